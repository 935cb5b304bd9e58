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

import math
from collections.abc import Callable
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import fail
from acausal.solvers.failures import Failure, Reason, integration_error, largest
from acausal.solvers.protocol import Labels
from acausal.solvers.system import NativeSystem

Array = NDArray[np.float64]

#: Up to this size linear algebra is dense.
DENSE_LIMIT = 150
MAX_ITERATIONS = 12
#: Newton stops when its correction is so small relative to the tolerance of the integration.
NEWTON_FRACTION = 1e-4
#: Most entries of a dense matrix with one column for each state.
LARGEST_MATRIX = 50_000_000
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
        self._algebraic = ~self.differential
        self._floor = absolute_tolerance * NEWTON_FRACTION * problem.nominal
        self._floor_derivative = np.where(self.differential, self._floor, 0.0)
        self._y = np.array(y, dtype=np.float64)
        self._yp = np.where(self.differential, yp, 0.0)
        self._v = np.where(self.differential, self._yp, self._y)
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
        guess = self._v.copy()
        if self._solve is not None and self._newton(t):
            return self._y, self._yp
        self._set(guess)
        self._factorise(t)
        if self._newton(t):
            return self._y, self._yp
        self._set(guess)
        if self._newton_damped(t):
            return self._y, self._yp
        self._set(guess)
        self._solve = None
        self.system.residual(t, self._y, self._yp, self._residual)
        rows = largest(self._residual)
        reason = Reason.EXPLICIT_FORM if np.isfinite(self._residual).all() else Reason.NOT_FINITE
        raise integration_error(Failure(reason, t, 0.0, (), rows), self.labels)

    def guess(self, y: Array, yp: Array) -> None:
        """Start the next solution from another point than the last one."""
        self._y[:] = y
        self._set(np.where(self.differential, yp, y))

    def derivative(self, t: float, x: Array) -> Array:
        """Return f(t, x), shape ``(size,)``; raises as :meth:`point`."""
        _, yp = self.point(t, x)
        return yp[self.states].copy() if self.states.size else np.zeros(1)

    def jacobian(self, t: float, x: Array) -> Array:
        """Return df/dx, dense, shape ``(size, size)``.

        Raises:
            AcausalError: R117 if it is too large; else as :meth:`point`.
        """
        if self.n * self.size > LARGEST_MATRIX:
            fail(
                "R117",
                f"{self.n} equations with {self.size} states are too many for an explicit form",
                help="choose the solver ida, which uses sparse matrices",
            )
        if not self.states.size:
            return np.zeros((1, 1))
        self.point(t, x)
        self._factorise(t)
        solve = self._solve
        assert solve is not None
        right = np.zeros((self.n, self.size))
        values, _ = self._partials(t)
        chosen = self._in_state_column
        place = np.cumsum(self.differential) - 1
        rows, columns = self.system.problem.indices[chosen], place[self._columns[chosen]]
        right[rows, columns] = values[chosen]
        return np.asarray(-solve(right)[self.states])

    # --- Newton's method

    def _set(self, v: Array) -> None:
        """Put v into y and y'."""
        self._v = v.copy()
        np.copyto(self._yp, v, where=self.differential)
        np.copyto(self._y, v, where=self._algebraic)

    def _newton(self, t: float) -> bool:
        """Iterate with the matrix as it is; tell whether it converged."""
        last = math.inf
        for _ in range(MAX_ITERATIONS):
            correction = self._correction(t)
            if correction is None:
                return False
            self._set(self._v - correction)
            norm, relative = self._measure(correction)
            rate = norm / last
            # The error that is left is about rate / (1 - rate) times the last correction.
            if norm <= 1.0 or (math.isfinite(last) and rate < 0.5 and norm * rate <= 0.5):
                return True
            if relative <= ROUNDOFF and rate > 0.5:
                return True
            if not rate <= 0.9:
                return False
            last = norm
        return False

    def _newton_damped(self, t: float) -> bool:
        """Iterate with a new matrix each time and damped steps; tell whether it converged."""
        for _ in range(4 * MAX_ITERATIONS):
            self._factorise(t)
            correction = self._correction(t)
            if correction is None:
                return False
            before = float(np.abs(self._residual).max(initial=0.0))
            start = self._v
            factor = 1.0
            while True:
                self._set(start - factor * correction)
                norm, relative = self._measure(correction)
                if norm <= 1.0 or relative <= ROUNDOFF:
                    return True
                self._evaluate(t)
                after = float(np.abs(self._residual).max(initial=0.0))
                if after <= before * (1.0 - 0.1 * factor):
                    break
                factor *= 0.5
                if factor < 1e-4:
                    return False
        return False

    def _evaluate(self, t: float) -> None:
        self.system.residual(t, self._y, self._yp, self._residual)
        self.evaluations += 1

    def _correction(self, t: float) -> Array | None:
        """Return F_v^-1 F, None if it is not finite."""
        assert self._solve is not None
        self._evaluate(t)
        if not np.isfinite(self._residual).all():
            return None
        correction = self._solve(self._residual)
        return correction if np.isfinite(correction).all() else None

    def _measure(self, correction: Array) -> tuple[float, float]:
        """Return the size of a correction relative to the tolerance and to the values."""
        if correction.size == 0:
            return 0.0, 0.0
        size, change = np.abs(self._v), np.abs(correction)
        most = float(size.max())
        # A derivative has no nominal value of its own: relative to the largest one at least.
        scale = self._relative * size
        scale += self._floor
        if most > 1.0:
            scale += (most - 1.0) * self._floor_derivative
        return float((change / scale).max()), float(change.max()) / max(most, 1e-300)

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
        from scipy.linalg.lapack import dgetrf, dgetrs

        matrix = np.zeros((self.n, self.n), order="F")
        matrix[self.system.problem.indices, self._columns] = values
        row = np.abs(matrix).max(axis=1)
        row[row == 0.0] = 1.0
        matrix /= row[:, np.newaxis]
        column = np.abs(matrix).max(axis=0)
        column[column == 0.0] = 1.0
        matrix /= column
        factors, pivots, _ = dgetrf(matrix)
        diagonal = np.abs(np.diag(factors))
        if not diagonal.min() > 1e-13 * diagonal.max():
            self._singular(t, matrix)

        def solve(right: Array) -> Array:
            solution, _ = dgetrs(factors, pivots, (right.T / row).T)
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
