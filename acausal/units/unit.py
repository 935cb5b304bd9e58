"""Unit expressions in Modelica's syntax: ``N.m/rad``, ``W/(m2.K)``, ``m/s2``, ``degC``.

Grammar (Modelica 3.6, chapter 19, and a little more: ``*`` for ``.``, ``^`` before an exponent)::

    unit     = product ["/" factor]
    product  = factor {"." factor}
    factor   = symbol [exponent] | "(" product ")"

A symbol is a known symbol, an SI prefix and a known symbol, or a name that pint knows.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, TypeVar

from acausal.units.dimension import DIMENSIONLESS, Dimension, Exponent, multiply, power
from acausal.units.table import SYMBOLS

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Value = TypeVar("Value", float, NDArray[np.float64])

#: SI prefixes as powers of ten.
PREFIXES = {
    "Q": 30, "R": 27, "Y": 24, "Z": 21, "E": 18, "P": 15, "T": 12, "G": 9, "M": 6, "k": 3,
    "h": 2, "da": 1, "d": -1, "c": -2, "m": -3, "u": -6, "µ": -6, "μ": -6, "n": -9, "p": -12,
    "f": -15, "a": -18, "z": -21, "y": -24, "r": -27, "q": -30,
}  # fmt: skip


class UnitError(ValueError):
    """A text that is no unit.

    Attributes:
        reason: One sentence, no full stop.
        suggestions: Units that may have been meant, best first.
    """

    def __init__(self, reason: str, suggestions: tuple[str, ...] = ()) -> None:
        self.reason = reason
        self.suggestions = suggestions
        hint = f"; did you mean {' or '.join(suggestions)}?" if suggestions else ""
        super().__init__(reason + hint)

    def __reduce__(self) -> tuple[type[UnitError], tuple[str, tuple[str, ...]]]:
        return (type(self), (self.reason, self.suggestions))


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit as plain numbers: ``si = factor * value + offset``.

    Attributes:
        text: The unit as written.
        factor: SI units in one of this unit.
        offset: SI value of this unit's zero; only temperatures have one.
        dimension: Exponents of kg, m, s, A, K, mol, cd.
    """

    text: str
    factor: float
    offset: float
    dimension: Dimension


#: The dimensionless unit.
ONE = Unit("1", 1.0, 0.0, DIMENSIONLESS)


def to_si(value: Value, unit: Unit) -> Value:
    """Convert a value, or an array of any shape, from ``unit`` to SI."""
    return value * unit.factor + unit.offset if unit.offset else value * unit.factor


def from_si(value: Value, unit: Unit) -> Value:
    """Convert a value, or an array of any shape, from SI to ``unit``."""
    return (value - unit.offset) / unit.factor if unit.offset else value / unit.factor


@lru_cache(maxsize=4096)
def parse_unit(text: str) -> Unit:
    """Read a unit.

    The offset of a temperature counts only where it stands alone: ``degC`` is a temperature,
    in ``W/degC`` it is a difference.

    Raises:
        UnitError: If the text is empty, malformed, or names an unknown unit.
    """
    stripped = text.strip()
    if not stripped:
        raise UnitError("the unit is empty", ("1",))
    if stripped in SYMBOLS:
        entry = SYMBOLS[stripped]
        return Unit(text, entry[0], entry[1], entry[2])
    factors = _factors(stripped)
    # Powers of ten apart, numerator and denominator apart: each rounds once, so that a mm3 is
    # 1e-9 m3 and km/h is 1000/3600 m/s to the last bit.
    above, below, tens = 1.0, 1.0, 0.0
    offset = 0.0
    total: Dimension = DIMENSIONLESS
    for symbol, exponent in factors:
        factor, offset, dimension, ten = _symbol(symbol, stripped)
        total = multiply(total, power(dimension, exponent))
        tens += ten * float(exponent)
        if exponent > 0:
            above *= factor ** float(exponent)
        else:
            below *= factor ** float(-exponent)
    factor = above / below
    factor = factor * 10.0**tens if tens >= 0 else factor / 10.0**-tens
    alone = len(factors) == 1 and factors[0][1] == 1
    return Unit(text, factor, offset if alone else 0.0, total)


_TOKEN = re.compile(
    r"\s*(?:(?P<symbol>[^\W\d]\w*?(?=[\d\W]|$)|°C|%|1(?!\d))"
    r"(?:\^?(?P<exponent>[+-]?\d+)|\^\((?P<fraction>[+-]?\d+(?:/\d+)?)\))?"
    r"|(?P<mark>[./*()]))"
)


