"""Tearing: solve a block by guessing few of its variables.

Statement (Elmqvist and Otter 1994; Cellier and Kofman 2006, chapter 7): choose *tearing variables*
of a block such that, once they are known, the other variables follow one after the other, each
from one row in which it can be solved for explicitly (linearly, with a coefficient that does not
vanish). The rows that are left over are the residuals; only they and the tearing variables are
seen by the Newton iteration. The smallest number is hard to find (NP-complete), so the choice is
greedy: solve every row with one unknown left; when there is none, the unknown that stands in most
of the remaining rows becomes a tearing variable, of equals the one that leaves most rows with a
single unknown, then the one declared first.

Complexity: ``O(e log e)`` for ``e`` entries of a block, in Python; blocks of equal pattern are
torn once.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np

from acausal.structural.blocks import Blocks
from acausal.structural.graphs import Ints, Mask, gather


@dataclass(frozen=True)
class Tearing:
    """How to solve one block. Numbers are places within the block.

    Attributes:
        tearing: Tearing variables, in the order of their choice.
        solved_rows: Rows to be solved explicitly, in this order.
        solved_columns: The variable that each of them gives.
        residual_rows: Rows left, as many as there are tearing variables, ascending.
    """

    tearing: Ints
    solved_rows: Ints
    solved_columns: Ints
    residual_rows: Ints


def tear(n: int, rows: Ints, columns: Ints, solvable: Mask) -> Tearing:
    """Tear one square block.

    Args:
        n: Number of rows and of variables.
        rows: Row of each entry, without repetition of pairs.
        columns: Variable of each entry.
        solvable: Whether the row can be solved for the variable.

    Returns:
        The tearing; in the worst case all variables are torn.
    """
    by_row: list[list[int]] = [[] for _ in range(n)]
    by_column: list[list[int]] = [[] for _ in range(n)]
    explicit = set()
    for row, column, can in zip(rows.tolist(), columns.tolist(), solvable.tolist(), strict=True):
        by_row[row].append(column)
        by_column[column].append(row)
        if can:
            explicit.add((row, column))
    unknowns = [len(members) for members in by_row]
    weight = [len(members) for members in by_column]
    known, used = bytearray(n), bytearray(n)
    ready = [row for row in range(n) if unknowns[row] == 1]
    heapq.heapify(ready)
    tearing: list[int] = []
    solved: list[tuple[int, int]] = []
    # Entries go stale when a weight falls; stale ones are put back when met.
    heap = [(-weight[column], column) for column in range(n)]
    heapq.heapify(heap)
    n_known = 0
    while n_known < n:
        chosen = -1
        while ready:
            row = heapq.heappop(ready)
            if used[row] or unknowns[row] != 1:
                continue
            column = next(c for c in by_row[row] if not known[c])
            if (row, column) in explicit:
                chosen = column
                used[row] = 1
                solved.append((row, column))
                for c in by_row[row]:
                    weight[c] -= 1
                break
        if chosen < 0:
            chosen = _next_torn(heap, weight, known, by_column, used, unknowns)
            tearing.append(chosen)
        known[chosen] = 1
        n_known += 1
        for row in by_column[chosen]:
            unknowns[row] -= 1
            if unknowns[row] == 1 and not used[row]:
                heapq.heappush(ready, row)
            if unknowns[row] == 0 and not used[row]:
                for c in by_row[row]:
                    weight[c] -= 1
    return Tearing(
        np.array(tearing, np.int64),
        np.array([row for row, _ in solved], np.int64),
        np.array([column for _, column in solved], np.int64),
        np.array([row for row in range(n) if not used[row]], np.int64),
    )


def _next_torn(
    heap: list[tuple[int, int]],
    weight: list[int],
    known: bytearray,
    by_column: list[list[int]],
    used: bytearray,
    unknowns: list[int],
) -> int:
    """Return the unknown in most open rows, and of those the one that makes most rows ready."""
    best, most, candidates = -1, -1, 0
    kept: list[tuple[int, int]] = []
    while heap and candidates < 16:
        value, column = heapq.heappop(heap)
        if known[column]:
            continue
        if -value != weight[column]:
            heapq.heappush(heap, (-weight[column], column))
            continue
        if kept and value != kept[0][0]:
            kept.append((value, column))
            break
        kept.append((value, column))
        candidates += 1
        gain = sum(not used[row] and unknowns[row] == 2 for row in by_column[column])
        if gain > most:
            best, most = column, gain
    for item in kept:
        if item[1] != best:
            heapq.heappush(heap, item)
    return best


@dataclass(frozen=True)
class TornBlocks:
    """Tearing of all blocks with more than one row.

    Attributes:
        patterns: The different tearings.
        blocks: Numbers of the blocks, ascending.
        pattern: Pattern of each of them.
    """

    patterns: tuple[Tearing, ...]
    blocks: Ints
    pattern: Ints

    @property
    def n_tearing(self) -> int:
        """Number of tearing variables of all blocks together."""
        sizes = np.array([p.tearing.shape[0] for p in self.patterns], np.int64)
        return int(sizes[self.pattern].sum()) if self.patterns else 0


def tear_blocks(blocks: Blocks, pointer: Ints, columns: Ints, solvable: Mask) -> TornBlocks:
    """Tear all blocks with more than one row; those of equal pattern share the work.

    Args:
        blocks: The block triangular form.
        pointer: Row pointers of the system, shape ``(n + 1,)``.
        columns: Columns of each row, ascending within a row.
        solvable: Whether a row can be solved for that column, as long as ``columns``.

    Returns:
        The tearing. Places within a block are those in ``blocks.rows`` and, for columns, in
        ascending order of the columns.
    """
    sizes = blocks.sizes
    chosen = np.flatnonzero(sizes > 1)
    pattern = np.zeros(chosen.shape[0], np.int64)
    patterns: list[Tearing] = []
    found: dict[tuple[int, bytes, bytes, bytes], int] = {}
    n = blocks.rows.shape[0]
    place = np.empty(n, np.int64)
    place[blocks.rows] = np.arange(n) - np.repeat(blocks.pointer[:-1], sizes)
    for size in np.unique(sizes[chosen]).tolist():
        which = np.flatnonzero(sizes[chosen] == size)
        rows = blocks.rows[blocks.pointer[chosen[which]][:, None] + np.arange(size)]
        own = np.sort(blocks.columns[blocks.pointer[chosen[which]][:, None] + np.arange(size)])
        edges = gather(pointer, rows.ravel())
        count = np.diff(pointer)[rows.ravel()]
        tails = np.repeat(rows.ravel(), count)
        owner = np.repeat(np.repeat(np.arange(which.shape[0]), size), count)
        inside = blocks.block_of_column[columns[edges]] == chosen[which][owner]
        edges, tails, owner = edges[inside], tails[inside], owner[inside]
        column_place = np.empty(n, np.int64)
        column_place[own.ravel()] = np.tile(np.arange(size), which.shape[0])
        local = np.stack([place[tails], column_place[columns[edges]], solvable[edges]])
        ends = np.searchsorted(owner, np.arange(which.shape[0] + 1)).tolist()
        for number, block in enumerate(which.tolist()):
            part = local[:, ends[number] : ends[number + 1]]
            key = (size, part[0].tobytes(), part[1].tobytes(), part[2].tobytes())
            if key not in found:
                found[key] = len(patterns)
                patterns.append(tear(size, part[0], part[1], part[2].astype(np.bool_)))
            pattern[block] = found[key]
    return TornBlocks(tuple(patterns), chosen, pattern)
