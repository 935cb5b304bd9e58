"""What is known about units comes from pint; this is the only module that asks it."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from typing import Any

from acausal.units.dimension import Dimension, Exponent

_BASE_NAMES = (
    "[mass]",
    "[length]",
    "[time]",
    "[current]",
    "[temperature]",
    "[substance]",
    "[luminosity]",
)
# What pint may reduce a unit to; a byte is a number too, but no physical quantity.
_BASE_UNITS = {
    "kilogram",
    "meter",
    "second",
    "ampere",
    "kelvin",
    "mole",
    "candela",
    "radian",
    "count",
}


@lru_cache(maxsize=1)
def _registry() -> Any:
    import pint

    # Exact arithmetic, so that a litre is 0.001 m3 and not the nearest product of floats.
    return pint.UnitRegistry(non_int_type=Fraction)


def from_pint(name: str) -> tuple[float, float, Dimension] | None:
    """Ask pint for one unit name.

    Args:
        name: A name that pint knows, e.g. ``inch``; no expression.

    Returns:
        Factor and offset with ``si = factor * value + offset``, and dimension; None if pint does
        not know it, or if it is no linear unit of the seven base quantities (``dB``, ``byte``).
    """
    registry = _registry()
    if not name.isidentifier():
        return None
    try:
        unit = registry.Unit(name)
        exponents: dict[str, Any] = dict(registry.get_dimensionality(unit))
        base = registry.Quantity(Fraction(1), unit).to_base_units()
        one = base.magnitude
        zero = registry.Quantity(Fraction(0), unit).to_base_units().magnitude
    except Exception:  # noqa: BLE001 - pint raises many unrelated classes for what is no unit
        return None
    counted = {name for name, _ in base.unit_items()} - _BASE_UNITS
    if counted or set(exponents) - set(_BASE_NAMES):
        return None
    dimension = tuple(_exponent(exponents.get(base, 0)) for base in _BASE_NAMES)
    return float(one - zero), float(zero), dimension


def known_names() -> list[str]:
    """Return all unit names that pint knows without prefix, sorted."""
    return sorted(name for name in _registry()._units if name.isidentifier())


def _exponent(value: Any) -> Exponent:
    fraction = Fraction(value).limit_denominator(12)
    return int(fraction) if fraction.denominator == 1 else fraction
