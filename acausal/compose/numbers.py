"""Python's values as syntax: numbers, texts with units, quantities of pint, lists and arrays."""

from __future__ import annotations

import math
import re
from dataclasses import fields, is_dataclass
from functools import lru_cache
from typing import Any, NoReturn, cast

import numpy as np

from acausal.compose.symbols import GlobalName, Listing, Literal, Symbolic
from acausal.diagnostics import AcausalError, Span, fail
from acausal.syntax import tree
from acausal.units.dimension import DIMENSIONLESS, Dimension
from acausal.units.unit import UnitError, parse_unit

_WITH_UNIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*\[([^\[\]]+)\]\s*\Z")
_NUMBER = re.compile(r"\s*[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\s*\Z")
_BASES = ("kg", "m", "s", "A", "K", "mol", "cd")


def symbolic_value(value: object, span: Span) -> Symbolic:
    """Return a Python value as an expression.

    Raises:
        AcausalError: ``T152`` for what is no value, ``T153`` for NaN, ``U104`` for an unknown unit.
    """
    if isinstance(value, float):
        if value - value == 0.0:
            return Literal(tree.NumberLiteral(span, float(value)))
        return _not_finite(value, span)
    if isinstance(value, bool | np.bool_):
        return Literal(tree.BooleanLiteral(span, bool(value)))
    if isinstance(value, int):
        return Literal(tree.NumberLiteral(span, float(value), True))
    if isinstance(value, str):
        return Literal(number_of_text(value, span))
    if isinstance(value, list | tuple | np.ndarray | range):
        return _array(value, span)
    if isinstance(value, np.generic):
        return symbolic_value(value.item(), span)
    if hasattr(value, "magnitude") and hasattr(value, "dimensionality"):
        return _quantity(cast(Any, value), span)
    if hasattr(value, "__array__"):
        return _array(np.asarray(value), span)
    fail("T152", f"{_article(value)} is no value of a model", span,
         help="give a number, a text such as \"10[kOhm]\", an array, or an expression")  # fmt: skip


def _article(value: object) -> str:
    text = repr(value)
    kind = type(value).__name__
    return f"{text if len(text) < 60 else 'this'} (a Python {kind})"


def _not_finite(value: float, span: Span) -> Symbolic:
    if math.isnan(value):
        fail("T153", "a value is not a number (NaN)", span,
             help="look where it comes from; a parameter left out keeps its default")  # fmt: skip
    name = GlobalName(("constants", "inf"))
    from acausal.compose.symbols import Operation

    return name if value > 0 else Operation("-", (name,), span)


# --- texts --------------------------------------------------------------------------------


def number_of_text(text: str, span: Span) -> tree.Expression:
    """Return a text such as ``10[kOhm]``, or any expression of the language, as syntax.

    Raises:
        AcausalError: ``T154`` for a text that is no expression, ``U104`` for an unknown unit.
    """
    match = _WITH_UNIT.match(text)
    if match is not None:
        check_unit(match[2], span)
        whole = match[1].lstrip("+-").isdigit()
        return tree.NumberLiteral(span, float(match[1]), whole, match[2].strip())
    if _NUMBER.match(text):
        whole = text.strip().lstrip("+-").isdigit()
        return tree.NumberLiteral(span, float(text), whole)
    return _parsed(text, span)


@lru_cache(maxsize=1000)
def _parsed(text: str, span: Span) -> tree.Expression:
    from acausal.syntax.parser import parse_expression

    try:
        node = parse_expression(text, "<text>")
    except AcausalError as error:
        found = re.match(r"\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*([^\d\s\[].*)\Z", text)
        advice = f'write "{found[1]}[{found[2]}]"' if found else 'write a number as in "10[kOhm]"'
        fail("T154", f'"{text}" is no expression', span,
             notes=[error.diagnostics[0].message], help=advice)  # fmt: skip
    return cast(tree.Expression, moved(node, span))


def moved(node: Any, span: Span) -> Any:
    """Return syntax with all its spans replaced."""
    if isinstance(node, tuple):
        return tuple(moved(n, span) for n in node)
    if isinstance(node, tree.Node) and is_dataclass(node):
        values = {f.name: moved(getattr(node, f.name), span) for f in fields(node)}
        return type(node)(**{**values, "span": span})
    return node


def check_unit(text: str, span: Span) -> None:
    """Refuse what is no unit.

    Raises:
        AcausalError: ``U104``.
    """
    try:
        parse_unit(text.strip())
    except UnitError as error:
        fail("U104", f"{text} is not a unit", span, notes=[str(error)],
             help=f"write {error.suggestions[0]}" if error.suggestions
             else "units are written as in N.m/rad, m/s2, kOhm")  # fmt: skip


# --- quantities ---------------------------------------------------------------------------


def _quantity(value: Any, span: Span) -> Symbolic:
    """Return a quantity of pint as a number with a unit, or an array of such numbers."""
    unit, factor, offset = _unit_of(str(value.units), value, span)
    magnitude = np.asarray(value.magnitude, np.float64) * factor + offset
    if np.isnan(magnitude).any():
        _not_finite(math.nan, span)
    if not magnitude.shape:
        return Literal(tree.NumberLiteral(span, float(magnitude), False, unit or None))
    return Literal(number_array(magnitude, span, unit or None), magnitude.ndim)


