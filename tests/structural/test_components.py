"""Connected components against networkx."""

from __future__ import annotations

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acausal.connections.components import connected_components


def reference(edges, n):
    graph = nx.Graph(edges)
    graph.add_nodes_from(range(n))
    label = np.empty(n, np.int64)
    for k, nodes in enumerate(sorted(nx.connected_components(graph), key=min)):
        label[list(nodes)] = k
    return label


@settings(max_examples=200, deadline=None)
@given(st.integers(1, 40), st.integers(0, 60), st.integers(0, 10_000))
def test_random_graphs(n, m, seed):
    edges = np.random.default_rng(seed).integers(0, n, (m, 2))
    count, label = connected_components(edges[:, 0], edges[:, 1], n)
    expected = reference(edges.tolist(), n)
    assert label.tolist() == expected.tolist()
    assert count == expected.max() + 1


@pytest.mark.parametrize("shape", ["path", "star", "caterpillar", "reversed"])
def test_large_trees_are_one_component(shape):
    n = 50_000
    order = np.random.default_rng(1).permutation(n)
    tails, heads = {
        "path": (order[:-1], order[1:]),
        "star": (np.full(n - 1, order[0]), order[1:]),
        "caterpillar": (order[(np.arange(1, n) - 1) // 2], order[1:]),
        "reversed": (np.arange(n - 1, 0, -1), np.arange(n - 2, -1, -1)),
    }[shape]
    count, label = connected_components(tails, heads, n)
    assert count == 1
    assert not label.any()


def test_nothing():
    none = np.zeros(0, np.int64)
    assert connected_components(none, none, 0)[0] == 0
    assert connected_components(none, none, 3)[1].tolist() == [0, 1, 2]
