"""One run: consistent start, integration between events, change of states, stored points."""

from __future__ import annotations

import time as clock
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from acausal.assembly.assemble import assemble, family_kernels
from acausal.assembly.layout import Layout, lay_out, unknowns_of, values_of
from acausal.assembly.observe import Observer
from acausal.assembly.problem import DAEProblem
from acausal.codegen.driver import NativeProblem
from acausal.diagnostics import AcausalError, Severity, fail
from acausal.flattening.model import Ids
from acausal.results.result import Ending, Event, Result
from acausal.simulation.assertions import violations
from acausal.simulation.labels import SystemLabels
from acausal.simulation.output import Recorder, output_times
from acausal.simulation.request import Request
from acausal.simulation.start import restart_values, start_values
from acausal.simulation.states import StateSelector
from acausal.simulation.system import System
from acausal.simulation.time_events import time_events
from acausal.simulation.trajectories import Trajectories
from acausal.solvers.protocol import Integrator, Options, Statistics, Status, create

if TYPE_CHECKING:
    from _collections_abc import dict_items

Array = NDArray[np.float64]

DEFAULT_TOLERANCE = 1e-6
#: Absolute tolerance as a share of the relative one, times the nominal value of a variable.
ABSOLUTE_SHARE = 1e-3
#: A run of more internal steps than this is not getting anywhere.
MOST_STEPS = 20_000_000
#: States are looked at again after so many steps; twice as many after every look that changed
#: nothing, up to the second number, which a look at fewer columns than that does not reach:
#: small systems are cheap to look at. A step that fails looks at them, too.
STEPS_BETWEEN_LOOKS = (3, 64)


#: Numbers that may be spent on keeping earlier choices of states ready for use.
KEPT = 4_000_000


@dataclass
class _Assembled:
    """The system for one choice of states, and its integrator once there is one."""

    states: Ids
    layout: Layout
    native: NativeProblem[DAEProblem]
    observer: Observer
    integrator: Integrator | None = None


