"""Values of elaborated expressions: scalars, lazy arrays, strings and records.

An array is a shape and a function from subscripts to scalar expressions. The subscripts may be
loop indices, so that an equation between arrays of a million elements is one template. An array
that is written out element by element cannot take a loop index; it raises :class:`NeedsUnroll`,
and whoever made the loop index then takes the elements one by one.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from acausal.expressions.build import number_of
from acausal.expressions.nodes import Expr, const, slot
from acausal.instantiation.template import TableEntry
from acausal.units.dimension import Dimension

if TYPE_CHECKING:
    from acausal.modeling.classes import ClassDef

Index = tuple[Expr, ...]

#: The unit of a bare number: adds to anything, and is dimensionless in a product.
LITERAL: Final = "literal"
#: A dimension, ``LITERAL``, or None where nothing is known.
UnitOf = Dimension | str | None


class NeedsUnroll(Exception):  # noqa: N818 - not an error, a request
    """An array cannot be subscripted by a loop index."""


@dataclass(frozen=True, eq=False)
class Value:
    """An elaborated expression.

    Attributes:
        type: ``Real``, ``Integer``, ``Boolean``, ``String``, ``enumeration`` or ``record``.
        shape: Array dimensions, empty for a scalar.
        get: From subscripts (expressions from 1, one for each dimension) to a scalar.
        unit: What is known about the unit.
        text: The text of a string.
        fields: The fields of a record.
        enumeration: The class of an enumeration value.
        numbers: The numbers of a constant array, where they are at hand.
    """

    type: str
    shape: tuple[int, ...]
    get: Callable[[Index], Expr]
    unit: UnitOf = None
    text: str | None = None
    fields: dict[str, Value] | None = None
    enumeration: ClassDef | None = None
    numbers: NDArray[np.float64] | None = None

    @property
    def expr(self) -> Expr:
        """The expression of a scalar."""
        return self.get(())

    @property
    def size(self) -> int:
        """Number of elements."""
        return int(np.prod(self.shape, dtype=np.int64))

    def elements(self) -> list[Expr]:
        """All elements, last subscript fastest."""
        return [self.get(i) for i in indices(self.shape)]


def indices(shape: tuple[int, ...]) -> list[Index]:
    """Return all subscripts of an array, last one fastest."""
    ranges = [[const(float(i)) for i in range(1, n + 1)] for n in shape]
    return list(itertools.product(*ranges))


def scalar(
    expr: Expr, type_: str = "Real", unit: UnitOf = None, enumeration: ClassDef | None = None
) -> Value:
    """Return a scalar value."""
    return Value(type_, (), lambda _: expr, unit, enumeration=enumeration)


def number(value: float, type_: str = "Real", unit: UnitOf = LITERAL) -> Value:
    """Return a constant scalar."""
    return scalar(const(float(value)), type_, unit)


def string(text: str) -> Value:
    """Return a string."""
    return Value("String", (), lambda _: const(0.0), None, text)


def position(index: Index, shape: tuple[int, ...]) -> int:
    """Return the row-major position of constant subscripts.

    Raises:
        NeedsUnroll: If a subscript is not constant.
        IndexError: If one is out of range.
    """
    place = 0
    for expr, n in zip(index, shape, strict=True):
        if expr.op != "const":
            raise NeedsUnroll
        i = int(number_of(expr))
        if not 1 <= i <= n:
            raise IndexError(i, n)
        place = place * n + i - 1
    return place


def listed(
    elements: list[Expr], shape: tuple[int, ...], type_: str = "Real", unit: UnitOf = None
) -> Value:
    """Return an array written out; constant ones can take loop indices."""
    if elements and all(e.op == "const" for e in elements):
        numbers = np.array([e.value for e in elements], np.float64)
        return table(numbers.reshape(shape), type_, unit)
    if not shape:
        return scalar(elements[0], type_, unit)
    return Value(type_, shape, lambda index: elements[position(index, shape)], unit)


def table(numbers: NDArray[np.float64], type_: str = "Real", unit: UnitOf = None) -> Value:
    """Return a constant array of any shape."""
    shape = numbers.shape
    flat = np.ascontiguousarray(numbers, np.float64).ravel()
    data = flat.tobytes()

    def get(index: Index) -> Expr:
        try:
            return const(float(flat[position(index, shape)]))
        except NeedsUnroll:
            return slot(TableEntry(data, shape, index))

    return Value(type_, shape, get, unit, numbers=flat.reshape(shape))


def constants(value: Value) -> NDArray[np.float64] | None:
    """Return the numbers of a value, shape ``value.shape``, or None if it is not constant."""
    if value.fields is not None or value.type == "String":
        return None
    if value.numbers is not None:
        return value.numbers
    if not value.shape:
        expr = value.expr
        return np.array(expr.value, np.float64) if expr.op == "const" else None
    result = np.empty(value.shape)
    flat = result.reshape(-1)
    for k, expr in enumerate(value.elements()):
        if expr.op != "const":
            return None
        flat[k] = number_of(expr)
    return result


def key(value: Value) -> Hashable:
    """Return what tells constant values apart."""
    if value.fields is not None:
        return tuple((n, key(v)) for n, v in value.fields.items())
    if value.type == "String":
        return ("String", value.text)
    numbers = constants(value)
    assert numbers is not None
    owner = value.enumeration.full_name if value.enumeration is not None else ""
    return (value.type, owner, numbers.shape, numbers.tobytes())
