"""Tyres: the Magic Formula, its combination of slips, relaxation, standstill."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.vehicle.running import magic_formula, simulate, values

# A wheel that is moved with given velocities and turned with a given speed.
RIG = """  parameter Boolean relaxation = false;
  parameter CombinedSlip combined = CombinedSlip.Ellipse;
  parameter Real heading = 0, vx = 20, vy = 0, vs = 0;
  TyreMagicFormula tyre(R = 0.3, fR0 = 0, fR1 = 0, fR4 = 0, relaxation = relaxation,
    combined = combined, load_constant = 5000, degression = 0.1, mu_constant = 0.8);
  mechanical.rotational.Speed drive(exact = true);
  Mover mover(heading = heading, vx = vx, vy = vy, sweep = sweep);
  Real sweep = time;
equation
  connect(drive.flange, tyre.shaft);
  connect(mover.hub, tyre.hub);
  drive.w_ref = (vx + vs*sweep)/0.3;
initial equation
  if relaxation then
    tyre.u_x = 0;
    tyre.u_y = 0;
  end if;
"""
PEAK = 0.8 * (1 - 0.1 * 0.25) * 5000


def rig(**parameters: object) -> str:
    """Return the rig with other parameters."""
    text = RIG
    for name, value in parameters.items():
        for before in ("false", "CombinedSlip.Ellipse", "0", "20"):
            text = text.replace(f"{name} = {before},", f"{name} = {value},")
            text = text.replace(f"{name} = {before};", f"{name} = {value};")
    return text


@pytest.mark.parametrize("combined", ["Separate", "Ellipse", "Weighting"])
def test_pure_slip_gives_the_magic_formula(combined: str) -> None:
    how = f"CombinedSlip.{combined}"
    driving = simulate(rig(combined=how, vs=6), stop_time=1)
    kappa = 6 * driving.times / 20
    force = magic_formula(kappa, 12, 1.65, 1.1 * PEAK, 0.3)
    assert values(driving, "tyre.F_x") == pytest.approx(force, rel=1e-6, abs=1e-3)
    assert values(driving, "tyre.tau") == pytest.approx(0.3 * force, rel=1e-6, abs=1e-3)
    assert np.max(np.abs(values(driving, "tyre.F_y"))) < 1e-6
    turning = simulate(rig(combined=how, vy=-5, heading=0.7), stop_time=1)
    alpha = np.arctan(5 * turning.times / 20)
    force = magic_formula(alpha, 10, 1.4, PEAK, -0.3)
    assert values(turning, "tyre.F_y") == pytest.approx(force, rel=1e-6, abs=1e-3)
    assert values(turning, "tyre.hub.fx") == pytest.approx(np.sin(0.7) * force, abs=1e-2)
    assert values(turning, "tyre.hub.fy") == pytest.approx(-np.cos(0.7) * force, abs=1e-2)


@pytest.mark.parametrize(("combined", "inside"), [("Ellipse", True), ("Separate", False)])
def test_combined_slip_stays_in_the_friction_ellipse(combined: str, inside: bool) -> None:
    result = simulate(rig(combined=f"CombinedSlip.{combined}", vs=-6, vy=-6), stop_time=1)
    share = (values(result, "tyre.F_x") / (1.1 * PEAK)) ** 2
    share = share + (values(result, "tyre.F_y") / PEAK) ** 2
    assert (np.max(share) <= 1 + 1e-9) == inside
    assert np.max(share) > 0.99
    assert np.all(values(result, "tyre.lossPower") > -1e-9)


def test_weighting_reduces_each_force_by_the_other_slip() -> None:
    result = simulate(rig(combined="CombinedSlip.Weighting", vs=-6, vy=-3), stop_time=1)
    kappa, alpha = -6 * result.times / 20, np.arctan(3 * result.times / 20)
    long = magic_formula(kappa, 12, 1.65, 1.1 * PEAK, 0.3) * np.cos(1.1 * np.arctan(12 * alpha))
    side = magic_formula(alpha, 10, 1.4, PEAK, -0.3) * np.cos(np.arctan(10 * kappa))
    assert values(result, "tyre.F_x") == pytest.approx(long, rel=1e-6, abs=1e-2)
    assert values(result, "tyre.F_y") == pytest.approx(side, rel=1e-6, abs=1e-2)


def test_slip_builds_up_over_the_relaxation_length() -> None:
    step = rig(relaxation="true", vy=-0.004, vs=0.002).replace("sweep = time", "sweep = 1")
    result = simulate(step, stop_time=0.2)
    way = 20 * result.times
    lateral = np.arctan(2e-4 * (1 - np.exp(-way / 0.4)))
    assert values(result, "tyre.alpha") == pytest.approx(lateral, abs=2e-9)
    longitudinal = 1e-4 * (1 - np.exp(-way / 0.15))
    assert values(result, "tyre.kappa") == pytest.approx(longitudinal, abs=2e-9)


def test_rolling_resistance_of_a_free_wheel() -> None:
    result = simulate(
        """  LongitudinalTyre tyre(useShaft = false, load_constant = 3000, R = 0.3, J = 1.8);
  Mass car(m = 300, s(fixed = true), v(start = 30, fixed = true));
