"""Running small hybrid models, and reading what happened at their events."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from acausal import compile_text

Array = NDArray[np.float64]


def run(text: str, stop_time: float = 2.0, *, ending: str = "complete", **options: Any) -> Any:
    """Return the result of a model, which has to end as expected."""
    parameters = options.pop("parameters", None)
    options = {"tolerance": 1e-8, "points": 51, **options}
    result = compile_text(text, parameters=parameters).simulate(stop_time=stop_time, **options)
    assert result.ending.value == ending, result.diagnostics
    return result


def values(result: Any, path: str) -> Array:
    """Return the values of a variable."""
    return np.asarray(result[path].values, np.float64)


def last(result: Any, path: str) -> float:
    """Return the last value of a variable."""
    return float(values(result, path)[-1])


def instants(result: Any) -> Array:
    """Return the times of the events in the list of events, each once."""
    return np.unique([event.time for event in result.events])


def sides(result: Any, path: str, time: float) -> tuple[float, float]:
    """Return the values just before and just after the event next to a time."""
    times = np.asarray(result.times)
    double = times[:-1][np.diff(times) == 0]
    at = double[np.argmin(np.abs(double - time))]
    assert abs(at - time) <= 1e-6 * max(abs(time), 1e-3), f"no event at {time}: {double}"
    both = np.flatnonzero(times == at)
    found = values(result, path)
    return float(found[both[0]]), float(found[both[-1]])


def jumps(result: Any, path: str) -> list[tuple[float, float]]:
    """Return when a piecewise constant variable changes, and to what."""
    found = values(result, path)
    times = np.asarray(result.times)
    changed = np.flatnonzero(np.diff(found))
    assert np.array_equal(times[changed], times[changed + 1]), "it changes between events"
    return [(float(times[k]), float(found[k + 1])) for k in changed]
