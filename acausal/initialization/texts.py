"""Equations and unknowns of a start in the user's words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Span
from acausal.elimination.families import variable_slots
from acausal.expressions.evaluate import evaluate_all
from acausal.expressions.nodes import Expr
from acausal.expressions.text import to_text
from acausal.expressions.traverse import postorder, slots
from acausal.flattening.model import EquationFamily, Ids, Names, Operand, Origin, RowKind
from acausal.initialization.problem import AlgebraicProblem, StartEquations

Array = NDArray[np.float64]

#: How many equations, unknowns or conditions a message lists.
LIST = 5


def origin_of(family: EquationFamily, member: int) -> Origin | None:
    """Return where a member comes from."""
    for origin in family.origins:
        if origin.first <= member < origin.first + origin.count:
            return origin
    return None


def substituted(family: EquationFamily, member: int, expr: Expr, names: Names) -> str:
    """Return an expression over the slots of a family with the names of one member."""

    def name(key: object) -> str:
        assert isinstance(key, int)
        number = int(family.operands[key, member])
        if family.kinds[key] == Operand.PARAMETER:
            return names.parameter(number)
        return names.variable(number)

    return to_text(expr, name, 200)


def row_text(equations: StartEquations, row: int) -> tuple[str, Span | None]:
    """Return a global row in words: its equation and the instance, and where it is written."""
    names = equations.system.names
    for family in equations.families:
        hits = np.flatnonzero(family.rows == row)
        if hits.shape[0] == 0:
            continue
        member = int(hits[0])
        origin = origin_of(family, member)
        if origin is None or origin.kind != RowKind.JUNCTION:
            return member_text(family, member, names)
        variables = [
            names.variable(int(f.operands[j, k]))
            for f in equations.families
            for k in np.flatnonzero(f.rows == row)[:LIST].tolist()
            for j in variable_slots(f)[:1]
        ]
        return f"the sum at a junction: {listed(variables)}", origin.span
    return f"equation {row + 1}", None


def listed(items: list[str], limit: int = LIST) -> str:
    """Return items with commas, the rest counted."""
    more = len(items) - limit
    return ", ".join(items[:limit]) + (f" and {more} more" if more > 0 else "")


@dataclass(frozen=True)
class Failure:
    """An operation that has no finite value.

    Attributes:
        family: Family of the equation.
        member: Member of it.
        words: What fails, e.g. ``division by zero: x is 0``.
        variables: Variables the operation is applied to.
        parameters: Parameters it is applied to.
    """

    family: EquationFamily
    member: int
    words: str
    variables: tuple[int, ...]
    parameters: tuple[int, ...]


def first_failure(problem: AlgebraicProblem, names: Names) -> tuple[int, Failure] | None:
    """Find the operation that is not finite at the point the problem stands at.

    Returns:
        Global row and failure; None if all equations are finite.
    """
    for (family, members, target), call in zip(problem.sources, problem.calls, strict=True):
        index = call.index

        def slot_values(key: object, index: NDArray[np.int32] = index) -> Array:
            assert isinstance(key, int)
            values: Array = problem.w[index[key]]
            return values

        mine = np.flatnonzero(target < problem.n_rows)
        found = failure_of(family, members, mine, slot_values, float(problem.w[1]), names)
        if found is not None:
            place = int(np.flatnonzero(members == found.member)[0])
            return int(problem.rows[target[place]]), found
    return None


def failure_of(
    family: EquationFamily,
    members: Ids,
    among: Ids,
    slot_values: Callable[[object], Array],
    time: float,
    names: Names,
) -> Failure | None:
    """Find the first operation of a family that has finite operands and no finite result.

    Args:
        family: The family.
        members: Members that ``slot_values`` has values for, shape ``(k,)``.
        among: Which of them count, indices into ``members``.
        slot_values: Values of a slot, shape ``(k,)``.
        time: Time in s.
        names: Paths.
    """
    order = postorder(family.template)
    values = evaluate_all(tuple(order), slot_values, time)
    full = [np.broadcast_to(v, members.shape[0]) for v in values]
    bad = among[~np.isfinite(full[-1][among])]
    if bad.shape[0] == 0:
        return None
    place = int(bad[0])
    member = int(members[place])
    known = dict(zip(order, full, strict=True))
    for item in order:
        arguments = [float(known[a][place]) for a in item.args]
        if np.isfinite(known[item][place]) or not np.isfinite(arguments).all():
            continue
        culprit = item.args[1] if item.op == "div" else item
        keys = [int(key) for key in slots(culprit)]  # type: ignore[call-overload]
        sorts = {kind: [k for k in keys if family.kinds[k] == kind] for kind in Operand}
        return Failure(
            family,
            member,
            _failure(item, arguments, family, member, names),
            tuple(family.operands[sorts[Operand.VARIABLE], member].tolist()),
            tuple(family.operands[sorts[Operand.PARAMETER], member].tolist()),
        )
    return Failure(family, member, "a value is not finite", (), ())


def _failure(
    item: Expr, arguments: list[float], family: EquationFamily, member: int, names: Names
) -> str:
    parts = [substituted(family, member, argument, names) for argument in item.args]
    if item.op == "div" and arguments[1] == 0.0:
        return f"division by zero: {parts[1]} is 0"
    if item.op == "call" and len(parts) == 1:
        return f"{item.value}({parts[0]}) with {parts[0]} = {arguments[0]:g}"
    text = substituted(family, member, item, names)
    at = [
        f"{p} = {a:g}"
        for p, a, e in zip(parts, arguments, item.args, strict=True)
        if e.op != "const"
    ]
    return f"{text} with {', '.join(at)}" if at else text


def member_text(family: EquationFamily, member: int, names: Names) -> tuple[str, Span | None]:
    """Return the equation of a member in words, with its instance, and where it is written."""
    origin = origin_of(family, member)
    if origin is None:
        return f"{substituted(family, member, family.template, names)} = 0", None
    path = names.instance_path(origin.group, int(origin.instances[member - origin.first]))
    text = origin.text or f"{substituted(family, member, family.template, names)} = 0"
    return text + (f" in {path}" if path else ""), origin.span
