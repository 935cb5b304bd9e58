"""Small DAEProblems with real kernels."""

from __future__ import annotations

import numpy as np

from acausal.assembly.problem import DAEProblem, KernelCall
from acausal.codegen.kernels import compile_kernels
from acausal.expressions.build import add, call, mul, sub
from acausal.expressions.nodes import Expr, slot

A, B, C = slot(0), slot(1), slot(2)


def build(
    differential: np.ndarray,
    parameters: list[float],
    families: list[tuple[Expr, list[np.ndarray], np.ndarray]],
) -> DAEProblem:
    """Build a problem.

    Args:
        differential: Mask of the states.
        parameters: Their values.
        families: Template, positions in ``w`` by slot, rows.
    """
    n = len(differential)
    kernels = compile_kernels([(t, tuple(range(len(index)))) for t, index, _ in families])
    index = [np.ascontiguousarray(np.array(i, dtype=np.int32)) for _, i, _ in families]
    targets = [np.array(rows, dtype=np.int32) for _, _, rows in families]
    cells = [np.zeros(0, np.int64)]
    for kernel, positions, target in zip(kernels, index, targets, strict=True):
        for j in kernel.variable_slots:
            chosen = (positions[j] >= 2) & (positions[j] < 2 + 2 * n)
            column = (positions[j][chosen].astype(np.int64) - 2) % n
            cells.append(column * n + target[chosen])
    keys = np.unique(np.concatenate(cells))
    nnz = len(keys)
    calls = []
    for kernel, positions, target in zip(kernels, index, targets, strict=True):
        entry = np.full((kernel.q, target.size), 2 * nnz, dtype=np.int32)
        for number, j in enumerate(kernel.variable_slots):
            chosen = (positions[j] >= 2) & (positions[j] < 2 + 2 * n)
            column = positions[j][chosen].astype(np.int64) - 2
            place = np.searchsorted(keys, (column % n) * n + target[chosen])
            entry[number, chosen] = place + nnz * (column >= n)
        calls.append(KernelCall(kernel, positions, target, entry))
    counts = np.bincount(keys // n, minlength=n)
    return DAEProblem(
        n=n,
        calls=tuple(calls),
        w=np.concatenate([np.zeros(2 + 2 * n), parameters]),
        indptr=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        indices=(keys % n).astype(np.int32),
        differential=np.asarray(differential, dtype=bool),
        nominal=np.ones(n),
    )


def oscillators(count: int, omega: float = 1.0) -> DAEProblem:
    """x' = v, v' = a, a + omega^2 x = 0, ``count`` times: y = [x.., v.., a..]."""
    k = np.arange(count)
    x, v, a = 2 + k, 2 + count + k, 2 + 2 * count + k
    n = 3 * count
    parameter = np.full(count, 2 + 2 * n)
    minus = sub(A, B)
    return build(
        np.repeat([True, True, False], count),
        [omega**2],
        [
            (minus, [x + n, v], k),
            (minus, [v + n, a], count + k),
            (add(A, mul(B, C)), [a, parameter, x], 2 * count + k),
        ],
    )


def pendulum(g: float = 9.81, length: float = 1.0) -> DAEProblem:
    """Angle: y = [angle, rate, acceleration], length * acceleration = -g sin(angle)."""
    n = 3
    minus = sub(A, B)
    parameters = np.array([2 + 2 * n, 2 + 2 * n + 1])
    swing = add(mul(slot(0), slot(1)), mul(slot(2), call("sin", slot(3))))
    one = np.array
    return build(
        np.array([True, True, False]),
        [length, g],
        [
            (minus, [one([2 + n]), one([3])], one([0])),
            (minus, [one([3 + n]), one([4])], one([1])),
            (swing, [parameters[:1], one([4]), parameters[1:], one([2])], one([2])),
        ],
    )
