"""A problem with its kernels made callable: what the integrators need, and no more."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, cast

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from acausal.assembly.problem import DAEProblem

Array = NDArray[np.float64]


class Pattern(Protocol):
    """The part of a :class:`~acausal.assembly.problem.DAEProblem` that integrators read."""

    @property
    def n(self) -> int:
        """Number of unknowns and rows."""

    @property
    def nnz(self) -> int:
        """Number of structurally non-zero entries of the Jacobian."""

    @property
    def indptr(self) -> NDArray[np.int64]:
        """Column pointers, shape ``(n+1,)``."""

    @property
    def indices(self) -> NDArray[np.int32]:
        """Row indices, shape ``(nnz,)``."""

    @property
    def differential(self) -> NDArray[np.bool_]:
        """Which unknowns have a derivative, shape ``(n,)``."""

    @property
    def nominal(self) -> Array:
        """Magnitudes of the unknowns, shape ``(n,)``."""


class NativeSystem(Protocol):
    """Residual and Jacobian of a problem, as C functions and as Python functions.

    The C functions, whose last argument is :attr:`table_address`, return 0, a positive number
    (try another step; a residual does so when a value is not finite) or a negative one (give
    up)::

        int residual(double t, const double* y, const double* yp, double* out, void* table)
        int jacobian(double t, double cj, const double* y, const double* yp, double* out, void*)
        int restart_jacobian(double t, const double* y, const double* yp, double* out, void*)
        int roots(double t, const double* y, const double* yp, double* out, void* table)

    The Jacobian is dF/dy + cj dF/dy', as CSC values.
    """

    @property
    def problem(self) -> Pattern:
        """Size, pattern, mask of the differential unknowns, nominal values."""

    @property
    def residual_address(self) -> int:
        """Address of the C function ``residual``."""

    @property
    def jacobian_address(self) -> int:
        """Address of the C function ``jacobian``."""

    @property
    def table_address(self) -> int:
        """Last argument of all."""

    @property
    def restart_jacobian_address(self) -> int:
        """Address of the C function ``restart_jacobian``, or 0.

        Its matrix is dF/dy' in the columns of differential unknowns and dF/dy in the others.
        """

    @property
    def root_count(self) -> int:
        """Number of root functions."""

    @property
    def roots_address(self) -> int:
        """Address of the C function ``roots``; of no meaning if there are none."""

    def roots(self, t: float, y: Array, yp: Array, out: Array) -> object:
        """Write g(t, y, y') to ``out``, shape ``(root_count,)``."""

    def residual(self, t: float, y: Array, yp: Array, out: Array) -> object:
        """Write F(t, y, y') to ``out``, shape ``(n,)``."""

    def jacobian_values(self, t: float, cj: float, y: Array, yp: Array, out: Array) -> object:
        """Write dF/dy + cj dF/dy' to ``out``, shape ``(nnz,)``."""

    def partial_values(self) -> tuple[Array, Array]:
        """Return dF/dy and dF/dy' of the last ``jacobian_values``, each of shape ``(nnz,)``."""


def native_system(problem: DAEProblem | NativeSystem) -> NativeSystem:
    """Make a problem callable, unless it is already."""
    if hasattr(problem, "residual_address"):
        return cast(NativeSystem, problem)
    from acausal.codegen.driver import NativeProblem

    return cast(NativeSystem, NativeProblem(problem))


def problem_size(problem: DAEProblem | NativeSystem) -> int:
    """Return the number of unknowns."""
    inner = getattr(problem, "problem", problem)
    return int(cast(Pattern, inner).n)
