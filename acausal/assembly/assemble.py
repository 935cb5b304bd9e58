"""Families and a layout become a DAE problem: index arrays, sparsity pattern, scatter maps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from acausal.assembly.layout import Layout
from acausal.assembly.problem import Y_POSITION, DAEProblem, KernelCall
from acausal.codegen.kernels import Kernel, compile_kernels
from acausal.expressions import build
from acausal.expressions.nodes import slot
from acausal.flattening.model import EquationFamily, Ids, Operand

#: ``x' - v``: couples the derivative of a state to the state that it is.
COUPLING = build.sub(slot(0), slot(1))


def wanted_slots(family: EquationFamily) -> tuple[int, ...]:
    """Return the slots that are variables: those to differentiate with respect to."""
    return tuple(k for k, kind in enumerate(family.kinds) if kind == Operand.VARIABLE)


def family_kernels(families: Sequence[EquationFamily]) -> list[Kernel]:
    """Return the kernels of families and, last, the one of the coupling rows."""
    return compile_kernels([*((f.template, wanted_slots(f)) for f in families), (COUPLING, (0, 1))])


def positions(family: EquationFamily, position: Ids, parameters: int) -> NDArray[np.int32]:
    """Return the operands of a family as positions in ``w``, shape ``(m, count)``."""
    result = np.empty(family.operands.shape, np.int32)
    for k, kind in enumerate(family.kinds):
        ids = family.operands[k]
        result[k] = position[ids] if kind == Operand.VARIABLE else parameters + ids
    return result


def assemble(
    families: Sequence[EquationFamily],
    kernels: Sequence[Kernel],
    n_rows: int,
    layout: Layout,
    parameters: NDArray[np.float64],
    nominal: NDArray[np.float64],
) -> DAEProblem:
    """Return the DAE problem.

    Args:
        families: All families, differentiated ones included.
        kernels: Their kernels and the coupling kernel, see :func:`family_kernels`.
        n_rows: Number of rows of the families; couplings are added behind them.
        layout: Positions.
        parameters: Values, shape ``(p,)``.
        nominal: Magnitudes of all variables, shape ``(N,)``.
    """
    n = layout.n
    assert n_rows + len(layout.couplings) == n, "rows and unknowns differ in number"
    targets = [f.rows.astype(np.int32) for f in families]
    indices = [positions(f, layout.position, layout.parameters) for f in families]
    coupled = layout.couplings
    x = layout.position[layout.states[coupled]]
    indices.append(np.stack([x + n, layout.position[layout.derivatives[coupled]]]).astype(np.int32))
    targets.append((n_rows + np.arange(len(coupled))).astype(np.int32))
    entries, indptr, rows = _pattern(kernels, indices, targets, n)
    w = np.zeros(layout.observables)
    w[layout.parameters :] = parameters
    differential = np.zeros(n, np.bool_)
    differential[layout.position[layout.states] - Y_POSITION] = True
    calls = tuple(
        KernelCall(kernel, np.ascontiguousarray(index), target, entry)
        for kernel, index, target, entry in zip(kernels, indices, targets, entries, strict=True)
        if index.shape[1]
    )
    return DAEProblem(
        n, calls, w, indptr, rows, differential, np.ascontiguousarray(nominal[layout.y_ids])
    )


def _pattern(
    kernels: Sequence[Kernel],
    indices: Sequence[NDArray[np.int32]],
    targets: Sequence[NDArray[np.int32]],
    n: int,
) -> tuple[list[NDArray[np.int32]], NDArray[np.int64], NDArray[np.int32]]:
    """Return the entry map of every kernel call, column pointers and row indices (CSC)."""
    keys: list[NDArray[np.int64]] = []
    primes: list[NDArray[np.bool_]] = []
    for kernel, index, target in zip(kernels, indices, targets, strict=True):
        for k in kernel.variable_slots:
            place = index[k].astype(np.int64) - Y_POSITION
            # A known zero stands before y: it has no column and goes to the bin.
            keys.append(np.where(place < 0, -1, (place % n) * n + target))
            primes.append(place >= n)
    if not keys:
        return (
            [np.zeros((0, t.shape[0]), np.int32) for t in targets],
            np.zeros(n + 1, np.int64),
            np.zeros(0, np.int32),
        )
    every = np.concatenate(keys)
    unique, inverse = np.unique(every[every >= 0], return_inverse=True)
    nnz = len(unique)
    place = np.full(len(every), 2 * nnz, np.int64)
    place[every >= 0] = inverse
    place = np.where((every >= 0) & np.concatenate(primes), place + nnz, place).astype(np.int32)
    entries: list[NDArray[np.int32]] = []
    start = 0
    for kernel, target in zip(kernels, targets, strict=True):
        q, count = len(kernel.variable_slots), target.shape[0]
        entries.append(np.ascontiguousarray(place[start : start + q * count].reshape(q, count)))
        start += q * count
    indptr = np.zeros(n + 1, np.int64)
    np.cumsum(np.bincount(unique // n, minlength=n), out=indptr[1:])
    return entries, indptr, (unique % n).astype(np.int32)
