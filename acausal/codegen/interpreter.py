"""Plain NumPy execution of kernels, with the signature of the native functions.

The reference against which generated code is tested, and the fallback where no native code can
be made. Both sides of a branch are computed for all members.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from acausal.codegen.ir import KernelCode
from acausal.expressions.evaluate import ARRAY_FUNCTIONS

_TIME_POSITION: Final = 1
_OPERATIONS: Final[dict[str, Callable[..., Any]]] = {
    "add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide, "neg": np.negative,
    "sqrt": np.sqrt, "abs": np.abs, "floor": np.floor, "ceil": np.ceil, "trunc": np.trunc,
    "lt": np.less, "le": np.less_equal, "gt": np.greater, "ge": np.greater_equal,
    "eq": np.equal, "ne": np.not_equal,
    "and": np.logical_and, "or": np.logical_or, "not": np.logical_not,
    "number": lambda truth: np.asarray(truth, dtype=np.float64),
    "select": np.where, "merge": np.where,
}  # fmt: skip
_MATH: Final[dict[str, Callable[..., Any]]] = {**ARRAY_FUNCTIONS, "pow": np.power}


def interpret(
    code: KernelCode,
    w: NDArray[np.float64],
    index: NDArray[np.int32],
    target: NDArray[np.int32],
    out: NDArray[np.float64],
) -> None:
    """Run a kernel for all members: ``out[target[j, k]] += output_j(w[index[:, k]])``.

    Args:
        code: The kernel.
        w: Work vector.
        index: Positions in ``w``, shape ``(slots, count)``.
        target: Positions in ``out``, shape ``(outputs, count)`` or ``(count,)`` for one output.
        out: Accumulated into; complex numbers are allowed in ``w`` and ``out`` for
            complex-step differentiation of kernels without comparisons.
    """
    count = index.shape[1]
    target = target.reshape(code.outputs, count)
    values: dict[int, Any] = {}
    with np.errstate(all="ignore"):
        for item in (*code.prologue, *code.body):
            match item.op:
                case "const":
                    values[item.result] = item.value
                case "time":
                    values[item.result] = w[_TIME_POSITION]
                case "load":
                    values[item.result] = w[index[int(item.value or 0)]]
                case "accumulate":
                    added = np.broadcast_to(values[item.args[0]], (count,))
                    np.add.at(out, target[int(item.value or 0)], added)
                case "if" | "else" | "end":
                    pass
                case "math":
                    function = _MATH[str(item.value)]
                    values[item.result] = function(*[values[a] for a in item.args])
                case op:
                    values[item.result] = _OPERATIONS[op](*[values[a] for a in item.args])
