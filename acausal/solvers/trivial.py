"""The integrator of a problem without unknowns, where only time passes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from acausal.solvers.protocol import Options, RunResult, Statistics, Status, StepResult
from acausal.solvers.system import NativeSystem

if TYPE_CHECKING:
    from acausal.assembly.problem import DAEProblem

Array = NDArray[np.float64]


class TrivialIntegrator:
    """Whatever solver was asked for; see :class:`acausal.solvers.protocol.Integrator`."""

    def __init__(self, t: float, options: Options) -> None:
        """Start at a time."""
        self.t = t
        self.y = np.zeros(0)
        self.yp = np.zeros(0)
        self._max_step = options.max_step
        self._steps = 0

    def step(self, t_limit: float) -> StepResult:
        """Go to the limit, or as far as a step may go."""
        self._steps += 1
        self.t = min(t_limit, self.t + self._max_step)
        return StepResult(self.t, Status.REACHED if self.t >= t_limit else Status.STEPPED)

    def run(
        self, times: Array, out_y: Array, out_yp: Array, t_limit: float | None = None
    ) -> RunResult:
        """Go to the last time."""
        if len(times):
            self.t = float(times[-1])
        return RunResult(len(times), Status.REACHED)

    def interpolate(self, t: float, order: int = 0) -> Array:
        """Return nothing."""
        return np.zeros(0)

    def restart(
        self, t: float, y: Array, yp: Array, problem: DAEProblem | NativeSystem | None = None
    ) -> None:
        """Go on from another time."""
        self.t = t

    @property
    def statistics(self) -> Statistics:
        """Steps only."""
        return Statistics(steps=self._steps)

    def close(self) -> None:
        """Free nothing."""
