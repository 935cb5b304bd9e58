"""Pure outputs: variables that nothing else uses are computed when asked for.

Such a variable and the row that gives it are no part of the system: the current of a ground, the
power of a resistor. A junction row can be such a row as well; its definition is then a sum over
several families. What defines an output may leave another variable without a use, so sweeps are
repeated.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.elimination.alias_rows import bare_coefficient, without_rows
from acausal.elimination.families import Tally, variable_slots
from acausal.elimination.linear_form import tidied
from acausal.elimination.locals import solution
from acausal.expressions.build import mul
from acausal.expressions.nodes import Expr, const
from acausal.flattening.members import merge_families, partition, renumbered, take_members
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
    counts: Tally,
    uses: Tally,
    blocked: Mask,
    no_sums: Mask,
    derivatives: Mask,
) -> Sweep | None:
    """Take out the rows that define variables used nowhere else; None if there are none.

    Args:
        families: Families of the model.
        counts: Number of contributions to each row.
        uses: Number of member slots that refer to each variable.
        blocked: Variables that must stay.
        no_sums: Variables that must have a definition of one term.
        derivatives: Which variables are derivatives of others. A row stays if it is needed
            for one of them: a derivative in no row would be nothing that has to be found.
    """
    defines = np.full(counts.shape[0], -1, dtype=np.int64)
    scale = np.ones(counts.shape[0])
    output = (uses == 1) & ~blocked
    for family in families:
        for j in variable_slots(family):
            hit = output[family.operands[j]] & (defines[family.rows] < 0)
            if not hit.any() or _value(family, j) is None:
                continue
            single = np.flatnonzero(hit & (counts[family.rows] == 1))
            defines[family.rows[single]] = family.operands[j, single]
        coefficient = bare_coefficient(family)
        if coefficient is None:
            continue
        x = family.operands[0]
        shared = output[x] & ~no_sums[x] & (counts[family.rows] > 1) & (defines[family.rows] < 0)
        members = np.flatnonzero(shared)
        _, first = np.unique(family.rows[members], return_index=True)
        members = members[np.sort(first)]
        defines[family.rows[members]] = x[members]
        scale[family.rows[members]] = -1.0 / coefficient
    _keep_derivatives(families, defines, uses, derivatives)
    rows = np.flatnonzero(defines >= 0)
    if rows.shape[0] == 0:
        return None
    definitions: list[EquationFamily] = []
    for family in families:
        definitions += _values(family, counts, defines)
        if (counts[rows] > 1).any():
            definitions += _terms(family, counts, defines, scale)
    return Sweep(
        without_rows(families, defines >= 0),
        merge_families(definitions),
        np.sort(defines[rows]),
        rows,
    )


def _value(family: EquationFamily, j: int) -> Expr | None:
    """Return ``f`` with ``slot(j) = f``; it is put into nothing, so it may be large."""
    solved = solution(family.template, j, frozenset(), sys.maxsize)
    return None if solved is None else solved[0]


def _keep_derivatives(
    families: Sequence[EquationFamily], defines: Ids, uses: Tally, derivatives: Mask
) -> None:
    """Take back the choice of rows without which a derivative would be in no row."""
    if not derivatives.any():
        return
    gone = np.zeros(uses.shape[0], dtype=np.int32)
    touched: list[tuple[EquationFamily, int, Ids]] = []
    for family in families:
        members = np.flatnonzero(defines[family.rows] >= 0)
        if members.shape[0] == 0:
            continue
        for j in variable_slots(family):
            of = members[derivatives[family.operands[j, members]]]
            np.add.at(gone, family.operands[j, of], np.int32(1))
            touched.append((family, j, of))
    for family, j, of in touched:
        x = family.operands[j, of]
        defines[family.rows[of[gone[x] == uses[x]]]] = -1


def _values(family: EquationFamily, counts: Tally, defines: Ids) -> list[EquationFamily]:
    """Return the definitions that single rows of a family give."""
    rest = np.flatnonzero((defines[family.rows] >= 0) & (counts[family.rows] == 1))
    result: list[EquationFamily] = []
    for j in variable_slots(family):
        mine = family.operands[j, rest] == defines[family.rows[rest]]
        value = _value(family, j) if mine.any() else None
        if value is None:
            continue
        part = take_members(family, rest[mine])
        rest = rest[~mine]
        named = EquationFamily(
            part.template, part.kinds, part.operands, part.operands[j], part.origins
        )
        result.append(renumbered(named, value))
    return result


def _terms(
    family: EquationFamily, counts: Tally, defines: Ids, scale: NDArray[np.float64]
) -> list[EquationFamily]:
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
