"""Damped Newton method, invariant to the scaling of equations.

The natural monotonicity test and the damping strategy of P. Deuflhard, "Newton Methods for
Nonlinear Problems", Springer 2004, section 3.3 (NLEQ): a trial point is good if the simplified
Newton correction there is shorter than the Newton step here. Steps are measured relative to the
magnitude of the unknowns, never by residuals, so it makes no difference whether an equation is
written in amperes or in megaamperes.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from acausal.initialization.linear import Factorised, factorise

Array = NDArray[np.float64]

#: Relative length of the last Newton step.
TOLERANCE = 1e-10
#: Shortest damping factor before giving up.
LEAST_DAMPING = 1e-7
MAX_ITERATIONS = 60


class Equations(Protocol):
    """What Newton's method needs to know; :class:`AlgebraicProblem` is one."""

    @property
    def indptr(self) -> NDArray[np.int64]:
        """Column pointers of the Jacobian."""

    @property
    def indices(self) -> NDArray[np.int32]:
        """Row indices of the Jacobian."""

    @property
    def scale(self) -> Array:
        """Magnitudes of the unknowns."""

    @property
    def minimum(self) -> Array:
        """Lower bounds of the unknowns."""

    @property
    def maximum(self) -> Array:
        """Upper bounds of the unknowns."""

    def residual(self, x: Array) -> Array:
        """Return ``F(x)``."""

    def jacobian(self, x: Array) -> Array:
        """Return the values of the Jacobian."""


class Outcome(Enum):
    """How Newton's method ended."""

    CONVERGED = "converged"
    SINGULAR = "the Jacobian is singular"
    STUCK = "no step brings it nearer"
    SLOW = "too many iterations"
    NOT_FINITE = "the residual is not finite at the start"
    NOT_FINITE_JACOBIAN = "the Jacobian is not finite at the start"


@dataclass(frozen=True)
class NewtonResult:
    """The outcome.

    Attributes:
        outcome: Why it ended.
        x: The last point, shape ``(n,)``.
        iterations: Newton steps taken.
        error: Residuals relative to the size of their terms at the last point.
        regular: The last Jacobian was regular; without that a solution may be one of many.
    """

    outcome: Outcome
    x: Array
    iterations: int
    error: Array
    regular: bool

    @property
    def converged(self) -> bool:
        """Whether a solution was found."""
        return self.outcome is Outcome.CONVERGED


@np.errstate(all="ignore")
def solve(equations: Equations, x: Array, max_iterations: int = MAX_ITERATIONS) -> NewtonResult:
    """Solve ``F(x) = 0`` from ``x``.

    Args:
        equations: A square system.
        x: Start of the iteration, shape ``(n,)``; not changed.
        max_iterations: Limit of Newton steps.
    """
    x = x.copy()
    if x.shape[0] == 0:
        return NewtonResult(Outcome.CONVERGED, x, 0, x, True)
    f = equations.residual(x)
    damping, previous = 1.0, 0.0
    nothing = np.abs(f)
    if not np.isfinite(f).all():
        return NewtonResult(Outcome.NOT_FINITE, x, 0, nothing, False)
    regular = True
    for iteration in range(max_iterations):
        scale = np.maximum(equations.scale, np.abs(x))
        data = equations.jacobian(x)
        if not np.isfinite(data).all():
            outcome = Outcome.NOT_FINITE_JACOBIAN if iteration == 0 else Outcome.STUCK
            return NewtonResult(outcome, x, iteration, np.abs(f), False)
        factors = factorise(equations.indptr, equations.indices, data, scale)
        regular = factors.regular
        step = -factors.solve(f)
        length = _norm(step / scale)
        error = np.abs(f) / factors.row_scale
        if length <= TOLERANCE and (regular or error.max(initial=0.0) <= 1e-8):
            # The step is taken: it costs nothing and squares the error.
            trial = x + step
            g = equations.residual(trial)
            if np.isfinite(g).all():
                x, error = trial, np.abs(g) / factors.row_scale
            return NewtonResult(Outcome.CONVERGED, x, iteration + 1, error, regular)
        if not regular and length <= TOLERANCE:
            return NewtonResult(Outcome.SINGULAR, x, iteration, error, False)
        damping = _first_damping(damping, previous, length, iteration)
        damping = _within_bounds(equations, x, step, damping)
        advanced = _search(equations, x, f, step, length, scale, factors, damping)
        if advanced is None:
            outcome = Outcome.STUCK if regular else Outcome.SINGULAR
            return NewtonResult(outcome, x, iteration, error, regular)
        x, f, damping, previous, correction = advanced
        if regular and damping == 1.0 and _norm(correction / scale) <= TOLERANCE:
            error = np.abs(f) / factors.row_scale
            return NewtonResult(Outcome.CONVERGED, x + correction, iteration + 1, error, True)
    scale = np.maximum(equations.scale, np.abs(x))
    return NewtonResult(Outcome.SLOW, x, max_iterations, np.abs(f), regular)


def _norm(x: Array) -> float:
    return float(np.sqrt(np.mean(x * x))) if x.shape[0] else 0.0


def _first_damping(damping: float, previous: float, length: float, iteration: int) -> float:
    """Predict the damping from that of the last step (``previous``: estimate of 1/curvature)."""
    if iteration == 0 or length == 0.0:
        return 1.0
    return float(np.clip(previous / length, 1e-3, 1.0))


def _within_bounds(equations: Equations, x: Array, step: Array, damping: float) -> float:
    """Shorten a step that leaves the bounds; they are hints, so never to nothing."""
    full = x + damping * step
    low, high = equations.minimum, equations.maximum
    out = ((full < low) & (x > low)) | ((full > high) & (x < high))
    if not out.any():
        return damping
    room = np.where(step[out] < 0.0, low[out] - x[out], high[out] - x[out])
    allowed = 0.9 * float((room / step[out]).min())
    return max(min(damping, allowed), 1e-3 * damping)


def _search(
    equations: Equations,
    x: Array,
    f: Array,
    step: Array,
    length: float,
    scale: Array,
    factors: Factorised,
    damping: float,
) -> tuple[Array, Array, float, float, Array] | None:
    """Search along a Newton step.

    Returns:
        The next point, its residual, the damping used, the reach of the linear model, and the
        simplified Newton correction there; None if no damping helps.
    """
    while damping >= LEAST_DAMPING:
        trial = x + damping * step
        g = equations.residual(trial)
        if not np.isfinite(g).all():
            damping *= 0.3
            continue
        if np.array_equal(trial, x):
            return None
        correction = -factors.solve(g)
        shorter = _norm(correction / scale)
        bend = _norm((correction - (1.0 - damping) * step) / scale)
        reach = 0.5 * length * damping * damping / bend * length if bend > 0.0 else np.inf
        if shorter <= (1.0 - damping / 4.0) * length or shorter <= TOLERANCE:
            return trial, g, damping, float(reach), correction
        best = reach / length if np.isfinite(reach) else 0.0
        damping = float(np.clip(best, 0.1 * damping, 0.5 * damping))
    return None
