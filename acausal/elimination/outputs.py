"""Pure outputs: variables that nothing else uses are computed when asked for.

Such a variable and the row that gives it are no part of the system: the current of a ground, the
power of a resistor. A junction row can be such a row as well; its definition is then a sum over
several families. What defines an output may leave another variable without a use, so sweeps are
repeated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.elimination.alias_rows import bare_coefficient, without_rows
from acausal.elimination.families import (
    merge_families,
    partition,
    renumbered,
    take_members,
    variable_slots,
)
from acausal.elimination.linear_form import tidied
from acausal.elimination.locals import solution
from acausal.expressions.build import mul
from acausal.expressions.nodes import const
from acausal.flattening.model import EquationFamily, Ids

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Sweep:
    """What is left, and what was taken out.

    Attributes:
        families: The remaining families.
        definitions: Families of the definitions; ``rows`` holds variables, and the
            contributions to one variable add up.
        defined: The variables, ascending.
        rows: The rows that were taken out.
    """

    families: tuple[EquationFamily, ...]
    definitions: tuple[EquationFamily, ...]
    defined: Ids
    rows: Ids


def sweep_outputs(
    families: Sequence[EquationFamily],
    counts: Ids,
    uses: Ids,
    blocked: Mask,
    no_sums: Mask,
) -> Sweep | None:
    """Take out the rows that define variables used nowhere else; None if there are none.

    Args:
        families: Families of the model.
        counts: Number of contributions to each row.
        uses: Number of member slots that refer to each variable.
        blocked: Variables that must stay.
        no_sums: Variables that must have a definition of one term.
    """
    defines = np.full(counts.shape[0], -1, dtype=np.int64)
    scale = np.ones(counts.shape[0])
    output = (uses == 1) & ~blocked
    definitions: list[EquationFamily] = []
    for family in families:
        for j in variable_slots(family):
            hit = output[family.operands[j]]
            if not hit.any():
                continue
            value = solution(family.template, j)
            if value is None:
                continue
            single = np.flatnonzero(
                hit & (counts[family.rows] == 1) & (defines[family.rows] < 0)
            )
            if single.shape[0]:
                part = take_members(family, single)
                x = part.operands[j]
                defines[part.rows] = x
                named = EquationFamily(part.template, part.kinds, part.operands, x, part.origins)
                definitions.append(renumbered(named, value))
        coefficient = bare_coefficient(family)
        if coefficient is None:
            continue
        x = family.operands[0]
        shared = output[x] & ~no_sums[x] & (counts[family.rows] > 1) & (defines[family.rows] < 0)
        members = np.flatnonzero(shared)
        _, first = np.unique(family.rows[members], return_index=True)
        members = np.sort(members[first])
        defines[family.rows[members]] = x[members]
        scale[family.rows[members]] = -1.0 / coefficient
    rows = np.flatnonzero(defines >= 0)
    if rows.shape[0] == 0:
        return None
    if (counts[rows] > 1).any():
        for family in families:
            definitions += _terms(family, counts, defines, scale)
    removed = defines >= 0
    return Sweep(
        without_rows(families, removed),
        merge_families(definitions),
        np.sort(defines[rows]),
        rows,
    )


def _terms(family: EquationFamily, counts: Ids, defines: Ids, scale: NDArray[np.float64]) -> list[
    EquationFamily
]:
    """Return the terms that a family contributes to the definitions by sums."""
    mine = (defines[family.rows] >= 0) & (counts[family.rows] > 1)
    if bare_coefficient(family) is not None:
        mine &= family.operands[0] != defines[family.rows]
    members = np.flatnonzero(mine)
    if members.shape[0] == 0:
        return []
    part = take_members(family, members)
    values, code = np.unique(scale[part.rows], return_inverse=True)
    result: list[EquationFamily] = []
    for group in partition([code], [values.shape[0]]):
        term = take_members(part, group)
        named = EquationFamily(
            term.template, term.kinds, term.operands, defines[term.rows], term.origins
        )
        factor = const(float(values[code[group[0]]]))
        result.append(renumbered(named, tidied(mul(factor, term.template))))
    return result
