"""Attributes of merged variables: start, fixed, nominal, bounds, stateSelect."""

from __future__ import annotations

from dataclasses import replace
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Label, fail
from acausal.elimination.signed_components import Signs
from acausal.flattening.model import Ids, Names, StateSelect, Variables

#: Two fixed starts closer than this (relative) do not contradict each other.
SAME_START = 1e-9


def merged_attributes(
    variables: Variables,
    representative: Ids,
    sign: Signs,
    names: Names,
    ids: Ids | None,
) -> Variables:
    """Return attributes in which each representative speaks for its class.

    A fixed start beats a given one, a given one a default; among equals the representative's
    own, then the lowest id. Bounds are intersected. Of ``stateSelect`` the strongest wish
    counts: anything above default, else anything below. The nominal value is the
    representative's own unless that is 1, the neutral default.

    Args:
        variables: Attributes before.
        representative: Who stands for each variable, shape ``(n,)``.
        sign: 1, -1, or 0 for a known zero, shape ``(n,)``.
        names: For messages.
        ids: Number of each variable in ``names``; its own if None.

    Raises:
        AcausalError: I001 if two fixed starts of one class differ, I002 if a variable that is
            always zero is to start elsewhere.
    """
    telling = variables.start_given | variables.fixed
    telling |= variables.nominal != 1.0
    telling |= variables.minimum > -np.inf
    telling |= variables.maximum < np.inf
    telling |= variables.state_select != StateSelect.DEFAULT
    members = np.flatnonzero(telling)
    members = members[(representative[members] != members) | (sign[members] == 0)]
    if members.shape[0] == 0:
        return variables
    wrong = members[
        (sign[members] == 0) & variables.fixed[members] & (variables.start[members] != 0.0)
    ]
    if wrong.shape[0]:
        _fail_zero(int(wrong[0]), variables, names, ids)
    members = members[sign[members] != 0]
    changes: dict[str, NDArray[np.generic]] = {}
    told = members[variables.start_given[members] | variables.fixed[members]]
    if told.shape[0]:
        changes |= _start(variables, told, representative[told], sign[told], names, ids)

    told = members[variables.nominal[members] != 1.0]
    told = told[variables.nominal[representative[told]] == 1.0]
    if told.shape[0]:
        nominal = variables.nominal.copy()
        which, first = np.unique(representative[told], return_index=True)
        nominal[which] = variables.nominal[told[first]]
        changes["nominal"] = nominal

    told = members[
        np.isfinite(variables.minimum[members]) | np.isfinite(variables.maximum[members])
    ]
    if told.shape[0]:
        minimum, maximum = variables.minimum.copy(), variables.maximum.copy()
        low, high = variables.minimum[told], variables.maximum[told]
        heads, positive = representative[told], sign[told] > 0
        np.maximum.at(minimum, heads, np.where(positive, low, -high))
        np.minimum.at(maximum, heads, np.where(positive, high, -low))
        changes |= {"minimum": minimum, "maximum": maximum}

    told = members[
        variables.state_select[members] != variables.state_select[representative[members]]
    ]
    if told.shape[0]:
        strongest, weakest = variables.state_select.copy(), variables.state_select.copy()
        np.maximum.at(strongest, representative[told], variables.state_select[told])
        np.minimum.at(weakest, representative[told], variables.state_select[told])
        select = np.where(strongest > StateSelect.DEFAULT, strongest, weakest)
        changes["state_select"] = select.astype(np.int8)
    return replace(variables, **changes)  # type: ignore[arg-type]


def _start(
    variables: Variables,
    members: Ids,
    heads: Ids,
    sign: Signs,
    names: Names,
    ids: Ids | None,
) -> dict[str, NDArray[np.generic]]:
    """Return merged start values, and whether they are given and fixed."""
    start, given = variables.start.copy(), variables.start_given.copy()
    fixed = variables.fixed.copy()
    values = sign * variables.start[members]
    for strength in (variables.start_given, variables.fixed):
        taken = strength[members] & ~strength[heads]
        which, first = np.unique(heads[taken], return_index=True)
        start[which] = values[taken][first]
    np.logical_or.at(given, heads, variables.start_given[members])
    np.logical_or.at(fixed, heads, variables.fixed[members])
    difference = np.abs(values - start[heads])
    limit = SAME_START * np.maximum(np.abs(values), np.abs(start[heads]))
    clash = np.flatnonzero(variables.fixed[members] & (difference > limit))
    if clash.shape[0]:
        member, head = int(members[clash[0]]), int(heads[clash[0]])
        if not variables.fixed[head]:
            head = int(members[(heads == head) & variables.fixed[members]][0])
        _fail_conflict(head, member, variables, names, ids)
    return {"start": start, "start_given": given, "fixed": fixed}


def _fail_conflict(
    first: int, second: int, variables: Variables, names: Names, ids: Ids | None
) -> NoReturn:
    p, q = variables.start[first], variables.start[second]
    if ids is not None:
        first, second = int(ids[first]), int(ids[second])
    a, b = names.variable(first), names.variable(second)
    other = names.declaration(second)
    fail(
        "I001",
        f"{a} and {b} are always equal (up to sign) but are to start at different values",
        names.declaration(first),
        label=f"{a} starts at {p:g}",
        labels=[Label(other, f"{b} starts at {q:g}")] if other is not None else [],
        notes=[f"{a}(start = {p:g}, fixed = true), {b}(start = {q:g}, fixed = true)"],
        help=f"remove fixed = true from {a} or from {b}",
    )


def _fail_zero(variable: int, variables: Variables, names: Names, ids: Ids | None) -> NoReturn:
    value = variables.start[variable]
    if ids is not None:
        variable = int(ids[variable])
    path = names.variable(variable)
    fail(
        "I002",
        f"{path} is always zero by the equations but is to start at {value:g}",
        names.declaration(variable),
        label=f"{path} starts at {value:g}",
        help=f"remove fixed = true from {path}",
    )
