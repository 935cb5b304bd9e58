"""Numbers taken from one variable over time: extremes, means, crossings, period, settling.

Between two stored points a variable is a straight line here, so that means are the integrals of
what a plot shows, whatever the distances of the points. An event is two equal times.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import fail

if TYPE_CHECKING:
    from acausal.results.trajectory import Trajectory

Array = NDArray[np.float64]

#: Parts that a step between two points is cut into where its polynomial is looked at.
FINER = 16


class Extreme(float):
    """The largest or smallest value of a variable: a number that knows when it is reached.

    Attributes:
        time: When, seconds; the first time if there are several.

    Example:
        >>> peak = result["c.v"].max()
        >>> print(f"{peak:.2f} V at {peak.time:.3f} s")
    """

    time: float

    def __new__(cls, value: float, time: float = float("nan")) -> Extreme:
        """Make a number with a time."""
        made = super().__new__(cls, value)
        made.time = time
        return made

    def __getnewargs__(self) -> tuple[float, float]:  # type: ignore[override]
        return float(self), self.time


@dataclass(frozen=True, slots=True)
class Jump:
    """An event as one variable sees it.

    Attributes:
        time: When, seconds.
        before: Value just before.
        after: Value just after.
    """

    time: float
    before: float
    after: float


def extreme(x: Trajectory, sign: float) -> Extreme:
    """Return the largest (``sign`` 1) or smallest (-1) value, NaN left out.

    Where the solver's polynomial is at hand it is looked at around the best stored point.

    Raises:
        AcausalError: ``F211`` if there are no values.
    """
    _need_values(x)
    values = sign * x.values
    if np.isnan(values).all():
        return Extreme(float("nan"))
    best = int(np.nanargmax(values))
    value, time = float(x.values[best]), float(x.time[best])
    if x.curve is None:
        return Extreme(value, time)
    low, high = x.time[max(best - 1, 0)], x.time[min(best + 1, len(x.time) - 1)]
    for _ in range(4):  # each look is FINER times finer; a parabola's top needs no more
        near = np.linspace(low, high, 2 * FINER + 1)
        found = x.curve(near, False)
        k = int(np.nanargmax(sign * found)) if not np.isnan(found).all() else 0
        if sign * found[k] > sign * value:
            value, time = float(found[k]), float(near[k])
        low, high = near[max(k - 1, 0)], near[min(k + 1, len(near) - 1)]
    return Extreme(value, time)


def mean(x: Trajectory) -> float:
    """Return the mean over time, the integral divided by the duration."""
    _need_values(x)
    duration = float(x.time[-1] - x.time[0])
    if duration <= 0:
        return float(x.values[-1])
    return float(np.trapezoid(x.values, x.time)) / duration


def mean_square(x: Trajectory) -> float:
    """Return the mean of the square over time, exact for straight lines between the points."""
    _need_values(x)
    duration = float(x.time[-1] - x.time[0])
    if duration <= 0:
        return float(x.values[-1]) ** 2
    a, b = x.values[:-1], x.values[1:]
    return float(np.sum((a * a + a * b + b * b) * np.diff(x.time))) / 3.0 / duration


def integral(x: Trajectory) -> Array:
    """Return the integral from the first time on, shape ``(nt,)``."""
    parts = 0.5 * (x.values[1:] + x.values[:-1]) * np.diff(x.time)
    return np.concatenate([np.zeros(min(1, len(x.values))), np.cumsum(parts)])


def crossings(x: Trajectory, level: float, direction: int) -> Array:
    """Return the times at which a level is crossed, ascending.

    Args:
        x: The variable.
        level: In the variable's unit.
        direction: 1 for upwards, -1 for downwards, 0 for both.

    A point that lies on the level counts as above it. With the solver's polynomial at hand the
    time is found in it.
    """
    above = x.values >= level
    change = above[1:].astype(np.int8) - above[:-1].astype(np.int8)
    known = np.isfinite(x.values[1:]) & np.isfinite(x.values[:-1])
    wanted = (change == direction) if direction else (change != 0)
    at = np.flatnonzero(wanted & known & (change != 0))
    low, high = x.time[at].copy(), x.time[at + 1].copy()
    a, b = x.values[at] - level, x.values[at + 1] - level
    if x.curve is None or not len(at):
        return np.asarray(low + (high - low) * a / (a - b))
    began = above[at]
    for _ in range(60):
        middle = 0.5 * (low + high)
        same = (x.curve(middle, False) >= level) == began
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return high


def period(x: Trajectory, level: float | None) -> float:
    """Return the mean time between upward crossings, NaN if there are not two of them.

    Args:
        x: The variable.
        level: What has to be crossed; the mean over time if None.
    """
    times = crossings(x, mean(x) if level is None else level, 1)
    return float(times[-1] - times[0]) / (len(times) - 1) if len(times) > 1 else float("nan")


def settle_time(x: Trajectory, band: float, final: float | None) -> float:
    """Return how long it takes from the first time until the variable stays near its end.

    Args:
        x: The variable.
        band: Largest distance from the end, as a share of the largest distance there was.
        final: Where it ends; the last value if None.

    Returns:
        Seconds; NaN if it does not stay there.
    """
    _need_values(x)
    target = float(x.values[-1]) if final is None else final
    distance = np.abs(x.values - target)
    width = band * float(np.nanmax(distance))
    outside = np.flatnonzero(~(distance <= width))
    if not len(outside):
        return 0.0
    last = int(outside[-1])
    if last + 1 == len(x.values):
        return float("nan")
    a, b = distance[last], distance[last + 1]
    step = x.time[last + 1] - x.time[last]
    part = (a - width) / (a - b) if a > b and np.isfinite(a) else 1.0
    return float(x.time[last] + part * step - x.time[0])


def jumps(x: Trajectory) -> list[Jump]:
    """Return where the variable has two values at one time, and which."""
    twice = np.flatnonzero((np.diff(x.time) == 0) & (x.values[1:] != x.values[:-1]))
    return [
        Jump(float(x.time[k]), float(x.values[k]), float(x.values[k + 1])) for k in twice.tolist()
    ]


def _need_values(x: Trajectory) -> None:
    if not len(x.values):
        fail("F211", f"{x.path} has no values", help="simulate for a longer time")
