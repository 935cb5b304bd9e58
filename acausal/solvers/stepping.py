"""Output times for integrators that step in Python."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from acausal.solvers.failures import IntegrationError
from acausal.solvers.protocol import Integrator, RunResult, Status, StepResult

Array = NDArray[np.float64]


class Stepper(Protocol):
    """What :func:`run_by_steps` needs of an integrator."""

    y: Array
    yp: Array

    @property
    def t(self) -> float:
        """Time of ``y`` and ``yp``."""

    @property
    def watches(self) -> bool:
        """Whether there are root functions."""

    @property
    def end_of_step(self) -> float:
        """End of the last step, which may lie past ``t``."""

    def step(self, t_limit: float) -> StepResult:
        """Take one internal step."""

    def go_to(self, t: float) -> None:
        """Set ``t``, ``y`` and ``yp`` to a time inside the last step."""


def run_by_steps(
    integrator: Stepper,
    times: Array,
    out_y: Array,
    out_yp: Array,
    t_limit: float | None,
    progress: Callable[[float], None] | None,
    land: bool = False,
) -> RunResult:
    """Step and interpolate; arguments as in ``Integrator.run``.

    Args:
        integrator: Does the steps.
        times: Output times.
        out_y: Receives the unknowns.
        out_yp: Receives the derivatives.
        t_limit: How far to look ahead.
        progress: Told the time after every step.
        land: End a step on every output time instead of interpolating.
    """
    row = 0
    try:
        if len(times) == 0:
            return RunResult(0, Status.REACHED)
        limit = float(times[-1]) if t_limit is None else max(float(times[-1]), t_limit)
        # Rows may be filled up to here; of a step that is left over, roots are not known yet.
        known = integrator.t if integrator.watches else integrator.end_of_step
        root: float | None = None
        for row, time in enumerate(times):
            t = float(time)
            while t > known and root is None:
                result = integrator.step(t if land else limit)
                if result.status is Status.FAILED:
                    return RunResult(row, Status.FAILED, result.failure)
                known = integrator.t
                if result.status is Status.ROOT:
                    root = known
                if progress is not None:
                    progress(integrator.t)
            if root is not None and t > root:
                if integrator.t != root:
                    integrator.go_to(root)
                return RunResult(row, Status.ROOT)
            if t != integrator.t:
                integrator.go_to(t)
            out_y[row] = integrator.y
            out_yp[row] = integrator.yp
    except IntegrationError as error:
        return RunResult(row, Status.FAILED, error)
    except KeyboardInterrupt:
        return RunResult(row, Status.INTERRUPTED)
    if root is not None and root == times[-1]:
        return RunResult(len(times), Status.ROOT)
    return RunResult(len(times), Status.REACHED)


def advance_by_run(integrator: Integrator, t_limit: float) -> StepResult:
    """Integrate to a time with :meth:`Integrator.run`; what it would store is dropped."""
    y, yp = np.empty((1, len(integrator.y))), np.empty((1, len(integrator.y)))
    result = integrator.run(np.array([t_limit]), y, yp, t_limit)
    return StepResult(integrator.t, result.status, result.failure)
