"""What the simulation knows of an integrator, and nothing else.

The simulation never asks which integrator it has. :func:`create` is the only place with names.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import fail

if TYPE_CHECKING:
    from acausal.assembly.problem import DAEProblem
    from acausal.solvers.consistent_point import NativePoint
    from acausal.solvers.failures import IntegrationError
    from acausal.solvers.system import NativeSystem

Array = NDArray[np.float64]


class Status(Enum):
    """How a call ended."""

    STEPPED = "stepped"
    REACHED = "reached"
    ROOT = "root"
    FAILED = "failed"
    INTERRUPTED = "interrupted"


@dataclass(frozen=True, slots=True)
class StepResult:
    """One internal step.

    Attributes:
        t: Time reached, seconds.
        status: STEPPED, REACHED (``t`` is the limit), ROOT (see :class:`Integrator`; also where
            the root is at the limit) or FAILED (``t`` is unchanged).
        failure: Why it failed; the caller decides whether to raise it.
    """

    t: float
    status: Status
    failure: IntegrationError | None = None


@dataclass(frozen=True, slots=True)
class RunResult:
    """A run over output times.

    Attributes:
        rows: Rows that were filled, counted from the first.
        status: REACHED (all of them), ROOT (all up to the time of the root), FAILED or
            INTERRUPTED (Ctrl-C).
        failure: Why it failed; the caller decides whether to raise it.
    """

    rows: int
    status: Status
    failure: IntegrationError | None = None


@dataclass(frozen=True, slots=True)
class Statistics:
    """What an integration has cost so far, restarts included; -1 where a solver does not tell."""

    steps: int = 0
    residual_evaluations: int = 0
    jacobian_evaluations: int = 0
    error_test_failures: int = 0
    convergence_failures: int = 0
    last_order: int = 0
    last_step: float = 0.0


class Labels(Protocol):
    """Names for messages about unknowns and rows."""

    def unknown(self, index: int) -> str:
        """Return the path of the unknown ``y[index]``."""

    def row(self, index: int) -> str:
        """Return the equation of row ``index`` in the user's words."""


@dataclass(frozen=True)
class NumberLabels:
    """Labels for problems without names."""

    def unknown(self, index: int) -> str:
        """Return ``y[index]``."""
        return f"y[{index}]"

    def row(self, index: int) -> str:
        """Return ``equation index``, counted from 1."""
        return f"equation {index + 1}"


@dataclass(frozen=True)
class Options:
    """Settings of an integration.

    Attributes:
        relative_tolerance: Per step and unknown.
        absolute_tolerance: Per step, times the problem's nominal values.
        max_step: Largest step, seconds.
        initial_step: First step, seconds; None leaves it to the integrator.
        max_steps: Largest number of internal steps in total; None for no limit.
        suppress_algebraic: Leave algebraic unknowns out of the error test (not out of the
            equations). They follow from the states, and a jump in them is no error.
        linear_solver: ``auto``, ``dense``, or ``sparse`` (banded where the integrator has
            no sparse one).
        progress: Called with the time reached, from time to time, during a run.
        labels: Names for messages.
    """

    relative_tolerance: float = 1e-6
    absolute_tolerance: float = 1e-6
    max_step: float = float("inf")
    initial_step: float | None = None
    max_steps: int | None = None
    suppress_algebraic: bool = True
    linear_solver: str = "auto"
    progress: Callable[[float], None] | None = None
    labels: Labels = NumberLabels()


