"""Index letters for subscripts that vary: ``section[k].right`` meets ``section[k+1].left``."""

from __future__ import annotations

from itertools import count
from math import prod

import numpy as np
from numpy.typing import NDArray

from acausal.instantiation.numbering import Ids

_LETTERS = "kjmnpqrs"
#: Values of an index without a rule that are listed.
_MOST_LISTED = 4


class IndexNames:
    """Names for columns of subscripts, all of the same length.

    A column that is constant is a number. The first one that varies becomes index ``k``; one that
    differs from a known index by a constant is written by it, ``k+1``; any other gets a letter
    of its own.

    Attributes:
        length: Number of members of every column.
    """

    def __init__(self, length: int, letters_used: int = 0) -> None:
        self.length = length
        self._known: list[tuple[str, Ids]] = []
        self._skip = letters_used

    def text(self, column: Ids) -> str:
        """Return how a column is written, shape ``(length,)``."""
        if (column == column[0]).all():
            return str(int(column[0]))
        for letter, values in self._known:
            shift = int(column[0] - values[0])
            if (column - values == shift).all():
                return letter if not shift else f"{letter}{shift:+d}"
        letter = _letter(self._skip + len(self._known))
        self._known.append((letter, column))
        return letter

    def affine(self, values: NDArray[np.float64]) -> tuple[float, float, str] | None:
        """Return ``(a, b, letter)`` if ``values`` are ``a*letter + b`` of a known index."""
        for letter, own in self._known:
            low, high = int(own.argmin()), int(own.argmax())
            a = float(values[high] - values[low]) / float(own[high] - own[low])
            b = float(values[low]) - a * float(own[low])
            scale = float(np.abs(values).max(initial=0.0)) + abs(b)
            if np.allclose(a * own + b, values, rtol=0.0, atol=1e-13 * scale):
                return (
                    float(f"{a:.14g}"),
                    float(f"{b:.14g}") if abs(b) > 1e-14 * scale else 0.0,
                    letter,
                )
        return None

    @property
    def used(self) -> int:
        """Number of letters given so far, those of others included."""
        return self._skip + len(self._known)

    def ranges(self) -> tuple[tuple[str, str, str], ...]:
        """Return letter, text and LaTeX of the values of each index."""
        return tuple((letter, *_range(values)) for letter, values in self._known)

    def covered(self) -> bool:
        """Tell whether all combinations of the index values occur."""
        return prod(len(_distinct(v)) for _, v in self._known) == self.length

    def text_of_ranges(self) -> str:
        """Return ``for k in 1:10, j in 1:3``, empty without indices."""
        if not self._known:
            return ""
        own = ", ".join(f"{letter} in {text}" for letter, text, _ in self.ranges())
        return f"for {own}" if self.covered() else f"for {self.length} of {own}"

    def latex_of_ranges(self) -> str:
        r"""Return ``k = 1, \dots, 10``, empty without indices."""
        return r",\; ".join(f"{letter} = {latex}" for letter, _, latex in self.ranges())


def _letter(number: int) -> str:
    if number < len(_LETTERS):
        return _LETTERS[number]
    return next(f"k{n}" for n in count(number - len(_LETTERS) + 1))


def _distinct(values: Ids) -> Ids:
    """Return the values in ascending order, each once; most columns are that already."""
    return values if (values[1:] > values[:-1]).all() else np.unique(values)


def _range(values: Ids) -> tuple[str, str]:
    distinct = _distinct(values)
    low, high = int(distinct[0]), int(distinct[-1])
    if len(distinct) <= 3:
        listed = ", ".join(str(v) for v in distinct.tolist())
        whole = high - low == len(distinct) - 1
        return f"{low}:{high}" if whole else f"{{{listed}}}", listed
    step = int(distinct[1] - distinct[0])
    if (np.diff(distinct) == step).all():
        text = f"{low}:{high}" if step == 1 else f"{low}:{step}:{high}"
        second = "" if step == 1 else f" {low + step},"
        return text, rf"{low},{second} \dots, {high}"
    first = ", ".join(str(v) for v in distinct[:_MOST_LISTED].tolist())
    return f"{{{first}, ... {high}}}", rf"{first}, \dots, {high}"
