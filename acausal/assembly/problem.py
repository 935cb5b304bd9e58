"""The problem a solver sees: ``F(t, y, y') = 0``, its Jacobian, and nothing about models."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.codegen.delays import DelayTable
from acausal.codegen.kernels import Kernel

#: Position of the constant 0.0 in the work vector.
ZERO_POSITION = 0
#: Position of the time in the work vector.
TIME_POSITION = 1
#: Position of ``y[0]`` in the work vector.
Y_POSITION = 2


@dataclass(frozen=True)
class KernelCall:
    """One kernel and the index arrays of one equation family (all C-contiguous).

    Attributes:
        kernel: Native functions of the template.
        index: Positions in ``w``, int32, shape ``(m, count)``.
        target: Rows, int32, shape ``(count,)``.
        entry: Positions in the Jacobian buffer of length ``2 nnz + 1``, int32, shape
            ``(q, count)``: below ``nnz`` for dF/dy, below ``2 nnz`` for dF/dy', else the bin.
    """

    kernel: Kernel
    index: NDArray[np.int32]
    target: NDArray[np.int32]
    entry: NDArray[np.int32]


@dataclass
class RootProblem:
    """Root functions ``g_k(t, y, y') = value_k + shift_k`` of a problem.

    They read the same work vector as the residual.

    Attributes:
        n: Number of root functions.
        calls: Kernel calls that give the values: ``target`` holds numbers of root functions,
            each of them once in all calls together; ``entry`` has no rows.
        shift: Added to the values, float64, shape ``(n,)``; may be changed in place between two
            calls of an integrator.
    """

    n: int
    calls: tuple[KernelCall, ...]
    shift: NDArray[np.float64]


@dataclass(frozen=True)
class DAEProblem:
    """A differential-algebraic system of index 1 in the form ``F(t, y, y') = 0``.

    Attributes:
        n: Number of unknowns and rows.
        calls: Kernel calls whose contributions add up to ``F``.
        w: Work vector ``[0, t, y, y', parameters, ...]``, float64; the problem owns it.
        indptr: Column pointers of the Jacobian's pattern, int64, shape ``(n+1,)``.
        indices: Row indices in CSC order, sorted in each column, int32, shape ``(nnz,)``.
        differential: Which unknowns have a derivative in ``F``, shape ``(n,)``.
        nominal: Magnitudes of the unknowns for tolerances, shape ``(n,)``.
        roots: Functions whose sign changes end an integration, None for none.
        delays: Entries of ``w`` that are read from histories at every evaluation.
    """

    n: int
    calls: tuple[KernelCall, ...]
    w: NDArray[np.float64]
    indptr: NDArray[np.int64]
    indices: NDArray[np.int32]
    differential: NDArray[np.bool_]
    nominal: NDArray[np.float64]
    roots: RootProblem | None = None
    delays: DelayTable | None = None

    @property
    def nnz(self) -> int:
        """Number of structurally non-zero entries of the Jacobian."""
        return int(self.indices.shape[0])

    @property
    def parameter_position(self) -> int:
        """Position of the first parameter in ``w``."""
        return Y_POSITION + 2 * self.n
