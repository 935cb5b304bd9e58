"""Equations besides ``==``: whens, choices between equations, assertions, reinits."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from acausal.compose.places import here
from acausal.compose.symbols import Equality, Invocation, Literal, Scope, Symbolic, operand
from acausal.diagnostics import Span, fail
from acausal.syntax import tree


class Statement:
    """An equation that is no ``==``."""

    __slots__ = ("_span",)

    _span: Span

    def __bool__(self) -> bool:
        fail("T150", "an equation is neither true nor false", self._span,
             help="hand it to model.equation, or yield it in equations()")  # fmt: skip

    def _equation(self, scope: Scope, description: str = "") -> tree.Equation:
        raise NotImplementedError


class CallStatement(Statement):
    """``reinit``, ``assert``, ``terminate``."""

    __slots__ = ("_call",)

    def __init__(self, call: Invocation, span: Span) -> None:
        self._call = call
        self._span = span

    def _equation(self, scope: Scope, description: str = "") -> tree.Equation:
        return tree.CallEquation(self._span, description, self._call._tree(scope, self._span))


Branch = tuple[Symbolic, tuple[Any, ...]]


class When(Statement):
    """Equations of an event, see :func:`when`."""

    __slots__ = ("_branches",)

    def __init__(self, branches: tuple[Branch, ...], span: Span) -> None:
        self._branches = branches
        self._span = span

    def elsewhen(self, condition: Any, *body: Any) -> When:
        """Add a branch for another condition; of two at one instant the first acts."""
        span = here()
        branch = (_condition(condition, span), _body(body, span))
        return When((*self._branches, branch), self._span)

    def _equation(self, scope: Scope, description: str = "") -> tree.Equation:
        return tree.WhenEquation(self._span, description, _branches(self._branches, scope))


class If(Statement):
    """A choice between equations, see :func:`if_then`."""

    __slots__ = ("_branches", "_else")

    def __init__(self, branches: tuple[Branch, ...], else_: tuple[Any, ...], span: Span) -> None:
        self._branches = branches
        self._else = else_
        self._span = span

    def else_if(self, condition: Any, *body: Any) -> If:
        """Add a branch for another condition."""
        span = here()
        branch = (_condition(condition, span), _body(body, span))
        return If((*self._branches, branch), self._else, self._span)

    def otherwise(self, *body: Any) -> If:
        """Add the equations that hold where no condition does."""
        return If(self._branches, _body(body, here()), self._span)

    def _equation(self, scope: Scope, description: str = "") -> tree.Equation:
        return tree.IfEquation(
            self._span,
            description,
            _branches(self._branches, scope),
            tuple(e._equation(scope) for e in self._else),
        )


def _branches(
    branches: tuple[Branch, ...], scope: Scope
) -> tuple[tuple[tree.Expression, tuple[tree.Equation, ...]], ...]:
    return tuple(
        (c._tree(scope, e[0]._span if e else _span_of(c)), tuple(x._equation(scope) for x in e))
        for c, e in branches
    )


def _span_of(value: Symbolic) -> Span:
    return getattr(value, "_span", None) or here()


def _condition(condition: Any, span: Span) -> Symbolic:
    if isinstance(condition, list | tuple):
        return operand(list(condition), span)
    return operand(condition, span)


def _body(body: Iterable[Any], span: Span) -> tuple[Any, ...]:
    return tuple(equations_of(body, span))


def equations_of(given: Any, span: Span) -> list[Any]:
    """Return equations from whatever they are given as: one, lists, dictionaries, generators.

    Raises:
        AcausalError: ``B110`` for what is no equation.
    """
    result: list[Any] = []
    for item in given:
        if isinstance(item, Equality | Statement):
            result.append(item)
        elif isinstance(item, dict):
            for target, value in item.items():
                result.append(Equality("==", (operand(target, span), operand(value, span)), span))
        elif isinstance(item, list | tuple) or hasattr(item, "__next__"):
            result += equations_of(item, span)
        else:
            what = f"{item!r} is no equation"
            help_ = "write left == right, with a variable or parameter of the model in it"
            if isinstance(item, bool):
                what = f"this == compares Python's own values and gives {item}"
            elif isinstance(item, Symbolic):
                help_ = "an expression states nothing; write left == right"
            fail("B110", what, getattr(item, "_span", None) or span, help=help_)
    return result


def when(condition: Any, *body: Any) -> When:
    """Return equations that act in the instant a condition becomes true.

    Args:
        condition: A relation, ``ac.sample(...)``, ``ac.initial()``, or a list of them: whichever
            becomes true.
        body: A dictionary of discrete variables and their new values, ``variable == value``,
            ``ac.reinit(...)``, ``ac.assert_(...)``, ``ac.terminate(...)``.

    Example:
        >>> import acausal as ac
        >>> ball = ac.Model("ball")
        >>> ball.h = ac.Variable(unit="m", start=1, fixed=True)
        >>> ball.v = ac.Variable(unit="m/s", start=0, fixed=True)
        >>> ball.bounces = ac.Variable(type=int, start=0, fixed=True)
        >>> ball.equation(ac.der(ball.h) == ball.v, ac.der(ball.v) == -9.81)
        >>> ball.equation(ac.when(ball.h < 0, {ball.bounces: ac.pre(ball.bounces) + 1},
        ...                       ac.reinit(ball.v, -0.8*ac.pre(ball.v))))
    """
    span = here()
    return When(((_condition(condition, span), _body(body, span)),), span)


def if_then(condition: Any, *body: Any) -> If:
    """Return equations that hold where a condition does, to go on with ``else_if``, ``otherwise``.

    Example:
        >>> import acausal as ac
        >>> clutch = ac.Model("clutch")
        >>> clutch.x, clutch.y = ac.Variable(), ac.Variable(ac.time)
        >>> clutch.equation(ac.if_then(clutch.y < 1, clutch.x == 0).otherwise(clutch.x == clutch.y))
    """
    span = here()
    return If(((_condition(condition, span), _body(body, span)),), (), span)


def reinit(x: Any, value: Any) -> CallStatement:
    """Return the statement that gives a state another value; it belongs into ``ac.when``."""
    span = here()
    return CallStatement(Invocation("reinit", (operand(x, span), operand(value, span)), span), span)


def assert_(condition: Any, message: str, warning: bool = False) -> CallStatement:
    """Return the statement that a condition holds; where it does not, the simulation fails.

    Args:
        condition: What must hold.
        message: What to say if it does not.
        warning: Only warn.
    """
    span = here()
    text = Literal(tree.StringLiteral(span, message))
    given: tuple[Symbolic, ...] = (operand(condition, span), text)
    if warning:
        from acausal.compose.symbols import GlobalName

        given = (*given, GlobalName(("AssertionLevel", "warning")))
    return CallStatement(Invocation("assert", given, span), span)


def terminate(message: str) -> CallStatement:
    """Return the statement that ends the simulation; it belongs into ``ac.when``."""
    span = here()
    text = Literal(tree.StringLiteral(span, message))
    return CallStatement(Invocation("terminate", (text,), span), span)
