"""Constructors of expressions with light, exact simplification.

A constructor simplifies only what keeps the value (up to the sign of a zero, and to ``0*x = 0``):
constants are folded in IEEE double arithmetic, neutral elements vanish, signs move outwards.
Operations that would fail or overflow (``1/0``, ``log(-1)``) are kept, so that they fail where
they are evaluated and can be reported there. The order of the user's terms is kept.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from acausal.expressions.nodes import FUNCTIONS, ONE, RELATIONS, ZERO, Expr, const, node


def _is_const(expr: Expr) -> bool:
    return expr.op == "const"


def number_of(expr: Expr) -> float:
    """Return the number of a ``const`` node."""
    assert isinstance(expr.value, float)
    return expr.value


def _folded(operation: Callable[..., float], *args: Expr) -> Expr | None:
    """Return the constant ``operation(*args)``, or None if it has no finite value."""
    try:
        result = operation(*map(number_of, args))
    except (ArithmeticError, ValueError):
        return None
    if isinstance(result, complex) or not math.isfinite(result):
        return None
    return const(result)


def add(a: Expr, b: Expr) -> Expr:
    """Return ``a + b``."""
    if a is ZERO:
        return b
    if b is ZERO:
        return a
    if _is_const(a) and _is_const(b) and (folded := _folded(lambda x, y: x + y, a, b)):
        return folded
    if b.op == "neg":
        return sub(a, b.args[0])
    if a.op == "neg" and a.args[0] is b:
        return ZERO
    return node("add", (a, b))


def sub(a: Expr, b: Expr) -> Expr:
    """Return ``a - b``."""
    if b is ZERO:
        return a
    if a is ZERO:
        return neg(b)
    if a is b:
        return ZERO
    if _is_const(a) and _is_const(b) and (folded := _folded(lambda x, y: x - y, a, b)):
        return folded
    if b.op == "neg":
        return add(a, b.args[0])
    return node("sub", (a, b))


def neg(a: Expr) -> Expr:
    """Return ``-a``."""
    if a.op == "neg":
        return a.args[0]
    if _is_const(a):
        return const(0.0 - number_of(a))
    if a.op == "sub":
        return node("sub", (a.args[1], a.args[0]))
    if a.op in ("mul", "div") and _is_const(a.args[0]):
        return node(a.op, (const(-number_of(a.args[0])), a.args[1]))
    return node("neg", (a,))


def mul(a: Expr, b: Expr) -> Expr:
    """Return ``a * b``."""
    if a is ONE:
        return b
    if b is ONE:
        return a
    if _is_zero(a) or _is_zero(b):
        return ZERO
    if _is_const(a) and _is_const(b) and (folded := _folded(lambda x, y: x * y, a, b)):
        return folded
    if a.op == "const" and a.value == -1.0:
        return neg(b)
    if b.op == "const" and b.value == -1.0:
        return neg(a)
    if a.op == "neg":
        return mul(a.args[0], b.args[0]) if b.op == "neg" else neg(mul(a.args[0], b))
    if b.op == "neg":
        return neg(mul(a, b.args[0]))
    return node("mul", (a, b))


def div(a: Expr, b: Expr) -> Expr:
    """Return ``a / b``; a division by a constant zero is kept."""
    if b is ONE:
        return a
    if _is_zero(b):
        return node("div", (a, b))
    if _is_zero(a):
        return ZERO
    if _is_const(a) and _is_const(b) and (folded := _folded(lambda x, y: x / y, a, b)):
        return folded
    if b.op == "const" and b.value == -1.0:
        return neg(a)
    if a.op == "neg":
        return div(a.args[0], b.args[0]) if b.op == "neg" else neg(div(a.args[0], b))
    if b.op == "neg":
        return neg(div(a, b.args[0]))
    return node("div", (a, b))


def power(a: Expr, b: Expr) -> Expr:
    """Return ``a ^ b``; small integer powers become multiplications in the kernels."""
    if b is ONE or a is ONE:
        return a
    if _is_zero(b):
        return ONE
    if _is_const(a) and _is_const(b) and (folded := _folded(math.pow, a, b)):
        return folded
    return node("pow", (a, b))


def _sign(x: float) -> float:
    return float((x > 0) - (x < 0))


def _remainder(x: float, y: float) -> float:
    return x - math.trunc(x / y) * y


def _modulo(x: float, y: float) -> float:
    return x - math.floor(x / y) * y


#: Functions on Python floats, used to fold constants; the same semantics as the kernels.
SCALAR_FUNCTIONS: Final[dict[str, Callable[..., float]]] = {
    "sin": math.sin, "cos": math.cos, "tan": math.tan,
    "asin": math.asin, "acos": math.acos, "atan": math.atan, "atan2": math.atan2,
    "sinh": math.sinh, "cosh": math.cosh, "tanh": math.tanh,
    "exp": math.exp, "log": math.log, "log10": math.log10, "sqrt": math.sqrt,
    "abs": abs, "sign": _sign, "floor": math.floor, "ceil": math.ceil, "integer": math.floor,
    "min": min, "max": max, "mod": _modulo, "rem": _remainder,
    "div": lambda x, y: math.trunc(x / y),
}  # fmt: skip


def call(name: str, *args: Expr) -> Expr:
    """Return the elementary function ``name`` of ``args``.

    Raises:
        ValueError: ``name`` is not in ``FUNCTIONS`` or the number of arguments is wrong.
    """
    if FUNCTIONS.get(name) != len(args):
        raise ValueError(f"no elementary function {name} of {len(args)} arguments")
    if all(map(_is_const, args)) and (folded := _folded(SCALAR_FUNCTIONS[name], *args)):
        return folded
    if name in ("min", "max") and args[0] is args[1]:
        return args[0]
    if name == "abs" and args[0].op == "neg":
        return call("abs", args[0].args[0])
    return node("call", args, name)


_COMPARE: Final[dict[str, Callable[[float, float], bool]]] = {
    "lt": lambda x, y: x < y, "le": lambda x, y: x <= y, "gt": lambda x, y: x > y,
    "ge": lambda x, y: x >= y, "eq": lambda x, y: x == y, "ne": lambda x, y: x != y,
}  # fmt: skip


def relation(op: str, a: Expr, b: Expr) -> Expr:
    """Return the relation ``op`` (``lt le gt ge eq ne``) of ``a`` and ``b``, 1.0 or 0.0.

    Raises:
        ValueError: ``op`` is not a relation.
    """
    if op not in RELATIONS:
        raise ValueError(f"{op} is not a relation")
    if _is_const(a) and _is_const(b):
        return ONE if _COMPARE[op](number_of(a), number_of(b)) else ZERO
    return node(op, (a, b))


def if_(condition: Expr, then: Expr, otherwise: Expr) -> Expr:
    """Return ``if condition then then else otherwise``."""
    if _is_const(condition):
        return then if number_of(condition) != 0.0 else otherwise
    if then is otherwise:
        return then
    if condition.op == "not":
        return if_(condition.args[0], otherwise, then)
    return node("if", (condition, then, otherwise))


def and_(a: Expr, b: Expr) -> Expr:
    """Return ``a and b``, 1.0 or 0.0 for Boolean (1.0 or 0.0) arguments."""
    if _is_const(a):
        return b if number_of(a) != 0.0 else ZERO
    if _is_const(b):
        return a if number_of(b) != 0.0 else ZERO
    return a if a is b else node("and", (a, b))


def or_(a: Expr, b: Expr) -> Expr:
    """Return ``a or b``, 1.0 or 0.0 for Boolean (1.0 or 0.0) arguments."""
    if _is_const(a):
        return ONE if number_of(a) != 0.0 else b
    if _is_const(b):
        return ONE if number_of(b) != 0.0 else a
    return a if a is b else node("or", (a, b))


def not_(a: Expr) -> Expr:
    """Return ``not a``."""
    if _is_const(a):
        return ZERO if number_of(a) != 0.0 else ONE
    return a.args[0] if a.op == "not" else node("not", (a,))


def noevent(a: Expr) -> Expr:
    """Return ``a`` with the mark that its relations make no events."""
    return a if not a.args or a.op == "noevent" else node("noevent", (a,))


def smooth(order: int, a: Expr) -> Expr:
    """Return ``a`` with the mark that it is continuous up to its ``order``-th derivative."""
    return a if not a.args else node("smooth", (a,), int(order))


def homotopy(actual: Expr, simplified: Expr) -> Expr:
    """Return ``actual``, to be reached from ``simplified`` when a start is hard to find."""
    return actual if actual is simplified else node("homotopy", (actual, simplified))


def rebuild(expr: Expr, args: tuple[Expr, ...]) -> Expr:
    """Return the operation of ``expr`` on other arguments, simplified."""
    if args == expr.args:
        return expr
    op = expr.op
    if op == "call":
        return call(str(expr.value), *args)
    if op == "smooth":
        assert isinstance(expr.value, int)
        return smooth(expr.value, *args)
    if op in RELATIONS:
        return relation(op, *args)
    return _CONSTRUCTORS[op](*args)


def _is_zero(expr: Expr) -> bool:
    return expr.op == "const" and expr.value == 0.0


_CONSTRUCTORS: Final[dict[str, Callable[..., Expr]]] = {
    "add": add, "sub": sub, "mul": mul, "div": div, "neg": neg, "pow": power,
    "if": if_, "and": and_, "or": or_, "not": not_, "noevent": noevent, "homotopy": homotopy,
}  # fmt: skip
