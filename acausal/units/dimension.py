"""Dimensions: exponents of the seven SI base units, and their text.

Angles are dimensionless, as in SI; so ``rad/s``, ``Hz`` and ``1/s`` have the same dimension.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, TypeAlias, Union

if TYPE_CHECKING:
    from fractions import Fraction

#: A whole exponent stays an ``int``; only a root makes a ``Fraction``.
Exponent: TypeAlias = Union[int, "Fraction"]
#: Exponents of kg, m, s, A, K, mol, cd.
Dimension: TypeAlias = tuple[Exponent, ...]

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd")
DIMENSIONLESS: Dimension = (0, 0, 0, 0, 0, 0, 0)


def multiply(a: Dimension, b: Dimension) -> Dimension:
    """Return the dimension of a product."""
    return tuple(_whole(x + y) for x, y in zip(a, b, strict=True))


def divide(a: Dimension, b: Dimension) -> Dimension:
    """Return the dimension of a quotient."""
    return tuple(_whole(x - y) for x, y in zip(a, b, strict=True))


def power(a: Dimension, exponent: Exponent) -> Dimension:
    """Return the dimension of ``x**exponent``."""
    return tuple(_whole(x * exponent) for x in a)


def root(a: Dimension, degree: int) -> Dimension:
    """Return the dimension of the ``degree``-th root.

    Raises:
        ZeroDivisionError: If ``degree`` is 0.
    """
    from fractions import Fraction

    return power(a, Fraction(1, degree))


def same_dimension(a: Dimension, b: Dimension) -> bool:
    """Return whether quantities of the two dimensions can be added."""
    return a == b


@lru_cache(maxsize=4096)
def format_dimension(dimension: Dimension) -> str:
    """Return the unit an engineer would write for a dimension, e.g. ``V`` or ``kg.m2/s``.

    A customary name is used where there is one; otherwise the shortest product of base units and
    at most one derived unit.
    """
    customary = _CUSTOMARY.get(dimension)
    if customary is not None:
        return customary
    best = (_cost(dimension, ()), _product(dimension, ()))
    for symbol, derived in _DERIVED:
        for exponent in (1, -1, 2, -2):
            rest = divide(dimension, power(derived, exponent))
            factor = ((symbol, exponent),)
            candidate = (_cost(rest, factor), _product(rest, factor))
            if candidate[0] < best[0]:
                best = candidate
    return best[1]


def _whole(x: Exponent) -> Exponent:
    """Turn a fraction with denominator 1 into an int, so that equal dimensions hash equal."""
    return int(x) if x == int(x) else x


def _cost(rest: Dimension, factors: tuple[tuple[str, int], ...]) -> float:
    """Length of a product as people feel it: number of factors and size of exponents."""
    exponents = [abs(float(e)) for e in rest if e] + [abs(float(e)) for _, e in factors]
    # Nobody writes N/kg for an acceleration, although it is shorter than m/s2.
    mixed = 2.0 if factors and rest[0] else 0.0
    return len(exponents) + sum(exponents) + mixed


def _product(rest: Dimension, factors: tuple[tuple[str, int], ...]) -> str:
    """Write a product of powers in Modelica's unit syntax."""
    terms: list[tuple[str, Exponent]] = [
        *factors,
        *((name, e) for name, e in zip(BASE_UNITS, rest, strict=True) if e),
    ]
    above = [_term(name, e) for name, e in terms if e > 0]
    below = [_term(name, -e) for name, e in terms if e < 0]
    text = ".".join(above) or "1"
    if not below:
        return text
    return f"{text}/{below[0]}" if len(below) == 1 else f"{text}/({'.'.join(below)})"


def _term(name: str, exponent: Exponent) -> str:
    if exponent == 1:
        return name
    return f"{name}{exponent}" if isinstance(exponent, int) else f"{name}^({exponent})"


def _dimension(**exponents: int) -> Dimension:
    return tuple(exponents.get(name, 0) for name in BASE_UNITS)


_DERIVED: tuple[tuple[str, Dimension], ...] = (
    ("V", _dimension(kg=1, m=2, s=-3, A=-1)),
    ("N", _dimension(kg=1, m=1, s=-2)),
    ("W", _dimension(kg=1, m=2, s=-3)),
    ("Pa", _dimension(kg=1, m=-1, s=-2)),
    ("J", _dimension(kg=1, m=2, s=-2)),
    ("C", _dimension(A=1, s=1)),
    ("Ohm", _dimension(kg=1, m=2, s=-3, A=-2)),
    ("S", _dimension(kg=-1, m=-2, s=3, A=2)),
    ("F", _dimension(kg=-1, m=-2, s=4, A=2)),
    ("H", _dimension(kg=1, m=2, s=-2, A=-2)),
    ("Wb", _dimension(kg=1, m=2, s=-2, A=-1)),
    ("T", _dimension(kg=1, s=-2, A=-1)),
)

_D = dict(_DERIVED)
_LENGTH, _TIME, _CURRENT = _dimension(m=1), _dimension(s=1), _dimension(A=1)
_KELVIN, _MASS = _dimension(K=1), _dimension(kg=1)

# Where one dimension has several customary names, the one used for most ports stands here.
_CUSTOMARY: dict[Dimension, str] = {
    DIMENSIONLESS: "1",
    **{dimension: symbol for symbol, dimension in _DERIVED},
    _D["J"]: "N.m",
    multiply(_D["J"], _TIME): "kg.m2/s",
    divide(_D["N"], _LENGTH): "N/m",
    divide(_D["N"], divide(_LENGTH, _TIME)): "N.s/m",
    _dimension(m=2, s=-2): "m2/s2",
    divide(_D["J"], _KELVIN): "J/K",
    divide(_D["J"], multiply(_MASS, _KELVIN)): "J/(kg.K)",
    divide(_D["W"], multiply(_dimension(m=2), _KELVIN)): "W/(m2.K)",
    divide(_D["W"], multiply(_LENGTH, _KELVIN)): "W/(m.K)",
    divide(_D["W"], _dimension(m=2)): "W/m2",
    divide(_D["V"], _LENGTH): "V/m",
    divide(_D["V"], _TIME): "V/s",
    divide(_D["H"], _LENGTH): "H/m",
    multiply(_D["Pa"], _TIME): "Pa.s",
}
