"""The examples of the hydraulic package."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acausal import compile_file, compile_text

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


def test_duty_cycle_loads_and_drives() -> None:
    result = compile_text("""import hydraulic.*;
model Duty
  inner Oil oil;
  ConstVolumeSource pump(q = 6e-4);
  ReliefValve relief(dp_relief = 20e6);
  VolumeClosed line(V = 1e-3, p(start = 20e6, fixed = true));
  OpenTank tank;
  V4_3CC valve(q_nom = 5e-4, dp_nom = 1e6, bandwidth = 50);
  DoubleActingCylinder cylinder(boreDiameter = 63e-3, rodDiameter = 36e-3, strokeLength = 0.5,
    damping = 1e4, closedLength = 0.6, cylinderChamberHead(p(start = 5e6, fixed = true)),
    cylinderChamberRod(p(start = 7e6, fixed = true)));
  mechanical.translational.Mass load(m = 100, s(start = 0.7, fixed = true), v(fixed = true));
  mechanical.translational.Fixed frame;
  FVController duty(k = 4);
equation
  connect(pump.port, relief.port_a, line.port, valve.portP);
  connect(tank.port, relief.port_b, valve.portT);
  connect(valve.portA, cylinder.port_a);
  connect(valve.portB, cylinder.port_b);
  connect(frame.flange, cylinder.flange_a);
  connect(cylinder.flange_b, load.flange_a);
  connect(load.flange_b, duty.flange_a);
  connect(duty.y, valve.control);
end Duty;
""").simulate(stop_time=8, tolerance=1e-7)
    t, v = result.times, values(result, "load.v")
    wanted = values(result, "duty.velocityProfile.y")
    moving = (t > 3.5) & (t < 5)
    # A proportional controller: slower than wanted, but in the right direction.
    assert np.all((v[moving] > 0.3 * wanted[moving]) & (v[moving] < wanted[moving]))
    assert np.max(np.abs(v[t > 7])) < 1e-2
    force = values(result, "duty.flange_a.f")
    assert force[np.searchsorted(t, 2.0)] == pytest.approx(11500, rel=1e-2)
    assert values(result, "duty.y") == pytest.approx(
        np.clip(4 * values(result, "duty.e"), -1, 1), abs=1e-9
    )
