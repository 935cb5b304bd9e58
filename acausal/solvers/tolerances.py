"""Tolerances as IDA needs them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from acausal.solvers.protocol import Options
from acausal.solvers.system import Pattern

Array = NDArray[np.float64]
_SMALLEST = 1e-14


def suppressing(options: Options, problem: Pattern) -> bool:
    """Return whether algebraic unknowns are left out of the error test.

    Without a single state there would be nothing left to control the step with.
    """
    mask = problem.differential
    return options.suppress_algebraic and bool(mask.any()) and not bool(mask.all())


def ida_tolerances(options: Options, problem: Pattern) -> tuple[float, Array]:
    """Return the relative tolerance and the absolute tolerance of each unknown, shape ``(n,)``.

    IDA's error norm is a root mean square. When algebraic unknowns are left out, it sums over the
    states but still divides by the number of all unknowns: the more algebraic unknowns a model has,
    the larger the errors that pass. The tolerances are reduced so that a model of ``m`` states
    is as accurate as an ordinary differential equation of ``m`` states.
    """
    factor = 1.0
    if suppressing(options, problem):
        factor = math.sqrt(np.count_nonzero(problem.differential) / problem.n)
    relative = max(options.relative_tolerance * factor, _SMALLEST)
    return relative, options.absolute_tolerance * factor * problem.nominal
