"""Bodies that stay where they have met: found before they go through each other.

A ``reinit`` throws a body back from what it has met, and its relation becomes false again. If the
flight to come is lower than what the integration resolves, it stays true, nothing acts any more,
and the body goes on through. How high a flight ``g`` will be follows from ``g'`` and ``g''`` right
after the impact, which are differences of ``g`` along the motion. What can come to rest does so
(:mod:`acausal.simulation.accumulation`); anything else must not go on in silence.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from acausal.flattening.model import EquationFamily, Hybrid, Ids, Operand
from acausal.simulation.event_kernels import EventKernels
from acausal.simulation.relations import FLOOR
from acausal.simulation.relations import SHARE as HYSTERESIS

Array = NDArray[np.float64]
#: Returns what a function returns now and at the next two steps of a length, or None.
Glances = Callable[[float, Callable[[], Array]], list[Array] | None]

#: A body is next to what it has met within this multiple of what its relation can tell.
NEXT_TO = 10.0
#: A flight below this multiple of the relative tolerance is none.
SHARE_OF_TOLERANCE = 1e-2
#: Flights shorter than this share of the longest one are looked at.
SHORT = 0.1
#: Impacts that leave less than this share of a velocity are looked at.
WEAK = 0.3
#: Steps of the differences, as shares of the longest flight.
STEPS = (1e-6, 1e-4)
#: A difference of second order below so many units of round-off says nothing.
ROUNDOFF = 100.0 * float(np.finfo(float).eps)

_NONE: Ids = np.zeros(0, np.int64)


class Contacts:
    """Watches what makes reinits act."""

    def __init__(self, hybrid: Hybrid, start: float, tolerance: float) -> None:
        self._hybrid = hybrid
        self._reach = max(NEXT_TO * HYSTERESIS, SHARE_OF_TOLERANCE * tolerance)
        self._behind: dict[int, Ids] = {}
        self._start = start
        self._last = np.full(hybrid.reinits.count, -np.inf)
        self._longest = np.zeros(hybrid.reinits.count)

    def memory(self) -> dict[str, Array]:
        """Return what it takes to go on: when reinits have acted."""
        return {
            "begun": np.array([self._start]), "acted": self._last.copy(),
            "longest": self._longest.copy(),
        }  # fmt: skip

    def recall(self, memory: Mapping[str, Array]) -> None:
        """Go on from a memory."""
        self._start = float(memory["begun"][0])
        self._last[:], self._longest[:] = memory["acted"], memory["longest"]

    def stuck(
        self, acting: Ids, before: Array, time: float, kernels: EventKernels, glances: Glances
    ) -> tuple[Ids, Ids]:
        """Return the reinits that do not get off what they have met, and its relations.

        Args:
            acting: Numbers of the reinits that have acted, ascending.
            before: Values before of what they have acted on, shape of ``acting``.
            time: Seconds.
            kernels: The discrete equations, after it.
            glances: Looks ahead.
        """
        gap = time - self._last[acting]
        unseen = np.isinf(gap)
        if not unseen.any() and (gap == 0.0).all():
            return _NONE, _NONE
        longest = np.maximum(self._longest[acting], np.where(unseen, time - self._start, gap))
        self._last[acting], self._longest[acting] = time, longest
        after = kernels.values_of(self._hybrid.reinits.states[acting])
        weak = np.abs(after) <= WEAK * np.abs(before)
        looked_at = acting[unseen | weak | (gap < SHORT * longest)]
        if not len(looked_at):
            return _NONE, _NONE
        met = np.unique(np.concatenate([self._relations(k) for k in looked_at.tolist()]))
        kernels.look()
        states = kernels.states
        watched = (states.relations.kind[met] != FLOOR) & ~states.relations.scheduled[met]
        met = met[watched & (np.abs(states.g[met]) <= NEXT_TO * HYSTERESIS * states.largest[met])]
        if not len(met):
            return _NONE, _NONE
        met = met[self._flights_are_flat(met, kernels, glances, float(longest.max()))]
        fast = [k for k in looked_at.tolist() if np.isin(self._relations(k), met).any()]
        return np.array(fast, np.int64), met

    def _relations(self, reinit: int) -> Ids:
        if reinit not in self._behind:
            self._behind[reinit] = relations_behind(self._hybrid, reinit)
        return self._behind[reinit]

    def _flights_are_flat(
        self, met: Ids, kernels: EventKernels, glances: Glances, longest: float
    ) -> NDArray[np.bool_]:
        states = kernels.states
        reach = self._reach * states.largest[met]
        noise = ROUNDOFF * states.largest[met]
        side = np.where(states.held[met] > 0.0, 1.0, -1.0)

        def look() -> Array:
            kernels.look()
            return states.g[met]  # a copy, as the index is an array

        for share in STEPS:
            step = share * longest
            found = glances(step, look)
            if found is None:
                break
            second = side * (found[2] - 2.0 * found[1] + found[0])
            first = 2.0 * found[1] - 1.5 * found[0] - 0.5 * found[2]
            if (second > noise).any():
                flat: NDArray[np.bool_] = (second > noise) & (first**2 <= 2.0 * reach * second)
                return flat
        return np.zeros(len(met), np.bool_)


def relations_behind(hybrid: Hybrid, reinit: int) -> Ids:
    """Return the numbers of the relations that the condition of a reinit is made of."""
    assigned = {
        int(row): (family, k)
        for family in hybrid.assignments
        for k, row in enumerate(family.rows.tolist())
    }
    relation_at: dict[int, int] = {}
    for relation in hybrid.relations:
        for row in relation.family.rows.tolist():
            relation_at[row] = len(relation_at)
    waiting = [
        (family, k)
        for family in hybrid.reinits.fires
        for k in np.flatnonzero(family.rows == reinit).tolist()
    ]
    seen: set[int] = set()
    while waiting:
        for place in _held_places(*waiting.pop(), hybrid.first):
            if place not in seen:
                seen.add(place)
                waiting += [assigned[place]] if place in assigned else []
    return np.array(sorted(relation_at[p] for p in seen if p in relation_at), np.int64)


def _held_places(family: EquationFamily, member: int, first: int) -> list[int]:
    return [
        int(ids[member]) - first
        for kind, ids in zip(family.kinds, family.operands, strict=True)
        if kind == Operand.PARAMETER and ids[member] >= first
    ]
