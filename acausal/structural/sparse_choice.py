"""Choose columns of one large sparse wide matrix.

Statement: that of :mod:`acausal.structural.column_choice`, for a matrix of so many rows that it
cannot be stored densely.

Algorithm: Gaussian elimination in rounds. In every round each row proposes an entry that is not
small in its row, with the least Markowitz cost (Markowitz 1957); of proposals that stand in one
another's rows or columns the one with the smaller key stays (Luby 1986, doi 10.1137/0215074, with
fixed pseudo-random keys). The pivots kept are a diagonal matrix, so all of them are eliminated by
one sparse product. A chain loses a constant share of its rows per round. What is left when the
rest has filled up is done densely.

Complexity: as many rounds as the logarithm of the number of rows, for chains and trees.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from acausal.structural.column_choice import IMPOSSIBLE, PIVOT_TOLERANCE, choose_columns
from acausal.structural.graphs import Ints, Mask

Floats = NDArray[np.float64]

#: A pivot is at least this part of the largest entry of its row.
RELATIVE_SIZE: Final = 0.3
#: Entries of the rest, counted as if dense, that are given to dense elimination.
DENSE: Final = 40_000


def choose_columns_sparse(
    rows: Ints, columns: Ints, values: Floats, shape: tuple[int, int], levels: Ints, ranks: Ints
) -> Ints:
    """Choose the depths of columns.

    Args:
        rows: Row of each entry.
        columns: Column of each entry.
        values: Entries, row-scaled.
        shape: Numbers of rows and columns.
        levels: Level of each row, shape ``(m,)``.
        ranks: Rank of each column at level ``k + 1``, shape ``(L, n)``.

    Returns:
        Depths, shape ``(n,)``.
    """
    m, n = shape
    rest = _Rest(rows, columns, values, shape)
    depth = np.zeros(n, np.int64)
    free_row = np.ones(m, np.bool_)
    for level in range(int(levels.max(initial=0)), 0, -1):
        active = levels >= level
        present = np.unique(ranks[level - 1])
        present = present[present < IMPOSSIBLE]
        for rank in present.tolist():
            tolerance = 0.0 if rank == present[-1] else PIVOT_TOLERANCE[rank]
            allowed = (ranks[level - 1] <= rank) & (depth == 0)
            while True:
                if rest.is_small(free_row, depth == 0):
                    return rest.finish(free_row, depth, levels, ranks)
                pivots = rest.pivots(free_row & active, allowed & (depth == 0), tolerance)
                if not pivots.shape[0]:
                    break
                pivot_rows, pivot_columns = rest.eliminate(pivots)
                free_row[pivot_rows] = False
                depth[pivot_columns] = level
    return rest.finish(free_row, depth, levels, ranks)


class _Rest:
    """The rows and columns not eliminated yet, as sorted coordinates."""

    def __init__(self, rows: Ints, columns: Ints, values: Floats, shape: tuple[int, int]) -> None:
        self.rows, self.columns, self.values, self.shape = rows, columns, values, shape

    def is_small(self, free_row: Mask, free_column: Mask) -> bool:
        """Whether what is left is better done densely."""
        m = int(np.count_nonzero(free_row))
        if m == 0:
            return True
        n = np.unique(self.columns).shape[0] if m < DENSE else self.shape[1]
        size = m * n
        return size <= DENSE or (size <= 400 * DENSE and 8 * self.rows.shape[0] > size)

    def pivots(self, active: Mask, allowed: Mask, tolerance: float) -> Ints:
        """Return entries that can be eliminated together."""
        size = np.abs(self.values)
        usable = active[self.rows] & allowed[self.columns] & (size > tolerance)
        entries = np.flatnonzero(usable)
        if not entries.shape[0]:
            return entries
        m, n = self.shape
        in_row = np.bincount(self.rows, minlength=m)
        in_column = np.bincount(self.columns, minlength=n)
        largest = np.zeros(m)
        np.maximum.at(largest, self.rows[entries], size[entries])
        entries = entries[size[entries] >= RELATIVE_SIZE * largest[self.rows[entries]]]
        rows, columns = self.rows[entries], self.columns[entries]
        # Each row proposes its emptiest column, of equal ones the last; so does each column.
        entries = entries[np.lexsort((-columns, in_column[columns], rows))]
        _, first = np.unique(self.rows[entries], return_index=True)
        entries = entries[first]
        rows, columns = self.rows[entries], self.columns[entries]
        cost = (in_row[rows] - 1) * (in_column[columns] - 1)
        mixed = (rows * 2654435761 + 97) % 4294967291 * 48271 % 2147483647
        order = np.lexsort((mixed, cost))
        entries, cost = entries[order], cost[order]
        entries = entries[cost <= max(4, 2 * int(cost[0]))]
        # Keys are positions in this order; the smallest key of a conflict stays.
        none = entries.shape[0]
        key_of_row = np.full(m, none)
        key_of_row[self.rows[entries]] = np.arange(none)
        key_of_column = np.full(n, none)
        key_of_column[self.columns[entries][::-1]] = np.arange(none)[::-1]
        first_key, second_key = key_of_row[self.rows], key_of_column[self.columns]
        conflict = (first_key < none) & (second_key < none) & (first_key != second_key)
        lost = np.maximum(first_key[conflict], second_key[conflict])
        keeps = np.ones(none, np.bool_)
        keeps[lost] = False
        return entries[keeps]

    def eliminate(self, pivots: Ints) -> tuple[Ints, Ints]:
        """Take out rows and columns of a diagonal set of pivots; return them."""
        from scipy.sparse import coo_array

        m, n = self.shape
        pivot_rows, pivot_columns = self.rows[pivots], self.columns[pivots]
        number_of_row, number_of_column = np.full(m, -1), np.full(n, -1)
        number_of_row[pivot_rows] = number_of_column[pivot_columns] = np.arange(pivots.shape[0])
        by_row, by_column = number_of_row[self.rows], number_of_column[self.columns]
        upper = (by_row >= 0) & (by_column < 0)
        lower = (by_row < 0) & (by_column >= 0)
        outside = (by_row < 0) & (by_column < 0)
        factors = self.values[lower] / self.values[pivots][by_column[lower]]
        size = pivots.shape[0]
        left: Any = coo_array((factors, (self.rows[lower], by_column[lower])), shape=(m, size))
        right: Any = coo_array(
            (self.values[upper], (by_row[upper], self.columns[upper])), shape=(size, n)
        )
        kept: Any = coo_array(
            (self.values[outside], (self.rows[outside], self.columns[outside])), shape=(m, n)
        )
        result = (kept.tocsr() - left.tocsr() @ right.tocsr()).tocsr()
        result.sort_indices()
        result = result.tocoo()
        # Entries that cancelled are noise, far below the perturbation.
        real = np.abs(result.data) > 1e-15
        self.rows = result.row[real].astype(np.int64)
        self.columns = result.col[real].astype(np.int64)
        self.values = result.data[real]
        return pivot_rows, pivot_columns

    def finish(self, free_row: Mask, depth: Ints, levels: Ints, ranks: Ints) -> Ints:
        """Do the rest densely."""
        rows = np.flatnonzero(free_row)
        if not rows.shape[0]:
            return depth
        rows = rows[np.argsort(-levels[rows], kind="stable")]
        columns = np.unique(self.columns)
        if columns.shape[0] < rows.shape[0]:
            columns = np.flatnonzero(depth == 0)
        dense = np.zeros((1, rows.shape[0], columns.shape[0]))
        local_row, local_column = np.full(self.shape[0], -1), np.full(self.shape[1], -1)
        local_row[rows] = np.arange(rows.shape[0])
        local_column[columns] = np.arange(columns.shape[0])
        dense[0, local_row[self.rows], local_column[self.columns]] = self.values
        depth = depth.copy()
        depth[columns] = choose_columns(dense, levels[rows], ranks[None][:, :, columns])[0]
        return depth
