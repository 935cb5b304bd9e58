"""SUNDIALS IDA with compiled callbacks: variable order, variable step BDF for F(t, y, y') = 0.

Source of the method: Brenan, Campbell, Petzold, Numerical Solution of Initial-Value Problems in
Differential-Algebraic Equations, SIAM 1996; Hindmarsh et al., SUNDIALS, ACM TOMS 31 (2005).

No Python runs inside the integration. A run is a sequence of native stretches of some
milliseconds, between which Python looks for Ctrl-C and tells the progress; when a single step takes
longer than that, the stretch runs in a thread and a flag stops it between two evaluations.
"""

from __future__ import annotations

import contextlib
import ctypes
from ctypes import byref, c_double, c_int, c_int64, c_long, c_void_p
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from acausal.codegen.sequence import data_of
from acausal.solvers import native
from acausal.solvers.consistent_point import ConsistentPoint, NativePoint
from acausal.solvers.failures import (
    Failure,
    IntegrationError,
    Reason,
    integration_error,
    largest,
    not_finite_rows,
    singular_parts,
)
from acausal.solvers.native import Frame, Word
from acausal.solvers.native_step import MOST_UNSETTLED, Code
from acausal.solvers.pacing import Pace, interruptible
from acausal.solvers.protocol import Options, RunResult, Statistics, Status, StepResult
from acausal.solvers.step_polynomial import StepPolynomial
from acausal.solvers.sundials import binding as c
from acausal.solvers.system import NativeSystem, native_system
from acausal.solvers.tolerances import ida_tolerances, suppressing

if TYPE_CHECKING:
    from acausal.assembly.problem import DAEProblem

Array = NDArray[np.float64]

_STATUS: dict[int, Status] = {
    Code.STEPPED: Status.STEPPED,
    Code.REACHED: Status.REACHED,
    Code.ROOT: Status.ROOT,
}
#: Up to this size a dense matrix is as fast as a sparse one (measured).
DENSE_LIMIT = {"klu": 12, "superlumt": 25}
#: Failures in a row at the same error test or Newton iteration before IDA gives up a step.
MAX_FAILURES = 20
#: Round-off in time, in units of its own, that an unknown is allowed to feel.
NOISE = 64.0
#: First steps tried after a failure, as fractions of the distance to the limit, and whether
#: the algebraic unknowns are computed anew before.
LADDER = ((1e-6, False), (1e-10, False), (1e-6, True), (1e-10, True), (1e-13, True))
#: A recovered failure is forgotten after so many steps that went so far, as a fraction of the
#: distance to the limit. Without the second, a pole would be approached for ever.
FORGET, FORGET_FRACTION = 10, 1e-7
_LOOP_TYPE = ctypes.CFUNCTYPE(
    c_int, c_void_p, c_void_p, c_int64, c_void_p, c_void_p, c_double, c_int64
)
_LOOK_TYPE = ctypes.CFUNCTYPE(c_int, c_void_p, c_double, c_void_p, c_void_p)
_TIME_TYPE = ctypes.CFUNCTYPE(c_int, c_void_p, c_double)
_UNIT_ROUNDOFF = float(np.finfo(float).eps)


