"""Relations that are frozen between events: what they are held at, and when that has to change.

A relation ``g > 0`` is held at 1 or 0, ``floor(g)`` at a whole number. Between events the equations
read the held value, so they are smooth; the solver looks for the moment at which the difference
``g`` no longer agrees with it. At an event the relations are brought into step with the values.

What was computed is known to round-off only, so a relation whose ``g`` is next to zero stays as
it is: it changes where ``g`` is on the other side by more than :data:`SHARE` of the largest
``g`` it has seen, or where ``g`` jumps to zero exactly. A root that the solver has found is believed. Where ``g`` stands next to zero
when integration goes on, the root function is shifted by the same small amount, so that it has
a sign to begin with; elsewhere it is exact.

Relations that are linear in time, with everything else held, are not left to the solver: the
moment at which they change is the solution of ``a t + b = 0``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.elimination.families import variable_slots
from acausal.expressions.linearity import split_linear
from acausal.expressions.nodes import TIME, ZERO, Expr
from acausal.expressions.traverse import depends_on
from acausal.flattening.model import EquationFamily, Hybrid, Ids

Array = NDArray[np.float64]

#: Share of the largest ``g`` within which a relation stays as it is.
SHARE = 1e-12
#: Share of the largest ``g`` at which a relation that is zero now was certainly not near zero.
JUMP = 1e-6
#: Least shift of a root function: one that has only been zero so far needs a sign, too.
LEAST = 1e-30
#: Times nearer to each other than this share of theirs are one.
SAME_TIME = 1e-13

GREATER, GREATER_EQUAL, FLOOR = 0, 1, 2
_KINDS = {"gt": GREATER, "ge": GREATER_EQUAL, "floor": FLOOR}


@dataclass(frozen=True)
class Relations:
    """All relations of a model, numbered family by family.

    Attributes:
        families: Their differences ``g``.
        kind: :data:`GREATER`, :data:`GREATER_EQUAL` or :data:`FLOOR`, shape ``(n,)``.
        place: Held position of each, shape ``(n,)``.
        scheduled: Linear in time with everything else held, shape ``(n,)``.
        slopes: For each family its coefficient of time where it is scheduled, else None.
        root_relation: Relation of each root function; a ``floor`` has two, shape ``(r,)``.
        root_side: 1 for the second one of a ``floor``, which is one higher, shape ``(r,)``.
    """

    families: tuple[EquationFamily, ...]
    kind: NDArray[np.int8]
    place: Ids
    scheduled: NDArray[np.bool_]
    slopes: tuple[Expr | None, ...]
    root_relation: Ids
    root_side: NDArray[np.int8]

    @property
    def count(self) -> int:
        """Number of relations."""
        return len(self.kind)

    def first_of(self, family: int) -> int:
        """Return the number of the first relation of a family."""
        return sum(f.count for f in self.families[:family])

    def find(self, relation: int) -> tuple[EquationFamily, int]:
        """Return family and member of a relation."""
        for family in self.families:
            if relation < family.count:
                return family, relation
            relation -= family.count
        raise IndexError(relation)


def relations_of(hybrid: Hybrid) -> Relations:
    """Return the relations of a model with what is known about them beforehand."""
    families: list[EquationFamily] = []
    slopes: list[Expr | None] = []
    kinds: list[NDArray[np.int8]] = []
    scheduled: list[NDArray[np.bool_]] = []
    for relation in hybrid.relations:
        family = relation.family
        slope = None
        if not variable_slots(family):
            split = split_linear(family.template, TIME)
            slope = split[0] if split is not None and split[0] is not ZERO else None
        families.append(family)
        slopes.append(slope)
        kinds.append(np.full(family.count, _KINDS[relation.kind], np.int8))
        scheduled.append(np.full(family.count, slope is not None))
    kind = np.concatenate([*kinds, np.zeros(0, np.int8)])
    at_times = np.concatenate([*scheduled, np.zeros(0, np.bool_)])
    place = np.concatenate([*(f.rows for f in families), np.zeros(0, np.int64)])
    watched = np.flatnonzero(~at_times)
    double = watched[kind[watched] == FLOOR]
    return Relations(
        tuple(families),
        kind,
        place,
        at_times,
        tuple(slopes),
        np.concatenate([watched, double]),
        np.repeat(np.array([0, 1], np.int8), [len(watched), len(double)]),
    )


def depends_on_time(family: EquationFamily) -> bool:
    """Tell whether the difference of a relation contains the time."""
    return depends_on(family.template, TIME)


class RelationStates:
    """How relations stand, and how they follow the values.

    Attributes:
        relations: What they are.
        g: Their differences as last evaluated, shape ``(n,)``.
        slope: Coefficients of time of the scheduled ones, zero elsewhere, shape ``(n,)``.
        largest: Largest ``|g|`` so far, shape ``(n,)``.
        left: Differences before the present event, shape ``(n,)``.
        any_scheduled: Some relations are linear in time.
    """

    def __init__(self, relations: Relations) -> None:
        self.relations = relations
        n = relations.count
        self.g: Array = np.zeros(n)
        self.slope: Array = np.zeros(n)
        self.largest: Array = np.zeros(n)
        self.left: Array = np.zeros(n)
        self._floors = np.flatnonzero(relations.kind == FLOOR)
        self._inclusive = relations.kind == GREATER_EQUAL
        self.any_scheduled = bool(relations.scheduled.any())
        self._any_inclusive = bool(self._inclusive.any())

    def take(self, other: RelationStates) -> None:
        """Go on from how the relations stood in another layout."""
        self.g[:] = other.g
        self.slope[:] = other.slope
        self.largest[:] = other.largest

    def wanted(self, held: Array, time: float, *, exact: bool = False) -> Array:
        """Return what the relations should be held at, shape ``(n,)``.

        Args:
            held: What they are held at.
            time: Seconds.
            exact: Without hysteresis, for the first instant.
        """
        g, largest = self.g, self.largest
        np.maximum(largest, np.abs(g), out=largest)
        margin = np.zeros_like(g) if exact else SHARE * largest
        level = np.where(held > 0.0, -margin, margin)
        new = g > level
        if self._any_inclusive:
            new |= self._inclusive & (g == level)
        if not exact:
            jumped = (g == 0.0) & (np.abs(self.left) > JUMP * largest)
            if jumped.any():
                new = np.where(jumped, self._inclusive, new)
        result: Array = new.astype(np.float64)
        if len(self._floors):
            f = self._floors
            below, above = g[f] - held[f] + margin[f], g[f] - held[f] - 1.0 - margin[f]
            result[f] = np.where((below >= 0.0) & (above < 0.0), held[f], np.floor(g[f]))
            if exact:
                result[f] = np.floor(g[f])
        if self.any_scheduled:
            self._at_their_time(result, time)
        return result

    def _at_their_time(self, result: Array, time: float) -> None:
        """Relations linear in time have changed when their time has come, whatever round-off."""
        s = np.flatnonzero(self.relations.scheduled)
        g, slope = self.g[s], self.slope[s]
        tolerance = np.abs(slope) * SAME_TIME * max(abs(time), 1e-3)
        floors = self.relations.kind[s] == FLOOR
        nearest = np.where(floors, np.round(g), 0.0)
        here = (np.abs(g - nearest) <= tolerance) & (slope != 0.0)
        rising = slope > 0.0
        value = np.where(floors, np.where(rising, nearest, nearest - 1.0), rising)
        exact = np.where(floors, np.floor(g), np.where(self._inclusive[s], g >= 0.0, g > 0.0))
        result[s] = np.where(here, value, exact)

    def next_times(self, held: Array, time: float) -> Array:
        """Return when each scheduled relation changes next, ``inf`` if never, shape ``(n,)``."""
        result = np.full(len(self.g), np.inf)
        s = np.flatnonzero(self.relations.scheduled)
        if not len(s):
            return result
        g, slope = self.g[s], self.slope[s]
        floors = self.relations.kind[s] == FLOOR
        level = np.where(floors, held[s] + (slope > 0.0), 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            wait = (level - g) / slope
        coming = np.where(floors, slope != 0.0, np.where(held[s] > 0.0, slope < 0.0, slope > 0.0))
        coming &= wait > SAME_TIME * max(abs(time), 1e-3)
        result[s] = np.where(coming, time + wait, np.inf)
        return result

    def after_roots(self, held: Array, roots: NDArray[np.int32]) -> Array:
        """Return what the relations are held at after the solver has found roots.

        Args:
            held: What they were held at, shape ``(n,)``.
            roots: 1 rising, -1 falling, 0 for none, shape ``(r,)``.
        """
        new = held.copy()
        for root in np.flatnonzero(roots).tolist():
            k = int(self.relations.root_relation[root])
            rising = roots[root] > 0
            if self.relations.kind[k] == FLOOR:
                new[k] += 1.0 if rising else -1.0
            else:
                new[k] = 1.0 if rising else 0.0
        return new

    def watch(self, held: Array) -> tuple[NDArray[np.int32], Array]:
        """Return direction and shift of each root function for what is held, shape ``(r,)``."""
        np.maximum(self.largest, np.abs(self.g), out=self.largest)
        k = self.relations.root_relation
        g, value = self.g[k], held[k]
        floors = self.relations.kind[k] == FLOOR
        upper = self.relations.root_side == 1
        up = np.where(floors, upper, value <= 0.0)
        level = np.where(floors, value + upper, 0.0)
        inside = np.where(up, level - g, g - level)  # how far it is from changing
        margin = np.maximum(SHARE * self.largest[k], LEAST)
        room = np.where(inside < 0.5 * margin, margin, 0.0)
        return np.where(up, 1, -1).astype(np.int32), -level + np.where(up, -room, room)
