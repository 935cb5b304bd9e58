"""Equations and unknowns of a start in the user's words."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Label, Span
from acausal.elimination.families import variable_slots
from acausal.expressions.evaluate import evaluate_all
from acausal.expressions.nodes import Expr
from acausal.expressions.text import to_text
from acausal.expressions.traverse import postorder
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
        if origin is None:
            return f"{substituted(family, member, family.template, names)} = 0", None
        path = names.instance_path(origin.group, int(origin.instances[member - origin.first]))
        if origin.kind == RowKind.JUNCTION:
            variables = [
                names.variable(int(f.operands[j, k]))
                for f in equations.families
                for k in np.flatnonzero(f.rows == row)[:LIST].tolist()
                for j in variable_slots(f)[:1]
            ]
            return f"the sum at a junction: {listed(variables)}", origin.span
        text = origin.text or f"{substituted(family, member, family.template, names)} = 0"
        return f"{text}" + (f" in {path}" if path else ""), origin.span
    return f"equation {row + 1}", None


def listed(items: list[str], limit: int = LIST) -> str:
    """Return items with commas, the rest counted."""
    more = len(items) - limit
    return ", ".join(items[:limit]) + (f" and {more} more" if more > 0 else "")


def row_labels(equations: StartEquations, rows: Ids, text: str = "") -> list[Label]:
    """Return labels under the source of the first rows that have one."""
    labels: list[Label] = []
    for row in rows[:LIST].tolist():
        words, span = row_text(equations, row)
        if span is not None:
            labels.append(Label(span, text or words))
    return labels


def first_failure(
    problem: AlgebraicProblem, names: Names, row: int | None = None
) -> tuple[int, str] | None:
    """Find the operation that is not finite at the point the problem stands at.

    Args:
        problem: Equations, at some point.
        names: Paths.
        row: Only look at this row of the problem.

    Returns:
        Global row, and what fails in words; None if all equations are finite.
    """
    for (family, members, target), call in zip(problem.sources, problem.calls, strict=True):
        mine = np.flatnonzero(target < problem.n_rows)
        if row is not None:
            mine = np.flatnonzero(target == row)
        index = call.index

        def slot_values(key: object, index: NDArray[np.int32] = index) -> Array:
            assert isinstance(key, int)
            values: Array = problem.w[index[key]]
            return values

        order = postorder(family.template)
        values = evaluate_all(tuple(order), slot_values, float(problem.w[1]))
        full = [np.broadcast_to(v, index.shape[1]) for v in values]
        bad = mine[~np.isfinite(full[-1][mine])]
        if bad.shape[0] == 0:
            continue
        member = int(bad[0])
        known = dict(zip(order, full, strict=True))
        for item in order:
            arguments = [known[a][member] for a in item.args]
            if np.isfinite(known[item][member]) or not np.isfinite(arguments).all():
                continue
            words = _failure(item, arguments, family, int(members[member]), names)
            return int(problem.rows[target[member]]), words
    return None


def _failure(
    item: Expr, arguments: list[float], family: EquationFamily, member: int, names: Names
) -> str:
    parts = [substituted(family, member, argument, names) for argument in item.args]
    if item.op == "div":
        return f"division by zero: {parts[1]} is 0"
    if item.op == "call" and len(parts) == 1:
        return f"{item.value}({parts[0]}) with {parts[0]} = {arguments[0]:g}"
    text = substituted(family, member, item, names)
    at = ", ".join(f"{p} = {a:g}" for p, a in zip(parts, arguments, strict=True))
    return f"{text} with {at}"
