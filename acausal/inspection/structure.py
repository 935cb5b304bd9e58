"""Stage structure: differential and algebraic variables, states, and what was differentiated."""

from __future__ import annotations

import numpy as np

from acausal.connections.components import connected_components
from acausal.diagnostics import AcausalError
from acausal.elimination.eliminate import Elimination
from acausal.flattening.flatten import Flattened
from acausal.flattening.model import Ids
from acausal.inspection.eliminate import grouped_pairs, place_lines, place_names
from acausal.inspection.equations import EquationForm, EquationForms
from acausal.inspection.flatten import place_text
from acausal.inspection.lists import SHOWN, columns, counted, indented, listed, wrapped
from acausal.inspection.operands import Names
from acausal.inspection.written_index import index_text
from acausal.instantiation.places import Place
from acausal.simulation.system import System


def show_structure(flattened: Flattened, elimination: Elimination, system: System) -> list[str]:
    """Return the roles of the variables, the states, and the differentiated equations."""
    differentiated, offsets = system.differentiated, system.offsets
    chains = differentiated.chains
    names = Names(flattened.numbering, flattened.model, chains)
    declared = flattened.numbering.n_declared
    lines = [
        f"{index_text(flattened, system)}, "
        f"{counted(offsets.degrees_of_freedom, 'degree')} of freedom, "
        f"{counted(elimination.model.n_rows, 'equation')}"
        + (
            f" and {counted(int(offsets.c.sum()), 'derivative')} of them" if offsets.c.any() else ""
        ),
    ]
    differential = _differential(flattened, elimination)
    lines += ["", f"differential variables: {len(differential)} (their derivatives are needed)"]
    lines += indented(_variable_lines(flattened, names.variables(differential), differential))
    lines += indented(_derivative_names(elimination, names, differential))
    algebraic = np.ones(declared, np.bool_)
    algebraic[differential] = False
    solved = algebraic & elimination.active[:declared]
    rest = np.flatnonzero(algebraic & ~solved)
    found = np.flatnonzero(solved)
    lines += ["", f"algebraic variables to be solved for: {len(found)}"]
    lines += indented(_variable_lines(flattened, names.variables(found), found))
    lines += ["", f"algebraic variables given by those: {len(rest)}"]
    lines += indented(wrapped(place_names(names.variables(rest)), "families"))
    lines += ["", *_states(system, names)]
    if offsets.c.any():
        lines += ["", *_differentiated(system, names)]
    return lines


def _differential(flattened: Flattened, elimination: Elimination) -> Ids:
    """Return the declared variables that are differential: they, or their aliases, have ``der``.

    Of variables that are equal up to a sign, the one that stands for all is listed.
    """
    derivative = elimination.model.derivative
    chosen = np.flatnonzero(elimination.active & (derivative >= 0))
    return chosen[chosen < flattened.numbering.n_declared]


def _variable_lines(flattened: Flattened, places: list[Place], ids: Ids) -> list[str]:
    names = flattened.model.names
    rows = []
    for place in places[:SHOWN]:
        path, ranges = place_text(place)
        variable = int(ids[place.members[0]])
        unit = names.unit(variable)
        rows.append((path, f"[{unit}]" if unit else "", ranges, names.description(variable)))
    more = [f"... {len(places) - SHOWN} more families"] if len(places) > SHOWN else []
    return [*columns(rows), *more]


def _derivative_names(elimination: Elimination, names: Names, differential: Ids) -> list[str]:
    """Return lines for derivatives that are variables of the model, as in ``v = der(x)``."""
    derivative = elimination.model.derivative[differential]
    named = derivative < names.numbering.n_declared
    return grouped_pairs(
        names, differential[named], derivative[named], np.zeros(int(named.sum()), np.int64),
        lambda x, v, _: f"der({x}) is {v}",
    )  # fmt: skip


def _states(system: System, names: Names) -> list[str]:
    from acausal.simulation.states import StateSelector

    count = system.offsets.degrees_of_freedom
    selector = StateSelector(system)
    try:
        states = selector.first(system.variables.start, system.experiment.start_time)
    except AcausalError as error:
        return [f"states: {count}, chosen at the start ({error.diagnostics[0].message})"]
    lines = [f"states: {len(states)}"]
    if selector.has_alternatives:
        lines[0] += " (chosen at the start values; others are taken when these become unsuitable)"
    return lines + indented(place_lines(names.variables(states)))


