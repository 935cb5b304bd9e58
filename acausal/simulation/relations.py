"""Relations that are frozen between events: what they are held at, and when that has to change.

A relation ``g > 0`` is held at 1 or 0, ``floor(g)`` at a whole number. Between events the equations
read the held value, so they are smooth; the solver looks for the moment at which the difference
``g`` no longer agrees with it. At an event the relations are brought into step with the values.

What was computed is known to round-off only, so a relation whose ``g`` is next to zero stays as
it is: it changes where ``g`` is on the other side by more than :data:`SHARE` of the largest
``g`` it has seen, or where ``g`` jumps to zero exactly. A root that the solver has found is
believed. Where ``g`` stands next to zero when integration goes on, the root function is shifted
by the same small amount, so that it has a sign to begin with; elsewhere it is exact.

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
from acausal.flattening.model import EquationFamily, Hybrid, Ids
from acausal.memory import Remembered

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


_known: Remembered[Relations] = Remembered()


def relations_of(hybrid: Hybrid) -> Relations:
    """Return the relations of a model with what is known about them beforehand."""
    return _known.get(hybrid.relations, (), lambda: _relations_of(hybrid))


def _relations_of(hybrid: Hybrid) -> Relations:
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


@dataclass(frozen=True)
class Places:
    """Where numbers about relations stand, in a part of the work vector of their own.

    Attributes:
        first: Position of the first one.
        n, r: Numbers of relations and of root functions.
    """

    first: int
    n: int
    r: int

    #: For each relation: difference, coefficient of time, largest difference so far, difference
    #: before the event, held value, wanted value, next time.
    NAMES = ("g", "slope", "largest", "left", "held", "wanted", "next")

    def of(self, name: str) -> int:
        """Return the position of the first number of a sort."""
        return self.first + self.NAMES.index(name) * self.n

    @property
    def shift(self) -> int:
        """Position of the first shift of a root function; the directions follow."""
        return self.first + len(self.NAMES) * self.n

    @property
    def size(self) -> int:
        """Number of positions."""
        return len(self.NAMES) * self.n + 2 * self.r


def room_for(relations: Relations) -> int:
    """Return how many numbers relations need in a work vector."""
    return Places(0, relations.count, len(relations.root_relation)).size


class RelationStates:
    """How relations stand; views of a work vector, changed by its kernels.

    Attributes:
        relations: What they are.
        places: Where the numbers are.
        g: Their differences as last evaluated, shape ``(n,)``.
        slope: Coefficients of time of the scheduled ones, zero elsewhere, shape ``(n,)``.
        largest: Largest ``|g|`` so far, shape ``(n,)``.
        left: Differences before the present event, shape ``(n,)``.
        held: What they were held at when last looked at, shape ``(n,)``.
        wanted: What they should be held at, shape ``(n,)``.
        next: When each scheduled relation changes next, ``inf`` if never, shape ``(n,)``.
        shift: Shift of each root function, shape ``(r,)``.
        direction: 1 to look for rising roots, -1 for falling ones, shape ``(r,)``.
        any_scheduled: Some relations are linear in time.
    """

    def __init__(self, relations: Relations, w: Array, first: int) -> None:
        self.relations = relations
        n, r = relations.count, len(relations.root_relation)
        self.places = places = Places(first, n, r)
        self.g, self.slope, self.largest, self.left, self.held, self.wanted, self.next = (
            w[places.of(name) : places.of(name) + n] for name in Places.NAMES
        )
        self.shift: Array = w[places.shift : places.shift + r]
        self.direction: Array = w[places.shift + r : places.shift + 2 * r]
        self.any_scheduled = bool(relations.scheduled.any())

    def take(self, other: RelationStates) -> None:
        """Go on from how the relations stood in another layout."""
        self.g[:] = other.g
        self.slope[:] = other.slope
        self.largest[:] = other.largest

    def after_roots(self, held: Array, roots: NDArray[np.int32]) -> Array:
        """Return what the relations are held at after the solver has found roots.

        Args:
            held: What they were held at, shape ``(n,)``.
            roots: 1 rising, -1 falling, 0 for none, shape ``(r,)``.
        """
        new = held.copy()
        signs = roots.tolist()
        for root in (k for k, sign in enumerate(signs) if sign):
            k = int(self.relations.root_relation[root])
            rising = signs[root] > 0
            if self.relations.kind[k] == FLOOR:
                new[k] += 1.0 if rising else -1.0
            else:
                new[k] = 1.0 if rising else 0.0
        return new
