"""Members of equation families: choose some, rename slots, merge equal templates.

Everything here is linear in the number of members and treats a template once.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from acausal.expressions.nodes import Expr, slot
from acausal.expressions.traverse import slots, substitute
from acausal.flattening.model import EquationFamily, Ids, Operand, Origin

Integer = TypeVar("Integer", bound=np.integer)


def take_origins(origins: Sequence[Origin], members: Ids) -> tuple[Origin, ...]:
    """Return the origins of the chosen members.

    Args:
        origins: Runs covering all members of a family, in order.
        members: Chosen members, ascending, shape ``(k,)``.
    """
    if not origins:
        return ()
    firsts = np.array([origin.first for origin in origins], dtype=np.int64)
    counts = np.array([origin.count for origin in origins], dtype=np.int64)
    low = np.searchsorted(members, firsts)
    high = np.searchsorted(members, firsts + counts)
    taken: list[Origin] = []
    for index in np.flatnonzero(high > low).tolist():
        origin, start, stop = origins[index], int(low[index]), int(high[index])
        if stop - start == origin.count:
            taken.append(replace(origin, first=start))
            continue
        chosen = origin.instances[members[start:stop] - origin.first]
        taken.append(replace(origin, first=start, count=stop - start, instances=chosen))
    return tuple(taken)


def join_origins(parts: Iterable[EquationFamily]) -> tuple[Origin, ...]:
    """Return the origins of families laid end to end.

    Runs of one equation of one group that follow each other become one run.
    """
    joined: list[list[Origin]] = []
    offset = 0
    for part in parts:
        for origin in part.origins:
            shifted = replace(origin, first=origin.first + offset)
            if joined and _same_source(joined[-1][0], origin):
                joined[-1].append(shifted)
            else:
                joined.append([shifted])
        offset += part.count
    return tuple(
        run[0]
        if len(run) == 1
        else replace(
            run[0],
            count=sum(origin.count for origin in run),
            instances=np.concatenate([origin.instances for origin in run]),
        )
        for run in joined
    )


def _same_source(a: Origin, b: Origin) -> bool:
    return (
        a.group == b.group
        and a.kind == b.kind
        and a.span == b.span
        and a.text == b.text
        and a.class_name == b.class_name
    )


def take_members(family: EquationFamily, members: Ids) -> EquationFamily:
    """Return the family of the chosen members (ascending, shape ``(k,)``)."""
    if members.shape[0] == family.count:
        return family
    return EquationFamily(
        family.template,
        family.kinds,
        np.ascontiguousarray(family.operands[:, members]),
        family.rows[members],
        take_origins(family.origins, members),
    )


def renumbered(family: EquationFamily, template: Expr) -> EquationFamily:
    """Return ``family`` with another template over its slots, the slots numbered anew.

    Slots that the new template does not use are dropped; the others are numbered in the order
    of their first appearance, so that equal equations get equal templates.
    """
    order = [int(key) for key in slots(template)]  # type: ignore[call-overload]
    if order == list(range(len(family.kinds))):
        return replace(family, template=template) if template is not family.template else family
    renamed = substitute(template, {slot(old): slot(new) for new, old in enumerate(order)})
    return EquationFamily(
        renamed,
        tuple(family.kinds[old] for old in order),
        np.ascontiguousarray(family.operands[order, :]),
        family.rows,
        family.origins,
    )


def merge_families(families: Iterable[EquationFamily]) -> tuple[EquationFamily, ...]:
    """Return families of which no two have the same template; empty ones are dropped.

    The order is that of the first family with each template; members keep their order.
    """
    groups: dict[tuple[Expr, tuple[Operand, ...]], list[EquationFamily]] = {}
    for family in families:
        if family.count:
            groups.setdefault((family.template, family.kinds), []).append(family)
    return tuple(
        parts[0]
        if len(parts) == 1
        else EquationFamily(
            template,
            kinds,
            np.concatenate([part.operands for part in parts], axis=1),
            np.concatenate([part.rows for part in parts]),
            join_origins(parts),
        )
        for (template, kinds), parts in groups.items()
    )


def sorted_unique(values: NDArray[Integer]) -> NDArray[Integer]:
    """Return the different values, ascending.

    By sorting: the hash table of ``numpy.unique`` is slow on regular integers.
    """
    ordered = np.sort(values)
    keep = np.ones(ordered.shape[0], dtype=np.bool_)
    keep[1:] = ordered[1:] != ordered[:-1]
    return ordered[keep]


def partition(keys: Sequence[NDArray[np.integer]], bases: Sequence[int]) -> list[Ids]:
    """Return the members with equal keys, one ascending array per combination that occurs.

    Args:
        keys: Arrays of shape ``(count,)``; the values of ``keys[i]`` are ``0 .. bases[i]-1``.
        bases: Number of possible values of each key.

    Returns:
        Groups in the order of their combined key (first key most significant).
    """
    code = np.zeros(keys[0].shape[0], dtype=np.int64)
    size = 1
    for key, base in zip(keys, bases, strict=True):
        if size * base > 1 << 20:
            present, code = np.unique(code, return_inverse=True)
            size = present.shape[0]
        code = code * base + key
        size *= base
    small = size <= 1 << 20
    present = np.flatnonzero(np.bincount(code, minlength=1)) if small else sorted_unique(code)
    if present.shape[0] <= 8:
        return [np.flatnonzero(code == value) for value in present.tolist()]
    order = np.argsort(code, kind="stable")
    bounds = np.searchsorted(code[order], present[1:])
    return list(np.split(order, bounds))
