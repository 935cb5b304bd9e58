"""The tube test of trajectory against reference, as used for the Modelica Standard Library.

Around every sample of the reference lies a rectangle, half as wide as the tolerance times the time
range and half as high as the tolerance times the range of the values. Between samples the rectangle
slides along the straight line. The union is the tube; every sample of the tested trajectory must
lie in it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Tube:
    """Bounds over time.

    Attributes:
        lower, upper: Bounds at the tested times, shape ``(n,)``.
        half_height: Half the height of a rectangle, in the unit of the signal.
    """

    lower: Array
    upper: Array
    half_height: float

    def worst(self, values: Array) -> float:
        """Return the largest distance outside of the tube, in half heights; 0 if inside."""
        outside = np.maximum(self.lower - values, values - self.upper)
        return float(max(0.0, np.max(outside)) / self.half_height)


def tube(reference_times: Array, reference: Array, times: Array, tolerance: float = 2e-3) -> Tube:
    """Return the tube around a reference, evaluated at ``times``.

    Args:
        reference_times: Times of the reference, not decreasing (a jump has two equal times).
        reference: Its values, same shape.
        times: Times at which bounds are wanted.
        tolerance: Half width against the time range and half height against the value range.
    """
    width = tolerance * (reference_times[-1] - reference_times[0])
    height = tolerance * max(float(np.ptp(reference)), abs(float(reference.min())), 1e-3)
    low_level, high_level = _sliding_extremes(reference)
    first = np.searchsorted(reference_times, times - width, "left")
    last = np.searchsorted(reference_times, times + width, "right")
    left = np.interp(times - width, reference_times, reference)
    right = np.interp(times + width, reference_times, reference)
    lower, upper = np.minimum(left, right), np.maximum(left, right)
    count = last - first
    for level, (low, high) in enumerate(zip(low_level, high_level, strict=True)):
        step = 1 << level
        at = np.flatnonzero((count >= step) & (count < 2 * step))
        for start in (first[at], last[at] - step):
            lower[at] = np.minimum(lower[at], low[start])
            upper[at] = np.maximum(upper[at], high[start])
    return Tube(lower - height, upper + height, height)


def share(
    reference_times: Array, reference: Array, times: Array, values: Array, tolerance: float = 2e-3
) -> float:
    """Return the share of the tube that a trajectory uses.

    It is the factor, to two places, by which width and height of the tube can be multiplied so that
    the trajectory just stays inside: 0 on the reference, 1 at the border, more outside.
    """

    def inside(factor: float) -> bool:
        bounds = tube(reference_times, reference, times, factor * tolerance)
        return bounds.worst(values) == 0.0

    low, high = 0.0, 1.0
    while not inside(high):
        if high > 1e3:
            return float("inf")
        low, high = high, 2 * high
    while high - low > 0.01 * max(1.0, high / 10):
        middle = (low + high) / 2
        low, high = (low, middle) if inside(middle) else (middle, high)
    return high


def _sliding_extremes(values: Array) -> tuple[list[Array], list[Array]]:
    """Return minima and maxima over all windows of 1, 2, 4, ... samples (a sparse table)."""
    low, high = [values], [values]
    step = 1
    while 2 * step <= len(values):
        low.append(np.minimum(low[-1][:-step], low[-1][step:]))
        high.append(np.maximum(high[-1][:-step], high[-1][step:]))
        step *= 2
    return low, high
