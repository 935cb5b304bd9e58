"""Output times, and storing points as a run goes on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.assembly.observe import Observer
from acausal.diagnostics import fail
from acausal.flattening.model import Ids
from acausal.simulation.request import DEFAULT_POINTS, Request
from acausal.simulation.trajectories import Segment

Array = NDArray[np.float64]

#: Numbers held at most before chosen variables are taken out of them.
CHUNK = 8_000_000
#: More output points than this are surely a mistake in the interval.
MOST_POINTS = 50_000_000


def output_times(request: Request, start: float, stop: float) -> Array:
    """Return the output times, both ends included.

    Raises:
        AcausalError: ``R010`` for an impossible number of points or interval.
    """
    if request.interval is not None:
        if not request.interval > 0 or (stop - start) / request.interval > MOST_POINTS:
            fail("R010", f"an output interval of {request.interval:g} s is not possible",
                 help="give a time above 0, "
                 "at least a small part of the simulated time")  # fmt: skip
        count = int(np.floor((stop - start) / request.interval * (1 + 1e-12)))
        times: Array = start + request.interval * np.arange(count + 1, dtype=np.float64)
        if times[-1] < stop - 1e-9 * (stop - start):
            times = np.append(times, stop)
        times[-1] = stop
        return times
    points = DEFAULT_POINTS if request.points is None else request.points
    if not 2 <= points <= MOST_POINTS:
        fail("R010", f"{points} output points are not possible", help="ask for 2 or more")
    return np.linspace(start, stop, points, dtype=np.float64)


@dataclass
class Recorder:
    """Collects points into segments; keeps only chosen variables if so asked.

    Attributes:
        chosen: Ids to keep, ascending, or None for everything.
        segments: The finished segments.
    """

    chosen: Ids | None
    segments: list[Segment]

    def store(self, observer: Observer, times: Array, y: Array, yp: Array) -> None:
        """Store points of one layout; the arrays are kept, not copied."""
        if not len(times):
            return
        if self.chosen is None:
            self.segments.append(Segment(observer, times, y, yp))
            return
        values = observer.values(self.chosen.tolist(), times, y, yp)
        empty = np.zeros((len(times), 0))
        self.segments.append(Segment(observer, times, empty, empty, values))

    def chunk(self, n: int) -> int:
        """Return how many points of ``2 n`` numbers are integrated at a time."""
        if self.chosen is None:
            return MOST_POINTS
        return max(2, CHUNK // max(1, 2 * n))
