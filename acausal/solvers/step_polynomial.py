"""The polynomial that an integrator interpolates with inside its last step.

IDA's is the BDF polynomial itself (order 1 to 5), taken as Taylor coefficients at the end of the
step: its derivatives there are what IDAGetDky gives, so that nothing is approximated. Hermite's
cubic through values and derivatives at both ends would need a third of the memory; measured, it is
as near to the solution at loose tolerances, and misses it twice as far at 1e-8. It needs
derivatives, too, which algebraic unknowns do not have everywhere.

Other integrators are sampled at Chebyshev points: six of them give their polynomials of degree
five and below exactly, ``y`` and ``y'`` each by itself, since ``y'`` is not always the derivative
of ``y`` there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from acausal.solvers.protocol import Integrator

Array = NDArray[np.float64]

#: Points at which integrators are sampled that do not tell their polynomial.
SAMPLES = 6


@dataclass(frozen=True, slots=True)
class StepPolynomial:
    """``y = sum(terms[k] * s**k)`` with ``s = (t - end) / step``.

    Attributes:
        end: Seconds.
        step: Seconds.
        terms: Shape ``(degree + 1, n)``.
        slopes: Likewise for ``y'``; None if it is the derivative of ``y``.
    """

    end: float
    step: float
    terms: Array
    slopes: Array | None = None


@runtime_checkable
class _Tells(Protocol):
    def polynomial(self) -> StepPolynomial | None: ...


def step_polynomial(integrator: Integrator, begin: float, end: float) -> StepPolynomial | None:
    """Return the polynomial of the last step; None if there was none.

    Args:
        integrator: Stands at ``end``.
        begin: Where the part of the step that is asked for begins, seconds.
        end: Where it ends.
    """
    if isinstance(integrator, _Tells):
        return integrator.polynomial()
    places, to_terms = _chebyshev()
    times = end + (end - begin) * places
    times[0], times[-1] = begin, end
    try:
        y = np.array([integrator.interpolate(float(t)) for t in times[1:]])
        yp = np.array([integrator.interpolate(float(t), 1) for t in times[1:]])
    except ValueError:
        return None
    return StepPolynomial(end, end - begin, to_terms @ y, to_terms @ yp)


@lru_cache(maxsize=1)
def _chebyshev() -> tuple[Array, Array]:
    """Return places in [-1, 0], a first one that is left out, and what makes coefficients.

    The beginning itself is left out: there an integrator may still show what was before.
    """
    angles = (2 * np.arange(SAMPLES) + 1) * np.pi / (2 * SAMPLES)
    inside = -0.5 - 0.5 * np.cos(angles)
    inside[-1] = 0.0
    inverse: Array = np.asarray(np.linalg.inv(np.vander(inside, increasing=True)), np.float64)
    return np.concatenate([[-1.0], inside]), inverse