def _differentiated(system: System, names: Names) -> list[str]:
    """Return the equations that were differentiated, with what they became."""
    differentiated, c = system.differentiated, system.offsets.c
    rows = np.flatnonzero(c > 0)
    own = np.flatnonzero(differentiated.order > 0)
    constraints = _constraints(system, rows)
    lines = [
        f"differentiated equations: {len(rows)} in "
        f"{counted(len(np.unique(constraints)), 'set')}, "
        f"{counted(len(own), 'new equation')}"
    ]
    families = differentiated.families
    original = [k for k, order in enumerate(differentiated.orders) if order == 0]
    before = EquationForms([families[k] for k in original], names, rows=rows)
    after = _after(system, names, own)
    shown = 0
    for number in range(before.count):
        form = before.form(number)
        for part in _parts_by_times(form.rows, c):
            if shown == SHOWN:
                return [*lines, f"  ... {before.count - number} more forms"]
            shown += 1
            lines += indented(_one(system, before, after, part))
    return lines


def _after(system: System, names: Names, rows: Ids) -> EquationForms:
    differentiated = system.differentiated
    orders = differentiated.orders
    return EquationForms(
        [f for f, order in zip(differentiated.families, orders, strict=True) if order > 0],
        names,
        rows=rows,
    )


def _parts_by_times(rows: Ids, c: Ids) -> list[Ids]:
    times = c[rows]
    return [rows[times == t] for t in np.unique(times)[::-1].tolist()]


def _one(system: System, before: EquationForms, after: EquationForms, rows: Ids) -> list[str]:
    """Return what is said about differentiated rows of one form."""
    differentiated = system.differentiated
    times = int(system.offsets.c[rows[0]])
    form = before.of_rows(rows)
    lines = [
        f"{form.text()}   {form.source()}",
        f"    {_often(times)} differentiated, {_reason(system, form, times)}",
    ]
    for order in range(1, times + 1):
        new = differentiated.rows_of(rows, np.full(len(rows), order))
        new = new[~np.isin(new, differentiated.vanished)]
        if len(new):
            derived, others = _main_form(after, new)
            what = "d/dt" if order == 1 else f"d^{order}/dt^{order}"
            also = f"   (and {others} with another end)" if others else ""
            lines.append(f"    {what}: {derived.text()}{also}")
    return lines


def _main_form(forms: EquationForms, rows: Ids) -> tuple[EquationForm, int]:
    """Return the most frequent form of some rows, and how many rows have another one."""
    numbers = forms.numbers_of(rows)
    own = numbers == np.bincount(numbers).argmax()
    return forms.of_rows(rows[own]), int((~own).sum())


def _often(times: int) -> str:
    return {1: "once", 2: "twice"}.get(times, f"{times} times")


def _reason(system: System, form: EquationForm, times: int) -> str:
    """Return why rows are differentiated: the variables they tie together without derivatives."""
    chains, d = system.differentiated.chains, system.offsets.d
    tied = [
        name
        for variable, name in form.operands
        if chains.base[variable] >= 0
        and int(chains.order[variable]) + times == int(d[chains.base[variable]])
    ]
    derivative = "derivative" if times == 1 else f"derivatives up to order {times}"
    if len(tied) == 1:
        return f"as it fixes {tied[0]}, whose {derivative} others need"
    return f"as it ties {listed(tied)}, whose {derivative} others need"


def _constraints(system: System, rows: Ids) -> Ids:
    """Return the set each differentiated row belongs to: rows that share highest derivatives."""
    entries = system.entries
    local = np.full(len(system.offsets.c), -1, np.int64)
    local[rows] = np.arange(len(rows))
    bases, column = np.unique(entries.bases, return_inverse=True)
    _, label = connected_components(
        local[entries.rows], len(rows) + column.reshape(-1), len(rows) + len(bases)
    )
    return label[: len(rows)]