@dataclass
class _Run:
    """A run on its way."""

    system: System
    request: Request
    recorder: Recorder
    selector: StateSelector
    tolerance: float
    stop: float
    events: list[Event] = field(default_factory=list)
    failure: AcausalError | None = None
    ending: Ending = Ending.COMPLETE
    statistics: list[Statistics] = field(default_factory=list)
    solve_time: float = 0.0
    solve_cpu_time: float = 0.0
    integrator: Integrator | None = None
    current: _Assembled | None = None
    kept: dict[bytes, _Assembled] = field(default_factory=dict)
    reselections: int = 0
    time: float = 0.0

    def assembled(self, states: Ids) -> _Assembled:
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
            system.parameters,
            system.variables.nominal,
        )
        observer = Observer(
            layout, system.representative, system.sign, system.definitions, system.parameters
        )
        return _Assembled(states, layout, NativeProblem(problem), observer)

    def begin(self, t: float, values: Array, states: Ids) -> None:
        """Start or restart the integrator at consistent values."""
        if self.current is None or not np.array_equal(states, self.current.states):
            self._change(states)
        assert self.current is not None
        y, yp = unknowns_of(self.current.layout, values)
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
        found = self.kept.pop(key, None) or self.assembled(states)
        self.kept[key] = found  # the last one used stands last
        size = sum(a.native.problem.nnz + len(a.layout.position) for a in self.kept.values())
        while size > KEPT and len(self.kept) > 1:
            oldest = self.kept.pop(next(iter(self.kept)))
            size -= oldest.native.problem.nnz + len(oldest.layout.position)
            self._finish(oldest)
        self.current = found

    def _progress(self, t: float) -> None:
        assert self.request.progress is not None
        self.request.progress(t, self.stop)

    def _finish(self, assembled: _Assembled) -> None:
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
        self.recorder.store(
            self.current.observer,
            np.array([self.time]),
            np.array(self.integrator.y)[None, :],
            np.array(self.integrator.yp)[None, :],
        )

    def integrate(self, times: Array, limit: float) -> bool:
        """Go on to ``limit``, storing ``times``; return False if the run is over."""
        begin, cpu = clock.perf_counter(), clock.process_time()
        try:
            if self.selector.has_alternatives:
                return self._integrate_watching(times, limit)
            return self._integrate_through(times, limit)
        finally:
            self.solve_time += clock.perf_counter() - begin
            self.solve_cpu_time += clock.process_time() - cpu

    def _integrate_through(self, times: Array, limit: float) -> bool:
        assert self.integrator is not None and self.current is not None
        n = self.current.layout.n
        every = times if len(times) and times[-1] >= limit else np.append(times, limit)
        chunk = self.recorder.chunk(n)
        for first in range(0, len(every), chunk):
            part = np.ascontiguousarray(every[first : first + chunk])
            y, yp = np.empty((len(part), n)), np.empty((len(part), n))
            result = self.integrator.run(part, y, yp, limit)
            kept = min(result.rows, len(times) - first)
            self.recorder.store(self.current.observer, part[:kept], y[:kept], yp[:kept])
            self.time = self.integrator.t
            if result.status is not Status.REACHED:
                self._end(result.status, result.failure)
                return False
        self.time = limit
        return True

    def _integrate_watching(self, times: Array, limit: float) -> bool:
        """Step by step, looking at the choice of states in between."""
        assert self.integrator is not None and self.current is not None
        done = 0
        since, pause = 0, STEPS_BETWEEN_LOOKS[0]
        longest = min(max(self.selector.columns, pause), STEPS_BETWEEN_LOOKS[1])
        while self.integrator.t < limit:
            step = self.integrator.step(limit)
            if step.status in (Status.FAILED, Status.INTERRUPTED):
                values = self.values()
                states = self.selector.better(values, self.integrator.t, force=True)
                if step.status is Status.FAILED and states is not None:
                    self.begin(self.integrator.t, values, states)
                    self.reselections += 1
                    continue
                self._end(step.status, step.failure)
                return False
            last = int(np.searchsorted(times, self.integrator.t, "right"))
            if last > done:
                part = times[done:last]
                y = np.array([self.integrator.interpolate(t) for t in part])
                yp = np.array([self.integrator.interpolate(t, 1) for t in part])
                self.recorder.store(self.current.observer, part, y, yp)
                done = last
            since += 1
            self.time = self.integrator.t
            if self.request.progress is not None:
                self._progress(self.time)
            if since >= pause and self.integrator.t < limit:
                since, pause = 0, min(2 * pause, longest)
                values = self.values()
                states = self.selector.better(values, self.integrator.t)
                if states is not None:
                    pause = STEPS_BETWEEN_LOOKS[0]
                    self.begin(self.integrator.t, values, states)
                    self.reselections += 1
        self.time = limit
        return True

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


def simulate(system: System, request: Request) -> Result:
    """Simulate a model.

    A run that fails or is interrupted on its way returns what it has, with the reason in
    ``diagnostics``.

    Raises:
        AcausalError: ``I0xx`` if there is no consistent start, ``R010`` for impossible times.
    """
    start, stop, tolerance = _span(system, request)
    times = output_times(request, start, stop)
    selector = StateSelector(system)
    begun = clock.perf_counter()
    states, values, warnings = start_values(system, selector, start)
    start_time = clock.perf_counter() - begun
    chosen = _chosen(system, request)
    trajectories = Trajectories(
        system.names, system.derivative, system.representative, system.sign, chosen
    )
    run = _Run(system, request, Recorder(chosen, trajectories.segments), selector, tolerance, stop)
    events = time_events(
        system.differentiated.families, system.definitions, system.parameters,
        system.representative, system.sign, start, stop,
    )  # fmt: skip
    run.begin(start, values, states)
    run.record_here()
    warned: set[int] = set()
    remarks = violations(system, trajectories.segments, warned)
    if any(d.severity is Severity.ERROR for d in remarks):
        run.totals()
        raise AcausalError(remarks)
    done = 1
    for boundary in [*events.tolist(), stop]:
        is_event = boundary != stop
        limit = _before(boundary, stop - start) if is_event else stop
        if limit <= run.time:
            continue
        last = int(np.searchsorted(times, limit, "right"))
        part = times[done:last]
        if is_event and (not len(part) or part[-1] < limit):
            part = np.append(part, limit)
        if not run.integrate(part, limit):
            break
        done = last
        if is_event:
            if not _pass_event(run, boundary):
                break
            if done < len(times) and times[done] <= boundary:
                done += 1
    statistics = run.totals()
    statistics["start_time"] = start_time
    failure = run.failure.diagnostics if run.failure is not None else ()
    remarks += violations(system, trajectories.segments, warned)
    if any(d.severity is Severity.ERROR for d in remarks) and run.ending is Ending.COMPLETE:
        run.ending = Ending.FAILED
    return Result(
        system.name,
        system.description,
        trajectories.times,
        trajectories,
        [system.names.variable(int(i)) for i in states[:50] if i < _declared(system)],
        _Parameters(system),
        run.events,
        statistics,
        {
            "start_time": start,
            "stop_time": stop,
            "tolerance": tolerance,
            "solver": request.solver,
        },
        run.ending,
        (*warnings, *selector.warnings(), *remarks, *failure),
    )