equation
  connect(car.flange_b, tyre.hub);
""",
        stop_time=10,
    )
    v = values(result, "car.v")
    x = v * 3.6 / 100
    resistance = 3000 * (0.009 + 0.002 * x + 0.0003 * x**4)
    assert values(result, "car.a") == pytest.approx(-resistance / (300 + 1.8 / 0.09), rel=1e-6)
    assert values(result, "tyre.lossPower") == pytest.approx(resistance * v, rel=1e-6)


def test_locked_wheel_slides_to_rest_and_the_vehicle_stays() -> None:
    # A brake that is far too strong: full sliding over v^2/(2 mu g), then no creep.
    result = simulate(
        """  LongitudinalTyre tyre(load_constant = 3000, R = 0.3, J = 1.2, relaxation = true,
    fR0 = 0, fR1 = 0, fR4 = 0, phi(fixed = true), w(start = 100, fixed = true), u_x(fixed = true));
  Mass car(m = 3000/9.81, s(fixed = true), v(start = 30, fixed = true));
  Brake brake;
  blocks.Step pedal(startTime = 0.5);
equation
  connect(car.flange_b, tyre.hub);
  connect(brake.flange_b, tyre.shaft);
  connect(pedal.y, brake.pedal);
""",
        stop_time=12,
    )
    t, v = result.times, values(result, "car.v")
    sliding = -magic_formula(1.0, 12, 1.65, 1.1 * 3000, 0.3) / (3000 / 9.81)
    locked = (values(result, "brake.mode") == 0) & (v > 1)
    assert np.sum(locked) > 50
    assert values(result, "car.a")[locked][5:] == pytest.approx(sliding, rel=2e-3)
    assert np.max(np.abs(values(result, "tyre.w")[locked][5:])) < 1e-5
    assert np.min(v) > -0.7
    way = values(result, "car.s")[-1] - 15
    assert way == pytest.approx(30**2 / (2 * -sliding), rel=0.03)
    assert np.max(np.abs(v[t > 11])) < 1e-5


def test_braking_distance_at_the_peak_is_the_shortest() -> None:
    # The textbook: v^2/(2 mu g) with the whole grip.
    def way(torque: float) -> float:
        result = simulate(
            f"""  LongitudinalTyre tyre(load_constant = 3000, R = 0.3, J = 0.1, fR0 = 0, fR1 = 0,
    fR4 = 0, phi(fixed = true), w(start = 100, fixed = true));
  Mass car(m = 3000/9.81, s(fixed = true), v(start = 30, fixed = true));
  Brake brake(map = [0, 0; 1, {torque}]);
  blocks.Ramp pedal(duration = 0.1);
equation
  connect(car.flange_b, tyre.hub);
  connect(brake.flange_b, tyre.shaft);
  connect(pedal.y, brake.pedal);
  when car.v < 2 then
    terminate("slow");
  end when;
""",
            stop_time=20,
        )
        return float(values(result, "car.s")[-1])

    best, locked, weak = way(970.0), way(1500.0), way(600.0)
    limit = (30**2 - 2**2) / (2 * 1.1 * 9.81)
    assert limit < best < 1.07 * limit
    assert locked > best + 2
    assert weak > best + 10


def test_vehicle_with_relaxed_tyres_stands_on_a_slope() -> None:
    result = simulate(
        """  LongitudinalTyre tyre(useLoadInput = true, relaxation = true, phi(fixed = true),
    J = 1, w(fixed = true), u_x(fixed = true));
  LongitudinalTyre free(useLoadInput = true, useShaft = false);
  LongitudinalChassis car(inclination_constant = 0.1, s(fixed = true),
    v_x(start = 0, fixed = true));
  Brake brake;
  blocks.Constant pedal(k = 1);
equation
  connect(brake.flange_b, tyre.shaft);
  connect(pedal.y, brake.pedal);
  connect(tyre.hub, free.hub, car.flange);
  connect(car.load_rear, tyre.load);
  connect(car.load_front, free.load);
""",
        stop_time=5,
    )
    slope = np.arctan(0.1)
    assert abs(values(result, "car.v_x")[-1]) < 1e-6
    weight = 1300 * 9.80665
    assert values(result, "tyre.F_x")[-1] == pytest.approx(weight * np.sin(slope), rel=1e-4)
    rear = weight * (1.2 * np.cos(slope) + 0.5 * np.sin(slope)) / 2.6
    assert values(result, "car.load_rear")[-1] == pytest.approx(rear, rel=1e-5)
    assert -0.02 < values(result, "car.s")[-1] < 0
