"""Which conditions make the start unique.

The rows of the model leave as many unknowns free as there are degrees of freedom. They are pinned,
in this order of strength, by initial equations and fixed starts (both are binding), then by start
values of states that were written, of other differentiated variables that were written, and last
by the default start of states. The choice is a maximum matching of rows and unknowns that grows
by one sort of condition after the other: what is matched stays matched.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.elimination.families import variable_slots
from acausal.flattening.members import sorted_unique
from acausal.flattening.model import EquationFamily, Ids
from acausal.initialization.system import StartSystem
from acausal.structural.dulmage_mendelsohn import overdetermined_part
from acausal.structural.matching import Matching, maximum_matching

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Conditions:
    """The square system to be solved, and what was decided about it.

    Attributes:
        pinned: Ids that take their start value, shape ``(k,)``, ascending.
        rows: Rows to be solved: the model's, then ``n_rows + i`` for initial row ``i``.
        unknowns: Ids to be solved for; ``unknowns[k]`` is matched to ``rows[k]``.
        chosen: Pinned ids that are not ``fixed``: guesses taken as conditions.
        surplus_rows: Binding rows (initial equations, or rows of the model) that are not
            needed and must hold all the same.
        surplus_fixed: Fixed ids that are not needed as a condition and must hold too.
        free: Ids that nothing determines.
        conflict_rows: Rows of the overdetermined part, numbered as ``rows``.
        conflict_ids: Fixed ids of the overdetermined part.
    """

    pinned: Ids
    rows: Ids
    unknowns: Ids
    chosen: Ids
    surplus_rows: Ids
    surplus_fixed: Ids
    free: Ids
    conflict_rows: Ids
    conflict_ids: Ids


def incidence(system: StartSystem) -> tuple[Ids, Ids]:
    """Return (row, id) pairs, sorted and unique; initial rows follow the model's."""
    rows: list[Ids] = []
    ids: list[Ids] = []

    def collect(families: tuple[EquationFamily, ...], offset: int) -> None:
        for family in families:
            for j in variable_slots(family):
                rows.append(family.rows + offset)
                ids.append(family.operands[j])

    collect(system.families, 0)
    collect(system.initial, system.n_rows)
    if not rows:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    key = sorted_unique(np.concatenate(rows) * np.int64(system.n_ids) + np.concatenate(ids))
    return key // system.n_ids, key % system.n_ids


def choose_conditions(
    system: StartSystem, pins: Ids | None = None, preferred: Ids | None = None
) -> Conditions:
    """Return the conditions that make the system square and structurally non-singular.

    Args:
        system: The equations.
        pins: If given, these ids are pinned and nothing else is: neither starts nor initial
            equations count (a restart during the simulation).
        preferred: Ids whose start values come before all other optional conditions.
    """
    rows, ids = incidence(system)
    total = system.n_rows + system.n_initial
    if pins is not None:
        keep = rows < system.n_rows
        rows, ids, total = rows[keep], ids[keep], system.n_rows
    used = system.used()
    if pins is not None:
        # What stands in initial equations only is no matter of a restart.
        standing = np.zeros(system.n_ids, dtype=np.bool_)
        standing[ids] = True
        used &= standing
    binding, optional = _candidates(system, used) if pins is None else (pins[used[pins]], [])
    if preferred is not None:
        others = [tier[~np.isin(tier, preferred)] for tier in optional]
        optional = [preferred[used[preferred]], *others]

    columns_of = np.flatnonzero(used)
    column = np.cumsum(used) - 1
    n_columns = columns_of.shape[0]
    conditions = np.concatenate([binding, *optional])
    # All rows in one graph: the model's, initial ones, and one row per condition. A stage
    # leaves the edges of later rows out, so they stay unmatched.
    all_rows = np.concatenate([rows, total + np.arange(conditions.shape[0])])
    all_columns = column[np.concatenate([ids, conditions])]
    n_all = total + conditions.shape[0]
    ends = np.cumsum([total + binding.shape[0], *[tier.shape[0] for tier in optional]])
    matching: Matching | None = None
    for end in dict.fromkeys([min(system.n_rows, total), *ends.tolist()]):
        allowed = all_rows < end
        pointer = np.zeros(n_all + 1, dtype=np.int64)
        np.cumsum(np.bincount(all_rows[allowed], minlength=n_all), out=pointer[1:])
        matching = maximum_matching(pointer, all_columns[allowed], n_columns, matching)
        if end == total + binding.shape[0]:
            over_rows, _ = overdetermined_part(
                *_graph(all_rows, all_columns, end), _head(matching, end)
            )
        if (matching.row_of_column >= 0).all() and end >= total + binding.shape[0]:
            break
    assert matching is not None
    matched = matching.column_of_row >= 0
    pinned_rows = np.flatnonzero(matched[total:])
    pinned = conditions[pinned_rows]
    solved_rows = np.flatnonzero(matched[:total])
    surplus = np.flatnonzero(~matched[:total])
    unmatched_binding = np.flatnonzero(~matched[total : total + binding.shape[0]])
    conflict = np.flatnonzero(over_rows)
    conflict_conditions = conflict[conflict >= total] - total
    return Conditions(
        pinned=np.sort(pinned),
        rows=solved_rows,
        unknowns=columns_of[matching.column_of_row[solved_rows]],
        chosen=np.sort(conditions[pinned_rows[pinned_rows >= binding.shape[0]]]),
        surplus_rows=surplus,
        surplus_fixed=np.sort(binding[unmatched_binding]),
        free=columns_of[matching.row_of_column < 0],
        conflict_rows=conflict[conflict < total],
        conflict_ids=binding[conflict_conditions],
    )


def _graph(rows: Ids, columns: Ids, end: int) -> tuple[Ids, Ids]:
    """Return pointer and columns of the rows below ``end``."""
    allowed = rows < end
    pointer = np.zeros(end + 1, dtype=np.int64)
    np.cumsum(np.bincount(rows[allowed], minlength=end), out=pointer[1:])
    return pointer, columns[allowed]


def _head(matching: Matching, end: int) -> Matching:
    """Return the matching of the rows below ``end`` (later ones are unmatched)."""
    return Matching(matching.column_of_row[:end], matching.row_of_column)


def _candidates(system: StartSystem, used: Mask) -> tuple[Ids, list[Ids]]:
    """Return fixed ids, and tiers of optional conditions, strongest first."""
    variables = system.variables
    fixed = np.flatnonzero(variables.fixed & used)
    given = variables.start_given & used & ~variables.fixed
    states = system.states[used[system.states] & ~variables.fixed[system.states]]
    differentiated = (system.derivative >= 0) & given
    differentiated[states] = False
    return fixed, [
        states[given[states]],
        np.flatnonzero(differentiated),
        states[~given[states]],
    ]
