"""Sweeps: one compiled model, many values of its parameters and start values."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from acausal.compiler import Compiled
from acausal.diagnostics import AcausalError, fail
from acausal.runs.executors import processors, run_here, run_in_processes, run_on_cluster
from acausal.runs.job import Job, Labels, Outcome
from acausal.runs.points import Point, as_points, grid, sampled, split
from acausal.runs.store import Store, digest
from acausal.runs.study import Study
from acausal.simulation.request import Request

#: Outcomes that are written together.
STORED_TOGETHER = 50
#: Below so many points a pool of processes costs more than it saves.
WORTH_A_POOL = 8


def sweep(
    compiled: Compiled,
    values: Mapping[str, Any],
    *,
    samples: int | None = None,
    seed: int = 0,
    **options: Any,
) -> Study:
    """Simulate a model for all combinations of values, or for samples of distributions.

    Args:
        compiled: The model.
        values: Values to try by parameter path (``start(path)`` for a start value); or, with
            ``samples``, distributions of ``scipy.stats``.
        samples: Number of points to draw.
        seed: Of the samples; the same seed gives the same points.
        options: Those of :func:`simulate_many`.

    Raises:
        AcausalError: ``F141`` for values that are none, and as :func:`simulate_many`.

    Example:
        >>> compiled = compile_file("examples/rlc.acm")
        >>> study = sweep(compiled, {"r.R": [50, 100, 200], "c.C": [1e-6, 2e-6]}, stop_time=0.1)
        >>> len(study)
        6
    """
    cases = grid(values) if samples is None else sampled(values, samples, seed)
    return simulate_many(compiled, cases, **options)


def simulate_many(
    compiled: Compiled,
    cases: Iterable[Point] | Any,
    /,
    *,
    start_time: float | None = None,
    stop_time: float | None = None,
    tolerance: float | None = None,
    solver: str = "ida",
    points: int | None = None,
    interval: float | None = None,
    variables: Sequence[str] | None = None,
    max_step: float = float("inf"),
    workers: int | None = None,
    scheduler: str | None = None,
    store: str | Path | None = None,
    progress: bool | Callable[[int, int], None] = False,
) -> Study:
    """Simulate a model at given points.

    A point that fails is recorded and stops nothing. Points whose values decide about the
    structure of the model are compiled for it.

    Args:
        compiled: The model.
        cases: Points: dictionaries of values by parameter path (``start(path)`` for a start
            value), or a pandas data frame.
        start_time: Seconds; this and the following as in
            :meth:`~acausal.compiler.Compiled.simulate`.
        stop_time: Seconds.
        tolerance: Relative tolerance.
        solver: Name of the integrator.
        points: Number of equidistant output points of each run.
        interval: Distance of output points, seconds.
        variables: Patterns of the variables to keep; everything by default.
        max_step: Largest step, seconds.
        workers: Number of processes; by default one for each processor if that pays, 1 for
            none besides this one.
        scheduler: Address of a Dask scheduler, to run the points on its workers.
        store: Folder to write outcomes to while the sweep runs. A sweep that is started again
            with the same folder goes on where it stopped.
        progress: True for a progress bar, or a function that is called with the number of
            points done and to do.

    Raises:
        AcausalError: ``N901`` for variables that do not exist, ``F140`` to ``F142`` for points,
            stores and schedulers that cannot be used, ``R010`` for impossible times.
    """
    given = as_points(cases if hasattr(cases, "columns") else list(cases))
    system = compiled.system
    if interval is None and points is None:
        interval = system.experiment.interval
    ids = _ids(compiled, variables)
    request = Request(
        start_time, stop_time, tolerance, solver, points, interval, None, None, max_step,
        None if variables is None else ids,
    )  # fmt: skip
    job = Job(compiled.changed_values(), request, ids)
    labels = _labels(compiled, ids)
    outcomes: list[Outcome | None] = [None] * len(given)
    kept = _store(store, job, labels, given)
    if kept is not None:
        for outcome in kept.outcomes():
            outcomes[outcome.number] = outcome
    todo: list[tuple[int, Point]] = [(k, p) for k, p in enumerate(given) if outcomes[k] is None]
    interrupted = False
    collected: list[Outcome] = []
    with _Progress(progress, len(given), len(given) - len(todo)) as shown:
        try:
            for found in _run(job, todo, workers, scheduler):
                for outcome in found:
                    if outcome.again:
                        outcome = _compiled_anew(compiled, job, outcome.number, given)
                    outcomes[outcome.number] = outcome
                    collected.append(outcome)
                    shown.add()
                if kept is not None and len(collected) >= STORED_TOGETHER:
                    kept.add(collected)
                    collected = []
        except KeyboardInterrupt:
            interrupted = True
        finally:
            if kept is not None and collected:
                kept.add(collected)
    return Study(given, outcomes, labels, interrupted)


def _run(
    job: Job, todo: list[tuple[int, Point]], workers: int | None, scheduler: str | None
) -> Iterator[list[Outcome]]:
    if not todo:
        return iter(())
    if scheduler is not None:
        return run_on_cluster(job, todo, scheduler)
    if workers is None:
        workers = processors() if len(todo) >= WORTH_A_POOL else 1
    if workers < 1:
        fail("F141", f"{workers} processes cannot run anything", help="give 1 or more")
    if workers == 1:
        return run_here(job, todo)
    return run_in_processes(job, todo, min(workers, len(todo)))


def _compiled_anew(compiled: Compiled, job: Job, number: int, points: Sequence[Point]) -> Outcome:
    """Run a point for which the model has to be compiled."""
    parameters, starts = split(points[number])
    try:
        own = compiled.with_values(parameters, starts)
        names = compiled.system.names
        ids = tuple(own.system.names.find_variables(names.variable(i))[0][1] for i in job.ids)
        from acausal.simulation.engine import simulate

        request = replace(job.request, kept=None if job.request.kept is None else ids)
        return replace(job, ids=ids).outcome(number, simulate(own.system, request))
    except AcausalError as error:
        return Outcome(number, np.zeros(0), np.zeros((0, 0)), {}, error.diagnostics[0])
    except IndexError:
        problem = _other_variables(number)
        return Outcome(number, np.zeros(0), np.zeros((0, 0)), {}, problem.diagnostics[0])


def _other_variables(number: int) -> AcausalError:
    try:
        fail("F144", f"point {number} makes a model with other variables",
             help="keep variables that all points have: variables = [...]")  # fmt: skip
    except AcausalError as error:
        return error


def _ids(compiled: Compiled, variables: Sequence[str] | None) -> tuple[int, ...]:
    names = compiled.system.names
    ids: set[int] = set()
    for pattern in ["*"] if variables is None else variables:
        found = names.find_variables(pattern)
        if not found and variables is not None:
            close = names.suggestions(pattern)
            fail("N901", f"there is no variable {pattern}",
                 notes=[f"did you mean {' or '.join(close)}?"] if close else [],
                 help="acausal inspect shows the variables of a model")  # fmt: skip
        ids |= {i for _, i in found}
    return tuple(sorted(ids))


def _labels(compiled: Compiled, ids: Sequence[int]) -> Labels:
    system = compiled.system
    names = system.names
    paths = tuple(names.variable(i) for i in ids)
    states = tuple(
        path for path, i in zip(paths, ids, strict=True)
        if system.active[i] and system.derivative[i] >= 0
    )  # fmt: skip
    return Labels(
        system.name, system.description, paths, states,
        {p: names.unit(i) for p, i in zip(paths, ids, strict=True)},
        {p: names.description(i) for p, i in zip(paths, ids, strict=True)},
    )  # fmt: skip


def _store(
    folder: str | Path | None, job: Job, labels: Labels, points: Sequence[Point]
) -> Store | None:
    if folder is None:
        return None
    request = job.request
    system = job.changed.of
    study = {
        "model": labels.model_name,
        # What the model is: templates, how they are joined, and all values.
        "equations": digest(
            [(f.template, f.operands.tobytes()) for f in system.differentiated.families],
            system.parameters.tobytes(), system.variables.start.tobytes(),
        ),
        "points": [dict(p) for p in points],
        "variables": list(labels.paths),
        "options": [
            request.start_time, request.stop_time, request.tolerance, request.solver,
            request.points, request.interval, str(request.max_step),
        ],
    }  # fmt: skip
    return Store(folder, study, labels.paths)


class _Progress:
    """A progress bar, a function that is told, or nothing."""

    def __init__(self, wanted: bool | Callable[[int, int], None], total: int, done: int) -> None:
        self._wanted, self._total, self._done = wanted, total, done
        self._bar: Any = None

    def __enter__(self) -> _Progress:
        if self._wanted is True:
            import click

            self._bar = click.progressbar(
                length=self._total, label="sweep", show_pos=True, show_eta=True
            )
            self._bar.__enter__()
            self._bar.update(self._done)
        return self

    def add(self) -> None:
        """One more point is done."""
        self._done += 1
        if self._bar is not None:
            self._bar.update(1)
        elif callable(self._wanted):
            self._wanted(self._done, self._total)

    def __exit__(self, *error: object) -> None:
        if self._bar is not None:
            self._bar.__exit__(*error)
