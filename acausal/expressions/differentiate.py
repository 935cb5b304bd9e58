"""Partial and total derivatives of expressions.

Forward propagation through the DAG: each node's derivative is built once from those of its
arguments, so shared subexpressions stay shared and the result grows linearly. Forward and not
reverse, because an ``if`` then protects the derivatives of its branches just as it protects the
branches: the derivative of ``if x > 0 then sqrt(x) else 0`` has no square root below zero either.
Sums are differentiated as a whole, so a sum of many terms costs what its terms cost.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from itertools import chain

from acausal.expressions.build import (
    add,
    call,
    div,
    homotopy,
    if_,
    mul,
    neg,
    noevent,
    power,
    relation,
    smooth,
    sub,
)
from acausal.expressions.nodes import ONE, RELATIONS, TIME, ZERO, Expr, const
from acausal.expressions.traverse import postorder

_TWO = const(2.0)
_ADDITIVE = frozenset(("add", "sub", "neg"))
_PIECEWISE_CONSTANT = frozenset(("sign", "floor", "ceil", "integer", "div"))


def partial(expr: Expr, slot: Expr) -> Expr:
    """Return the partial derivative of ``expr`` with respect to the node ``slot``."""
    return partials(expr, (slot,))[slot]


def partials(expr: Expr, slots: Iterable[Expr]) -> dict[Expr, Expr]:
    """Return the partial derivatives of ``expr`` with respect to each of ``slots``.

    Args:
        expr: The expression.
        slots: Slot nodes, or ``TIME`` for the explicit derivative by time.

    Returns:
        For each slot its partial derivative, ``ZERO`` where there is none.
    """
    wanted = tuple(dict.fromkeys(slots))
    order = postorder(expr)
    terms: dict[Expr, dict[Expr, float]] = {}
    needed = {expr}
    for item in reversed(order):  # what uses a node comes before the node
        if item in needed:
            if item.op in _ADDITIVE:
                terms[item] = _terms(item)
                needed.update(terms[item])
            else:
                needed.update(item.args)
    gradients: dict[Expr, dict[Expr, Expr]] = {slot: {slot: ONE} for slot in wanted}
    for item in order:
        if item not in needed or item in gradients:
            continue
        gradient: dict[Expr, Expr] = {}
        if item in terms:
            for term, count in terms[item].items():
                for slot, derivative in gradients[term].items():
                    added = mul(const(count), derivative)
                    gradient[slot] = add(gradient[slot], added) if slot in gradient else added
        else:
            arguments = [gradients[a] for a in item.args]
            for slot in dict.fromkeys(chain.from_iterable(arguments)):
                gradient[slot] = _chain(item, [g.get(slot, ZERO) for g in arguments])
        gradients[item] = {slot: d for slot, d in gradient.items() if d is not ZERO}
    return {slot: gradients[expr].get(slot, ZERO) for slot in wanted}


def time_derivative(expr: Expr, derivative_of: Callable[[Expr], Expr]) -> Expr:
    """Return the total derivative of ``expr`` with respect to time.

    Args:
        expr: The expression.
        derivative_of: For a slot node, the node of its time derivative; ``ZERO`` if constant.
    """
    derivative: dict[Expr, Expr] = {}
    for item in postorder(expr):
        if item.op == "slot":
            derivative[item] = derivative_of(item)
        elif item is TIME:
            derivative[item] = ONE
        else:
            derivative[item] = _chain(item, [derivative[a] for a in item.args])
    return derivative[expr]


def _terms(expr: Expr) -> dict[Expr, float]:
    """Split a sum into its terms, in the order written, each with how often it is added."""
    order: dict[Expr, None] = {}
    stack = [(expr, False)]
    while stack:
        item, expanded = stack.pop()
        if item in order:
            continue
        if expanded or item.op not in _ADDITIVE:
            order[item] = None
        else:
            stack.append((item, True))
            stack.extend((argument, False) for argument in reversed(item.args))
    count = dict.fromkeys(order, 0.0)
    count[expr] = 1.0
    for item in reversed(order):
        if item.op in ("add", "sub"):
            count[item.args[0]] += count[item]
            count[item.args[1]] += count[item] if item.op == "add" else -count[item]
        elif item.op == "neg":
            count[item.args[0]] -= count[item]
    return {i: count[i] for i in order if i.op not in _ADDITIVE and count[i] != 0.0}


def _chain(expr: Expr, d: Sequence[Expr]) -> Expr:
    """Return the derivative of an operation from the derivatives ``d`` of its arguments."""
    if all(item is ZERO for item in d):
        return ZERO
    op, args = expr.op, expr.args
    match op:
        case "add":
            return add(d[0], d[1])
        case "sub":
            return sub(d[0], d[1])
        case "neg":
            return neg(d[0])
        case "mul":
            return add(mul(d[0], args[1]), mul(args[0], d[1]))
        case "div":
            return div(sub(d[0], mul(expr, d[1])), args[1])
        case "pow":
            return _power_chain(expr, d)
        case "call":
            return _call_chain(expr, d)
        case "if":
            return if_(args[0], d[1], d[2])
        case "noevent":
            return noevent(d[0])
        case "smooth":
            assert isinstance(expr.value, int)
            return smooth(expr.value - 1, d[0]) if expr.value > 0 else d[0]
        case "homotopy":
            return homotopy(d[0], d[1])
        case "and" | "or" | "not":
            return ZERO
    if op in RELATIONS:
        return ZERO
    raise AssertionError(f"no derivative of {op}")


def _power_chain(expr: Expr, d: Sequence[Expr]) -> Expr:
    base, exponent = expr.args
    by_base = mul(mul(exponent, power(base, sub(exponent, ONE))), d[0])
    if d[1] is ZERO:
        return by_base
    return add(by_base, mul(mul(expr, call("log", base)), d[1]))


def _call_chain(expr: Expr, d: Sequence[Expr]) -> Expr:
    name = str(expr.value)
    if name in _PIECEWISE_CONSTANT:
        return ZERO
    if len(expr.args) == 1:
        if name == "exp":
            return mul(expr, d[0])
        if name == "sqrt":
            return div(d[0], mul(_TWO, expr))
        return _unary_chain(name, expr, d[0])
    a, b = expr.args
    match name:
        case "atan2":
            square = add(power(a, _TWO), power(b, _TWO))
            return div(sub(mul(b, d[0]), mul(a, d[1])), square)
        case "min":
            return if_(noevent(relation("le", a, b)), d[0], d[1])
        case "max":
            return if_(noevent(relation("ge", a, b)), d[0], d[1])
        case "mod":
            return sub(d[0], mul(call("floor", div(a, b)), d[1]))
        case "rem":
            return sub(d[0], mul(call("div", a, b), d[1]))
    raise AssertionError(f"no derivative of {name}")


def _unary_chain(name: str, expr: Expr, d: Expr) -> Expr:
    x = expr.args[0]
    match name:
        case "sin":
            return mul(call("cos", x), d)
        case "cos":
            return neg(mul(call("sin", x), d))
        case "tan":
            return mul(add(ONE, power(expr, _TWO)), d)
        case "asin":
            return div(d, call("sqrt", sub(ONE, power(x, _TWO))))
        case "acos":
            return neg(div(d, call("sqrt", sub(ONE, power(x, _TWO)))))
        case "atan":
            return div(d, add(ONE, power(x, _TWO)))
        case "sinh":
            return mul(call("cosh", x), d)
        case "cosh":
            return mul(call("sinh", x), d)
        case "tanh":
            return mul(sub(ONE, power(expr, _TWO)), d)
        case "log":
            return div(d, x)
        case "log10":
            return div(d, mul(const(math.log(10.0)), x))
        case "abs":
            return mul(call("sign", x), d)
    raise AssertionError(f"no derivative of {name}")
