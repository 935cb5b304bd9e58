"""Walks over expressions, with explicit stacks: an expression may be thousands of levels deep."""

from __future__ import annotations

from collections.abc import Hashable, Mapping

from acausal.expressions.build import rebuild
from acausal.expressions.nodes import Expr


def postorder(*roots: Expr) -> list[Expr]:
    """Return every node below ``roots`` once, arguments before what uses them."""
    done: set[Expr] = set()
    order: list[Expr] = []
    for root in roots:
        stack: list[tuple[Expr, bool]] = [(root, False)]
        while stack:
            expr, expanded = stack.pop()
            if expr in done:
                continue
            if expanded or not expr.args:
                done.add(expr)
                order.append(expr)
                continue
            stack.append((expr, True))
            for argument in reversed(expr.args):
                if argument not in done:
                    stack.append((argument, False))
    return order


def slot_nodes(*roots: Expr) -> tuple[Expr, ...]:
    """Return the slot nodes below ``roots`` in the order of their first appearance."""
    return tuple(expr for expr in postorder(*roots) if expr.op == "slot")


def slots(*roots: Expr) -> tuple[Hashable, ...]:
    """Return the keys of the slots below ``roots`` in the order of their first appearance."""
    return tuple(expr.value for expr in slot_nodes(*roots))


def substitute(expr: Expr, mapping: Mapping[Expr, Expr]) -> Expr:
    """Return ``expr`` with every node that is a key of ``mapping`` replaced by its value.

    The replacements are made at once: what is put in is not searched again.
    """
    return substitute_all((expr,), mapping)[0]


def substitute_all(exprs: tuple[Expr, ...], mapping: Mapping[Expr, Expr]) -> tuple[Expr, ...]:
    """Return ``substitute`` of several expressions, which share what they have in common."""
    result: dict[Expr, Expr] = {}
    for item in postorder(*exprs):
        replacement = mapping.get(item)
        if replacement is None:
            replacement = (
                rebuild(item, tuple([result[a] for a in item.args])) if item.args else item
            )
        result[item] = replacement
    return tuple(result[expr] for expr in exprs)


def size(*roots: Expr) -> int:
    """Return the number of different nodes below ``roots``."""
    return len(postorder(*roots))


def depends_on(expr: Expr, slot: Expr) -> bool:
    """Return whether the node ``slot`` (or any other leaf, such as ``TIME``) is in ``expr``."""
    seen = {expr}
    stack = [expr]
    while stack:
        item = stack.pop()
        if item is slot:
            return True
        for argument in item.args:
            if argument not in seen:
                seen.add(argument)
                stack.append(argument)
    return False
