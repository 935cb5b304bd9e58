"""Which equation gives each discrete variable its value: exactly one for all that are equal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Label, fail
from acausal.events.layout import Layout
from acausal.expressions import build
from acausal.expressions.linearity import split_linear
from acausal.expressions.nodes import Expr, slot
from acausal.flattening.members import renumbered, take_members
from acausal.flattening.model import (
    Discrete,
    EquationFamily,
    FlatModel,
    Ids,
    Names,
    Operand,
    Origin,
)


@dataclass(frozen=True)
class DiscreteRows:
    """Rows of the model that relate discrete variables only, and the rest.

    Attributes:
        families: Families of the rows that have a continuous variable, or none at all.
        equalities: Rows ``x - y = 0``.
        assignments: Rows solved for the variable ``rows``.
    """

    families: tuple[EquationFamily, ...]
    equalities: tuple[EquationFamily, ...]
    assignments: tuple[EquationFamily, ...]


def discrete_rows(model: FlatModel, discrete: Discrete) -> DiscreteRows:
    """Turn equations in which nothing is continuous into equations of discrete variables.

    ``discrete Real y; equation y = 2*x;`` with a discrete ``x`` is one, and whether ``x`` is
    discrete is a matter of the instance.
    """
    held = discrete.discrete
    lonely = _lonely_rows(model.families, model.n_rows, held)
    if not lonely.any():
        return DiscreteRows(model.families, (), ())
    assigned = np.zeros(len(held), np.bool_)
    for family in discrete.assignments:
        assigned[family.rows] = True
    families: list[EquationFamily] = []
    equalities: list[EquationFamily] = []
    assignments: list[EquationFamily] = []
    for family in model.families:
        own = lonely[family.rows]
        if not own.any():
            families.append(family)
            continue
        if not own.all():
            families.append(take_members(family, np.flatnonzero(~own)))
        part = take_members(family, np.flatnonzero(own))
        if (
            part.template is build.sub(slot(0), slot(1))
            and set(part.kinds) == {Operand.VARIABLE}
            and len(part.kinds) == 2
        ):
            equalities.append(part)
        else:
            solved, left = _solved(part, Operand.VARIABLE, assigned)
            assignments += solved
            if len(left):
                _fail_unsolved(part, left, model.names)
    return DiscreteRows(tuple(families), tuple(equalities), tuple(assignments))


@dataclass(frozen=True)
class InitialRows:
    """Initial equations that relate discrete variables only, and the rest, numbered anew.

    Attributes:
        families: Families of the rest.
        n_rows: Number of its rows.
        assignments: Equations solved for the discrete variable ``rows``.
        before: Equations solved for its value before the first instant.
    """

    families: tuple[EquationFamily, ...]
    n_rows: int
    assignments: tuple[EquationFamily, ...]
    before: tuple[EquationFamily, ...]


def initial_rows(model: FlatModel, discrete: Discrete) -> InitialRows:
    """Turn initial equations in which nothing is continuous into assignments.

    That a variable of a component only changes at events is not known to the class around it.
    """
    lonely = _lonely_rows(model.initial, model.n_initial, discrete.discrete)
    if not lonely.any():
        return InitialRows(model.initial, model.n_initial, (), ())
    assigned, before = np.zeros((2, len(discrete.base)), np.bool_)
    for chosen, known in ((discrete.initial, assigned), (discrete.initial_pre, before)):
        for family in chosen:
            known[family.rows] = True
    number = np.cumsum(~lonely) - 1
    families: list[EquationFamily] = []
    assignments: list[EquationFamily] = []
    pre: list[EquationFamily] = []
    for family in model.initial:
        own = lonely[family.rows]
        if not own.all():
            rest = take_members(family, np.flatnonzero(~own))
            families.append(replace(rest, rows=number[rest.rows]))
        if own.any():
            part = take_members(family, np.flatnonzero(own))
            solved, left = _solved(part, Operand.VARIABLE, assigned)
            assignments += solved
            if len(left):
                solved, left = _solved(take_members(part, left), Operand.PRE, before)
                pre += solved
            if len(left):
                _fail_unsolved(part, left, model.names)
    n_rows = int(np.count_nonzero(~lonely))
    return InitialRows(tuple(families), n_rows, tuple(assignments), tuple(pre))


def _lonely_rows(
    families: Sequence[EquationFamily], n_rows: int, held: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Mark the rows that have discrete variables and no continuous one."""
    continuous = np.zeros(n_rows, np.bool_)
    discrete = np.zeros(n_rows, np.bool_)
    for family in families:
        for kind, ids in zip(family.kinds, family.operands, strict=True):
            if kind in (Operand.VARIABLE, Operand.PRE):
                mine = held[ids]
                discrete[family.rows[mine]] = True
                if kind == Operand.VARIABLE:
                    continuous[family.rows[~mine]] = True
    return discrete & ~continuous


