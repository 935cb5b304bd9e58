"""The first step of a multistep method.

IDA's own choice is a thousandth of the distance to the first output time, which can be thousands of
periods of a source that stands still at the start: the error test then sees nothing of them. A
small first step costs little, because the method doubles its steps until the error test objects.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: First step as a fraction of the distance to the limit.
FRACTION = 1e-6
#: Largest change of the states in the first step, in units of the tolerance (as in IDA).
CHANGE = 0.5
_UNIT_ROUNDOFF = float(np.finfo(float).eps)


def first_step(
    t: float,
    t_limit: float,
    y: Array,
    yp: Array,
    differential: NDArray[np.bool_],
    relative_tolerance: float,
    absolute_tolerance: Array,
) -> float:
    """Return a first step, seconds.

    Args:
        t: Time of the start.
        t_limit: Where the integration ends at the latest, later than ``t``.
        y: Unknowns, shape ``(n,)``.
        yp: Derivatives, shape ``(n,)``.
        differential: Mask of the states, shape ``(n,)``.
        relative_tolerance: Relative tolerance.
        absolute_tolerance: Absolute tolerance of each unknown, shape ``(n,)``.
    """
    rate = np.where(differential, yp, 0.0) / (relative_tolerance * np.abs(y) + absolute_tolerance)
    norm = math.sqrt(float(rate @ rate) / max(len(rate), 1))
    step = FRACTION * (t_limit - t)
    if norm * step > CHANGE:
        step = CHANGE / norm
    smallest = 64.0 * _UNIT_ROUNDOFF * max(abs(t), abs(t_limit))
    return min(max(step, smallest), t_limit - t)
