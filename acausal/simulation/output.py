"""Output times, and storing points as a run goes on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from struct import Struct

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
#: The same where a file is written while the run goes on.
WRITTEN = 1_000_000
#: More output points than this are surely a mistake in the interval.
MOST_POINTS = 50_000_000
_DOUBLE = Struct("d")


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
        look: Sees every segment before anything of it is dropped.
        sink: Takes times and the values of ``written`` as the run goes on.
        written: Ids that the sink takes.
        keep: Whether segments are kept in memory.
    """

    chosen: Ids | None
    segments: list[Segment]
    look: Callable[[Segment], None] | None = None
    sink: Callable[[Array, Array], None] | None = None
    written: Sequence[int] = ()
    keep: bool = True
    _observer: Observer | None = None
    _times: list[Array | bytes] = field(default_factory=list)
    _y: list[Array | bytes] = field(default_factory=list)
    _yp: list[Array | bytes] = field(default_factory=list)
    _counts: list[int] = field(default_factory=list)
    _which: list[int] = field(default_factory=list)
    _held: list[bytes] = field(default_factory=list)
    _columns: int = 0
    _size: int = 0

    def hold(self, held: Array) -> None:
        """Take held values for all points from now on."""
        now = held.tobytes()
        if not self._held or now != self._held[-1]:
            self._held.append(now)

    def store(self, observer: Observer, times: Array, y: Array, yp: Array) -> None:
        """Store points of one layout; the arrays are kept, not copied."""
        if not len(times):
            return
        self._add(observer, times, y, yp, len(times), y.shape[1])

    def store_point(self, observer: Observer, time: float, y: Array, yp: Array) -> None:
        """Store a single point; the arrays are copied."""
        # Bytes: many small arrays would cost ten times as much.
        self._add(observer, _DOUBLE.pack(time), y.tobytes(), yp.tobytes(), 1, len(y))

    def _add(
        self,
        observer: Observer,
        times: Array | bytes,
        y: Array | bytes,
        yp: Array | bytes,
        count: int,
        columns: int,
    ) -> None:
        if observer is not self._observer or self._size > self._most:
            self.flush()
            self._observer, self._columns = observer, columns
        self._times.append(times)
        self._y.append(y)
        self._yp.append(yp)
        self._counts.append(count)
        self._which.append(len(self._held) - 1)
        if self.chosen is not None or self.sink is not None:
            self._size += count * max(2 * columns, len(self.written))

    @property
    def _most(self) -> int:
        return CHUNK if self.sink is None else WRITTEN

    def flush(self) -> None:
        """Make a segment of what has come so far."""
        if self._observer is None or not self._times:
            return
        times = _joined(self._times)
        shape = (len(times), self._columns)
        y, yp = (_joined(parts).reshape(shape) for parts in (self._y, self._yp))
        held = None
        if self._held:
            first = self._which[0]
            which = np.repeat(np.array(self._which) - first, self._counts)
            parts = self._held[first:]
            values = np.frombuffer(b"".join(parts)).reshape(len(parts), len(parts[0]) // 8)
            held = Held(values, which)
            del self._held[:-1]
        for stored in (self._times, self._y, self._yp, self._counts, self._which):
            stored.clear()
        self._size = 0
        self._finish(Segment(self._observer, times, y, yp, None, held))

    def _finish(self, whole: Segment) -> None:
        """Look at a segment, write it, keep it, as it is asked for."""
        if self.look is not None:
            self.look(whole)

        def values(ids: Sequence[int]) -> Array:
            return whole.observer.values(ids, whole.times, whole.y, whole.yp, whole.held)

        if self.keep and self.chosen is None:
            self.segments.append(whole)
        elif self.keep and self.chosen is not None:
            empty = np.zeros((len(whole.times), 0))
            kept = values(self.chosen.tolist())
            self.segments.append(Segment(whole.observer, whole.times, empty, empty, kept))
        if self.sink is not None:
            self.sink(whole.times, values(self.written))

    def chunk(self, n: int) -> int:
        """Return how many points of ``2 n`` numbers are integrated at a time."""
        if self.chosen is None and self.sink is None:
            return MOST_POINTS
        return max(2, self._most // max(1, 2 * n, len(self.written)))


def _joined(parts: list[Array | bytes]) -> Array:
    """Return all numbers in a row, of a single array without a copy."""
    first = parts[0]
    if len(parts) == 1 and not isinstance(first, bytes):
        return first
    plain = (part if isinstance(part, bytes) else part.data for part in parts)
    return np.frombuffer(bytearray().join(plain))
