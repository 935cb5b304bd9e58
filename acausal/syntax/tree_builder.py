# ruff: noqa: D102 - a callback is named after its grammar rule, which says what it is
"""Callbacks of the LALR parser: each reduction makes its node of :mod:`acausal.syntax.tree`.

The parser calls the method named after the rule with the list of its children: tokens that the
grammar keeps and nodes that were made before. No parse tree of Lark's own is ever built.
"""

from __future__ import annotations

from typing import Any

from acausal.diagnostics import Span, fail
from acausal.syntax import tree
from acausal.syntax.class_builder import ClassBuilder


class TreeBuilder(ClassBuilder):
    """Makes the tree of one source; call :meth:`begin` before each parse."""

    def file(self, children: list[Any]) -> tree.File:
        if self._open_ends:
            fail(
                "P024",
                "'end' as a number has a meaning only inside the brackets of a subscript",
                self._open_ends[0],
                help="write x[end], or size(x, 1) for the length of x",
            )
        within: tuple[str, ...] = ()
        imports = []
        classes = []
        for child in children:
            if isinstance(child, tree.ImportClause):
                imports.append(child)
            elif isinstance(child, tree.ClassDefinition):
                classes.append(child)
            else:
                within = child
        if children:
            first = next((c for c in children if isinstance(c, tree.Node)), None)
            span = first.span if first is not None else Span(self.source, 1, 1, 1, 1)
            if classes:
                span = span.to(classes[-1].span)
        else:
            span = Span(self.source, 1, 1, 1, 1)
        return tree.File(span, within, tuple(imports), tuple(classes))

    def expression_only(self, children: list[Any]) -> tree.Expression:
        if self._open_ends:
            fail(
                "P024",
                "'end' has a meaning only inside a subscript",
                self._open_ends[0],
                help="write x[end], or size(x, 1) for the length of x",
            )
        expression: tree.Expression = children[0]
        return expression

    def within(self, children: list[Any]) -> tuple[str, ...]:
        return tuple(str(t) for t in children[1:])
