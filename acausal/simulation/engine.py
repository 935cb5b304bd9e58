"""One simulation: consistent start, integration from event to event, results."""

from __future__ import annotations

import time as clock
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from os import PathLike
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import AcausalError, Diagnostic, Severity, fail
from acausal.flattening.model import Ids
from acausal.results.result import Ending, Result
from acausal.results.snapshot import Snapshot
from acausal.results.table import TableSource
from acausal.simulation.assertions import violations
from acausal.simulation.dense import DenseRecord, DenseRun
from acausal.simulation.event_handler import EventHandler
from acausal.simulation.failure_places import told
from acausal.simulation.folds import Folds
from acausal.simulation.output import Recorder, output_times
from acausal.simulation.request import Request
from acausal.simulation.run import SNAPSHOTS, Reached, Run
from acausal.simulation.start import resumed_values, start_values
from acausal.simulation.states import StateSelector
from acausal.simulation.system import System
from acausal.simulation.trajectories import Trajectories

if TYPE_CHECKING:
    from acausal.results.stream import Stream

Array = NDArray[np.float64]

DEFAULT_TOLERANCE = 1e-6


def simulate(system: System, request: Request) -> Result:
    """Simulate a model.

    A run that fails or is interrupted on its way returns what it has, with the reason in
    ``diagnostics``.

    Raises:
        AcausalError: ``I0xx`` if there is no consistent start, ``R010`` for impossible times.
    """
    start, stop, tolerance = _span(system, request)
    if request.output is not None:
        from acausal.results.files import check_target
        from acausal.results.stream import SUFFIXES

        check_target(request.output, SUFFIXES)
    elif not request.keep:
        fail("R010", "a result that is not kept needs a file", help='give output="run.nc"')
    times = output_times(request, start, stop)
    selector = StateSelector(system)
    begun = clock.perf_counter()
    snapshot = request.continue_from
    if snapshot is None:
        begin = start_values(system, selector, start)
    else:
        begin = resumed_values(system, selector, snapshot)
    start_time = clock.perf_counter() - begun
    chosen = _chosen(system, request)
    trajectories = Trajectories(
        system.names, system.derivative, system.representative, system.sign, chosen
    )
    recorder = Recorder(chosen, trajectories.segments, keep=request.keep)
    warned: set[int] = set()
    remarks: list[Diagnostic] = []
    if (chosen is not None or not request.keep) and system.assertions:
        recorder.look = lambda segment: remarks.extend(violations(system, [segment], warned))
    run = Run(
        system, request, recorder, selector, tolerance, stop, begin.parameters, begin.relations
    )
    if request.dense:
        run.dense = DenseRecord()
    handler = EventHandler(run, start) if begin.relations is not None else None
    run.begin(start, begin.values, begin.states)
    if handler is not None and snapshot is None:
        handler.started()
    elif handler is not None and snapshot is not None:
        handler.resumed(snapshot.memory, not np.array_equal(begin.parameters, snapshot.parameters))
    stream = None
    if request.output is not None:
        head = _head(system, request, start, stop, tolerance)
        stream, recorder.written = _open(request.output, head, trajectories)
        recorder.sink = stream.add
    try:
        run.record_here()
        recorder.flush()
        remarks += violations(system, trajectories.segments, warned)
        if any(d.severity is Severity.ERROR for d in remarks):
            run.totals()
            raise AcausalError(remarks)
        wall, processor = clock.perf_counter(), clock.process_time()
        with _until_full(run, stream):
            _go(run, handler, times, stop)
        end = _standing(run, handler)
        if handler is not None:
            handler.finish()
        with _until_full(run, stream):
            recorder.flush()
    except BaseException:
        if stream is not None:
            stream.finish()
        raise
    run.solve_time = clock.perf_counter() - wall
    run.solve_cpu_time = clock.process_time() - processor
    failure = told(run)
    statistics = run.totals()
    statistics["start_time"] = start_time
    remarks += violations(system, trajectories.segments, warned)
    if handler is not None:
        remarks += handler.remarks
    if any(d.severity is Severity.ERROR for d in remarks) and run.ending is Ending.COMPLETE:
        run.ending = Ending.FAILED
    dense = None
    if run.dense is not None:
        run.dense.flush()
        dense = DenseRun(trajectories, run.dense.pieces) if run.dense.pieces else None
    streamed = stream is not None and not request.keep
    result = replace(
        _head(system, request, start, stop, tolerance),
        times=np.zeros(0) if streamed else trajectories.times,
        variables=trajectories,
        states=[system.names.variable(int(i)) for i in begin.states[:50] if i < _declared(system)],
        events=run.events,
        statistics=statistics,
        ending=run.ending,
        diagnostics=(*begin.warnings, *selector.warnings(), *remarks, *failure),
        end=end,
        dense=dense,
    )
    return result if stream is None else _closed(stream, result, trajectories, request.keep)


def _open(
    path: str | PathLike[str], head: Result, trajectories: Trajectories
) -> tuple[Stream, list[int]]:
    """Return the file that is written while the run goes on, and which ids it takes."""
    from acausal.results.stream import Stream

    if trajectories.chosen is None:
        found = sorted(trajectories.names.find_variables("*"), key=lambda pair: pair[1])
        paths, ids = [path for path, _ in found], [number for _, number in found]
    else:
        paths, ids = list(trajectories.paths()), trajectories.chosen.tolist()
    return Stream(path, replace(head, variables=trajectories), paths), ids


