"""Heat in a house and in a motor: what is fed is stored or lost."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from tests.examples.conftest import Simulate


def values(result: object, path: str) -> np.ndarray:
    return np.asarray(result[path].values)  # type: ignore[index]


def test_house_keeps_warm_and_loses_what_the_boiler_gives(simulate: Simulate) -> None:
    result = simulate("heated_house", stop_time=86400, interval=30, tolerance=1e-7)
    t = result.times
    air, water = 12 * 1.149 * 1007, 4177
    stored, lost = 15 * water * values(result, "boiler.T"), 0.0
    for room, V, A in (("living", 75, 35), ("bedroom", 40, 20)):
        stored = stored + air * V * values(result, f"{room}.inside.T")
        stored = stored + 180e3 * A * values(result, f"{room}.wall.T")
        stored = stored + 8 * water * values(result, f"{room}.radiator.T")
        for part in ("windows", "outerHalf"):
            lost = lost + values(result, f"{room}.{part}.Q_flow")
    fed = values(result, "fuel")
    balance = stored - stored[0] + cumulative_trapezoid(lost, t, initial=0)
    assert balance == pytest.approx(fed, abs=2e-4 * fed[-1])
    # The thermostat switches where it should, and the room swings around what is wanted.
    temperature = values(result, "living.inside.T")
    assert np.mean(temperature[t > 2e4]) == pytest.approx(294.15, abs=0.3)
    burner = values(result, "burner.Q_flow") > 1
    jumps = np.flatnonzero((t[1:] == t[:-1]) & (burner[1:] != burner[:-1]))
    levels = [
        min(
            abs(temperature[k] - 293.65),
            abs(temperature[k] - 294.65),
            abs(T - 320.15),
            abs(T - 326.15),
        )
        for k, T in zip(jumps, values(result, "boiler.T")[jumps], strict=True)
    ]
    assert len(jumps) > 10
    assert max(levels) < 1e-2


def test_motor_warms_up_in_intermittent_service(simulate: Simulate) -> None:
    result = simulate("dc_motor_drive", stop_time=600, interval=0.1, tolerance=1e-7)
    i, w = values(result, "motor.ia"), values(result, "motor.wMechanical")
    winding, housing = values(result, "winding.T"), values(result, "housing.T")
    J = 1.5e-3 + (0.02 + 60 * 0.05**2) / 15**2
    energy = 0.75e-3 * i**2 + J * w**2 / 2 + values(result, "lift")
    energy += 120 * (winding - 293.15) + 1800 * (housing - 293.15)
    energy += cumulative_trapezoid(1.2 * (housing - 293.15), result.times, initial=0)
    work = values(result, "work")
    assert energy == pytest.approx(work, abs=1e-4 * work[-1])
    # the torque that holds the load takes the same current, warm or cold, but more voltage
    k = (48 - 4 - 1.2) / (1500 * np.pi / 30)
    assert i[-1] == pytest.approx(60 * 9.80665 * 0.05 / 15 / k, rel=1e-3)
    resistance = 0.4 * (1 + 3.92e-3 * (winding[-1] - 293.15))
    assert values(result, "motor.va")[-1] == pytest.approx(resistance * i[-1] + 1.2, rel=1e-3)
    assert values(result, "lift")[-1] == pytest.approx(60 * 9.80665 * 0.3 * 24 * 10, rel=0.05)
