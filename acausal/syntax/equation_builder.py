# ruff: noqa: D102 - a callback is named after its grammar rule, which says what it is
"""Callbacks of the parser for equations and statements."""

from __future__ import annotations

from typing import Any

from lark import Token

from acausal.diagnostics import fail
from acausal.syntax import tree
from acausal.syntax.expression_builder import ExpressionBuilder


class EquationBuilder(ExpressionBuilder):
    """Makes the nodes of equations and statements."""

    def simple_equation(self, children: list[Any]) -> tree.SimpleEquation:
        left, right = children[0], children[2]
        return tree.SimpleEquation(left.span.to(right.span), _description(children), left, right)

    def call_equation(self, children: list[Any]) -> tree.CallEquation:
        call = children[0]
        if not isinstance(call, tree.Call):
            if isinstance(call, tree.Binary) and call.operator == "==":
                fail(
                    "P014",
                    "'==' compares two values; an equation is written with '='",
                    self._between(call.left.span, call.right.span),
                    help="write a single '='",
                )
            fail(
                "P019",
                "this is an expression, not an equation",
                call.span,
                help="an equation has the form 'left = right'",
            )
        return tree.CallEquation(call.span, _description(children), call)

    def connect_equation(self, children: list[Any]) -> tree.ConnectEquation:
        cuts = tuple(c for c in children if isinstance(c, tree.Reference))
        span = self._whole(children)
        if len(cuts) < 2:
            fail(
                "P012",
                f"connect needs at least two cuts and has {'one' if cuts else 'none'}",
                span,
                help="write connect(a.p, b.n), with as many cuts as meet at the junction",
            )
        return tree.ConnectEquation(span, _description(children), cuts)

    def tuple_target(self, children: list[Any]) -> tree.TupleExpression:
        elements: list[tree.Expression | None] = [None]
        for child in children[1:-1]:
            if isinstance(child, Token):
                elements.append(None)
            else:
                elements[-1] = child
        return tree.TupleExpression(self._span(children[0], children[-1]), tuple(elements))

    def index(self, children: list[Any]) -> tree.ForIndex:
        span = self._span(children[0], children[-1])
        return tree.ForIndex(span, str(children[0]), children[2] if len(children) > 1 else None)

    def for_equation(self, children: list[Any]) -> tree.ForEquation:
        indices, body = _loop(children)
        node = tree.ForEquation(self._whole(children), _description(children), indices, body)
        self._nest(node, children)
        return node

    def if_equation(self, children: list[Any]) -> tree.IfEquation:
        branches, otherwise = _branches(children)
        node = tree.IfEquation(self._whole(children), _description(children), branches, otherwise)
        self._nest(node, children)
        return node

    def when_equation(self, children: list[Any]) -> tree.WhenEquation:
        branches, _ = _branches(children)
        node = tree.WhenEquation(self._whole(children), _description(children), branches)
        self._nest(node, children)
        return node

    def assignment(self, children: list[Any]) -> tree.Assignment:
        target, value = children[0], children[2]
        span = target.span.to(value.span)
        if isinstance(target, tree.TupleExpression) and not isinstance(value, tree.Call):
            fail(
                "P024",
                "several names in parentheses take their values from one function call",
                value.span,
                help="write (a, b) := f(x), or one assignment for each name",
            )
        return tree.Assignment(span, _description(children), target, value)

    def assigned_tuple(self, children: list[Any]) -> tree.TupleExpression:
        return self.tuple_target(children)

    def call_statement(self, children: list[Any]) -> tree.CallStatement:
        return tree.CallStatement(children[0].span, _description(children), children[0])

    def for_statement(self, children: list[Any]) -> tree.ForStatement:
        indices, body = _loop(children)
        node = tree.ForStatement(self._whole(children), _description(children), indices, body)
        self._nest(node, children)
        return node

    def while_statement(self, children: list[Any]) -> tree.WhileStatement:
        body = tuple(c for c in children[2:] if isinstance(c, tree.Statement))
        node = tree.WhileStatement(self._whole(children), _description(children), children[1], body)
        self._nest(node, children)
        return node

    def if_statement(self, children: list[Any]) -> tree.IfStatement:
        branches, otherwise = _branches(children)
        node = tree.IfStatement(self._whole(children), _description(children), branches, otherwise)
        self._nest(node, children)
        return node

    def when_statement(self, children: list[Any]) -> tree.WhenStatement:
        branches, _ = _branches(children)
        node = tree.WhenStatement(self._whole(children), _description(children), branches)
        self._nest(node, children)
        return node

    def return_statement(self, children: list[Any]) -> tree.ReturnStatement:
        return tree.ReturnStatement(self._at(children[0]), _description(children))

    def break_statement(self, children: list[Any]) -> tree.BreakStatement:
        return tree.BreakStatement(self._at(children[0]), _description(children))


def _description(children: list[Any]) -> str:
    for child in children[-2:]:
        if type(child) is str:
            return child
    return ""


def _loop(children: list[Any]) -> tuple[tuple[tree.ForIndex, ...], tuple[Any, ...]]:
    indices = tuple(c for c in children if isinstance(c, tree.ForIndex))
    body = tuple(c for c in children if isinstance(c, tree.Equation | tree.Statement))
    return indices, body


def _branches(
    children: list[Any],
) -> tuple[tuple[tuple[Any, tuple[Any, ...]], ...], tuple[Any, ...]]:
    """Split the flat children of an if or when into conditions with bodies, and the else part."""
    branches: list[tuple[tree.Expression, list[Any]]] = []
    otherwise: list[Any] = []
    body: list[Any] = otherwise
    for child in children:
        if isinstance(child, tree.Expression):
            body = []
            branches.append((child, body))
        elif isinstance(child, tree.Equation | tree.Statement):
            body.append(child)
        elif isinstance(child, Token):
            if child.type == "ELSE":
                body = otherwise
            elif child.type == "END":
                break
    return tuple((c, tuple(b)) for c, b in branches), tuple(otherwise)
