"""The explicit form x' = f(t, x) of a system F(t, y, y') = 0 of index 1.

The states x are the unknowns that have a derivative in F. For given (t, x), the vector

    v_k = y'_k  where unknown k is a state,  y_k  where it is algebraic

is the solution of F = 0, found by a simplified Newton method that starts from the last solution
and keeps its matrix

    F_v = dF/dy' in the columns of states, dF/dy in the columns of algebraic unknowns

while it converges fast. F_v is regular exactly if the index is 1. With F_x = dF/dy in the columns
of states, the implicit function theorem gives dv/dx = -F_v^-1 F_x; the rows of the states
are df/dx.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from acausal.solvers.failures import Failure, Reason, integration_error, largest
from acausal.solvers.protocol import Labels
from acausal.solvers.system import NativeSystem

Array = NDArray[np.float64]

#: Up to this size linear algebra is dense.
DENSE_LIMIT = 150
MAX_ITERATIONS = 12
#: Newton stops when its correction is so small relative to the tolerance of the integration.
NEWTON_FRACTION = 1e-4
#: A correction that does not become smaller any more but is so small relative to the values.
ROUNDOFF = 1e-11


class ExplicitForm:
    """Solves for derivatives and algebraic unknowns; keeps the last solution as a guess.

    Attributes:
        states: Positions of the states among the unknowns, shape ``(m,)``.
        size: Length of ``x``; a system without states gets one dummy state, x' = 0.
        evaluations: Residual evaluations so far.
        factorisations: Factorisations of F_v so far.
    """

    def __init__(
        self,
        system: NativeSystem,
        t: float,
        y: Array,
        yp: Array,
        relative_tolerance: float,
        absolute_tolerance: float,
        labels: Labels,
    ) -> None:
        """Start from a consistent point; tolerances as in ``Options``."""
        self.system = system
        self.labels = labels
        problem = system.problem
        self.n = problem.n
        self.differential = np.asarray(problem.differential, dtype=bool)
        self.states = np.flatnonzero(self.differential)
        self.size = max(1, self.states.size)
        self.evaluations = 0
        self.factorisations = 0
        self._relative = relative_tolerance * NEWTON_FRACTION
        self._floor = absolute_tolerance * NEWTON_FRACTION * problem.nominal
        self._y = np.array(y, dtype=np.float64)
        self._yp = np.where(self.differential, yp, 0.0)
        self._residual = np.zeros(self.n)
        self._columns = np.repeat(np.arange(self.n), np.diff(problem.indptr))
        self._in_state_column = self.differential[self._columns]
        self._solve: Callable[[Array], Array] | None = None

    def x(self, y: Array) -> Array:
        """Return the states of a point, shape ``(size,)``."""
        return np.asarray(y[self.states], dtype=np.float64) if self.states.size else np.zeros(1)

    def absolute_tolerances(self, absolute_tolerance: float) -> Array:
        """Return the absolute tolerance of each state, shape ``(size,)``."""
        if not self.states.size:
            return np.ones(1)
        return np.asarray(absolute_tolerance * self.system.problem.nominal[self.states])

    def point(self, t: float, x: Array) -> tuple[Array, Array]:
        """Return (y, y') for a time and states; views that the next call changes.

        Derivatives of algebraic unknowns are 0.

        Raises:
            IntegrationError: R116 if Newton's method does not converge, R112 if the system
                cannot be solved for v, R114 if F is not finite.
        """
        if self.states.size:
            self._y[self.states] = x
        fresh = self._solve is None
        for _ in range(2):
            if fresh:
                self._factorise(t)
            guess_y, guess_yp = self._y.copy(), self._yp.copy()
            if self._newton(t):
                return self._y, self._yp
            self._y[:], self._yp[:] = guess_y, guess_yp
            if fresh:
                break
            fresh = True
        if self._newton_fresh(t):
            return self._y, self._yp
        self._y[:], self._yp[:] = guess_y, guess_yp
        self._solve = None
        self.system.residual(t, self._y, self._yp, self._residual)
        rows = largest(self._residual)
        reason = Reason.EXPLICIT_FORM if np.isfinite(self._residual).all() else Reason.NOT_FINITE
        raise integration_error(Failure(reason, t, 0.0, (), rows), self.labels)

    def guess(self, y: Array, yp: Array) -> None:
        """Start the next solution from another point than the last one."""
        self._y[:] = y
        self._yp[:] = np.where(self.differential, yp, 0.0)

    def derivative(self, t: float, x: Array) -> Array:
        """Return f(t, x), shape ``(size,)``; raises as :meth:`point`."""
        _, yp = self.point(t, x)
        return yp[self.states].copy() if self.states.size else np.zeros(1)

    def jacobian(self, t: float, x: Array) -> Array:
        """Return df/dx, dense, shape ``(size, size)``; raises as :meth:`point`."""
        if not self.states.size:
            return np.zeros((1, 1))
        self.point(t, x)
        self._factorise(t)
        solve = self._solve
        assert solve is not None
        right = np.zeros((self.n, self.n))
        values, _ = self._partials(t)
        chosen = self._in_state_column
        rows, columns = self.system.problem.indices[chosen], self._columns[chosen]
        np.add.at(right, (rows, columns), values[chosen])
        return np.asarray(-solve(right[:, self.states])[self.states])

    # --- Newton's method

    def _newton(self, t: float) -> bool:
        """Iterate with the matrix as it is; tell whether it converged."""
        assert self._solve is not None
        last = np.inf
        for _ in range(MAX_ITERATIONS):
            correction = self._correction(t)
            if correction is None:
                return False
            norm, relative = self._apply(correction)
            if norm <= 1.0 or (relative <= ROUNDOFF and norm > 0.5 * last):
                return True
            if norm > 0.9 * last:
                return False
            last = norm
        return False

    def _newton_fresh(self, t: float) -> bool:
        """Iterate with a new matrix each time and damped steps; tell whether it converged."""
        for _ in range(4 * MAX_ITERATIONS):
            self._factorise(t)
            correction = self._correction(t)
            if correction is None:
                return False
            before = float(np.abs(self._residual).max(initial=0.0))
            y, yp = self._y.copy(), self._yp.copy()
            factor = 1.0
            while True:
                norm, relative = self._apply(factor * correction)
                if norm <= factor or relative <= ROUNDOFF:
                    return True
                self._evaluate(t)
                after = float(np.abs(self._residual).max(initial=0.0))
                if after <= before * (1.0 - 0.1 * factor):
                    break
                factor *= 0.5
                self._y[:], self._yp[:] = y, yp
                if factor < 1e-4:
                    return False
        return False

    def _evaluate(self, t: float) -> None:
        self.system.residual(t, self._y, self._yp, self._residual)
        self.evaluations += 1

    def _correction(self, t: float) -> Array | None:
        """Return -F_v^-1 F, None if it is not finite."""
        assert self._solve is not None
        self._evaluate(t)
        if not np.isfinite(self._residual).all():
            return None
        correction = -self._solve(self._residual)
        return correction if np.isfinite(correction).all() else None

    def _apply(self, correction: Array) -> tuple[float, float]:
        """Add a correction to v; return its size relative to the tolerance and to the values."""
        mask = self.differential
        self._yp += np.where(mask, correction, 0.0)
        self._y += np.where(mask, 0.0, correction)
        size = np.abs(np.where(mask, self._yp, self._y))
        if correction.size == 0:
            return 0.0, 0.0
        # A derivative has no nominal value of its own: relative to the largest one at least.
        floor = np.where(mask, self._floor * max(1.0, float(size.max())), self._floor)
        norm = float((np.abs(correction) / (self._relative * size + floor)).max())
        relative = float(np.abs(correction).max() / max(float(size.max()), 1e-300))
        return norm, relative

    def _partials(self, t: float) -> tuple[Array, Array]:
        """Return the entries of dF/dy and of dF/dy' at the present point."""
        work = np.zeros(self.system.problem.nnz)
        self.system.jacobian_values(t, 0.0, self._y, self._yp, work)
        return self.system.partial_values()

    def _factorise(self, t: float) -> None:
        """Factorise F_v at the present point.

        Raises:
            IntegrationError: R112 if it is singular, R114 if it is not finite.
        """
        self.factorisations += 1
        by_y, by_yp = self._partials(t)
        values = np.where(self._in_state_column, by_yp, by_y)
        if not np.isfinite(values).all():
            rows = self.system.problem.indices[~np.isfinite(values)]
            failure = Failure(Reason.NOT_FINITE, t, 0.0, (), tuple(int(r) for r in rows[:4]))
            raise integration_error(failure, self.labels)
        if self.n == 0:
            self._solve = np.copy
        elif self.n <= DENSE_LIMIT:
            self._solve = self._dense(t, values)
        else:
            self._solve = self._sparse(t, values)

    def _dense(self, t: float, values: Array) -> Callable[[Array], Array]:
        from scipy.linalg import lu_factor, lu_solve

        matrix = np.zeros((self.n, self.n))
        np.add.at(matrix, (self.system.problem.indices, self._columns), values)
        row = np.abs(matrix).max(axis=1)
        scaled = matrix / np.where(row > 0.0, row, 1.0)[:, np.newaxis]
        column = np.abs(scaled).max(axis=0)
        scaled /= np.where(column > 0.0, column, 1.0)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            factors = lu_factor(scaled, check_finite=False)
        pivots = np.abs(np.diag(factors[0]))
        if not pivots.min() > 1e-13 * pivots.max():
            self._singular(t, scaled)

        def solve(right: Array) -> Array:
            divided = (right.T / row).T
            solution = lu_solve(factors, divided, check_finite=False)
            return np.asarray((solution.T / column).T)

        return solve

    def _sparse(self, t: float, values: Array) -> Callable[[Array], Array]:
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        problem = self.system.problem
        matrix = csc_array((values, problem.indices, problem.indptr), shape=(self.n, self.n))
        try:
            factors: Any = splu(matrix)
        except RuntimeError:
            self._singular(t, None)
        return lambda right: np.asarray(factors.solve(np.ascontiguousarray(right)))

    def _singular(self, t: float, scaled: Array | None) -> NoReturn:
        unknowns: tuple[int, ...] = ()
        rows: tuple[int, ...] = ()
        if scaled is not None:
            left, _, right = np.linalg.svd(scaled)
            unknowns, rows = largest(right[-1]), largest(left[:, -1])
        self._solve = None
        failure = Failure(Reason.SINGULAR, t, 0.0, unknowns, rows)
        raise integration_error(failure, self.labels)
