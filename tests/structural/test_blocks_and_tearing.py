"""Block triangular form and tearing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from acausal.structural.blocks import Blocks, block_triangular_form
from acausal.structural.graphs import adjacency
from acausal.structural.matching import Matching, maximum_matching
from acausal.structural.tearing import Tearing, tear, tear_blocks


def blocks_of(edges: list[tuple[int, int]], n: int) -> tuple[Blocks, np.ndarray, np.ndarray]:
    pairs = np.array(edges, np.int64)
    pointer, columns = adjacency(pairs[:, 0], pairs[:, 1], n)
    matching = maximum_matching(pointer, columns, n)
    return block_triangular_form(pointer, columns, matching), pointer, columns


def check_triangular(blocks: Blocks, pointer: np.ndarray, columns: np.ndarray) -> None:
    rows = np.repeat(np.arange(pointer.shape[0] - 1), np.diff(pointer))
    assert (blocks.block_of_column[columns] <= blocks.block_of_row[rows]).all()
    assert sorted(blocks.rows.tolist()) == list(range(pointer.shape[0] - 1))
    assert (np.diff(blocks.block_of_row[blocks.rows]) >= 0).all()


def test_tarjans_example():
    """The graph of Tarjan 1972, figure 3: components {1, 2, 3...} as rows that need each other."""
    arcs = [(0, 1), (1, 2), (1, 7), (2, 3), (2, 6), (3, 4), (4, 2), (4, 5), (6, 3), (6, 5),
            (7, 0), (7, 6)]  # fmt: skip
    blocks, pointer, columns = blocks_of([*arcs, *[(k, k) for k in range(8)]], 8)
    # The matching need not be the diagonal, the blocks are the same.
    groups = {tuple(np.flatnonzero(blocks.block_of_row == b).tolist()) for b in range(blocks.count)}
    assert groups == {(5,), (2, 3, 4, 6), (0, 1, 7)}
    check_triangular(blocks, pointer, columns)
    assert blocks.sizes.tolist() == [1, 4, 3]


@given(
    st.lists(st.tuples(st.integers(0, 8), st.integers(0, 8)), max_size=30),
    st.permutations(range(9)),
)
def test_blocks_do_not_depend_on_the_matching(edges, permutation):
    edges = edges + [(k, permutation[k]) for k in range(9)]
    blocks, pointer, columns = blocks_of(edges, 9)
    check_triangular(blocks, pointer, columns)
    column_of_row = np.array(permutation)
    other = block_triangular_form(
        pointer, columns, Matching(column_of_row, np.argsort(column_of_row))
    )
    check_triangular(other, pointer, columns)
    assert sorted(blocks.sizes.tolist()) == sorted(other.sizes.tolist())
    first = blocks.block_of_row[:, None] == blocks.block_of_row
    second = other.block_of_row[:, None] == other.block_of_row
    assert (first == second).all()


def test_imperfect_matchings_are_refused():
    with pytest.raises(ValueError, match="perfect"):
        block_triangular_form(
            np.array([0, 0]), np.zeros(0, np.int64), Matching(-np.ones(1, int), -np.ones(1, int))
        )


@pytest.mark.parametrize("n", [300, 30_000])
def test_cascade_and_ring(n):
    k = np.arange(n)
    cascade = adjacency(np.r_[k, k[1:]], np.r_[k, k[:-1]], n)
    blocks = block_triangular_form(*cascade, Matching(k, k))
    assert blocks.rows.tolist() == k.tolist()
    ring = adjacency(np.r_[k, k], np.r_[k, (k + 1) % n], n)
    assert block_triangular_form(*ring, Matching(k, k)).count == 1


def check_tearing(tearing: Tearing, n: int, entries: dict[tuple[int, int], bool]) -> None:
    known = set(tearing.tearing.tolist())
    for row, column in zip(
        tearing.solved_rows.tolist(), tearing.solved_columns.tolist(), strict=True
    ):
        assert entries[row, column]
        assert {j for i, j in entries if i == row} - known == {column}
        known.add(column)
    assert known == set(range(n))
    rows = [*tearing.solved_rows.tolist(), *tearing.residual_rows.tolist()]
    assert sorted(rows) == list(range(n))
    assert tearing.tearing.shape == tearing.residual_rows.shape


def run(entries: dict[tuple[int, int], bool], n: int) -> Tearing:
    rows, columns = np.array(list(entries), np.int64).T
    tearing = tear(n, rows, columns, np.array(list(entries.values())))
    check_tearing(tearing, n, entries)
    return tearing


def test_elmqvist_and_otter_resistor_network():
    """A voltage divider with a loaded middle: one tearing variable is enough.

    u1 = R1 i1, u2 = R2 i2, u3 = R3 i3, i1 = i2 + i3, u1 + u2 = U, u2 = u3.
    """
    u1, u2, u3, i1, i2, i3 = range(6)
    rows = [(u1, i1), (u2, i2), (u3, i3), (i1, i2, i3), (u1, u2), (u2, u3)]
    tearing = run({(k, v): True for k, row in enumerate(rows) for v in row}, 6)
    assert tearing.tearing.shape[0] == 1


def test_what_cannot_be_solved_for_is_torn():
    entries = {(0, 0): False, (0, 1): False, (1, 0): False, (1, 1): False}
    assert run(entries, 2).tearing.tolist() == [0, 1]
    entries[1, 1] = True
    assert run(entries, 2).tearing.tolist() == [0]


@given(st.integers(1, 9), st.integers(0, 100_000))
def test_random_blocks(n, seed):
    random = np.random.default_rng(seed)
    entries = {(k, k): bool(random.random() < 0.7) for k in range(n)}
    for _ in range(3 * n):
        entries[int(random.integers(n)), int(random.integers(n))] = bool(random.random() < 0.7)
    run(entries, n)


def test_equal_blocks_are_torn_once():
    """A thousand pairs of rows that need each other, in a cascade."""
    n = 2000
    first = 2 * np.arange(n // 2)
    rows = np.r_[first, first, first + 1, first + 1, first[1:]]
    columns = np.r_[first, first + 1, first, first + 1, first[:-1]]
    pointer, columns = adjacency(rows, columns, n)
    blocks = block_triangular_form(pointer, columns, maximum_matching(pointer, columns, n))
    torn = tear_blocks(blocks, pointer, columns, np.ones(columns.shape[0], np.bool_))
    assert torn.blocks.shape[0] == n // 2
    assert len(torn.patterns) == 1
    assert torn.n_tearing == n // 2
