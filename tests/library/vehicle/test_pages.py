"""The examples on the pages about vehicles, multiports and one-dimensional mechanics."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acausal import compile_text
from tests.library.vehicle.running import magic_formula, values

DOCS = Path(__file__).parents[3] / "docs"


def example(page: str, **options: Any) -> Any:
    """Simulate the first example of a page."""
    found = re.search(r"```modelica\n(.*?)```", (DOCS / page).read_text(), re.DOTALL)
    assert found
    return compile_text(found.group(1)).simulate(**{"tolerance": 1e-8, **options})


def test_full_braking_of_one_axle() -> None:
    result = example("vehicle.md", stop_time=4)
    assert values(result, "brake.mode")[-1] == 0
    assert abs(values(result, "tyre.w")[-1]) < 1e-4
    rear = 1200 * 9.80665 * 1.2 / 2.6
    sliding = magic_formula(1.0, 12, 1.65, 1.1 * rear, 0.3) / 1200
    whole = 1.1 * 9.80665
    assert 0.25 * whole < sliding < 0.4 * whole
    v = values(result, "car.v_x")[-1]
    drag = 0.6 * 0.3 * 2 * v**2 / 1200
    assert -values(result, "car.a_x")[-1] - drag == pytest.approx(sliding, abs=0.08)


def test_heat_engine() -> None:
    result = example("multiport.md", stop_time=1)
    work = values(result, "engine.powerOut")
    assert work == pytest.approx(2 * 300**2)
    assert values(result, "source.port.Q_flow") == pytest.approx(-2 * work)


def test_absorber() -> None:
    result = example("mechanics.md", stop_time=5)
    expected = 0.1 * np.cos(2 * result.times)
    assert values(result, "body.s") == pytest.approx(expected, abs=1e-6)
