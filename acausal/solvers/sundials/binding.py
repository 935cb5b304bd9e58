"""The ctypes prototypes of the SUNDIALS functions in use, for versions 6 and 7.

``sunindextype`` arguments are passed as 64-bit integers whatever the library's width: in the
calling conventions of x86-64 and arm64 a function with 32-bit indices reads the lower half.
"""

from __future__ import annotations

import ctypes
import functools
from ctypes import POINTER, byref, c_double, c_int, c_int64, c_long, c_void_p
from typing import Any

from acausal.diagnostics import fail
from acausal.solvers.sundials.locate import VARIABLE, Sundials, load

IDA_NORMAL, IDA_ONE_STEP = 1, 2
IDA_SUCCESS, IDA_TSTOP_RETURN = 0, 1
IDA_TOO_MUCH_WORK = -1
IDA_TOO_MUCH_ACC = -2
IDA_ERR_FAIL = -3
IDA_CONV_FAIL = -4
IDA_LINIT_FAIL = -5
IDA_LSETUP_FAIL = -6
IDA_LSOLVE_FAIL = -7
IDA_RES_FAIL = -8
IDA_REP_RES_ERR = -9
IDA_FIRST_RES_FAIL = -12
IDA_LINESEARCH_FAIL = -13
IDA_MEM_FAIL = -21
IDA_ILL_INPUT = -22
IDA_YA_YDP_INIT = 1

CSC_MATRIX = 0
KLU_AMD = 0
KLU_REINIT_PARTIAL = 2

_P = c_void_p
_I = c_int64
_D = c_double
_N = c_int

#: name -> (result, arguments, component that must be loaded)
_PROTOTYPES: dict[str, tuple[Any, tuple[Any, ...], str | None]] = {
    "SUNContext_Create": (_N, (_P, POINTER(_P)), None),
    "SUNContext_Free": (_N, (POINTER(_P),), None),
    "SUNContext_ClearErrHandlers": (_N, (_P,), None),
    "N_VMake_Serial": (_P, (_I, _P, _P), None),
    "N_VWrmsNorm": (_D, (_P, _P), None),
    "N_VWrmsNormMask": (_D, (_P, _P, _P), None),
    "N_VLinearSum": (None, (_D, _P, _D, _P, _P), None),
    "N_VProd": (None, (_P, _P, _P), None),
    "N_VDestroy": (None, (_P,), None),
    "N_VGetArrayPointer": (_P, (_P,), None),
    "SUNDenseMatrix": (_P, (_I, _I, _P), None),
    "SUNDenseMatrix_Data": (_P, (_P,), None),
    "SUNSparseMatrix": (_P, (_I, _I, _I, _N, _P), None),
    "SUNSparseFromDenseMatrix": (_P, (_P, _D, _N), None),
    "SUNSparseMatrix_IndexPointers": (_P, (_P,), None),
    "SUNSparseMatrix_IndexValues": (_P, (_P,), None),
    "SUNSparseMatrix_Data": (_P, (_P,), None),
    "SUNMatDestroy": (None, (_P,), None),
    "SUNLinSol_Dense": (_P, (_P, _P, _P), None),
    "SUNLinSol_KLU": (_P, (_P, _P, _P), "sunlinsolklu"),
    "SUNLinSol_KLUSetOrdering": (_N, (_P, _N), "sunlinsolklu"),
    "SUNLinSol_KLUReInit": (_N, (_P, _P, _I, _N), "sunlinsolklu"),
    "SUNLinSol_SuperLUMT": (_P, (_P, _P, _N, _P), "sunlinsolsuperlumt"),
    "SUNLinSol_SuperLUMTSetOrdering": (_N, (_P, _N), "sunlinsolsuperlumt"),
    "SUNLinSolSetup": (_N, (_P, _P), None),
    "SUNLinSolLastFlag": (_I, (_P,), None),
    "SUNMatZero": (_N, (_P,), None),
    "SUNLinSolSolve": (_N, (_P, _P, _P, _P, _D), None),
    "SUNLinSolFree": (_N, (_P,), None),
    "IDACreate": (_P, (_P,), None),
    "IDASetErrFile": (_N, (_P, _P), None),
    "IDAInit": (_N, (_P, _P, _D, _P, _P), None),
    "IDAReInit": (_N, (_P, _D, _P, _P), None),
    "IDASVtolerances": (_N, (_P, _D, _P), None),
    "IDASetUserData": (_N, (_P, _P), None),
    "IDASetId": (_N, (_P, _P), None),
    "IDASetSuppressAlg": (_N, (_P, _N), None),
    "IDASetMaxNumSteps": (_N, (_P, c_long), None),
    "IDASetMaxErrTestFails": (_N, (_P, _N), None),
    "IDASetMaxConvFails": (_N, (_P, _N), None),
    "IDASetMaxNonlinIters": (_N, (_P, _N), None),
    "IDASetMaxOrd": (_N, (_P, _N), None),
    "IDASetMaxStep": (_N, (_P, _D), None),
    "IDASetInitStep": (_N, (_P, _D), None),
    "IDASetStopTime": (_N, (_P, _D), None),
    "IDASetLinearSolver": (_N, (_P, _P, _P), None),
    "IDASetJacFn": (_N, (_P, _P), None),
    "IDASolve": (_N, (_P, _D, POINTER(_D), _P, _P, _N), None),
    "IDACalcIC": (_N, (_P, _N, _D), None),
    "IDAGetConsistentIC": (_N, (_P, _P, _P), None),
    "IDAGetDky": (_N, (_P, _D, _N, _P), None),
    "IDAGetNumSteps": (_N, (_P, POINTER(c_long)), None),
    "IDAGetNumErrTestFails": (_N, (_P, POINTER(c_long)), None),
    "IDAGetNumNonlinSolvIters": (_N, (_P, POINTER(c_long)), None),
    "IDAGetNumNonlinSolvConvFails": (_N, (_P, POINTER(c_long)), None),
    "IDAGetNumLinSolvSetups": (_N, (_P, POINTER(c_long)), None),
    "IDAGetLastOrder": (_N, (_P, POINTER(_N)), None),
    "IDAGetLastStep": (_N, (_P, POINTER(_D)), None),
    "IDAGetCurrentStep": (_N, (_P, POINTER(_D)), None),
    "IDAGetCurrentTime": (_N, (_P, POINTER(_D)), None),
    "IDAGetCurrentCj": (_N, (_P, POINTER(_D)), None),
    "IDAGetLastLinFlag": (_N, (_P, POINTER(c_long)), None),
    "IDAGetErrWeights": (_N, (_P, _P), None),
    "IDAGetEstLocalErrors": (_N, (_P, _P), None),
    "IDAFree": (None, (POINTER(_P),), None),
}


