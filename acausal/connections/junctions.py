"""Connection sets by union-find over all cuts at once (Modelica 3.6, section 9.2).

Every cut has two faces: the outer one, seen by the class that owns the component, and the inner
one, seen from inside the component. Faces joined by connect equations make a junction, where the
through variables of outer faces, minus those of inner faces, add up to zero. Across variables do
not know faces: they are equal over everything that is joined on either side. A cut whose outer face
is joined to nothing carries nothing.

Complexity: a few array operations over cuts and connections, see
:mod:`acausal.connections.components`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.connections.components import connected_components
from acausal.diagnostics import fail
from acausal.instantiation.connects import cut_leaves
from acausal.instantiation.numbering import Ids, Numbering
from acausal.instantiation.template import ConnectDecl, Domain, Ref, Step, Template
from acausal.instantiation.values import indices

Leaf = tuple[tuple[str, ...], int, bool]


@dataclass(frozen=True)
class Interface:
    """Cuts with the same variables.

    Attributes:
        leaves: Path, number of scalars and through flag of each variable.
        ids: Variable ids by leaf, each of shape ``(cuts, size)``; rows of other interfaces
            are -1.
    """

    leaves: tuple[Leaf, ...]
    ids: tuple[Ids, ...]


@dataclass(frozen=True)
class Junctions:
    """All cuts of a model and how they are joined.

    Attributes:
        group: Group of each cut, shape ``(cuts,)``.
        instance: Its number in the group.
        interface: Its interface.
        interfaces: The interfaces.
        node: Label of the across node of each cut, shape ``(cuts,)``.
        junction: Label of the junction of each face, shape ``(2 * cuts,)``; even: outer.
        edges: Joined faces, shape ``(connections, 2)``.
    """

    group: Ids
    instance: Ids
    interface: Ids
    interfaces: tuple[Interface, ...]
    node: Ids
    junction: Ids
    edges: Ids

    @property
    def count(self) -> int:
        """Number of cuts."""
        return int(self.group.shape[0])


def find_junctions(numbering: Numbering) -> Junctions:
    """Return the cuts of a model and how they are joined.

    Raises:
        AcausalError: ``T114`` for a subscript out of range in a connect equation.
    """
    offsets: dict[int, int] = {}
    total = 0
    groups, instances = [], []
    for group in numbering.groups:
        if group.template.is_connector and group.count:
            offsets[group.template.number] = total
            total += group.count
            groups.append(np.full(group.count, group.template.number))
            instances.append(np.arange(group.count))
    group_of = np.concatenate(groups) if groups else np.zeros(0, np.int64)
    instance_of = np.concatenate(instances) if instances else np.zeros(0, np.int64)
    edges = _edges(numbering, offsets)
    count, junction = connected_components(edges[:, 0], edges[:, 1], 2 * total)
    # Both faces of a cut belong to one node.
    node = connected_components(junction[::2], junction[1::2], count)[1][junction[::2]]
    interface, interfaces = _interfaces(numbering, offsets, total)
    nested = _nested(numbering, offsets, total)
    interface[nested] = -1
    return Junctions(group_of, instance_of, interface, interfaces, node, junction, edges)


def _edges(numbering: Numbering, offsets: dict[int, int]) -> Ids:
    found: list[Ids] = []
    # Connections between components declared one by one, as plain numbers: many times faster.
    single: list[tuple[int, int]] = []
    for group in numbering.groups:
        if not group.count:
            continue
        for connect in group.template.connects:
            if not connect.domain.names:
                ends_ = _single_ends(numbering, group.template, connect, offsets)
                if ends_ is not None:
                    single += [(ends_[0], other) for other in ends_[1:]]
                    continue
            size = (group.count, connect.domain.length)
            ends = []
            for cut in connect.cuts:
                try:
                    template, here = numbering.instances(
                        group.template, cut.path, cut.outer, connect.domain
                    )
                except IndexError as error:
                    index, n = error.args
                    fail("T114", f"subscript {index} is outside 1..{n}", connect.span,
                         help=f"the array has {n} elements; "
                         "check the range of the loop")  # fmt: skip
                ends.append(2 * (offsets[template.number] + here) + int(cut.inner_face))
            if size == (1, 1):
                first, *others = (int(end[0, 0]) for end in ends)
                single += [(first, other) for other in others]
                continue
            if single:
                found.append(np.array(single, np.int64))
                single = []
            faces = [np.broadcast_to(end, size).reshape(-1) for end in ends]
            found += [np.stack([faces[0], other], axis=1) for other in faces[1:]]
    if single:
        found.append(np.array(single, np.int64))
    return np.concatenate(found) if found else np.zeros((0, 2), np.int64)


def _single_ends(
    numbering: Numbering, template: Template, connect: ConnectDecl, offsets: dict[int, int]
) -> list[int] | None:
    """Return the faces that a connection joins, if each is one by itself; None otherwise."""
    result: list[int] = []
    for cut in connect.cuts:
        found = None if cut.outer else numbering.single_instance(template, cut.path)
        if found is None:
            return None
        result.append(2 * (offsets[found[0].number] + found[1]) + cut.inner_face)
    return result


def _interfaces(
    numbering: Numbering, offsets: dict[int, int], total: int
) -> tuple[Ids, tuple[Interface, ...]]:
    by_leaves: dict[tuple[Leaf, ...], int] = {}
    arrays: list[list[Ids]] = []
    interface = np.full(total, -1, np.int64)
    for number, offset in offsets.items():
        group = numbering.groups[number]
        leaves = tuple(
            sorted((path, size, through) for path, size, through, _ in cut_leaves(group.template))
        )
        if leaves not in by_leaves:
            by_leaves[leaves] = len(arrays)
            arrays.append([np.full((total, size), -1, np.int64) for _, size, _ in leaves])
        which = by_leaves[leaves]
        interface[offset : offset + group.count] = which
        for place, (path, _, _) in enumerate(leaves):
            arrays[which][place][offset : offset + group.count] = leaf_ids(
                numbering, group.template, path
            )
    return interface, tuple(Interface(leaves, tuple(arrays[k])) for leaves, k in by_leaves.items())


def leaf_ids(numbering: Numbering, template: Template, path: tuple[str, ...]) -> Ids:
    """Return the ids of one variable of a cut, shape ``(instances, scalars)``."""
    shape: tuple[int, ...] = ()
    where = template
    for name in path[:-1]:
        child = where.children[name]
        shape += child.shape
        where = child.template
    declaration = where.variables[path[-1]]
    columns = []
    for index in indices(shape + declaration.shape):
        free = iter(index)
        steps = []
        inside = template
        for name in path[:-1]:
            child = inside.children[name]
            steps.append(Step(name, tuple(next(free) for _ in child.shape)))
            inside = child.template
        ref = Ref(tuple(steps), path[-1], tuple(free))
        columns.append(numbering.ids(template, ref, Domain()))
    return np.stack(columns, axis=1) if columns else np.zeros((0, 0), np.int64)


def _nested(numbering: Numbering, offsets: dict[int, int], total: int) -> NDArray[np.bool_]:
    """Mark connectors inside connectors: they are parts of a cut, not cuts."""
    result = np.zeros(total, np.bool_)
    for number, offset in offsets.items():
        for block in numbering.groups[number].blocks:
            owner = numbering.groups[block.owner]
            if owner.template.is_connector:
                first = offset + block.first
                result[first : first + owner.count * block.size] = True
    return result
