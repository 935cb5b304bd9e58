"""Maximum matching of rows and columns.

Statement: given a bipartite graph of rows and columns, find as many edges as possible no two of
which share a row or a column. A matching is maximum when no augmenting path is left (Berge 1957,
doi 10.1073/pnas.43.9.842).

Algorithm: a greedy start, then phases of a breadth-first search from all free rows at once
(Azad, Buluc, Pothen 2017, doi 10.1109/TPDS.2016.2546258). The search trees are disjoint, so each
tree that reaches a free column gives one augmenting path, and all of them are taken together. A
phase is linear; paths may be as long as the model without harm, because nothing recurses and
predecessors are followed by pointer doubling. The last search reaches exactly the rows and columns
of the overdetermined part.

SciPy's ``maximum_bipartite_matching`` is not used: it takes quadratic time on a path whose nodes
are numbered at random (68 s for a million rows), cannot start from a given matching, and its
depth-first phase does not remember dead ends.

When the phases stop paying (dense parts, where one tree takes all), the rest is done by depth-first
searches with lookahead (Pothen and Fan 1990, doi 10.1145/98267.98287).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from acausal.structural.graphs import (
    Ints,
    ancestors,
    breadth_first_forest,
    compress,
    gather,
    roots,
)

#: Phases after which a small gain per phase ends the breadth-first part.
_PHASES = 12


@dataclass(frozen=True)
class Matching:
    """A matching of rows and columns.

    Attributes:
        column_of_row: Matched column of each row or -1, shape ``(n_rows,)``.
        row_of_column: Matched row of each column or -1, shape ``(n_columns,)``.
    """

    column_of_row: Ints
    row_of_column: Ints

    @property
    def size(self) -> int:
        """Number of matched pairs."""
        return int(np.count_nonzero(self.column_of_row >= 0))

    @property
    def is_perfect(self) -> bool:
        """Whether every row and every column is matched."""
        return bool((self.column_of_row >= 0).all() and (self.row_of_column >= 0).all())


def maximum_matching(
    pointer: Ints, columns: Ints, n_columns: int, start: Matching | None = None
) -> Matching:
    """Find a maximum matching.

    Args:
        pointer: Row pointers, shape ``(n_rows + 1,)``.
        columns: Columns of each row in order of preference, shape ``(edges,)``.
        n_columns: Number of columns.
        start: A matching of this graph to start from. Columns it matches stay matched, rows too.

    Returns:
        A maximum matching.
    """
    n_rows = pointer.shape[0] - 1
    if start is None:
        column_of_row = np.full(n_rows, -1, np.int64)
        row_of_column = np.full(n_columns, -1, np.int64)
    else:
        column_of_row = start.column_of_row.copy()
        row_of_column = start.row_of_column.copy()
    _greedy(pointer, columns, column_of_row, row_of_column)
    phase = 0
    while True:
        free = np.flatnonzero(column_of_row < 0)
        gained = _phase(pointer, columns, column_of_row, row_of_column, free)
        phase += 1
        if gained == 0 or gained == free.shape[0]:
            break
        if phase >= _PHASES and gained * 20 < free.shape[0]:
            _depth_first(pointer, columns, column_of_row, row_of_column)
            break
    return Matching(column_of_row, row_of_column)


def _greedy(pointer: Ints, columns: Ints, column_of_row: Ints, row_of_column: Ints) -> None:
    """Let every free row ask for its first, second, ... column; the lowest row wins."""
    rows = np.flatnonzero(column_of_row < 0)
    place = 0
    while rows.shape[0]:
        at = pointer[rows] + place
        rows = rows[at < pointer[rows + 1]]
        wanted = columns[pointer[rows] + place]
        available = row_of_column[wanted] < 0
        asking, wanted = rows[available][::-1], wanted[available][::-1]
        row_of_column[wanted] = asking  # the last assignment, that is the lowest row, stays
        won = asking[row_of_column[wanted] == asking]
        column_of_row[won] = wanted[row_of_column[wanted] == asking]
        rows = rows[column_of_row[rows] < 0]
        place += 1


def alternating_graph(pointer: Ints, columns: Ints, row_of_column: Ints) -> tuple[Ints, Ints]:
    """Return the graph of alternating paths from rows, as ``(pointer, head)``.

    Nodes are the rows, then the columns. A row leads to all its columns, a column to its matched
    row.
    """
    n_rows = pointer.shape[0] - 1
    matched = row_of_column >= 0
    ends = pointer[-1] + np.cumsum(matched)
    head = np.concatenate([columns + n_rows, row_of_column[matched]])
    return np.concatenate([pointer, ends]), head


def _phase(
    pointer: Ints, columns: Ints, column_of_row: Ints, row_of_column: Ints, free: Ints
) -> int:
    """Augment along disjoint shortest paths of one search; return how many."""
    n_rows = pointer.shape[0] - 1
    if free.shape[0] == 0:
        return 0
    graph, head = alternating_graph(pointer, columns, row_of_column)
    order, before = breadth_first_forest(graph, head, free)
    is_end = order >= n_rows
    is_end[is_end] = row_of_column[order[is_end] - n_rows] < 0
    ends = np.flatnonzero(is_end)
    if ends.shape[0] == 0:
        return 0
    root = roots(before)
    # The first free column that a tree reached ends its path.
    _, first = np.unique(root[ends], return_index=True)
    on_path = ancestors(before, ends[first])
    used = np.flatnonzero(on_path & (order >= n_rows))
    new_columns, new_rows = order[used] - n_rows, order[before[used]]
    column_of_row[new_rows] = new_columns
    row_of_column[new_columns] = new_rows
    return int(first.shape[0])


def _depth_first(pointer: Ints, columns: Ints, column_of_row: Ints, row_of_column: Ints) -> None:
    """Match the remaining rows one by one; each phase visits an edge at most twice."""
    start, neighbours = pointer.tolist(), columns.tolist()
    of_row, of_column = column_of_row.tolist(), row_of_column.tolist()
    look = start[:-1]
    free = [row for row, column in enumerate(of_row) if column < 0]
    while True:
        seen = bytearray(len(of_row))
        following = start[:-1]
        failed = []
        for root in free:
            path = [root]
            seen[root] = 1
            while path:
                row = path[-1]
                end = start[row + 1]
                column = -1
                while look[row] < end:  # lookahead: a column once matched stays matched
                    if of_column[neighbours[look[row]]] < 0:
                        column = neighbours[look[row]]
                        break
                    look[row] += 1
                if column >= 0:
                    while path:
                        row = path.pop()
                        of_column[column] = row
                        column, of_row[row] = of_row[row], column
                    break
                while following[row] < end:
                    other = of_column[neighbours[following[row]]]
                    following[row] += 1
                    if not seen[other]:
                        seen[other] = 1
                        path.append(other)
                        break
                else:
                    path.pop()
            else:
                failed.append(root)
        if len(failed) in (0, len(free)):
            break
        free = failed
    column_of_row[:], row_of_column[:] = of_row, of_column


def matching_of_edges(
    rows: Ints, columns: Ints, n_rows: int, n_columns: int, start: Matching | None = None
) -> Matching:
    """Find a maximum matching of edges given as arrays, sorted by row."""
    return maximum_matching(compress(rows, n_rows), columns, n_columns, start)


def restrict_matching(matching: Matching, pointer: Ints, columns: Ints) -> Matching:
    """Return the pairs of ``matching`` that are edges of another graph of the same size."""
    rows = np.flatnonzero(matching.column_of_row >= 0)
    edges = gather(pointer, rows)
    tails = np.repeat(rows, pointer[rows + 1] - pointer[rows])
    kept = tails[columns[edges] == matching.column_of_row[tails]]
    column_of_row = np.full_like(matching.column_of_row, -1)
    row_of_column = np.full_like(matching.row_of_column, -1)
    column_of_row[kept] = matching.column_of_row[kept]
    row_of_column[column_of_row[kept]] = kept
    return Matching(column_of_row, row_of_column)
