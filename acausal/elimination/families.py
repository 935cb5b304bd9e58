"""What rows and variables equation families refer to, counted."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from acausal.flattening.members import take_members
from acausal.flattening.model import EquationFamily, Operand

#: Counts per variable or row. Half the memory of 64 bits: time goes into memory here.
Tally = NDArray[np.int32]


def keep_rows(family: EquationFamily, removed: NDArray[np.bool_]) -> EquationFamily | None:
    """Return the family without the members whose row is removed; None if none is left."""
    gone = removed[family.rows]
    if not gone.any():
        return family
    if gone.all():
        return None
    return take_members(family, np.flatnonzero(~gone))


def variable_slots(family: EquationFamily) -> list[int]:
    """Return the slots that refer to variables."""
    return [j for j, kind in enumerate(family.kinds) if kind == Operand.VARIABLE]


def row_counts(families: Iterable[EquationFamily], n_rows: int) -> Tally:
    """Return the number of contributions to each row, shape ``(n_rows,)``."""
    counts = np.zeros(n_rows, dtype=np.int32)
    for family in families:
        np.add.at(counts, family.rows, np.int32(1))
    return counts


def use_counts(families: Iterable[EquationFamily], n_variables: int) -> Tally:
    """Return how many member slots refer to each variable, shape ``(n_variables,)``."""
    counts = np.zeros(n_variables, dtype=np.int32)
    for family in families:
        for j in variable_slots(family):
            np.add.at(counts, family.operands[j], np.int32(1))
    return counts


def used_variables(families: Iterable[EquationFamily], n_variables: int) -> NDArray[np.bool_]:
    """Return which variables any member refers to, shape ``(n_variables,)``."""
    used = np.zeros(n_variables, dtype=np.bool_)
    for family in families:
        for j in variable_slots(family):
            used[family.operands[j]] = True
    return used
