"""Templates to the statement form of kernels.

Common subexpressions are shared across all outputs, so a Jacobian kernel computes an exponential
once for the value and the derivatives that need it. Small integer powers become multiplications,
powers by halves square roots. A division stays a division, except by a power of two, whose
reciprocal is exact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from acausal.codegen.branches import schedule
from acausal.codegen.ir import MATH_FUNCTIONS, TRUTH_OPERATIONS, Instruction, KernelCode
from acausal.expressions.nodes import RELATIONS, Expr
from acausal.expressions.traverse import postorder

_LARGEST_POWER: Final = 32
_DIRECT: Final = frozenset(("sqrt", "abs", "floor", "ceil"))


def lower(outputs: Sequence[Expr], slots: int) -> KernelCode:
    """Return the kernel that accumulates ``outputs[j]`` into its ``j``-th target.

    Args:
        outputs: Expressions over integer slots ``0 .. slots-1``.
        slots: Number of operands of a member.
    """
    builder = _Builder()
    for item in postorder(*outputs):
        builder.native[item] = builder.translate(item)
    roots = [builder.number(item) for item in outputs]
    prologue, body = schedule(builder.instructions, roots)
    return KernelCode(slots, len(outputs), tuple(prologue), tuple(body))


class _Builder:
    """Instructions made so far, each different one once."""

    def __init__(self) -> None:
        self.instructions: list[Instruction] = []
        self.native: dict[Expr, int] = {}
        self._numbers: dict[tuple[object, ...], int] = {}

    def emit(self, op: str, *args: int, value: float | int | str | None = None) -> int:
        tag = value.hex() if isinstance(value, float) else value  # keeps 0.0 and -0.0 apart
        key = (op, args, tag)
        number = self._numbers.get(key)
        if number is None:
            number = self._numbers[key] = len(self.instructions)
            self.instructions.append(Instruction(op, number, args, value))
        return number

    def constant(self, value: float) -> int:
        return self.emit("const", value=value)

    def number(self, expr: Expr) -> int:
        """Return the value of ``expr`` as a number."""
        value = self.native[expr]
        is_truth = self.instructions[value].op in TRUTH_OPERATIONS
        return self.emit("number", value) if is_truth else value

    def truth(self, expr: Expr) -> int:
        """Return the value of ``expr`` as a truth."""
        value = self.native[expr]
        is_truth = self.instructions[value].op in TRUTH_OPERATIONS
        return value if is_truth else self.emit("ne", value, self.constant(0.0))

    def translate(self, expr: Expr) -> int:
        op, args = expr.op, expr.args
        match op:
            case "const":
                assert isinstance(expr.value, float)
                return self.constant(expr.value)
            case "time":
                return self.emit("time")
            case "slot":
                assert isinstance(expr.value, int), "templates have integer slots"
                return self.emit("load", value=expr.value)
            case "and" | "or" | "not":
                return self.emit(op, *[self.truth(a) for a in args])
            case "if":
                then, otherwise = self.number(args[1]), self.number(args[2])
                return self.emit("select", self.truth(args[0]), then, otherwise)
            case "noevent" | "smooth" | "homotopy":
                return self.native[args[0]]
        numbers = [self.number(a) for a in args]
        if op in ("add", "sub", "mul", "neg") or op in RELATIONS:
            return self.emit(op, *numbers)
        if op == "div":
            return self._divide(*numbers)
        if op == "pow":
            return self._power(*numbers)
        assert op == "call", f"no code for {op}"
        return self._call(str(expr.value), numbers)

    def _constant_value(self, number: int) -> float | None:
        item = self.instructions[number]
        return float(item.value) if item.op == "const" and item.value is not None else None

    def _divide(self, a: int, b: int) -> int:
        divisor = self._constant_value(b)
        if divisor is not None and math.isfinite(divisor) and abs(math.frexp(divisor)[0]) == 0.5:
            reciprocal = 1.0 / divisor if abs(divisor) > 1e-300 else 0.0
            if abs(reciprocal) > 1e-300:
                return self.emit("mul", a, self.constant(reciprocal))
        return self.emit("div", a, b)

    def _power(self, base: int, exponent: int) -> int:
        value = self._constant_value(exponent)
        if value is None or abs(value) > _LARGEST_POWER or not (2.0 * value).is_integer():
            return self.emit("math", base, exponent, value="pow")
        whole = abs(math.trunc(value))
        power = self._integer_power(base, whole) if whole else None
        if not value.is_integer():
            root = self.emit("sqrt", base)
            power = root if power is None else self.emit("mul", power, root)
        if power is None:
            return self.constant(1.0)
        return power if value > 0.0 else self.emit("div", self.constant(1.0), power)

    def _integer_power(self, base: int, exponent: int) -> int:
        if exponent == 1:
            return base
        if exponent % 2:
            return self.emit("mul", self._integer_power(base, exponent - 1), base)
        half = self._integer_power(base, exponent // 2)
        return self.emit("mul", half, half)

    def _call(self, name: str, args: Sequence[int]) -> int:
        if name in _DIRECT:
            return self.emit(name, *args)
        if name in MATH_FUNCTIONS:
            return self.emit("math", *args, value=name)
        a = args[0]
        match name:
            case "integer":
                return self.emit("floor", a)
            case "sign":
                zero, one = self.constant(0.0), self.constant(1.0)
                negative = self.emit("lt", a, zero)
                rest = self.emit("select", negative, self.constant(-1.0), a)  # a: zero or NaN
                return self.emit("select", self.emit("gt", a, zero), one, rest)
            case "min" | "max":  # a NaN among the arguments must come through
                first = self.emit("lt" if name == "min" else "gt", a, args[1])
                first = self.emit("or", first, self.emit("ne", a, a))
                return self.emit("select", first, a, args[1])
            case "div":
                return self.emit("trunc", self._divide(a, args[1]))
            case "mod" | "rem":
                rounding = "floor" if name == "mod" else "trunc"
                whole = self.emit(rounding, self._divide(a, args[1]))
                return self.emit("sub", a, self.emit("mul", whole, args[1]))
        raise AssertionError(f"no code for {name}")