def _declared(system: System) -> int:
    return len(system.representative)


def _before(t: float, span: float) -> float:
    """Return a time just before an event, close enough to change nothing."""
    return t - 1e-13 * max(abs(t), span)


def _pass_event(run: _Run, boundary: float) -> bool:
    """Solve for the values right after a time event; return False if that fails."""
    assert run.current is not None
    try:
        values = restart_values(run.system, run.current.states, run.values(), boundary)
    except AcausalError as error:
        run.failure, run.ending = error, Ending.FAILED
        return False
    run.events.append(Event(boundary, "time event"))
    run.begin(boundary, values, run.current.states)
    run.record_here()
    return True


def _span(system: System, request: Request) -> tuple[float, float, float]:
    experiment = system.experiment
    start = experiment.start_time if request.start_time is None else request.start_time
    stop = request.stop_time
    if stop is None:
        stop = experiment.stop_time if experiment.stop_time is not None else start + 1.0
    if not (np.isfinite(start) and np.isfinite(stop) and stop > start):
        fail("R010", f"cannot simulate from {start:g} s to {stop:g} s",
             help="the stop time must be after the start time")  # fmt: skip
    tolerance = request.tolerance or experiment.tolerance or DEFAULT_TOLERANCE
    if not 0 < tolerance < 1:
        fail("R010", f"a tolerance of {tolerance:g} is not possible",
             help="use a small number, such as 1e-6")  # fmt: skip
    return start, stop, tolerance


def _chosen(system: System, request: Request) -> Ids | None:
    if request.variables is None:
        return None
    ids: set[int] = set()
    for pattern in request.variables:
        found = system.names.find_variables(pattern)
        if not found:
            close = system.names.suggestions(pattern)
            fail("N901", f"there is no variable {pattern}",
                 notes=[f"did you mean {' or '.join(close)}?"] if close else [],
                 help="acausal inspect shows the variables of a model")  # fmt: skip
        ids |= {i for _, i in found}
    return np.array(sorted(ids), np.int64)


class _Parameters(dict[str, float]):
    """Parameter values by path, filled when first asked for."""

    def __init__(self, system: System) -> None:
        super().__init__()
        self._system = system
        self._filled = False

    def __getitem__(self, path: str) -> float:
        found = self._system.names.find_parameters(path)
        if len(found) != 1:
            raise KeyError(path)
        return float(self._system.parameters[found[0][1]])

    def _fill(self) -> None:
        if not self._filled:
            self._filled = True
            for path, number in self._system.names.find_parameters("*"):
                super().__setitem__(path, float(self._system.parameters[number]))

    def __iter__(self) -> Iterator[str]:
        self._fill()
        return super().__iter__()

    def __len__(self) -> int:
        self._fill()
        return super().__len__()

    def items(self) -> dict_items[str, float]:
        """Return paths and values."""
        self._fill()
        return super().items()
