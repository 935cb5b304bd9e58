"""The pass: a flat model with a discrete part to one whose events are held values.

Between events everything discrete is constant: discrete variables, their values before the
event, relations, samples, limits. They become parameters behind all others, so that elimination,
index reduction and the kernels see a smooth model; what happens at events is assignments to held
values, in order of evaluation (Modelica 3.6, appendix B).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Label, fail
from acausal.events.causality import (
    check_definitions,
    discrete_rows,
    initial_rows,
    origin_of,
    targets_of,
)
from acausal.events.layout import Layout, layout_of, start_values
from acausal.events.operands import held_operands
from acausal.events.ordering import DiscreteLoopError, in_order
from acausal.events.relations import Extraction, makes_events
from acausal.events.signals import delay_families, sample_times, timing_parameters
from acausal.expressions.nodes import slot
from acausal.flattening.members import take_members
from acausal.flattening.model import (
    Discrete,
    EquationFamily,
    FlatModel,
    Hybrid,
    Ids,
    Names,
    Operand,
    Reinits,
    Termination,
)
from acausal.flattening.signals import INITIAL_ID, TERMINAL_ID

Families = Sequence[EquationFamily]


def lower_events(model: FlatModel) -> FlatModel:
    """Return the model with :attr:`FlatModel.hybrid` in place of :attr:`FlatModel.discrete`.

    A model without discrete variables, whens and relations that make events comes back as it is.

    Raises:
        AcausalError: ``E020`` to ``E026``, see the list of messages.
    """
    if model.discrete is None and not makes_events(model.families):
        return model
    discrete = model.discrete or _nothing_discrete(model)
    rows = discrete_rows(model, discrete)
    beginning = initial_rows(model, discrete)
    discrete = replace(
        discrete,
        initial=(*discrete.initial, *beginning.assignments),
        initial_pre=(*discrete.initial_pre, *beginning.before),
    )
    equalities = (*discrete.equalities, *rows.equalities)
    assigned = (*discrete.assignments, *rows.assignments)
    first = len(model.parameters)
    layout = layout_of(discrete, equalities, _all_families(model, discrete), first)
    check_definitions(assigned, layout, discrete, model.names)
    _check_derivatives(model, discrete)

    def placed(families: Families, offset: int = 0) -> list[EquationFamily]:
        moved = [replace(f, rows=offset + layout.place[f.rows]) for f in families]
        return list(held_operands(moved, layout))

    conditions = [
        replace(s.operands[0], rows=layout.signal[s.operands[0].rows])
        for s in discrete.signals
        if s.kind == "condition"
    ]
    expressions, times, maxima = delay_families(discrete, layout, model.parameters)
    extraction = Extraction(first, layout.count)
    continuous, assignments, condition_values, delays, delay_times, fires = extraction.extracted(
        [
            held_operands(rows.families, layout),
            placed(assigned),
            held_operands(conditions, layout),
            held_operands(expressions, layout),
            held_operands(times, layout),
            held_operands(_fires(discrete), layout),
        ]
    )
    assignments = [*extraction.shared(assignments), *condition_values]
    count = extraction.count
    ordered = _ordered(assignments, layout, model.names)
    initial = ordered
    if discrete.initial:
        instead = placed(discrete.initial)
        _check_initial(discrete.initial, layout, model.names)
        initial = _ordered(_replaced(assignments, instead), layout, model.names)
    n_before = layout.n_discrete
    start = np.zeros(count)
    values = start_values(
        layout, model.variables.start, model.variables.start_given, targets_of(assigned)
    )
    start[:n_before] = start[n_before : 2 * n_before] = values
    sample_start, sample_interval = sample_times(discrete, layout, model.parameters)
    hybrid = Hybrid(
        first=first,
        start=start,
        n_discrete=n_before,
        place=layout.place,
        conditions=layout.signal[layout.conditions],
        relations=extraction.relations(),
        assignments=ordered,
        initial=initial,
        initial_pre=tuple(placed(discrete.initial_pre, n_before)),
        initial_flag=int(layout.signal[INITIAL_ID]),
        terminal_flag=int(layout.signal[TERMINAL_ID]),
        sample_places=layout.signal[layout.samples],
        sample_start=sample_start,
        sample_interval=sample_interval,
        limits=_limits(layout),
        delay_places=layout.signal[layout.delays],
        delays=tuple(delays),
        delay_times=tuple(delay_times),
        delay_maxima=maxima,
        reinits=_reinits(discrete, layout, fires, extraction),
        terminations=tuple(
            Termination(part, t.message)
            for t in discrete.terminations
            for part in held_operands([t.family], layout)
        ),
        relevant=read_by(continuous, first, count),
        timing=timing_parameters(discrete),
    )
    return replace(
        model,
        variables=replace(model.variables, fixed=model.variables.fixed & (layout.place < 0)),
        parameters=np.concatenate([model.parameters, start]),
        families=tuple(continuous),
        initial=held_operands(beginning.families, layout),
        n_initial=beginning.n_rows,
        assertions=tuple(
            replace(a, family=part)
            for a in model.assertions
            for part in held_operands([a.family], layout)
        ),
        discrete=None,
        hybrid=hybrid,
    )


def read_by(families: Families, first: int, count: int) -> NDArray[np.bool_]:
    """Return which held values families read, shape ``(count,)``."""
    read = np.zeros(count, np.bool_)
    for family in families:
        for kind, ids in zip(family.kinds, family.operands, strict=True):
            if kind == Operand.PARAMETER:
                read[ids[ids >= first] - first] = True
    return read


def _nothing_discrete(model: FlatModel) -> Discrete:
    n = model.variables.count
    return Discrete(
        np.zeros(n, np.int8), np.zeros(n, np.bool_), 2, (), (), (), (), (), (), ()
    )  # fmt: skip


def _fires(discrete: Discrete) -> list[EquationFamily]:
    """Return the conditions of the reinits, ``rows`` number them."""
    return _numbered(discrete, "fires")


def _numbered(discrete: Discrete, part: str) -> list[EquationFamily]:
    result: list[EquationFamily] = []
    begin = 0
    for reinit in discrete.reinits:
        family: EquationFamily = getattr(reinit, part)
        result.append(replace(family, rows=begin + np.arange(family.count)))
        begin += family.count
    return result


def _reinits(
    discrete: Discrete, layout: Layout, fires: Families, extraction: Extraction
) -> Reinits:
    def joined(parts: list[Ids]) -> Ids:
        return np.concatenate([np.zeros(0, np.int64), *parts])

    states = joined([r.value.rows for r in discrete.reinits])
    ones = np.ones(len(states), np.int8)
    return Reinits(
        states,
        ones,
        joined([r.impulse for r in discrete.reinits]),
        ones,
        tuple(extraction.shared(held_operands(_numbered(discrete, "value"), layout))),
        tuple(fires),
        states,
    )


def _limits(layout: Layout) -> tuple[EquationFamily, ...]:
    ids = layout.limit_variables
    if not len(ids):
        return ()
    return (EquationFamily(slot(0), (Operand.VARIABLE,), ids[None, :], layout.limit[ids]),)


def _all_families(model: FlatModel, discrete: Discrete) -> list[EquationFamily]:
    return [
        *model.families,
        *model.initial,
        *(a.family for a in model.assertions),
        *discrete.assignments,
        *discrete.initial,
        *discrete.initial_pre,
        *(operand for s in discrete.signals for operand in s.operands),
        *(f for r in discrete.reinits for f in (r.value, r.fires)),
        *(t.family for t in discrete.terminations),
    ]


def _replaced(assignments: Families, instead: Sequence[EquationFamily]) -> list[EquationFamily]:
    """Return assignments with those of the same targets replaced."""
    gone = np.unique(np.concatenate([f.rows for f in instead]))
    result = []
    for family in assignments:
        keep = np.flatnonzero(~np.isin(family.rows, gone))
        if len(keep):
            result.append(take_members(family, keep))
    return [*result, *instead]


def _ordered(assignments: Families, layout: Layout, names: Names) -> tuple[EquationFamily, ...]:
    try:
        return in_order(assignments, layout.first, layout.n_discrete)
    except DiscreteLoopError as error:
        _fail_loop(error.places, assignments, layout, names)
        raise


def _fail_loop(places: list[int], assignments: Families, layout: Layout, names: Names) -> None:
    members = {place: np.flatnonzero(layout.place == place) for place in places}
    paths = [names.variable(int(members[p][0])) for p in places if len(members[p])]
    labels: list[Label] = []
    for place in places:
        for family in assignments:
            for member in np.flatnonzero(family.rows == place):
                origin = origin_of(family, int(member))
                if origin is not None and origin.span is not None:
                    labels.append(Label(origin.span, origin.text))
    fail(
        "E022",
        f"discrete variables depend on each other at one instant: {', '.join(paths[:6])}"
        + (f" and {len(paths) - 6} more" if len(paths) > 6 else ""),
        labels[0].span if labels else None,
        label=labels[0].text if labels else "",
        labels=labels[1:6],
        help=f"use the value before the event somewhere in the circle, e.g. pre({paths[0]})"
        if paths
        else "use pre(...) somewhere in the circle",
    )


def _check_initial(initial: Families, layout: Layout, names: Names) -> None:
    counts = np.bincount(np.concatenate([layout.place[f.rows] for f in initial]))
    twice = np.flatnonzero(counts > 1)
    if len(twice):
        variable = int(np.flatnonzero(layout.place == twice[0])[0])
        spans = [
            Label(origin.span, origin.text)
            for f in initial
            for m in np.flatnonzero(layout.place[f.rows] == twice[0])
            if (origin := origin_of(f, int(m))) is not None and origin.span is not None
        ]
        fail("E021", f"{names.variable(variable)} has two initial equations",
             spans[-1].span if spans else None, labels=spans[:-1],
             help="remove one of them")  # fmt: skip


def _check_derivatives(model: FlatModel, discrete: Discrete) -> None:
    """Refuse derivatives of variables that only change at events."""
    mothers = np.flatnonzero(discrete.discrete & (model.derivative >= 0))
    if not len(mothers):
        return
    bad = np.zeros(model.variables.count, np.bool_)
    bad[model.derivative[mothers]] = True
    for family in _all_families(model, discrete):
        for kind, ids in zip(family.kinds, family.operands, strict=True):
            if kind == Operand.VARIABLE and bad[ids].any():
                member = int(np.flatnonzero(bad[ids])[0])
                origin = origin_of(family, member)
                path = model.names.variable(int(ids[member]))
                fail("E023", f"{path} is the derivative of a variable that only changes at events",
                     origin.span if origin is not None else None,
                     label="between events it does not change, at events it jumps",
                     help="take the derivative of a continuous variable")  # fmt: skip
