"""S21: magnetic valve: time to 90 % of the travel, and what shortens it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

MU_0 = 1.25663706212e-6
#: Time to 90 % of the travel in milliseconds: the larger the shorter.
EXPECTED = {
    "AbsValve": {},
    "Boosted": {"voltage": 48.0},
    "FewerTurns": {"turns": 150.0},
    "Slotted": {"eddy": 500.0},
    "Light": {"mass": 3e-3},
    "ShortTravel": {"travel": 0.17e-3},
}


def iron(flux: float, length: float, area: float) -> float:
    """Return the reluctance of steel 9SMnPb28."""
    relative = abs(flux) / area / 1.488
    permeability = 1 + (399 + 1200 * relative) / (1 + 3 * relative + relative**12.5)
    return length / (MU_0 * permeability * area)


def time_to_open(
    voltage: float = 12.0,
    turns: float = 300.0,
    eddy: float = 6000.0,
    mass: float = 6e-3,
    travel: float = 0.25e-3,
) -> float:
    resistance, radius = 4 * (turns / 300) ** 2, 3.5e-3
    core, yoke = np.pi * radius**2, np.pi * (9e-3**2 - 8e-3**2)
    guide = np.log(3.7 / 3.5) / (2 * np.pi * MU_0 * 5e-3)
    seat, drop = np.pi / 4 * 0.8e-3**2, 97e5

    def equations(_: float, x: Any) -> list[float]:
        flux, s, v = x
        gap = 0.06e-3 + travel - s
        permeance = MU_0 * (core / gap + 22e-3 / np.pi * np.log(1 + np.pi * 1.5e-3 / gap))
        slope = MU_0 * (core / gap**2 + 22e-3 * 1.5e-3 / (gap**2 + np.pi * 1.5e-3 * gap))
        reluctance = iron(flux, 20e-3, core) + iron(flux, 25e-3, yoke) + guide + 1 / permeance
        rate = (turns * voltage / resistance - reluctance * flux) / (turns**2 / resistance + eddy)
        opening = min(seat, np.pi * 0.8e-3 * np.sin(np.pi / 4) * max(s, 0))
        flow = 2 * 0.7**2 * np.cos(np.pi / 4) * opening * drop
        force = (flux / permeance) ** 2 / 2 * slope + seat * drop - flow - 8 - 2000 * s - 3 * v
        return [rate, v, 0.0 if s <= 0 and force < 0 else force / mass]

    def opened(_: float, x: Any) -> float:
        return float(x[1] - 0.9 * travel)

    opened.terminal = True  # type: ignore[attr-defined]
    found = solve_ivp(
        equations,
        (0, 0.01),
        [0, 0, 0],
        "Radau",
        events=opened,
        rtol=1e-8,
        atol=1e-12,
        max_step=1e-5,
    )
    return float(found.t_events[0][0])


@pytest.mark.parametrize("model", EXPECTED)
def test_time_to_90_percent(simulate: Any, model: str) -> None:
    result = simulate("abs_valve", model, stop_time=0.015, interval=1e-5, tolerance=1e-7)
    assert result.times[-1] == pytest.approx(0.015)
    lift = np.asarray(result["armature.s"].values)
    travel = EXPECTED[model].get("travel", 0.25e-3)
    assert np.max(lift) == pytest.approx(travel, rel=1e-6)
    assert np.min(lift) > -1e-9
    found = float(np.asarray(result["t90"].values)[-1])
    assert found == pytest.approx(time_to_open(**EXPECTED[model]), rel=0.01)
    if model != "AbsValve":
        assert found < 0.95 * time_to_open()


def test_pressure_falls_while_the_valve_is_open(simulate: Any) -> None:
    result = simulate("abs_valve", "AbsValve", stop_time=0.015, interval=1e-5, tolerance=1e-7)
    pressure = np.asarray(result["brake.p"].values)
    lift = np.asarray(result["armature.s"].values)
    shut = lift < 1e-9
    falling = np.gradient(pressure, result.times + np.arange(len(lift)) * 1e-12)
    assert np.max(np.abs(falling[shut][1:50])) < 1e5
    assert pressure[0] == pytest.approx(100e5)
    assert 50e5 < pressure[-1] < 70e5
    # full lift: the orifice law, with the compressibility of brake and liquid
    k = int(np.searchsorted(result.times, 5e-3))
    area = np.pi * 0.8e-3 * np.sin(np.pi / 4) * 0.25e-3
    flow = 0.7 * area * np.sqrt(2 * (pressure[k] - 3e5) / 1070)
    stiffness = 1 / (2e-6 * (1 / 1.6e9 + 5e-8))
    assert falling[k] == pytest.approx(-flow * stiffness, rel=0.02)
