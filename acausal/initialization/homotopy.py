"""Continuation: from an easier problem to the one to be solved.

Two of them. The *model's* homotopy follows the operator ``homotopy(actual, simplified)``
(M. Sielemann et al., "Robust initialization of differential-algebraic equations using homotopy",
Modelica conference 2011). *Newton's* homotopy ``F(x) = (1 - lambda) F(x0)`` needs no help from the
model: it is solved by ``x0`` at ``lambda = 0``, and lets the sources of the residual grow step by
step (Allgower and Georg, "Introduction to Numerical Continuation Methods", SIAM 2003).

The step in ``lambda`` adapts: it doubles after an easy step and halves after a failed one; the
predictor is the secant through the last two points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.initialization.newton import Equations, NewtonResult, Outcome, solve

Array = NDArray[np.float64]

FIRST_STEP = 0.1
LEAST_STEP = 1e-6
#: Newton steps allowed to return to the path.
CORRECTOR = 12
#: Corrector steps after which a step in lambda counts as easy.
EASY = 4
MAX_STEPS = 400
MAX_ITERATIONS = 2000


@dataclass(frozen=True)
class Path:
    """The end of a continuation.

    Attributes:
        result: Newton's result at ``reached``.
        reached: The last ``lambda`` with a solution; 1 if it came through.
        steps: Steps taken.
        iterations: Newton steps taken in all of them.
    """

    result: NewtonResult
    reached: float
    steps: int
    iterations: int

    @property
    def arrived(self) -> bool:
        """Whether the actual equations are solved."""
        return self.reached == 1.0 and self.result.converged


@dataclass
class _Shifted:
    """``F(x) - shift``, with the Jacobian of ``F``."""

    equations: Equations
    shift: Array

    @property
    def indptr(self) -> NDArray[np.int64]:
        return self.equations.indptr

    @property
    def indices(self) -> NDArray[np.int32]:
        return self.equations.indices

    @property
    def scale(self) -> Array:
        return self.equations.scale

    @property
    def minimum(self) -> Array:
        return self.equations.minimum

    @property
    def maximum(self) -> Array:
        return self.equations.maximum

    def residual(self, x: Array) -> Array:
        return self.equations.residual(x) - self.shift

    def jacobian(self, x: Array) -> Array:
        return self.equations.jacobian(x)


def newton_homotopy(equations: Equations, x0: Array, budget: int = MAX_ITERATIONS) -> Path:
    """Follow ``F(x) = (1 - lambda) F(x0)`` from ``x0``, with at most ``budget`` Newton steps."""
    f0 = equations.residual(x0)
    if not np.isfinite(f0).all():
        result = NewtonResult(Outcome.NOT_FINITE, x0, 0, np.abs(f0), False)
        return Path(result, 0.0, 0, 0)
    shifted = _Shifted(equations, f0)

    def at(value: float) -> Equations:
        shifted.shift = (1.0 - value) * f0
        return shifted

    return follow(at, x0, budget)


def model_homotopy(equations: Equations, x0: Array, set_lambda: Callable[[float], None]) -> Path:
    """Follow the operator ``homotopy`` from the simplified to the actual equations.

    Args:
        equations: Equations whose homotopy operators move with lambda.
        x0: Start of the iteration.
        set_lambda: Sets lambda in the equations' work vector.
    """

    def at(value: float) -> Equations:
        set_lambda(value)
        return equations

    return follow(at, x0)


def follow(at: Callable[[float], Equations], x0: Array, budget: int = MAX_ITERATIONS) -> Path:
    """Follow the solutions of ``at(lambda)`` from 0 to 1.

    Args:
        at: The equations for a value of lambda.
        x0: Start of the iteration at ``lambda = 0``.
        budget: Newton steps allowed in all.
    """
    result = solve(at(0.0), x0)
    iterations = result.iterations
    if not result.converged:
        at(1.0)
        return Path(result, 0.0, 0, iterations)
    reached, x, step = 0.0, result.x, FIRST_STEP
    before: tuple[float, Array] | None = None
    for count in range(1, MAX_STEPS + 1):
        value = min(1.0, reached + step)
        guess = x
        if before is not None:
            guess = x + (x - before[1]) * ((value - reached) / (reached - before[0]))
        result = solve(at(value), guess, CORRECTOR)
        iterations += result.iterations
        if not result.converged and before is not None:
            result = solve(at(value), x, CORRECTOR)
            iterations += result.iterations
        if result.converged:
            before = (reached, x)
            reached, x = value, result.x
            if reached == 1.0:
                return Path(result, 1.0, count, iterations)
            if result.iterations <= EASY:
                step *= 2.0
        else:
            step = 0.25 * (value - reached)
            if step < LEAST_STEP:
                break
        if iterations > budget:
            break
    at(1.0)
    return Path(result, reached, count, iterations)
