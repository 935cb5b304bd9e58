# ruff: noqa: D102 - a callback is named after its grammar rule, which says what it is
"""Callbacks of the parser for expressions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

from lark import Token

from acausal.diagnostics import Span, fail
from acausal.syntax import tree
from acausal.syntax.place_tracking import PlaceTracking
from acausal.syntax.precedence import resolve_operators

_ESCAPES = {
    "'": "'",
    '"': '"',
    "?": "?",
    "\\": "\\",
    "a": "\a",
    "b": "\b",
    "f": "\f",
    "n": "\n",
    "r": "\r",
    "t": "\t",
    "v": "\v",
}


@dataclass(frozen=True, slots=True)
class Subscripts:
    """``[a, b]`` behind a name."""

    span: Span
    items: tuple[tree.Expression, ...]


class ExpressionBuilder(PlaceTracking):
    """Makes the nodes of expressions."""

    def simple_expression(self, children: list[Any]) -> tree.Expression:
        colons = [i for i, c in enumerate(children) if isinstance(c, Token) and c.type == "COLON"]
        if not colons:
            return resolve_operators(children, self._at)
        bounds = [-1, *colons, len(children)]
        parts = [resolve_operators(children[a + 1 : b], self._at) for a, b in pairwise(bounds)]
        step = parts[1] if len(parts) == 3 else None
        span = parts[0].span.to(parts[-1].span)
        return tree.RangeExpression(span, parts[0], step, parts[-1])

    def if_expression(self, children: list[Any]) -> tree.IfExpression:
        parts = [c for c in children if isinstance(c, tree.Expression)]
        branches = tuple(zip(parts[:-1:2], parts[1:-1:2], strict=True))
        node = tree.IfExpression(self._span(children[0], parts[-1]), branches, parts[-1])
        self._nest(node, parts)
        return node

    def number(self, children: list[Any]) -> tree.NumberLiteral:
        token = children[0]
        span = self._at(token)
        unit = None
        text = str(token)
        if token.type == "QUANTITY":
            text, _, unit = text.partition("[")
            text = text.rstrip()
            unit = unit[:-1].strip()
            if not unit:
                fail(
                    "P015",
                    "the brackets behind a number hold its unit and are empty",
                    span,
                    help=f"write {text}[1] for a number without unit, or {text}",
                )
        value = float(text)
        if value == float("inf"):
            fail(
                "P022",
                f"the number {_short(text)} is too large for a double",
                span,
                help="numbers end at 1.8e308; look for a digit too many in the exponent",
            )
        return tree.NumberLiteral(span, value, text.isdigit(), unit)

    def string(self, children: list[Any]) -> tree.StringLiteral:
        return tree.StringLiteral(self._at(children[0]), self._text(children[0]))

    def boolean(self, children: list[Any]) -> tree.BooleanLiteral:
        return tree.BooleanLiteral(self._at(children[0]), children[0].type == "TRUE")

    def end(self, children: list[Any]) -> tree.End:
        span = self._at(children[0])
        self._open_ends.append(span)
        return tree.End(span)

    def colon(self, children: list[Any]) -> tree.Colon:
        return tree.Colon(self._at(children[0]))

    def parenthesised(self, children: list[Any]) -> tree.Expression:
        # The span takes the parentheses in, so that a message never shows half of a pair.
        inner: tree.Expression = children[1]
        result = replace(inner, span=self._span(children[0], children[2]))
        depth = self._depth.get(id(inner))
        if depth is not None:
            self._depth[id(result)] = depth
        return result

    def array(self, children: list[Any]) -> tree.ArrayLiteral:
        span = self._span(children[0], children[-1])
        return tree.ArrayLiteral(span, tuple(children[1:-1]))

    def comprehension(self, children: list[Any]) -> tree.ArrayComprehension:
        span = self._span(children[0], children[-1])
        return tree.ArrayComprehension(span, children[1], tuple(children[3:-1]))

    def matrix(self, children: list[Any]) -> tree.MatrixLiteral:
        rows: list[list[tree.Expression]] = [[]]
        for child in children[1:-1]:
            if not isinstance(child, Token):
                rows[-1].append(child)
            elif child.type == "SEMICOLON":
                rows.append([])
        return tree.MatrixLiteral(
            self._span(children[0], children[-1]), tuple(tuple(row) for row in rows)
        )

    def reference(self, children: list[Any]) -> tree.Reference:
        first = children[0]
        if len(children) == 1:
            span = self._at(first)
            return tree.Reference(span, (tree.NamePart(span, str(first)),))
        absolute = first.type == "DOT"
        parts: list[tree.NamePart] = []
        for child in children[1:] if absolute else children:
            if isinstance(child, Subscripts):
                part = parts[-1]
                parts[-1] = tree.NamePart(part.span.to(child.span), part.name, child.items)
            else:
                parts.append(tree.NamePart(self._at(child), str(child)))
        start = self._at(first) if absolute else parts[0].span
        return tree.Reference(start.to(parts[-1].span), tuple(parts), absolute)

    def subscripts(self, children: list[Any]) -> Subscripts:
        start = (children[0].line, children[0].column)
        while self._open_ends:
            place = self._open_ends[-1]
            if (place.line, place.column) < start:
                break
            self._open_ends.pop()
        return Subscripts(self._span(children[0], children[-1]), tuple(children[1:-1]))

    def call(self, children: list[Any]) -> tree.Call:
        function = children[0]
        arguments = []
        named = []
        indices = []
        for child in children[1:-1]:
            if isinstance(child, tree.Expression):
                arguments.append(child)
            elif isinstance(child, tree.NamedArgument):
                named.append(child)
            elif isinstance(child, tree.ForIndex):
                indices.append(child)
        return tree.Call(
            self._span(function, children[-1]),
            function,
            tuple(arguments),
            tuple(named),
            tuple(indices),
        )

    def function_keyword(self, children: list[Any]) -> tree.Reference:
        return self.reference(children)

    def named(self, children: list[Any]) -> tree.NamedArgument:
        return tree.NamedArgument(
            self._span(children[0], children[2]), str(children[0]), children[2]
        )

    def _text(self, token: Token) -> str:
        """Return the content of a string token, escapes resolved.

        Raises:
            AcausalError: P023.
        """
        text = str(token)[1:-1]
        if "\\" not in text:
            return text
        pieces = []
        position = 0
        while True:
            slash = text.find("\\", position)
            if slash < 0:
                pieces.append(text[position:])
                return "".join(pieces)
            pieces.append(text[position:slash])
            mark = text[slash + 1]
            if mark not in _ESCAPES:
                before = text[:slash]
                line = token.line + before.count("\n")  # type: ignore[operator]
                column = (
                    len(before) - before.rfind("\n")
                    if "\n" in before
                    else token.column + 1 + len(before)  # type: ignore[operator]
                )
                fail(
                    "P023",
                    f"'\\{mark}' is not an escape sequence of a string",
                    Span(self.source, line, column, line, column + 2),
                    help="write '\\\\' for a backslash itself; known are"
                    " \\n \\t \\r \\\" \\' \\\\ \\? \\a \\b \\f \\v",
                )
            pieces.append(_ESCAPES[mark])
            position = slash + 2


def _short(text: str) -> str:
    return text if len(text) <= 24 else text[:20] + "..."
