"""Attributes of merged variables: start, fixed, nominal, bounds, stateSelect."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Label, fail
from acausal.elimination.signed_components import Signs
from acausal.flattening.model import Ids, Names, StateSelect, Variables

#: Two fixed starts closer than this (relative) do not contradict each other.
SAME_START = 1e-9


def merged_attributes(
    variables: Variables, representative: Ids, sign: Signs, names: Names
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

    Raises:
        AcausalError: I001 if two fixed starts of one class differ, I002 if a variable that is
            always zero is to start elsewhere.
    """
    members = np.flatnonzero((representative != np.arange(representative.shape[0])) | (sign == 0))
    if members.shape[0] == 0:
        return variables
    wrong = members[
        (sign[members] == 0) & variables.fixed[members] & (variables.start[members] != 0.0)
    ]
    if wrong.shape[0]:
        _fail_zero(int(wrong[0]), variables, names)
    members = members[sign[members] != 0]
    heads = representative[members]
    signs = sign[members].astype(np.float64)
    fixed, given = variables.fixed.copy(), variables.start_given.copy()
    start, nominal = variables.start.copy(), variables.nominal.copy()
    _start(variables, members, heads, signs, start, given, fixed, names)

    other = (nominal[heads] == 1.0) & (variables.nominal[members] != 1.0)
    which, first = np.unique(heads[other], return_index=True)
    nominal[which] = variables.nominal[members[other][first]]

    minimum, maximum = variables.minimum.copy(), variables.maximum.copy()
    low, high = variables.minimum[members], variables.maximum[members]
    np.maximum.at(minimum, heads, np.where(signs > 0, low, -high))
    np.minimum.at(maximum, heads, np.where(signs > 0, high, -low))

    wish = variables.state_select.copy()
    weakest = variables.state_select.copy()
    np.maximum.at(wish, heads, variables.state_select[members])
    np.minimum.at(weakest, heads, variables.state_select[members])
    select = np.where(wish > StateSelect.DEFAULT, wish, weakest).astype(np.int8)
    return replace(
        variables,
        start=start,
        start_given=given,
        fixed=fixed,
        nominal=nominal,
        minimum=minimum,
        maximum=maximum,
        state_select=select,
    )


def _start(
    variables: Variables,
    members: Ids,
    heads: Ids,
    signs: NDArray[np.float64],
    start: NDArray[np.float64],
    given: NDArray[np.bool_],
    fixed: NDArray[np.bool_],
    names: Names,
) -> None:
    """Merge start values into ``start``, ``given`` and ``fixed``."""
    values = signs * variables.start[members]
    for strength in (variables.start_given, variables.fixed):
        strong = strength[members]
        taken = strong & ~strength[heads]
        which, first = np.unique(heads[taken], return_index=True)
        start[which] = values[taken][first]
    np.logical_or.at(given, heads, variables.start_given[members])
    np.logical_or.at(fixed, heads, variables.fixed[members])
    pinned = variables.fixed[members]
    difference = np.abs(values - start[heads])
    limit = SAME_START * np.maximum(np.abs(values), np.abs(start[heads]))
    clash = np.flatnonzero(pinned & (difference > limit))
    if clash.shape[0]:
        index = int(clash[0])
        member, head = int(members[index]), int(heads[index])
        if not variables.fixed[head]:
            rivals = members[(heads == head) & variables.fixed[members]]
            head = int(rivals[0])
        _fail_conflict(head, member, variables, names)


def _labels(pairs: list[tuple[int, str]], names: Names) -> list[Label]:
    spans = [(names.declaration(variable), text) for variable, text in pairs]
    return [Label(span, text) for span, text in spans if span is not None]


def _fail_conflict(first: int, second: int, variables: Variables, names: Names) -> None:
    a, b = names.variable(first), names.variable(second)
    p, q = variables.start[first], variables.start[second]
    fail(
        "I001",
        f"{a} and {b} are always equal (up to sign) but are to start at different values",
        names.declaration(first),
        label=f"{a} starts at {p:g}",
        labels=_labels([(second, f"{b} starts at {q:g}")], names),
        notes=[f"{a}(start = {p:g}, fixed = true), {b}(start = {q:g}, fixed = true)"],
        help=f"remove fixed = true from {a} or from {b}",
    )


def _fail_zero(variable: int, variables: Variables, names: Names) -> None:
    path, value = names.variable(variable), variables.start[variable]
    fail(
        "I002",
        f"{path} is always zero by the equations but is to start at {value:g}",
        names.declaration(variable),
        label=f"{path} starts at {value:g}",
        help=f"remove fixed = true from {path}",
    )
