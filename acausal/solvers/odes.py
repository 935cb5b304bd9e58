"""What ``odes-ida`` and ``odes-cvode`` have in common: stepping scikits-odes' solver objects.

scikits-odes does not tell what it could: steps, errors, interpolants, and an exception in a
callback is printed and forgotten. So callbacks here never raise: they keep the exception and
return the code for giving up. Interpolation asks the solver for a time that it has passed already.

Times are passed relative to the last start, because scikits-odes ignores a stop time that is not
positive. It also rounds the stop time to single precision, so that the solver may end a step
just behind the wanted limit; the point at the limit is then interpolated.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import fail
from acausal.solvers.failures import (
    Failure,
    IntegrationError,
    Reason,
    integration_error,
    not_finite_rows,
    singular_parts,
)
from acausal.solvers.first_step import first_step
from acausal.solvers.protocol import Options, RunResult, Statistics, Status, StepResult
from acausal.solvers.stepping import advance_by_run, run_by_steps
from acausal.solvers.system import NativeSystem, native_system
from acausal.solvers.watching import Watch, Watching

if TYPE_CHECKING:
    from acausal.assembly.problem import DAEProblem

Array = NDArray[np.float64]

TSTOP_RETURN = 1
TOO_MUCH_WORK, ERR_FAIL, CONV_FAIL, LSETUP_FAIL, LSOLVE_FAIL = -1, -3, -4, -6, -7
#: First steps tried after a failure, as fractions of the distance to the limit.
LADDER = (1e-6, 1e-9, 1e-12)
#: A recovered failure is forgotten after so many steps that went so far, as a fraction of the
#: distance to the limit. Without the second, a pole would be approached for ever.
FORGET, FORGET_FRACTION = 10, 1e-7
#: Steps too small to change the time before the run is given up.
MOST_STANDING = 50
#: Stop times reached before the solver is made anew: it keeps a list of them all.
MOST_STOPS = 200


def odes_module(name: str) -> Any:
    """Import ``ida`` or ``cvode`` of scikits-odes, in whichever of its packages it is.

    Raises:
        AcausalError: R102 if it is not installed.
    """
    for package in ("scikits_odes_sundials", "scikits.odes.sundials"):
        try:
            return importlib.import_module(f"{package}.{name}")
        except ImportError:
            pass
    return fail(
        "R102",
        f"the solver odes-{name} needs scikits-odes, which is not installed",
        help="pip install 'acausal[odes]' (it is built with SUNDIALS' headers and a compiler), "
        "or choose the solver ida",
    )


class OdesIntegrator(Watching):
    """Base of both; see :class:`acausal.solvers.protocol.Integrator`.

    A subclass makes the solver and translates between the unknowns and the solver's vectors.
    """

    def __init__(
        self, system: NativeSystem, t: float, y: Array, yp: Array, options: Options
    ) -> None:
        """Prepare an integration from a consistent point."""
        self._options = options
        self._base_steps = 0
        self._residuals = 0
        self._jacobians = 0
        self._error: BaseException | None = None
        self._refused: IntegrationError | None = None
        self._not_finite_time = math.nan
        self.y = np.array(y, dtype=np.float64)
        self.yp = np.array(yp, dtype=np.float64)
        self._steps = 0
        self._stops = 0
        self._t = self._t_step = self._t_base = t
        self._t_before = t
        self._t_read = t  # time of the solver's vectors
        self._tau_step = 0.0  # end of the last step as the solver has it
        self._attempt = 0
        self._since = 0
        self._solver: Any = None
        self._watch = Watch(system)
        self._use(system)

    # --- for subclasses

    def _use(self, system: NativeSystem) -> None:
        """Take a problem, at the point (t, y, y')."""
        raise NotImplementedError

    def _begin(self, first_step: float) -> Any:
        """Return a new solver object that starts at the point (t, y, y') and time 0."""
        raise NotImplementedError

    def _begin_again(self) -> None:
        """Start the present solver object anew at the point (t, y, y') and time 0."""
        raise NotImplementedError

    def _call(self, tau: float) -> tuple[int, float]:
        """Step the solver object; return its flag and time."""
        raise NotImplementedError

    def _read(self, t: float) -> tuple[Array, Array]:
        """Return (y, y') from the vectors that the last call filled."""
        raise NotImplementedError

    def _common_options(self, first_step: float) -> dict[str, Any]:
        options: dict[str, Any] = {
            "rtol": self._options.relative_tolerance,
            "max_steps": 100_000,
            "old_api": False,
            "one_step_compute": True,
            "err_handler": _silent,
            "first_step_size": first_step,
        }
        if math.isfinite(self._options.max_step):
            options["max_step_size"] = self._options.max_step
        return options

    def _guard(self, work: Callable[[], Array], t: float) -> int:
        """Do the work of a callback; return SUNDIALS' code."""
        try:
            out = work()
        except IntegrationError as error:
            # A point that the solver only tries: a smaller step may avoid it.
            self._refused = error
            return 1
        except BaseException as error:  # noqa: BLE001 - raised again after the step
            self._error = error
            return -1
        if not np.isfinite(out).all():
            self._not_finite_time = t
            return 1
        return 0

    # --- the protocol

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
        maximum = self._options.max_steps
        if maximum is not None and self._base_steps + self._steps >= maximum:
            failure = Failure(Reason.TOO_MANY_STEPS, self._t)
            error = integration_error(failure, self._options.labels, (f"limit: {maximum} steps",))
            return StepResult(self._t, Status.FAILED, error)
        before = self._t
        low = self._watch.values(before, self.y, self.yp) if self.watches else None
        if self._t_step > self._t:  # an earlier run has looked ahead
            self.go_to(min(self._t_step, t_limit))
        else:
            error_or_none = self._advance(t_limit)
            if error_or_none is not None:
                return StepResult(self._t, Status.FAILED, error_or_none)
        if low is not None and self._watch.search(self, before, low, self._t):
            return StepResult(self._t, Status.ROOT)
        status = Status.REACHED if self._t >= t_limit else Status.STEPPED
        return StepResult(self._t, status)

    def _advance(self, t_limit: float) -> IntegrationError | None:
        """Take one step of the method and make it the present point."""
        self._refused = None
        standing = 0
        while True:
            if self._solver is None:
                self._solver = self._begin(self._first_step(t_limit))
            tau = t_limit - self._t_base
            before = self._t_step
            self._solver.set_options(tstop=_not_before(tau))
            flag, reached = self._call(tau)
            if self._error is not None:
                error, self._error = self._error, None
                raise error
            t = t_limit if reached == tau else self._t_base + reached
            if flag >= 0 and t <= before:
                # After an interpolation it only repeats where it is; next to a pole its steps
                # become too small to change the time, and it never gives up.
                standing += 1
                if standing > MOST_STANDING:
                    return self._explain(ERR_FAIL)
                continue
            if flag >= 0:
                self._steps += 1
                self._since += 1
                self._stops += flag == TSTOP_RETURN
                self._t_before, self._t_step = before, t
                self._t_read, self._tau_step = t, reached
                if t > t_limit:
                    self.go_to(t_limit)
                else:
                    self._set_point(t)
                return None
            if flag != TOO_MUCH_WORK and not self._recover(flag, t_limit):
                return self._explain(flag)

    def _first_step(self, t_limit: float) -> float:
        step = self._options.initial_step or first_step(
            self._t,
            t_limit,
            self.y,
            self.yp,
            self._system.problem.differential,
            self._options.relative_tolerance,
            self._options.absolute_tolerance * self._system.problem.nominal,
        )
        return min(step, self._options.max_step)

    def _set_point(self, t: float) -> None:
        y, yp = self._read(t)
        self.y[:] = y
        self.yp[:] = yp
        self._t = t

    def _look(self, t: float) -> tuple[Array, Array]:
        """Return (y, y') at a time inside the last step."""
        if t != self._t_read:
            # Rounding must not lead past the last step: the solver would take another one.
            tau = self._tau_step if t == self._t_step else min(t - self._t_base, self._tau_step)
            self._solver.set_options(one_step_compute=False)
            try:
                flag, _ = self._call(tau)
            finally:
                self._solver.set_options(one_step_compute=True)
            self._t_read = t
            if flag < 0:
                raise ValueError(f"{t} is not inside the last step, which ends at {self._t_step}")
        return self._read(t)

    def go_to(self, t: float) -> None:
        """Set ``t``, ``y`` and ``yp`` to a time inside the last step."""
        y, yp = self._look(t)
        self.y[:] = y
        self.yp[:] = yp
        self._t = t

    def run(
        self, times: Array, out_y: Array, out_yp: Array, t_limit: float | None = None
    ) -> RunResult:
        """Integrate and fill rows; see the protocol."""
        progress = self._options.progress
        return run_by_steps(self, times, out_y, out_yp, t_limit, progress)

    def advance(self, t_limit: float) -> StepResult:
        """Integrate to a time without output; see the protocol."""
        return advance_by_run(self, t_limit)

    def interpolate(self, t: float, order: int = 0) -> Array:
        """Return ``y`` or ``y'`` inside the last step; see the protocol."""
        if t == self._t:
            return (self.yp if order else self.y).copy()
        if not self._t_before <= t <= self._t_step:
            raise ValueError(f"{t} is not inside the last step, which ends at {self._t_step}")
        return np.array(self._look(t)[1 if order else 0])

    def restart(
        self, t: float, y: Array, yp: Array, problem: DAEProblem | NativeSystem | None = None
    ) -> None:
        """Go on from other values; see the protocol."""
        self.y[:] = y
        self.yp[:] = yp
        self._start_at(t)
        self._attempt = 0
        if problem is not None:
            system = native_system(problem)
            if system.problem.n != len(self.y):
                raise ValueError("the new problem has another size")
            self._use(system)
            self._watch.use(system)
            self._consistent_point = None
            self._solver = None
        elif self._stops > MOST_STOPS:
            self._solver = None
        if self._solver is None:
            self._stops = 0
        else:
            self._begin_again()

    def _start_at(self, t: float) -> None:
        self._t = self._t_step = self._t_base = self._t_before = self._t_read = t
        self._base_steps += self._steps
        self._steps = self._since = 0

    @property
    def statistics(self) -> Statistics:
        """What it has cost so far; scikits-odes counts no failures."""
        return Statistics(
            self._base_steps + self._steps,
            self._residuals,
            self._jacobians,
            -1,
            -1,
            -1,
            self._t_step - self._t_before,
        )

    def close(self) -> None:
        """Drop the solver object."""
        self._solver = None

    # --- failures

    def _recover(self, flag: int, t_limit: float) -> bool:
        """Start anew from the last good point with a small first step."""
        gone = self._t_step - self._t_base
        if self._since >= FORGET and gone > FORGET_FRACTION * (t_limit - self._t_base):
            self._attempt = 0
        if self._attempt >= len(LADDER):
            return False
        step = LADDER[self._attempt] * (t_limit - self._t_step)
        if not self._t_step + step > self._t_step:
            return False
        self._attempt += 1
        self._start_at(self._t_step)
        self._solver = self._begin(step)
        self._stops = 0
        return True

    def _explain(self, flag: int) -> IntegrationError:
        labels, t = self._options.labels, self._t
        if self._refused is not None:
            return self._refused
        if math.isfinite(self._not_finite_time) and abs(self._not_finite_time - t) <= 1e-3 * max(
            1.0, abs(t)
        ):
            rows = not_finite_rows(self._system, t, self.y, self.yp)
            return integration_error(Failure(Reason.NOT_FINITE, t, 0.0, (), rows), labels)
        step = self._t_step - self._t_before
        if flag in (CONV_FAIL, LSETUP_FAIL, LSOLVE_FAIL):
            cj = 1.0 / step if step > 0.0 else 1.0
            unknowns, rows = singular_parts(self._system, t, cj, self.y, self.yp)
            if unknowns or rows:
                failure = Failure(Reason.SINGULAR, t, step, unknowns, rows)
                return integration_error(failure, labels)
        reasons = {ERR_FAIL: Reason.ERROR_TEST, CONV_FAIL: Reason.CONVERGENCE}
        reason = reasons.get(flag, Reason.OTHER)
        notes = (f"SUNDIALS returned {flag}",) if reason is Reason.OTHER else ()
        return integration_error(Failure(reason, t, step), labels, notes)

    _system: NativeSystem


def _not_before(tau: float) -> float:
    """Return the first number of single precision that is not before a time."""
    rounded = np.float32(tau)
    return float(rounded if float(rounded) >= tau else np.nextafter(rounded, np.float32(np.inf)))


def _silent(code: int, module: bytes, function: bytes, message: bytes) -> None:
    """Receive SUNDIALS' messages, which repeat the return code."""
