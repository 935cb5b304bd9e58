"""Graph primitives on compressed adjacency: breadth-first forest, strong components.

A directed graph over nodes ``0 .. n-1`` is a pair ``(pointer, head)``: the successors of node
``v`` are ``head[pointer[v]:pointer[v+1]]``, in that order.

Each primitive has two forms: the one of ``scipy.sparse.csgraph`` (compiled, linear time) and a
few lines of Python for small graphs. The second is there because importing SciPy's sparse package
takes longer than all of a small model's compilation.

Sources: breadth-first search, Moore 1959; strong components, Tarjan 1972 (doi 10.1137/0201010),
for which SciPy uses Pearce's variant (2005). All are ``O(nodes + edges)``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

#: Nodes plus edges up to which the Python forms are used.
SMALL = 20_000


def compress(tails: NDArray[Any], n_nodes: int) -> Ints:
    """Return the pointers of a compressed adjacency from the sorted tails of its edges.

    Args:
        tails: Tail of every edge, ascending, shape ``(edges,)``.
        n_nodes: Number of nodes.

    Returns:
        Pointers, shape ``(n_nodes + 1,)``.
    """
    pointer = np.zeros(n_nodes + 1, np.int64)
    np.cumsum(np.bincount(tails, minlength=n_nodes), out=pointer[1:])
    return pointer


def adjacency(tails: NDArray[Any], heads: NDArray[Any], n_nodes: int) -> tuple[Ints, Ints]:
    """Return ``(pointer, head)`` of edges in any order; successors ascend, repetitions go."""
    tails, heads = np.asarray(tails, np.int64), np.asarray(heads, np.int64)
    bits = int(heads.max(initial=0)).bit_length()
    key = np.sort((tails << bits) | heads)  # several times faster than sorting by two keys
    if key.shape[0]:
        key = key[np.concatenate([[True], key[1:] != key[:-1]])]
    return compress(key >> bits, n_nodes), key & ((1 << bits) - 1)


def stable_order(keys: Ints) -> Ints:
    """Return what ``argsort(kind="stable")`` does for integers >= 0, faster."""
    bits = keys.shape[0].bit_length()
    order: Ints = np.sort((keys << bits) | np.arange(keys.shape[0])) & ((1 << bits) - 1)
    return order


def gather(pointer: Ints, nodes: Ints) -> Ints:
    """Return the edge numbers ``pointer[v] .. pointer[v+1]-1`` of all ``nodes``, concatenated."""
    first = pointer[nodes]
    count = pointer[nodes + 1] - first
    total = int(count.sum())
    if total == 0:
        return np.zeros(0, np.int64)
    ends = np.cumsum(count)
    return np.repeat(first - (ends - count), count) + np.arange(total, dtype=np.int64)


def breadth_first_forest(pointer: Ints, head: Ints, sources: Ints) -> tuple[Ints, Ints]:
    """Search breadth first from all sources at once.

    Args:
        pointer: Pointers, shape ``(n + 1,)``.
        head: Successors, shape ``(edges,)``.
        sources: Nodes to start from, without repetition.

    Returns:
        The nodes reached in the order of the search (sources first), and for each of them the
        position in that order of its predecessor, -1 for sources. A predecessor comes before its
        successors, and the trees are disjoint.
    """
    n = pointer.shape[0] - 1
    if sources.shape[0] == 0:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    if n + head.shape[0] <= SMALL:
        return _forest_in_python(pointer, head, sources)
    from scipy.sparse.csgraph import breadth_first_order

    # One more node, joined to all sources, makes the forest a tree.
    wider = np.concatenate([pointer, [pointer[-1] + sources.shape[0]]])
    matrix = _matrix(wider, np.concatenate([head, sources]))
    nodes, before = breadth_first_order(matrix, n, directed=True, return_predecessors=True)
    order = np.asarray(nodes[1:], np.int64)
    position = np.full(n + 1, -1, np.int64)
    position[order] = np.arange(order.shape[0])
    return order, position[before[order]]


def _forest_in_python(pointer: Ints, head: Ints, sources: Ints) -> tuple[Ints, Ints]:
    start, successors = pointer.tolist(), head.tolist()
    order: list[int] = sources.tolist()
    before = [-1] * len(order)
    seen = bytearray(len(start) - 1)
    for node in order:
        seen[node] = 1
    position = 0
    while position < len(order):
        node = order[position]
        for successor in successors[start[node] : start[node + 1]]:
            if not seen[successor]:
                seen[successor] = 1
                order.append(successor)
                before.append(position)
        position += 1
    return np.array(order, np.int64), np.array(before, np.int64)


def reachable(pointer: Ints, head: Ints, sources: Ints) -> Mask:
    """Return which nodes can be reached from ``sources`` (themselves included), shape ``(n,)``."""
    mask = np.zeros(pointer.shape[0] - 1, np.bool_)
    mask[breadth_first_forest(pointer, head, sources)[0]] = True
    return mask


def strong_components(pointer: Ints, head: Ints) -> tuple[int, Ints]:
    """Find the strongly connected components.

    Args:
        pointer: Pointers, shape ``(n + 1,)``.
        head: Successors, shape ``(edges,)``. An edge must not be given twice: SciPy's search
            (1.17) would not end.

    Returns:
        Their number, and the component of each node. Components are numbered such that every
        edge leads to a component of the same or a smaller number.
    """
    n = pointer.shape[0] - 1
    if n + head.shape[0] <= SMALL:
        return _strong_components_in_python(pointer, head)
    from scipy.sparse.csgraph import connected_components

    count, found = connected_components(_matrix(pointer, head), True, "strong")
    label: Ints = np.asarray(found, np.int64)
    tail_label = np.repeat(label, np.diff(pointer))
    head_label = label[head]
    if not bool((head_label <= tail_label).all()):
        # SciPy promises no order. Up to 1.17 it numbers them as they are finished.
        if not bool((head_label >= tail_label).all()):  # pragma: no cover
            return _strong_components_in_python(pointer, head)
        label = count - 1 - label
    return int(count), label


def _strong_components_in_python(pointer: Ints, head: Ints) -> tuple[int, Ints]:
    """Tarjan's algorithm with an explicit stack."""
    start, successors = pointer.tolist(), head.tolist()
    n = len(start) - 1
    number, low, label = [-1] * n, [0] * n, [-1] * n
    following = start[:n]
    open_nodes: list[int] = []
    counter = components = 0
    for root in range(n):
        if number[root] >= 0:
            continue
        path = [root]
        number[root] = low[root] = counter
        counter += 1
        open_nodes.append(root)
        while path:
            node = path[-1]
            edge = following[node]
            if edge < start[node + 1]:
                following[node] = edge + 1
                successor = successors[edge]
                if number[successor] < 0:
                    number[successor] = low[successor] = counter
                    counter += 1
                    open_nodes.append(successor)
                    path.append(successor)
                elif label[successor] < 0 and number[successor] < low[node]:
                    low[node] = number[successor]
                continue
            path.pop()
            if path and low[node] < low[path[-1]]:
                low[path[-1]] = low[node]
            if low[node] == number[node]:
                while True:
                    member = open_nodes.pop()
                    label[member] = components
                    if member == node:
                        break
                components += 1
    return components, np.array(label, np.int64)


