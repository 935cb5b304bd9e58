"""Units of measurement: text to SI factor, offset and dimension, and back to text."""

from acausal.units.dimension import (
    DIMENSIONLESS,
    Dimension,
    divide,
    format_dimension,
    multiply,
    power,
    root,
    same_dimension,
)
from acausal.units.unit import ONE, Unit, UnitError, from_si, parse_unit, to_si

__all__ = [
    "DIMENSIONLESS",
    "ONE",
    "Dimension",
    "Unit",
    "UnitError",
    "divide",
    "format_dimension",
    "from_si",
    "multiply",
    "parse_unit",
    "power",
    "root",
    "same_dimension",
    "to_si",
]