class Integrator(Protocol):
    """An initial value problem on its way.

    Root functions (``DAEProblem.roots``) are looked at after every internal step. Where one has
    changed its sign, the first such time in the step is located and the call ends with the
    status ROOT: ``t``, ``y`` and ``yp`` are those at the end of an interval of a few units of
    roundoff that holds the root, so the functions found have their new sign there (or are zero).
    A root at ``t_limit`` is reported as ROOT. At the start of every call the functions are
    evaluated anew at ``t``; so shifts and directions may be changed between any two calls, and
    after a ROOT the integration may go on by ``step`` or ``run`` without a restart where nothing
    else has changed. A function that is exactly zero at the start of a step is not looked at in
    that step: keep it away from zero by its shift. A function that is not finite at the end of a
    step has no sign, and no root in that step.
    """

    @property
    def t(self) -> float:
        """Time of :attr:`y` and :attr:`yp`, seconds."""

    @property
    def y(self) -> Array:
        """Unknowns at :attr:`t`, shape ``(n,)``; a view that the next call changes."""

    @property
    def yp(self) -> Array:
        """Derivatives at :attr:`t`, shape ``(n,)``; a view that the next call changes.

        Entries of algebraic unknowns mean nothing.
        """

    def step(self, t_limit: float) -> StepResult:
        """Take one internal step, never past ``t_limit``, which lies ahead of ``t``."""

    def run(
        self, times: Array, out_y: Array, out_yp: Array, t_limit: float | None = None
    ) -> RunResult:
        """Integrate to the last of ``times`` and fill one row for each of them.

        Args:
            times: Output times, increasing, the first not before ``t``, shape ``(k,)``.
            out_y: Receives the unknowns, C-contiguous, shape ``(k, n)``.
            out_yp: Receives the derivatives, likewise.
            t_limit: How far the integrator may look ahead; ``times[-1]`` if None. A later
                limit spares the steps that would end exactly at ``times[-1]``.
        """

    def advance(self, t_limit: float) -> StepResult:
        """Integrate to a time without output: REACHED, ROOT, FAILED or INTERRUPTED."""

    def interpolate(self, t: float, order: int = 0) -> Array:
        """Return ``y`` (order 0) or ``y'`` (order 1) at a time inside the last step."""

    def restart(
        self, t: float, y: Array, yp: Array, problem: DAEProblem | NativeSystem | None = None
    ) -> None:
        """Go on from other, consistent values.

        Args:
            t: Time, seconds.
            y: Unknowns, shape ``(n,)``.
            yp: Derivatives, shape ``(n,)``.
            problem: Another problem of the same size (other states), None for the same.
        """

    @property
    def roots_found(self) -> NDArray[np.int32]:
        """Which functions changed their sign, shape ``(roots.n,)``; valid after a ROOT.

        +1 where it rises, -1 where it falls, 0 elsewhere. A view that the next call changes.
        """

    def set_root_directions(self, directions: NDArray[np.int32]) -> None:
        """Look for rising roots (+1), falling ones (-1) or both (0, the default) from now on.

        Args:
            directions: One for each root function, shape ``(roots.n,)``; copied.
        """

    def consistent(self, t: float, y: Array, yp: Array) -> int:
        """Solve F(t, y, y') = 0 for algebraic unknowns and derivatives of differential ones.

        The differential unknowns stay as they are. Full Newton steps from the given values, which
        have to be near: this is for the restart after an event.

        Args:
            t: Time, seconds.
            y: Unknowns, float64, shape ``(n,)``; the algebraic ones are replaced.
            yp: Derivatives, float64, shape ``(n,)``; those of differential unknowns are
                replaced.

        Returns:
            Newton iterations, or -1 where the matrix is singular, a value is not finite or the
            iteration does not converge; ``y`` and ``yp`` are unchanged then.
        """

    def native_point(self) -> NativePoint | None:
        """Return how native code does what :meth:`consistent` does, None if it cannot."""

    @property
    def statistics(self) -> Statistics:
        """What it has cost so far."""

    def close(self) -> None:
        """Free everything; no other call may follow."""


#: Names of the integrators, best first.
SOLVERS = ("ida", "odes-ida", "odes-cvode", "radau")


def create(
    name: str,
    problem: DAEProblem | NativeSystem,
    t: float,
    y: Array,
    yp: Array,
    options: Options | None = None,
) -> Integrator:
    """Return an integrator at a consistent point.

    Args:
        name: One of :data:`SOLVERS`.
        problem: The system, or its kernels made callable already.
        t: Initial time, seconds.
        y: Unknowns, shape ``(n,)``; copied.
        yp: Derivatives, shape ``(n,)``; copied.
        options: Settings.

    Raises:
        AcausalError: R100 for an unknown name, R101 or R102 if the solver is not installed.
    """
    from acausal.solvers.system import native_system, problem_size

    options = options or Options()
    if name not in SOLVERS:
        fail("R100", f"there is no solver {name!r}", help="choose one of " + ", ".join(SOLVERS))
    if problem_size(problem) == 0:
        from acausal.solvers.trivial import TrivialIntegrator

        return TrivialIntegrator(native_system(problem), t, options)
    system = native_system(problem)
    if name == "ida":
        from acausal.solvers.ida import IDAIntegrator

        return IDAIntegrator(system, t, y, yp, options)
    if name == "odes-ida":
        from acausal.solvers.odes_ida import OdesIDAIntegrator

        return OdesIDAIntegrator(system, t, y, yp, options)
    if name == "odes-cvode":
        from acausal.solvers.odes_cvode import OdesCVODEIntegrator

        return OdesCVODEIntegrator(system, t, y, yp, options)
    from acausal.solvers.radau import RadauIntegrator

    return RadauIntegrator(system, t, y, yp, options)
