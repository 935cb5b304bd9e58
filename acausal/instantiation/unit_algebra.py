"""What happens to units in expressions.

Three cases: a dimension is known; it is a bare number (``LITERAL``), which adds to anything; or
nothing is known (None), because something in it was declared without a unit.
"""

from __future__ import annotations

from fractions import Fraction

from acausal.diagnostics import Label, Span, fail
from acausal.instantiation.values import LITERAL, UnitOf
from acausal.units.dimension import (
    DIMENSIONLESS,
    Dimension,
    Exponent,
    divide,
    format_dimension,
    multiply,
    power,
)


class Scaled(tuple[Exponent, ...]):
    """The unit of a quantity that was multiplied with or divided by a bare number.

    Equal to the dimension itself, but where a pure number is needed the bare number may have been
    meant as one of that unit: ``exp(v/0.025)``.
    """

    __slots__ = ()


_SECOND: Dimension = (0, 0, 1, 0, 0, 0, 0)


def times(a: UnitOf, b: UnitOf) -> UnitOf:
    """Return the unit of a product."""
    if a is None or b is None:
        return None
    if isinstance(a, str):
        return LITERAL if isinstance(b, str) or b == DIMENSIONLESS else Scaled(b)
    if isinstance(b, str):
        return LITERAL if a == DIMENSIONLESS else Scaled(a)
    return multiply(a, b)


def over(a: UnitOf, b: UnitOf) -> UnitOf:
    """Return the unit of a quotient."""
    if a is None or b is None:
        return None
    if isinstance(b, str):
        return a if isinstance(a, str) else Scaled(a)
    return divide(DIMENSIONLESS if isinstance(a, str) else a, b)


def raised(a: UnitOf, exponent: float | None) -> UnitOf:
    """Return the unit of a power; the exponent is None if it is not constant."""
    if a is None or isinstance(a, str):
        return a
    if exponent is None:
        return DIMENSIONLESS if a == DIMENSIONLESS else None
    return power(a, Fraction(exponent).limit_denominator(64))


def per_second(a: UnitOf) -> UnitOf:
    """Return the unit of a time derivative."""
    return None if a is None or isinstance(a, str) else divide(a, _SECOND)


def describe(unit: UnitOf) -> str:
    """Return the unit as text for a message."""
    if unit is None:
        return "unknown"
    if isinstance(unit, str) or unit == DIMENSIONLESS:
        return "1 (a pure number)"
    return format_dimension(unit)


def compatible(a: UnitOf, b: UnitOf) -> bool:
    """Tell whether two units may be added or compared."""
    return a is None or b is None or isinstance(a, str) or isinstance(b, str) or a == b


def join(a: UnitOf, b: UnitOf) -> UnitOf:
    """Return what is known of a quantity that has both units."""
    if a is None or b is None:
        return a if b is None else b
    return b if isinstance(a, str) else a


def added(
    a: UnitOf, b: UnitOf, what: str, code: str, span: Span, left: Span, right: Span
) -> UnitOf:
    """Return the unit of a sum, comparison or equation.

    Raises:
        AcausalError: ``code`` if the units differ.
    """
    if not compatible(a, b):
        fail(
            code,
            f"{what} {describe(a)} and {describe(b)}",
            span,
            label="these units do not fit",
            labels=[Label(left, f"in {describe(a)}"), Label(right, f"in {describe(b)}")],
            help="check the formula, or give a number its unit, as in 10[kOhm]",
        )
    return join(a, b)


def pure(unit: UnitOf, function: str, span: Span) -> None:
    """Refuse a quantity with a unit where a pure number (or an angle) must stand.

    Raises:
        AcausalError: ``U103``.
    """
    if unit is None or isinstance(unit, str | Scaled) or unit == DIMENSIONLESS:
        return
    fail(
        "U103",
        f"{function} needs a pure number, not a quantity in {describe(unit)}",
        span,
        help="divide it by a reference value of the same unit",
    )
