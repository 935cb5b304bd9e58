"""Spans of tokens and nodes, and the depth of nesting, for the callbacks of the parser."""

from __future__ import annotations

from typing import Any

from lark import Token

from acausal.diagnostics import Span, fail
from acausal.syntax import tree

MAXIMAL_NESTING = 150
"""Blocks, classes and if-expressions inside each other; deeper text is refused."""


class PlaceTracking:
    """What the callbacks of all rules share: the source and the places in it."""

    def __init__(self) -> None:
        self.begin("<text>")

    def begin(self, source: str) -> None:
        """Forget the last parse; ``source`` goes into the spans that follow."""
        self.source = source
        self._depth: dict[int, int] = {}
        self._open_ends: list[Span] = []

    def _at(self, token: Token) -> Span:
        return Span(self.source, token.line, token.column, token.end_line, token.end_column)  # type: ignore[arg-type]

    def _span(self, first: Any, last: Any) -> Span:
        """Return the span from one child to another, each a token or a node."""
        if isinstance(first, Token):
            line, column = first.line, first.column
        else:
            line, column = first.span.line, first.span.column
        if isinstance(last, Token):
            end_line, end_column = last.end_line, last.end_column
        else:
            end_line, end_column = last.span.end_line, last.span.end_column
        return Span(self.source, line, column, end_line, end_column)  # type: ignore[arg-type]

    def _whole(self, children: list[Any]) -> Span:
        """Return the span of a block, from its keyword to the one behind its ``end``."""
        last = children[-1]
        for child in reversed(children):
            if isinstance(child, Token):
                last = child
                break
        return self._span(children[0], last)

    def _between(self, left: Span, right: Span) -> Span:
        return Span(self.source, left.end_line, left.end_column, right.line, right.column)

    def _nest(self, node: tree.Node, inner: list[Any]) -> None:
        """Note how deep ``node`` is nested, and refuse what no later stage could walk.

        Raises:
            AcausalError: P026.
        """
        depths = self._depth
        depth = 1 + max((depths.get(id(child), 0) for child in inner), default=0)
        depths[id(node)] = depth
        if depth > MAXIMAL_NESTING:
            fail(
                "P026",
                f"more than {MAXIMAL_NESTING} blocks or conditions inside each other",
                node.span,
                help="split it into several classes, equations or functions",
            )
