"""Equations of variables that change at events only: which side is set to which."""

from __future__ import annotations

from acausal.diagnostics import Span, fail
from acausal.expressions.nodes import Expr
from acausal.instantiation.event_operators import lone
from acausal.instantiation.sinks import Name, Sink, name_of
from acausal.instantiation.template import DiscreteDecl, Domain, Ref
from acausal.instantiation.values import Value
from acausal.syntax import tree
from acausal.syntax.formatter import format_expression


def type_text(value: Value) -> str:
    """Return the type of a value as a user would name it."""
    return value.enumeration.name if value.enumeration is not None else value.type


def check_assignable(target: Value, value: Value, what: str, span: Span) -> None:
    """Refuse a value of another type than its target.

    Raises:
        AcausalError: ``T101``, with the way to convert it.
    """
    if target.type == value.type and target.enumeration is value.enumeration:
        return
    if target.type == "Real" and value.type == "Integer":
        return
    if target.type == "Integer" and value.type == "Real":
        fail("T101", f"{what} is an Integer, its value is Real", span,
             help="write integer(...) to cut off the fraction")  # fmt: skip
    if target.type == "Integer" and value.type == "enumeration":
        fail("T101", f"{what} is an Integer, its value is a {type_text(value)}", span,
             help="write Integer(...) for the number of an enumeration value")  # fmt: skip
    numbers = {target.type, value.type} <= {"Real", "Integer", "Boolean"}
    fail("T101", f"{what} is {type_text(target)}, its value {type_text(value)}", span,
         help="write if b then 1 else 0, or compare a number: x > 0" if numbers
         else "give a value of its type")  # fmt: skip


def is_discrete_equation(left: Value, right: Value, equation: tree.SimpleEquation) -> bool:
    """Tell whether an equation is between values that change at events only.

    Raises:
        AcausalError: ``T101`` if the types of the two sides do not fit.
    """
    for value, side in ((left, equation.left), (right, equation.right)):
        if value.type in ("String", "record"):
            fail("T101", f"an equation needs numbers, not {value.type}", side.span,
                 help="texts and components have no equations")  # fmt: skip
    if {left.type, right.type} <= {"Real", "Integer"}:
        return left.type == right.type == "Integer"
    check_assignable(left, right, format_expression(equation.left), equation.span)
    return True


def check_whole(
    one: Expr, other: Expr, left: Value, right: Value, equation: tree.SimpleEquation
) -> None:
    """Refuse to set an Integer variable to a Real expression.

    Raises:
        AcausalError: ``T101``.
    """
    if left.type == "Integer" and lone(one) is not None and lone(other) is None:
        check_assignable(left, right, format_expression(equation.left), equation.span)


def _target(expr: Expr, initial: bool) -> Ref | None:
    """Return the variable that an equation may define, in initial equations also before it."""
    ref = expr.value
    if initial and isinstance(ref, Ref) and expr.op == "slot" and not ref.parameter:
        return None if ref.order else ref
    return lone(expr)


def sets_held(one: Expr, other: Expr, held: frozenset[Name]) -> bool:
    """Tell whether an initial equation of Reals is about a variable that whens set."""
    for expr in (one, other):
        ref = _target(expr, True)
        if ref is not None and (ref.pre or name_of(ref) in held):
            return True
    return False


def definition(
    one: Expr, other: Expr, discrete: bool, domain: Domain, equation: tree.SimpleEquation,
    text: str, owner: str, sink: Sink,
) -> DiscreteDecl | None:  # fmt: skip
    """Return the assignment that an equation between discrete values stands for.

    Raises:
        AcausalError: ``E005`` if neither side is a single variable, ``B103`` and ``B104`` for an
            equation without a variable.
    """
    left, right = _target(one, sink.initial), _target(other, sink.initial)
    if not discrete:  # only what whens set can be the target
        left = left if left is not None and _is_held(left, sink.held) else None
        right = right if right is not None and _is_held(right, sink.held) else None
    if one is other:
        fail("B103", "this equation says nothing: both sides are the same", equation.span,
             help="remove it")  # fmt: skip
    if left is None and right is None:
        if one.op == other.op == "const":
            fail("B104", "this equation can never hold: both sides are different values",
                 equation.span, help="an unknown is missing in it")  # fmt: skip
        fail("E005", "this equation does not say which variable it sets", equation.span,
             label="neither side is a single variable",
             help="write b = ... for an Integer, Boolean or enumeration variable b")  # fmt: skip
    target, value = (one, other) if left is not None else (other, one)
    both = discrete and left is not None and right is not None
    symmetric = both and not (left and left.pre) and not (right and right.pre)
    return DiscreteDecl(target, value, domain, equation.span, text, owner, symmetric=symmetric)


def _is_held(ref: Ref, held: frozenset[Name]) -> bool:
    return ref.pre or name_of(ref) in held


def assignment(
    one: Expr, other: Expr, left: Value, right: Value, domain: Domain,
    equation: tree.SimpleEquation, text: str, owner: str,
) -> DiscreteDecl:  # fmt: skip
    """Return an equation inside a when, which sets the variable on its left.

    Raises:
        AcausalError: ``E014`` if there is no single variable on its left, ``T101`` if the value
            has another type.
    """
    if lone(one) is None:
        fail("E014", "an equation in a when sets the variable on its left", equation.left.span,
             label="this is not a single variable", help="write v = ...")  # fmt: skip
    check_assignable(left, right, format_expression(equation.left), equation.span)
    return DiscreteDecl(one, other, domain, equation.span, text, owner, held=True)
