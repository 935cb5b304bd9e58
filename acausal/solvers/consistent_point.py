"""Consistent values after an event: the differential unknowns are kept, everything else follows.

The unknowns are ``v_k = y'_k`` where unknown ``k`` is differential and ``v_k = y_k`` where it is
algebraic; the matrix has the column dF/dy'_k or dF/dy_k, which is regular exactly if the index
is 1. Full Newton steps from values that are near; it is for the caller to have a slower and more
robust way when they do not converge.
"""

from __future__ import annotations

import contextlib
import ctypes
from ctypes import byref, c_double, c_int32, c_void_p
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import AcausalError
from acausal.solvers import native_newton
from acausal.solvers.native_newton import (
    ITERATIONS,
    KEEP,
    ROUNDOFF_UNITS,
    SHARE,
    STAGNATION,
    TOLERANCE,
    Field,
)
from acausal.solvers.sundials import binding
from acausal.solvers.system import NativeSystem

Array = NDArray[np.float64]

#: Up to this size the native function with its dense matrix.
DENSE_LIMIT = 60

# The interpreter's lock is kept: giving it up costs more than a small system.
_FUNCTION = ctypes.PYFUNCTYPE(c_int32, c_double, c_void_p)
_UNIT_ROUNDOFF = float(np.finfo(float).eps)


@dataclass(frozen=True)
class NativePoint:
    """Addresses for native code that solves the same system.

    Attributes:
        function: ``i32 f(double t, void* table)``, negative where it fails.
        table: Its argument.
        y, yp: Where it takes the unknowns and derivatives from, and leaves them.
    """

    function: int
    table: int
    y: int
    yp: int


class ConsistentPoint:
    """Solves one system, again and again."""

    def __init__(self, system: NativeSystem) -> None:
        """Prepare the arrays."""
        self._system = system
        problem = system.problem
        n, nnz = problem.n, problem.nnz
        self._work = np.zeros((8, n))
        self._y, self._yp, self._nominal, self._mask = self._work[:4]
        self._r, self._d = self._work[4:6]
        self._nominal[:] = problem.nominal
        self._mask[:] = problem.differential
        self._differential = np.asarray(problem.differential, np.bool_)
        self._rows = problem.indices.astype(np.int64)
        self._columns = np.repeat(np.arange(n, dtype=np.int64), np.diff(problem.indptr))
        self._values = np.zeros(max(nnz, 1))
        self._function: Any = None
        self._solver: _Linear | None = None
        if n <= DENSE_LIMIT and system.restart_jacobian_address:
            self._prepare_native(system)

    def _prepare_native(self, system: NativeSystem) -> None:
        n = system.problem.n
        self._dense = np.zeros((n, n))
        self._pivots = np.zeros(n, np.int64)
        self._scales = np.zeros((3, n))
        table = np.zeros(Field.COUNT, np.int64)
        table[Field.RESIDUAL] = system.residual_address
        table[Field.JACOBIAN] = system.restart_jacobian_address
        table[Field.TABLE] = system.table_address
        table[Field.N], table[Field.NNZ] = n, system.problem.nnz
        arrays: dict[Field, NDArray[Any]] = {
            Field.Y: self._y, Field.YP: self._yp, Field.NOMINAL: self._nominal,
            Field.DIFFERENTIAL: self._mask, Field.ROWS: self._rows, Field.COLUMNS: self._columns,
            Field.VALUES: self._values, Field.MATRIX: self._dense, Field.PIVOTS: self._pivots,
            Field.ROW_SCALE: self._scales[0], Field.COLUMN_SCALE: self._scales[1],
            Field.TERMS: self._scales[2], Field.R: self._r, Field.D: self._d,
        }  # fmt: skip
        for field, array in arrays.items():
            table[field] = array.ctypes.data
        self._table = table
        self._argument = c_void_p(table.ctypes.data)
        self._function = _FUNCTION(native_newton.address())

    @property
    def native(self) -> NativePoint | None:
        """The same for native code; None for a system too large, or in Python."""
        if self._function is None:
            return None
        places = (self._table, self._y, self._yp)
        return NativePoint(native_newton.address(), *(int(a.ctypes.data) for a in places))

    def solve(self, t: float, y: Array, yp: Array) -> int:
        """Replace algebraic unknowns and derivatives; see ``Integrator.consistent``."""
        self._y[:] = y
        self._yp[:] = yp
        count = self._iterate(t) if self._function is None else self._function(t, self._argument)
        if count >= 0:
            y[:] = self._y
            yp[:] = self._yp
        return int(count)

    # --- the same in Python, for large systems and for callback systems

    def _iterate(self, t: float) -> int:
        last, new = np.inf, True
        if self._solver is None:
            self._solver = _linear_solver(self._system)
        for count in range(1, ITERATIONS + 1):
            if new:
                self._evaluate_matrix(t)
                if not np.isfinite(self._values).all() or not self._solver.factorise(self._values):
                    return -1
            self._system.residual(t, self._y, self._yp, self._r)
            d = self._solver.solve(self._r)
            v = np.where(self._differential, self._yp, self._y)
            norm = float((np.abs(d) / np.maximum(np.abs(v), SHARE * self._nominal)).max())
            if not norm < np.inf:
                return -1
            if new or norm <= 0.5 * last or norm <= STAGNATION:
                v -= d
                np.copyto(self._yp, v, where=self._differential)
                np.copyto(self._y, v, where=~self._differential)
                if norm <= TOLERANCE:
                    return count
                if norm > 0.1 * last and (
                    (count >= 4 and norm <= STAGNATION) or (count >= 2 and self._is_roundoff(v))
                ):
                    return count
            new = norm > KEEP * last
            last = norm
        return -1

    def _evaluate_matrix(self, t: float) -> None:
        self._system.jacobian_values(t, 0.0, self._y, self._yp, self._values)
        by_y, by_yp = self._system.partial_values()
        chosen = self._differential[self._columns]
        self._values[: len(by_y)] = np.where(chosen, by_yp, by_y)

    def _is_roundoff(self, v: Array) -> bool:
        terms = np.abs(self._values[: len(self._rows)] * v[self._columns])
        sums = np.bincount(self._rows, terms, minlength=len(v))
        return bool(np.all(np.abs(self._r) <= ROUNDOFF_UNITS * _UNIT_ROUNDOFF * sums))


