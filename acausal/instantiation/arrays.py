"""Arrays of expressions: elementwise functions, products, stacking and concatenation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from acausal.diagnostics import Span, fail
from acausal.expressions import build
from acausal.expressions.nodes import ZERO, Expr, const
from acausal.instantiation import unit_algebra as units
from acausal.instantiation.values import (
    LITERAL,
    Index,
    NeedsUnroll,
    UnitOf,
    Value,
    constants,
    listed,
    position,
    scalar,
    table,
)

#: Reductions longer than this are refused: they would make a template of that length.
LONGEST_REDUCTION = 20_000


def shape_text(shape: tuple[int, ...]) -> str:
    """Return an array's size in words."""
    return "a scalar" if not shape else f"size [{', '.join(map(str, shape))}]"


def require_shape(value: Value, shape: tuple[int, ...], what: str, span: Span) -> None:
    """Refuse a value of another size.

    Raises:
        AcausalError: ``T104``.
    """
    if value.shape != shape:
        fail(
            "T104",
            f"{what}: {shape_text(shape)} and {shape_text(value.shape)}",
            span,
            label="the sizes differ",
            help="make both the same size; a subscript or slice picks elements",
        )


def mapped(function: Callable[..., Expr], type_: str, unit: UnitOf, *args: Value) -> Value:
    """Apply a scalar function elementwise; scalars among the arguments are repeated."""
    shape = next((a.shape for a in args if a.shape), ())
    if not shape:
        return scalar(function(*(a.expr for a in args)), type_, unit)

    def get(index: Index) -> Expr:
        return function(*(a.get(index) if a.shape else a.expr for a in args))

    return Value(type_, shape, get, unit)


def sum_of(terms: list[Expr]) -> Expr:
    """Return the sum as a balanced tree, so that long sums stay shallow."""
    while len(terms) > 1:
        paired = [
            build.add(terms[k], terms[k + 1]) if k + 1 < len(terms) else terms[k]
            for k in range(0, len(terms), 2)
        ]
        terms = paired
    return terms[0] if terms else ZERO


def matrix_product(left: Value, right: Value, span: Span) -> Value:
    """Return the scalar, matrix-vector or matrix product of two arrays.

    Raises:
        AcausalError: ``T104`` if the inner sizes differ.
    """
    inner = left.shape[-1]
    if inner != right.shape[0] or len(left.shape) > 2 or len(right.shape) > 2:
        fail(
            "T104",
            f"product of {shape_text(left.shape)} and {shape_text(right.shape)}",
            span,
            label="the inner sizes differ",
            help="use .* to multiply element by element, transpose() to turn a matrix",
        )
    if inner > LONGEST_REDUCTION:
        too_long(inner, span)
    unit = units.times(left.unit, right.unit)
    rows, columns = left.shape[:-1], right.shape[1:]

    def get(index: Index) -> Expr:
        row, column = index[: len(rows)], index[len(rows) :]
        terms = [
            build.mul(left.get((*row, k)), right.get((k, *column)))
            for k in (const(float(i)) for i in range(1, inner + 1))
        ]
        return sum_of(terms)

    shape = rows + columns
    if not shape:
        return scalar(get(()), "Real", unit)
    return Value("Real", shape, get, unit)


def too_long(length: int, span: Span) -> None:
    """Refuse a reduction of too many terms.

    Raises:
        AcausalError: ``T107``.
    """
    fail(
        "T107",
        f"a sum of {length} terms in one expression is too long",
        span,
        notes=[f"the longest allowed has {LONGEST_REDUCTION} terms"],
        help="add the terms in a chain: s[1] = x[1]; s[i] = s[i-1] + x[i] in a for equation",
    )


def stack(values: list[Value], spans: list[Span], span: Span) -> Value:
    """Return the array whose elements along a new first dimension are ``values``."""
    if not values:
        return table(np.zeros(0), "Real", LITERAL)
    shape = values[0].shape
    unit: UnitOf = LITERAL
    for value, place in zip(values, spans, strict=True):
        require_shape(value, shape, "elements of an array differ in size", place)
        unit = units.added(unit, value.unit, "an array holds", "U101", span, spans[0], place)
    type_ = common_type(values, spans)
    if type_ in ("String", "record"):
        fail("T110", f"arrays of {type_} are not supported here", span,
             help="use separate components")  # fmt: skip
    enumeration = values[0].enumeration
    if all(not v.shape for v in values):
        result = listed([v.expr for v in values], (len(values),), type_, unit)
        return replace(result, enumeration=enumeration)

    def get(index: Index) -> Expr:
        return values[position(index[:1], (len(values),))].get(index[1:])

    result = settled(Value(type_, (len(values), *shape), get, unit))
    return replace(result, enumeration=enumeration)


def common_type(values: list[Value], spans: list[Span]) -> str:
    """Return the type of values that stand for each other; whole numbers are real, too.

    Raises:
        AcausalError: ``T101`` if there is none.
    """
    type_, enumeration = values[0].type, values[0].enumeration
    for value, span in zip(values, spans, strict=True):
        if value.type == type_ and value.enumeration is enumeration:
            continue
        if {value.type, type_} != {"Real", "Integer"}:
            fail("T101", f"{type_} and {value.type} do not mix", span,
                 help="use values of one type; "
                 "Booleans become numbers with if c then 1 else 0")  # fmt: skip
        type_ = "Real"
    return type_


def settled(value: Value) -> Value:
    """Turn an array whose elements are all constant into a table."""
    if value.size <= LONGEST_REDUCTION:
        try:
            numbers = constants(value)
        except NeedsUnroll:
            return value
        if numbers is not None:
            return table(numbers, value.type, value.unit)
    return value


def as_matrix(value: Value) -> Value:
    """Return a scalar as a matrix of one element, a vector as a matrix of one column."""
    if len(value.shape) == 2:
        return value
    if len(value.shape) == 1:
        return Value(value.type, (value.shape[0], 1), lambda i: value.get(i[:1]), value.unit)
    return listed([value.expr], (1, 1), value.type, value.unit)


def concatenate(dimension: int, values: list[Value], spans: list[Span]) -> Value:
    """Return arrays put one after the other along a dimension (from 1).

    Raises:
        AcausalError: ``T104`` if the other sizes differ.
    """
    axis = dimension - 1
    first = values[0]
    if len(values) == 1:
        return first
    unit: UnitOf = LITERAL
    for value, span in zip(values, spans, strict=True):
        expected = (*first.shape[:axis], value.shape[axis], *first.shape[axis + 1 :])
        require_shape(value, expected, "concatenated arrays differ in size", span)
        unit = units.added(unit, value.unit, "an array holds", "U101", span, spans[0], span)
    ends = np.cumsum([v.shape[axis] for v in values])
    shape = (*first.shape[:axis], int(ends[-1]), *first.shape[axis + 1 :])

    def get(index: Index) -> Expr:
        place = position((index[axis],), (shape[axis],))
        which = int(np.searchsorted(ends, place, "right"))
        inside = place - (int(ends[which - 1]) if which else 0)
        return values[which].get((*index[:axis], const(float(inside + 1)), *index[axis + 1 :]))

    return settled(Value(common_type(values, spans), shape, get, unit))