def _closed(stream: Stream, result: Result, trajectories: Trajectories, keep: bool) -> Result:
    """Complete the file; a result that is not kept in memory reads it when asked."""
    stream.finish(result)
    if keep:
        return result
    from acausal.results.stream import StreamedSource, read_columns

    source = StreamedSource(stream, trajectories)
    return replace(result, variables=source, times=read_columns(stream.path, ["time"])[:, 0])


@contextmanager
def _until_full(run: Run, stream: Stream | None) -> Iterator[None]:
    """Let a full disk end the run, with what was computed until then."""
    try:
        yield
    except AcausalError as error:
        if stream is None or not stream.full:
            raise
        run.fail(error)


def _head(system: System, request: Request, start: float, stop: float, tolerance: float) -> Result:
    """Return what is known of a result before the run."""
    return Result(
        system.name,
        system.description,
        np.zeros(0),
        TableSource({}),
        parameters=_Parameters(system),
        experiment={
            "start_time": start,
            "stop_time": stop,
            "tolerance": tolerance,
            "solver": request.solver,
        },
        parameter_units=_ParameterUnits(system),
    )


def _declared(system: System) -> int:
    return len(system.representative)


def _go(run: Run, handler: EventHandler | None, times: Array, stop: float) -> None:
    """Integrate from event to event."""
    done = 1
    folds = Folds(run, run.time)
    run.spacing = SNAPSHOTS * (stop - run.time)
    while run.time < stop:
        limit = stop if handler is None else min(handler.limit, stop)
        last = done  # between events that follow each other closely there is nothing to store
        if done < len(times) and times[done] <= limit:
            last = int(np.searchsorted(times, limit, "right"))
        if limit > run.time:
            reached, stored = run.integrate(times[done:last], limit)
            done += stored
            if reached is Reached.OVER:
                run.time = run.integrator.t if run.integrator is not None else run.time
                if not folds.overcome():
                    return
                if handler is not None:
                    handler.leapt()
                continue
            if handler is None:
                continue
            found = reached is Reached.ROOT
            if (found or run.time >= handler.next_time) and not handler.handle(found):
                return
        elif handler is None or not handler.handle(False):
            return
        while done < len(times) and times[done] <= run.time:
            done += 1


def _standing(run: Run, handler: EventHandler | None) -> Snapshot | None:
    """Return where a run stands, so that another one can go on; None after a failure."""
    if run.ending is Ending.FAILED or run.current is None or run.integrator is None:
        return None
    return Snapshot(
        run.system.name, run.time, run.current.states.copy(), run.values(),
        run.current.parameters.copy(), {} if handler is None else handler.memory(),
    )  # fmt: skip


def _span(system: System, request: Request) -> tuple[float, float, float]:
    experiment = system.experiment
    start = experiment.start_time if request.start_time is None else request.start_time
    if request.continue_from is not None:
        start = request.continue_from.time
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
    return float(start), float(stop), tolerance


def _chosen(system: System, request: Request) -> Ids | None:
    if request.kept is not None:
        return np.array(sorted(request.kept), np.int64)
    if request.variables is None:
        return None
    ids: set[int] = set()
    for pattern in request.variables:
        found = system.names.find_variables(pattern)
        if not found:
            found = _needed(system, pattern)
        if not found:
            close = system.names.suggestions(pattern)
            fail("N901", f"there is no variable {pattern}",
                 notes=[f"did you mean {' or '.join(close)}?"] if close else [],
                 help="acausal inspect shows the variables of a model")  # fmt: skip
        ids |= {i for _, i in found}
    return np.array(sorted(ids), np.int64)


def _needed(system: System, text: str) -> list[tuple[str, int]]:
    """Return the variables that an expression needs, none if the text is not one."""
    from acausal.results.expressions import is_expression, paths_within

    if not is_expression(text):
        return []

    def find(pattern: str) -> list[str]:
        return [path for path, _ in system.names.find_variables(pattern)]

    return [f for p in paths_within(text, find) for f in system.names.find_variables(p)]


class _ParameterUnits(dict[str, str]):
    """Unit texts of parameters by path, found when asked for."""

    def __init__(self, system: System) -> None:
        super().__init__()
        self._system = system

    def __missing__(self, path: str) -> str:
        names = self._system.names
        found = names.find_parameters(path)
        return names.parameter_unit(found[0][1]) if len(found) == 1 else ""

    def get(self, path: str, default: str = "") -> str:  # type: ignore[override]
        """Return a unit text, the default if there is none."""
        return self[path] or default


class _Parameters(Mapping[str, float]):
    """Parameter values by path, named when first asked for."""

    def __init__(self, system: System) -> None:
        self._system = system
        self._every: dict[str, float] | None = None

    def __getitem__(self, path: str) -> float:
        found = self._system.names.find_parameters(path)
        if len(found) != 1:
            raise KeyError(path)
        return float(self._system.parameters[found[0][1]])

    def _all(self) -> dict[str, float]:
        if self._every is None:
            found = self._system.names.find_parameters("*")
            self._every = {path: float(self._system.parameters[k]) for path, k in found}
        return self._every

    def __iter__(self) -> Iterator[str]:
        return iter(self._all())

    def __len__(self) -> int:
        return len(self._all())
