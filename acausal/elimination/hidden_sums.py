"""Sums of states that follow from several rows with literal coefficients.

Around a set of nodes the currents add up to zero, and along a loop the voltages: the rows that
say so have coefficients of one, and a sum of several of them may leave differentiated variables
only: three coils that feed a rectifier carry currents that add up to zero, three capacitors in a
triangle have such voltages, whatever the diodes and resistors beside them do. The structure of
the rows does not show it once the other currents are replaced by what they are functions of; all
these variables would be taken for states, and the system would be singular.

So the rows with literal coefficients are looked at before anything is put in. Rows in which a
variable stands alone that is not differentiated take part in no such sum; they are peeled off,
round by round. What is left, mostly nothing, is reduced by Gaussian elimination; a row that only
differentiated variables are left in takes the place of the row it came from. The new rows are
equivalent to the old.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from acausal.elimination.alias_rows import without_rows
from acausal.elimination.families import variable_slots
from acausal.elimination.linear_form import linear_form, tidied
from acausal.elimination.working import System
from acausal.expressions.build import add, mul
from acausal.expressions.nodes import ZERO, Expr, const, slot
from acausal.flattening.members import merge_families, take_members
from acausal.flattening.model import EquationFamily, Operand

Mask = NDArray[np.bool_]

#: Largest number of rows that Gaussian elimination is used on.
LARGEST = 3000
#: A round of peeling that takes less than this share of so many rows or more is the last: they
#: are a long chain or a large net, which is left alone.
SHARE = 0.05
#: Sums of coefficients of one are whole numbers; what is smaller is zero.
TINY = 1e-9


def with_sums_of_states(system: System) -> tuple[System, NDArray[np.int64]]:
    """Return the system with sums of differentiated variables that rows imply as rows.

    Args:
        system: Variables are numbered as in the model, aliases are merged, nothing is defined.

    Returns:
        The system, and the rows that others were added to, ascending.
    """
    none = np.zeros(0, np.int64)
    differentiated = system.derivative >= 0
    if np.count_nonzero(differentiated) < 2:
        return system, none
    rows, columns, coefficients, constants = _literal_rows(system)
    inner = ~differentiated[columns]
    alive = _core(rows, columns, inner, system.n_rows)
    chosen = np.flatnonzero(alive)
    if not 2 <= len(chosen) <= LARGEST:
        return system, none
    table: dict[int, dict[int, float]] = {row: {} for row in chosen.tolist()}
    kept = alive[rows]
    for row, column, value in zip(
        rows[kept].tolist(), columns[kept].tolist(), coefficients[kept].tolist(), strict=True
    ):
        table[row][column] = table[row].get(column, 0.0) + value
    found = _reduced(table, differentiated, constants)
    if not found:
        return system, none
    changed = np.array(sorted(found), np.int64)
    return _with_rows(system, found), changed


def _literal_rows(
    system: System,
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Return row, variable and coefficient of all entries of rows that are linear with literals.

    The fourth result is the constant of each row, shape ``(n_rows,)``. Rows with derivatives are
    left out.
    """
    unfit = system.removed.copy()
    derivatives = np.zeros(system.n_variables, np.bool_)
    derivatives[system.derivative[system.derivative >= 0]] = True
    constants = np.zeros(system.n_rows)
    parts: list[tuple[NDArray[np.int64], NDArray[np.int64], float]] = []
    for family in system.families:
        form = linear_form(family.template)
        variables = set(variable_slots(family))
        if form is None or not variables.issuperset(form.coefficients):
            unfit[family.rows] = True
            continue
        np.add.at(constants, family.rows, form.constant)
        for j, value in form.coefficients.items():
            unfit[family.rows[derivatives[family.operands[j]]]] = True
            parts.append((family.rows, family.operands[j], value))
    nothing = np.zeros(0, np.int64)
    rows = np.concatenate([nothing, *(p[0] for p in parts)])
    columns = np.concatenate([nothing, *(p[1] for p in parts)])
    values = np.repeat(np.array([p[2] for p in parts]), [len(p[0]) for p in parts])
    fit = ~unfit[rows]
    return rows[fit], columns[fit], values[fit], constants


def _core(rows: NDArray[np.int64], columns: NDArray[np.int64], inner: Mask, n_rows: int) -> Mask:
    """Return the rows in which no variable that is not differentiated stands alone."""
    alive = np.zeros(n_rows, np.bool_)
    if not inner.any() or inner.all():
        return alive
    row, column = rows[inner], columns[inner]
    alive[row] = True
    count = np.count_nonzero(alive)
    while len(row):
        counts = np.bincount(column)
        lonely = row[counts[column] == 1]
        if not len(lonely):
            return alive
        alive[lonely] = False
        before, count = count, np.count_nonzero(alive)
        if count > LARGEST and before - count < SHARE * before:
            break
        kept = alive[row]
        row, column = row[kept], column[kept]
    return np.zeros(n_rows, np.bool_)


def _reduced(
    table: dict[int, dict[int, float]], differentiated: Mask, constants: NDArray[np.float64]
) -> dict[int, tuple[dict[int, float], float]]:
    """Return the rows that become sums of differentiated variables, with their constants."""
    pivots: dict[int, tuple[dict[int, float], float]] = {}
    found: dict[int, tuple[dict[int, float], float]] = {}
    for number in sorted(table, key=lambda r: (len(table[r]), r)):
        row, constant = table[number], float(constants[number])
        inner = [c for c in row if not differentiated[c]]
        while inner:
            column = inner.pop()
            if column not in pivots or column not in row:
                continue
            pivot, rest = pivots[column]
            factor = row[column] / pivot[column]
            for other, value in pivot.items():
                left = row.get(other, 0.0) - factor * value
                if abs(left) < TINY:
                    row.pop(other, None)
                    continue
                if other not in row and not differentiated[other]:
                    inner.append(other)
                row[other] = left
            constant -= factor * rest
        inner = [c for c in row if not differentiated[c]]
        if inner:
            pivots[inner[0]] = row, constant
        elif row:
            found[number] = row, constant
    return found


def _with_rows(system: System, found: dict[int, tuple[dict[int, float], float]]) -> System:
    """Return the system with other terms in some rows; they keep their numbers and origins."""
    replaced = np.zeros(system.n_rows, np.bool_)
    replaced[list(found)] = True
    new: list[EquationFamily] = []
    for family in system.families:
        for member in np.flatnonzero(replaced[family.rows]).tolist():
            row = int(family.rows[member])
            if row not in found:
                continue
            terms, constant = found.pop(row)
            template: Expr = const(constant) if abs(constant) >= TINY else ZERO
            for j, value in enumerate(terms.values()):
                template = add(template, mul(const(value), slot(j)))
            old = take_members(family, np.array([member]))
            operands = np.array(list(terms), family.operands.dtype)[:, None]
            new.append(
                replace(
                    old,
                    template=tidied(template),
                    kinds=(Operand.VARIABLE,) * len(terms),
                    operands=operands,
                )
            )
    return replace(
        system, families=merge_families([*without_rows(system.families, replaced), *new])
    )
