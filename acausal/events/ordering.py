"""The order in which discrete variables are evaluated.

Levels of the graph of dependencies (A. B. Kahn, "Topological sorting of large networks", Comm.
ACM 5, 1962): what depends on no other comes first, then what depends on that alone, and so on.
Each level costs a few array operations over its members.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from acausal.flattening.members import merge_families, partition, take_members
from acausal.flattening.model import EquationFamily, Ids, Operand


class DiscreteLoopError(Exception):
    """Discrete variables that depend on each other.

    Attributes:
        places: Held positions, each of which depends on the next and the last on the first.
    """

    def __init__(self, places: list[int]) -> None:
        super().__init__(places)
        self.places = places


def in_order(
    assignments: Iterable[EquationFamily],
    first: int,
    n_discrete: int,
    *,
    loops_allowed: bool = False,
) -> tuple[EquationFamily, ...]:
    """Return assignments in an order in which each comes after those it depends on.

    Args:
        assignments: ``rows`` holds held positions below ``n_discrete``, each at most once.
        first: Parameter id of held value 0.
        n_discrete: Number of positions.
        loops_allowed: Cut a loop somewhere instead of giving up: it is iterated over.

    Raises:
        DiscreteLoopError: If some depend on each other.
    """
    families = merge_families(assignments)
    sources, targets = _dependencies(families, first, n_discrete)
    level = _levels(sources, targets, n_discrete, loops_allowed)
    by_level: dict[int, list[EquationFamily]] = {}
    for family in families:
        own = level[family.rows]
        values, code = np.unique(own, return_inverse=True)
        for members in partition([code], [len(values)]):
            part = take_members(family, members)
            by_level.setdefault(int(own[members[0]]), []).append(part)
    return tuple(part for number in sorted(by_level) for part in by_level[number])


def _dependencies(
    families: Iterable[EquationFamily], first: int, n_discrete: int
) -> tuple[Ids, Ids]:
    """Return pairs of held positions of which the second is computed from the first."""
    sources, targets = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    for family in families:
        for kind, ids in zip(family.kinds, family.operands, strict=True):
            if kind == Operand.PARAMETER:
                here = np.flatnonzero((ids >= first) & (ids < first + n_discrete))
                sources.append(ids[here] - first)
                targets.append(family.rows[here])
    return np.concatenate(sources), np.concatenate(targets)


def _levels(sources: Ids, targets: Ids, n: int, loops_allowed: bool) -> Ids:
    order = np.argsort(sources, kind="stable")
    heads = targets[order]
    pointer = np.searchsorted(sources[order], np.arange(n + 1))
    waiting = np.bincount(targets, minlength=n)
    level = np.full(n, -1, np.int64)
    ready = np.flatnonzero(waiting == 0)
    number = 0
    while True:
        while len(ready):
            level[ready] = number
            number += 1
            following = heads[_ranges(pointer[ready], pointer[ready + 1])]
            np.subtract.at(waiting, following, 1)
            following = np.unique(following)
            ready = following[(waiting[following] == 0) & (level[following] < 0)]
        left = level < 0
        if not left.any():
            return level
        if not loops_allowed:
            raise DiscreteLoopError(_cycle(sources, targets, left))
        ready = np.flatnonzero(left)[:1]


def _ranges(begin: Ids, end: Ids) -> Ids:
    """Return the numbers ``begin[0] .. end[0]-1, begin[1] .. end[1]-1, ...``."""
    sizes = end - begin
    total = int(sizes.sum())
    offset = np.repeat(begin - np.concatenate([[0], np.cumsum(sizes)[:-1]]), sizes)
    return offset + np.arange(total)


def _cycle(sources: Ids, targets: Ids, left: NDArray[np.bool_]) -> list[int]:
    """Return a circle among the nodes that are left; each of them waits for another."""
    inside = left[sources] & left[targets]
    before = dict(zip(targets[inside][::-1].tolist(), sources[inside][::-1].tolist(), strict=True))
    node = int(np.flatnonzero(left)[0])
    seen: dict[int, int] = {}
    path: list[int] = []
    while node not in seen:
        seen[node] = len(path)
        path.append(node)
        node = before[node]
    return path[seen[node] :]
