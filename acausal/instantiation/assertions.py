"""``assert`` and the messages of ``assert`` and ``terminate``."""

from __future__ import annotations

from acausal.diagnostics import fail
from acausal.expressions.nodes import ZERO
from acausal.instantiation.expressions import Environment, elaborate, elaborate_condition
from acausal.instantiation.template import AssertDecl, Domain
from acausal.syntax import tree
from acausal.syntax.formatter import format_expression


def assertion(call: tree.Call, env: Environment, domain: Domain) -> AssertDecl | None:
    """Return ``assert(condition, message, level)``, or None if it always holds.

    Raises:
        AcausalError: ``T120`` for other arguments, ``T102`` if the condition is not Boolean.
    """
    named = {n.name: n.value for n in call.named}
    arguments = list(call.arguments)
    for missing in ("condition", "message", "level")[len(arguments) :]:
        if missing in named:
            arguments.append(named[missing])
    if len(arguments) not in (2, 3):
        fail("T120", "assert takes a condition, a message and a level", call.span,
             help='write assert(x > 0, "x must be positive")')  # fmt: skip
    condition = elaborate_condition(arguments[0], env).expr
    if condition.op == "const" and condition is not ZERO:
        return None
    warning = len(arguments) == 3 and format_expression(arguments[2]).endswith("warning")
    text = format_expression(arguments[0])
    return AssertDecl(condition, domain, message(arguments[1], env), warning, call.span, text)


def terminate_message(call: tree.Call, env: Environment) -> str:
    """Return the message of ``terminate(message)``.

    Raises:
        AcausalError: ``T120`` for other arguments.
    """
    arguments = [*call.arguments, *(n.value for n in call.named if n.name == "message")]
    if len(arguments) != 1:
        fail("T120", "terminate takes a message", call.span,
             help='write terminate("the tank is empty")')  # fmt: skip
    return message(arguments[0], env)


def message(expression: tree.Expression, env: Environment) -> str:
    """Return the fixed part of a message; what String(x) would put in is left out."""
    if isinstance(expression, tree.StringLiteral):
        return expression.value
    if isinstance(expression, tree.Binary):
        return message(expression.left, env) + message(expression.right, env)
    if isinstance(expression, tree.Reference):
        return elaborate(expression, env).text or "…"
    return "…"