_units: dict[str, tuple[str, float, float]] = {}


def _unit_of(name: str, value: Any, span: Span) -> tuple[str, float, float]:
    """Return our text of a unit of pint, with what turns magnitudes into numbers of that unit."""
    if name in _units:
        return _units[name]
    one = type(value)(1.0, value.units)
    zero = type(value)(0.0, value.units)
    try:
        base = one.to_base_units()
        offset = float(zero.to_base_units().magnitude)
        factor = float(base.magnitude) - offset
        dimension = _dimension(base, span)
    except AcausalError:
        raise
    except Exception as error:  # noqa: BLE001 - pint raises many unrelated classes
        fail("U104", f"{name} is no unit of a physical quantity", span, notes=[str(error)],
             help="use units of mass, length, time, current, temperature, ...")  # fmt: skip
    short = f"{value.units:~}".replace(" ", "").replace("**", "").replace("*", ".")
    for text in (short.replace("Ω", "Ohm").replace("ohm", "Ohm").replace("µ", "u"), name):
        try:
            ours = parse_unit(text)
        except UnitError:
            continue
        same = math.isclose(ours.factor, factor, rel_tol=1e-12)
        same = same and math.isclose(ours.offset, offset, rel_tol=1e-12)
        if same and ours.dimension == dimension:
            return _units.setdefault(name, (text, 1.0, 0.0))
    return _units.setdefault(name, (_base_text(dimension), factor, offset))


def _dimension(base: Any, span: Span) -> Dimension:
    names = ("[mass]", "[length]", "[time]", "[current]", "[temperature]", "[substance]",
             "[luminosity]")  # fmt: skip
    given = dict(base.dimensionality)
    extra = set(given) - set(names)
    if extra:
        fail("U104", f"{sorted(extra)[0]} is no physical dimension here", span,
             help="use units of mass, length, time, current, temperature, ...")  # fmt: skip
    found = tuple(given.get(n, 0) for n in names)
    return tuple(int(e) if float(e).is_integer() else e for e in found)


def _base_text(dimension: Dimension) -> str:
    if dimension == DIMENSIONLESS:
        return "1"
    above = [_power(b, e) for b, e in zip(_BASES, dimension, strict=True) if e > 0]
    below = [_power(b, -e) for b, e in zip(_BASES, dimension, strict=True) if e < 0]
    text = ".".join(above) or "1"
    if not below:
        return text
    return f"{text}/{below[0]}" if len(below) == 1 else f"{text}/({'.'.join(below)})"


def _power(base: str, exponent: Any) -> str:
    if exponent == 1:
        return base
    return f"{base}{exponent}" if isinstance(exponent, int) else f"{base}^({exponent})"


# --- arrays -------------------------------------------------------------------------------


def _array(value: Any, span: Span) -> Symbolic:
    if not isinstance(value, np.ndarray):
        if _any_symbolic(value):
            return Listing(tuple(symbolic_or_value(v, span) for v in value), span)
        try:
            value = np.asarray(value)
        except ValueError:
            fail("T104", "the rows of an array have different lengths", span,
                 help="give every row equally many elements")  # fmt: skip
    if value.dtype.kind in "OUS":
        return Listing(tuple(symbolic_or_value(v, span) for v in value.tolist()), span)
    if value.dtype.kind == "b":
        return Listing(tuple(symbolic_value(v, span) for v in value.tolist()), span)
    if value.dtype.kind not in "iuf":
        _no_array(value, span)
    if not value.shape:
        return symbolic_value(value.item(), span)
    if not np.isfinite(value).all():
        if np.isnan(value).any():
            where = [int(k) for k in np.argwhere(np.isnan(value))[0]]
            fail("T153", f"element {where} of an array is not a number (NaN)", span,
                 help="look where it comes from")  # fmt: skip
        return Listing(tuple(symbolic_or_value(v, span) for v in value.tolist()), span)
    return Literal(number_array(value, span), value.ndim)


def _no_array(value: Any, span: Span) -> NoReturn:
    fail("T152", f"an array of {value.dtype} is no value of a model", span,
         help="give an array of numbers")  # fmt: skip


def symbolic_or_value(value: object, span: Span) -> Symbolic:
    """Return a value as an expression; expressions stay what they are."""
    return value if isinstance(value, Symbolic) else symbolic_value(value, span)


def _any_symbolic(value: Any) -> bool:
    stack = list(value)
    for item in stack:
        if isinstance(item, list | tuple):
            stack.extend(item)
        elif isinstance(item, Symbolic) or hasattr(item, "magnitude"):
            return True
    return False


def number_array(numbers: Any, span: Span, unit: str | None = None) -> tree.NumberArray:
    """Return an array of numbers as syntax."""
    whole = numbers.dtype.kind in "iu"
    data = np.ascontiguousarray(numbers, np.float64)
    return tree.NumberArray(span, data.tobytes(), data.shape, whole, unit)
