"""Stage blocks: in which order the equations can be solved once the states are known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.elimination.eliminate import Elimination
from acausal.expressions.differentiate import partials
from acausal.expressions.nodes import ZERO
from acausal.expressions.nodes import slot as slot_of
from acausal.expressions.traverse import slots
from acausal.flattening.flatten import Flattened
from acausal.flattening.model import EquationFamily, Ids, Operand
from acausal.inspection.eliminate import place_names
from acausal.inspection.equations import EquationForm, EquationForms, mixed
from acausal.inspection.lists import SHOWN, columns, counted, indented, listed
from acausal.inspection.operands import Label, Located, Names
from acausal.simulation.system import System
from acausal.structural.blocks import Blocks, block_triangular_form
from acausal.structural.graphs import compress
from acausal.structural.incidence import incidence_of
from acausal.structural.tearing import TornBlocks, tear_blocks

#: Rows of one block that are shown.
_ROWS_SHOWN = 8


def show_blocks(flattened: Flattened, elimination: Elimination, system: System) -> list[str]:
    """Return the block lower triangular form for the highest derivatives.

    Row ``i``, differentiated ``c[i]`` times, and the highest derivatives ``d[j]`` of the unknowns
    are solved for; states and time are known.
    """
    reduced, offsets = elimination.model, system.offsets
    chains = system.differentiated.chains
    signature = incidence_of(reduced.families, reduced.n_rows, chains).signature()
    tight = signature.orders + offsets.c[signature.rows] == offsets.d[signature.bases]
    rows, bases = signature.rows[tight], signature.bases[tight]
    pointer = compress(rows, reduced.n_rows)
    blocks = block_triangular_form(pointer, bases, offsets.matching)
    can = _solvable(reduced.families, system, rows, bases)
    torn = tear_blocks(blocks, pointer, bases, can)
    names = Names(flattened.numbering, flattened.model, chains)
    sizes, how_many = np.unique(blocks.sizes, return_counts=True)
    said = ", ".join(
        f"{count} of size {size}"
        for size, count in zip(sizes.tolist(), how_many.tolist(), strict=True)
    )
    lines = [f"{counted(blocks.count, 'block')}" + (f": {said}" if said else "")]
    if len(torn.blocks):
        inside = int(blocks.sizes[torn.blocks].sum())
        lines.append(f"tearing: {torn.n_tearing} instead of {inside} unknowns in iterations")
    lines += ["", "in the order of solution, states and time known"]
    lines += indented(_block_lines(blocks, torn, system, names))
    return lines


def _solvable(
    families: tuple[EquationFamily, ...], system: System, rows: Ids, bases: Ids
) -> NDArray[np.bool_]:
    """Tell which rows give an unknown explicitly: linear, with a coefficient of parameters only."""
    chains, offsets = system.differentiated.chains, system.offsets
    n_bases = len(offsets.d)
    key = rows * n_bases + bases
    result = np.ones(len(key), np.bool_)
    for family in families:
        variables = [j for j, kind in enumerate(family.kinds) if kind == Operand.VARIABLE]
        derived = partials(family.template, [slot_of(j) for j in variables])
        for j in variables:
            partial = derived[slot_of(j)]
            constant = partial is not ZERO and all(
                family.kinds[int(str(k))] == Operand.PARAMETER for k in slots(partial)
            )
            if constant:
                continue
            ids = family.operands[j]
            base, order = chains.base[ids], chains.order[ids]
            own = np.flatnonzero((base >= 0) & (order + offsets.c[family.rows] == offsets.d[base]))
            result[np.searchsorted(key, family.rows[own] * n_bases + base[own])] = False
    return result


@dataclass(frozen=True)
class _Runs:
    """Blocks one after the other that look the same.

    Attributes:
        first: First block of each run.
        count: Number of blocks in it.
    """

    first: Ids
    count: Ids


def _runs(blocks: Blocks, forms: EquationForms, rows: Ids, unknowns: Located) -> _Runs:
    """Find runs of blocks with the same forms of equations for unknowns of the same places."""
    within = np.arange(len(rows)) - np.repeat(blocks.pointer[:-1], blocks.sizes)
    code = forms.numbers_of(rows) * (int(unknowns.code.max(initial=0)) + 1) + unknowns.code
    terms = mixed(mixed(code.astype(np.uint64)) + within.astype(np.uint64))
    signature = np.add.reduceat(terms, blocks.pointer[:-1])
    change = np.concatenate([[True], signature[1:] != signature[:-1]])
    first = np.flatnonzero(change)
    return _Runs(first, np.diff(np.concatenate([first, [blocks.count]])))


def _block_lines(blocks: Blocks, torn: TornBlocks, system: System, names: Names) -> list[str]:
    if not blocks.count:
        return []
    chains, offsets = system.differentiated.chains, system.offsets
    rows = system.differentiated.rows_of(blocks.rows, offsets.c[blocks.rows])
    forms = EquationForms(system.differentiated.families, names, rows=rows)
    unknown = chains.ids(blocks.columns, offsets.d[blocks.columns])
    located = names.locate(unknown, Operand.VARIABLE)
    runs = _runs(blocks, forms, rows, located)
    pattern_of = dict(zip(torn.blocks.tolist(), torn.pattern.tolist(), strict=True))
    lines: list[str] = []
    table: list[tuple[str, str, str]] = []
    for first, count in zip(runs.first[:SHOWN].tolist(), runs.count[:SHOWN].tolist(), strict=True):
        size = int(blocks.sizes[first])
        places = blocks.pointer[first] + np.arange(count)[:, None] * size + np.arange(size)
        number = f"{first + 1}" + (f"-{first + count}" if count > 1 else "")
        if size == 1:
            form = forms.of_rows(rows[places[:, 0]])
            table.append((number, _unknown(located, places[:, 0], form), f"from {form.text()}"))
            continue
        lines += columns(table, 40)
        table = []
        each = " each" if count > 1 else ""
        lines.append(f"{number}  {counted(size, 'equation')} together{each}")
        tearing = torn.patterns[pattern_of[first]].tearing
        by_column = np.argsort(blocks.columns[places[0]])[tearing]
        if count > 1:
            said = _alike(forms, rows, located, places, by_column)
        else:
            said = _alone(forms, rows[places[0]], names, unknown[places[0]], by_column)
        lines += indented(said, 3)
    lines += columns(table, 40)
    if len(runs.first) > SHOWN:
        left = int(runs.count[SHOWN:].sum())
        lines.append(f"... {counted(left, 'block')} more")
    return lines


def _unknown(located: Located, members: Ids, form: EquationForm) -> str:
    """Return the name of unknowns of one place, with the index letters of their equations."""
    name = located.name(members, form.indices).value
    assert isinstance(name, Label)
    return name.text


def _alike(forms: EquationForms, rows: Ids, located: Located, places: Ids, torn: Ids) -> list[str]:
    """Return what is said about equal blocks: an index stands for all of them."""
    shown = range(min(places.shape[1], _ROWS_SHOWN))
    said = [forms.of_rows(rows[places[:, k]]) for k in shown]
    unknowns = [_unknown(located, places[:, k], said[0]) for k in shown]
    lines = ["for " + ", ".join(unknowns), *(form.text() for form in said)]
    if places.shape[1] > _ROWS_SHOWN:
        lines.append(f"... {places.shape[1] - _ROWS_SHOWN} more equations and unknowns")
    guessed = [_unknown(located, places[:, k], said[0]) for k in torn[:SHOWN].tolist()]
    return [*lines, "torn by " + ", ".join(guessed)]


def _alone(forms: EquationForms, rows: Ids, names: Names, unknowns: Ids, torn: Ids) -> list[str]:
    """Return what is said about one block: its equations by form, its unknowns by place."""
    lines = ["for " + listed(place_names(names.variables(unknowns)))]
    numbers = forms.numbers_of(rows)
    _, first = np.unique(numbers, return_index=True)
    order = [int(numbers[k]) for k in np.sort(first)]
    for number in order[:_ROWS_SHOWN]:
        lines.append(forms.of_rows(np.sort(rows[numbers == number])).text())
    if len(order) > _ROWS_SHOWN:
        lines.append(f"... {len(order) - _ROWS_SHOWN} more forms of equations")
    return [*lines, "torn by " + listed(place_names(names.variables(np.sort(unknowns[torn]))))]
