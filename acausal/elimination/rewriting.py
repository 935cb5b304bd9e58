"""Bring families into step with what is known about their variables.

Members of a family whose variables changed sign, became zero or became the same variable get
another template: the family is split by pattern, and each pattern's template is specialised once.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from acausal.elimination.families import variable_slots
from acausal.elimination.linear_form import tidied
from acausal.elimination.signed_components import Signs
from acausal.expressions.build import neg
from acausal.expressions.nodes import ZERO, Expr, slot
from acausal.expressions.traverse import substitute
from acausal.flattening.members import merge_families, partition, renumbered, take_members
from acausal.flattening.model import EquationFamily, Ids, Operand


def rewritten(
    families: Iterable[EquationFamily], representative: Ids, sign: Signs
) -> tuple[EquationFamily, ...]:
    """Return the families with every variable replaced by ``sign * representative``."""
    result: list[EquationFamily] = []
    for family in families:
        result += _rewritten(family, representative, sign)
    return merge_families(result)


def _rewritten(family: EquationFamily, representative: Ids, sign: Signs) -> list[EquationFamily]:
    slots = variable_slots(family)
    if not slots:
        return [family]
    changed = False
    operands = family.operands.copy()
    patterned: list[int] = []
    keys: list[Signs] = []
    for j in slots:
        ids = family.operands[j]
        operands[j] = representative[ids]
        signs = sign[ids]
        if (signs != 1).any():
            patterned.append(j)
            keys.append(signs)
        changed = changed or bool(patterned) or not np.array_equal(operands[j], ids)
    if not changed:
        return [family]
    family = replace(family, operands=operands)
    if not patterned:
        return split_duplicates(family)
    result: list[EquationFamily] = []
    for members in partition([key + 1 for key in keys], [3] * len(keys)):
        mapping: dict[Expr, Expr] = {}
        for j, key in zip(patterned, keys, strict=True):
            if key[members[0]] == 0:
                mapping[slot(j)] = ZERO
            elif key[members[0]] < 0:
                mapping[slot(j)] = neg(slot(j))
        part = take_members(family, members)
        if mapping:
            part = renumbered(part, tidied(substitute(part.template, mapping)))
        result += split_duplicates(part)
    return result


def _told_apart(operands: Ids, kinds: Ids) -> Ids:
    """Return ids of parameters and variables, which are numbered apart, as different numbers."""
    ids: Ids = 2 * operands + (kinds == Operand.PARAMETER)[:, None]
    return ids


def split_duplicates(family: EquationFamily) -> list[EquationFamily]:
    """Split off the members in which two slots hold the same id, and specialise them."""
    kinds = np.array([int(kind) for kind in family.kinds], dtype=np.int64)
    m = len(family.kinds)
    if m < 2 or family.count == 0:
        return [family]
    if m <= 8:
        twice = np.zeros(family.count, dtype=np.bool_)
        for j in range(1, m):
            for i in range(j):
                if kinds[i] == kinds[j]:
                    twice |= family.operands[i] == family.operands[j]
    else:
        ordered = np.sort(_told_apart(family.operands, kinds), axis=0)
        twice = (ordered[1:] == ordered[:-1]).any(axis=0)
    if not twice.any():
        return [family]
    result: list[EquationFamily] = []
    single = np.flatnonzero(~twice)
    if single.shape[0]:
        result.append(take_members(family, single))
    members = np.flatnonzero(twice)
    chosen = _told_apart(family.operands[:, members], kinds)
    first = np.empty((m, members.shape[0]), dtype=np.int64)
    first[0] = 0
    for j in range(1, m):
        first[j] = np.argmax(chosen[: j + 1] == chosen[j], axis=0)
    for group in partition(list(first), [m] * m):
        pattern = first[:, group[0]].tolist()
        mapping = {slot(j): slot(i) for j, i in enumerate(pattern) if i != j}
        part = take_members(family, members[group])
        result.append(renumbered(part, tidied(substitute(part.template, mapping))))
    return result
