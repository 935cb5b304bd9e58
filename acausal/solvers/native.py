"""Native callbacks between SUNDIALS and the kernels, and the native output loop.

SUNDIALS calls with N_Vectors and matrices, kernels want arrays. The functions here convert,
count, look for numbers that are not finite, and obey a stop flag, all without Python. Their
user data is a :class:`Frame`, an array of 64-bit words; addresses are read from it, so
that the code is the same for every problem, process and library, and can be cached.
"""

from __future__ import annotations

import functools
from enum import IntEnum, auto
from hashlib import blake2b
from typing import Final

import numpy as np
from numpy.typing import NDArray

from acausal.solvers.sundials.binding import KLU_REINIT_PARTIAL

#: An interpolated point is good when its last correction was so small, in tolerances.
NEWTON_LIMIT: Final = 0.1
NEWTON_ITERATIONS: Final = 4


class Word(IntEnum):
    """Positions in a frame."""

    STOP = 0  #: not zero: every callback returns an unrecoverable error
    RESIDUAL = auto()  #: ``i32 (double t, double* y, double* yp, double* out, void* table)``
    JACOBIAN = auto()  #: ``i32 (double t, double cj, double* y, double* yp, double* out, void*)``
    TABLE = auto()  #: last argument of both
    N = auto()
    NNZ = auto()
    INDPTR = auto()  #: column pointers, in the library's index width
    INDICES = auto()  #: row indices, in the library's index width
    POSITIONS = auto()  #: position of each entry in a dense column-major matrix, int64
    VALUES = auto()  #: scratch for ``nnz`` values, dense matrices only
    RESIDUAL_COUNT = auto()
    JACOBIAN_COUNT = auto()
    NOT_FINITE_COUNT = auto()
    NOT_FINITE_TIME = auto()  #: time of the last such evaluation, a double
    NOT_FINITE_ROW = auto()  #: first such row of the last such residual, -1 for a Jacobian
    VECTOR_DATA = auto()  #: N_VGetArrayPointer
    DENSE_DATA = auto()  #: SUNDenseMatrix_Data
    SPARSE_DATA = auto()  #: SUNSparseMatrix_Data
    SPARSE_INDPTR = auto()  #: SUNSparseMatrix_IndexPointers
    SPARSE_INDICES = auto()  #: SUNSparseMatrix_IndexValues
    SOLVE = auto()  #: IDASolve
    MEMORY = auto()  #: IDA's memory
    Y_VECTOR = auto()
    YP_VECTOR = auto()
    Y = auto()  #: data of the vectors
    YP = auto()
    REACHED = auto()  #: time of the present point, a double
    END = auto()  #: end of the last step, a double
    KNOWN = auto()  #: the output loop may fill rows up to this time, a double
    STEP_COUNT = auto()  #: IDAGetNumSteps
    STEPS = auto()  #: steps so far, since the last restart
    STEP_LIMIT = auto()  #: the output loop pauses when there are so many
    ROWS = auto()  #: output rows filled
    CONSISTENT = auto()  #: not zero: make interpolated points solve the equations
    GET_CJ = auto()  #: IDAGetCurrentCj
    GET_WEIGHTS = auto()  #: IDAGetErrWeights
    INTERPOLATE = auto()  #: IDAGetDky
    SOLVE_LINEAR = auto()  #: SUNLinSolSolve
    LINEAR_SOLVER = auto()
    MATRIX = auto()
    SETUP_LINEAR = auto()  #: SUNLinSolSetup
    LINEAR_FLAG = auto()  #: SUNLinSolLastFlag
    NEW_PIVOTS = auto()  #: SUNLinSol_KLUReInit, 0 for another linear solver
    MATRIX_ZERO = auto()  #: SUNMatZero
    JACOBIAN_CALLBACK = auto()  #: IDA's Jacobian callback for the matrix in use
    NORM = auto()  #: N_VWrmsNorm
    LINEAR_SUM = auto()  #: N_VLinearSum
    PRODUCT = auto()  #: N_VProd
    STATES_VECTOR = auto()  #: 1 for states, 0 for algebraic unknowns
    RESIDUAL_VECTOR = auto()
    CORRECTION_VECTOR = auto()
    WEIGHT_VECTOR = auto()
    OUTPUT_VECTOR = auto()  #: scratch for rows
    OUTPUT_VECTOR_P = auto()
    OUTPUT = auto()  #: data of these
    OUTPUT_P = auto()
    ROWS_WANTED = auto()
    PENDING = auto()  #: not zero: the present point of the output loop is a root
    ROOTS = auto()  #: ``i32 (double t, double* y, double* yp, double* g, void* table)``
    ROOT_COUNT = auto()
    G_LOW = auto()  #: values of the root functions, at the left
    G_HIGH = auto()  #: at the right
    G_MIDDLE = auto()  #: in between
    DIRECTIONS = auto()  #: int32
    FOUND = auto()  #: int32
    FRESH = auto()  #: not zero: no step since the last start, and the first is to be chosen
    START_TIME = auto()  #: of the last start, a double
    START_Y = auto()  #: data at the last start
    START_YP = auto()
    START_STEP = auto()  #: a good first step after a restart, 0 if unknown, a double
    INITIAL_STEP = auto()  #: the one asked for, else 0, a double
    MAX_STEP = auto()  #: a double
    RELATIVE = auto()  #: relative tolerance, a double
    TOLERANCE = auto()  #: data of the absolute tolerances
    STATES = auto()  #: data of ``STATES_VECTOR``
    SUPPRESSED = auto()  #: not zero: algebraic unknowns are not in the error test
    MOST_STEPS = auto()  #: in all, -1 for no limit
    STANDING = auto()  #: steps in a row that did not change the time
    BASE_STEPS = auto()  #: before the last start
    BASE_ERROR_FAILURES = auto()
    BASE_CONVERGENCE_FAILURES = auto()
    COUNTED = auto()  #: scratch
    LAST_ORDER = auto()  #: an int32
    LAST_STEP = auto()  #: a double
    SET_STOP = auto()  #: IDASetStopTime
    SET_FIRST_STEP = auto()  #: IDASetInitStep
    REINITIALISE = auto()  #: IDAReInit
    GET_LAST_STEP = auto()  #: IDAGetLastStep
    GET_LAST_ORDER = auto()  #: IDAGetLastOrder
    GET_ERRORS = auto()  #: IDAGetEstLocalErrors
    GET_ERROR_FAILURES = auto()  #: IDAGetNumErrTestFails
    GET_CONVERGENCE_FAILURES = auto()  #: IDAGetNumNonlinSolvConvFails
    MASKED_NORM = auto()  #: N_VWrmsNormMask
    CURRENT_CJ = auto()  #: dy'/dy of the method, a double
    UNSETTLED = auto()  #: number of interpolated points that do not solve the equations
    UNSETTLED_TIMES = auto()  #: data of their times, the first ``MOST_UNSETTLED``
    COUNT = auto()


