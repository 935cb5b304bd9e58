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
    lower, upper = np.empty_like(times), np.empty_like(times)
    left = np.interp(times - width, reference_times, reference)
    right = np.interp(times + width, reference_times, reference)
    for k in range(len(times)):
        i, j = int(first[k]), int(last[k])
        lower[k], upper[k] = min(left[k], right[k]), max(left[k], right[k])
        if j > i:
            level = (j - i).bit_length() - 1
            step = 1 << level
            lower[k] = min(lower[k], low_level[level][i], low_level[level][j - step])
            upper[k] = max(upper[k], high_level[level][i], high_level[level][j - step])
    return Tube(lower - height, upper + height, height)


def _sliding_extremes(values: Array) -> tuple[list[Array], list[Array]]:
    """Return minima and maxima over all windows of 1, 2, 4, ... samples (a sparse table)."""
    low, high = [values], [values]
    step = 1
    while 2 * step <= len(values):
        low.append(np.minimum(low[-1][:-step], low[-1][step:]))
        high.append(np.maximum(high[-1][:-step], high[-1][step:]))
        step *= 2
    return low, high
