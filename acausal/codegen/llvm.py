"""Kernels as LLVM assembly text.

Text is printed directly: building a module through a Python object model takes longer than
parsing and compiling it. Floating point stays strict (no reassociation, no contraction), so
results equal those of the interpreter up to the mathematical library.
"""

from __future__ import annotations

import struct
from typing import Final

from acausal.codegen.ir import MATH_FUNCTIONS, Instruction, KernelCode

_ARITHMETIC: Final = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}
_INTRINSICS: Final = {
    "sqrt": "llvm.sqrt.f64", "abs": "llvm.fabs.f64", "floor": "llvm.floor.f64",
    "ceil": "llvm.ceil.f64", "trunc": "llvm.trunc.f64",
}  # fmt: skip
_COMPARISONS: Final = {
    "lt": "olt", "le": "ole", "gt": "ogt", "ge": "oge", "eq": "oeq", "ne": "une",
}  # fmt: skip

#: What every module with kernels begins with. Mathematical functions are declared free of side
#: effects: nobody reads ``errno``.
DECLARATIONS: Final = "".join(
    f"declare double @{name}({', '.join(['double'] * arity)}) nounwind willreturn memory(none)\n"
    for name, arity in [*MATH_FUNCTIONS.items(), *((i, 1) for i in _INTRINSICS.values())]
)

_SIGNATURE: Final = (
    "define void @{name}(i64 %count, ptr %w, ptr %index, ptr %target, ptr %out) nounwind {{\n"
)


def print_kernel(name: str, code: KernelCode) -> str:
    """Return the LLVM function ``name``: for each ``k``, ``out[target[j][k]] += output_j``."""
    if not code.outputs:
        return _SIGNATURE.format(name=name) + "  ret void\n}\n"
    return _Printer(name, code).text()


def print_value_kernel(name: str, accumulating: str) -> str:
    """Return the LLVM function that stores what the kernel ``accumulating`` adds.

    It clears the targets and calls that kernel; compiled without optimisation (``optnone``),
    that costs a tenth of the compile time of a second body.
    """
    return (
        _SIGNATURE.format(name=name).replace("nounwind", "nounwind noinline optnone")
        + f"""entry:
  %some = icmp sgt i64 %count, 0
  br i1 %some, label %loop, label %exit
loop:
  %k = phi i64 [ 0, %entry ], [ %next, %loop ]
  %at = getelementptr inbounds i32, ptr %target, i64 %k
  %position = load i32, ptr %at, align 4
  %wide = zext nneg i32 %position to i64
  %cell = getelementptr inbounds double, ptr %out, i64 %wide
  store double 0.0, ptr %cell, align 8
  %next = add nuw nsw i64 %k, 1
  %more = icmp slt i64 %next, %count
  br i1 %more, label %loop, label %call
call:
  call void @{accumulating}(i64 %count, ptr %w, ptr %index, ptr %target, ptr %out)
  br label %exit
exit:
  ret void
}}
"""
    )