def _tokens(text: str) -> Iterator[tuple[str, Exponent]]:
    """Yield (symbol, exponent), and (mark, 0) for ``. / ( )``."""
    position = 0
    while position < len(text):
        match = _TOKEN.match(text, position)
        if match is None:
            raise UnitError(f"'{text}' is not a unit: unexpected '{text[position]}'")
        position = match.end()
        if match["mark"]:
            yield match["mark"].replace("*", "."), 0
        elif match["fraction"]:
            from fractions import Fraction

            try:
                fraction = Fraction(match["fraction"])
            except ZeroDivisionError:
                raise UnitError(f"'{text}' is not a unit: exponent divided by 0") from None
            yield match["symbol"], int(fraction) if fraction.denominator == 1 else fraction
        else:
            yield match["symbol"], int(match["exponent"] or 1)


def _factors(text: str) -> list[tuple[str, Exponent]]:
    """Split a unit into symbols and exponents, those below the fraction bar negative."""
    factors: list[tuple[str, Exponent]] = []
    sign, depth, divided = 1, 0, False
    expect_symbol = True
    below_done = False
    for symbol, exponent in _tokens(text):
        if symbol == ")":
            if not depth or expect_symbol:
                raise UnitError(f"'{text}' is not a unit: unexpected ')'")
            depth -= 1
            below_done = divided
        elif symbol == "(":
            if not expect_symbol or depth:
                raise UnitError(f"'{text}' is not a unit: unexpected '('")
            depth += 1
        elif symbol == "/":
            if expect_symbol or depth:
                raise UnitError(f"'{text}' is not a unit: unexpected '/'")
            if divided:
                raise UnitError(f"'{text}' has two fraction bars", _one_fraction_bar(text))
            sign, divided, expect_symbol = -1, True, True
        elif symbol == ".":
            if expect_symbol:
                raise UnitError(f"'{text}' is not a unit: unexpected '.'")
            if below_done and not depth:
                raise UnitError(
                    f"'{text}' does not say what is below the fraction bar",
                    _one_fraction_bar(text),
                )
            expect_symbol = True
        else:
            if not expect_symbol:
                raise UnitError(f"'{text}' is not a unit: a '.' is missing before '{symbol}'")
            if not 0 < abs(float(exponent)) <= 10:
                raise UnitError(f"'{text}' is not a unit: exponent {exponent}")
            factors.append((symbol, sign * exponent))
            expect_symbol = False
            below_done = divided and not depth
    if depth or expect_symbol:
        raise UnitError(f"'{text}' is not a unit: it ends too early")
    return factors


def _one_fraction_bar(text: str) -> tuple[str, ...]:
    """Suggest ``J/(kg.K)`` for ``J/kg/K`` and for ``J/kg.K``."""
    above, _, below = text.partition("/")
    return (f"{above}/({re.sub('[/()]', '.', below).strip('.').replace('..', '.')})",)


def _symbol(symbol: str, text: str) -> tuple[float, float, Dimension, int]:
    """Look a symbol up: as it stands, behind a prefix, then in pint.

    Returns:
        Factor, offset, dimension, and the power of ten that its prefix stands for.
    """
    entry = SYMBOLS.get(symbol)
    if entry is not None:
        return entry[0], entry[1], entry[2], 0
    for length in (1, 2):
        ten, rest = PREFIXES.get(symbol[:length]), SYMBOLS.get(symbol[length:])
        if ten is not None and rest is not None and rest[3]:
            return rest[0], 0.0, rest[2], ten
    # One and two letters are too easily mistyped to take pint's meaning (C, a and G differ).
    if len(symbol) > 2:
        from acausal.units.pint_source import from_pint

        found = from_pint(symbol)
        if found is not None:
            return (*found, 0)
    where = "" if symbol == text else f" in '{text}'"
    raise UnitError(f"unknown unit '{symbol}'{where}", _suggest(symbol))


def _suggest(symbol: str) -> tuple[str, ...]:
    """Return known units that look like a misspelt one."""
    from difflib import get_close_matches

    known = list(SYMBOLS)
    known += [p + s for s, entry in SYMBOLS.items() if entry[3] for p in ("k", "m", "u", "M")]
    folded = [name for name in known if name.lower() == symbol.lower()]
    words = {
        "ohms": "Ohm", "volt": "V", "volts": "V", "amp": "A", "amps": "A", "sec": "s",
        "degree": "deg", "degrees": "deg", "celsius": "degC", "newton": "N", "kelvin": "K",
        "in": "inch", "cc": "cm3", "mps": "m/s", "kmh": "km/h", "kph": "km/h", "nm": "N.m",
    }  # fmt: skip
    named = [words[symbol.lower()]] if symbol.lower() in words else []
    close = get_close_matches(symbol, known, n=3, cutoff=0.75) if len(symbol) > 2 else []
    return tuple(dict.fromkeys(named + folded + close))[:3]
