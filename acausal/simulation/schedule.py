"""Events whose time is known beforehand: samples, and relations that are linear in time."""

from __future__ import annotations

from collections.abc import Mapping
from heapq import heappop, heappush

import numpy as np
from numpy.typing import NDArray

from acausal.flattening.model import Hybrid, Ids
from acausal.simulation.event_kernels import EventKernels
from acausal.simulation.relations import SAME_TIME

Array = NDArray[np.float64]

_NONE = np.zeros(0, np.int64)


class Schedule:
    """Knows the next event in time.

    Sample ``k`` comes at ``start + m*interval`` with whole numbers ``m``, not by adding up.
    """

    def __init__(self, hybrid: Hybrid, start: float) -> None:
        # Samples with the same start and interval are one.
        both = np.stack([hybrid.sample_start, hybrid.sample_interval], axis=1)
        clocks, which = np.unique(both, axis=0, return_inverse=True)
        self._clocks: list[tuple[float, float]] = [(float(a), float(b)) for a, b in clocks]
        self._places = [hybrid.sample_places[which.ravel() == k] for k in range(len(clocks))]
        self._count = [
            max(float(np.ceil((start - first) / interval - 1e-12)), 0.0)
            for first, interval in self._clocks
        ]
        self._times = [
            first + m * interval
            for (first, interval), m in zip(self._clocks, self._count, strict=True)
        ]
        self._next_sample = min(self._times, default=np.inf)
        self._jumps: list[float] = []

    def memory(self) -> dict[str, Array]:
        """Return what it takes to go on: samples done, jumps of delayed values to come."""
        return {"samples": np.array(self._count), "jumps": np.array(sorted(self._jumps))}

    def recall(self, memory: Mapping[str, Array]) -> None:
        """Go on from a memory of the same clocks."""
        self._count = [float(c) for c in memory["samples"]]
        self._times = [
            first + m * interval
            for (first, interval), m in zip(self._clocks, self._count, strict=True)
        ]
        self._next_sample = min(self._times, default=np.inf)
        self._jumps = memory["jumps"].tolist()  # ascending: a heap

    def add_jumps(self, times: Array) -> None:
        """Take note of jumps of delayed values."""
        for time in times.tolist():
            heappush(self._jumps, time)

    def has_jump(self, time: float) -> bool:
        """Tell whether delayed values jump now, and forget these jumps."""
        found = False
        while self._jumps and self._jumps[0] <= time + SAME_TIME * max(abs(time), 1e-3):
            heappop(self._jumps)
            found = True
        return found

    def due(self, time: float) -> Ids:
        """Return the held positions of the samples whose time it is, and go on to their next."""
        latest = time + SAME_TIME * max(abs(time), 1e-3)
        if self._next_sample > latest:
            return _NONE
        found: list[Ids] = []
        for k, (first, interval) in enumerate(self._clocks):
            if self._times[k] <= latest:
                found.append(self._places[k])
                self._count[k] += 1.0
                self._times[k] = first + self._count[k] * interval
        self._next_sample = min(self._times)
        return found[0] if len(found) == 1 else np.sort(np.concatenate(found))

    def next_time(self, kernels: EventKernels) -> float:
        """Return the next time, ``inf`` if there is none; relations have just been prepared."""
        known = min(self._next_sample, self._jumps[0]) if self._jumps else self._next_sample
        if not kernels.states.any_scheduled:
            return known
        return min(known, float(np.minimum.reduce(kernels.states.next)))
