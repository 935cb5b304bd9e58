"""Output times, and storing points as a run goes on."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from acausal.assembly.observe import Held, Observer
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

    Points come in pieces of any size, one at a time around events; a segment is made of all that
    share an observer.

    Attributes:
        chosen: Ids to keep, ascending, or None for everything.
        segments: The finished segments.
    """

    chosen: Ids | None
    segments: list[Segment]
    _observer: Observer | None = None
    _times: list[Array | float] = field(default_factory=list)
    _y: list[Array] = field(default_factory=list)
    _yp: list[Array] = field(default_factory=list)
    _which: list[int] = field(default_factory=list)
    _held: list[Array] = field(default_factory=list)
    _size: int = 0
    _last: bytes | None = None

    def hold(self, held: Array) -> None:
        """Take held values for all points from now on."""
        now = held.tobytes()
        if now != self._last:
            self._last = now
            self._held.append(held.copy())

    def store(self, observer: Observer, times: Array, y: Array, yp: Array) -> None:
        """Store points of one layout; the arrays are kept, not copied."""
        if not len(times):
            return
        if observer is not self._observer or self._size > CHUNK:
            self.flush()
            self._observer = observer
        self._times.append(times)
        self._y.append(y)
        self._yp.append(yp)
        self._which.append(len(self._held) - 1)
        self._size += y.size + yp.size if self.chosen is not None else 0

    def store_point(self, observer: Observer, time: float, y: Array, yp: Array) -> None:
        """Store one point; the arrays, shape ``(n,)``, are copied."""
        if observer is not self._observer or self._size > CHUNK:
            self.flush()
            self._observer = observer
        self._times.append(float(time))
        self._y.append(y.copy())
        self._yp.append(yp.copy())
        self._which.append(len(self._held) - 1)
        self._size += 2 * y.size if self.chosen is not None else 0

    def flush(self) -> None:
        """Make a segment of what has come so far."""
        if self._observer is None or not self._times:
            return
        times = np.concatenate([np.atleast_1d(part) for part in self._times])
        y, yp = _joined(self._y), _joined(self._yp)
        held = None
        if self._held:
            counts = [1 if isinstance(part, float) else len(part) for part in self._times]
            first = self._which[0]
            which = np.repeat(np.array(self._which) - first, counts)
            held = Held(np.stack(self._held[first:]), which)
            del self._held[:-1]
        if self.chosen is None:
            self.segments.append(Segment(self._observer, times, y, yp, None, held))
        else:
            values = self._observer.values(self.chosen.tolist(), times, y, yp, held)
            empty = np.zeros((len(times), 0))
            self.segments.append(Segment(self._observer, times, empty, empty, values))
        for parts in (self._times, self._y, self._yp, self._which):
            parts.clear()
        self._size = 0

    def chunk(self, n: int) -> int:
        """Return how many points of ``2 n`` numbers are integrated at a time."""
        if self.chosen is None:
            return MOST_POINTS
        return max(2, CHUNK // max(1, 2 * n))


def _joined(parts: list[Array]) -> Array:
    """Return the rows of arrays of points and of single points."""
    rows = [part if part.ndim == 2 else part[None, :] for part in parts]
    return rows[0] if len(rows) == 1 else np.concatenate(rows)
