"""Points of a sweep: grids, lists and samples of distributions."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from acausal.diagnostics import fail

#: One run: values by parameter path, or by ``start(path)`` for the start value of a variable.
Point = Mapping[str, float | str]

_START = re.compile(r"start\((.+)\)")


def grid(values: Mapping[str, Iterable[float | str]]) -> list[dict[str, float | str]]:
    """Return all combinations, the last name changing fastest.

    Args:
        values: Values to try by name.

    Raises:
        AcausalError: ``F141`` for a name without values.

    Example:
        >>> grid({"r.R": [1, 2], "c.C": [1e-6]})
        [{'r.R': 1.0, 'c.C': 1e-06}, {'r.R': 2.0, 'c.C': 1e-06}]
    """
    columns = {name: _numbers(name, column) for name, column in values.items()}
    return [dict(zip(columns, row, strict=True)) for row in itertools.product(*columns.values())]


def sampled(
    distributions: Mapping[str, Any], samples: int, seed: int = 0
) -> list[dict[str, float | str]]:
    """Draw points from independent distributions.

    Args:
        distributions: SciPy's frozen distributions by name (``scipy.stats.norm(100, 5)``), or
            single numbers.
        samples: Number of points.
        seed: The same seed gives the same points.

    Raises:
        AcausalError: ``F141`` for what is no distribution, or fewer than one sample.

    Example:
        >>> from scipy.stats import uniform
        >>> points = sampled({"r.R": uniform(90, 20)}, samples=100)
    """
    if samples < 1:
        fail("F141", f"{samples} samples cannot be drawn", help="ask for at least one")
    generator = np.random.default_rng(seed)
    columns: dict[str, Any] = {}
    for name, distribution in distributions.items():
        if isinstance(distribution, (int, float)):
            columns[name] = np.full(samples, float(distribution))
        elif hasattr(distribution, "rvs"):
            columns[name] = np.asarray(distribution.rvs(size=samples, random_state=generator))
        else:
            fail("F141", f"{name} has no distribution",
                 help="give one of scipy.stats with its parameters, or a number")  # fmt: skip
    return [{name: float(c[k]) for name, c in columns.items()} for k in range(samples)]


def _numbers(name: str, column: Iterable[float | str]) -> list[float | str]:
    if isinstance(column, str) or not isinstance(column, Iterable):
        column = [column]
    found = [value if isinstance(value, str) else float(value) for value in column]
    if not found:
        fail("F141", f"{name} has no values", help="give at least one")
    return found


def split(point: Point) -> tuple[dict[str, float | str], dict[str, float | str]]:
    """Return the parameters and the start values of a point."""
    parameters: dict[str, float | str] = {}
    starts: dict[str, float | str] = {}
    for name, value in point.items():
        start = _START.fullmatch(name)
        if start is None:
            parameters[name] = value
        else:
            starts[start.group(1)] = value
    return parameters, starts


def as_points(points: object) -> list[dict[str, float | str]]:
    """Return points of a list of mappings or of a pandas data frame.

    Raises:
        AcausalError: ``F141`` for anything else.
    """
    if hasattr(points, "to_dict") and hasattr(points, "columns"):
        points = points.to_dict("records")
    if not isinstance(points, Sequence) or not all(isinstance(p, Mapping) for p in points):
        fail("F141", "points are a list of dictionaries, or a data frame",
             help='write [{"r.R": 1}, {"r.R": 2}]')  # fmt: skip
    return [{str(n): v if isinstance(v, str) else float(v) for n, v in p.items()} for p in points]
