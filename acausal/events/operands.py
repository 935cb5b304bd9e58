"""Operands that are held become parameters; families split where only some members' are."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from acausal.events.layout import Layout
from acausal.flattening.members import merge_families, partition, take_members
from acausal.flattening.model import EquationFamily, Operand


def held_operands(families: Iterable[EquationFamily], layout: Layout) -> tuple[EquationFamily, ...]:
    """Return families whose operands are continuous variables and parameters only.

    Members of a family may be split by which of their operands are discrete; ``rows`` tell them
    apart afterwards.
    """
    result: list[EquationFamily] = []
    for family in families:
        result += held_parts(family, layout)
    return merge_families(result)


def held_parts(family: EquationFamily, layout: Layout) -> list[EquationFamily]:
    """Return the parts of one family, see :func:`held_operands`."""
    if all(kind == Operand.PARAMETER for kind in family.kinds):
        return [family]
    operands = family.operands
    kinds = list(family.kinds)
    held = operands.copy()
    mixed: list[int] = []
    for j, kind in enumerate(family.kinds):
        ids = operands[j]
        if kind == Operand.PARAMETER:
            continue
        if kind == Operand.VARIABLE:
            discrete = layout.place[ids] >= 0
            if not discrete.any():
                continue
            held[j] = np.where(discrete, layout.first + layout.place[ids], ids)
            if not discrete.all():
                mixed.append(j)
                continue
        elif kind == Operand.PRE:
            place = layout.place[ids]
            before = np.where(place >= 0, place + layout.n_discrete, layout.limit[ids])
            held[j] = layout.first + before
        else:
            table = layout.signal if kind == Operand.SIGNAL else layout.pre_signal
            held[j] = layout.first + table[ids]
        kinds[j] = Operand.PARAMETER
    if not mixed:
        if tuple(kinds) == family.kinds:
            return [family]
        return [replace(family, kinds=tuple(kinds), operands=held)]
    keys = [(layout.place[operands[j]] >= 0).astype(np.int64) for j in mixed]
    whole = replace(family, operands=held)
    parts: list[EquationFamily] = []
    for members in partition(keys, [2] * len(keys)):
        for j, key in zip(mixed, keys, strict=True):
            kinds[j] = Operand.PARAMETER if key[members[0]] else Operand.VARIABLE
        parts.append(replace(take_members(whole, members), kinds=tuple(kinds)))
    return parts
