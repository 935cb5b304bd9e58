"""The over-, well- and underdetermined parts of a system.

Statement (Dulmage and Mendelsohn 1958, doi 10.4153/CJM-1958-052-0): the rows and columns of a
bipartite graph fall into three parts that do not depend on the maximum matching used to find them.
The *overdetermined* part is what alternating paths from unmatched rows reach: more rows than
columns. The *underdetermined* part is what alternating paths from unmatched columns reach: more
columns than rows. The rest is *well-determined*: square with a perfect matching. In block form

    over: rows only in their own columns; well: in well and over; under: in all.

Complexity: linear after the matching.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from acausal.structural.graphs import Ints, Mask, adjacency, reachable
from acausal.structural.matching import Matching, alternating_graph


@dataclass(frozen=True)
class Decomposition:
    """The coarse decomposition; masks over rows ``(n_rows,)`` and columns ``(n_columns,)``."""

    over_rows: Mask
    over_columns: Mask
    under_rows: Mask
    under_columns: Mask

    @property
    def well_rows(self) -> Mask:
        """Rows of the well-determined part."""
        return ~(self.over_rows | self.under_rows)

    @property
    def well_columns(self) -> Mask:
        """Columns of the well-determined part."""
        return ~(self.over_columns | self.under_columns)


def overdetermined_part(pointer: Ints, columns: Ints, matching: Matching) -> tuple[Mask, Mask]:
    """Return masks of the rows and columns that alternating paths from free rows reach.

    Args:
        pointer: Row pointers, shape ``(n_rows + 1,)``.
        columns: Columns of each row.
        matching: A maximum matching.
    """
    n_rows = pointer.shape[0] - 1
    free = np.flatnonzero(matching.column_of_row < 0)
    graph, head = alternating_graph(pointer, columns, matching.row_of_column)
    seen = reachable(graph, head, free)
    return seen[:n_rows], seen[n_rows:]


def transpose(pointer: Ints, columns: Ints, n_columns: int) -> tuple[Ints, Ints]:
    """Return ``(pointer, rows)`` of each column, rows ascending."""
    rows = np.repeat(np.arange(pointer.shape[0] - 1), np.diff(pointer))
    return adjacency(columns, rows, n_columns)


def dulmage_mendelsohn(pointer: Ints, columns: Ints, matching: Matching) -> Decomposition:
    """Decompose a bipartite graph.

    Args:
        pointer: Row pointers, shape ``(n_rows + 1,)``.
        columns: Columns of each row.
        matching: A maximum matching of it.

    Returns:
        The three parts.
    """
    over_rows, over_columns = overdetermined_part(pointer, columns, matching)
    turned = Matching(matching.row_of_column, matching.column_of_row)
    column_pointer, rows = transpose(pointer, columns, matching.row_of_column.shape[0])
    under_columns, under_rows = overdetermined_part(column_pointer, rows, turned)
    return Decomposition(over_rows, over_columns, under_rows, under_columns)
