"""Hash-consed expression DAG: what templates are made of.

Equal expressions are the same object, so equality is identity, dictionaries over nodes are cheap,
and common subexpressions are found by construction. Walk them with an explicit stack, never by
recursion: a sum over an unrolled array may be thousands deep.

Operators (``op``), arguments and payload (``value``):

============================= ======================= =======================================
op                            args                    value
============================= ======================= =======================================
``const``                     none                    float
``time``                      none                    none; unit s
``slot``                      none                    hashable: a reference inside a class,
                                                      an int from 0 once in a template
``add`` ``sub`` ``mul``       two                     none
``div`` ``pow``
``neg`` ``not``               one                     none
``lt le gt ge eq ne``         two                     none; result is 1.0 or 0.0
``and`` ``or``                two                     none; result is 1.0 or 0.0
``if``                        condition, then, else   none
``homotopy``                  actual, simplified      none
``noevent``                   one                     none: its relations make no events
``smooth``                    one                     int: continuous up to this order
``call``                      any                     name of a function of ``FUNCTIONS``
============================= ======================= =======================================
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from typing import Final
from weakref import WeakValueDictionary

#: Elementary functions and their number of arguments. ``mod``, ``rem``, ``div`` (integer
#: quotient), ``floor``, ``ceil``, ``integer`` and ``sign`` are piecewise constant or linear.
FUNCTIONS: Final[dict[str, int]] = {
    "sin": 1, "cos": 1, "tan": 1, "asin": 1, "acos": 1, "atan": 1, "atan2": 2,
    "sinh": 1, "cosh": 1, "tanh": 1, "exp": 1, "log": 1, "log10": 1, "sqrt": 1,
    "abs": 1, "sign": 1, "floor": 1, "ceil": 1, "integer": 1, "min": 2, "max": 2,
    "mod": 2, "rem": 2, "div": 2,
}  # fmt: skip

RELATIONS: Final = ("lt", "le", "gt", "ge", "eq", "ne")


class Expr:
    """A node of the DAG. Make nodes with the functions below, never with this constructor.

    Attributes:
        op: The operator, see the module's table.
        args: The arguments.
        value: The payload.
    """

    __slots__ = ("__weakref__", "args", "op", "value")

    op: str
    args: tuple[Expr, ...]
    value: Hashable

    def __reduce__(self) -> tuple[Callable[..., Expr], tuple[str, tuple[Expr, ...], Hashable]]:
        return (node, (self.op, self.args, self.value))

    def __repr__(self) -> str:
        inner = ", ".join(
            [*map(repr, self.args), *([repr(self.value)] if self.value is not None else [])]
        )
        return f"{self.op}({inner})"


_table: WeakValueDictionary[tuple[object, ...], Expr] = WeakValueDictionary()


def node(op: str, args: tuple[Expr, ...] = (), value: Hashable = None) -> Expr:
    """Return the one node with this operator, arguments and payload (no simplification)."""
    # -0.0 == 0.0 and 1 == 1.0 == True as dictionary keys: the type and sign keep them apart.
    tag = (type(value), math.copysign(1.0, value)) if isinstance(value, float) else type(value)
    key = (op, value, tag, *map(id, args))
    found = _table.get(key)
    if found is None:
        found = Expr()
        found.op, found.args, found.value = op, args, value
        _table[key] = found
    return found


def const(value: float) -> Expr:
    """Return a number."""
    return node("const", (), float(value))


def slot(key: Hashable) -> Expr:
    """Return a slot: an operand of a template."""
    return node("slot", (), key)


ZERO: Final = const(0.0)
ONE: Final = const(1.0)
TIME: Final = node("time")
