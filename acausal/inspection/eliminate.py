"""Stage eliminate: what was taken out of the system and why, and what remains."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from acausal.elimination.eliminate import Elimination
from acausal.flattening.flatten import Flattened
from acausal.flattening.model import Ids, Operand
from acausal.inspection.equations import EquationForms
from acausal.inspection.flatten import form_lines
from acausal.inspection.index_names import IndexNames
from acausal.inspection.lists import SHOWN_IN_LINES, columns, counted, indented, shortened
from acausal.inspection.operands import Label, Names
from acausal.instantiation.places import Place, path_text


def show_eliminate(flattened: Flattened, elimination: Elimination) -> list[str]:
    """Return aliases, zeros and definitions, and the equations and unknowns that remain."""
    counts = elimination.counts
    names = Names(flattened.numbering, flattened.model)
    lines = [
        f"{counts.rows_before} equations became {counts.rows}, "
        f"{counts.families_before} families {counts.families}, in "
        f"{counted(counts.rounds, 'round')}",
        "",
        f"equal up to a sign: {counted(counts.aliases, 'variable')} "
        "(an equation says no more than a = b or a = -b)",
        *indented(_aliases(elimination, names)),
        "",
        f"always zero: {counted(counts.zeros, 'variable')} "
        "(not connected, held at zero, or equal to one that is)",
        *indented(_zeros(elimination, names)),
        "",
        f"computed from others: {counted(counts.definitions, 'variable')} "
        "(one equation gives it explicitly, or nothing else needs it)",
        *indented(_definitions(elimination, names)),
        "",
        f"what remains: {counted(counts.rows, 'equation')}",
    ]
    forms = EquationForms(elimination.model.families, names)
    lines += indented(form_lines(forms, range(forms.count)))
    unknowns = names.variables(np.flatnonzero(elimination.active))
    lines += ["", f"for {counted(int(elimination.active.sum()), 'unknown')}, derivatives counted"]
    lines += indented(place_lines(unknowns))
    return lines


def place_lines(places: list[Place]) -> list[str]:
    """Return places with index ranges, shortened."""
    return shortened(len(places), lambda k: place_names(places[k : k + 1])[0], "families")


def place_names(places: list[Place]) -> list[str]:
    """Return the name of every place with its index range."""
    names = []
    for place in places[: SHOWN_IN_LINES + 1]:
        indices = IndexNames(len(place.members))
        rows = [indices.text(r) for r in place.subscripts]
        ranges = indices.text_of_ranges()
        names.append(path_text(place.steps, rows, place.order) + (f" {ranges}" if ranges else ""))
    return names + [""] * max(0, len(places) - len(names))


def _aliases(elimination: Elimination, names: Names) -> list[str]:
    """Return lines ``who = a, b, -c``: one for each way of standing for others."""
    n = len(elimination.representative)
    others = np.flatnonzero((elimination.representative != np.arange(n)) & (elimination.sign != 0))
    heads = elimination.representative[others]
    order = np.argsort(heads, kind="stable")
    others, heads = others[order], heads[order]
    minus = (elimination.sign[others] < 0).astype(np.int64)
    return grouped_pairs(
        names, others, heads, minus, lambda other, head, sign: f"{other} = {'-' * sign}{head}"
    )


def grouped_pairs(
    names: Names, first: Ids, second: Ids, tag: Ids, text: Callable[[str, str, int], str]
) -> list[str]:
    """Return a line for every pair of places of variables that occurs, shortened.

    Args:
        names: Names.
        first: Variables, shape ``(n,)``.
        second: Their partners, shape ``(n,)``.
        tag: What else tells pairs apart.
        text: From both paths and the tag to a line.
    """
    if not len(first):
        return []
    a, b = names.locate(first, Operand.VARIABLE), names.locate(second, Operand.VARIABLE)
    code = (a.code * (int(b.code.max()) + 1) + b.code) * (int(tag.max()) + 1) + tag
    _, start, inverse = np.unique(code, return_index=True, return_inverse=True)
    pair = np.argsort(np.argsort(start))[inverse.reshape(-1)]
    members = np.argsort(pair, kind="stable")
    sizes = np.bincount(pair)
    bounds = np.concatenate([[0], np.cumsum(sizes)])

    def row(k: int) -> tuple[str, str]:
        own = members[bounds[k] : bounds[k + 1]]
        indices = IndexNames(len(own))
        paths = []
        for located in (a, b):
            name = located.name(own, indices).value
            assert isinstance(name, Label)
            paths.append(name.text)
        return text(paths[0], paths[1], int(tag[own[0]])), indices.text_of_ranges()

    shown = [row(k) for k in range(min(len(sizes), 20))]
    lines = columns(shown)
    if len(sizes) > 20:
        lines.append(f"... {len(sizes) - 20} more kinds")
    return lines


def _zeros(elimination: Elimination, names: Names) -> list[str]:
    return place_lines(names.variables(np.flatnonzero(elimination.sign == 0)))


def _definitions(elimination: Elimination, names: Names) -> list[str]:
    if not elimination.definitions:
        return []
    forms = EquationForms(elimination.definitions, names, definitions=True)
    return form_lines(forms, range(forms.count))
