"""A problem as native functions that a solver calls without Python in between.

``NativeProblem`` builds the table of ``driver_code`` from a
``acausal.assembly.problem.DAEProblem``. All functions return 0
for success, 1 for a value that is not finite (a solver may try a smaller step) and -1 when
``request_stop`` was called.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import cache
from hashlib import blake2b
from typing import Final, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from acausal.codegen import engine
from acausal.codegen.delays import DelayTable
from acausal.codegen.driver_code import DRIVER_TEXT, FIELDS, RECORD
from acausal.codegen.kernels import Kernel
from acausal.storage import cache_directory


class _KernelCall(Protocol):
    """What the driver reads of ``acausal.assembly.problem.KernelCall``, a later stage."""

    @property
    def kernel(self) -> Kernel: ...
    @property
    def index(self) -> NDArray[np.int32]: ...
    @property
    def target(self) -> NDArray[np.int32]: ...
    @property
    def entry(self) -> NDArray[np.int32]: ...


class _RootProblem(Protocol):
    """What the driver reads of ``acausal.assembly.problem.RootProblem``."""

    n: int
    shift: NDArray[np.float64]

    @property
    def calls(self) -> Sequence[_KernelCall]: ...


class _Problem(Protocol):
    """What the driver reads of ``acausal.assembly.problem.DAEProblem``."""

    @property
    def n(self) -> int: ...
    @property
    def nnz(self) -> int: ...
    @property
    def calls(self) -> Sequence[_KernelCall]: ...
    @property
    def w(self) -> NDArray[np.float64]: ...
    @property
    def indptr(self) -> NDArray[np.int64]: ...
    @property
    def indices(self) -> NDArray[np.int32]: ...
    @property
    def differential(self) -> NDArray[np.bool_]: ...
    @property
    def parameter_position(self) -> int: ...
    @property
    def roots(self) -> _RootProblem | None: ...
    @property
    def delays(self) -> DelayTable | None: ...


_ProblemT = TypeVar("_ProblemT", bound=_Problem)

_double, _pointer = ctypes.c_double, ctypes.c_void_p
_RESIDUAL_TYPE: Final = ctypes.CFUNCTYPE(
    ctypes.c_int32, _double, _pointer, _pointer, _pointer, _pointer
)
_JACOBIAN_TYPE: Final = ctypes.CFUNCTYPE(
    ctypes.c_int32, _double, _double, _pointer, _pointer, _pointer, _pointer
)
_ZERO_POSITION: Final = 0


@cache
def _load_driver() -> None:
    """Load the driver, compiled by the first program on this machine that needs it."""
    identity = engine.target_identity() + DRIVER_TEXT
    key = "driver_" + blake2b(identity.encode(), digest_size=16).hexdigest()
    code = cache_directory.read("kernel", key)
    if code is None:
        code = engine.compile_object(DRIVER_TEXT, level=2, passes=True)
        cache_directory.write("kernel", key, code)
    engine.load_objects([code])


class NativeProblem(Generic[_ProblemT]):
    """Native residual and Jacobian of a problem.

    Holds references to the arrays of the problem, so that the addresses stay good as long as this
    object lives. Changes of values in ``problem.w`` (parameters) are seen at the next call.

    Attributes:
        problem: The problem.
    """

    def __init__(self, problem: _ProblemT) -> None:
        """Build the table.

        Raises:
            ValueError: An array has a wrong type or layout, or an index out of range.
        """
        _load_driver()
        self.problem = problem
        n, nnz = problem.n, problem.nnz
        w, start = problem.w, problem.parameter_position
        _check("w", w, np.float64, (w.size,))
        _check("indptr", problem.indptr, np.int64, (n + 1,))
        _check("indices", problem.indices, np.int32, (nnz,), n)
        if w.size < start:
            raise ValueError(f"a work vector of {w.size} numbers for {n} unknowns")
        self._buffer = np.zeros(2 * nnz + 1)
        self._constant_part = np.zeros(2 * nnz + 1)
        self._tail_copy = np.zeros(w.size - start)
        self._calls = np.zeros((len(problem.calls), len(RECORD)), dtype=np.int64)
        for record, call in zip(self._calls, problem.calls, strict=True):
            record[:] = _record(problem, call)
        entries = np.repeat(np.asarray(problem.differential, np.int8), np.diff(problem.indptr))
        self._differential_entry = np.ascontiguousarray(entries)
        self._root_calls, self._root_shift = _root_records(problem)
        self._table = np.zeros(len(FIELDS), dtype=np.int64)
        self._set(
            n=n, nnz=nnz, call_count=len(problem.calls), w=w.ctypes.data,
            calls=self._calls.ctypes.data, buffer=self._buffer.ctypes.data,
            indptr=problem.indptr.ctypes.data, indices=problem.indices.ctypes.data,
            constant_part=self._constant_part.ctypes.data,
            tail=w.ctypes.data + 8 * start, tail_bytes=8 * self._tail_copy.size,
            tail_copy=self._tail_copy.ctypes.data,
            differential_entry=self._differential_entry.ctypes.data,
            delays=0 if problem.delays is None else problem.delays.address,
            root_count=self._root_shift.size, root_call_count=len(self._root_calls),
            root_calls=self._root_calls.ctypes.data, root_shift=self._root_shift.ctypes.data,
        )  # fmt: skip
        self.table_address = int(self._table.ctypes.data)
        self._residual = _RESIDUAL_TYPE(self.residual_address)
        self._jacobian = _JACOBIAN_TYPE(self.jacobian_address)
        self._roots = _RESIDUAL_TYPE(self.roots_address)

    def _set(self, **values: int) -> None:
        for name, value in values.items():
            self._table[FIELDS.index(name)] = value

    @property
    def residual_address(self) -> int:
        """Address of ``i32 (f64 t, f64* y, f64* yp, f64* r, table*)``."""
        return engine.address_of("acausal_residual")

    @property
    def jacobian_address(self) -> int:
        """Address of ``i32 (f64 t, f64 cj, f64* y, f64* yp, f64* data[nnz], table*)``."""
        return engine.address_of("acausal_jacobian")

    @property
    def jacobian_dense_address(self) -> int:
        """Address of the same for a column-major ``data[n*n]``, zero outside of the pattern."""
        return engine.address_of("acausal_jacobian_dense")

    @property
    def restart_jacobian_address(self) -> int:
        """Address of ``i32 (f64 t, f64* y, f64* yp, f64* data[nnz], table*)``.

        It gives dF/dy' in the columns of differential unknowns and dF/dy in the others.
        """
        return engine.address_of("acausal_restart_jacobian")

    @property
    def roots_address(self) -> int:
        """Address of ``i32 (f64 t, f64* y, f64* yp, f64* g, table*)``."""
        return engine.address_of("acausal_roots")

    @property
    def root_count(self) -> int:
        """Number of root functions."""
        return 0 if self.problem.roots is None else self.problem.roots.n

    def request_stop(self, stop: bool = True) -> None:
        """Make all callbacks return -1 from now on (or, with False, work again)."""
        self._set(stop=int(stop))

    @property
    def residual_evaluations(self) -> int:
        """Number of residual evaluations so far."""
        return int(self._table[FIELDS.index("residual_evaluations")])

    @property
    def jacobian_evaluations(self) -> int:
        """Number of Jacobian evaluations so far."""
        return int(self._table[FIELDS.index("jacobian_evaluations")])

    def residual(
        self,
        t: float,
        y: NDArray[np.float64],
        yp: NDArray[np.float64],
        out: NDArray[np.float64],
    ) -> int:
        """Compute ``out = F(t, y, y')``.

        Args:
            t: Time in s.
            y: Unknowns, float64, shape ``(n,)``.
            yp: Their derivatives by time, shape ``(n,)``.
            out: Residuals, shape ``(n,)``, overwritten.

        Returns:
            0; 1 if a residual is not finite; -1 if a stop was requested.

        Raises:
            ValueError: Wrong shapes, types or memory layout.
        """
        shape = (self.problem.n,)
        for name, array in (("y", y), ("yp", yp), ("out", out)):
            _check(name, array, np.float64, shape)
        arrays = (y.ctypes.data, yp.ctypes.data, out.ctypes.data)
        return int(self._residual(t, *arrays, self.table_address))

    def jacobian_values(
        self,
        t: float,
        cj: float,
        y: NDArray[np.float64],
        yp: NDArray[np.float64],
        out: NDArray[np.float64],
    ) -> int:
        """Compute the entries of ``dF/dy + cj dF/dy'`` in the order of ``problem.indices``.

        Args:
            t: Time in s.
            cj: Factor of dF/dy', in 1/s.
            y: Unknowns, shape ``(n,)``.
            yp: Their derivatives by time, shape ``(n,)``.
            out: Entries, shape ``(nnz,)``, overwritten.

        Returns:
            0, or -1 if a stop was requested.

        Raises:
            ValueError: Wrong shapes, types or memory layout.
        """
        shape = (self.problem.n,)
        for name, array in (("y", y), ("yp", yp)):
            _check(name, array, np.float64, shape)
        _check("out", out, np.float64, (self.problem.nnz,))
        arrays = (y.ctypes.data, yp.ctypes.data, out.ctypes.data)
        return int(self._jacobian(t, cj, *arrays, self.table_address))

    def roots(
        self,
        t: float,
        y: NDArray[np.float64],
        yp: NDArray[np.float64],
        out: NDArray[np.float64],
    ) -> int:
        """Compute the root functions ``out = g(t, y, y')``, shifts included.

        Args:
            t: Time in s.
            y: Unknowns, float64, shape ``(n,)``.
            yp: Their derivatives by time, shape ``(n,)``.
            out: Values, shape ``(roots.n,)``, overwritten.

        Returns:
            0; 1 if a value is not finite.

        Raises:
            ValueError: Wrong shapes, types or memory layout.
        """
        for name, array in (("y", y), ("yp", yp)):
            _check(name, array, np.float64, (self.problem.n,))
        _check("out", out, np.float64, (self.root_count,))
        arrays = (y.ctypes.data, yp.ctypes.data, out.ctypes.data)
        return int(self._roots(t, *arrays, self.table_address))

    def partial_values(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the entries of dF/dy and dF/dy' of the last Jacobian, each of shape ``(nnz,)``."""
        nnz = self.problem.nnz
        return self._buffer[:nnz].copy(), self._buffer[nnz : 2 * nnz].copy()


def _record(problem: _Problem, call: _KernelCall) -> tuple[int, ...]:
    kernel, count = call.kernel, call.index.shape[1]
    _check("index", call.index, np.int32, (kernel.m, count), problem.w.size)
    _check("target", call.target, np.int32, (count,), problem.n)
    _check("entry", call.entry, np.int32, (kernel.q, count), 2 * problem.nnz + 1)
    return (
        kernel.residual, kernel.jacobian, count,
        call.index.ctypes.data, call.target.ctypes.data, call.entry.ctypes.data,
        int(_is_constant(problem, call)), 0,
    )  # fmt: skip


def _root_records(problem: _Problem) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the records of the root functions' calls and the shifts themselves."""
    roots = problem.roots
    if roots is None:
        return np.zeros((0, len(RECORD)), np.int64), np.zeros(0)
    _check("shift", roots.shift, np.float64, (roots.n,))
    times = np.zeros(roots.n, np.int64)
    records = np.zeros((len(roots.calls), len(RECORD)), np.int64)
    for record, call in zip(records, roots.calls, strict=True):
        kernel, count = call.kernel, call.index.shape[1]
        _check("index", call.index, np.int32, (kernel.m, count), problem.w.size)
        _check("target", call.target, np.int32, (count,), roots.n)
        # Adding to zero once is storing, and the adding kernel is the faster one.
        record[:] = (
            kernel.residual, 0, count, call.index.ctypes.data, call.target.ctypes.data, 0, 0, 0,
        )  # fmt: skip
        np.add.at(times, call.target, 1)
    if np.any(times != 1):
        raise ValueError("every root function needs exactly one kernel")
    return records, roots.shift


def _is_constant(problem: _Problem, call: _KernelCall) -> bool:
    """Return whether the partial derivatives read nothing but zero and the tail of ``w``."""
    if call.kernel.jacobian_reads_time:
        return False
    for slot in call.kernel.jacobian_operands:
        row = call.index[slot]
        if not np.all((row == _ZERO_POSITION) | (row >= problem.parameter_position)):
            return False
    return True


def _check(
    name: str, array: NDArray[np.generic], kind: type, shape: tuple[int, ...], bound: int = 0
) -> None:
    if array.dtype != kind or array.shape != shape or not array.flags.c_contiguous:
        raise ValueError(
            f"{name} is {array.dtype} {array.shape}, expected C-contiguous {kind.__name__} {shape}"
        )
    if bound and array.size and (array.min() < 0 or array.max() >= bound):
        raise ValueError(f"{name} holds an index outside of 0 .. {bound - 1}")
