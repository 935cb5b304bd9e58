"""Many instances or scalars by where they are declared: a place is a path without its subscripts.

``line.section[1].r.v .. line.section[1000].r.v`` are one place, ``line.section[].r.v``, and a
column of subscripts. The number of places is that of the declarations of a model, not of its
instances, so that a million instances are sorted, named and counted with a few array operations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from acausal.instantiation.numbering import Ids, Numbering, VariableBlock


@dataclass(frozen=True)
class Place:
    """Members of a list of ids that are declared in the same place.

    Attributes:
        steps: Names from the model down, each with its number of array dimensions.
        subscripts: Subscripts from 1 of all steps, shape ``(dimensions, members)``.
        members: Where the members stand in the list, ascending.
        order: Order of the time derivative.
    """

    steps: tuple[tuple[str, int], ...]
    subscripts: Ids
    members: Ids
    order: int = 0

    @property
    def key(self) -> tuple[tuple[tuple[str, int], ...], int]:
        """What tells places apart."""
        return self.steps, self.order

    def paths(self) -> list[str]:
        """Return the path of every member."""
        pattern = path_text(self.steps, ["%d"] * len(self.subscripts), self.order)
        if not len(self.subscripts):
            return [pattern] * len(self.members)
        return [pattern % row for row in zip(*self.subscripts.tolist(), strict=True)]


def path_text(steps: Sequence[tuple[str, int]], subscripts: Sequence[str], order: int = 0) -> str:
    """Return a path with the given subscripts, in ``der(...)`` as often as ``order`` says."""
    free = iter(subscripts)
    parts = []
    for name, dimensions in steps:
        own = ",".join(next(free) for _ in range(dimensions))
        parts.append(f"{name}[{own}]" if dimensions else name)
    return "der(" * order + ".".join(parts) + ")" * order


def instance_places(numbering: Numbering, group: int, instances: Ids) -> list[Place]:
    """Sort instances of a group by place, in the order in which places first occur.

    Args:
        numbering: The numbering of the model.
        group: Number of the group.
        instances: Numbers in the group, shape ``(n,)``.
    """
    root = len(numbering.groups) - 1
    found: list[Place] = []
    # Worklist: group, instances there, members, steps and subscript rows below.
    Work = tuple[int, Ids, Ids, tuple[tuple[str, int], ...], tuple[Ids, ...]]
    work: list[Work] = [(group, instances, np.arange(len(instances)), (), ())]
    while work:
        number, here, members, steps, rows = work.pop()
        if not len(here):
            continue
        if number == root:
            table = np.stack(rows) if rows else np.zeros((0, len(members)), np.int64)
            found.append(Place(steps, table, members))
            continue
        blocks = numbering.groups[number].blocks
        which = np.searchsorted(np.array([b.first for b in blocks]), here, "right") - 1
        for k, chosen in _parts(which):
            block = blocks[k]
            owner, place = np.divmod(here[chosen] - block.first, block.size)
            below = tuple(row[chosen] for row in rows)
            own = _subscripts(place, block.shape)
            work.append(
                (
                    block.owner,
                    owner,
                    members[chosen],
                    ((block.name, len(block.shape)), *steps),
                    own + below,
                )
            )
    return sorted(found, key=lambda p: int(p.members[0]))


def variable_places(numbering: Numbering, ids: Ids) -> list[Place]:
    """Sort variable ids by place, in the order in which places first occur."""
    return _scalar_places(numbering, numbering.variables, ids)


def parameter_places(numbering: Numbering, ids: Ids) -> list[Place]:
    """Sort ids of declared parameters by place, in the order in which places first occur."""
    return _scalar_places(numbering, numbering.parameters, ids)


def _scalar_places(numbering: Numbering, blocks: Sequence[VariableBlock], ids: Ids) -> list[Place]:
    if not len(ids):
        return []
    # Empty blocks share their first id with the next one: the last of equals is meant.
    which = np.searchsorted(np.array([b.first for b in blocks]), ids, "right") - 1
    found: list[Place] = []
    for k, chosen in _parts(which):
        block = blocks[k]
        declaration = block.declaration
        instance, scalar = np.divmod(ids[chosen] - block.first, declaration.size)
        leaf = ((declaration.name, len(declaration.shape)),) if declaration.name else ()
        own = _subscripts(scalar, declaration.shape)
        for place in instance_places(numbering, block.group, instance):
            rows = [place.subscripts, *(axis[None, place.members] for axis in own)]
            found.append(
                Place(
                    (*place.steps, *leaf),
                    np.concatenate(rows),
                    chosen[place.members],
                    block.order,
                )
            )
    return sorted(found, key=lambda p: int(p.members[0]))


def _subscripts(place: Ids, shape: tuple[int, ...]) -> tuple[Ids, ...]:
    """Return subscripts from 1 for row-major places."""
    return tuple(axis + 1 for axis in np.unravel_index(place, shape)) if shape else ()


def _parts(labels: Ids) -> list[tuple[int, Ids]]:
    """Return each label with the positions where it stands, ascending."""
    if (labels == labels[0]).all():
        return [(int(labels[0]), np.arange(len(labels)))]
    order = np.argsort(labels, kind="stable")
    inside = labels[order]
    bounds = np.concatenate([[0], np.flatnonzero(np.diff(inside)) + 1, [len(labels)]])
    return [(int(inside[a]), order[a:b]) for a, b in pairwise(bounds.tolist())]
