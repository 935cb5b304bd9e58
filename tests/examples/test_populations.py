"""S13 and S14: populations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest


def periods(times: Any, signal: Any) -> Any:
    """Distances of the upward crossings of the mean level."""
    level = signal - 1
    up = np.nonzero((level[:-1] < 0) & (level[1:] >= 0))[0]
    crossing = times[up] - level[up] * (times[up + 1] - times[up]) / (level[up + 1] - level[up])
    return np.diff(crossing)


def test_volterra_invariant_and_equal_periods(simulate: Any) -> None:
    result = simulate("predator_prey", "PredatorPrey", stop_time=60, tolerance=1e-10, points=6001)
    prey, predators = np.asarray(result["xB"].values), np.asarray(result["xR"].values)
    assert result["invariant"].values == pytest.approx(2 - np.log(2) + 0.5 - np.log(0.5), abs=1e-6)
    of_prey, of_predators = periods(result.times, prey), periods(result.times, predators)
    assert len(of_prey) >= 7
    assert of_prey == pytest.approx(of_prey[0], rel=1e-5)
    assert of_predators[:5] == pytest.approx(of_prey[0], rel=1e-5)


def test_logistic_variant_settles(simulate: Any) -> None:
    result = simulate("predator_prey", "PredatorPreyLogistic", stop_time=200, tolerance=1e-9)
    # a - e xB - b xR = 0 and d xB - c - f xR = 0
    rest = np.linalg.solve([[0.1, 1], [1, -0.1]], [1, 1])
    assert [result["xB"].values[-1], result["xR"].values[-1]] == pytest.approx(rest, rel=1e-4)


def test_logistic_growth_in_closed_form(simulate: Any) -> None:
    result = simulate("logistic_growth", "LogisticGrowth", stop_time=10, tolerance=1e-9)
    expected = 1 / (1 + 9 * np.exp(-result.times))
    assert result["x"].values == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize(("start", "end"), [(2.0, 8.0), (3.0, 8.0), (12.0, 8.0), (8.0, 8.0)])
def test_harvest_settles_at_the_upper_equilibrium(simulate: Any, start: float, end: float) -> None:
    # k/2 (1 +- sqrt(1 - 4 h/(a k))) = 5 (1 +- 0.6); the lower one, 2, is unstable
    start = start + 0.01 if start == 2.0 else start
    result = simulate("logistic_growth", "Harvest", {"x0": start}, stop_time=40, tolerance=1e-9)
    assert result["x"].values[-1] == pytest.approx(end, abs=1e-3)
