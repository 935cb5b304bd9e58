"""A run on its way: layouts, integrators, change of states, stored points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from acausal.assembly.assemble import assemble, family_kernels
from acausal.assembly.layout import Layout, lay_out, unknowns_of, values_of
from acausal.assembly.observe import Observer
from acausal.assembly.problem import TIME_POSITION, Y_POSITION, DAEProblem
from acausal.codegen.driver import NativeProblem
from acausal.diagnostics import AcausalError
from acausal.flattening.model import Ids
from acausal.results.result import Ending, Event
from acausal.simulation.delays import Delays
from acausal.simulation.dense import DenseRecord
from acausal.simulation.event_kernels import EventKernels
from acausal.simulation.labels import SystemLabels
from acausal.simulation.output import Recorder
from acausal.simulation.relations import Relations, room_for
from acausal.simulation.request import Request
from acausal.simulation.states import StateSelector
from acausal.simulation.system import System
from acausal.solvers.protocol import Integrator, Options, Statistics, Status, create
from acausal.solvers.step_polynomial import step_polynomial

Array = NDArray[np.float64]

#: Absolute tolerance as a share of the relative one, times the nominal value of a variable.
ABSOLUTE_SHARE = 1e-3
#: A run of more internal steps than this is not getting anywhere.
MOST_STEPS = 20_000_000
#: States are looked at again after so many steps; twice as many after every look that changed
#: nothing, up to the second number, which a look at fewer columns than that does not reach:
#: small systems are cheap to look at. A step that fails looks at them, too.
STEPS_BETWEEN_LOOKS = (3, 64)
#: Spacing of the points that a motion over a singular position starts from, as a share of a run.
SNAPSHOTS = 2e-4
#: Longest step where values are delayed, as a share of a run.
HISTORY = 2e-3
#: A variable delay that comes near zero does not make steps shorter than this share of a run;
#: histories go on as straight lines over less than one step then.
LEAST_STEP = 1e-6

#: Numbers that may be spent on keeping earlier choices of states ready for use.
KEPT = 4_000_000


@dataclass
class Assembled:
    """The system for one choice of states, and its integrator once there is one."""

    states: Ids
    layout: Layout
    native: NativeProblem[DAEProblem]
    observer: Observer
    events: EventKernels | None = None
    integrator: Integrator | None = None

    @property
    def parameters(self) -> Array:
        """Parameters and held values, a view of the work vector."""
        w: Array = self.native.problem.w
        return w[self.layout.parameters : self.layout.observables]


class Reached(Enum):
    """Where a part of the integration ended."""

    LIMIT = "limit"
    ROOT = "root"
    OVER = "over"


@dataclass
class Run:
    """A run on its way.

    Attributes:
        parameters: Parameters and held values to begin with, shape ``(p,)``.
        relations: The relations, None in a model without events.
        on_new_layout: Told of every layout that is used for the first time.
        snapshots: The last few good points, time and values of all ids, if states are watched.
        spacing: Time between them, seconds.
        dense: Collects the integrator's polynomials, if they are wanted.
    """

    system: System
    request: Request
    recorder: Recorder
    selector: StateSelector
    tolerance: float
    stop: float
    parameters: Array
    relations: Relations | None = None
    on_new_layout: Callable[[Assembled], None] | None = None
    events: list[Event] = field(default_factory=list)
    failure: AcausalError | None = None
    ending: Ending = Ending.COMPLETE
    statistics: list[Statistics] = field(default_factory=list)
    solve_time: float = 0.0
    solve_cpu_time: float = 0.0
    integrator: Integrator | None = None
    current: Assembled | None = None
    kept: dict[bytes, Assembled] = field(default_factory=dict)
    reselections: int = 0
    time: float = 0.0
    snapshots: list[tuple[float, Array]] = field(default_factory=list)
    spacing: float = np.inf
    dense: DenseRecord | None = None
    _in_need: float = -np.inf

    def assembled(self, states: Ids) -> Assembled:
        """Return the system for a choice of states; index arrays only, the kernels are there."""
        system = self.system
        differentiated = system.differentiated
        is_state = np.zeros(len(system.active), np.bool_)
        is_state[states] = True
        layout = lay_out(system.active, system.derivative, is_state, len(system.parameters))
        problem = assemble(
            differentiated.families,
            family_kernels(differentiated.families),
            differentiated.n_rows,
            layout,
            self.parameters,
            system.variables.nominal,
        )
        observer = Observer(
            layout, system.representative, system.sign, system.definitions, system.parameters,
            *((-1, None) if system.hybrid is None else (system.hybrid.first, system.hybrid.place)),
        )  # fmt: skip
        events = None
        if system.hybrid is not None and self.relations is not None:
            more = np.zeros(room_for(self.relations))
            problem = replace(problem, w=np.concatenate([problem.w, more]))
            events = EventKernels(
                system.hybrid, self.relations, problem.w, layout.position, layout.parameters,
                system.assertions,
            )  # fmt: skip
            delays = events.delays.table if events.delays is not None else None
            problem = replace(problem, roots=events.root_problem(), delays=delays)
        return Assembled(states, layout, NativeProblem(problem), observer, events)

    def begin(self, t: float, values: Array, states: Ids) -> None:
        """Start or restart the integrator at consistent values."""
        if self.current is None or not np.array_equal(states, self.current.states):
            self._change(states)
        assert self.current is not None
        self.begin_at(t, *unknowns_of(self.current.layout, values))

    def begin_at(self, t: float, y: Array, yp: Array) -> None:
        """Start or restart the integrator at consistent values of the present layout."""
        assert self.current is not None
        if self.current.integrator is None:
            options = Options(
                relative_tolerance=self.tolerance,
                absolute_tolerance=self.tolerance * ABSOLUTE_SHARE,
                max_step=self.request.max_step,
                max_steps=MOST_STEPS,
                progress=self._progress if self.request.progress is not None else None,
                labels=SystemLabels(self.system, self.current.layout),
            )
            self.current.integrator = create(
                self.request.solver, self.current.native, t, y, yp, options
            )
        else:
            self.current.integrator.restart(t, y, yp)
        self.integrator = self.current.integrator
        self.time = t

    def _change(self, states: Ids) -> None:
        """Make another choice of states the present one."""
        key = states.tobytes()
        found = self.kept.pop(key, None)
        is_new = found is None
        if found is None:
            found = self.assembled(states)
        if self.current is not None:
            found.parameters[:] = self.current.parameters
            if found.events is not None and self.current.events is not None:
                found.events.states.take(self.current.events.states)
                if found.events.delays is not None and self.current.events.delays is not None:
                    found.events.delays.table.take(self.current.events.delays.table)
        self.kept[key] = found  # the last one used stands last
        size = sum(a.native.problem.nnz + len(a.layout.position) for a in self.kept.values())
        while size > KEPT and len(self.kept) > 1:
            oldest = self.kept.pop(next(iter(self.kept)))
            size -= oldest.native.problem.nnz + len(oldest.layout.position)
            self._finish(oldest)
        self.current = found
        if is_new and self.on_new_layout is not None:
            self.on_new_layout(found)

    def _progress(self, t: float) -> None:
        assert self.request.progress is not None
        self.request.progress(t, self.stop)

    def _finish(self, assembled: Assembled) -> None:
        if assembled.integrator is not None:
            self.statistics.append(assembled.integrator.statistics)
            assembled.integrator.close()
            assembled.integrator = None

    def values(self) -> Array:
        """Return the values of all ids where the integrator stands."""
        assert self.integrator is not None and self.current is not None
        return values_of(self.current.layout, self.integrator.y, self.integrator.yp)

    def record_here(self) -> None:
        """Store the present point."""
        assert self.integrator is not None and self.current is not None
        self.recorder.store_point(
            self.current.observer, self.time, self.integrator.y, self.integrator.yp
        )

    def integrate(self, times: Array, limit: float) -> tuple[Reached, int]:
        """Go on to ``limit``, or to the first root before it.

        Args:
            times: Output times to store, not after ``limit``.
            limit: Seconds.

        Returns:
            Where it ended, and how many of ``times`` are stored.
        """
        if self.selector.has_alternatives or self._delays is not None or self.dense is not None:
            return self._integrate_watching(times, limit)
        return self._integrate_through(times, limit)

    def _integrate_through(self, times: Array, limit: float) -> tuple[Reached, int]:
        assert self.integrator is not None and self.current is not None
        if not len(times):
            advanced = self.integrator.advance(limit)
            self.time = advanced.t
            if advanced.status is Status.ROOT:
                return Reached.ROOT, 0
            if advanced.status is not Status.REACHED:
                self._end(advanced.status, advanced.failure)
                return Reached.OVER, 0
            self.time = limit
            return Reached.LIMIT, 0
        n = self.current.layout.n
        every = times if times[-1] >= limit else np.append(times, limit)
        chunk = self.recorder.chunk(n)
        stored = 0
        for first in range(0, len(every), chunk):
            part = every[first : first + chunk]
            y, yp = np.empty((len(part), n)), np.empty((len(part), n))
            result = self.integrator.run(part, y, yp, limit)
            kept = min(result.rows, len(times) - first)
            if kept > 0:
                self.recorder.store(self.current.observer, part[:kept], y[:kept], yp[:kept])
                stored += kept
            self.time = self.integrator.t
            if result.status is Status.ROOT:
                return Reached.ROOT, stored
            if result.status is not Status.REACHED:
                self._end(result.status, result.failure)
                return Reached.OVER, stored
        self.time = limit
        return Reached.LIMIT, stored

    def _integrate_watching(self, times: Array, limit: float) -> tuple[Reached, int]:
        """Step by step, looking at the choice of states in between."""
        assert self.integrator is not None and self.current is not None
        done = 0
        since, pause = 0, STEPS_BETWEEN_LOOKS[0]
        longest = min(max(self.selector.columns, pause), STEPS_BETWEEN_LOOKS[1])
        delays = self._delays
        while self.integrator.t < limit:
            ahead = limit
            if delays is not None:
                ahead = min(limit, self.integrator.t + self._longest(delays))
            begin = self.integrator.t
            step = self.integrator.step(ahead)
            if step.status in (Status.FAILED, Status.INTERRUPTED):
                values = self.values()
                states = None
                if step.status is Status.FAILED and self.integrator.t > self._in_need:
                    states = self.selector.better(values, self.integrator.t, force=True)
                    self._in_need = self.integrator.t
                if states is not None:
                    self.begin(self.integrator.t, values, states)
                    self.reselections += 1
                    continue
                self._end(step.status, step.failure)
                return Reached.OVER, done
            if self.dense is not None:
                self._keep_polynomial(self.dense, begin)
            last = int(np.searchsorted(times, self.integrator.t, "right"))
            if last > done:
                part = times[done:last]
                y = np.array([self.integrator.interpolate(t) for t in part])
                yp = np.array([self.integrator.interpolate(t, 1) for t in part])
                if delays is None:
                    self.recorder.store(self.current.observer, part, y, yp)
                else:
                    self._store_delayed(delays, part, y, yp)
                done = last
            if delays is not None:
                self._show(self.integrator.t, self.integrator.y, self.integrator.yp)
                delays.step(self.integrator.t)
            since += 1
            self.time = self.integrator.t
            if not self.snapshots or self.time > self.snapshots[-1][0] + self.spacing:
                self.snapshots = [*self.snapshots[-2:], (self.time, self.values())]
            if self.request.progress is not None:
                self._progress(self.time)
            if step.status is Status.ROOT:
                return Reached.ROOT, done
            if since >= pause and self.integrator.t < limit:
                since, pause = 0, min(2 * pause, longest)
                values = self.values()
                states = self.selector.better(values, self.integrator.t)
                if states is not None:
                    pause = STEPS_BETWEEN_LOOKS[0]
                    self.begin(self.integrator.t, values, states)
                    self.reselections += 1
        self.time = limit
        return Reached.LIMIT, done

    def _keep_polynomial(self, dense: DenseRecord, begin: float) -> None:
        assert self.integrator is not None and self.current is not None
        end, events = self.integrator.t, self.current.events
        polynomial = step_polynomial(self.integrator, begin, end) if end > begin else None
        if polynomial is None:
            return
        held = None
        if events is not None and self._delays is not None:
            ends = []
            for t in (begin, end):
                self._show(t, self.integrator.interpolate(t), self.integrator.interpolate(t, 1))
                self._delays.show(t, right=t == begin)
                ends.append(events.held.copy())
            held = ends[0], ends[1]
        elif events is not None:
            now = events.held.copy()
            held = now, now
        native = self.current.native
        looks_back = events is not None and events.delays is not None
        settled = bool(np.all(native.problem.differential)) or looks_back
        dense.add(self.current.observer, None if settled else native, begin, end, polynomial, held)

    def _longest(self, delays: Delays) -> float:
        """Return the longest step with delays: histories have to show what they delay."""
        run = self.spacing / SNAPSHOTS
        return min(max(delays.shortest, LEAST_STEP * run), HISTORY * run)

    @property
    def _delays(self) -> Delays | None:
        events = self.current.events if self.current is not None else None
        if events is None or events.delays is None or not events.delays.moving:
            return None
        return events.delays

    def _show(self, t: float, y: Array, yp: Array) -> None:
        """Let the kernels of events see a point."""
        assert self.current is not None
        n, w = self.current.layout.n, self.current.native.problem.w
        w[TIME_POSITION] = t
        w[Y_POSITION : Y_POSITION + n] = y
        w[Y_POSITION + n : Y_POSITION + 2 * n] = yp

    def _store_delayed(self, delays: Delays, times: Array, y: Array, yp: Array) -> None:
        """Store points, each with the delayed values of its time."""
        assert self.current is not None and self.current.events is not None
        for k, t in enumerate(times.tolist()):
            self._show(t, y[k], yp[k])
            delays.show(t)
            self.recorder.hold(self.current.events.held)
            rows = slice(k, k + 1)
            self.recorder.store(self.current.observer, times[rows], y[rows], yp[rows])

    def fail(self, error: AcausalError) -> None:
        """End the run; what is stored is kept."""
        self.failure, self.ending = error, Ending.FAILED

    def recover(self) -> None:
        """Take back a failure that could be mended."""
        self.failure, self.ending = None, Ending.COMPLETE

    def _end(self, status: Status, failure: AcausalError | None) -> None:
        self.ending = Ending.INTERRUPTED if status is Status.INTERRUPTED else Ending.FAILED
        self.failure = failure

    def totals(self) -> dict[str, float | int | str]:
        """Return the statistics of the whole run."""
        for assembled in self.kept.values():
            self._finish(assembled)
        self.integrator = None
        names = (
            "steps", "residual_evaluations", "jacobian_evaluations", "error_test_failures",
            "convergence_failures",
        )  # fmt: skip
        totals: dict[str, float | int | str] = {}
        for name in names:
            parts = [getattr(s, name) for s in self.statistics]
            totals[name] = sum(p for p in parts if p >= 0) if parts else 0
        totals["solve_time"] = self.solve_time
        totals["solve_cpu_time"] = self.solve_cpu_time
        totals["state_changes"] = self.reselections
        return totals
