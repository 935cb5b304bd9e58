"""Rest at the end of infinitely many impacts.

A ball that bounces with restitution makes infinitely many impacts in finite time. Behind them its
motion is not defined by ``der(v) = -g`` and ``reinit(v, -e*pre(v))``: there the floor carries
it. That is what is added here, for each reinit of a ``v`` whose derivative stands in one row ``R``:

    if at_rest then der(v) = 0 else R = 0,      support = sign * R at der(v) = 0

The support is what the row needs to be satisfied with ``der(v) = 0``; the rest ends when it would
have to pull. The simulation sets ``at_rest`` when the impacts accumulate (see
:mod:`acausal.simulation.accumulation`). Nothing changes before.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from acausal.elimination.families import row_counts, variable_slots
from acausal.expressions.build import if_, mul
from acausal.expressions.nodes import ONE, slot
from acausal.flattening.members import take_members
from acausal.flattening.model import (
    EquationFamily,
    FlatModel,
    Ids,
    Operand,
    RelationFamily,
    Rests,
)

#: A model with more reinits than this is not searched member by member.
_MOST = 2000


def with_rests(model: FlatModel) -> FlatModel:
    """Return an eliminated model in which what bounces can come to rest."""
    hybrid = model.hybrid
    if hybrid is None or not 0 < hybrid.reinits.count <= _MOST:
        return model
    rows = _rows(model, hybrid.reinits.states)
    chosen = np.flatnonzero(rows >= 0)
    _, first = np.unique(rows[chosen], return_index=True)
    chosen = chosen[np.sort(first)]
    if not len(chosen):
        return model
    k, h = len(chosen), len(hybrid.start)
    at_rest, sign, supported = (h + i * k + np.arange(k) for i in range(3))
    families: list[EquationFamily] = []
    relations: list[RelationFamily] = []
    number = np.full(model.n_rows, -1, np.int64)
    number[rows[chosen]] = np.arange(k)
    derivative = model.derivative[hybrid.reinits.states[chosen]]
    for family in model.families:
        mine = number[family.rows]
        rest = np.flatnonzero(mine < 0)
        if len(rest) == family.count:
            families.append(family)
            continue
        if len(rest):
            families.append(take_members(family, rest))
        for j in variable_slots(family):
            members = np.flatnonzero(mine >= 0)
            members = members[family.operands[j, members] == derivative[mine[members]]]
            if len(members):
                part = take_members(family, members)
                which = mine[members]
                row, relation = _row_and_support(
                    part, j, hybrid.first + at_rest[which], hybrid.first + sign[which],
                    supported[which],
                )  # fmt: skip
                families.append(row)
                relations.append(relation)
    start = np.concatenate([hybrid.start, np.zeros(k), np.ones(2 * k)])
    return replace(
        model,
        families=tuple(families),
        parameters=np.concatenate([model.parameters, start[h:]]),
        hybrid=replace(
            hybrid,
            start=start,
            relations=(*hybrid.relations, *relations),
            relevant=np.concatenate([hybrid.relevant, np.repeat([True, False], [k, 2 * k])]),
            rests=Rests(chosen, derivative, at_rest, sign, supported),
        ),
    )


def _rows(model: FlatModel, states: Ids) -> Ids:
    """Return the only row with the derivative of each state, -1 if there is not just one."""
    derivative = np.where(states >= 0, model.derivative[states], -1)
    times = np.zeros(model.variables.count, np.int64)
    row = np.full(model.variables.count, -1, np.int64)
    counts = row_counts(model.families, model.n_rows)
    for family in model.families:
        # der(v) = 0 alone: nothing that would have to be supported
        template = family.template
        free = template.op == "slot" or (template.op == "neg" and template.args[0].op == "slot")
        for j in variable_slots(family):
            np.add.at(times, family.operands[j], 2 if free else 1)
            single = counts[family.rows] == 1
            row[family.operands[j, single]] = family.rows[single]
    good = (derivative >= 0) & (times[derivative] == 1)
    return np.where(good, row[derivative], -1)


def _row_and_support(
    family: EquationFamily, j: int, at_rest: Ids, sign: Ids, supported: Ids
) -> tuple[EquationFamily, RelationFamily]:
    """Return the row that can rest, and the relation that tells whether it may."""
    m = len(family.kinds)
    flag, direction = slot(m), slot(m + 1)
    kinds = (*family.kinds, Operand.PARAMETER)
    operands = np.vstack([family.operands, at_rest])
    row = replace(
        family, template=if_(flag, slot(j), family.template), kinds=kinds, operands=operands
    )
    relation = replace(
        family,
        template=if_(flag, mul(direction, family.template), ONE),
        kinds=(*kinds, Operand.PARAMETER),
        operands=np.vstack([operands, sign]),
        rows=supported,
    )
    return row, RelationFamily(relation, "gt")
