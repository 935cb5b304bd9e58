"""A small language for native functions that are written by hand: loops, branches, variables.

A :class:`Function` prints LLVM assembly while Python code that looks like the algorithm runs::

    f = Function("dot", "double", x="ptr", y="ptr", n="i64")
    total = f.variable("double", 0.0)
    with f.loop(f["n"]) as k:
        total.set(total + f.load(f["x"], k) * f.load(f["y"], k))
    f.give(total)

Variables live in memory until LLVM's passes put them into registers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from acausal.codegen.llvm import double_literal

_SIZES = {"double": 8, "i64": 8, "ptr": 8, "i32": 4, "i8": 1}
_REAL = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
_INTEGER = {"+": "add", "-": "sub", "*": "mul", "&": "and", "|": "or", "^": "xor"}
_REAL_TESTS = {"<": "olt", "<=": "ole", ">": "ogt", ">=": "oge", "==": "oeq", "!=": "une"}
_INTEGER_TESTS = {"<": "slt", "<=": "sle", ">": "sgt", ">=": "sge", "==": "eq", "!=": "ne"}


class Value:
    """A value in a function: an LLVM type and a name or literal.

    Comparisons of reals are false where one is NaN, except :meth:`differs`.
    """

    def __init__(self, function: Function, kind: str, text: str) -> None:
        """Only functions make values."""
        self.function, self.kind, self.text = function, kind, text

    def read(self) -> Value:
        """Return the value as it is now."""
        return self

    def _binary(self, sign: str, other: Value | float | int, swap: bool = False) -> Value:
        f = self.function
        a = self.read()
        b = f.operand(other, a.kind)
        if swap:
            a, b = b, a
        operation = (_REAL if a.kind == "double" else _INTEGER)[sign]
        return f.emit(a.kind, f"{operation} {a.kind} {a.text}, {b.text}")

    def _test(self, sign: str, other: Value | float | int) -> Value:
        f = self.function
        a = self.read()
        b = f.operand(other, a.kind)
        if a.kind == "double":
            return f.emit("i1", f"fcmp {_REAL_TESTS[sign]} double {a.text}, {b.text}")
        return f.emit("i1", f"icmp {_INTEGER_TESTS[sign]} {a.kind} {a.text}, {b.text}")

    def __add__(self, other: Value | float | int) -> Value:
        return self._binary("+", other)

    def __radd__(self, other: float | int) -> Value:
        return self._binary("+", other, swap=True)

    def __sub__(self, other: Value | float | int) -> Value:
        return self._binary("-", other)

    def __rsub__(self, other: float | int) -> Value:
        return self._binary("-", other, swap=True)

    def __mul__(self, other: Value | float | int) -> Value:
        return self._binary("*", other)

    def __rmul__(self, other: float | int) -> Value:
        return self._binary("*", other, swap=True)

    def __truediv__(self, other: Value | float | int) -> Value:
        return self._binary("/", other)

    def __rtruediv__(self, other: float | int) -> Value:
        return self._binary("/", other, swap=True)

    def __and__(self, other: Value) -> Value:
        return self._binary("&", other)

    def __or__(self, other: Value) -> Value:
        return self._binary("|", other)

    def __invert__(self) -> Value:
        return self._binary("^", self.function.operand(1, self.read().kind))

    def __lt__(self, other: Value | float | int) -> Value:
        return self._test("<", other)

    def __le__(self, other: Value | float | int) -> Value:
        return self._test("<=", other)

    def __gt__(self, other: Value | float | int) -> Value:
        return self._test(">", other)

    def __ge__(self, other: Value | float | int) -> Value:
        return self._test(">=", other)

    def equals(self, other: Value | float | int) -> Value:
        """Return whether two values are equal."""
        return self._test("==", other)

    def differs(self, other: Value | float | int) -> Value:
        """Return whether two values differ (or one of them is NaN)."""
        return self._test("!=", other)


class Variable(Value):
    """A value that changes."""

    def read(self) -> Value:
        """Return the value as it is now."""
        return self.function.emit(self.kind, f"load {self.kind}, ptr {self.text}")

    def set(self, value: Value | float | int) -> None:
        """Assign."""
        f = self.function
        f.put(f"store {self.kind} {f.operand(value, self.kind).text}, ptr {self.text}")


class Function:
    """A function under construction."""

    def __init__(self, name: str, result: str, internal: bool = False, **arguments: str) -> None:
        """Begin a function.

        Args:
            name: Its symbol.
            result: Type of what it returns: ``double``, ``i64``, ``i32``, ``ptr`` or ``void``.
            internal: Whether it is for this module only.
            **arguments: Types by name.
        """
        listed = ", ".join(f"{kind} %{key}" for key, kind in arguments.items())
        scope = "internal " if internal else ""
        self._head = f"define {scope}{result} @{name}({listed}) nounwind {{\nentry:\n"
        self._result = result
        self._arguments = {k: Value(self, kind, f"%{k}") for k, kind in arguments.items()}
        self._variables: list[str] = []
        self._lines: list[str] = []
        self._count = 0
        self._ended = False

    def __getitem__(self, name: str) -> Value:
        """Return an argument."""
        return self._arguments[name]

    def text(self) -> str:
        """Return the assembly of the finished function."""
        if not self._ended:
            self.give(*(() if self._result == "void" else (0,)))
        variables = "".join(self._variables)
        return self._head + variables + "  br label %code\ncode:\n" + "".join(self._lines) + "}\n"

    def put(self, line: str) -> None:
        """Print an instruction without a result."""
        if self._ended:  # unreachable, but it needs a block
            self._label(self._name("dead"))
        self._lines.append(f"  {line}\n")

    def emit(self, kind: str, line: str) -> Value:
        """Print an instruction with a result."""
        name = f"%{self._name('v')}"
        self.put(f"{name} = {line}")
        return Value(self, kind, name)

    def _name(self, stem: str) -> str:
        self._count += 1
        return f"{stem}{self._count}"

    def _label(self, name: str) -> None:
        self._lines.append(f"{name}:\n")
        self._ended = False

    def _jump(self, name: str) -> None:
        if not self._ended:
            self.put(f"br label %{name}")
            self._ended = True

    def operand(self, value: Value | float | int, kind: str) -> Value:
        """Return a value of a type, from a value or a number."""
        if isinstance(value, Value):
            present = value.read()
            assert present.kind == kind, f"{present.kind} where {kind} is wanted"
            return present
        if kind == "double":
            return Value(self, kind, double_literal(float(value)))
        if kind == "ptr":
            assert value == 0
            return Value(self, kind, "null")
        return Value(self, kind, str(int(value)))

    def number(self, value: float) -> Value:
        """Return a constant double."""
        return self.operand(value, "double")

    def variable(self, kind: str, value: Value | float | int) -> Variable:
        """Return a new variable."""
        name = f"%{self._name('x')}"
        self._variables.append(f"  {name} = alloca {kind}\n")
        variable = Variable(self, kind, name)
        variable.set(value)
        return variable

    def address(self, variable: Variable) -> Value:
        """Return where a variable is, for functions that write to it."""
        return Value(self, "ptr", variable.text)

    # --- memory

    def at(self, base: Value, index: Value | int, kind: str = "double") -> Value:
        """Return the address of an element of an array."""
        base, place = base.read(), self.operand(index, "i64")
        return self.emit("ptr", f"getelementptr {kind}, ptr {base.text}, i64 {place.text}")

    def load(self, base: Value, index: Value | int, kind: str = "double") -> Value:
        """Return an element of an array."""
        place = self.at(base, index, kind)
        return self.emit(kind, f"load {kind}, ptr {place.text}, align {_SIZES[kind]}")

    def store(
        self, base: Value, index: Value | int, value: Value | float | int, kind: str = "double"
    ) -> None:
        """Assign to an element of an array."""
        place = self.at(base, index, kind)
        stored = self.operand(value, kind)
        self.put(f"store {kind} {stored.text}, ptr {place.text}, align {_SIZES[kind]}")

    def copy(self, to: Value, source: Value, count: Value) -> None:
        """Copy doubles between arrays that do not overlap."""
        size = (count * 8).text
        self.put(
            f"call void @llvm.memcpy.p0.p0.i64(ptr {to.read().text}, ptr {source.read().text}, "
            f"i64 {size}, i1 false)"
        )

    def clear(self, to: Value, count: Value) -> None:
        """Set doubles to zero."""
        size = (count * 8).text
        self.put(f"call void @llvm.memset.p0.i64(ptr {to.read().text}, i8 0, i64 {size}, i1 false)")

    # --- values

    def call(self, kind: str, function: str | Value, *arguments: Value) -> Value:
        """Call a function by name or by address."""
        read = [argument.read() for argument in arguments]
        listed = ", ".join(f"{a.kind} {a.text}" for a in read)
        target = f"@{function}" if isinstance(function, str) else function.read().text
        if kind == "void":
            self.put(f"call void {target}({listed})")
            return Value(self, "void", "")
        return self.emit(kind, f"call {kind} {target}({listed})")

    def select(self, condition: Value, a: Value | float | int, b: Value | float | int) -> Value:
        """Return one of two values; one of them at least is no plain number."""
        kind = a.kind if isinstance(a, Value) else b.kind  # type: ignore[union-attr]
        x, y = self.operand(a, kind), self.operand(b, kind)
        chosen = condition.read()
        return self.emit(kind, f"select i1 {chosen.text}, {kind} {x.text}, {kind} {y.text}")

    def abs(self, a: Value) -> Value:
        """Return a magnitude."""
        return self.emit("double", f"call double @llvm.fabs.f64(double {a.read().text})")

    def sqrt(self, a: Value) -> Value:
        """Return a square root."""
        return self.emit("double", f"call double @llvm.sqrt.f64(double {a.read().text})")

    def smaller(self, a: Value, b: Value | float) -> Value:
        """Return the smaller one (the second where one is NaN)."""
        a, b = a.read(), self.operand(b, a.kind)
        return self.select(a < b, a, b)

    def larger(self, a: Value, b: Value | float) -> Value:
        """Return the larger one (the second where one is NaN)."""
        a, b = a.read(), self.operand(b, a.kind)
        return self.select(a > b, a, b)

    def half(self, a: Value) -> Value:
        """Return half of an integer that is not negative, rounded down."""
        return self.emit("i64", f"lshr i64 {a.read().text}, 1")

    def wide(self, a: Value) -> Value:
        """Return an index of 32 bits as one of 64."""
        return self.emit("i64", f"sext i32 {a.read().text} to i64")

    def real(self, a: Value) -> Value:
        """Return an integer as a double."""
        a = a.read()
        return self.emit("double", f"sitofp {a.kind} {a.text} to double")

    # --- control

    def give(self, *value: Value | float | int) -> None:
        """Return from the function."""
        if value:
            self.put(f"ret {self._result} {self.operand(value[0], self._result).text}")
        else:
            self.put("ret void")
        self._ended = True

    @contextmanager
    def when(self, condition: Value) -> Iterator[None]:
        """Do what follows only if a condition holds."""
        inside, after = self._name("then"), self._name("after")
        self.put(f"br i1 {condition.read().text}, label %{inside}, label %{after}")
        self._label(inside)
        yield
        self._jump(after)
        self._label(after)

    @contextmanager
    def while_(self, condition: Callable[[], Value]) -> Iterator[None]:
        """Repeat what follows as long as a condition, evaluated before each turn, holds."""
        head, body, after = self._name("head"), self._name("body"), self._name("after")
        self._jump(head)
        self._label(head)
        self.put(f"br i1 {condition().read().text}, label %{body}, label %{after}")
        self._label(body)
        yield
        self._jump(head)
        self._label(after)

    @contextmanager
    def loop(self, end: Value, begin: Value | int = 0) -> Iterator[Value]:
        """Repeat for each integer from ``begin`` to before ``end``; both are read once."""
        last = end.read()
        counter = self.variable("i64", begin)
        with self.while_(lambda: counter < last):
            present = counter.read()
            yield present
            counter.set(present + 1)


#: What every module needs beside its functions.
DECLARATIONS = """
declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)
declare void @llvm.memset.p0.i64(ptr, i8, i64, i1)
declare double @llvm.fabs.f64(double)
declare double @llvm.sqrt.f64(double)
"""


def module(*functions: Function) -> str:
    """Return the assembly of a module."""
    return DECLARATIONS + "".join(function.text() for function in functions)
