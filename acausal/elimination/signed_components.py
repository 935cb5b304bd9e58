"""Connected components of a graph whose edges say ``a = b`` or ``a = -b``.

The signed graph is balanced where no cycle forces ``x = -x``. Balance is tested on the double
cover (F. Harary, "On the notion of balance of a signed graph", Michigan Math. J. 2, 1953; the
cover of T. Zaslavsky, "Signed graphs", Discrete Appl. Math. 4, 1982): every node ``x`` becomes
``(x, +)`` and ``(x, -)``; an edge of sign + joins like sides, one of sign - unlike sides. A
component of the graph is unbalanced if and only if the two sides of its nodes are connected.
Time and memory are linear in nodes and edges.

An edge ``a = -a`` says that ``a`` is zero, which is how known zeros come in.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from acausal.flattening.model import Ids

Signs = NDArray[np.int8]


def signed_components(n: int, a: Ids, b: Ids, sign: Signs) -> tuple[Ids, Signs, int]:
    """Return the component of every node and its sign in it.

    Args:
        n: Number of nodes.
        a: First end of each edge, shape ``(m,)``.
        b: Second end of each edge, shape ``(m,)``.
        sign: 1 for ``a = b``, -1 for ``a = -b``, shape ``(m,)``.

    Returns:
        ``(component, sign, k)``: numbers ``0 .. k-1`` in the order of their first nodes, and
        signs with ``a * sign[a] == b * sign[b]`` in a component, 0 in an unbalanced one. The
        first node of a balanced component has sign 1.
    """
    positive = sign > 0
    component, k = _components(n, a[positive], b[positive])
    negative = ~positive
    if not negative.any():
        return component, np.ones(n, dtype=np.int8), k
    # Only what the negative edges touch needs the double cover.
    ends = np.concatenate([component[a[negative]], component[b[negative]]])
    touched = np.zeros(k, dtype=np.bool_)
    touched[ends] = True
    nodes = np.flatnonzero(touched)
    local = np.cumsum(touched) - 1
    low, high = np.split(local[ends], 2)
    count = nodes.shape[0]
    cover, _ = _components(
        2 * count, np.concatenate([low, low + count]), np.concatenate([high + count, high])
    )
    plus, minus = cover[:count], cover[count:]
    # Covers are numbered by first node, so the first node of a component has plus < minus.
    merged = np.arange(k)
    merged_sign = np.ones(k, dtype=np.int8)
    first = np.full(2 * count, k, dtype=np.int64)
    np.minimum.at(first, np.minimum(plus, minus), nodes)
    merged[nodes] = first[np.minimum(plus, minus)]
    merged_sign[nodes] = np.sign(minus - plus)
    total_sign = merged_sign[component]
    kept = merged == np.arange(k)
    renumber = np.cumsum(kept) - 1
    return renumber[merged][component], total_sign, int(kept.sum())


def _components(n: int, a: Ids, b: Ids) -> tuple[Ids, int]:
    """Return components of an undirected graph, numbered in the order of their first nodes."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if a.shape[0] == 0:
        return np.arange(n), n
    index = np.int32 if n < 2**31 else np.int64
    graph = coo_array(
        (np.ones(a.shape[0], dtype=np.int8), (a.astype(index), b.astype(index))), shape=(n, n)
    )
    count, labels = connected_components(graph.tocsr(), directed=False)
    first = np.full(count, n, dtype=np.int64)
    np.minimum.at(first, labels, np.arange(n))
    order = np.empty(count, dtype=np.int64)
    order[np.argsort(first)] = np.arange(count)
    return order[labels], int(count)


def redundant_edges(
    component: Ids, node_sign: Signs, k: int, a: Ids, b: Ids, sign: Signs
) -> NDArray[np.bool_]:
    """Return which edges follow from the others, shape ``(m,)``.

    In a balanced component a spanning forest is independent, in an unbalanced one a spanning
    forest and one edge that closes an unbalanced cycle (the signed-graphic matroid). Edges that
    come first are kept.

    Args:
        component: Component of each node, from :func:`signed_components`.
        node_sign: Sign of each node in it.
        k: Number of components.
        a, b, sign: The edges.
    """
    n = component.shape[0]
    result = np.zeros(a.shape[0], dtype=np.bool_)
    rank = np.bincount(component, minlength=k)
    balanced = np.ones(k, dtype=np.bool_)
    balanced[component[node_sign == 0]] = False
    rank -= balanced
    of_edge = component[a]
    excess = np.bincount(of_edge, minlength=k) > rank
    if not excess.any():
        return result
    suspects = np.flatnonzero(excess[of_edge])
    tree = suspects[_forest(n, a[suspects], b[suspects])]
    rest = np.setdiff1d(suspects, tree)
    _, tree_sign, _ = signed_components(n, a[tree], b[tree], sign[tree])
    odd = rest[tree_sign[a[rest]] * tree_sign[b[rest]] * sign[rest] < 0]
    _, first_odd = np.unique(of_edge[odd], return_index=True)
    result[rest] = True
    result[odd[first_odd]] = False
    return result


def _forest(n: int, a: Ids, b: Ids) -> Ids:
    """Return the edges of the spanning forest that prefers early edges, ascending."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import minimum_spanning_tree

    low, high = np.minimum(a, b), np.maximum(a, b)
    _, first = np.unique(low * n + high, return_index=True)
    first = first[low[first] != high[first]]
    graph = coo_array((first + 1.0, (low[first], high[first])), shape=(n, n)).tocsr()
    return np.sort(minimum_spanning_tree(graph).data.astype(np.int64) - 1)
