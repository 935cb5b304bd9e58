"""Impacts that accumulate: recognised, and ended in rest.

Impacts of one reinit follow each other ever faster, with ever smaller velocities. A flight as high
as the product of velocity and duration says, compared with the first one, is below what the
integration resolves sooner or later. Then the infinitely many impacts still to come take next to
no time, the velocity is set to zero, and the body rests (:mod:`acausal.elimination.rests`).

Until then a step of the integrator must not leap over a whole flight, at both ends of which
the height is zero: after every impact it is stopped once, early in the flight to come.

A body that does not get off what it has met, as with a restitution of zero, rests at once (see
:mod:`acausal.simulation.contacts`).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from acausal.flattening.model import Hybrid, Ids
from acausal.simulation.contacts import SHARE_OF_TOLERANCE
from acausal.simulation.event_kernels import EventKernels

Array = NDArray[np.float64]

#: A body comes to rest when a flight is this much lower than the first one, or by
#: ``SHARE_OF_TOLERANCE`` times the relative tolerance.
SHARE = 1e-10
#: Where the integrator is stopped after an impact, as a share of the flight before it.
EARLY = 0.1
#: Impacts in a row, each sooner and weaker than the one before.
LEAST = 5
_REMEMBERED = ("last", "gap", "speed", "first", "pace", "count")
#: Velocity per duration of a flight stays the same where a stop does not move, about.
EVEN = 10.0


class Accumulation:
    """Watches the impacts of all reinits that may end in rest.

    Attributes:
        early: A time in the flight after the last impact at which to stop, ``inf`` if none.
    """

    def __init__(self, hybrid: Hybrid, tolerance: float) -> None:
        self._hybrid = hybrid
        self._rests = hybrid.rests
        self._share = max(SHARE, SHARE_OF_TOLERANCE * tolerance)
        self.early = np.inf
        n = hybrid.reinits.count
        self._number = np.full(n, -1, np.int64)
        if hybrid.rests is not None:
            self._number[hybrid.rests.reinits] = np.arange(len(hybrid.rests.reinits))
        self._last = np.full(n, -np.inf)
        self._gap = np.full(n, np.inf)
        self._speed = np.full(n, np.inf)
        self._first = np.zeros(n)
        self._pace = np.zeros(n)
        self._count = np.zeros(n, np.int64)

    def memory(self) -> dict[str, Array]:
        """Return what it takes to go on: the last impacts."""
        own = {name: getattr(self, f"_{name}").copy() for name in _REMEMBERED}
        return {**own, "early": np.array([self.early])}

    def recall(self, memory: Mapping[str, Array]) -> None:
        """Go on from a memory."""
        for name in _REMEMBERED:
            getattr(self, f"_{name}")[:] = memory[name]
        self.early = float(memory["early"][0])

    def ending(self, acting: Ids, values: Array, time: float) -> Ids:
        """Take note of impacts; return the reinits that end in rest now.

        Args:
            acting: Numbers of the reinits that act.
            values: New values of all reinits.
            time: Seconds.
        """
        if self._rests is None:
            return acting[:0]
        speed, gap = np.abs(values[acting]), time - self._last[acting]
        if not np.isfinite(speed).all():
            return acting[:0]  # reported with the values of this event
        repeated = gap == 0.0
        weaker = (gap < self._gap[acting]) & (speed < self._speed[acting]) & (gap < np.inf)
        self._count[acting] = np.where(
            repeated, self._count[acting], np.where(weaker, self._count[acting] + 1, 0)
        )
        fresh = self._count[acting] <= 1
        flight = np.multiply(speed, gap, out=np.full(len(gap), np.inf), where=gap < np.inf)
        self._first[acting] = np.where(fresh, flight, self._first[acting])
        pace = np.divide(speed, gap, out=np.zeros(len(gap)), where=gap > 0.0)
        self._pace[acting] = np.where(fresh, pace, self._pace[acting])
        self._gap[acting] = np.where(repeated, self._gap[acting], gap)
        self._speed[acting] = speed
        self._last[acting] = time
        self.early = time + EARLY * float(gap.min(initial=np.inf))
        ends = (self._count[acting] >= LEAST) & (flight <= self._share * self._first[acting])
        ends &= self._number[acting] >= 0
        self._count[acting[ends]] = 0
        ending: Ids = acting[ends]
        return ending

    def are_calm(self, acting: Ids, before: Array, kernels: EventKernels) -> bool:
        """Tell whether what reinits have thrown back comes to rest where it is.

        Its velocities become as small as its flights become short: what it has met does not move.

        Args:
            acting: Numbers of the reinits that have acted.
            before: Velocities before, shape of ``acting``.
            kernels: The discrete equations, after it.
        """
        if self._rests is None or (self._number[acting] < 0).any():
            return False
        speed = np.abs(kernels.values_of(self._hybrid.reinits.states[acting]))
        acceleration = kernels.values_of(self._rests.accelerations[self._number[acting]])
        flat = speed <= 2.0 * np.sqrt(self._share) * np.abs(before)
        steady = self._count[acting] > 0
        steady &= speed <= EVEN * self._pace[acting] * np.minimum(self._gap[acting], 1e300)
        return bool(((acceleration * before > 0.0) & (flat | steady)).all())

    def begin_rest(self, ending: Ids, kernels: EventKernels) -> None:
        """Hold the bodies of some reinits at rest."""
        assert self._rests is not None
        number = self._number[ending]
        kernels.held[self._rests.at_rest[number]] = 1.0
        kernels.held[self._rests.sign[number]] = 1.0
        kernels.held[self._rests.supported[number]] = 1.0

    def orient(self, ending: Ids, kernels: EventKernels) -> None:
        """Let the support act in the direction in which it is needed now."""
        assert self._rests is not None
        number = self._number[ending]
        kernels.look()
        place = self._rests.supported[number]
        relations = kernels.states.relations
        g = np.zeros(len(kernels.held))
        g[relations.place] = kernels.states.g
        kernels.held[self._rests.sign[number]] = np.where(g[place] < 0.0, -1.0, 1.0)

    def end_rests(self, kernels: EventKernels) -> bool:
        """End the rests whose support would have to pull; return whether any ends."""
        if self._rests is None:
            return False
        held = kernels.held
        ends = (held[self._rests.at_rest] > 0.0) & (held[self._rests.supported] == 0.0)
        if not ends.any():
            return False
        held[self._rests.at_rest[ends]] = 0.0
        return True
