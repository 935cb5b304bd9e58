"""Integration of a system with modes to nearly machine precision, for the reference numbers.

Nothing here knows `acausal`: modes are written out by hand, events are terminal events of SciPy's
``solve_ivp`` (DOP853), and what happens at an event is a function.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
RightSide = Callable[[float, Array], Array]

RELATIVE, ABSOLUTE = 1e-13, 1e-14


@dataclass(frozen=True)
class Guard:
    """An event that ends a mode.

    Attributes:
        function: Is zero at the event.
        direction: +1 rising, -1 falling.
        action: Time and values before -> name of the next mode, values after, what is reported.
    """

    function: Callable[[float, Array], float]
    direction: int
    action: Callable[[float, Array], tuple[str, Array, dict[str, Any]]]


@dataclass(frozen=True)
class Mode:
    """Equations between events and the events that end them."""

    right_side: RightSide
    guards: Sequence[Guard]


def integrate(
    modes: Mapping[str, Mode],
    first: str,
    values: Sequence[float],
    times: Sequence[float],
    max_step: float,
    most_events: int = 10_000,
) -> tuple[Array, list[dict[str, Any]]]:
    """Integrate through all events.

    Args:
        modes: All modes by name.
        first: The mode at ``times[0]``.
        values: Values there.
        times: Where values are wanted, ascending; none of them is the time of an event.
        max_step: Longest step; keeps the interpolation that locates events accurate.
        most_events: More than this many are a mistake.

    Returns:
        Values at ``times``, shape (times, values); and the events with time, before, after.
    """
    grid = np.asarray(times, float)
    out = np.full((len(grid), len(values)), np.nan)
    t, y, mode, events = float(grid[0]), np.array(values, float), first, []
    done = 0
    while True:
        guards = modes[mode].guards
        functions = [_terminal(g) for g in guards]
        # An event function that starts at zero has just acted; a tiny step leaves the zero.
        solution = solve_ivp(
            modes[mode].right_side, (t, grid[-1]), y, "DOP853", events=functions or None,
            dense_output=True, rtol=RELATIVE, atol=ABSOLUTE, max_step=max_step,
            first_step=min(1e-9, (grid[-1] - t) / 2) if t < grid[-1] else None,
        )  # fmt: skip
        if solution.status < 0:
            raise RuntimeError(solution.message)
        end = float(solution.t[-1])
        last = int(np.searchsorted(grid, end, "right"))
        if last > done:
            out[done:last] = solution.sol(grid[done:last]).T
            done = last
        if solution.status == 0:
            return out, events
        which = next(k for k, found in enumerate(solution.t_events) if len(found))
        t, before = float(solution.t_events[which][0]), solution.y_events[which][0]
        mode, y, told = guards[which].action(t, before)
        events.append({"time": t, "before": before.tolist(), "after": list(map(float, y)), **told})
        if len(events) > most_events:
            raise RuntimeError("too many events")


def _terminal(guard: Guard) -> Callable[[float, Array], float]:
    def function(t: float, y: Array) -> float:
        return float(guard.function(t, y))

    function.terminal = True  # type: ignore[attr-defined]
    function.direction = guard.direction  # type: ignore[attr-defined]
    return function


def impact(
    mass: Array, jacobian: Array, velocity: Array, restitution: float
) -> tuple[Array, float]:
    """Return velocities after an impact and the impulse, in minimal coordinates.

    The gap ``g(q)`` has the gradient ``G``; its rate is ``G v``. The impulse P >= 0 acts along G:
    ``M (v+ - v-) = G^T P`` and ``G v+ = -e G v-``, hence
    ``P = -(1 + e) G v- / (G M^-1 G^T)``.
    """
    direction = np.linalg.solve(mass, jacobian)
    impulse = -(1 + restitution) * float(jacobian @ velocity) / float(jacobian @ direction)
    return velocity + direction * impulse, impulse


def impact_with_constraints(
    mass: Array, constraint: Array, jacobian: Array, velocity: Array, restitution: float
) -> tuple[Array, Array, float]:
    """Return the same in redundant coordinates, with the impulses of the constraints.

    ``M (v+ - v-) = C^T L + G^T P``, ``C v+ = 0``, ``G v+ = -e G v-``: one linear system for v+, L
    and P. A second way to the numbers of `impact`.
    """
    n, m = len(velocity), len(constraint)
    matrix = np.zeros((n + m + 1, n + m + 1))
    matrix[:n, :n] = mass
    matrix[:n, n : n + m] = -constraint.T
    matrix[:n, -1] = -jacobian
    matrix[n : n + m, :n] = constraint
    matrix[-1, :n] = jacobian
    right = np.concatenate(
        [mass @ velocity, np.zeros(m), [-restitution * float(jacobian @ velocity)]]
    )
    solved = np.linalg.solve(matrix, right)
    return solved[:n], solved[n : n + m], float(solved[-1])
