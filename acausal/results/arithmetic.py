"""Arithmetic of variables over time, with their units."""

from __future__ import annotations

import operator
from collections.abc import Callable
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import fail
from acausal.units import (
    DIMENSIONLESS,
    ONE,
    Dimension,
    Unit,
    UnitError,
    divide,
    format_dimension,
    from_si,
    multiply,
    parse_unit,
    power,
    to_si,
)

if TYPE_CHECKING:
    from acausal.results.trajectory import Trajectory

Array = NDArray[np.float64]

#: NumPy functions that keep a variable a variable, and the operators they are.
UFUNCS: Final[dict[Any, str]] = {
    np.add: "+", np.subtract: "-", np.multiply: "*", np.true_divide: "/", np.power: "**",
}  # fmt: skip
_FUNCTIONS: Final[dict[str, Callable[[Any, Any], Any]]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv,
    "**": operator.pow,
}  # fmt: skip


def known_unit(text: str) -> Unit | None:
    """Return a unit, or None for a variable without one or with one that is not known."""
    if not text:
        return None
    try:
        return parse_unit(text)
    except UnitError:
        return None


def wanted_unit(text: str) -> Unit:
    """Return a unit that a user asks for.

    Raises:
        AcausalError: ``U104`` if it is none.
    """
    try:
        return parse_unit(text)
    except UnitError as error:
        close = error.suggestions
        fail("U104", f"{text} is not a unit", notes=[error.reason],
             help=f"write {close[0]}" if close
             else "units are written as in N.m/rad, m/s2, kOhm, 1/min")  # fmt: skip


def converted(x: Trajectory, text: str) -> Trajectory:
    """Return a variable in another unit.

    Raises:
        AcausalError: ``U104`` if it is no unit, ``U101`` if it is one of another quantity.
    """
    from acausal.results.trajectory import Trajectory

    unit, own = wanted_unit(text), known_unit(x.unit)
    if own is None and x.unit == "":
        own = ONE
    if own is None or own.dimension != unit.dimension:
        has = f"is in {x.unit}" if x.unit else "has no unit"
        fail("U101", f"{x.path} {has} and cannot be given in {text}",
             help="choose a unit of the same quantity")  # fmt: skip
    change = partial(_changed, own, unit)
    curve = None if x.curve is None else partial(_mapped, change, x.curve)
    return Trajectory(x.path, x.time, change(x.values), text, x.description, curve)


def combined(sign: str, left: Any, right: Any) -> Any:
    """Return ``left sign right``; one of them is a variable, the other may be a number.

    Bare numbers add to anything, as in the language.

    Returns:
        A variable over time; ``NotImplemented`` for other operands.

    Raises:
        AcausalError: ``U101`` for units that do not fit, ``F212`` for variables of unlike times.
    """
    from acausal.results.trajectory import Trajectory

    for side in (left, right):
        if not isinstance(side, Trajectory) and not _is_number(side):
            return NotImplemented
    if isinstance(left, Trajectory) and isinstance(right, Trajectory):
        _need_same_times(left, right)
    time = left.time if isinstance(left, Trajectory) else right.time
    (to_left, to_right), unit = _units(sign, left, right)
    function = partial(_applied, sign, to_left, to_right)
    values = function(_values(left), _values(right))
    curve = None
    if all(not isinstance(side, Trajectory) or side.curve is not None for side in (left, right)):
        curve = partial(_joined, function, _curve(left), _curve(right))
    return Trajectory(_name(sign, left, right), time, values, unit, "", curve)


def arrays(sign: str, left: Any, right: Any) -> Any:
    """Return ``left sign right`` as a plain array, where one of them is one."""
    return _FUNCTIONS[sign](np.asarray(left), np.asarray(right))


def negated(x: Trajectory) -> Trajectory:
    """Return ``-x``."""
    from acausal.results.trajectory import Trajectory

    curve = None if x.curve is None else partial(_mapped, np.negative, x.curve)
    return Trajectory(f"-{_enclosed(x)}", x.time, -x.values, x.unit, "", curve)


def absolute(x: Trajectory) -> Trajectory:
    """Return ``abs(x)``."""
    from acausal.results.trajectory import Trajectory

    curve = None if x.curve is None else partial(_mapped, np.abs, x.curve)
    return Trajectory(f"abs({x.path})", x.time, np.abs(x.values), x.unit, "", curve)


