"""IDA through scikits-odes: dense with our Jacobian, or banded after reordering.

scikits-odes has no sparse direct solver. A maximum transversal puts non-zeros on the diagonal,
and the reverse Cuthill-McKee ordering (Cuthill and McKee 1969; George 1971) of the symmetrised
pattern makes the band narrow; SUNDIALS then finds the Jacobian by differences, one residual
evaluation per column of the band.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from acausal.solvers.explicit_form import ExplicitForm
from acausal.solvers.failures import IntegrationError
from acausal.solvers.odes import OdesIntegrator, odes_module
from acausal.solvers.system import NativeSystem, Pattern
from acausal.solvers.tolerances import ida_tolerances, suppressing

Array = NDArray[np.float64]
Positions = NDArray[np.int64]

#: Up to this size the matrix is dense.
DENSE_LIMIT = 100


def band_ordering(problem: Pattern) -> tuple[Positions, Positions, int, int]:
    """Return an ordering that makes the Jacobian's band narrow.

    Args:
        problem: The pattern, structurally regular.

    Returns:
        Unknowns in their new order, rows in their new order, shape ``(n,)`` each; lower and upper
        bandwidth of the reordered matrix.
    """
    from scipy.sparse import csc_array
    from scipy.sparse.csgraph import (
        maximum_bipartite_matching,
        reverse_cuthill_mckee,
    )

    n = problem.n
    ones = np.ones(problem.nnz, dtype=np.int8)
    pattern = csc_array((ones, problem.indices, problem.indptr), shape=(n, n)).tocsr()
    row_of = maximum_bipartite_matching(pattern, perm_type="row").astype(np.int64)
    if (row_of < 0).any():
        row_of = np.arange(n, dtype=np.int64)  # singular anyway; the solver will say so
    matched = pattern[row_of, :]  # row of unknown k is row k now
    symmetric = (matched + matched.T).tocsr()
    columns = reverse_cuthill_mckee(symmetric, symmetric_mode=True).astype(np.int64)
    place = np.empty(n, dtype=np.int64)
    place[columns] = np.arange(n)
    entries = matched.tocoo()
    distance = place[entries.row] - place[entries.col]
    lower = int(distance.max(initial=0))
    upper = int(-distance.min(initial=0))
    return columns, row_of[columns], lower, upper


class OdesIDAIntegrator(OdesIntegrator):
    """The integrator ``odes-ida``; see :class:`acausal.solvers.protocol.Integrator`."""

    def _use(self, system: NativeSystem) -> None:
        self._system = system
        self._module = odes_module("ida")
        problem = system.problem
        n = problem.n
        wanted = self._options.linear_solver
        self._dense = n <= DENSE_LIMIT if wanted == "auto" else wanted == "dense"
        if self._dense:
            self._unknowns = self._rows = np.arange(n, dtype=np.int64)
            self._lower = self._upper = 0
            self._columns = np.repeat(np.arange(n), np.diff(problem.indptr))
            self._values = np.zeros(problem.nnz)
        else:
            self._unknowns, self._rows, self._lower, self._upper = band_ordering(problem)
        options = self._options
        self._form = ExplicitForm(
            system,
            self._t,
            self.y,
            self.yp,
            options.relative_tolerance,
            options.absolute_tolerance,
            options.labels,
        )
        self._y_work = np.zeros(n)
        self._yp_work = np.zeros(n)
        self._out_work = np.zeros(n)
        self._x = np.zeros(n)
        self._xp = np.zeros(n)

    def _residual(self, tau: float, x: Array, xp: Array, out: Array) -> int:
        self._residuals += 1
        t = self._t_base + tau

        def work() -> Array:
            if self._dense:
                self._system.residual(t, x, xp, out)
                return out
            self._y_work[self._unknowns] = x
            self._yp_work[self._unknowns] = xp
            self._system.residual(t, self._y_work, self._yp_work, self._out_work)
            np.take(self._out_work, self._rows, out=out)
            return out

        return self._guard(work, t)

    def _jacobian(
        self, tau: float, x: Array, xp: Array, residual: Array, cj: float, matrix: Array
    ) -> int:
        self._jacobians += 1
        t = self._t_base + tau

        def work() -> Array:
            self._system.jacobian_values(t, cj, x, xp, self._values)
            matrix[:] = 0.0
            matrix[self._system.problem.indices, self._columns] = self._values
            return self._values

        return self._guard(work, t)

    def _begin(self, first_step: float) -> Any:
        problem = self._system.problem
        options = self._common_options(first_step)
        relative, absolute = ida_tolerances(self._options, problem)
        options["rtol"] = relative
        options["atol"] = self._atol = absolute[self._unknowns]  # kept: the solver points to it
        options["compute_initcond"] = None
        if suppressing(self._options, problem):
            options["algebraic_vars_idx"] = np.flatnonzero(~problem.differential[self._unknowns])
            options["exclude_algvar_from_error"] = True
        if self._dense:
            options.update(linsolver="dense", jacfn=self._jacobian)
        else:
            options.update(linsolver="band", lband=self._lower, uband=self._upper)
        solver = self._module.IDA(self._residual, **options)
        self._start_x = self.y[self._unknowns]
        self._start_xp = self.yp[self._unknowns]
        solver.init_step(0.0, self._start_x, self._start_xp)
        return solver

    def _begin_again(self) -> None:
        self._start_x = self.y[self._unknowns]
        self._start_xp = self.yp[self._unknowns]
        self._solver.reinit_IC(0.0, self._start_x, self._start_xp)

    def _call(self, tau: float) -> tuple[int, float]:
        result = self._solver.step(tau, self._x, self._xp)
        flag = int(result.flag)
        return flag, float(result.values.t if flag >= 0 else result.errors.t)

    def _read(self, t: float) -> tuple[Array, Array]:
        self._y_work[self._unknowns] = self._x
        self._yp_work[self._unknowns] = self._xp
        if t == self._t_step or self._system.problem.differential.all():
            return self._y_work, self._yp_work
        # Between the steps IDA interpolates, and nothing controls that error in the algebraic
        # unknowns: solve for them.
        self._form.guess(self._y_work, self._yp_work)
        try:
            return self._form.point(t, self._form.x(self._y_work))
        except IntegrationError:
            return self._y_work, self._yp_work
