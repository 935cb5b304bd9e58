"""Find the rows that say ``a = b``, ``a = -b`` or ``x = 0``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from acausal.elimination.alias_classes import AliasRows
from acausal.elimination.families import Tally, keep_rows
from acausal.elimination.linear_form import LinearForm, linear_form
from acausal.elimination.signed_components import Nodes
from acausal.expressions.build import mul
from acausal.expressions.nodes import ZERO, const, slot
from acausal.flattening.members import merge_families, sorted_unique, take_members
from acausal.flattening.model import EquationFamily, Ids, Operand


def variable_form(family: EquationFamily) -> LinearForm | None:
    """Return the linear form of a family if it has variables only and no constant."""
    form = linear_form(family.template)
    if form is None or form.constant != 0.0:
        return None
    if any(family.kinds[j] != Operand.VARIABLE for j in form.coefficients):
        return None
    return form


def bare_coefficient(family: EquationFamily) -> float | None:
    """Return ``c`` if the contribution of the family is ``c * x``, else None."""
    form = variable_form(family)
    if form is None or len(form.coefficients) != 1:
        return None
    return next(iter(form.coefficients.values()))


def alias_rows(families: Sequence[EquationFamily], counts: Tally) -> AliasRows:
    """Return all rows that make two variables equal up to sign, or one zero.

    Args:
        families: Families of the model; junction rows have one member per contribution.
        counts: Number of contributions to each row.
    """
    rows: list[Ids] = []
    first: list[Ids] = []
    second: list[Ids] = []
    signs: list[NDArray[np.int8]] = []
    bare: list[tuple[Ids, Ids, float]] = []

    def found(row: Ids, a: Ids, b: Ids, sign: NDArray[np.int8]) -> None:
        rows.append(row)
        first.append(a)
        second.append(b)
        signs.append(sign)

    for family in families:
        form = variable_form(family)
        if form is None or not 1 <= len(form.coefficients) <= 2:
            continue
        slots, coefficients = list(form.coefficients), list(form.coefficients.values())
        if len(slots) == 2 and abs(coefficients[0]) != abs(coefficients[1]):
            continue
        shared = counts[family.rows]
        single = shared == 1
        a, b = family.operands[slots[0]], family.operands[slots[-1]]
        equal = coefficients[0] == coefficients[-1]
        if single.all():
            found(family.rows, a, b, np.full(family.count, -1 if equal else 1, dtype=np.int8))
            continue
        some = np.flatnonzero(single)
        same = np.full(some.shape[0], -1 if equal else 1, dtype=np.int8)
        found(family.rows[some], a[some], b[some], same)
        if len(slots) == 1:
            pair = np.flatnonzero(shared == 2)
            bare.append((family.rows[pair], a[pair], coefficients[0]))
    if bare:
        found(*_pairs(bare))
    nothing = np.zeros(0, dtype=np.int64)

    def joined(parts: list[Ids]) -> Nodes:
        return np.concatenate([*parts, nothing], dtype=np.int32, casting="same_kind")

    return AliasRows(
        joined(rows),
        joined(first),
        joined(second),
        np.concatenate([*signs, nothing], dtype=np.int8, casting="same_kind"),
    )


def _pairs(bare: list[tuple[Ids, Ids, float]]) -> tuple[Ids, Ids, Ids, NDArray[np.int8]]:
    """Return the rows whose two contributions are both ``c * x`` with equal ``abs(c)``."""
    row = np.concatenate([item[0] for item in bare])
    variable = np.concatenate([item[1] for item in bare])
    coefficient = np.concatenate([np.full(item[0].shape[0], item[2]) for item in bare])
    order = np.argsort(row, kind="stable")
    row, variable, coefficient = row[order], variable[order], coefficient[order]
    head = np.flatnonzero(row[1:] == row[:-1])
    head = head[np.abs(coefficient[head]) == np.abs(coefficient[head + 1])]
    sign = np.where(coefficient[head] == coefficient[head + 1], -1, 1).astype(np.int8)
    return row[head], variable[head], variable[head + 1], sign


def combined_contributions(
    families: Sequence[EquationFamily], counts: Tally, n_variables: int
) -> tuple[EquationFamily, ...]:
    """Return families in which no row has two bare contributions of the same variable.

    After aliases are merged a through variable may enter and leave the same junction; what
    cancels must not look like a dependence.
    """
    bare: list[tuple[int, Ids, float]] = []
    for index, family in enumerate(families):
        coefficient = bare_coefficient(family)
        if coefficient is not None:
            members = np.flatnonzero(counts[family.rows] > 1)
            if members.shape[0]:
                bare.append((index, members, coefficient))
    if not bare:
        return tuple(families)
    key = np.concatenate(
        [
            families[i].rows[m] * np.int64(n_variables) + families[i].operands[0, m]
            for i, m, _ in bare
        ]
    )
    ordered = np.sort(key)
    repeated = sorted_unique(ordered[1:][ordered[1:] == ordered[:-1]])
    if repeated.shape[0] == 0:
        return tuple(families)
    place = np.searchsorted(repeated, key)
    place[place == repeated.shape[0]] = 0
    double = repeated[place] == key
    total = np.zeros(repeated.shape[0])
    result = list(families)
    offset = 0
    extra: list[EquationFamily] = []
    taken = np.zeros(repeated.shape[0], dtype=np.bool_)
    spans: list[tuple[int, Ids, Ids]] = []
    for index, members, coefficient in bare:
        here = slice(offset, offset + members.shape[0])
        offset += members.shape[0]
        hit = np.flatnonzero(double[here])
        np.add.at(total, place[here][hit], coefficient)
        spans.append((index, members[hit], place[here][hit]))
    for index, members, where in spans:
        if members.shape[0] == 0:
            continue
        family = families[index]
        _, unique = np.unique(where, return_index=True)
        unique = np.sort(unique)
        fresh = unique[~taken[where[unique]] & (total[where[unique]] != 0.0)]
        taken[where[fresh]] = True
        kept = np.ones(family.count, dtype=np.bool_)
        kept[members] = False
        remaining = take_members(family, np.flatnonzero(kept))
        result[index] = remaining
        for value in np.unique(total[where[fresh]]).tolist():
            chosen = np.sort(members[fresh[total[where[fresh]] == value]])
            part = take_members(family, chosen)
            template = mul(const(value), slot(0))
            extra.append(
                EquationFamily(template, part.kinds, part.operands, part.rows, part.origins)
            )
    return merge_families([*result, *extra])


def without_zeros(families: Sequence[EquationFamily]) -> tuple[EquationFamily, ...]:
    """Return the families whose template is not the constant zero."""
    return tuple(family for family in families if family.template is not ZERO)


def without_rows(
    families: Sequence[EquationFamily], removed: NDArray[np.bool_]
) -> tuple[EquationFamily, ...]:
    """Return the families without the members of removed rows."""
    kept = [keep_rows(family, removed) for family in families]
    return tuple(family for family in kept if family is not None)
