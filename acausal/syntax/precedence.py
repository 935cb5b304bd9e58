"""Operator precedence of Modelica 3.6 (section 3.2) over the flat operator chains of the grammar.

From weak to strong: ``or``, ``and``, ``not``, relations, ``+ -`` (binary and sign), ``* /``, ``^``.
Relations and ``^`` do not associate; the other binary operators associate to the left. A sign
applies to the whole product behind it: ``-a*b`` is ``-(a*b)`` and ``-a^2`` is ``-(a^2)``.

Algorithm: operator precedence with two stacks (Dijkstra 1961), linear and without recursion.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from acausal.diagnostics import Span, fail
from acausal.syntax import tree

if TYPE_CHECKING:
    from lark import Token

OR, AND, NOT, RELATION, SUM, SIGN, PRODUCT, POWER = range(1, 9)

BINARY_LEVELS = {
    "or": OR,
    "and": AND,
    **dict.fromkeys(("<", "<=", ">", ">=", "==", "<>"), RELATION),
    **dict.fromkeys(("+", "-", ".+", ".-"), SUM),
    **dict.fromkeys(("*", "/", ".*", "./"), PRODUCT),
    **dict.fromkeys(("^", ".^"), POWER),
}
"""Binding strength of each binary operator."""

UNARY_LEVELS = {"not": NOT, **dict.fromkeys(("+", "-", ".+", ".-"), SIGN)}
"""Binding strength of each prefix operator."""

_NON_ASSOCIATIVE = (RELATION, POWER)


def resolve_operators(items: list[Any], place: Callable[[Token], Span]) -> tree.Expression:
    """Return the tree of a chain of operands and operator tokens.

    Args:
        items: Expressions and operator tokens, in the order of the text.
        place: Gives the span of a token.

    Raises:
        AcausalError: P018 for ``a < b < c`` and ``a^b^c``.
    """
    if len(items) == 1:
        single: tree.Expression = items[0]
        return single
    if len(items) == 3 and isinstance(items[0], tree.Expression):
        left, operator, right = items
        if isinstance(right, tree.Expression):
            return tree.Binary(left.span.to(right.span), str(operator), left, right)
    operands: list[tree.Expression] = []
    operators: list[tuple[int, Token, bool]] = []
    expects_operand = True
    for item in items:
        if isinstance(item, tree.Expression):
            operands.append(item)
            expects_operand = False
            continue
        if expects_operand:
            operators.append((UNARY_LEVELS[str(item)], item, True))
            continue
        level = BINARY_LEVELS[str(item)]
        while operators and operators[-1][0] >= level:
            if operators[-1][0] == level and level in _NON_ASSOCIATIVE:
                _refuse_chain(level, operators[-1][1], item, place)
            _reduce(operands, operators, place)
        operators.append((level, item, False))
        expects_operand = True
    while operators:
        _reduce(operands, operators, place)
    return operands[0]


def _reduce(
    operands: list[tree.Expression],
    operators: list[tuple[int, Token, bool]],
    place: Callable[[Token], Span],
) -> None:
    _, operator, unary = operators.pop()
    right = operands.pop()
    if unary:
        operands.append(tree.Unary(place(operator).to(right.span), str(operator), right))
    else:
        left = operands.pop()
        operands.append(tree.Binary(left.span.to(right.span), str(operator), left, right))


def _refuse_chain(level: int, first: Token, second: Token, place: Callable[[Token], Span]) -> None:
    if level == RELATION:
        fail(
            "P018",
            f"'{first}' and '{second}' cannot follow each other: a comparison has two sides",
            place(second),
            help="write 'a < b and b < c'",
        )
    fail(
        "P018",
        "a power of a power needs parentheses",
        place(second),
        help="write (a^b)^c or a^(b^c)",
    )
