"""The integrator of a problem without unknowns, where only time passes.

Root functions of time are looked at :data:`LOOKS` times between a start and the first limit.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from acausal.solvers.protocol import Options, RunResult, Statistics, Status, StepResult
from acausal.solvers.stepping import advance_by_run, run_by_steps
from acausal.solvers.system import NativeSystem, native_system
from acausal.solvers.watching import Watch, Watching

if TYPE_CHECKING:
    from acausal.assembly.problem import DAEProblem

Array = NDArray[np.float64]


#: Looks at the root functions on the way to the first limit.
LOOKS = 500


class TrivialIntegrator(Watching):
    """Whatever solver was asked for; see :class:`acausal.solvers.protocol.Integrator`."""

    def __init__(self, system: NativeSystem, t: float, options: Options) -> None:
        """Start at a time."""
        self._system = system
        self._watch = Watch(system)
        self._stride = 0.0
        self._progress = options.progress
        self.t = self.end_of_step = t
        self.y = np.zeros(0)
        self.yp = np.zeros(0)
        self._max_step = options.max_step
        self._steps = 0

    def step(self, t_limit: float) -> StepResult:
        """Go to the limit, or as far as a step may go."""
        self._steps += 1
        before, stride = self.t, self._max_step
        if self.watches:
            self._stride = self._stride or (t_limit - before) / LOOKS
            stride = min(stride, self._stride)
            low = self._watch.values(before, self.y, self.yp)
        near = before + stride * (1.0 + 1e-9) < t_limit
        self.t = self.end_of_step = before + stride if near else t_limit
        if self.watches and self._watch.search(self, before, low, self.t):
            return StepResult(self.t, Status.ROOT)
        return StepResult(self.t, Status.REACHED if self.t >= t_limit else Status.STEPPED)

    def run(
        self, times: Array, out_y: Array, out_yp: Array, t_limit: float | None = None
    ) -> RunResult:
        """Go to the last time."""
        if self.watches:
            return run_by_steps(self, times, out_y, out_yp, t_limit, self._progress)
        if len(times):
            self.t = self.end_of_step = float(times[-1])
        return RunResult(len(times), Status.REACHED)

    def go_to(self, t: float) -> None:
        """Set the time."""
        self.t = t

    def advance(self, t_limit: float) -> StepResult:
        """Integrate to a time without output; see the protocol."""
        return advance_by_run(self, t_limit)

    def interpolate(self, t: float, order: int = 0) -> Array:
        """Return nothing."""
        return np.zeros(0)

    def restart(
        self, t: float, y: Array, yp: Array, problem: DAEProblem | NativeSystem | None = None
    ) -> None:
        """Go on from another time."""
        self.t = self.end_of_step = t
        self._stride = 0.0
        if problem is not None:
            self._system = native_system(problem)
            self._watch.use(self._system)

    @property
    def statistics(self) -> Statistics:
        """Steps only."""
        return Statistics(steps=self._steps)

    def close(self) -> None:
        """Free nothing."""

    def consistent(self, t: float, y: Array, yp: Array) -> int:
        """Nothing is to be solved."""
        return 0

    def native_point(self) -> None:
        """Nothing is to be solved in native code either."""
