"""One system of equations solved by all means, cheapest first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.initialization.homotopy import newton_homotopy
from acausal.initialization.newton import Equations, NewtonResult, Outcome, solve

Array = NDArray[np.float64]

#: Shifts of the guesses, in magnitudes of the unknowns, when the guess itself leads nowhere.
SHIFTS = (1e-3, 0.1, 1.0, -1.0, 10.0)
RANDOM_STARTS = 4


@dataclass(frozen=True)
class Attempt:
    """A result and the method that led to it."""

    result: NewtonResult
    method: str


def guesses(x0: Array, scale: Array, movable: NDArray[np.bool_]) -> Iterator[Array]:
    """Return other starting points, always the same ones.

    Args:
        x0: The guess.
        scale: Magnitudes.
        movable: Guesses that were not written by the user; if there are none, all move.
    """
    free = movable if movable.any() else np.ones_like(movable)
    size = np.where(free, np.maximum(scale, np.abs(x0)), 0.0)
    # Unequal shifts: equal ones would keep differences of two guesses zero.
    unequal = 1.0 + 0.1 * np.cos(np.arange(x0.shape[0]))
    for shift in SHIFTS:
        yield x0 + shift * size * unequal
    random = np.random.default_rng(1)
    for _ in range(RANDOM_STARTS):
        yield x0 + size * random.normal(size=x0.shape[0])


def solve_robustly(equations: Equations, x0: Array, movable: NDArray[np.bool_]) -> Attempt:
    """Solve a square system: Newton, Newton's homotopy, then both from other guesses.

    Args:
        equations: The system.
        x0: The guess, shape ``(n,)``.
        movable: Guesses that are mere defaults.

    Returns:
        The first success; otherwise the first attempt, whose outcome tells most.
    """
    budget = effort(x0.shape[0])
    first = solve(equations, x0)
    if first.converged and first.regular:
        return Attempt(first, "Newton")
    irregular = first if first.converged else None
    spent = first.iterations
    if first.outcome not in (Outcome.NOT_FINITE, Outcome.NOT_FINITE_JACOBIAN) and not irregular:
        path = newton_homotopy(equations, x0, budget // 2)
        spent += path.iterations
        if path.arrived and path.result.regular:
            return Attempt(path.result, "Newton homotopy")
    for guess in guesses(x0, equations.scale, movable):
        if spent > budget:
            break
        result = solve(equations, guess)
        spent += result.iterations
        if not result.converged and result.outcome is not Outcome.NOT_FINITE and not irregular:
            path = newton_homotopy(equations, guess, (budget - spent) // 2)
            spent += path.iterations
            result = path.result if path.arrived else result
        if result.converged and (result.regular or not irregular):
            if irregular and _norm(result.x - x0) > 2.0 * _norm(irregular.x - x0) + 1e-6:
                continue
            return Attempt(result, "another guess")
    return Attempt(irregular or first, "Newton")


def effort(n: int) -> int:
    """Return how many Newton steps may be spent on ``n`` unknowns: seconds, not minutes."""
    return max(100, min(4000, 1_000_000 // max(n, 1)))


def _norm(x: Array) -> float:
    return float(np.sqrt(x @ x))
