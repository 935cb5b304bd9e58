"""SciPy's Radau IIA method of order 5 on the explicit form.

Source of the method: Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.8.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from acausal.solvers.explicit_form import ExplicitForm
from acausal.solvers.failures import Failure, IntegrationError, Reason, integration_error
from acausal.solvers.protocol import Options, RunResult, Statistics, Status, StepResult
from acausal.solvers.stepping import advance_by_run, run_by_steps
from acausal.solvers.system import NativeSystem, native_system
from acausal.solvers.watching import Watch, Watching

if TYPE_CHECKING:
    from acausal.assembly.problem import DAEProblem

Array = NDArray[np.float64]


class RadauIntegrator(Watching):
    """The integrator ``radau``; see :class:`acausal.solvers.protocol.Integrator`."""

    def __init__(
        self, system: NativeSystem, t: float, y: Array, yp: Array, options: Options
    ) -> None:
        """Prepare an integration from a consistent point."""
        self._options = options
        self._base = Statistics()
        self._steps = 0
        self._watch = Watch(system)
        self._start(system, t, y, yp)

    def _start(self, system: NativeSystem, t: float, y: Array, yp: Array) -> None:
        options = self._options
        self._system = system
        self.y = np.array(y, dtype=np.float64)
        self.yp = np.array(yp, dtype=np.float64)
        self._t = self._t_step = t
        self._form = ExplicitForm(
            system,
            t,
            y,
            yp,
            options.relative_tolerance,
            options.absolute_tolerance,
            options.labels,
        )
        self._refused: IntegrationError | None = None
        self._dense: Any = None
        self._solver: Any = None

    def _make_solver(self, t_limit: float) -> Any:
        from scipy.integrate import Radau

        options, form = self._options, self._form
        # SciPy takes one tolerance per state, which its type hints do not know.
        tolerances: Any = form.absolute_tolerances(options.absolute_tolerance)
        return Radau(
            self._derivative,
            self._t_step,
            form.x(self.y),
            t_limit,
            max_step=options.max_step,
            rtol=max(options.relative_tolerance, 1e-13),
            atol=tolerances,
            jac=form.jacobian,
            first_step=options.initial_step,
        )

    def _derivative(self, t: float, x: Array) -> Array:
        try:
            return self._form.derivative(t, x)
        except IntegrationError as error:
            # Radau takes a smaller step when a stage is not finite.
            self._refused = error
            return np.full(self._form.size, np.nan)

    @property
    def t(self) -> float:
        """Time of ``y`` and ``yp``, seconds."""
        return self._t

    @property
    def end_of_step(self) -> float:
        """End of the last step, which may lie past ``t``."""
        return self._t_step

    def step(self, t_limit: float) -> StepResult:
        """Take one internal step; see the protocol."""
        options = self._options
        total = self._base.steps + self._steps
        if options.max_steps is not None and total >= options.max_steps:
            failure = Failure(Reason.TOO_MANY_STEPS, self._t)
            note = f"limit: {options.max_steps} steps"
            return self._failed(integration_error(failure, options.labels, (note,)))
        before = self._t
        low = self._watch.values(before, self.y, self.yp) if self.watches else None
        if self._t_step > self._t:  # an earlier run has looked ahead
            self.go_to(min(self._t_step, t_limit))
            return self._result(t_limit, before, low)
        try:
            message = self._advance(t_limit)
        except IntegrationError as error:
            return self._failed(error)
        if message is not None:
            return self._failed(self._explain(message))
        self.go_to(self._t_step)
        return self._result(t_limit, before, low)

    def _result(self, t_limit: float, before: float, low: Array | None) -> StepResult:
        if low is not None and self._watch.search(self, before, low, self._t):
            return StepResult(self._t, Status.ROOT)
        return StepResult(self._t, Status.REACHED if self._t >= t_limit else Status.STEPPED)

    def _failed(self, error: IntegrationError) -> StepResult:
        return StepResult(self._t, Status.FAILED, error)

    def _advance(self, t_limit: float) -> str | None:
        """Take one step of the method; return its complaint."""
        if self._solver is None:
            # Where the start is no solution, say so here and not as a step that is too small.
            self._form.point(self._t_step, self._form.x(self.y))
            self._solver = self._make_solver(t_limit)
        solver = self._solver
        solver.t_bound = t_limit
        solver.status = "running"
        message: str | None = solver.step()
        if solver.status == "failed":
            return message or "failed"
        if not np.isfinite(solver.f).all():
            return "not finite"
        self._steps += 1
        self._t_step = float(solver.t)
        self._dense = None
        return None

    def _explain(self, message: str) -> IntegrationError:
        solver = self._solver
        if self._refused is not None:
            return self._refused
        failure = Failure(Reason.ERROR_TEST, self._t, float(getattr(solver, "h_abs", 0.0)))
        return integration_error(failure, self._options.labels, (message,))

    def go_to(self, t: float) -> None:
        """Set ``t``, ``y`` and ``yp`` to a time inside the last step."""
        y, yp = self._point(t)
        self.y[:] = y
        self.yp[:] = yp
        self._t = t

    def _point(self, t: float) -> tuple[Array, Array]:
        solver = self._solver
        if solver is None:
            return self.y, self.yp
        if t == solver.t:
            return self._form.point(t, solver.y)
        if self._dense is None:
            self._dense = solver.dense_output()
        return self._form.point(t, self._dense(t))

    def run(
        self, times: Array, out_y: Array, out_yp: Array, t_limit: float | None = None
    ) -> RunResult:
        """Integrate and fill rows; see the protocol."""
        # Radau's steps are controlled at their ends only; in between, very stiff components may
        # be off by much more than the tolerance. A one-step method may well end on every time.
        progress = self._options.progress
        return run_by_steps(self, times, out_y, out_yp, None, progress, land=True)

    def advance(self, t_limit: float) -> StepResult:
        """Integrate to a time without output; see the protocol."""
        return advance_by_run(self, t_limit)

    def interpolate(self, t: float, order: int = 0) -> Array:
        """Return ``y`` or ``y'`` inside the last step; see the protocol."""
        if t == self._t:
            return (self.yp if order else self.y).copy()
        start = self._solver.t_old if self._solver is not None else None
        if start is None or not start <= t <= self._t_step:
            raise ValueError(f"{t} is not inside the last step, which ends at {self._t_step}")
        return self._point(t)[1 if order else 0].copy()

    def restart(
        self, t: float, y: Array, yp: Array, problem: DAEProblem | NativeSystem | None = None
    ) -> None:
        """Go on from other values; see the protocol."""
        self._base = self.statistics
        self._steps = 0
        system = self._system if problem is None else native_system(problem)
        if system.problem.n != self._system.problem.n:
            raise ValueError("the new problem has another size")
        if problem is not None:
            self._watch.use(system)
            self._consistent_point = None
        self._start(system, t, y, yp)

    @property
    def statistics(self) -> Statistics:
        """What it has cost so far; of this method's own failures nothing is known."""
        base, solver = self._base, self._solver
        return Statistics(
            base.steps + self._steps,
            base.residual_evaluations + self._form.evaluations,
            base.jacobian_evaluations + self._form.factorisations,
            -1,
            -1,
            5,
            float(solver.step_size or 0.0) if solver is not None else base.last_step,
        )

    def close(self) -> None:
        """Free nothing: all is Python's."""
        self._solver = self._dense = None