class Frame:
    """User data of the callbacks: words, and views of the ones that are doubles."""

    def __init__(self) -> None:
        self.words: NDArray[np.int64] = np.zeros(Word.COUNT, dtype=np.int64)
        self.doubles: NDArray[np.float64] = self.words.view(np.float64)
        self.address = int(self.words.ctypes.data)

    def address_of(self, word: Word) -> int:
        """Return the address of one word."""
        return self.address + 8 * int(word)


def _ir() -> str:
    """Return the LLVM IR of all functions."""

    def load(name: str, word: Word, kind: str = "ptr") -> str:
        return (
            f"  %{name}_at = getelementptr i64, ptr %frame, i64 {int(word)}\n"
            f"  %{name} = load {kind}, ptr %{name}_at\n"
        )

    def count(name: str, word: Word) -> str:
        return (
            load(name, word, "i64")
            + f"  %{name}_more = add i64 %{name}, 1\n  store i64 %{name}_more, ptr %{name}_at\n"
        )

    # x * 0 is 0 for finite x, else NaN; the sum tells about all of them. Four at a time.
    finite = """
define internal i1 @all_finite(ptr %x, i64 %n) {
entry:
  %whole = and i64 %n, -4
  %some = icmp sgt i64 %whole, 0
  br i1 %some, label %four, label %middle
four:
  %i = phi i64 [0, %entry], [%i4, %four]
  %s = phi <4 x double> [zeroinitializer, %entry], [%s4, %four]
  %at = getelementptr double, ptr %x, i64 %i
  %v = load <4 x double>, ptr %at, align 8
  %z = fmul <4 x double> %v, zeroinitializer
  %s4 = fadd <4 x double> %s, %z
  %i4 = add i64 %i, 4
  %on = icmp slt i64 %i4, %whole
  br i1 %on, label %four, label %middle
middle:
  %v4 = phi <4 x double> [zeroinitializer, %entry], [%s4, %four]
  %e0 = extractelement <4 x double> %v4, i32 0
  %e1 = extractelement <4 x double> %v4, i32 1
  %e2 = extractelement <4 x double> %v4, i32 2
  %e3 = extractelement <4 x double> %v4, i32 3
  %e01 = fadd double %e0, %e1
  %e23 = fadd double %e2, %e3
  %e = fadd double %e01, %e23
  %rest = icmp slt i64 %whole, %n
  br i1 %rest, label %one, label %done
one:
  %j = phi i64 [%whole, %middle], [%j1, %one]
  %a = phi double [%e, %middle], [%a1, %one]
  %jat = getelementptr double, ptr %x, i64 %j
  %w = load double, ptr %jat
  %wz = fmul double %w, 0.0
  %a1 = fadd double %a, %wz
  %j1 = add i64 %j, 1
  %more = icmp slt i64 %j1, %n
  br i1 %more, label %one, label %done
done:
  %total = phi double [%e, %middle], [%a1, %one]
  %ok = fcmp oeq double %total, 0.0
  ret i1 %ok
}
"""
    # Return values as SUNDIALS wants them: 0 good, > 0 try a smaller step, < 0 give up.
    # A residual tells by itself that it is not finite; a Jacobian is looked through here.
    check = (
        """
define internal i32 @check(ptr %frame, double %t, ptr %x, i64 %n, i32 %flag, i1 %rows) {
  %give_up = icmp slt i32 %flag, 0
  %trusted = icmp eq i32 %flag, 0
  %skip = select i1 %trusted, i1 %rows, i1 %give_up
  br i1 %skip, label %out, label %look
look:
  %ok = call i1 @all_finite(ptr %x, i64 %n)
  br i1 %ok, label %out, label %bad
bad:
"""
        + count("bads", Word.NOT_FINITE_COUNT)
        + f"""  %time_at = getelementptr i64, ptr %frame, i64 {int(Word.NOT_FINITE_TIME)}
  store double %t, ptr %time_at
  %row_at = getelementptr i64, ptr %frame, i64 {int(Word.NOT_FINITE_ROW)}
  store i64 -1, ptr %row_at
  br i1 %rows, label %find, label %retry
find:
  %k = phi i64 [0, %bad], [%k1, %find]
  %at = getelementptr double, ptr %x, i64 %k
  %v = load double, ptr %at
  %z = fmul double %v, 0.0
  %fine = fcmp oeq double %z, 0.0
  %k1 = add i64 %k, 1
  br i1 %fine, label %find, label %found
found:
  store i64 %k, ptr %row_at
  br label %retry
retry:
  ret i32 1
out:
  ret i32 %flag
}}
"""
    )
    residual = (
        """
define i32 @ida_residual(double %t, ptr %yy, ptr %yyp, ptr %rr, ptr %frame) {
"""
        + load("stop", Word.STOP, "i64")
        + """  %halt = icmp ne i64 %stop, 0
  br i1 %halt, label %give_up, label %go
give_up:
  ret i32 -1
go:
"""
        + load("data", Word.VECTOR_DATA)
        + load("f", Word.RESIDUAL)
        + load("table", Word.TABLE)
        + load("n", Word.N, "i64")
        + count("calls", Word.RESIDUAL_COUNT)
        + """  %y = call ptr %data(ptr %yy)
  %yp = call ptr %data(ptr %yyp)
  %r = call ptr %data(ptr %rr)
  %flag = call i32 %f(double %t, ptr %y, ptr %yp, ptr %r, ptr %table)
  %result = call i32 @check(ptr %frame, double %t, ptr %r, i64 %n, i32 %flag, i1 true)
  ret i32 %result
}
"""
    )

    def jacobian(name: str, values: str, before: str, after: str) -> str:
        return (
            f"\ndefine i32 @{name}(double %t, double %cj, ptr %yy, ptr %yyp, ptr %rr, "
            "ptr %J, ptr %frame, ptr %a, ptr %b, ptr %c) {\n"
            + load("stop", Word.STOP, "i64")
            + """  %halt = icmp ne i64 %stop, 0
  br i1 %halt, label %give_up, label %go
give_up:
  ret i32 -1
go:
"""
            + load("data", Word.VECTOR_DATA)
            + load("f", Word.JACOBIAN)
            + load("table", Word.TABLE)
            + load("nnz", Word.NNZ, "i64")
            + load("n", Word.N, "i64")
            + count("calls", Word.JACOBIAN_COUNT)
            + "  %y = call ptr %data(ptr %yy)\n  %yp = call ptr %data(ptr %yyp)\n"
            + values
            + before
            + "  %flag = call i32 %f(double %t, double %cj, ptr %y, ptr %yp, ptr %x, ptr %table)\n"
            + "  %result = call i32 @check("
            "ptr %frame, double %t, ptr %x, i64 %nnz, i32 %flag, i1 false)\n" + after + "}\n"
        )

    def sparse(bits: int) -> str:
        # KLU keeps its pivots. Where one of them has become zero (beyond a kink) it fails, although
        # the matrix is regular, and would do so for ever: let it choose others the next time.
        # SUNDIALS clears the pattern together with the values: write it again.
        size = bits // 8
        before = (
            load("new_pivots", Word.NEW_PIVOTS)
            + load("last_flag", Word.LINEAR_FLAG)
            + load("solver", Word.LINEAR_SOLVER)
            + f"""  %can = icmp ne ptr %new_pivots, null
  br i1 %can, label %ask, label %write
ask:
  %last = call i32 %last_flag(ptr %solver)
  %failed = icmp ne i32 %last, 0
  br i1 %failed, label %choose, label %write
choose:
  call i32 %new_pivots(ptr %solver, ptr %J, i64 %nnz, i32 {KLU_REINIT_PARTIAL})
  br label %write
write:
"""
            + load("get_p", Word.SPARSE_INDPTR)
            + load("get_i", Word.SPARSE_INDICES)
            + load("p", Word.INDPTR)
            + load("i", Word.INDICES)
            + f"""  %to_p = call ptr %get_p(ptr %J)
  %to_i = call ptr %get_i(ptr %J)
  %n1 = add i64 %n, 1
  %p_size = mul i64 %n1, {size}
  %i_size = mul i64 %nnz, {size}
  call void @llvm.memcpy.p0.p0.i64(ptr %to_p, ptr %p, i64 %p_size, i1 false)
  call void @llvm.memcpy.p0.p0.i64(ptr %to_i, ptr %i, i64 %i_size, i1 false)
"""
        )
        values = load("get_x", Word.SPARSE_DATA) + "  %x = call ptr %get_x(ptr %J)\n"
        return jacobian(f"ida_jacobian_sparse{bits}", values, before, "  ret i32 %result\n")

    dense = jacobian(
        "ida_jacobian_dense",
        load("x", Word.VALUES),
        "",
        load("get_d", Word.DENSE_DATA)
        + load("positions", Word.POSITIONS)
        + """  %d = call ptr %get_d(ptr %J)
  %some = icmp sgt i64 %nnz, 0
  br i1 %some, label %scatter, label %done
scatter:
  %k = phi i64 [0, %go], [%k1, %scatter]
  %from = getelementptr double, ptr %x, i64 %k
  %value = load double, ptr %from
  %position_at = getelementptr i64, ptr %positions, i64 %k
  %position = load i64, ptr %position_at
  %to = getelementptr double, ptr %d, i64 %position
  store double %value, ptr %to
  %k1 = add i64 %k, 1
  %more = icmp slt i64 %k1, %nnz
  br i1 %more, label %scatter, label %done
done:
  ret i32 %result
""",
    )
    # Between the steps IDA interpolates. Nothing controls that error in algebraic unknowns that
    # the error test leaves out, so that y = log(x) may be far off where x is nearly linear. A
    # simplified Newton iteration with the matrix that IDA has factorised last puts the point
    # back on the equations; it moves the states by about the tolerance or less. If that matrix is
    # too old to converge, it is renewed at this point; IDA goes on with the newer one.
    consistent = (
        """
define i32 @consistent(ptr %frame, double %t, ptr %yy, ptr %yyp) {
entry:
"""
        + load("memory", Word.MEMORY)
        + load("n", Word.N, "i64")
        + load("f", Word.RESIDUAL)
        + load("table", Word.TABLE)
        + load("data", Word.VECTOR_DATA)
        + load("solve", Word.SOLVE_LINEAR)
        + load("solver", Word.LINEAR_SOLVER)
        + load("matrix", Word.MATRIX)
        + load("norm", Word.NORM)
        + load("sum", Word.LINEAR_SUM)
        + load("product", Word.PRODUCT)
        + load("states", Word.STATES_VECTOR)
        + load("rr", Word.RESIDUAL_VECTOR)
        + load("dd", Word.CORRECTION_VECTOR)
        + load("ww", Word.WEIGHT_VECTOR)
        + load("get_weights", Word.GET_WEIGHTS)
        + load("get_cj", Word.GET_CJ)
        + load("interpolate", Word.INTERPOLATE)
        + load("setup", Word.SETUP_LINEAR)
        + load("zero", Word.MATRIX_ZERO)
        + load("jacobian", Word.JACOBIAN_CALLBACK)
        + f"""  %cj_at = getelementptr i64, ptr %frame, i64 {int(Word.CURRENT_CJ)}
  call i32 %get_cj(ptr %memory, ptr %cj_at)
  call i32 %get_weights(ptr %memory, ptr %ww)
  %cj = load double, ptr %cj_at
  %minus_cj = fneg double %cj
  %y = call ptr %data(ptr %yy)
  %yp = call ptr %data(ptr %yyp)
  %r = call ptr %data(ptr %rr)
  br label %iterate
iterate:
  %k = phi i32 [0, %entry], [%k1, %again], [0, %renewed]
  %last = phi double [0x7FF0000000000000, %entry], [%size, %again], [0x7FF0000000000000, %renewed]
  %renewals = phi i32 [0, %entry], [%renewals, %again], [1, %renewed]
"""
        + count("calls", Word.RESIDUAL_COUNT)
        + f"""  %flag = call i32 %f(double %t, ptr %y, ptr %yp, ptr %r, ptr %table)
  %good = icmp eq i32 %flag, 0
  br i1 %good, label %correct, label %back
correct:
  %solved = call i32 %solve(ptr %solver, ptr %matrix, ptr %dd, ptr %rr, double 0.0)
  %fine = icmp eq i32 %solved, 0
  br i1 %fine, label %measure, label %back
measure:
  %size = call double %norm(ptr %dd, ptr %ww)
  %limit = fmul double %last, 0.9
  %smaller = fcmp olt double %size, %limit
  br i1 %smaller, label %apply, label %back
apply:
  call void %sum(double 1.0, ptr %yy, double -1.0, ptr %dd, ptr %yy)
  call void %product(ptr %dd, ptr %states, ptr %dd)
  call void %sum(double 1.0, ptr %yyp, double %minus_cj, ptr %dd, ptr %yyp)
  %k1 = add i32 %k, 1
  %enough = fcmp olt double %size, {NEWTON_LIMIT:e}
  br i1 %enough, label %done, label %again
again:
  %more = icmp slt i32 %k1, {NEWTON_ITERATIONS}
  br i1 %more, label %iterate, label %back
back:
  call i32 %interpolate(ptr %memory, double %t, i32 0, ptr %yy)
  call i32 %interpolate(ptr %memory, double %t, i32 1, ptr %yyp)
  %old = icmp eq i32 %renewals, 0
  br i1 %old, label %renew, label %give_up
renew:
  call i32 %zero(ptr %matrix)
  %evaluated = call i32 %jacobian(double %t, double %cj, ptr %yy, ptr %yyp, ptr %rr, ptr %matrix,
       ptr %frame, ptr null, ptr null, ptr null)
  %set = call i32 %setup(ptr %solver, ptr %matrix)
  %failed = or i32 %evaluated, %set
  %ready = icmp eq i32 %failed, 0
  br i1 %ready, label %renewed, label %give_up
renewed:
  br label %iterate
give_up:
  ret i32 1
done:
  ret i32 0
}}
"""
    )
    return finite + check + residual + sparse(32) + sparse(64) + dense + consistent


_CACHE_KIND: Final = "solver"

NAMES = (
    "ida_residual",
    "ida_jacobian_sparse32",
    "ida_jacobian_sparse64",
    "ida_jacobian_dense",
    "consistent",
    "look",
    "advance",
    "output_loop",
    "restart",
)


@functools.cache
def addresses() -> dict[str, int]:
    """Compile the functions (or take them from the disk cache); return addresses by name."""
    from acausal.codegen import engine, writer
    from acausal.solvers import native_step
    from acausal.storage import cache_directory

    text = writer.DECLARATIONS + _ir() + native_step.functions()
    key = blake2b(f"{engine.target_identity()}\n{text}".encode(), digest_size=16).hexdigest()
    code = cache_directory.read(_CACHE_KIND, key)
    if code is None:
        code = engine.compile_object(text, level=2, passes=True)
        cache_directory.write(_CACHE_KIND, key, code)
    engine.load_objects([code])
    return {name: engine.address_of(name) for name in NAMES}
