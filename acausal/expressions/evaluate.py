"""The meaning of every operator, as vectorised NumPy: the reference for generated code."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from acausal.expressions.nodes import Expr
from acausal.expressions.traverse import postorder

Array = NDArray[Any]

#: Elementary functions. ``integer`` rounds down, as in Modelica; ``div`` truncates.
ARRAY_FUNCTIONS: Final[dict[str, Callable[..., Array]]] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan,
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2,
    "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh,
    "exp": np.exp, "log": np.log, "log10": np.log10, "sqrt": np.sqrt,
    "abs": np.abs, "sign": np.sign, "floor": np.floor, "ceil": np.ceil, "integer": np.floor,
    "min": np.minimum, "max": np.maximum,
    "mod": lambda x, y: x - np.floor(x / y) * y,
    "rem": lambda x, y: x - np.trunc(x / y) * y,
    "div": lambda x, y: np.trunc(x / y),
}  # fmt: skip


def _select(condition: Array, then: Array, otherwise: Array) -> Array:
    return np.where(condition != 0, then, otherwise)


_OPERATIONS: Final[dict[str, Callable[..., Array]]] = {
    "add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide,
    "pow": np.power, "neg": np.negative,
    "lt": lambda a, b: (a < b).astype(np.float64), "le": lambda a, b: (a <= b).astype(np.float64),
    "gt": lambda a, b: (a > b).astype(np.float64), "ge": lambda a, b: (a >= b).astype(np.float64),
    "eq": lambda a, b: (a == b).astype(np.float64), "ne": lambda a, b: (a != b).astype(np.float64),
    "and": lambda a, b: ((a != 0) & (b != 0)).astype(np.float64),
    "or": lambda a, b: ((a != 0) | (b != 0)).astype(np.float64),
    "not": lambda a: (a == 0).astype(np.float64),
    "if": _select,
    "noevent": lambda a: a, "smooth": lambda a: a, "homotopy": lambda actual, _: actual,
}  # fmt: skip


def evaluate(
    expr: Expr,
    slot_values: Callable[[Hashable], ArrayLike] | Mapping[Any, ArrayLike],
    time: ArrayLike = 0.0,
) -> NDArray[np.float64]:
    """Return the value of ``expr`` for arrays of slot values.

    Both branches of an ``if`` are computed and one is chosen, so the one not chosen may be NaN
    without harm and without a warning. Outside of their domain functions give NaN or infinity.

    Args:
        expr: The expression.
        slot_values: Values by slot key, a mapping or a function; shapes must broadcast.
        time: Time in s.

    Returns:
        Float64 array of the broadcast shape of the values that ``expr`` uses.
    """
    return evaluate_all((expr,), slot_values, time)[0]


def evaluate_all(
    exprs: tuple[Expr, ...],
    slot_values: Callable[[Hashable], ArrayLike] | Mapping[Any, ArrayLike],
    time: ArrayLike = 0.0,
) -> list[NDArray[np.float64]]:
    """Return ``evaluate`` of several expressions, sharing what they have in common."""
    lookup = slot_values if callable(slot_values) else slot_values.__getitem__
    values: dict[Expr, Array] = {}
    with np.errstate(all="ignore"):
        for item in postorder(*exprs):
            match item.op:
                case "const":
                    value = np.asarray(item.value, dtype=np.float64)
                case "time":
                    value = np.asarray(time, dtype=np.float64)
                case "slot":
                    value = np.asarray(lookup(item.value), dtype=np.float64)
                case "call":
                    function = ARRAY_FUNCTIONS[str(item.value)]
                    value = function(*[values[a] for a in item.args])
                case op:
                    value = np.asarray(_OPERATIONS[op](*[values[a] for a in item.args]))
            values[item] = value
    return [np.asarray(values[expr], dtype=np.float64) for expr in exprs]
