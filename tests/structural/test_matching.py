"""Maximum matching: Berge's theorem, and families of graphs that are hard for some algorithms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from acausal.structural import graphs
from acausal.structural.dulmage_mendelsohn import dulmage_mendelsohn, overdetermined_part
from acausal.structural.graphs import adjacency
from acausal.structural.matching import Matching, maximum_matching, restrict_matching

Edges = list[tuple[int, int]]


def match(edges: Edges, n_rows: int, n_columns: int, start: Matching | None = None) -> Matching:
    pairs = np.array(sorted(set(edges)), np.int64).reshape(-1, 2)
    pointer, columns = adjacency(pairs[:, 0], pairs[:, 1], n_rows)
    matching = maximum_matching(pointer, columns, n_columns, start)
    check(matching, pointer, columns)
    return matching


def check(matching: Matching, pointer: np.ndarray, columns: np.ndarray) -> None:
    """Assert that it is a matching and, by König's theorem, a maximum one."""
    rows = np.flatnonzero(matching.column_of_row >= 0)
    assert (matching.row_of_column[matching.column_of_row[rows]] == rows).all()
    assert np.count_nonzero(matching.row_of_column >= 0) == rows.shape[0]
    tails = np.repeat(np.arange(pointer.shape[0] - 1), np.diff(pointer))
    pairs = (
        set(zip(tails.tolist(), columns.tolist(), strict=True)) if rows.shape[0] < 5000 else None
    )
    if pairs is not None:
        assert all((int(r), int(matching.column_of_row[r])) in pairs for r in rows)
    over_rows, over_columns = overdetermined_part(pointer, columns, matching)
    # A vertex cover as large as the matching: rows not reached, and columns reached.
    assert bool((~over_rows[tails] | over_columns[columns]).all())
    assert int((~over_rows).sum() + over_columns.sum()) == matching.size


def test_hopcroft_karp_needs_two_augmentations():
    # The greedy start takes (0, 0) and (1, 1); row 2 only knows column 0, row 3 only column 1.
    matching = match([(0, 0), (0, 2), (1, 1), (1, 3), (2, 0), (3, 1)], 4, 4)
    assert matching.column_of_row.tolist() == [2, 3, 0, 1]


@given(
    st.integers(1, 12).flatmap(
        lambda n: st.tuples(
            st.just(n),
            st.integers(1, 12),
            st.lists(st.tuples(st.integers(0, n - 1), st.integers(0, 11)), max_size=40),
        )
    )
)
def test_random_graphs_have_a_cover_of_the_same_size(case):
    n_rows, n_columns, edges = case
    match([(i, j % n_columns) for i, j in edges], n_rows, n_columns)


@pytest.mark.parametrize("n", [400, 40_000])
@pytest.mark.parametrize("shuffled", [False, True])
@pytest.mark.parametrize("family", ["path", "reversed path", "tree", "ring"])
def test_long_structures(n, shuffled, family):
    k = np.arange(n)
    rows, columns = {
        "path": (np.r_[k, k[:-1]], np.r_[k, k[1:]]),
        "reversed path": (np.r_[k, k[1:]], np.r_[k, k[:-1]]),
        "tree": (np.r_[k, (k[1:] - 1) // 2], np.r_[k, k[1:]]),
        "ring": (np.r_[k, k], np.r_[k, (k + 1) % n]),
    }[family]
    if shuffled:
        random = np.random.default_rng(1)
        rows, columns = random.permutation(n)[rows], random.permutation(n)[columns]
    pointer, head = adjacency(rows, columns, n)
    matching = maximum_matching(pointer, head, n)
    check(matching, pointer, head)
    assert matching.is_perfect


def test_dense_part_behind_a_dense_part():
    """One search tree would take the whole layer in every phase."""
    h = 60
    dense = np.zeros((2 * h, 2 * h), bool)
    dense[:, :h] = True
    dense[:h] = True
    rows, columns = np.nonzero(dense[np.random.default_rng(0).permutation(2 * h)])
    pointer, head = adjacency(rows, columns, 2 * h)
    matching = maximum_matching(pointer, head, 2 * h)
    check(matching, pointer, head)
    assert matching.is_perfect


def test_matched_columns_stay_matched():
    start = Matching(np.array([-1, -1, 0]), np.array([2, -1, -1]))
    matching = match([(2, 0), (2, 1), (0, 0), (0, 2), (1, 1)], 3, 3, start)
    assert matching.is_perfect
    smaller = match([(2, 0), (2, 1), (0, 0)], 3, 3, start)
    assert smaller.row_of_column[0] >= 0
    assert smaller.column_of_row[2] >= 0


def test_restriction_keeps_pairs_that_are_edges():
    matching = Matching(np.array([0, 1]), np.array([0, 1]))
    pointer, columns = adjacency(np.array([0, 1]), np.array([0, 0]), 2)
    kept = restrict_matching(matching, pointer, columns)
    assert kept.column_of_row.tolist() == [0, -1]
    assert kept.row_of_column.tolist() == [0, -1]


def test_dulmage_mendelsohn_parts():
    # Rows 0, 1 share column 0; row 2 owns column 1; row 3 sees columns 2, 3.
    edges = [(0, 0), (1, 0), (2, 1), (2, 0), (3, 2), (3, 3), (3, 1)]
    pairs = np.array(edges)
    pointer, columns = adjacency(pairs[:, 0], pairs[:, 1], 4)
    parts = dulmage_mendelsohn(pointer, columns, maximum_matching(pointer, columns, 4))
    assert parts.over_rows.tolist() == [True, True, False, False]
    assert parts.over_columns.tolist() == [True, False, False, False]
    assert parts.well_rows.tolist() == [False, False, True, False]
    assert parts.well_columns.tolist() == [False, True, False, False]
    assert parts.under_rows.tolist() == [False, False, False, True]
    assert parts.under_columns.tolist() == [False, False, True, True]


@given(st.lists(st.tuples(st.integers(0, 14), st.integers(0, 14)), max_size=45), st.data())
def test_both_forms_of_the_primitives_agree(edges, data):
    pairs = np.array(edges, np.int64).reshape(-1, 2)
    pointer, head = adjacency(pairs[:, 0], pairs[:, 1], 15)
    sources = np.array(sorted(data.draw(st.sets(st.integers(0, 14), max_size=4))), np.int64)
    small = graphs.breadth_first_forest(pointer, head, sources)
    count, label = graphs.strong_components(pointer, head)
    limit, graphs.SMALL = graphs.SMALL, -1
    try:
        large = graphs.breadth_first_forest(pointer, head, sources)
        count_large, label_large = graphs.strong_components(pointer, head)
    finally:
        graphs.SMALL = limit
    assert [a.tolist() for a in small] == [a.tolist() for a in large]
    assert count == count_large
    same = (label[:, None] == label[None]) == (label_large[:, None] == label_large[None])
    assert same.all()
    tails = np.repeat(np.arange(15), np.diff(pointer))
    for numbers in (label, label_large):
        assert (numbers[head] <= numbers[tails]).all()
