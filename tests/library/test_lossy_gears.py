"""Gears with losses: efficiency in all quadrants, self-locking, energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from acausal import compile_text


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def gear(table: str, w0: float, drive: float, load: float, **options: Any) -> Any:
    """Simulate two inertias with a gear 2:1 between them; angular velocity at flange_a is w0."""
    return compile_text(f"""import mechanical.rotational.*;
model Drive
  ConstantTorque drive(tau_constant = {drive});
  Inertia one(J = 1, w(start = {w0}, fixed = true), phi(fixed = true));
  LossyGear gear(ratio = 2, lossTable = {table});
  Inertia two(J = 2);
  ConstantTorque load(tau_constant = {load});
equation
  connect(drive.flange, one.flange_a);
  connect(one.flange_b, gear.flange_a);
  connect(gear.flange_b, two.flange_a);
  connect(two.flange_b, load.flange);
end Drive;
""").simulate(**{"tolerance": 1e-9, "stop_time": 1.0, **options})


@pytest.mark.parametrize(
    ("w0", "drive", "load", "motor_drives"),
    [(10, 6, -4, True), (10, -6, 30, False), (-10, -6, 4, True), (-10, 6, -30, False)],
)
def test_efficiency_in_all_quadrants(
    w0: float, drive: float, load: float, motor_drives: bool
) -> None:
    result = gear("[0, 0.8, 0.5, 0, 0]", w0, drive, load)
    a, b = values(result, "gear.flange_a.tau"), values(result, "gear.flange_b.tau")
    w = values(result, "one.w")
    assert np.all(w * w0 > 0)
    power_a, power_b = a * w, b * w / 2
    if motor_drives:
        assert np.all(power_a > 0)
        assert -power_b == pytest.approx(0.8 * power_a)
    else:
        assert np.all(power_b > 0)
        assert -power_a == pytest.approx(0.5 * power_b)
    assert values(result, "gear.lossPower") == pytest.approx(power_a + power_b)
    # d(w)/dt from the torques: w1' = drive - a, w2' = (load - b)/2 with w1 = 2 w2.
    rate = (w[-1] - w[0]) / result.times[-1]
    assert rate == pytest.approx(drive - a[-1])
    assert rate == pytest.approx(load - b[-1])


def test_gear_holds_a_load_up_to_the_bearing_torque() -> None:
    result = gear("[0, 0.25, 0.25, 0.625, 2.5]", 0.0, 0.0, 4.99)
    assert set(values(result, "one.w")) == {0.0}
    assert set(values(result, "gear.mode")) == {0.0}


@pytest.mark.parametrize("load", [5.9, 500.0, -500.0])
def test_load_drives_a_gear_of_low_efficiency(load: float) -> None:
    # The mesh turns 4 parts of torque into one, 2.5 N.m go into the bearings: the load gives
    # 2*(4*w1' + 2.5) for w1' at the other inertia, and w1' for its own, so 9*w1' = load - 5.
    result = gear("[0, 0.25, 0.25, 0.625, 2.5]", 0.0, 0.0, load)
    rate = np.sign(load) * (abs(load) - 5) / 9
    assert values(result, "one.w") == pytest.approx(rate * result.times, rel=1e-6, abs=1e-8)


def test_ideal_table_is_an_ideal_gear() -> None:
    result = gear("[0, 1, 1, 0, 0]", 0.0, 3.0, -2.0)
    # (1 + 2/4) w1' = 3 - 2/2
    assert values(result, "one.w") == pytest.approx(4 / 3 * result.times, abs=1e-8)
    assert set(values(result, "gear.mode")) == {2.0}


def test_gear_that_turns_to_and_fro_loses_energy_only() -> None:
    result = compile_text("""import mechanical.rotational.*;
model Swing
  Inertia one(J = 1, w(start = 8, fixed = true), phi(fixed = true));
  LossyGear gear(ratio = 2, lossTable = [0, 0.9, 0.8, 0.1, 0.2; 10, 0.95, 0.9, 0.2, 0.3]);
  Inertia two(J = 2);
  Spring spring(c = 100);
  Fixed fixed;
equation
  connect(one.flange_b, gear.flange_a);
  connect(gear.flange_b, two.flange_a);
  connect(two.flange_b, spring.flange_a);
  connect(spring.flange_b, fixed.flange);
end Swing;
""").simulate(stop_time=30, points=30001, tolerance=1e-9)
    t, w, phi = result.times, values(result, "one.w"), values(result, "two.phi")
    energy = 0.75 * w**2 + 50 * phi**2
    loss = values(result, "gear.lossPower")
    assert np.all(loss >= -1e-9)
    lost = np.concatenate([[0], np.cumsum(np.diff(t) * (loss[1:] + loss[:-1]) / 2)])
    assert energy + lost == pytest.approx(energy[0], abs=2e-3)
    assert set(w[-1000:]) == {0.0}
    assert {-1.0, 0.0, 1.0} <= set(values(result, "gear.mode"))
