"""Functions of the language for expressions; of plain numbers they give plain numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from acausal.compose.places import here
from acausal.compose.symbols import (
    Choice,
    GlobalName,
    Invocation,
    Literal,
    Symbolic,
    called,
    operand,
)
from acausal.diagnostics import fail
from acausal.syntax import tree

#: Simulation time, seconds.
time = GlobalName(("time",))


def _elementwise(name: str, numeric: str, text: str) -> Callable[..., Any]:
    def function(*arguments: Any) -> Any:
        if not any(isinstance(a, Symbolic) for a in arguments):
            return getattr(np, numeric)(*arguments)
        return called(name, *arguments)

    function.__name__ = function.__qualname__ = name
    function.__doc__ = text
    return function


sin = _elementwise("sin", "sin", "Sine of an angle in radian.")
cos = _elementwise("cos", "cos", "Cosine of an angle in radian.")
tan = _elementwise("tan", "tan", "Tangent of an angle in radian.")
asin = _elementwise("asin", "arcsin", "Inverse sine, radian.")
acos = _elementwise("acos", "arccos", "Inverse cosine, radian.")
atan = _elementwise("atan", "arctan", "Inverse tangent, radian.")
atan2 = _elementwise("atan2", "arctan2", "Angle of the point (x, y) from ``atan2(y, x)``, radian.")
sinh = _elementwise("sinh", "sinh", "Hyperbolic sine.")
cosh = _elementwise("cosh", "cosh", "Hyperbolic cosine.")
tanh = _elementwise("tanh", "tanh", "Hyperbolic tangent.")
exp = _elementwise("exp", "exp", "Exponential.")
log = _elementwise("log", "log", "Natural logarithm.")
log10 = _elementwise("log10", "log10", "Logarithm to the base 10.")
sqrt = _elementwise("sqrt", "sqrt", "Square root.")
abs = _elementwise("abs", "abs", "Absolute value.")  # noqa: A001 - as in the language
sign = _elementwise("sign", "sign", "-1, 0 or 1.")
floor = _elementwise("floor", "floor", "Largest whole number below; an event where it changes.")
ceil = _elementwise("ceil", "ceil", "Smallest whole number above; an event where it changes.")
mod = _elementwise("mod", "mod", "Rest of a division, with the sign of the divisor.")


def _reduction(name: str, numeric: str, text: str) -> Callable[..., Any]:
    def function(*arguments: Any) -> Any:
        if not any(_is_symbolic(a) for a in arguments):
            data = arguments[0] if len(arguments) == 1 else arguments
            return getattr(np, numeric)(np.asarray(data))
        return called(name, *arguments, dimensions=0)

    function.__name__ = function.__qualname__ = name
    function.__doc__ = text
    return function


def _is_symbolic(value: Any) -> bool:
    if isinstance(value, list | tuple):
        return any(_is_symbolic(v) for v in value)
    return isinstance(value, Symbolic)


sum = _reduction("sum", "sum", "Sum of all elements of an array.")  # noqa: A001
product = _reduction("product", "prod", "Product of all elements of an array.")
min = _reduction("min", "min", "Smallest of two values, or of an array.")  # noqa: A001
max = _reduction("max", "max", "Largest of two values, or of an array.")  # noqa: A001


def der(x: Any) -> Symbolic:
    """Return the derivative of a variable or expression with respect to time."""
    return called("der", x)


def pre(x: Any) -> Symbolic:
    """Return the value of a discrete variable before the event."""
    return called("pre", x)


def edge(b: Any) -> Symbolic:
    """Return whether a Boolean becomes true at this event."""
    return called("edge", b)


def change(x: Any) -> Symbolic:
    """Return whether a discrete variable changes at this event."""
    return called("change", x)


def initial() -> Symbolic:
    """Return whether it is the first instant."""
    return called("initial")


def terminal() -> Symbolic:
    """Return whether it is the last instant of a successful simulation."""
    return called("terminal")


def sample(start: Any, interval: Any) -> Symbolic:
    """Return true at ``start``, ``start + interval``, ... (seconds)."""
    return called("sample", start, interval, dimensions=0)


def delay(x: Any, by: Any, largest: Any = None) -> Symbolic:
    """Return an expression as it was ``by`` seconds ago.

    Args:
        x: The expression.
        by: The delay, seconds; it may vary if ``largest`` is given.
        largest: Largest delay, seconds.
    """
    return called("delay", x, by) if largest is None else called("delay", x, by, largest)


def no_event(x: Any) -> Symbolic:
    """Return an expression whose relations are evaluated as they are, without events."""
    return called("noEvent", x)


def smooth(order: int, x: Any) -> Symbolic:
    """Return an expression that is said to be continuous with ``order`` derivatives."""
    return called("smooth", order, x)


def homotopy(actual: Any, simplified: Any) -> Symbolic:
    """Return ``actual``; the start is sought from ``simplified`` on."""
    span = here()
    given = [("actual", operand(actual, span)), ("simplified", operand(simplified, span))]
    return Invocation("homotopy", (), span, given)


def where(condition: Any, first: Any, second: Any) -> Symbolic:
    """Return ``first`` where the condition holds, else ``second``.

    Example:
        >>> import acausal as ac
        >>> ac.where(ac.time < 1, 0.0, ac.time - 1)
        if time < 1 then 0.0 else time - 1
    """
    span = here()
    return Choice(operand(condition, span), operand(first, span), operand(second, span), span)


def and_(*conditions: Any) -> Symbolic:
    """Return whether all conditions hold; ``&`` between two does the same."""
    return _joined("and", conditions)


def or_(*conditions: Any) -> Symbolic:
    """Return whether at least one condition holds; ``|`` between two does the same."""
    return _joined("or", conditions)


def _joined(operator: str, conditions: Iterable[Any]) -> Symbolic:
    from acausal.compose.symbols import Operation

    span = here()
    given = [operand(c, span) for c in conditions]
    if not given:
        return Literal(tree.BooleanLiteral(span, operator == "and"))
    result = given[0]
    for other in given[1:]:
        result = Operation(operator, (result, other), span)
    return result


def not_(condition: Any) -> Symbolic:
    """Return whether a condition does not hold; ``~`` does the same."""
    return ~operand(condition, here())


def size(x: Any, dimension: int | None = None) -> Symbolic:
    """Return the size of an array along a dimension (from 0), or of a vector."""
    if isinstance(x, Symbolic) and x._ndim == 0:
        fail("T113", f"{x!r} is no array", here(), help="give an array")
    return called("size", x, 1 if dimension is None else dimension + 1, dimensions=0)


def cross(a: Any, b: Any) -> Symbolic:
    """Return the cross product of two vectors of three elements."""
    return called("cross", a, b)


def transpose(a: Any) -> Symbolic:
    """Return a matrix with rows and columns exchanged."""
    return called("transpose", a)


def function(name: str, *arguments: Any, dimensions: int = 0) -> Symbolic:
    """Return a call of any function of the language by name.

    Args:
        name: For example ``"semiLinear"``.
        arguments: Its arguments.
        dimensions: Array dimensions of the result.
    """
    return called(name, *arguments, dimensions=dimensions)
