"""Plain sequential forms of the structural algorithms, to test the vectorised ones against."""

from __future__ import annotations

import numpy as np

from acausal.structural.graphs import compress
from acausal.structural.incidence import Signature

Sigma = dict[tuple[int, int], int]


def signature(sigma: Sigma, n_rows: int, n_bases: int) -> Signature:
    """Turn ``{(row, base): order}`` into a signature matrix."""
    keys = sorted(sigma)
    rows = np.array([i for i, _ in keys], np.int64)
    bases = np.array([j for _, j in keys], np.int64)
    orders = np.array([sigma[key] for key in keys], np.int64)
    return Signature(n_rows, n_bases, compress(rows, n_rows), rows, bases, orders)


def matching_size(edges: set[tuple[int, int]], n_rows: int) -> int:
    """Return the size of a maximum matching, by one augmenting path after the other."""
    row_of: dict[int, int] = {}

    def augment(row: int, seen: set[int]) -> bool:
        for i, j in sorted(edges):
            if i == row and j not in seen:
                seen.add(j)
                if j not in row_of or augment(row_of[j], seen):
                    row_of[j] = row
                    return True
        return False

    return sum(augment(row, set()) for row in range(n_rows))


def _augment(
    e: int,
    equations: list[set[int]],
    highest: set[int],
    assign: dict[int, int],
    seen_equations: list[int],
    seen_variables: list[int],
) -> bool:
    """Find an augmenting path from equation ``e`` (algorithm AUGMENTPATH of the paper)."""
    seen_equations.append(e)
    for v in sorted(equations[e] & highest):
        if v not in assign:
            assign[v] = e
            return True
    for v in sorted(equations[e] & highest):
        if v not in seen_variables:
            seen_variables.append(v)
            if _augment(assign[v], equations, highest, assign, seen_equations, seen_variables):
                assign[v] = e
                return True
    return False


def pantelides_1988(sigma: Sigma, n: int) -> tuple[list[int], list[int]]:
    """Return the offsets by Pantelides' own algorithm (1988, algorithm 4.1), row after row.

    Equations and variables are numbered; differentiating makes new ones. ``A`` leads from a
    variable to its derivative, ``B`` from an equation to its derivative.
    """
    variables = [(j, 0) for j in range(n)]
    number = {v: k for k, v in enumerate(variables)}
    A: list[int | None] = [None] * n

    def derivative(v: int) -> int:
        if A[v] is None:
            j, order = variables[v]
            variables.append((j, order + 1))
            number[j, order + 1] = len(variables) - 1
            A.append(None)
            A[v] = len(variables) - 1
        found = A[v]
        assert found is not None
        return found

    def variable(j: int, order: int) -> int:
        v = j
        for _ in range(order):
            v = derivative(v)
        return v

    equations = []
    for i in range(n):
        content = set()
        for (row, j), order in sigma.items():
            if row == i:
                # Lower orders may stand there too; only the highest matters.
                content.add(variable(j, order))
        equations.append(content)
    B: list[int | None] = [None] * n
    origin = [(i, 0) for i in range(n)]
    assign: dict[int, int] = {}
    for k in range(n):
        i = k
        while True:
            highest = {v for v in range(len(variables)) if A[v] is None}
            seen_equations: list[int] = []
            seen_variables: list[int] = []

            if _augment(i, equations, highest, assign, seen_equations, seen_variables):
                break
            new_variables = {v: derivative(v) for v in seen_variables}
            for e in seen_equations:
                content = set()
                for v in equations[e]:
                    content.add(derivative(v))
                equations.append(equations[e] | content)
                B.append(None)
                origin.append((origin[e][0], origin[e][1] + 1))
                B[e] = len(equations) - 1
            for v, w in new_variables.items():
                found = B[assign[v]]
                assert found is not None
                assign[w] = found
            follower = B[i]
            assert follower is not None
            i = follower
    c, d = [0] * n, [0] * n
    for i, order in origin:
        c[i] = max(c[i], order)
    for j, order in variables:
        d[j] = max(d[j], order)
    return c, d
