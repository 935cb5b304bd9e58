"""Expressions as readable infix text with no more parentheses than needed."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Final

from acausal.expressions.nodes import Expr

# Binding strength, from loosest to tightest.
_IF, _OR, _AND, _NOT, _RELATION, _SUM, _PRODUCT, _POWER, _ATOM = range(9)

_BINARY: Final[dict[str, tuple[str, int, int, int]]] = {
    # operator: symbol, own strength, strength needed on the left and on the right
    "or": (" or ", _OR, _OR, _AND),
    "and": (" and ", _AND, _AND, _NOT),
    "lt": (" < ", _RELATION, _SUM, _SUM),
    "le": (" <= ", _RELATION, _SUM, _SUM),
    "gt": (" > ", _RELATION, _SUM, _SUM),
    "ge": (" >= ", _RELATION, _SUM, _SUM),
    "eq": (" == ", _RELATION, _SUM, _SUM),
    "ne": (" <> ", _RELATION, _SUM, _SUM),
    "add": (" + ", _SUM, _SUM, _PRODUCT),
    "sub": (" - ", _SUM, _SUM, _PRODUCT),
    "mul": ("*", _PRODUCT, _PRODUCT, _POWER),
    "div": ("/", _PRODUCT, _PRODUCT, _POWER),
    "pow": ("^", _POWER, _ATOM, _ATOM),
}


def number_text(value: float) -> str:
    """Return the shortest text that reads back as ``value``, integers without a point."""
    text = repr(float(value))
    return text[:-2] if text.endswith(".0") else text.replace("e-0", "e-").replace("e+", "e")


def to_text(
    expr: Expr, name_of_slot: Callable[[Hashable], str] = str, max_length: int = 10_000
) -> str:
    """Return ``expr`` in the notation of the modelling language.

    Args:
        expr: The expression.
        name_of_slot: Text of a slot from its key.
        max_length: Longer text ends in ``...``; a shared DAG may unfold without limit.
    """
    pieces: list[str] = []
    length = 0
    stack: list[str | tuple[Expr, int]] = [(expr, _IF)]
    while stack:
        item = stack.pop()
        if isinstance(item, str):
            pieces.append(item)
            length += len(item)
            if length > max_length:
                return "".join(pieces)[:max_length] + "..."
            continue
        strength, parts = _parts(item[0], name_of_slot)
        if strength < item[1]:
            parts = ["(", *parts, ")"]
        stack.extend(reversed(parts))
    return "".join(pieces)


def is_negative(expr: Expr) -> bool:
    """Return whether ``expr`` is a negative number."""
    return isinstance(expr.value, float) and expr.value < 0.0


def _parts(
    expr: Expr, name_of_slot: Callable[[Hashable], str]
) -> tuple[int, list[str | tuple[Expr, int]]]:
    """Return the binding strength of ``expr`` and the pieces it is written with."""
    op, args = expr.op, expr.args
    if op in _BINARY:
        symbol, strength, left, right = _BINARY[op]
        if op in ("mul", "div") and is_negative(args[0]):
            return _SUM, [(args[0], _SUM), symbol, (args[1], right)]
        return strength, [(args[0], left), symbol, (args[1], right)]
    match op:
        case "const":
            assert isinstance(expr.value, float)
            text = number_text(expr.value)
            return (_SUM if text.startswith("-") else _ATOM), [text]
        case "time":
            return _ATOM, ["time"]
        case "slot":
            return _ATOM, [name_of_slot(expr.value)]
        case "neg":
            return _SUM, ["-", (args[0], _PRODUCT)]
        case "not":
            return _NOT, ["not ", (args[0], _RELATION)]
        case "if":
            head: list[str | tuple[Expr, int]] = ["if ", (args[0], _OR), " then ", (args[1], _OR)]
            return _IF, [*head, " else ", (args[2], _IF)]
    names = {"noevent": "noEvent(", "homotopy": "homotopy(", "smooth": f"smooth({expr.value}, "}
    pieces: list[str | tuple[Expr, int]] = [names.get(op, f"{expr.value}(")]
    for number, argument in enumerate(args):
        pieces += [", ", (argument, _IF)] if number else [(argument, _IF)]
    return _ATOM, [*pieces, ")"]
