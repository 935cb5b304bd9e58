"""Syntax of expressions to values: names resolved, arrays made elementwise, units checked."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np

from acausal.diagnostics import Span, fail
from acausal.expressions import build
from acausal.expressions.nodes import ONE, TIME, ZERO, Expr, const
from acausal.instantiation import unit_algebra as units
from acausal.instantiation.arrays import (
    LONGEST_REDUCTION,
    as_matrix,
    common_type,
    concatenate,
    mapped,
    matrix_product,
    require_shape,
    settled,
    shape_text,
    stack,
    too_long,
)
from acausal.instantiation.domain import has_loops
from acausal.instantiation.template import Ref
from acausal.instantiation.values import (
    LITERAL,
    Index,
    NeedsUnroll,
    Value,
    constants,
    number,
    scalar,
    string,
    table,
)
from acausal.syntax import tree
from acausal.syntax.formatter import format_expression
from acausal.units.unit import UnitError, parse_unit, to_si

#: The unit of time.
SECOND = (0, 0, 1, 0, 0, 0, 0)

_RELATIONS = {"<": "lt", "<=": "le", ">": "gt", ">=": "ge", "==": "eq", "<>": "ne"}


class Environment(Protocol):
    """Where names get their meaning."""

    def reference(self, reference: tree.Reference) -> Value:
        """Return the value of a component reference."""

    def call(self, call: tree.Call) -> Value:
        """Return the value of a function call."""

    def stored(self, reference: tree.Reference) -> Value:
        """Return the variable that a reference names, whatever was assigned to it."""

    def signal(self, kind: str, operands: tuple[Expr, ...], source: tree.Expression) -> Expr:
        """Return the slot of a signal, see :class:`~acausal.instantiation.template.Signal`."""

    def events(self, call: tree.Call) -> None:
        """Refuse an operator of hybrid systems where there are no events."""

    def is_discrete(self, ref: Ref) -> bool:
        """Tell whether a variable is declared to change at events only."""

    def component_shape(self, reference: tree.Reference) -> tuple[int, ...] | None:
        """Return the array dimensions of a component that is no value; None for anything else."""

    def with_locals(self, values: dict[str, Value]) -> Environment:
        """Return the environment with names that hide others (loop and reduction indices)."""


def elaborate(expression: tree.Expression, env: Environment) -> Value:
    """Return the value of an expression.

    Raises:
        AcausalError: For unknown names (``N1xx``), wrong types and sizes (``T1xx``) and units
            (``U1xx``).
        NeedsUnroll: If a loop index meets an array that is written out.
    """
    return _handlers[type(expression)](expression, env)


def elaborate_real(expression: tree.Expression, env: Environment) -> Value:
    """Like :func:`elaborate`, but refuse strings, Booleans and records."""
    value = elaborate(expression, env)
    if value.type in ("Real", "Integer"):
        return value
    fail(
        "T101",
        f"a number is needed, not {_article(value)}",
        expression.span,
        help="compare or convert it, or use if c then 1 else 0",
    )


def elaborate_condition(expression: tree.Expression, env: Environment) -> Value:
    """Like :func:`elaborate`, for a scalar Boolean."""
    value = elaborate(expression, env)
    if value.type != "Boolean" or value.shape:
        fail(
            "T102",
            f"a condition must be true or false, not {_article(value)}",
            expression.span,
            help="write a comparison, such as x > 0",
        )
    return value


def constant_number(expression: tree.Expression, env: Environment, what: str) -> float:
    """Return the number of an expression that must be known at compile time.

    Raises:
        AcausalError: ``T103`` if it depends on a variable or on a real parameter.
    """
    value = elaborate(expression, env)
    numbers = constants(value)
    if numbers is None and not value.shape and has_loops(value.expr):
        raise NeedsUnroll
    if numbers is None or numbers.shape:
        fail(
            "T103",
            f"{what} must be a number known before the simulation",
            expression.span,
            label="this depends on something that can change",
            help="use Integer parameters and constants here",
        )
    return float(numbers)


def _article(value: Value) -> str:
    kind = {"enumeration": "an enumeration value", "record": "a record"}.get(
        value.type, f"a {value.type}"
    )
    return kind if not value.shape else f"an array of {shape_text(value.shape)}"


# --- literals ----------------------------------------------------------------------------


def _number(e: tree.NumberLiteral, env: Environment) -> Value:
    if e.unit is None:
        return number(e.value, "Integer" if e.integer else "Real")
    try:
        unit = parse_unit(e.unit)
    except UnitError as error:
        fail(
            "U104",
            f"{e.unit} is not a unit",
            e.span,
            notes=[str(error)],
            help=(
                f"write {error.suggestions[0]}"
                if error.suggestions
                else "units are written as in N.m/rad, m/s2, kOhm, 1/min"
            ),
        )
    return number(float(to_si(e.value, unit)), "Real", unit.dimension)


def _string(e: tree.StringLiteral, env: Environment) -> Value:
    return string(e.value)


def _boolean(e: tree.BooleanLiteral, env: Environment) -> Value:
    return number(float(e.value), "Boolean", None)


def _reference(e: tree.Reference, env: Environment) -> Value:
    if len(e.parts) == 1 and e.parts[0].name == "time" and not e.absolute:
        # Without a unit: people write sin(time) and x = 2*time, and mean numbers.
        return scalar(TIME, "Real", None)
    return env.reference(e)


# --- operators ---------------------------------------------------------------------------


def _unary(e: tree.Unary, env: Environment) -> Value:
    operand = elaborate(e.operand, env)
    if e.operator == "not":
        if operand.type != "Boolean":
            fail("T102", f"not needs a Boolean, not {_article(operand)}", e.span,
                 help="write a comparison, such as not x > 0")  # fmt: skip
        return mapped(build.not_, "Boolean", None, operand)
    _need_numbers(operand, e.operand.span, e.operator)
    if e.operator.endswith("+"):
        return operand
    return mapped(build.neg, operand.type, operand.unit, operand)


def _need_numbers(value: Value, span: Span, operator: str) -> None:
    if value.type not in ("Real", "Integer"):
        fail(
            "T101",
            f"{operator} needs numbers, not {_article(value)}",
            span,
            help="use a number here; Booleans become one with if c then 1 else 0",
        )


def _binary(e: tree.Binary, env: Environment) -> Value:
    left = elaborate(e.left, env)
    right = elaborate(e.right, env)
    op = e.operator
    if op in _RELATIONS:
        return _relation(e, left, right)
    if op in ("and", "or"):
        for value, part in ((left, e.left), (right, e.right)):
            if value.type != "Boolean":
                fail("T102", f"{op} needs Booleans, not {_article(value)}", part.span,
                     help="write a comparison, such as x > 0")  # fmt: skip
        return mapped(build.and_ if op == "and" else build.or_, "Boolean", None, left, right)
    if op == "+" and left.text is not None and right.text is not None:
        return string(left.text + right.text)
    _need_numbers(left, e.left.span, op)
    _need_numbers(right, e.right.span, op)
    both = "Integer" if left.type == right.type == "Integer" else "Real"
    if op in ("+", "-", ".+", ".-"):
        if left.shape != right.shape and (op in ("+", "-") or (left.shape and right.shape)):
            require_shape(right, left.shape, f"{op} of unlike sizes", e.span)
        unit = units.added(
            left.unit, right.unit, "adding" if "+" in op else "subtracting", "U101",
            e.span, e.left.span, e.right.span,
        )  # fmt: skip
        return mapped(build.add if "+" in op else build.sub, both, unit, left, right)
    if op == "*" and left.shape and right.shape:
        return matrix_product(left, right, e.span)
    if op in ("*", ".*"):
        if left.shape and right.shape:
            require_shape(right, left.shape, "elementwise product", e.span)
        return mapped(build.mul, both, units.times(left.unit, right.unit), left, right)
    if op in ("/", "./"):
        if right.shape and op == "/":
            fail("T105", "an array cannot be a divisor", e.right.span,
                 help="use ./ to divide element by element")  # fmt: skip
        if left.shape and right.shape:
            require_shape(right, left.shape, "elementwise quotient", e.span)
        return mapped(build.div, "Real", units.over(left.unit, right.unit), left, right)
    if op in ("^", ".^"):
        if op == "^" and left.shape:
            return _matrix_power(left, right, e)
        units.pure(right.unit, "an exponent", e.right.span)
        exponent = right.expr if not right.shape else None
        known = exponent is not None and exponent.op == "const"
        constant = build.number_of(exponent) if exponent is not None and known else None
        return mapped(build.power, "Real", units.raised(left.unit, constant), left, right)
    raise AssertionError(op)


def _relation(e: tree.Binary, left: Value, right: Value) -> Value:
    if left.text is not None and right.text is not None and e.operator in ("==", "<>"):
        return number(float((left.text == right.text) == (e.operator == "==")), "Boolean", None)
    if (left.type == "enumeration") != (right.type == "enumeration") or (
        left.enumeration is not right.enumeration
    ):
        fail("T106", f"cannot compare {_article(left)} with {_article(right)}", e.span,
             help="compare values of one type")  # fmt: skip
    if (left.type == "Boolean") != (right.type == "Boolean"):
        fail("T106", f"cannot compare {_article(left)} with {_article(right)}", e.span,
             help="a Boolean is compared with true, false or another Boolean")  # fmt: skip
    if left.shape or right.shape:
        fail("T106", "arrays cannot be compared", e.span, help="compare their elements")
    units.added(left.unit, right.unit, "comparing", "U105", e.span, e.left.span, e.right.span)
    return mapped(
        lambda a, b: build.relation(_RELATIONS[e.operator], a, b), "Boolean", None, left, right
    )


def _matrix_power(left: Value, right: Value, e: tree.Binary) -> Value:
    exponent = right.expr
    if len(left.shape) != 2 or left.shape[0] != left.shape[1] or exponent.op != "const":
        fail("T105", "only a square matrix has a power, with a constant whole exponent", e.span,
             help="use .^ to raise element by element")  # fmt: skip
    n = int(build.number_of(exponent))
    result = table(np.eye(left.shape[0]), "Real", LITERAL)
    for _ in range(n):
        result = matrix_product(result, left, e.span)
    return result


# --- conditionals and arrays -------------------------------------------------------------


def _if(e: tree.IfExpression, env: Environment) -> Value:
    chosen: list[tuple[Value, Value, tree.Expression]] = []
    otherwise: tuple[Value, tree.Expression] | None = None
    for condition, result in e.branches:
        c = elaborate_condition(condition, env)
        if c.expr.op == "const":
            if c.expr is ZERO:
                continue
            otherwise = (elaborate(result, env), result)
            break
        chosen.append((c, elaborate(result, env), result))
    if otherwise is None:
        otherwise = (elaborate(e.otherwise, env), e.otherwise)
    value, last = otherwise
    for condition_value, branch, source in reversed(chosen):
        if branch.type in ("String", "record") or value.type in ("String", "record"):
            fail("T108", "such an if must be decided before the simulation", e.span,
                 help="use a parameter or constant in the condition")  # fmt: skip
        require_shape(branch, value.shape, "the branches of an if differ", source.span)
        unit = units.added(
            branch.unit, value.unit, "an if gives", "U101", e.span, source.span, last.span
        )
        type_ = common_type([value, branch], [last.span, source.span])
        enumeration = value.enumeration
        value = mapped(build.if_, type_, unit, condition_value, branch, value)
        if enumeration is not None:
            value = replace(value, enumeration=enumeration)
    return value


def _range(e: tree.RangeExpression, env: Environment) -> Value:
    start = constant_number(e.start, env, "the start of a range")
    stop = constant_number(e.stop, env, "the end of a range")
    step = 1.0 if e.step is None else constant_number(e.step, env, "the step of a range")
    if step == 0.0:
        fail("T109", "the step of a range is 0", e.span, help="use a step above or below 0")
    count = max(0, int(np.floor((stop - start) / step * (1 + 1e-14) + 1e-10)) + 1)
    whole = all(v == int(v) for v in (start, step))
    return table(
        start + step * np.arange(count, dtype=np.float64), "Integer" if whole else "Real", LITERAL
    )


def _array(e: tree.ArrayLiteral, env: Environment) -> Value:
    values = [elaborate(x, env) for x in e.elements]
    return stack(values, [x.span for x in e.elements], e.span)


def _number_array(e: tree.NumberArray, env: Environment) -> Value:
    numbers = np.frombuffer(e.data, np.float64).reshape(e.shape)
    if e.unit is None:
        return table(numbers, "Integer" if e.integer else "Real", LITERAL)
    unit = parse_unit(e.unit)
    return table(np.asarray(to_si(numbers, unit)), "Real", unit.dimension)


def _comprehension(e: tree.ArrayComprehension, env: Environment) -> Value:
    ranges = [iteration(i, env) for i in e.indices]
    # Lazy: the element is elaborated again for every subscript asked for, loop indices included.
    shape = tuple(r.size for r in ranges)
    first = elaborate(
        e.element,
        env.with_locals({i.name: _item(r, ONE) for i, r in zip(e.indices, ranges, strict=True)}),
    ) if all(shape) else number(0.0)  # fmt: skip
    outer = len(shape)

    def get(index: Index) -> Expr:
        own = {i.name: _item(r, x) for i, r, x in zip(e.indices, ranges, index, strict=False)}
        return elaborate(e.element, env.with_locals(own)).get(index[outer:])

    result = settled(Value(first.type, (*shape, *first.shape), get, first.unit))
    return replace(result, enumeration=first.enumeration)


def iteration(index: tree.ForIndex, env: Environment) -> Value:
    """Return the values a loop index takes, a constant vector.

    Raises:
        AcausalError: ``T111`` if it has no range, ``T103`` if the range is not constant.
    """
    if index.range is None:
        fail("T111", f"the loop index {index.name} has no range", index.span,
             help=f"write for {index.name} in 1:n")  # fmt: skip
    value = elaborate(index.range, env)
    if len(value.shape) != 1:
        fail("T111", f"{index.name} must run over a vector", index.range.span,
             help=f"write for {index.name} in 1:n")  # fmt: skip
    return value


def _item(values: Value, index: Expr) -> Value:
    return scalar(values.get((index,)), values.type, values.unit, values.enumeration)


def passes(
    indices_: tuple[tree.ForIndex, ...], env: Environment, span: Span
) -> list[dict[str, Value]]:
    """Return the names and values of every pass of a reduction or unrolled loop."""
    ranges = [iteration(i, env) for i in indices_]
    total = int(np.prod([r.size for r in ranges]))
    if total > LONGEST_REDUCTION:
        too_long(total, span)
    names = [i.name for i in indices_]
    return [
        dict(zip(names, combination, strict=True))
        for combination in itertools.product(
            *([_item(r, const(float(k))) for k in range(1, r.size + 1)] for r in ranges)
        )
    ]


def _matrix(e: tree.MatrixLiteral, env: Environment) -> Value:
    rows = []
    for row in e.rows:
        parts = [as_matrix(elaborate(x, env)) for x in row]
        rows.append(concatenate(2, parts, [x.span for x in row]))
    return concatenate(1, rows, [r[0].span for r in e.rows])


def _call(e: tree.Call, env: Environment) -> Value:
    return env.call(e)


def _refuse(e: tree.Expression, env: Environment) -> Value:
    fail("T112", f"{format_expression(e)} has no meaning here", e.span,
         help=": and end belong into subscripts")  # fmt: skip


class EndEnvironment:
    """An environment in which ``end`` has a value."""

    def __init__(self, env: Environment, end: int) -> None:
        self._env = env
        self.end = end

    def reference(self, reference: tree.Reference) -> Value:
        """Return the value of a component reference."""
        return self._env.reference(reference)

    def stored(self, reference: tree.Reference) -> Value:
        """Return the variable that a reference names."""
        return self._env.stored(reference)

    def signal(self, kind: str, operands: tuple[Expr, ...], source: tree.Expression) -> Expr:
        """Return the slot of a signal."""
        return self._env.signal(kind, operands, source)

    def events(self, call: tree.Call) -> None:
        """Refuse an operator of hybrid systems where there are no events."""
        self._env.events(call)

    def is_discrete(self, ref: Ref) -> bool:
        """Tell whether a variable is declared to change at events only."""
        return self._env.is_discrete(ref)

    def call(self, call: tree.Call) -> Value:
        """Return the value of a function call."""
        return self._env.call(call)

    def component_shape(self, reference: tree.Reference) -> tuple[int, ...] | None:
        """Return the array dimensions of a component."""
        return self._env.component_shape(reference)

    def with_locals(self, values: dict[str, Value]) -> Environment:
        """Return the environment with names that hide others."""
        return EndEnvironment(self._env.with_locals(values), self.end)


def _end(e: tree.Expression, env: Environment) -> Value:
    if isinstance(env, EndEnvironment):
        return number(float(env.end), "Integer")
    return _refuse(e, env)


_handlers: dict[type[tree.Expression], Callable[..., Value]] = {
    tree.NumberLiteral: _number,
    tree.StringLiteral: _string,
    tree.BooleanLiteral: _boolean,
    tree.Reference: _reference,
    tree.Unary: _unary,
    tree.Binary: _binary,
    tree.IfExpression: _if,
    tree.Call: _call,
    tree.RangeExpression: _range,
    tree.ArrayLiteral: _array,
    tree.NumberArray: _number_array,
    tree.ArrayComprehension: _comprehension,
    tree.MatrixLiteral: _matrix,
    tree.Colon: _refuse,
    tree.End: _end,
    tree.TupleExpression: _refuse,
}
