"""Predefined functions and operators (Modelica 3.6, sections 3.7 and 10.3)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from acausal.diagnostics import fail
from acausal.expressions import build
from acausal.expressions.differentiate import time_derivative
from acausal.expressions.nodes import FUNCTIONS, ONE, ZERO, Expr, const, slot
from acausal.instantiation import unit_algebra as units
from acausal.instantiation.arrays import (
    LONGEST_REDUCTION,
    concatenate,
    mapped,
    matrix_product,
    require_shape,
    shape_text,
    stack,
    sum_of,
    too_long,
)
from acausal.instantiation.expressions import (
    Environment,
    constant_number,
    elaborate,
    elaborate_real,
    passes,
)
from acausal.instantiation.template import Ref, Unset
from acausal.instantiation.values import (
    LITERAL,
    Index,
    UnitOf,
    Value,
    number,
    scalar,
    table,
)
from acausal.syntax import tree
from acausal.syntax.formatter import format_expression
from acausal.units.dimension import DIMENSIONLESS

Handler = Callable[[tree.Call, Environment], Value]


def find_builtin(name: str) -> Handler | None:
    """Return the handler of a predefined function, or None."""
    if name in _handlers:
        return _handlers[name]
    if name in FUNCTIONS:
        return _elementary
    return None


def builtin_names() -> list[str]:
    """Return the names of all predefined functions."""
    return sorted({*_handlers, *FUNCTIONS})


def arguments(e: tree.Call, least: int, most: int | None = None) -> tuple[tree.Expression, ...]:
    """Return the positional arguments of a call.

    Raises:
        AcausalError: ``T120`` if there are fewer or more, or named ones.
    """
    most = least if most is None else most
    name = str(e.function)
    if e.named:
        fail("T120", f"{name} takes no named arguments", e.named[0].span,
             help="write the arguments in order")  # fmt: skip
    if not least <= len(e.arguments) <= most:
        wanted = str(least) if least == most else f"{least} to {most}"
        fail("T120", f"{name} takes {wanted} arguments, not {len(e.arguments)}", e.span,
             help=f"give {wanted}")  # fmt: skip
    return e.arguments


_KEEP = ("abs", "floor", "ceil", "integer")


def _elementary(e: tree.Call, env: Environment) -> Value:
    name = str(e.function)
    if name in ("min", "max") and (e.indices or len(e.arguments) == 1):
        return _extremum(e, env)
    given = arguments(e, FUNCTIONS[name])
    values = [elaborate_real(a, env) for a in given]
    shapes = {v.shape for v in values if v.shape}
    if len(shapes) > 1:
        require_shape(values[1], values[0].shape, f"arguments of {name}", e.span)
    unit: UnitOf
    if name == "sqrt":
        unit = units.raised(values[0].unit, 0.5)
    elif name in _KEEP:
        unit = values[0].unit
    elif name in ("min", "max", "mod", "rem"):
        unit = units.added(values[0].unit, values[1].unit, f"{name} of", "U101", e.span,
                           given[0].span, given[1].span)  # fmt: skip
    elif name == "div":
        unit = units.over(values[0].unit, values[1].unit)
    elif name == "atan2":
        units.added(values[0].unit, values[1].unit, "atan2 of", "U101", e.span,
                    given[0].span, given[1].span)  # fmt: skip
        unit = DIMENSIONLESS
    elif name == "sign":
        unit = DIMENSIONLESS
    else:
        for value, place in zip(values, given, strict=True):
            units.pure(value.unit, name, place.span)
        unit = DIMENSIONLESS
    whole = name in ("integer", "sign") or (
        name in ("abs", "min", "max", "mod", "rem", "div", "floor", "ceil")
        and all(v.type == "Integer" for v in values)
    )
    return mapped(lambda *a: build.call(name, *a), "Integer" if whole else "Real", unit, *values)


def _terms(e: tree.Call, env: Environment) -> tuple[list[Expr], UnitOf, str]:
    if e.indices:
        values = [
            elaborate_real(e.arguments[0], env.with_locals(own))
            for own in passes(e.indices, env, e.span)
        ]
        unit: UnitOf = LITERAL
        for v in values:
            unit = units.join(unit, v.unit)
        whole = all(v.type == "Integer" for v in values)
        return [x for v in values for x in v.elements()], unit, "Integer" if whole else "Real"
    (argument,) = arguments(e, 1)
    value = elaborate_real(argument, env)
    if value.size > LONGEST_REDUCTION:
        too_long(value.size, e.span)
    return value.elements(), value.unit, value.type


def _sum(e: tree.Call, env: Environment) -> Value:
    terms, unit, type_ = _terms(e, env)
    return scalar(sum_of(terms), type_, unit)


def _product(e: tree.Call, env: Environment) -> Value:
    terms, unit, type_ = _terms(e, env)
    result = ONE
    for term in terms:
        result = build.mul(result, term)
    pure = unit in (None, LITERAL, DIMENSIONLESS)
    return scalar(result, type_, unit if pure else units.raised(unit, float(len(terms))))


def _extremum(e: tree.Call, env: Environment) -> Value:
    terms, unit, type_ = _terms(e, env)
    if not terms:
        fail("T121", f"{e.function} of nothing", e.span, help="give at least one element")
    result = terms[0]
    for term in terms[1:]:
        result = build.call(str(e.function), result, term)
    return scalar(result, type_, unit)


# --- size and shape ----------------------------------------------------------------------


def _size(e: tree.Call, env: Environment) -> Value:
    given = arguments(e, 1, 2)
    what = given[0]
    known = env.component_shape(what) if isinstance(what, tree.Reference) else None
    shape = elaborate(what, env).shape if known is None else known
    if len(given) == 1:
        return table(np.array(shape, np.float64), "Integer", LITERAL)
    k = int(constant_number(given[1], env, "the dimension"))
    if not 1 <= k <= len(shape):
        fail("T113", f"dimension {k} of {shape_text(shape)}", e.span,
             help=f"it has {len(shape)} dimensions")  # fmt: skip
    return number(float(shape[k - 1]), "Integer")


def _ndims(e: tree.Call, env: Environment) -> Value:
    return number(float(len(elaborate(arguments(e, 1)[0], env).shape)), "Integer")


def _dimensions(arguments: tuple[tree.Expression, ...], env: Environment) -> tuple[int, ...]:
    result = tuple(int(constant_number(a, env, "an array size")) for a in arguments)
    for n, a in zip(result, arguments, strict=True):
        if n < 0:
            fail("T122", f"an array cannot have {n} elements", a.span, help="use 0 or more")
    return result


def filled(value: Value, shape: tuple[int, ...]) -> Value:
    """Return an array of any size whose elements are all the same."""
    if not shape:
        return value
    return Value(value.type, shape, lambda _: value.expr, value.unit,
                 enumeration=value.enumeration)  # fmt: skip


def _zeros(e: tree.Call, env: Environment) -> Value:
    value = 0.0 if str(e.function) == "zeros" else 1.0
    return filled(number(value), _dimensions(e.arguments, env))


def _fill(e: tree.Call, env: Environment) -> Value:
    return filled(elaborate(e.arguments[0], env), _dimensions(e.arguments[1:], env))


def _identity(e: tree.Call, env: Environment) -> Value:
    (n,) = _dimensions(arguments(e, 1), env)
    return table(np.eye(n), "Real", LITERAL)


def _diagonal(e: tree.Call, env: Environment) -> Value:
    value = elaborate_real(arguments(e, 1)[0], env)
    n = value.shape[0]

    def get(index: Index) -> Expr:
        row, column = index
        if row.op == "const" and column.op == "const":
            return value.get((row,)) if row is column else ZERO
        return build.if_(build.relation("eq", row, column), value.get((row,)), ZERO)

    return Value(value.type, (n, n), get, value.unit)


def _linspace(e: tree.Call, env: Environment) -> Value:
    first, last, count = arguments(e, 3)
    a, b = elaborate_real(first, env), elaborate_real(last, env)
    n = int(constant_number(count, env, "the number of points"))
    unit = units.join(a.unit, b.unit)

    def get(index: Index) -> Expr:
        share = build.div(build.sub(index[0], ONE), const(float(max(n - 1, 1))))
        return build.add(a.expr, build.mul(build.sub(b.expr, a.expr), share))

    return Value("Real", (n,), get, unit)


def _transpose(e: tree.Call, env: Environment) -> Value:
    value = elaborate(arguments(e, 1)[0], env)
    if len(value.shape) != 2:
        fail("T105", f"only a matrix can be transposed, not {shape_text(value.shape)}", e.span,
             help="a row of a matrix is A[i, :]")  # fmt: skip
    return Value(value.type, value.shape[::-1], lambda i: value.get((i[1], i[0])), value.unit)


def _three(value: Value, e: tree.Call) -> list[Expr]:
    require_shape(value, (3,), f"{e.function} needs vectors of three", e.span)
    return value.elements()


def _cross(e: tree.Call, env: Environment) -> Value:
    u, v = (elaborate_real(a, env) for a in arguments(e, 2))
    a, b = _three(u, e), _three(v, e)
    terms = [
        build.sub(build.mul(a[j], b[k]), build.mul(a[k], b[j])) for j, k in ((1, 2), (2, 0), (0, 1))
    ]
    unit = units.times(u.unit, v.unit)
    return stack([scalar(t, "Real", unit) for t in terms], [e.span] * 3, e.span)


def _skew(e: tree.Call, env: Environment) -> Value:
    value = elaborate_real(arguments(e, 1)[0], env)
    x, y, z = _three(value, e)
    rows = [[ZERO, build.neg(z), y], [z, ZERO, build.neg(x)], [build.neg(y), x, ZERO]]
    stacked = [
        stack([scalar(c, "Real", value.unit) for c in row], [e.span] * 3, e.span) for row in rows
    ]
    return stack(stacked, [e.span] * 3, e.span)


def _outer_product(e: tree.Call, env: Environment) -> Value:
    u, v = (elaborate_real(a, env) for a in arguments(e, 2))
    column = Value("Real", (*u.shape, 1), lambda i: u.get(i[:1]), u.unit)
    row = Value("Real", (1, *v.shape), lambda i: v.get(i[1:]), v.unit)
    return matrix_product(column, row, e.span)


def _vector(e: tree.Call, env: Environment) -> Value:
    value = elaborate(arguments(e, 1)[0], env)
    return stack([scalar(x, value.type, value.unit) for x in value.elements()],
                 [e.span] * value.size, e.span)  # fmt: skip


def _scalar(e: tree.Call, env: Environment) -> Value:
    value = elaborate(arguments(e, 1)[0], env)
    if value.size != 1:
        fail("T104", f"scalar of {shape_text(value.shape)}", e.span, help="give one element")
    return scalar(value.elements()[0], value.type, value.unit)


def _cat(e: tree.Call, env: Environment) -> Value:
    dimension = int(constant_number(e.arguments[0], env, "the dimension"))
    values = [elaborate(a, env) for a in e.arguments[1:]]
    return concatenate(dimension, values, [a.span for a in e.arguments[1:]])


# --- operators on dynamic expressions ----------------------------------------------------


def derivative_of(operand: Expr) -> Expr:
    """Return the slot of the time derivative of a slot; zero for what does not change."""
    ref = operand.value.ref if isinstance(operand.value, Unset) else operand.value
    if isinstance(ref, Ref) and not ref.parameter and not ref.pre:
        return slot(replace(ref, order=ref.order + 1))
    return ZERO


def _der(e: tree.Call, env: Environment) -> Value:
    (argument,) = arguments(e, 1)
    value = elaborate_real(argument, env)

    def rate(operand: Expr) -> Expr:
        ref = operand.value.ref if isinstance(operand.value, Unset) else operand.value
        if isinstance(ref, Ref) and not ref.parameter and env.is_discrete(ref):
            fail("E013", f"{ref.name or format_expression(argument)} changes at events only "
                 "and has no derivative", e.span,
                 help="differentiate a Real variable that is not declared discrete")  # fmt: skip
        return derivative_of(operand)

    return mapped(lambda x: time_derivative(x, rate), "Real", units.per_second(value.unit), value)


def _no_event(e: tree.Call, env: Environment) -> Value:
    value = elaborate(arguments(e, 1)[0], env)
    result = mapped(build.noevent, value.type, value.unit, value)
    return replace(result, enumeration=value.enumeration)


def _smooth(e: tree.Call, env: Environment) -> Value:
    order, argument = arguments(e, 2)
    p = int(constant_number(order, env, "the order of smooth"))
    value = elaborate_real(argument, env)
    return mapped(lambda x: build.smooth(p, x), "Real", value.unit, value)


def _homotopy(e: tree.Call, env: Environment) -> Value:
    given = {n.name: n.value for n in e.named}
    parts = list(e.arguments)
    for name in ("actual", "simplified")[len(parts) :]:
        if name in given:
            parts.append(given.pop(name))
    if len(parts) != 2 or given:
        fail("T120", "homotopy takes actual and simplified", e.span,
             help="write homotopy(actual = ..., simplified = ...)")  # fmt: skip
    actual, simplified = (elaborate_real(p, env) for p in parts)
    unit = units.added(actual.unit, simplified.unit, "homotopy between", "U101", e.span,
                       parts[0].span, parts[1].span)  # fmt: skip
    return mapped(build.homotopy, "Real", unit, actual, simplified)


def _semi_linear(e: tree.Call, env: Environment) -> Value:
    x, up, down = (elaborate_real(a, env) for a in arguments(e, 3))
    value = build.if_(
        build.relation("ge", x.expr, ZERO), build.mul(up.expr, x.expr), build.mul(down.expr, x.expr)
    )
    return scalar(value, "Real", units.times(x.unit, units.join(up.unit, down.unit)))


_handlers: dict[str, Handler] = {
    "sum": _sum, "product": _product, "size": _size, "ndims": _ndims, "zeros": _zeros,
    "ones": _zeros, "fill": _fill, "identity": _identity, "diagonal": _diagonal,
    "linspace": _linspace, "transpose": _transpose, "cross": _cross, "skew": _skew,
    "outerProduct": _outer_product, "vector": _vector, "scalar": _scalar, "cat": _cat,
    "der": _der, "noEvent": _no_event, "smooth": _smooth, "homotopy": _homotopy,
    "semiLinear": _semi_linear,
}  # fmt: skip
