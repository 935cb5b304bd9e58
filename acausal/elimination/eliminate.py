"""The pass: a flat model to a smaller one, and the record of what was taken out."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from acausal.elimination.alias_classes import alias_classes
from acausal.elimination.alias_rows import (
    alias_rows,
    combined_contributions,
    without_rows,
    without_zeros,
)
from acausal.elimination.attributes import merged_attributes
from acausal.elimination.carried import named_variables, restored
from acausal.elimination.families import row_counts, use_counts, used_variables, variable_slots
from acausal.elimination.hidden_sums import with_sums_of_states
from acausal.elimination.locals import choose_definitions, put_in
from acausal.elimination.outputs import sweep_outputs
from acausal.elimination.rewriting import rewritten
from acausal.elimination.signed_components import Signs
from acausal.elimination.vanishing import freed_starts, without_vanishing_derivatives
from acausal.elimination.working import (
    System,
    compacted,
    expanded,
    unsupported_derivatives,
    whole_model,
)
from acausal.flattening.members import merge_families, sorted_unique
from acausal.flattening.model import EquationFamily, FlatModel, Ids, Names, StateSelect

#: Rounds of elimination; each makes what is left smaller, few are ever needed.
MAX_ROUNDS = 12
#: Sweeps for pure outputs per round: a chain of outputs longer than this stays in the model.
MAX_SWEEPS = 12


@dataclass(frozen=True)
class Counts:
    """How much was taken out, for reports.

    Attributes:
        rows_before, rows: Rows before and after.
        families_before, families: Equation families before and after.
        aliases: Variables that are plus or minus another one.
        zeros: Variables that are always zero.
        definitions: Variables that are computed from others.
        rounds: Rounds it took.
    """

    rows_before: int
    rows: int
    families_before: int
    families: int
    aliases: int
    zeros: int
    definitions: int
    rounds: int


@dataclass(frozen=True)
class Elimination:
    """A reduced model and how to get the rest of the variables back.

    A variable ``x`` has the value ``sign[x] * value(representative[x])``; a representative is
    either active or has a definition.

    Attributes:
        model: The reduced model: same ids of variables and parameters, fewer rows, numbered
            anew. ``derivative`` relates representatives only.
        row_of: Row of the original model for each row of the reduced one, shape ``(n_rows,)``.
        representative: Who stands for each variable, shape ``(n,)``.
        sign: 1, -1, or 0 for a variable that is always zero, shape ``(n,)``.
        definitions: Families in the order of evaluation. The value of the variable
            ``rows[k]`` is the sum of all contributions to it, which mostly is one; start from
            zero and add family after family.
        divisors: Expressions of parameters that definitions divide by, as families; ``rows``
            holds the variable. See :func:`divisors_hold`.
        active: Variables that remain unknowns, shape ``(n,)``.
        redundant_rows: Rows of the original model that say what others say already, ascending.
            Each of them leaves an unknown without an equation.
        counts: Statistics.
        recombined: Rows of the original model to which others were added, ascending; see
            :mod:`acausal.elimination.hidden_sums`.
    """

    model: FlatModel
    row_of: Ids
    representative: Ids
    sign: Signs
    definitions: tuple[EquationFamily, ...]
    divisors: tuple[EquationFamily, ...]
    active: NDArray[np.bool_]
    redundant_rows: Ids
    counts: Counts
    recombined: Ids = field(default_factory=lambda: np.zeros(0, np.int64))


def eliminate(
    model: FlatModel, *, explicit_locals: bool = True, divide_by_parameters: bool = False
) -> Elimination:
    """Return the model without aliases, known zeros and, if wished, explicit locals.

    Time and memory grow linearly with the number of rows; symbolic work is done once per
    template and pattern.

    Args:
        model: The flat model.
        explicit_locals: Also take out variables that one row defines by others.
        divide_by_parameters: Solve ``R*i = v`` for ``i`` where ``R`` is not zero now. Who
            changes parameters later has to ask :func:`divisors_hold`, and to compile anew if
            they do not.

    Raises:
        AcausalError: I001, I002 if fixed start values of equal variables contradict.

    Warnings of the model: I102 for start values that zero parameters make impossible.
    """
    kept = np.zeros(model.variables.count, dtype=np.bool_)
    whole = whole_model(model)
    whole = _merged_once(whole, model.names) or whole
    regular = without_vanishing_derivatives(whole, model)
    if regular is not whole:
        regular = _merged_once(regular, model.names) or regular
        whole, warnings = freed_starts(whole, regular, model.names)
        model = replace(model, warnings=(*model.warnings, *warnings))
    whole, recombined = with_sums_of_states(whole)
    parameters = _divisible(model) if divide_by_parameters else None
    while True:
        # Most variables and rows are gone now. What is left is numbered anew for the rounds. It is
        # made again in the rare case that it is needed twice: it takes more memory than time.
        system = compacted(whole)
        rounds = 0
        progress = True
        while progress and rounds < MAX_ROUNDS:
            rounds += 1
            progress, system = _without_aliases(system, model.names)
            if explicit_locals:
                named = named_variables(model, system.others, system.n_variables)
                changed, system = _without_locals(system, kept[system.ids] | named, parameters)
                progress = progress or changed
        assert system.ids is not None
        needed = system.ids[_definitions_of_lost_derivatives(system)]
        if needed.shape[0] == 0:
            final = expanded(system, whole, model)
            del system, whole
            return replace(_finish(model, final, rounds), recombined=recombined)
        kept[needed] = True


def _divisible(model: FlatModel) -> NDArray[np.float64]:
    """Return the parameters with those that change at events as NaN: no divisors."""
    if model.hybrid is None:
        return model.parameters
    parameters = model.parameters.copy()
    parameters[model.hybrid.first :] = np.nan
    return parameters


def _definitions_of_lost_derivatives(system: System) -> Ids:
    """Return variables whose definitions refer to a derivative that is left in no row.

    Nothing would make index reduction find such a derivative, so the row has to stay.
    """
    n = system.n_variables
    used = use_counts(system.families, n) > 0
    lost = unsupported_derivatives(system.derivative, used) & ~used
    found = np.zeros(n, dtype=np.bool_)
    if lost.any():
        for group in system.definitions:
            for family in group:
                for j in variable_slots(family):
                    found[family.rows[lost[family.operands[j]]]] = True
    return np.flatnonzero(found)


def _without_aliases(system: System, names: Names) -> tuple[bool, System]:
    """Merge aliases and zeros until none is found."""
    changed = False
    while True:
        merged = _merged_once(system, names)
        if merged is None:
            return changed, system
        system, changed = merged, True


def _merged_once(system: System, names: Names) -> System | None:
    """Return the system with alias classes merged and their rows gone; None without aliases."""
    families = without_zeros(system.families)
    aliases = alias_rows(families, row_counts(families, system.n_rows))
    if aliases.rows.shape[0] == 0:
        return None
    select = system.variables.state_select
    priority = (
        4 * (select > StateSelect.DEFAULT).astype(np.int8)
        + 2 * system.variables.fixed.astype(np.int8)
        + system.variables.start_given.astype(np.int8)
    ).astype(np.int8)
    classes = alias_classes(aliases, system.derivative, priority)
    rows = classes.used.rows
    if rows.shape[0] == 0:
        return None
    representative, sign = classes.representative, classes.sign
    before = system.representative
    removed = system.removed.copy()
    removed[rows] = True
    families = rewritten(without_rows(families, removed), representative, sign)
    families = combined_contributions(
        families, row_counts(families, system.n_rows), system.n_variables
    )
    return replace(
        system,
        families=without_zeros(families),
        others=tuple(rewritten(group, representative, sign) for group in system.others),
        definitions=tuple(rewritten(group, representative, sign) for group in system.definitions),
        variables=merged_attributes(system.variables, representative, sign, names, system.ids),
        derivative=classes.derivative,
        representative=representative if before is None else representative[before],
        sign=sign if before is None else system.sign * sign[before],
        removed=removed,
        redundant=(*system.redundant, rows[classes.redundant].astype(np.int64)),
    )


def _without_locals(
    system: System,
    kept: NDArray[np.bool_],
    parameters: NDArray[np.float64] | None,
) -> tuple[bool, System]:
    """Take out pure outputs, then one batch of explicit locals."""
    n = system.n_variables
    variables = system.variables
    blocked = (
        variables.fixed
        | (variables.state_select > StateSelect.DEFAULT)
        | (system.derivative >= 0)
        | system.defined
        | kept
    )
    derivatives = np.zeros(n, dtype=np.bool_)
    derivatives[system.derivative[system.derivative >= 0]] = True
    blocked |= derivatives
    elsewhere = np.zeros(n, dtype=np.bool_)
    for group in system.others:
        for family in group:
            elsewhere[family.operands[variable_slots(family)].ravel()] = True
    changed = False
    for sweeps in range(MAX_SWEEPS + 1):
        counts = row_counts(system.families, system.n_rows)
        uses = use_counts(system.families, n)
        if sweeps == MAX_SWEEPS:
            break
        unsupported = unsupported_derivatives(system.derivative, uses > 0)
        sweep = sweep_outputs(
            system.families, counts, uses, blocked | elsewhere, elsewhere, unsupported
        )
        if sweep is None:
            break
        changed = True
        system = _defined(system, sweep.families, sweep.definitions, sweep.defined, sweep.rows)
    chosen = choose_definitions(system.families, counts, uses, blocked | system.defined, parameters)
    if not chosen:
        return changed, system
    definitions = merge_families([definition.value_family() for definition in chosen])
    defined = np.concatenate([definition.variables for definition in chosen])
    divisors = [definition.divisor_family() for definition in chosen]
    system = replace(
        system,
        divisors=merge_families([*system.divisors, *[d for d in divisors if d is not None]]),
    )
    rows = np.concatenate([d.family.rows[d.members] for d in chosen])
    removed = np.zeros(system.n_rows, dtype=np.bool_)
    removed[rows] = True
    families = put_in(without_rows(system.families, removed), chosen, n)
    others = tuple(put_in(group, chosen, n) for group in system.others)
    system = _defined(replace(system, others=others), families, definitions, defined, rows)
    return True, system


def _defined(
    system: System,
    families: tuple[EquationFamily, ...],
    definitions: tuple[EquationFamily, ...],
    variables: Ids,
    rows: Ids,
) -> System:
    """Return the system after variables got definitions; later ones are evaluated first."""
    defined, removed = system.defined.copy(), system.removed.copy()
    defined[variables] = True
    removed[rows] = True
    return replace(
        system,
        families=families,
        definitions=(definitions, *system.definitions),
        defined=defined,
        removed=removed,
    )


def _finish(model: FlatModel, system: System, rounds: int) -> Elimination:
    n = system.n_variables
    counts = row_counts(system.families, model.n_rows)
    present = counts > 0
    row_of = np.flatnonzero(present)
    number = np.cumsum(present, dtype=np.int32) - np.int32(1)
    families = tuple(replace(f, rows=number[f.rows].astype(np.int64)) for f in system.families)
    lost = ~present & ~system.removed
    redundant = sorted_unique(np.concatenate([np.flatnonzero(lost), *system.redundant]))

    representative = system.representative
    if representative is None:
        representative = np.arange(n)
    # Every representative stands for itself.
    own = np.zeros(n, dtype=np.bool_)
    own[representative] = True
    standing = (*families, *(family for group in system.others for family in group))
    used = used_variables(standing, n)
    active = own & (system.sign != 0) & ~system.defined
    if model.hybrid is not None:
        active &= model.hybrid.place < 0
    # A derivative that nothing uses any more is no unknown.
    derivative = system.derivative.copy()
    mothers = np.flatnonzero(derivative >= 0)
    is_derivative = np.zeros(n, dtype=np.bool_)
    is_derivative[model.derivative[model.derivative >= 0]] = True
    derivative[mothers[~active[mothers]]] = -1
    while True:
        idle = is_derivative & active & ~used & (derivative < 0)
        if not idle.any():
            break
        active &= ~idle
        mothers = np.flatnonzero(derivative >= 0)
        derivative[mothers[idle[derivative[mothers]]]] = -1

    reduced = replace(
        restored(model, system.others, families),
        variables=system.variables,
        derivative=derivative,
        families=families,
        n_rows=row_of.shape[0],
    )
    zeros = int((system.sign == 0).sum())
    statistics = Counts(
        model.n_rows,
        reduced.n_rows,
        len(model.families),
        len(families),
        int((~own).sum()) - int((~own & (system.sign == 0)).sum()),
        zeros,
        int(system.defined.sum()),
        rounds,
    )
    return Elimination(
        reduced,
        row_of,
        representative,
        system.sign,
        tuple(family for group in system.definitions for family in group),
        system.divisors,
        active,
        redundant,
        statistics,
    )