def _solved(
    family: EquationFamily, kind: Operand, assigned: NDArray[np.bool_]
) -> tuple[list[EquationFamily], Ids]:
    """Solve rows for a variable that nothing else defines; return what is left as well."""
    result: list[EquationFamily] = []
    left = np.arange(family.count)
    for j, own in enumerate(family.kinds):
        solution = _solution(family.template, j) if own == kind else None
        if solution is None or not len(left):
            continue
        free = ~assigned[family.operands[j, left]]
        members = left[free]
        left = left[~free]
        if len(members):
            part = take_members(family, members)
            result.append(renumbered(replace(part, rows=part.operands[j]), solution))
            assigned[part.operands[j]] = True
    return result, left


def _fail_unsolved(family: EquationFamily, left: Ids, names: Names) -> None:
    origin = origin_of(family, int(left[0]))
    ids = [row[left[0]] for kind, row in zip(family.kinds, family.operands, strict=True)
           if kind != Operand.PARAMETER]  # fmt: skip
    paths = sorted({names.variable(int(i)) for i in ids})
    fail("E026", f"an equation of discrete variables gives none of them its value: "
         f"{', '.join(paths)}", origin.span if origin else None,
         label="all that stands here only changes at events",
         help="write a single variable on the left, or remove the equation")  # fmt: skip


def _solution(template: Expr, j: int) -> Expr | None:
    split = split_linear(template, slot(j))
    if split is None or split[0].op != "const" or split[0].value == 0.0:
        return None
    return build.neg(build.div(split[1], split[0]))


def origin_of(family: EquationFamily, member: int) -> Origin | None:
    """Return where a member of a family comes from."""
    for origin in family.origins:
        if origin.first <= member < origin.first + origin.count:
            return origin
    return None


def check_definitions(
    assignments: Sequence[EquationFamily], layout: Layout, discrete: Discrete, names: Names
) -> None:
    """Refuse discrete variables with no equation, or with two.

    Args:
        assignments: Assignments of variables, ``rows`` holds variables.
        layout: Positions.
        discrete: The discrete part as collected.
        names: For messages.

    Raises:
        AcausalError: ``E020``, ``E021``.
    """
    counts = np.zeros(layout.n_classes, np.int64)
    for family in assignments:
        np.add.at(counts, layout.place[family.rows], 1)
    twice = np.flatnonzero(counts > 1)
    if len(twice):
        _fail_twice(assignments, layout, int(twice[0]), names)
    missing = np.flatnonzero(counts == 0)
    if len(missing):
        members = np.flatnonzero(layout.place == missing[0])
        path = names.variable(int(members[0]))
        others = [names.variable(int(i)) for i in members[1:4]]
        more = len(missing) - 1
        fail(
            "E020",
            f"nothing gives {path} a value",
            names.declaration(int(members[0])),
            label="it only changes at events, but no equation and no when says to what",
            notes=[
                *([f"equal to it: {', '.join(others)}"] if others else []),
                *([f"{more} more discrete variables have no equation"] if more else []),
            ],
            help="give it an equation, assign it in a when, or connect a source to it",
        )


def _fail_twice(
    assignments: Sequence[EquationFamily], layout: Layout, place: int, names: Names
) -> None:
    found: list[tuple[int, Origin | None]] = []
    for family in assignments:
        members = np.flatnonzero(layout.place[family.rows] == place)
        found += [(int(family.rows[m]), origin_of(family, int(m))) for m in members[:2]]
    (first, one), (second, other) = found[:2]
    a, b = names.variable(first), names.variable(second)
    same = a == b
    fail(
        "E021",
        f"{a} is assigned twice" if same else f"{a} and {b} are equal but both are assigned",
        other.span if other is not None else None,
        label=f"{b} gets its value here" if not same else "the second equation for it",
        labels=[Label(one.span, f"{a} gets its value here")]
        if one is not None and one.span is not None
        else [],
        help="let one equation or one when decide; put several conditions into one when with "
        "elsewhen",
    )


def targets_of(assignments: Sequence[EquationFamily]) -> Ids:
    """Return the variables that assignments give a value, ascending."""
    return np.unique(np.concatenate([np.zeros(0, np.int64), *(f.rows for f in assignments)]))