def roots(before: Ints) -> Ints:
    """Return for each node of a forest the position of its root, by pointer doubling.

    Args:
        before: Position of the predecessor, -1 for roots, shape ``(n,)``.

    Returns:
        Positions, shape ``(n,)``; ``O(n log depth)``.
    """
    jump = np.where(before < 0, np.arange(before.shape[0]), before)
    while True:
        further = jump[jump]
        if np.array_equal(further, jump):
            return jump
        jump = further


def ancestors(before: Ints, nodes: Ints) -> Mask:
    """Return which nodes of a forest lie on the paths from ``nodes`` to their roots.

    Args:
        before: Position of the predecessor, -1 for roots, shape ``(n,)``.
        nodes: Positions to start from; they count as their own ancestors.

    Returns:
        Mask, shape ``(n,)``; ``O(n log depth)``.
    """
    mask = np.zeros(before.shape[0], np.bool_)
    mask[nodes] = True
    jump = np.where(before < 0, np.arange(before.shape[0]), before)
    while True:
        mask[jump[mask]] = True
        further = jump[jump]
        if np.array_equal(further, jump):
            return mask
        jump = further


def _matrix(pointer: Ints, head: Ints) -> Any:
    from scipy.sparse import csr_array

    n = pointer.shape[0] - 1
    arrays = (np.ones(head.shape[0]), head.astype(np.int32), pointer.astype(np.int32))
    return csr_array(arrays, shape=(n, n))