class IDAIntegrator:
    """The integrator ``ida``; see :class:`acausal.solvers.protocol.Integrator`."""

    def __init__(
        self, system: NativeSystem, t: float, y: Array, yp: Array, options: Options
    ) -> None:
        """Prepare an integration from a consistent point.

        Raises:
            AcausalError: R101 if there is no SUNDIALS.
        """
        self._open = False
        self._c = c.bind()
        self._options = options
        self._system = system
        self._n = n = system.problem.n
        self._data = np.zeros((11, n))
        self.y, self.yp, self._scratch, self._tolerance, self._states = self._data[:5]
        self._scratch_p, self._start_y, self._start_yp = self._data[5], *self._data[9:]
        self._frame = Frame()
        self._reached = c_double.from_address(self._frame.address_of(Word.REACHED))
        self._end = c_double.from_address(self._frame.address_of(Word.END))
        self._attempt = 0
        self._consistent_point: ConsistentPoint | None = None
        self._pace = Pace(n)
        self._unsettled: Array = np.zeros(MOST_UNSETTLED)
        self._row: Array = np.zeros(1)
        self._row_y: Array = np.zeros(n)
        self._row_yp: Array = np.zeros(n)
        self._row_address = data_of(self._row)
        self._row_outputs = (data_of(self._row_y), data_of(self._row_yp))
        self._context = self._c.context()
        self._vectors = [
            self._c.N_VMake_Serial(n, row.ctypes.data, self._context) for row in self._data[:9]
        ]
        self._matrix: int = 0
        self._linear_solver: int = 0
        self._pattern: tuple[NDArray[np.int64], NDArray[np.int32]] | None = None
        self._memory = c_void_p(self._c.IDACreate(self._context))
        self._open = True
        self._fill_frame()
        self.y[:] = y
        self.yp[:] = yp
        self._initialise(t)

    # --- set-up

    def _fill_frame(self) -> None:
        """Write the addresses that stay the same."""
        lib, words = self._c, self._frame.words
        words[Word.N] = self._n
        words[Word.UNSETTLED_TIMES] = self._unsettled.ctypes.data
        words[Word.VECTOR_DATA] = lib.address("N_VGetArrayPointer")
        words[Word.DENSE_DATA] = lib.address("SUNDenseMatrix_Data")
        words[Word.SPARSE_DATA] = lib.address("SUNSparseMatrix_Data")
        words[Word.SPARSE_INDPTR] = lib.address("SUNSparseMatrix_IndexPointers")
        words[Word.SPARSE_INDICES] = lib.address("SUNSparseMatrix_IndexValues")
        words[Word.SOLVE] = lib.address("IDASolve")
        words[Word.STEP_COUNT] = lib.address("IDAGetNumSteps")
        words[Word.MEMORY] = self._memory.value or 0
        words[Word.SET_STOP] = lib.address("IDASetStopTime")
        words[Word.SET_FIRST_STEP] = lib.address("IDASetInitStep")
        words[Word.REINITIALISE] = lib.address("IDAReInit")
        words[Word.GET_LAST_STEP] = lib.address("IDAGetLastStep")
        words[Word.GET_LAST_ORDER] = lib.address("IDAGetLastOrder")
        words[Word.GET_ERRORS] = lib.address("IDAGetEstLocalErrors")
        words[Word.GET_ERROR_FAILURES] = lib.address("IDAGetNumErrTestFails")
        words[Word.GET_CONVERGENCE_FAILURES] = lib.address("IDAGetNumNonlinSolvConvFails")
        words[Word.MASKED_NORM] = lib.address("N_VWrmsNormMask")
        words[Word.GET_CJ] = lib.address("IDAGetCurrentCj")
        words[Word.GET_WEIGHTS] = lib.address("IDAGetErrWeights")
        words[Word.INTERPOLATE] = lib.address("IDAGetDky")
        words[Word.SOLVE_LINEAR] = lib.address("SUNLinSolSolve")
        words[Word.SETUP_LINEAR] = lib.address("SUNLinSolSetup")
        words[Word.MATRIX_ZERO] = lib.address("SUNMatZero")
        words[Word.NORM] = lib.address("N_VWrmsNorm")
        words[Word.LINEAR_SUM] = lib.address("N_VLinearSum")
        words[Word.PRODUCT] = lib.address("N_VProd")
        words[Word.Y_VECTOR], words[Word.YP_VECTOR] = self._vectors[:2]
        words[Word.STATES_VECTOR] = self._vectors[4]
        words[Word.RESIDUAL_VECTOR] = self._vectors[6]
        words[Word.CORRECTION_VECTOR] = self._vectors[7]
        words[Word.WEIGHT_VECTOR] = self._vectors[8]
        words[Word.OUTPUT_VECTOR], words[Word.OUTPUT_VECTOR_P] = self._vectors[2], self._vectors[5]
        rows = {
            Word.Y: 0, Word.YP: 1, Word.OUTPUT: 2, Word.TOLERANCE: 3, Word.STATES: 4,
            Word.OUTPUT_P: 5, Word.START_Y: 9, Word.START_YP: 10,
        }  # fmt: skip
        for word, row in rows.items():
            words[word] = self._data[row].ctypes.data
        options, doubles = self._options, self._frame.doubles
        doubles[Word.INITIAL_STEP] = options.initial_step or 0.0
        doubles[Word.MAX_STEP] = options.max_step
        words[Word.MOST_STEPS] = -1 if options.max_steps is None else options.max_steps
        addresses = native.addresses()
        self._loop = _LOOP_TYPE(addresses["output_loop"])
        self._look = _LOOK_TYPE(addresses["look"])
        self._advance = _TIME_TYPE(addresses["advance"])
        self._restart = _TIME_TYPE(addresses["restart"])
        self._address = c_void_p(self._frame.address)

    def _initialise(self, t: float) -> None:
        lib, memory = self._c, self._memory
        y, yp = self._vectors[:2]
        if lib.sundials.version < (7, 0, 0):
            lib.IDASetErrFile(memory, None)
        self._check(lib.IDAInit(memory, native.addresses()["ida_residual"], t, y, yp))
        self._check(lib.IDASetUserData(memory, self._frame.address))
        lib.IDASetMaxErrTestFails(memory, MAX_FAILURES)
        lib.IDASetMaxConvFails(memory, MAX_FAILURES)
        if np.isfinite(self._options.max_step):
            lib.IDASetMaxStep(memory, self._options.max_step)
        self._attach(self._system)
        self._start(t)

    def _attach(self, system: NativeSystem) -> None:
        """Connect a problem: tolerances, kinds of unknowns, pattern, kernels."""
        lib, memory, problem = self._c, self._memory, system.problem
        self._system = system
        words = self._frame.words
        words[Word.RESIDUAL] = system.residual_address
        words[Word.JACOBIAN] = system.jacobian_address
        words[Word.TABLE] = system.table_address
        tolerance = self._vectors[3]
        self._states[:] = problem.differential
        self._attach_roots(system)
        words[Word.CONSISTENT] = not problem.differential.all()
        self._check(lib.IDASetId(memory, self._vectors[4]))
        suppressed = suppressing(self._options, problem)
        words[Word.SUPPRESSED] = suppressed
        lib.IDASetSuppressAlg(memory, int(suppressed))
        relative, self._tolerance[:] = ida_tolerances(self._options, problem)
        self._least_tolerance = self._tolerance.copy()
        self._raised = False
        self._stateless = not problem.differential.any()
        self._frame.doubles[Word.RELATIVE] = relative
        self._check(lib.IDASVtolerances(memory, relative, tolerance))
        if not self._same_pattern(system):
            self._make_matrix(system)

    def _attach_roots(self, system: NativeSystem) -> None:
        words, count = self._frame.words, system.root_count
        if words[Word.ROOT_COUNT] != count or not hasattr(self, "roots_found"):
            self._root_values = np.zeros((3, count))
            self.roots_found = np.zeros(count, np.int32)
            self._directions = np.zeros(count, np.int32)
        words[Word.ROOT_COUNT] = count
        words[Word.ROOTS] = system.roots_address
        places = (Word.G_LOW, Word.G_HIGH, Word.G_MIDDLE)
        for word, row in zip(places, self._root_values, strict=True):
            words[word] = row.ctypes.data
        words[Word.FOUND] = self.roots_found.ctypes.data
        words[Word.DIRECTIONS] = self._directions.ctypes.data

    def set_root_directions(self, directions: NDArray[np.int32]) -> None:
        """Look for rising or falling roots; see the protocol."""
        self._directions[:] = directions

    def _same_pattern(self, system: NativeSystem) -> bool:
        if self._pattern is None:
            return False
        old_indptr, old_indices = self._pattern
        new = system.problem
        if old_indptr is new.indptr and old_indices is new.indices:
            return True
        return np.array_equal(old_indptr, new.indptr) and np.array_equal(old_indices, new.indices)

    def _make_matrix(self, system: NativeSystem) -> None:
        """Make the matrix and the linear solver for the problem's pattern."""
        lib, words, problem, n = self._c, self._frame.words, system.problem, self._n
        wanted = self._options.linear_solver
        limit = DENSE_LIMIT[str(lib.sundials.location.sparse)]
        dense = n <= limit if wanted == "auto" else wanted == "dense"
        words[Word.NNZ] = problem.nnz
        y = self._vectors[0]
        if dense:
            columns = np.repeat(np.arange(n, dtype=np.int64), np.diff(problem.indptr))
            self._positions = columns * n + problem.indices
            self._values = np.zeros(max(problem.nnz, 1))
            words[Word.POSITIONS] = self._positions.ctypes.data
            words[Word.VALUES] = self._values.ctypes.data
            matrix = lib.SUNDenseMatrix(n, n, self._context)
            solver = lib.SUNLinSol_Dense(y, matrix, self._context)
            callback = "ida_jacobian_dense"
        else:
            index = np.int32 if lib.index_bytes == 4 else np.int64
            self._indptr = np.ascontiguousarray(problem.indptr, dtype=index)
            self._indices = np.ascontiguousarray(problem.indices, dtype=index)
            words[Word.INDPTR] = self._indptr.ctypes.data
            words[Word.INDICES] = self._indices.ctypes.data
            matrix = lib.SUNSparseMatrix(n, n, max(problem.nnz, 1), c.CSC_MATRIX, self._context)
            solver = lib.sparse_solver(y, matrix, self._context)
            callback = f"ida_jacobian_sparse{8 * lib.index_bytes}"
        if not matrix or not solver:
            raise MemoryError("SUNDIALS cannot allocate its matrix")
        self._check(lib.IDASetLinearSolver(self._memory, solver, matrix))
        words[Word.JACOBIAN_CALLBACK] = native.addresses()[callback]
        self._check(lib.IDASetJacFn(self._memory, native.addresses()[callback]))
        self._free_matrix()
        self._matrix, self._linear_solver = matrix, solver
        words[Word.MATRIX], words[Word.LINEAR_SOLVER] = matrix, solver
        words[Word.LINEAR_FLAG] = lib.address("SUNLinSolLastFlag")
        keeps = lib.keeps_pivots and not dense
        words[Word.NEW_PIVOTS] = lib.address("SUNLinSol_KLUReInit") if keeps else 0
        self._pattern = (problem.indptr, problem.indices)

    def _check(self, flag: int) -> None:
        if flag < 0:
            failure = Failure(Reason.OTHER, self.t)
            raise integration_error(
                failure, self._options.labels, (f"SUNDIALS returned {flag} during set-up",)
            )

    # --- the protocol

    @property
    def t(self) -> float:
        """Time of ``y`` and ``yp``, seconds."""
        return self._reached.value

    def step(self, t_limit: float) -> StepResult:
        """Take one internal step; see the protocol."""
        while True:
            flag = self._advance(self._address, t_limit)
            if flag >= 0:
                return StepResult(self._reached.value, _STATUS[flag])
            if not self._recover(flag, t_limit):
                return StepResult(self.t, Status.FAILED, self._failure(flag))

    def run(
        self, times: Array, out_y: Array, out_yp: Array, t_limit: float | None = None
    ) -> RunResult:
        """Integrate and fill rows; see the protocol."""
        times = np.ascontiguousarray(times, dtype=np.float64)
        rows = len(times)
        for out in (out_y, out_yp):
            if out.shape != (rows, self._n) or out.dtype != np.float64:
                raise ValueError(f"output must be float64 of shape {(rows, self._n)}")
            if not out.flags.c_contiguous:
                raise ValueError("output must be C-contiguous")
        if rows == 0:
            return RunResult(0, Status.REACHED)
        words = self._frame.words
        words[Word.ROWS], words[Word.ROWS_WANTED] = 0, rows
        words[Word.UNSETTLED] = 0
        last = float(times[-1])
        limit = last if t_limit is None else max(t_limit, last)
        try:
            result = self._run(data_of(times), rows, (data_of(out_y), data_of(out_yp), limit))
        except KeyboardInterrupt:
            return RunResult(int(words[Word.ROWS]), Status.INTERRUPTED)
        finally:
            words[Word.STOP] = 0
            if words[Word.UNSETTLED]:
                self._settle(times, out_y, out_yp)
        status, failure = result
        return RunResult(int(words[Word.ROWS]), status, failure)

    def _settle(self, times: Array, out_y: Array, out_yp: Array) -> None:
        """Mend rows whose interpolated values were too far from a solution.

        Where an algebraic unknown jumps, the polynomial through the steps says nothing about it.
        The rows beside it, or the end of the step, are better guesses.
        """
        count = int(self._frame.words[Word.UNSETTLED])
        filled = int(self._frame.words[Word.ROWS])
        wanted = np.arange(filled)
        if count <= len(self._unsettled):
            wanted = wanted[np.isin(times[:filled], self._unsettled[:count])]
        algebraic = self._states == 0.0
        for k in wanted.tolist():
            t = float(times[k])
            if t == self.t:
                continue
            guesses = [out_y[k], *(out_y[i] for i in (k - 1, k + 1) if 0 <= i < filled), self.y]
            for guess in guesses:
                y, yp = out_y[k].copy(), out_yp[k].copy()
                y[algebraic] = guess[algebraic]
                if self.consistent(t, y, yp) >= 0:
                    out_y[k], out_yp[k] = y, yp
                    break

    def advance(self, t_limit: float) -> StepResult:
        """Integrate to a time without any output; see the protocol."""
        words, row = self._frame.words, self._row
        words[Word.ROWS], words[Word.ROWS_WANTED] = 0, 1
        row[0] = t_limit
        try:
            status, failure = self._run(self._row_address, 1, (*self._row_outputs, t_limit))
        except KeyboardInterrupt:
            return StepResult(self.t, Status.INTERRUPTED)
        finally:
            words[Word.STOP] = 0
        return StepResult(self.t, status, failure)

    def _run(
        self, times: int, rows: int, outputs: tuple[int, int, float]
    ) -> tuple[Status, IntegrationError | None]:
        """Fill the rows of arrays at some addresses; tell how it ended."""
        words, pace = self._frame.words, self._pace
        progress, limit = self._options.progress, outputs[2]
        first = (self._address, times)
        begin = 1
        while True:
            before = int(words[Word.STEPS])
            words[Word.STEP_LIMIT] = before + pace.steps
            last = min(rows, int(words[Word.ROWS]) + pace.rows)
            clock = perf_counter()
            if pace.slow:
                flag = interruptible(self._loop, (*first, last, *outputs, begin), self._halt)
            else:
                flag = self._loop(*first, last, *outputs, begin)
            pace.learn(int(words[Word.STEPS]) - before, perf_counter() - clock)
            begin = 0
            if flag < 0 and not self._recover(flag, limit):
                return Status.FAILED, self._failure(flag)
            if progress is not None:
                progress(self.t)
            if flag == Code.REACHED or flag == Code.ROOT:
                return _STATUS[flag], None

    def _halt(self) -> None:
        self._frame.words[Word.STOP] = 1

    def interpolate(self, t: float, order: int = 0) -> Array:
        """Return ``y`` or ``y'`` inside the last step; see the protocol."""
        if t == self.t:
            return np.array(self.yp if order else self.y)
        self._frame.words[Word.UNSETTLED] = 0
        if self._look(self._address, t, self._vectors[2], self._vectors[5]) == 0:
            if self._frame.words[Word.UNSETTLED]:
                self._settle_at(t)
            return np.array(self._scratch_p if order else self._scratch)
        raise ValueError(f"{t} is not inside the last step, which ends at {self._end.value}")

    def _settle_at(self, t: float) -> None:
        """Mend the interpolated point, see :meth:`_settle`."""
        algebraic = self._states == 0.0
        for guess in (self._scratch, self.y):
            y, yp = self._scratch.copy(), self._scratch_p.copy()
            y[algebraic] = guess[algebraic]
            if self.consistent(t, y, yp) >= 0:
                self._scratch[:], self._scratch_p[:] = y, yp
                return

    def polynomial(self) -> StepPolynomial | None:
        """Return the polynomial of the last step; None before the first one."""
        if self._frame.words[Word.FRESH]:
            return None
        end, step, order = self._end.value, self._double("IDAGetLastStep"), c_int()
        self._c.IDAGetLastOrder(self._memory, byref(order))
        terms = np.empty((max(order.value, 1) + 1, self._n))
        factor = 1.0
        for k in range(len(terms)):
            factor *= step / k if k else 1.0
            if self._c.IDAGetDky(self._memory, end, k, self._vectors[2]):
                return None
            np.multiply(self._scratch, factor, out=terms[k])
        return StepPolynomial(end, step, terms)

    def restart(
        self, t: float, y: Array, yp: Array, problem: DAEProblem | NativeSystem | None = None
    ) -> None:
        """Go on from other values; see the protocol."""
        self.y[:] = y
        self.yp[:] = yp
        self._attempt = 0
        if self._stateless:
            self._tolerate_noise(t)
        self._start(t)
        if problem is not None:
            system = native_system(problem)
            if system.problem.n != self._n:
                raise ValueError("the new problem has another size")
            self._attach(system)
            self._consistent_point = None

    def _tolerate_noise(self, t: float) -> None:
        """Ask no unknown for more digits than time has; some change by much in nanoseconds."""
        noise = NOISE * _UNIT_ROUNDOFF * abs(t) * np.abs(self.yp)
        raised = bool((noise > self._least_tolerance).any())
        if raised or self._raised:
            np.maximum(self._least_tolerance, noise, out=self._tolerance)
            relative = float(self._frame.doubles[Word.RELATIVE])
            self._check(self._c.IDASVtolerances(self._memory, relative, self._vectors[3]))
        self._raised = raised

    def consistent(self, t: float, y: Array, yp: Array) -> int:
        """Solve for algebraic unknowns and derivatives; see the protocol."""
        if self._consistent_point is None:
            self._consistent_point = ConsistentPoint(self._system)
        return self._consistent_point.solve(t, y, yp)

    def native_point(self) -> NativePoint | None:
        """Return how native code does the same; see the protocol."""
        if self._consistent_point is None:
            self._consistent_point = ConsistentPoint(self._system)
        return self._consistent_point.native

    @property
    def statistics(self) -> Statistics:
        """What it has cost so far."""
        words, doubles = self._frame.words, self._frame.doubles
        order, step = c_int(), self._double("IDAGetLastStep")
        self._c.IDAGetLastOrder(self._memory, byref(order))
        return Statistics(
            int(words[Word.BASE_STEPS] + words[Word.STEPS]),
            int(words[Word.RESIDUAL_COUNT]),
            int(words[Word.JACOBIAN_COUNT]),
            int(words[Word.BASE_ERROR_FAILURES]) + self._count("IDAGetNumErrTestFails"),
            int(words[Word.BASE_CONVERGENCE_FAILURES])
            + self._count("IDAGetNumNonlinSolvConvFails"),
            order.value or int(words[Word.LAST_ORDER]),
            step or float(doubles[Word.LAST_STEP]),
        )

    def close(self) -> None:
        """Free SUNDIALS' memory."""
        if not self._open:
            return
        self._open = False
        self._c.IDAFree(byref(self._memory))
        self._free_matrix()
        for vector in self._vectors:
            self._c.N_VDestroy(vector)
        self._c.SUNContext_Free(byref(self._context))

    def __del__(self) -> None:
        with contextlib.suppress(Exception):
            self.close()

    def _free_matrix(self) -> None:
        if self._linear_solver:
            self._c.SUNLinSolFree(self._linear_solver)
            self._c.SUNMatDestroy(self._matrix)
        self._linear_solver = self._matrix = 0

    # --- counters

    def _count(self, name: str) -> int:
        value = c_long()
        getattr(self._c, name)(self._memory, byref(value))
        return int(value.value)

    def _double(self, name: str) -> float:
        value = c_double()
        getattr(self._c, name)(self._memory, byref(value))
        return float(value.value)

    # --- failures

    def _start(self, t: float) -> None:
        """Start at the present values of ``y`` and ``yp``."""
        self._check(self._restart(self._address, t))

    def _start_with(self, t: float, step: float) -> None:
        """Start with a first step that is given."""
        self._start(t)
        self._frame.words[Word.FRESH] = 0
        self._c.IDASetInitStep(self._memory, step)

    def _recover(self, flag: int, t_limit: float) -> bool:
        """Start anew at order 1 with a small step where a step has failed.

        A jump in the equations (a source that switches, an idealised friction) leaves the
        history of the method useless; from the last good point it can go on. At the initial time,
        the first step that IDA chooses can be too large by many orders of magnitude.

        Returns:
            Whether it is worth trying again.
        """
        recoverable = (
            c.IDA_ERR_FAIL,
            c.IDA_CONV_FAIL,
            c.IDA_REP_RES_ERR,
            c.IDA_FIRST_RES_FAIL,
            c.IDA_LSETUP_FAIL,
            c.IDA_LSOLVE_FAIL,
        )
        if flag not in recoverable or self._frame.words[Word.STOP]:
            return False
        words, doubles = self._frame.words, self._frame.doubles
        steps, t = int(words[Word.STEPS]), self._end.value
        start = float(doubles[Word.START_TIME])
        if steps >= FORGET and t - start > FORGET_FRACTION * (t_limit - start):
            self._attempt = 0
        if self._attempt >= len(LADDER):
            return False
        self._failed_step = self._double("IDAGetCurrentStep")
        fraction, compute = LADDER[self._attempt]
        self._attempt += 1
        if steps > 0:
            y, yp = self._vectors[:2]
            if self._c.IDAGetDky(self._memory, t, 0, y) or self._c.IDAGetDky(
                self._memory, t, 1, yp
            ):
                return False
        else:
            self.y[:] = self._start_y
            self.yp[:] = self._start_yp
        smallest = 16.0 * _UNIT_ROUNDOFF * max(abs(t), abs(t_limit) * 1e-3)
        step = max(fraction * (t_limit - t), smallest)
        if not t + step <= t_limit:
            return False
        self._start_with(t, step)
        if compute:
            self._compute_consistent(t, step)
        return True

    def _compute_consistent(self, t: float, step: float) -> None:
        """Solve for the algebraic unknowns and the derivatives of the states."""
        lib, memory, (y, yp) = self._c, self._memory, self._vectors[:2]
        if lib.IDACalcIC(memory, c.IDA_YA_YDP_INIT, t + step) == c.IDA_SUCCESS:
            lib.IDAGetConsistentIC(memory, y, yp)
        else:
            self.y[:] = self._start_y
            self.yp[:] = self._start_yp
        self._start_with(t, step)

    def _too_many_steps(self) -> IntegrationError:
        failure = Failure(Reason.TOO_MANY_STEPS, self.t, self._double("IDAGetLastStep"))
        return integration_error(
            failure, self._options.labels, (f"limit: {self._options.max_steps} steps",)
        )

    def _failure(self, flag: int) -> IntegrationError:
        """Find out why IDA gave up."""
        if flag == Code.TOO_MANY_STEPS:
            return self._too_many_steps()
        if flag == Code.STANDING:
            flag = c.IDA_ERR_FAIL
        words, labels = self._frame.words, self._options.labels
        t = self.t
        step = self._double("IDAGetCurrentStep")
        bad_time = float(self._frame.doubles[Word.NOT_FINITE_TIME])
        near = 2.0 * abs(step) + 1e-12 * abs(t)
        finite = not words[Word.NOT_FINITE_COUNT] or abs(bad_time - t) > near
        if flag in (c.IDA_REP_RES_ERR, c.IDA_FIRST_RES_FAIL) or not finite:
            row = int(words[Word.NOT_FINITE_ROW])
            rows = (row,) if row >= 0 else not_finite_rows(self._system, t, self.y, self.yp)
            return integration_error(Failure(Reason.NOT_FINITE, t, step, (), rows), labels)
        singular = self._count("IDAGetLastLinFlag") > 0
        if singular or flag in (c.IDA_LSETUP_FAIL, c.IDA_LSOLVE_FAIL, c.IDA_CONV_FAIL):
            cj = 1.0 / step if step > 0.0 else 0.0
            unknowns, rows = singular_parts(self._system, t, cj, self.y, self.yp)
            if singular or unknowns or rows:
                failure = Failure(Reason.SINGULAR, t, step, unknowns, rows)
                return integration_error(failure, labels)
        reasons = {c.IDA_ERR_FAIL: Reason.ERROR_TEST, c.IDA_CONV_FAIL: Reason.CONVERGENCE}
        reason = reasons.get(flag, Reason.OTHER)
        notes = (f"SUNDIALS returned {flag}",) if reason is Reason.OTHER else ()
        failure = Failure(reason, t, step, self._worst_unknowns(reason))
        return integration_error(failure, labels, notes)

    def _worst_unknowns(self, reason: Reason) -> tuple[int, ...]:
        """Return the unknowns with the largest estimated error relative to the tolerance."""
        if self._c.IDAGetErrWeights(self._memory, self._vectors[2]):
            return ()
        weights = self._scratch.copy()
        if self._c.IDAGetEstLocalErrors(self._memory, self._vectors[2]):
            return ()
        errors = self._scratch * weights
        problem = self._system.problem
        if reason is Reason.ERROR_TEST and suppressing(self._options, problem):
            errors = np.where(problem.differential, errors, 0.0)
        return largest(errors)
