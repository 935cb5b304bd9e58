"""The examples of the hydraulic package."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acausal import compile_file

EXAMPLES = Path(__file__).parents[3] / "examples"


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def test_basin_fills_and_empties_as_the_closed_form_says() -> None:
    # A h' = q - k sqrt(h); with y = sqrt(h): t = 2 A/k ((y0 - y) + q/k log((q - k y0)/(q - k y))).
    result = compile_file(EXAMPLES / "basin.acm").simulate(stop_time=2400, tolerance=1e-10)
    t, level = result.times, values(result, "basin.level")
    area, inflow = 3.0, 20e-3
    k = 0.62 * np.pi / 4 * 0.09**2 * np.sqrt(2 * 9.80665)
    filling = t < 1799
    y, start = np.sqrt(level[filling]), np.sqrt(0.2)
    needed = (
        2 * area / k * (start - y + inflow / k * np.log((inflow - k * start) / (inflow - k * y)))
    )
    early = t[filling] < 1500
    assert needed[early] == pytest.approx(t[filling][early], rel=2e-4, abs=0.05)
    assert level[filling][-1] == pytest.approx((inflow / k) ** 2, rel=0.02)
    full = level[np.searchsorted(t, 1800.0)]
    emptying = (t > 1800) & (level > 1e-3)
    expected = (np.sqrt(full) - k / (2 * area) * (t[emptying] - 1800)) ** 2
    assert level[emptying] == pytest.approx(expected, abs=2e-4)
    assert level[-1] == pytest.approx(0, abs=1e-4)


def test_servo_cylinder_reaches_and_follows() -> None:
    result = compile_file(EXAMPLES / "servo_cylinder.acm").simulate(stop_time=3, tolerance=1e-7)
    t, s, deviation = (result.times, values(result, "cylinder.s"), values(result, "deviation"))
    assert abs(s[np.searchsorted(t, 0.19)] - 0.1) < 2e-3
    assert abs(deviation[np.searchsorted(t, 1.19)]) < 2e-3
    # A loop with one integrator and the gain K lags behind by about rate/K.
    sine = t > 2
    assert np.max(np.abs(deviation[sine])) < 0.05 * 2 * np.pi / 4
    force = values(result, "cylinder.f")
    weight = 3000 + 150 * values(result, "load.a")
    assert force == pytest.approx(weight, abs=1e-3 * np.max(force))
    supply = values(result, "accumulator.p")
    assert 9e6 < supply.min() < supply.max() < 14.8e6
    # Oil is neither made nor lost between the tank and the chambers.
    tank = values(result, "tank.port.m_flow")
    stored = sum(values(result, f"{name}.m") for name in STORES)
    inflow = np.concatenate([[0], np.cumsum(np.diff(t) * (tank[1:] + tank[:-1]) / 2)])
    balance = stored + inflow
    assert balance == pytest.approx(balance[0], abs=2e-3)


STORES = (
    "accumulator",
    "line.volumeMiddle",
    "cylinder.cylinderChamberHead",
    "cylinder.cylinderChamberRod",
)


def test_hydrostatic_drive_loses_power_but_gains_none() -> None:
    result = compile_file(EXAMPLES / "hydrostatic_drive.acm").simulate(stop_time=12, tolerance=1e-7)
    t, w = result.times, values(result, "load.w")
    given, used = values(result, "P_in"), values(result, "P_out")

    def integral(power: Any) -> Any:
        return np.sum(np.diff(t) * (power[1:] + power[:-1]) / 2)

    kinetic, resistance = 15 * w**2, integral(6 * w**2)
    assert integral(used) == pytest.approx(kinetic[-1] + resistance, rel=2e-3)
    assert 0.5 * integral(given) < integral(used) < 0.9 * integral(given)
    assert values(result, "accumulator.p").max() < 26.5e6
    # Driven, the motor turns as fast as the oil of the pump makes it, less some leakage.
    driven = np.searchsorted(t, 7.4)
    assert 0.88 < w[driven] / (45 / 160 * 1800 * 2 * np.pi / 60) < 0.95
    # Coasting, the check valve feeds it, and the load slows down.
    assert w[-1] < 0.5 * w.max()
    assert values(result, "motor.portA.p")[-1] == pytest.approx(101325, rel=0.8)