def double_literal(value: float) -> str:
    """Return the exact LLVM literal of a double."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


class _Printer:
    """State of printing one function: names of values, the open branches, the current block."""

    def __init__(self, name: str, code: KernelCode) -> None:
        self.name, self.code = name, code
        self.lines: list[str] = []
        self.names: dict[int, str] = {}
        self.block = "prologue"
        self.branch_count = 0
        self.open_branches: list[tuple[int, str]] = []  # number, last block of the first side
        self.merged = ("", "")

    def text(self) -> str:
        code, put = self.code, self.lines.append
        loads = sorted({int(i.value or 0) for i in code.body if i.op == "load"})
        targets = sorted({int(i.value or 0) for i in code.body if i.op == "accumulate"})
        put(
            "entry:\n  %some = icmp sgt i64 %count, 0\n"
            "  br i1 %some, label %prologue, label %exit\nprologue:"
        )
        for kind, array, rows in (("row", "index", loads), ("entry", "target", targets)):
            for row in rows:
                put(f"  %{kind}.o{row} = mul nuw nsw i64 %count, {row}")
                put(
                    f"  %{kind}{row} = getelementptr inbounds i32, ptr %{array}, i64 %{kind}.o{row}"
                )
        for item in code.prologue:
            self._print(item)
        put("  br label %loop\nloop:\n  %k = phi i64 [ 0, %prologue ], [ %next, %latch ]")
        self.block = "loop"
        for item in code.body:
            self._print(item)
        put(
            "  br label %latch\nlatch:\n  %next = add nuw nsw i64 %k, 1\n"
            "  %more = icmp slt i64 %next, %count\n  br i1 %more, label %loop, label %exit\n"
            "exit:\n  ret void\n}\n"
        )
        return _SIGNATURE.format(name=self.name) + "\n".join(self.lines)

    def _position(self, row: str, tag: str) -> str:
        """Print the load of an index and return the name of its value."""
        self.lines.append(
            f"  %{tag}.p = getelementptr inbounds i32, ptr %{row}, i64 %k\n"
            f"  %{tag}.n = load i32, ptr %{tag}.p, align 4\n"
            f"  %{tag}.i = zext nneg i32 %{tag}.n to i64"
        )
        return f"%{tag}.i"

    def _print(self, item: Instruction) -> None:
        op = item.op
        if op == "const":
            assert isinstance(item.value, float)
            self.names[item.result] = double_literal(item.value)
            return
        result = f"%v{item.result}"
        if item.result >= 0:
            self.names[item.result] = result
        a = [self.names[argument] for argument in item.args]
        match op:
            case "time":
                line = f"{result}.p = getelementptr inbounds double, ptr %w, i64 1\n"
                line += f"  {result} = load double, ptr {result}.p, align 8"
            case "load":
                position = self._position(f"row{item.value}", f"v{item.result}")
                line = f"{result}.a = getelementptr inbounds double, ptr %w, i64 {position}\n"
                line += f"  {result} = load double, ptr {result}.a, align 8"
            case "accumulate":
                tag = f"s{item.value}"
                position = self._position(f"entry{item.value}", tag)
                line = f"%{tag}.a = getelementptr inbounds double, ptr %out, i64 {position}\n"
                line += f"  %{tag}.old = load double, ptr %{tag}.a, align 8\n"
                line += f"  %{tag}.new = fadd double %{tag}.old, {a[0]}\n"
                line += f"  store double %{tag}.new, ptr %{tag}.a, align 8"
            case "add" | "sub" | "mul" | "div":
                line = f"{result} = {_ARITHMETIC[op]} double {a[0]}, {a[1]}"
            case "neg":
                line = f"{result} = fneg double {a[0]}"
            case "lt" | "le" | "gt" | "ge" | "eq" | "ne":
                line = f"{result} = fcmp {_COMPARISONS[op]} double {a[0]}, {a[1]}"
            case "and" | "or":
                line = f"{result} = {op} i1 {a[0]}, {a[1]}"
            case "not":
                line = f"{result} = xor i1 {a[0]}, true"
            case "number":
                line = f"{result} = uitofp i1 {a[0]} to double"
            case "select":
                line = f"{result} = select i1 {a[0]}, double {a[1]}, double {a[2]}"
            case "math":
                arguments = ", ".join(f"double {name}" for name in a)
                line = f"{result} = call double @{item.value}({arguments})"
            case "merge":
                first, second = self.merged
                line = f"{result} = phi double [ {a[1]}, %{first} ], [ {a[2]}, %{second} ]"
            case "if" | "else" | "end":
                line = self._marker(op, a)
            case _:
                line = f"{result} = call double @{_INTRINSICS[op]}(double {a[0]})"
        self.lines.append("  " + line)

    def _marker(self, op: str, args: list[str]) -> str:
        """Return the jump and the label that begin or end one side of a branch."""
        if op == "if":
            number = self.branch_count
            self.branch_count += 1
            self.open_branches.append((number, ""))
            self.block = f"then{number}"
            jump = f"br i1 {args[0]}, label %then{number}, label %else{number}"
        elif op == "else":
            number, _ = self.open_branches[-1]
            self.open_branches[-1] = (number, self.block)
            self.block = f"else{number}"
            jump = f"br label %end{number}"
        else:
            number, last = self.open_branches.pop()
            self.merged = (last, self.block)
            self.block = f"end{number}"
            jump = f"br label %end{number}"
        return f"{jump}\n{self.block}:"
