"""Families that make no row but follow what happens to the variables: from a model and back.

Initial equations, assertions and all of the hybrid part are rewritten like the rows, group by
group. A group may come back in more parts than it went in; ``rows`` tell what each member is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from acausal.elimination.families import variable_slots
from acausal.elimination.signed_components import Signs
from acausal.events.lowering import read_by
from acausal.events.ordering import in_order
from acausal.expressions.nodes import ZERO, slot
from acausal.flattening.model import (
    Assertion,
    EquationFamily,
    FlatModel,
    Hybrid,
    Ids,
    Operand,
    Reinits,
    RelationFamily,
    Termination,
)

Group = tuple[EquationFamily, ...]
Groups = tuple[Group, ...]
_Watched = TypeVar("_Watched", Assertion, RelationFamily, Termination)


def carried(model: FlatModel) -> Groups:
    """Return all families of a model that make no row, in groups."""
    groups: list[Group] = [model.initial, *((a.family,) for a in model.assertions)]
    hybrid = model.hybrid
    if hybrid is None:
        return tuple(groups)
    reinits = hybrid.reinits
    groups += [
        _single(reinits.states),
        _single(reinits.impulses),
        reinits.values,
        reinits.fires,
        hybrid.initial_pre,
        hybrid.limits,
        hybrid.delays,
        hybrid.delay_times,
        hybrid.assignments,
        () if hybrid.initial is hybrid.assignments else hybrid.initial,
    ]
    groups += [(r.family,) for r in hybrid.relations]
    groups += [(t.family,) for t in hybrid.terminations]
    return tuple(groups)


def named_variables(model: FlatModel, groups: Groups, n: int) -> NDArray[np.bool_]:
    """Return the variables that reinits name, which have to stay, shape ``(n,)``.

    Args:
        model: The model the groups were made from.
        groups: What became of them.
        n: Number of variables.
    """
    kept = np.zeros(n, np.bool_)
    if model.hybrid is not None:
        begin = 1 + len(model.assertions)
        for group in groups[begin : begin + 2]:
            for family in group:
                kept[family.operands[variable_slots(family)].ravel()] = True
    return kept


def restored(model: FlatModel, groups: Groups, families: Group) -> FlatModel:
    """Return the model with its carried families replaced by what became of them.

    Args:
        model: The model the groups were made from.
        groups: What became of them.
        families: The rows that are left.
    """
    parts = iter(groups)
    initial = next(parts)
    assertions = _again(model.assertions, parts)
    result = replace(model, initial=initial, assertions=assertions)
    if model.hybrid is None:
        return result
    return replace(result, hybrid=_hybrid(model.hybrid, parts, families))


def _again(items: tuple[_Watched, ...], parts: Iterator[Group]) -> tuple[_Watched, ...]:
    return tuple(replace(item, family=part) for item in items for part in next(parts))


def _hybrid(hybrid: Hybrid, parts: Iterator[Group], families: Group) -> Hybrid:
    wanted = hybrid.reinits
    states, signs = _ids(wanted.states, next(parts))
    impulses, impulse_signs = _ids(wanted.impulses, next(parts))
    values, fires, initial_pre, limits, delays, delay_times, assignments, initial = (
        next(parts) for _ in range(8)
    )

    def ordered(chosen: Group) -> Group:
        # What went through a continuous variable before may be a direct dependency now.
        return in_order(chosen, hybrid.first, hybrid.n_discrete, loops_allowed=True)

    assignments = ordered(assignments)
    same = hybrid.initial is hybrid.assignments
    return replace(
        hybrid,
        reinits=Reinits(states, signs, impulses, impulse_signs, values, fires, wanted.wanted),
        initial_pre=initial_pre,
        limits=limits,
        delays=delays,
        delay_times=delay_times,
        assignments=assignments,
        initial=assignments if same else ordered(initial),
        relations=_again(hybrid.relations, parts),
        terminations=_again(hybrid.terminations, parts),
        relevant=read_by(families, hybrid.first, hybrid.count),
    )


def _single(ids: Ids) -> Group:
    """Return variables as a family, ``rows`` their places; -1 is left out."""
    places = np.flatnonzero(ids >= 0)
    if not len(places):
        return ()
    return (EquationFamily(slot(0), (Operand.VARIABLE,), ids[places][None, :], places),)


def _ids(before: Ids, group: Group) -> tuple[Ids, Signs]:
    """Return what became of variables and the signs with which others stand for them."""
    ids, signs = before.copy(), np.ones(len(before), np.int8)
    for family in group:
        if family.template is ZERO:
            signs[family.rows] = 0
            continue
        ids[family.rows] = family.operands[0]
        signs[family.rows] = 1 if family.template.op == "slot" else -1
    return ids, signs
