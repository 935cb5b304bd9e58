"""Recognition of expressions that are linear in one slot."""

from __future__ import annotations

from acausal.expressions.build import (
    add,
    div,
    homotopy,
    if_,
    mul,
    neg,
    noevent,
    rebuild,
    smooth,
    sub,
)
from acausal.expressions.nodes import ONE, ZERO, Expr
from acausal.expressions.traverse import postorder


def split_linear(expr: Expr, slot: Expr) -> tuple[Expr, Expr] | None:
    """Return ``(a, b)`` with ``expr = a*slot + b`` and both free of ``slot``, else None.

    The test is structural: ``(x + 1)*(x - 1) - x*x`` is not found to be linear. The conditions
    of an ``if`` must be free of ``slot``. ``a`` is ``ZERO`` if ``expr`` does not contain it.
    """
    parts: dict[Expr, tuple[Expr, Expr]] = {}
    for item in postorder(expr):
        split = (ONE, ZERO) if item is slot else _split(item, [parts.get(a) for a in item.args])
        if split is not None:
            parts[item] = split
    return parts.get(expr)


def linear_coefficient(expr: Expr, slot: Expr) -> Expr | None:
    """Return ``a`` if ``expr = a*slot + b`` with ``a`` and ``b`` free of ``slot``, else None."""
    split = split_linear(expr, slot)
    return None if split is None else split[0]


def _split(expr: Expr, parts: list[tuple[Expr, Expr] | None]) -> tuple[Expr, Expr] | None:
    known = [part for part in parts if part is not None]
    if len(known) < len(parts):
        return None
    if all(a is ZERO for a, _ in known):
        return ZERO, rebuild(expr, tuple(b for _, b in known))  # slots may have cancelled
    match expr.op:
        case "add":
            (a, b), (c, d) = known
            return add(a, c), add(b, d)
        case "sub":
            (a, b), (c, d) = known
            return sub(a, c), sub(b, d)
        case "neg":
            return neg(known[0][0]), neg(known[0][1])
        case "mul":
            (a, b), (c, d) = known
            if c is ZERO:
                return mul(a, d), mul(b, d)
            return (mul(b, c), mul(b, d)) if a is ZERO else None
        case "div":
            (a, b), (c, d) = known
            return (div(a, d), div(b, d)) if c is ZERO else None
        case "if":
            (c, condition), (a, b), (e, f) = known
            return (if_(condition, a, e), if_(condition, b, f)) if c is ZERO else None
        case "homotopy":
            (a, b), (c, d) = known
            return homotopy(a, c), homotopy(b, d)
        case "noevent":
            return noevent(known[0][0]), noevent(known[0][1])
        case "smooth":
            assert isinstance(expr.value, int)
            return smooth(expr.value, known[0][0]), smooth(expr.value, known[0][1])
    return None
