"""Events whose time is known beforehand: samples, and relations that are linear in time."""

from __future__ import annotations

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
        self._places = hybrid.sample_places
        self._first = hybrid.sample_start
        self._interval = hybrid.sample_interval
        passed = (start - self._first) / self._interval if len(self._places) else np.zeros(0)
        self._count: Array = np.maximum(np.ceil(passed - 1e-12), 0.0)
        self._times: Array = self._first + self._count * self._interval
        self._next_sample = float(self._times.min(initial=np.inf))
        self._jumps: list[float] = []

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
        if self._next_sample > time + SAME_TIME * max(abs(time), 1e-3):
            return _NONE
        now = self._times <= time + SAME_TIME * max(abs(time), 1e-3)
        self._count[now] += 1.0
        self._times[now] = self._first[now] + self._count[now] * self._interval[now]
        self._next_sample = float(self._times.min(initial=np.inf))
        return self._places[now]

    def next_time(self, kernels: EventKernels) -> float:
        """Return the next time, ``inf`` if there is none; relations have just been prepared."""
        known = min(self._next_sample, self._jumps[0]) if self._jumps else self._next_sample
        if not kernels.states.any_scheduled:
            return known
        return min(known, float(kernels.states.next.min()))
