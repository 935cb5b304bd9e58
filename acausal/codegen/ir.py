"""A small statement form of kernels, independent of the target language.

A kernel is a loop over the members ``k`` of an equation family. Its body is straight-line code in
static single assignment, in which ``if`` markers may enclose parts that only one branch needs.

=============== ============== ===================================================== ==========
op              args           meaning                                               result
=============== ============== ===================================================== ==========
``const``       none           ``value``                                             number
``time``        none           ``w[1]``, in s                                        number
``load``        none           ``w[index[value, k]]``                                number
``add`` ``sub`` two            arithmetic                                            number
``mul`` ``div``
``neg``         one            change of sign                                        number
``sqrt`` ``abs`` one           processor instructions                                number
``floor`` ``ceil`` ``trunc``
``math``        one or two     function ``value`` of the C mathematical library      number
``lt le gt ge`` two            comparison, false with NaN (``ne``: true)             truth
``eq ne``
``and`` ``or``  two            of truths                                             truth
``not``         one            of a truth                                            truth
``number``      one            1.0 or 0.0 of a truth                                 number
``select``      three          second or third by the truth of the first             number
``if``          one            begin of what is computed if the truth holds          none
``else``        none           begin of what is computed otherwise                   none
``end``         none           end of both                                           none
``merge``       three          right after ``end``: as ``select``, of the branches   number
``accumulate``  one            ``out[target[value, k]] +=`` the number               none
=============== ============== ===================================================== ==========
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

#: Functions of the C mathematical library that kernels may call, and their argument counts.
MATH_FUNCTIONS: Final[dict[str, int]] = {
    "sin": 1, "cos": 1, "tan": 1, "asin": 1, "acos": 1, "atan": 1, "atan2": 2,
    "sinh": 1, "cosh": 1, "tanh": 1, "exp": 1, "log": 1, "log10": 1, "pow": 2,
}  # fmt: skip

#: Operations whose result is a truth; all others give a number.
TRUTH_OPERATIONS: Final = frozenset(("lt", "le", "gt", "ge", "eq", "ne", "and", "or", "not"))


class Instruction(NamedTuple):
    """One statement; ``result`` is the number of its value, -1 if it has none."""

    op: str
    result: int
    args: tuple[int, ...] = ()
    value: float | int | str | None = None


@dataclass(frozen=True)
class KernelCode:
    """One kernel function.

    Attributes:
        slots: Number of operands of a member (rows of the index array).
        outputs: Number of targets of a member.
        prologue: What is the same for all members, computed once before the loop.
        body: What is done for each member.
    """

    slots: int
    outputs: int
    prologue: tuple[Instruction, ...]
    body: tuple[Instruction, ...]

    @property
    def weight(self) -> int:
        """Length of the body in machine terms; memory is reached through an index."""
        return sum(5 if item.op in ("load", "accumulate") else 1 for item in self.body)

    def __str__(self) -> str:
        lines = [_line(item) for item in self.prologue]
        lines.append("for each member k:")
        depth = 1
        for item in self.body:
            depth -= item.op in ("else", "end")
            lines.append("  " * depth + _line(item))
            depth += item.op in ("if", "else")
        return "\n".join(lines)


def _line(item: Instruction) -> str:
    words = [item.op, *([] if item.value is None else [str(item.value)])]
    words += [f"v{argument}" for argument in item.args]
    return (f"v{item.result} = " if item.result >= 0 else "") + " ".join(words)
