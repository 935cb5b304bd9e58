"""Connected components of a graph whose edges say ``a = b`` or ``a = -b``.

The signed graph is balanced where no cycle forces ``x = -x`` (F. Harary, "On the notion of
balance of a signed graph", Michigan Math. J. 2, 1953). Components are found by hooking and
pointer jumping (Y. Shiloach and U. Vishkin, "An O(log n) parallel connectivity algorithm", J.
Algorithms 3, 1982): every root hooks onto its least neighbour, then all paths are shortened to
length one; every pointer carries the sign on its way. Each round is a few NumPy operations over
the edges that are left, and a handful of rounds suffices in practice.

An edge ``a = -a`` says that ``a`` is zero, which is how known zeros come in.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Nodes = NDArray[np.int32]
Signs = NDArray[np.int8]


def signed_components(
    n: int, a: Nodes, b: Nodes, sign: Signs, known: tuple[Nodes, Signs] | None = None
) -> tuple[Nodes, Signs]:
    """Return the root of every node and its sign relative to the root.

    Args:
        n: Number of nodes, below ``2**31``.
        a: First end of each edge, shape ``(m,)``.
        b: Second end of each edge, shape ``(m,)``.
        sign: 1 for ``a = b``, -1 for ``a = -b``, shape ``(m,)``.
        known: Result for other edges, to be continued.

    Returns:
        ``(root, sign)``: the least node of the component, and signs with
        ``a * sign[a] == b * sign[b]`` in a balanced component, 0 in an unbalanced one.
    """
    if known is None:
        root, signs = np.arange(n, dtype=np.int32), np.ones(n, dtype=np.int8)
        unbalanced = np.zeros(n, dtype=np.bool_)
    else:
        root, signs = known[0].copy(), known[1].copy()
        unbalanced = signs == 0
        signs[unbalanced] = 1
        unbalanced &= root == np.arange(n, dtype=np.int32)
        sign = sign * signs[a] * signs[b]
        a, b = root[a], root[b]
    while True:
        low, high = np.minimum(a, b), np.maximum(a, b)
        np.minimum.at(root, high, low)
        hooked = np.flatnonzero((root[high] == low) & (low < high))
        signs[high[hooked]] = sign[hooked]
        while True:
            up = root[root]
            far = np.flatnonzero(up != root)
            if far.shape[0] == 0:
                break
            signs[far] *= signs[root[far]]
            root[far] = up[far]
        sign = sign * signs[a] * signs[b]
        a, b = root[a], root[b]
        same = a == b
        unbalanced[a[same & (sign < 0)]] = True
        rest = np.flatnonzero(~same)
        if rest.shape[0] == 0:
            break
        a, b, sign = a[rest], b[rest], sign[rest]
    below = np.flatnonzero(unbalanced)
    if below.shape[0]:
        unbalanced[root[below]] = True
        signs[unbalanced[root]] = 0
    return root, signs


def redundant_edges(
    root: Nodes, node_sign: Signs, a: Nodes, b: Nodes, sign: Signs
) -> NDArray[np.bool_]:
    """Return which edges follow from the others, shape ``(m,)``.

    In a balanced component a spanning forest is independent, in an unbalanced one a spanning
    forest and one edge that closes an unbalanced cycle (the signed-graphic matroid). Edges that
    come first are kept.

    Args:
        root: Root of each node, from :func:`signed_components` of these edges.
        node_sign: Sign of each node.
        a: First end of each edge.
        b: Second end of each edge.
        sign: 1 for ``a = b``, -1 for ``a = -b``.
    """
    n = root.shape[0]
    result = np.zeros(a.shape[0], dtype=np.bool_)
    # What the edges lack to the rank of each component, at its root.
    lack = np.zeros(n, dtype=np.int32)
    np.add.at(lack, root, np.int32(1))
    lack -= (lack > 0) & (node_sign != 0)
    of_edge = root[a]
    np.subtract.at(lack, of_edge, np.int32(1))
    excess = lack < 0
    if not excess.any():
        return result
    suspects = np.flatnonzero(excess[of_edge])
    tree = suspects[_forest(n, a[suspects], b[suspects])]
    rest = np.setdiff1d(suspects, tree)
    _, tree_sign = signed_components(n, a[tree], b[tree], sign[tree])
    odd = rest[tree_sign[a[rest]] * tree_sign[b[rest]] * sign[rest] < 0]
    _, first_odd = np.unique(of_edge[odd], return_index=True)
    result[rest] = True
    result[odd[first_odd]] = False
    return result


def _forest(n: int, a: Nodes, b: Nodes) -> NDArray[np.int64]:
    """Return the edges of the spanning forest that prefers early edges, ascending."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import minimum_spanning_tree

    low, high = np.minimum(a, b), np.maximum(a, b)
    _, first = np.unique(low * np.int64(n) + high, return_index=True)
    first = first[low[first] != high[first]]
    graph = coo_array((first + 1.0, (low[first], high[first])), shape=(n, n)).tocsr()
    return np.sort(minimum_spanning_tree(graph).data.astype(np.int64) - 1)
