"""Linear systems of Newton's method: dense for small, sparse for large ones.

Rows and columns are scaled first. A singular or nearly singular matrix gives the step of least
norm (dense) or a damped one (sparse) instead of a failure: the caller sees by ``regular`` that it
is one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Largest system that is solved densely.
DENSE = 100
#: A step this many times larger than what the residual suggests comes from a singular matrix.
TOO_LONG = 1e13


@dataclass(frozen=True)
class Factorised:
    """A factorised matrix.

    Attributes:
        solve: Returns ``x`` with ``A x = b``, or the step of least norm.
        regular: The matrix is numerically regular.
        row_scale: Largest entry of each row, columns scaled: what a residual is measured with.
    """

    solve: Callable[[Array], Array]
    regular: bool
    row_scale: Array


def dense_matrix(
    indptr: NDArray[np.int64], indices: NDArray[np.int32], data: Array, n_rows: int
) -> Array:
    """Return a CSC matrix as a full one, shape ``(n_rows, n)``."""
    n = indptr.shape[0] - 1
    matrix = np.zeros((n_rows, n))
    matrix[indices, np.repeat(np.arange(n), np.diff(indptr))] = data
    return matrix


def factorise(
    indptr: NDArray[np.int64], indices: NDArray[np.int32], data: Array, scale: Array
) -> Factorised:
    """Factorise a square matrix.

    Args:
        indptr: Column pointers, shape ``(n+1,)``.
        indices: Row indices, shape ``(nnz,)``.
        data: Values, finite, shape ``(nnz,)``.
        scale: Magnitudes of the unknowns, shape ``(n,)``.
    """
    n = indptr.shape[0] - 1
    scaled = data * np.repeat(scale, np.diff(indptr))
    row_scale = np.zeros(n)
    np.maximum.at(row_scale, indices, np.abs(scaled))
    row_scale[row_scale == 0.0] = 1.0
    scaled = scaled / row_scale[indices]
    if n <= DENSE:
        return _dense(dense_matrix(indptr, indices, scaled, n), scale, row_scale)
    return _sparse(indptr, indices, scaled, scale, row_scale)


def _dense(matrix: Array, scale: Array, row_scale: Array) -> Factorised:
    n = matrix.shape[0]
    regular = True
    try:
        inverse = np.linalg.inv(matrix)
        # The norm of the inverse times that of the (row scaled) matrix bounds the condition.
        size = float(np.abs(inverse).sum(axis=0).max() * np.abs(matrix).sum(axis=0).max())
        regular = bool(np.isfinite(size)) and size < TOO_LONG * n
    except np.linalg.LinAlgError:
        regular = False
    if not regular:
        inverse = np.linalg.pinv(matrix, rcond=1e-11)

    def solve(b: Array) -> Array:
        right = b / row_scale
        x = inverse @ right
        # One step of refinement makes up for the explicit inverse.
        if regular:
            x += inverse @ (right - matrix @ x)
        return np.asarray(scale * x)

    return Factorised(solve, regular, row_scale)


def _sparse(
    indptr: NDArray[np.int64],
    indices: NDArray[np.int32],
    data: Array,
    scale: Array,
    row_scale: Array,
) -> Factorised:
    from scipy.sparse import csc_matrix, identity
    from scipy.sparse.linalg import splu

    n = indptr.shape[0] - 1
    matrix = csc_matrix((data, indices, indptr.astype(np.int32)), shape=(n, n))
    options = {"DiagPivotThresh": 0.1}
    try:
        factors = splu(matrix, permc_spec="COLAMD", options=options)
        pivots = np.abs(factors.U.diagonal())
        regular = bool(pivots.min() > 1e-14 * pivots.max())
    except (RuntimeError, ValueError):
        regular = False
    if regular:
        return Factorised(lambda b: scale * factors.solve(b / row_scale), True, row_scale)
    # Levenberg's damped normal equations: the step of nearly least norm.
    normal = (matrix.T @ matrix + 1e-12 * identity(n)).tocsc()
    damped = splu(normal, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def solve(b: Array) -> Array:
        right = np.asarray(matrix.T @ (b / row_scale), dtype=np.float64)
        return np.asarray(scale * damped.solve(right))

    return Factorised(solve, False, row_scale)
