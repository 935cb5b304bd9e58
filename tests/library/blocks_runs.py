"""Running small models of blocks."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from acausal import compile_text

Array = NDArray[np.float64]


def run(text: str, stop_time: float = 1.0, **options: Any) -> Any:
    """Return the result of a model with the given body."""
    options = {"tolerance": 1e-8, "points": 101, **options}
    return compile_text(f"model Test\n{text}\nend Test;\n").simulate(stop_time=stop_time, **options)


def values(result: Any, path: str) -> Array:
    """Return the values of a variable."""
    return np.asarray(result[path].values, np.float64)


def jumps(result: Any, path: str) -> list[tuple[float, float]]:
    """Return when a piecewise constant variable changes, and to what."""
    found = values(result, path)
    times = np.asarray(result.times)
    changed = np.flatnonzero(np.diff(found))
    assert np.array_equal(times[changed], times[changed + 1]), "it changes between events"
    return [(float(times[k]), float(found[k + 1])) for k in changed]


def after(result: Any, path: str, time: float) -> float:
    """Return the last value at a time that is in the result."""
    at = np.flatnonzero(np.asarray(result.times) == time)
    assert len(at), f"{time} is not in the result"
    return float(values(result, path)[at[-1]])
