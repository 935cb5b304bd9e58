"""Block lower triangular form.

Statement (Tarjan 1972, doi 10.1137/0201010; Duff and Reid 1978, doi 10.1145/355769.355771): let
every row of a square system be matched to one variable. Row ``i`` needs row ``k`` if the variable
of ``k`` stands in ``i``. Rows that need each other are one block and must be solved together; the
blocks, sorted such that each needs only earlier ones, can be solved one after the other. The
blocks do not depend on the matching.

Complexity: linear.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from acausal.structural.graphs import Ints, stable_order, strong_components
from acausal.structural.matching import Matching


@dataclass(frozen=True)
class Blocks:
    """Blocks in the order in which they can be solved.

    Attributes:
        pointer: Where each block begins in ``rows`` and ``columns``, shape ``(n_blocks + 1,)``.
        rows: Rows by block, ascending within a block, shape ``(n,)``.
        columns: The matched column of each of ``rows``.
        block_of_row: Block of each row, shape ``(n,)``.
        block_of_column: Block of each column, shape ``(n,)``.
    """

    pointer: Ints
    rows: Ints
    columns: Ints
    block_of_row: Ints
    block_of_column: Ints

    @property
    def count(self) -> int:
        """Number of blocks."""
        return int(self.pointer.shape[0]) - 1

    @property
    def sizes(self) -> Ints:
        """Number of rows of each block, shape ``(n_blocks,)``."""
        return np.diff(self.pointer)


def block_triangular_form(pointer: Ints, columns: Ints, matching: Matching) -> Blocks:
    """Sort a matched square system into blocks.

    Args:
        pointer: Row pointers, shape ``(n + 1,)``.
        columns: Columns of each row.
        matching: A perfect matching.

    Returns:
        The blocks.

    Raises:
        ValueError: If the matching is not perfect; callers test this before.
    """
    if not matching.is_perfect:
        raise ValueError("block triangular form needs a perfect matching")
    count, label = strong_components(pointer, matching.row_of_column[columns])
    rows = stable_order(label)
    block_pointer = np.zeros(count + 1, np.int64)
    np.cumsum(np.bincount(label, minlength=count), out=block_pointer[1:])
    return Blocks(
        block_pointer,
        rows,
        matching.column_of_row[rows],
        label,
        label[matching.row_of_column],
    )