class _Linear:
    """A linear solver that is factorised again and again for one pattern."""

    def factorise(self, values: Array) -> bool:
        """Take a matrix by its entries; tell whether it is regular."""
        raise NotImplementedError

    def solve(self, right: Array) -> Array:
        """Return the solution."""
        raise NotImplementedError


def _linear_solver(system: NativeSystem) -> _Linear:
    if system.problem.n > DENSE_LIMIT:
        with contextlib.suppress(AcausalError):
            # SuperLU_MT cannot be freed after a matrix that was singular.
            if binding.bind().sundials.location.sparse == "klu":
                return _Klu(system)
        return _SciPy(system)
    return _Dense(system)


class _Dense(_Linear):
    def __init__(self, system: NativeSystem) -> None:
        self._problem = system.problem
        self._columns = np.repeat(np.arange(system.problem.n), np.diff(system.problem.indptr))

    def factorise(self, values: Array) -> bool:
        problem = self._problem
        self._matrix = np.zeros((problem.n, problem.n))
        self._matrix[problem.indices, self._columns] = values[: problem.nnz]
        largest = np.abs(self._matrix).max(axis=1)
        if not largest.all():
            return False
        self._scale = largest
        self._matrix /= largest[:, None]
        return True

    def solve(self, right: Array) -> Array:
        try:
            return np.asarray(np.linalg.solve(self._matrix, right / self._scale))
        except np.linalg.LinAlgError:
            return np.full(len(right), np.nan)


class _SciPy(_Linear):
    def __init__(self, system: NativeSystem) -> None:
        self._problem = system.problem

    def factorise(self, values: Array) -> bool:
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        p = self._problem
        matrix = csc_array((values[: p.nnz], p.indices, p.indptr), shape=(p.n, p.n))
        try:
            self._factors: Any = splu(matrix)
        except RuntimeError:
            return False
        return True

    def solve(self, right: Array) -> Array:
        return np.asarray(self._factors.solve(right))


class _Klu(_Linear):
    """KLU, as SUNDIALS has it; the pattern is analysed once."""

    def __init__(self, system: NativeSystem) -> None:
        self._open = False
        self._c = lib = binding.bind()
        problem = system.problem
        n, nnz = problem.n, problem.nnz
        index: Any = np.int32 if lib.index_bytes == 4 else np.int64
        self._context = lib.context()
        self._data = np.zeros((2, n))
        self._right, self._solution = (
            lib.N_VMake_Serial(n, row.ctypes.data, self._context) for row in self._data
        )
        self._matrix = lib.SUNSparseMatrix(n, n, max(nnz, 1), binding.CSC_MATRIX, self._context)
        self._solver = lib.sparse_solver(self._right, self._matrix, self._context)
        if not self._matrix or not self._solver:
            raise MemoryError("SUNDIALS cannot allocate its matrix")
        self._open = True
        self._pointers = np.ascontiguousarray(problem.indptr, index)
        self._indices = np.ascontiguousarray(problem.indices, index)
        self._entries = nnz

    def factorise(self, values: Array) -> bool:
        lib, matrix = self._c, self._matrix
        for place, array in (
            (lib.SUNSparseMatrix_IndexPointers(matrix), self._pointers),
            (lib.SUNSparseMatrix_IndexValues(matrix), self._indices),
            (lib.SUNSparseMatrix_Data(matrix), values[: self._entries]),
        ):
            ctypes.memmove(place, array.ctypes.data, array.nbytes)
        if int(lib.SUNLinSolSetup(self._solver, matrix)) == 0:
            return True
        # A pivot of the matrix before has become zero: choose others.
        lib.SUNLinSol_KLUReInit(
            self._solver, matrix, max(self._entries, 1), binding.KLU_REINIT_PARTIAL
        )
        return int(lib.SUNLinSolSetup(self._solver, matrix)) == 0

    def solve(self, right: Array) -> Array:
        self._data[0] = right
        flag = self._c.SUNLinSolSolve(self._solver, self._matrix, self._solution, self._right, 0.0)
        return self._data[1].copy() if flag == 0 else np.full(len(right), np.nan)

    def __del__(self) -> None:
        with contextlib.suppress(Exception):
            if self._open:
                self._open = False
                self._c.SUNLinSolFree(self._solver)
                self._c.SUNMatDestroy(self._matrix)
                self._c.N_VDestroy(self._right)
                self._c.N_VDestroy(self._solution)
                self._c.SUNContext_Free(byref(self._context))