def _units(sign: str, left: Any, right: Any) -> tuple[tuple[Unit, Unit], str]:
    """Return the units that the values are taken from, and the unit of what comes out in SI.

    Where nothing has to be converted both are 1.
    """
    texts = [getattr(side, "unit", None) for side in (left, right)]  # None for a number
    if sign == "**":
        if texts[1] not in (None, "", "1"):
            fail("U103", f"an exponent needs a pure number, not {right.path} in {texts[1]}",
                 help="divide it by a reference value of the same unit")  # fmt: skip
        return _power_units(left, right)
    if sign in "+-":
        # Whatever has a unit decides; of two, the left one.
        if not texts[0] or not texts[1] or texts[0] == texts[1]:
            return (ONE, ONE), texts[0] or texts[1] or ""
        units = [known_unit(text or "") for text in texts]
        if units[0] is None or units[1] is None or units[0].dimension != units[1].dimension:
            fail("U101", f"{'adding' if sign == '+' else 'subtracting'} {left.path} in {texts[0]} "
                 f"and {right.path} in {texts[1]}",
                 help="check the formula; only quantities of one kind can be added")  # fmt: skip
        return (units[0], units[1]), str(texts[0])
    if any(text == "" for text in texts):
        return (ONE, ONE), ""
    if texts[1] is None or (texts[0] is None and sign == "*"):
        return (ONE, ONE), str(texts[0] if texts[1] is None else texts[1])
    units = [ONE if text is None else known_unit(text) for text in texts]
    if units[0] is None or units[1] is None:
        return (ONE, ONE), ""
    of = multiply if sign == "*" else divide
    return (units[0], units[1]), _text(of(units[0].dimension, units[1].dimension))


def _power_units(left: Any, right: Any) -> tuple[tuple[Unit, Unit], str]:
    text = getattr(left, "unit", None)
    if not text:
        return (ONE, ONE), ""
    unit = known_unit(text)
    if unit is None:
        return (ONE, ONE), ""
    if not _is_number(right):
        return (unit, ONE), "1" if unit.dimension == DIMENSIONLESS else ""
    exponent = Fraction(float(right)).limit_denominator(64)
    return (unit, ONE), _text(power(unit.dimension, exponent))


def _text(dimension: Dimension) -> str:
    return format_dimension(dimension)


def _applied(sign: str, left_unit: Unit, right_unit: Unit, left: Any, right: Any) -> Array:
    """Compute in SI units; sums come back in the unit of the left."""
    with np.errstate(all="ignore"):
        result = _FUNCTIONS[sign](to_si(left, left_unit), to_si(right, right_unit))
    if sign in "+-":
        result = from_si(result, left_unit)
    return np.asarray(result, dtype=np.float64)


def _changed(own: Unit, unit: Unit, values: Array) -> Array:
    return np.asarray(from_si(to_si(values, own), unit), dtype=np.float64)


def _mapped(function: Callable[[Array], Array], curve: Any, times: Array, before: bool) -> Array:
    return function(curve(times, before))


def _joined(
    function: Callable[[Any, Any], Array], left: Any, right: Any, times: Array, before: bool
) -> Array:
    a = left(times, before) if callable(left) else left
    b = right(times, before) if callable(right) else right
    return function(a, b)


def _curve(side: Any) -> Any:
    return float(side) if _is_number(side) else side.curve


def _values(side: Any) -> Any:
    return float(side) if _is_number(side) else side.values


def _is_number(side: Any) -> bool:
    return isinstance(side, int | float | np.integer | np.floating) or (
        isinstance(side, np.ndarray) and side.ndim == 0
    )


def _need_same_times(left: Trajectory, right: Trajectory) -> None:
    if left.time is right.time or np.array_equal(left.time, right.time):
        return
    fail("F212", f"{left.path} and {right.path} have their values at unlike times",
         help="bring one to the times of the other: a - b.sampled(a.time)")  # fmt: skip


def _name(sign: str, left: Any, right: Any) -> str:
    if sign == "**":
        return f"{_enclosed(left)}^{_enclosed(right)}"
    if sign in "*/":
        return f"{_enclosed(left)}{sign}{_enclosed(right)}"
    return f"{_shown(left)} {sign} {_enclosed(right) if sign == '-' else _shown(right)}"


def _shown(side: Any) -> str:
    return f"{float(side):g}" if _is_number(side) else str(side.path)


def _enclosed(side: Any) -> str:
    """Return a name in parentheses if it is a formula."""
    text = _shown(side)
    formula = any(mark in text for mark in " +*/^") or text.startswith("-")
    return f"({text})" if formula and not (text.endswith("]") and " " not in text) else text
