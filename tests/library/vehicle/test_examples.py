"""Electric car and elevator."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from acausal import compile_file
from tests.library.vehicle.running import values

EXAMPLES = Path(__file__).parents[3] / "examples"


def test_electric_car_follows_its_cycle_and_accounts_for_its_energy() -> None:
    result = compile_file(EXAMPLES / "electric_car.acm").simulate(stop_time=200, tolerance=1e-7)
    assert result.times[-1] == 200
    error = values(result, "speed.y") - values(result, "chassis.v_x")
    assert np.max(np.abs(error)) < 0.5
    balance = sum(values(result, name) for name in ("E_lost", "E_kinetic", "E_magnetic"))
    taken = values(result, "E_battery")
    assert np.max(np.abs(taken - balance)) < 1e-6 * np.max(taken)
    # Braking gives back, and the car stands still on its brake at the end.
    assert np.max(taken) > 1.2 * taken[-1]
    assert abs(values(result, "chassis.v_x")[-1]) < 1e-6
    # 0.08 kWh per kilometre is usual for a small car in town.
    assert 0.05 < taken[-1] / 3.6e6 / (values(result, "chassis.s")[-1] / 1e3) < 0.12
    charge = (0.8 - values(result, "motor.battery.soc")[-1]) * 100 * 3600
    assert abs(charge * 386 / taken[-1] - 1) < 0.01


def test_elevator_travels_and_is_stopped_by_its_brake() -> None:
    result = compile_file(EXAMPLES / "elevator.acm").simulate(stop_time=20, tolerance=1e-8)
    t, v = result.times, values(result, "cabin.v")
    assert np.max(np.abs(v[t < 0.5])) < 1e-6
    travelling = (t > 5) & (t < 6)
    assert np.max(np.abs(v[travelling] - 1.6)) < 2e-3
    ropes = values(result, "cabinRope.f")[travelling], values(result, "counterRope.f")[travelling]
    difference = (ropes[0] - ropes[1]).mean() * 0.25
    assert abs(values(result, "motor.tau")[travelling].mean() - difference) < 1
    # Rigid ropes: the brake's torque and the difference of the weights stop all masses.
    inertia = (1350 + 1200) * 0.25**2 + 25
    weights = (1350 - 1200) * 9.80665 * 0.25
    w = 1.6 / 0.25 - weights / inertia * 0.15
    expected = w / ((2160 + weights) / inertia)
    locked = t[(values(result, "brake.mode") == 0) & (t > 6)][0] - 6.15
    assert abs(locked - expected) < 0.1 * expected + 0.1
    assert np.max(np.abs(values(result, "sheave.w")[t > 7])) < 1e-9
    assert abs(values(result, "brake.tau")[-1] + weights) < 80 * 1.2 * 0.25 + 1
    assert np.min(values(result, "slack")) > 0
    energy = values(result, "E_mechanical") + values(result, "E_lost") - values(result, "E_motor")
    assert np.ptp(energy) < 1e-5 * np.max(values(result, "E_motor"))