class Binding:
    """SUNDIALS' functions as attributes, e.g. ``binding.IDASolve``, each prepared once."""

    def __init__(self, sundials: Sundials) -> None:
        """Ask the library for the width of its indices.

        Raises:
            AcausalError: R101 if the library does not use double precision and 32-bit or
                64-bit indices.
        """
        self.sundials = sundials
        sundials.index_bytes = self.index_bytes = self._index_bytes()

    def __getattr__(self, name: str) -> Any:
        result, arguments, part = _PROTOTYPES[name]
        function: Any = self.sundials.function(name, part)
        function.restype = result
        function.argtypes = arguments
        setattr(self, name, function)
        return function

    def address(self, name: str) -> int:
        """Return a function's address."""
        return int(ctypes.cast(getattr(self, name), c_void_p).value or 0)

    def context(self) -> c_void_p:
        """Make a SUNContext that prints nothing; free it with ``SUNContext_Free``."""
        context = c_void_p()
        # The communicator is a null pointer in 6.x and the int 0 (SUN_COMM_NULL) in 7.x.
        if self.SUNContext_Create(None, byref(context)) != 0:
            fail("R101", "SUNDIALS cannot make a context")
        if self.sundials.version >= (7, 0, 0):
            self.SUNContext_ClearErrHandlers(context)
        return context

    def sparse_solver(self, vector: int, matrix: int, context: c_void_p) -> int:
        """Make the sparse direct linear solver that this SUNDIALS has."""
        if self.sundials.location.sparse == "klu":
            solver = int(self.SUNLinSol_KLU(vector, matrix, context) or 0)
            if solver:
                self.SUNLinSol_KLUSetOrdering(solver, KLU_AMD)
            return solver
        return int(self.SUNLinSol_SuperLUMT(vector, matrix, 1, context) or 0)

    @property
    def keeps_pivots(self) -> bool:
        """Whether the sparse linear solver is KLU, which keeps its pivots."""
        return self.sundials.location.sparse == "klu"

    def _index_bytes(self) -> int:
        """Find the width of ``sunindextype`` from the column pointers of a unit matrix."""
        context = self.context()
        dense = self.SUNDenseMatrix(2, 2, context)
        data = (c_double * 4).from_address(self.SUNDenseMatrix_Data(dense))
        data[:] = [1.0, 0.0, 0.0, 1.0]
        sparse = self.SUNSparseFromDenseMatrix(dense, 0.0, CSC_MATRIX)
        words = list((c_int * 3).from_address(self.SUNSparseMatrix_IndexPointers(sparse)))
        self.SUNMatDestroy(sparse)
        self.SUNMatDestroy(dense)
        self.SUNContext_Free(byref(context))
        width = {(0, 1, 2): 4, (0, 0, 1): 8}.get((words[0], words[1], words[2]), 0)
        if width == 0:
            fail(
                "R101",
                f"the index width of the SUNDIALS in {self.sundials.location.folder} is unknown",
                help=f"it must use double precision; set {VARIABLE} to another source",
            )
        return width


@functools.cache
def bind(wanted: str | None = None) -> Binding:
    """Load SUNDIALS and prepare its functions, once per process.

    Args:
        wanted: Source name or folder, None for the best.

    Raises:
        AcausalError: R101 if there is no usable SUNDIALS.
    """
    return Binding(load(wanted))
