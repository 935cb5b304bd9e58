"""What a worker gets once, and what it gives back for each point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acausal.compiler import parameter_numbers
from acausal.diagnostics import AcausalError, Diagnostic
from acausal.results.result import Event, Result
from acausal.results.table import TableSource
from acausal.runs.points import Point, split
from acausal.simulation.changed_values import ChangedValues, StructureChanges
from acausal.simulation.engine import simulate
from acausal.simulation.request import Request
from acausal.simulation.trajectories import Trajectories

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Outcome:
    """One point, run.

    Attributes:
        number: Of the point.
        times: Stored times, seconds, shape ``(nt,)``.
        values: Stored variables, shape ``(nt, nv)``.
        about: Ending, events, statistics and experiment of the result.
        error: Why there is no result, or why it ended early; None if it is complete.
        again: The values decide about the structure: it has to be compiled for this point.
    """

    number: int
    times: Array
    values: Array
    about: Mapping[str, Any]
    error: Diagnostic | None = None
    again: bool = False


@dataclass(frozen=True)
class Job:
    """A compiled model with what is asked of every run.

    Attributes:
        changed: Makes systems with other values.
        request: The run.
        ids: Variables to give back.
    """

    changed: ChangedValues
    request: Request
    ids: tuple[int, ...]

    def run(self, number: int, point: Point) -> Outcome:
        """Run one point; whatever goes wrong with it is part of the outcome."""
        try:
            parameters, starts = split(point)
            system = self.changed.system(parameter_numbers(parameters), parameter_numbers(starts))
        except StructureChanges:
            return replace(_failed(number, None), again=True)
        except AcausalError as error:
            return _failed(number, error.diagnostics[0])
        try:
            return self.outcome(number, simulate(system, self.request))
        except AcausalError as error:
            return _failed(number, error.diagnostics[0])

    def outcome(self, number: int, result: Result) -> Outcome:
        """Return what is kept of a result."""
        source = result.variables
        assert isinstance(source, Trajectories)
        values = source.values_of(self.ids)
        bad = [d for d in result.diagnostics if d.severity.value == "error"]
        about = {
            "ending": result.ending,
            "events": [(e.time, e.text) for e in result.events],
            "statistics": dict(result.statistics),
            "experiment": dict(result.experiment),
        }
        return Outcome(number, result.times, values, about, bad[0] if bad else None)

    def run_chunk(self, points: Sequence[tuple[int, Point]]) -> list[Outcome]:
        """Run several points."""
        return [self.run(number, point) for number, point in points]


def _failed(number: int, error: Diagnostic | None) -> Outcome:
    return Outcome(number, np.zeros(0), np.zeros((0, 0)), {}, error)


def result_of(outcome: Outcome, point: Point, labels: Labels) -> Result:
    """Return the result of an outcome that has one."""
    columns = {path: outcome.values[:, k] for k, path in enumerate(labels.paths)}
    about = outcome.about
    return Result(
        labels.model_name,
        labels.description,
        outcome.times,
        TableSource(columns, labels.units, labels.descriptions),
        labels.states,
        {n: v for n, v in point.items() if not isinstance(v, str)},
        [Event(*event) for event in about["events"]],
        about["statistics"],
        about["experiment"],
        about["ending"],
        () if outcome.error is None else (outcome.error,),
    )


@dataclass(frozen=True)
class Labels:
    """What all runs of a sweep have in common.

    Attributes:
        model_name, description: Of the model.
        paths: Stored variables.
        states: Those of them that are states.
        units, descriptions: By path.
    """

    model_name: str
    description: str
    paths: tuple[str, ...]
    states: tuple[str, ...]
    units: Mapping[str, str]
    descriptions: Mapping[str, str]
