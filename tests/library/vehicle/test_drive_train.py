"""Engine, gears, differential, brake, drivers, electric drive."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.vehicle.running import simulate, values


def test_engine_takes_its_torque_from_the_map() -> None:
    result = simulate(
        """  Engine engine(J = 0.5, map = [0, 0, 1; 100, -10, 50; 300, -30, 150; 500, -50, 100],
    w(start = 150, fixed = true), phi(fixed = true));
  blocks.Constant throttle(k = 0.4);
equation
  connect(throttle.y, engine.throttle);
""",
        stop_time=10,
    )
    w = values(result, "engine.w")
    closed = np.interp(w, [100, 300, 500], [-10, -30, -50])
    full = np.interp(w, [100, 300, 500], [50, 150, 100])
    assert values(result, "engine.tau") == pytest.approx(0.6 * closed + 0.4 * full, abs=1e-6)
    gained = np.trapezoid(values(result, "engine.power"), result.times)
    assert 0.25 * (w[-1] ** 2 - w[0] ** 2) == pytest.approx(gained, rel=1e-3)
    assert np.ptp(w) > 100


def test_idle_control_keeps_the_engine_running() -> None:
    result = simulate(
        """  Engine engine(w(start = 200, fixed = true), phi(fixed = true), w_idle = 85);
  blocks.Constant throttle(k = 0);
  mechanical.rotational.TorqueStep accessories(stepTorque = -8, startTime = 8);
equation
  connect(throttle.y, engine.throttle);
  connect(accessories.flange, engine.flange);
""",
        stop_time=20,
    )
    w = values(result, "engine.w")
    assert 70 < w[-1] < 85
    assert np.min(w) > 65
    power = values(result, "engine.tau")[-1]
    assert power == pytest.approx(8, abs=0.05)


GEARS = """  GearBox box(ratio = {4, 2}, tau_sync = 300);
  mechanical.rotational.Inertia input_(J = 0.5, phi(fixed = true), w(start = 200, fixed = true));
  mechanical.rotational.Inertia output_(J = 20, phi(fixed = true), w(start = 50, fixed = true));
  blocks.IntegerTable lever(table = [0, 1; 1, 2; 3, 0; 4, -1]);
  Real lost(start = 0, fixed = true);
equation
  connect(lever.y, box.gear);
  connect(input_.flange_b, box.flange_a);
  connect(box.flange_b, output_.flange_a);
  der(lost) = box.lossPower;
"""


def test_gearbox_shifts_by_friction() -> None:
    result = simulate(GEARS, stop_time=6)
    t, a, b = result.times, values(result, "input_.w"), values(result, "output_.w")
    assert a[t < 1] == pytest.approx(4 * b[t < 1], abs=1e-5)
    second = (t > 2) & (t < 4)
    assert a[second] == pytest.approx(2 * b[second], abs=1e-5)
    # Impulse of the synchronizer: 0.5 (a - a0) = -p, 20 (b - b0) = 2 p, until a = 2 b.
    p = (200 - 2 * 50) / (1 / 0.5 + 2 * 2 / 20)
    assert a[second][-1] == pytest.approx(200 - p / 0.5, rel=1e-6)
    assert values(result, "box.mode")[(t > 3.01) & (t < 3.99)] == pytest.approx(2)
    assert a[-1] == pytest.approx(-3.2 * b[-1], abs=1e-4)
    energy = 0.25 * a**2 + 10 * b**2 + values(result, "lost")
    assert energy == pytest.approx(np.full_like(energy, energy[0]), rel=1e-6)


def test_differential_shares_the_torque() -> None:
    result = simulate(
        """  Differential gear(ratio = 4);
  mechanical.rotational.ConstantTorque drive(tau_constant = 10);
  mechanical.rotational.Inertia left(J = 1, phi(fixed = true), w(start = 3, fixed = true));
  mechanical.rotational.Inertia right(J = 2, phi(fixed = true), w(start = -3, fixed = true));
equation
  connect(drive.flange, gear.flange_a);
  connect(gear.flange_left, left.flange_a);
  connect(gear.flange_right, right.flange_a);
""",
        stop_time=2,
    )
    assert values(result, "left.w") == pytest.approx(3 + 20 * result.times, abs=1e-6)
    assert values(result, "right.w") == pytest.approx(-3 + 10 * result.times, abs=1e-6)
    assert values(result, "gear.flange_a.phi")[-1] == pytest.approx(4 * (40 + 20) / 2, rel=1e-6)


def test_brake_follows_its_map_and_holds() -> None:
    result = simulate(
        """  Brake brake(map = [0, 0; 0.5, 100; 1, 400]);
  mechanical.rotational.Inertia wheel(J = 2, phi(fixed = true), w(start = 60, fixed = true));
  mechanical.rotational.TorqueStep push(stepTorque = 300, startTime = 2);
  blocks.Step pedal(offset = 0.25, height = 0.5, startTime = 1);
equation
  connect(wheel.flange_b, brake.flange_a);
  connect(push.flange, brake.flange_b);
  connect(pedal.y, brake.pedal);
""",
        stop_time=4,
    )
    t, w = result.times, values(result, "wheel.w")
    assert w[t < 1] == pytest.approx(60 - 25 * t[t < 1], abs=1e-5)
    held = (t > 1.4) & (t < 2)
    assert np.max(np.abs(w[held])) < 1e-6
    assert w[-1] == pytest.approx((300 - 250) / 2 * 2, rel=1e-3)


def test_drag_grows_with_the_square_of_the_velocity() -> None:
    result = simulate(
        """  AerodynamicDrag air(c_w = 0.4, A = 2.5);
  Mass body(m = 3, s(fixed = true), v(start = 40, fixed = true));
equation
  connect(air.flange, body.flange_a);
""",
        stop_time=5,
    )
    expected = 40 / (1 + 0.6 * 0.4 * 2.5 * 40 / 3 * result.times)
    assert values(result, "body.v") == pytest.approx(expected, rel=1e-6)


def test_driver_does_not_wind_up() -> None:
    # Full throttle for a long while, then the wanted speed is reached without overshoot.
    result = simulate(
        """  Driver driver(k = 0.5, Ti = 3);
  Mass car(m = 1000, s(fixed = true), v(fixed = true));
  mechanical.translational.Force force;
  mechanical.translational.SpeedSensor sensor;
  blocks.TimeTable cycle(table = [0, 20; 40, 20; 40, 5; 80, 5]);
equation
  connect(cycle.y, driver.v_set);
  connect(sensor.flange, car.flange_a);
  connect(sensor.v, driver.v);
  force.f = 1000*driver.throttle - 3000*driver.brake;
  connect(force.flange, car.flange_b);
""",
        stop_time=80,
    )
    t, v = result.times, values(result, "car.v")
    assert v[t < 10] == pytest.approx(t[t < 10], abs=1e-5)
    assert np.max(v) < 20.8
    assert v[(t > 39) & (t < 40)] == pytest.approx(20, abs=0.05)
    assert np.min(v[t > 40]) > 4
    assert v[-1] == pytest.approx(5, abs=0.05)
    assert np.max(values(result, "driver.brake")) == pytest.approx(1)


def test_steering_driver_changes_the_lane() -> None:
    result = simulate(
        """  SingleTrackVehicle car(mu_f = 0.9, mu_r = 0.95, c_w = 0, useShafts = false,
    chassis(v_x(start = 22, fixed = true), x(fixed = true), y(fixed = true), psi(fixed = true),
    v_y(fixed = true), r(fixed = true)));
  SteeringDriver driver(path = [-10, 0; 50, 0; 90, 3.5; 500, 3.5], preview = 18, k = 0.8);
equation
  driver.x = car.chassis.x;
  driver.y = car.chassis.y;
  driver.psi = car.chassis.psi;
  connect(driver.delta, car.delta);
""",
        stop_time=8,
    )
    x, y = values(result, "car.chassis.x"), values(result, "car.chassis.y")
    assert y[x < 30] == pytest.approx(0, abs=1e-6)
    assert np.max(y) < 4.2
    assert y[-1] == pytest.approx(3.5, abs=0.02)
    assert values(result, "car.a_y").min() < -1


def test_automatic_gear_shift_accelerates_through_the_gears() -> None:
    result = simulate(
        """  Engine engine(phi(fixed = true), w(start = 200, fixed = true));
  GearShift shift(n = 5);
  GearBox box;
  Differential axle;
  LongitudinalTyre left(useLoadInput = true, J = 1.5, phi(fixed = true),
    w(start = 200/3.09/3.91, fixed = true));
  LongitudinalTyre right(useLoadInput = true, J = 1.5, phi(fixed = true),
    w(start = 200/3.09/3.91, fixed = true));
  LongitudinalTyre front(useLoadInput = true, useShaft = false);
  LongitudinalChassis car(s(fixed = true), v_x(start = 0.3*200/3.09/3.91, fixed = true));
  blocks.Constant throttle(k = 1);
equation
  connect(throttle.y, engine.throttle);
  shift.w = engine.w;
  connect(shift.gear, box.gear);
  connect(engine.flange, box.flange_a);
  connect(box.flange_b, axle.flange_a);
  connect(axle.flange_left, left.shaft);
  connect(axle.flange_right, right.shaft);
  connect(left.hub, right.hub, front.hub, car.flange);
  left.load = car.load_rear/2;
  right.load = car.load_rear/2;
  connect(car.load_front, front.load);
""",
        stop_time=40,
    )
    gear, w, t = values(result, "shift.gear"), values(result, "engine.w"), result.times
    assert list(dict.fromkeys(gear.tolist()))[:4] == [1, 2, 3, 4]
    assert np.max(w[gear < 5]) < 505
    assert values(result, "car.v_x")[-1] > 40
    third = (gear == 3) & (values(result, "box.mode") == 0)
    wheels = values(result, "left.w") + values(result, "right.w")
    assert w[third] == pytest.approx(1.33 * 3.91 * wheels[third] / 2, rel=1e-5)
    assert values(result, "left.w") == pytest.approx(values(result, "right.w"), rel=1e-6)
    assert t[gear == 2][0] > 1


def test_road_gives_inclination_and_friction() -> None:
    result = simulate(
        """  Road road(heights = [0, 0; 100, 0; 200, 5; 300, 5],
    friction = [0, 1; 150, 1; 150.1, 0.3; 300, 0.3]);
equation
  road.s = 250*time;
""",
        stop_time=1,
    )
    s = 250 * result.times
    height = np.interp(s, [0, 100, 200, 300], [0, 0, 5, 5])
    assert values(result, "road.height") == pytest.approx(height, abs=1e-9)
    assert values(result, "road.inclination")[(s > 101) & (s < 199)] == pytest.approx(0.05)
    assert values(result, "road.mu")[s > 151] == pytest.approx(0.3)


def test_electric_drive_limits_current_and_power_and_keeps_its_energy() -> None:
    result = simulate(
        """  ElectricDrive drive(P_max = 60e3, I_max = 300, battery(soc(start = 0.9)),
    rotor(phi(fixed = true),
    w(fixed = true)));
  mechanical.rotational.Inertia load(J = 2);
  blocks.Step pedal(offset = 1, height = -2, startTime = 5);
  Real source(start = 0, fixed = true), lost(start = 0, fixed = true);
  Real stored = drive.rotor.J*drive.rotor.w^2/2 + load.J*load.w^2/2
    + drive.winding.L*drive.winding.i^2/2;
equation
  connect(pedal.y, drive.pedal);
  connect(drive.flange, load.flange_a);
  der(source) = -drive.battery.v_0*drive.battery.i;
  der(lost) = drive.battery.lossPower + drive.armature.LossPower;
""",
        stop_time=8,
    )
    t, i = result.times, values(result, "drive.winding.i")
    assert np.max(np.abs(i)) < 300.1
    assert i[(t > 0.1) & (t < 1)] == pytest.approx(300, rel=1e-3)
    mechanical = 0.45 * i * values(result, "drive.rotor.w")
    assert np.max(mechanical[t < 5]) < 60.5e3
    assert np.min(mechanical[t > 5.1]) < -40e3
    balance = values(result, "source") - values(result, "lost") - values(result, "stored")
    assert np.max(np.abs(balance)) < 1e-4 * np.max(values(result, "stored"))
    charge = values(result, "drive.battery.soc")
    assert charge[-1] > np.min(charge) + 1e-5


def random_train(seed: int) -> str:
    """Return a chain of parts between a motor and a vehicle on tyres."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 6))
    text, equations, loss, energy = "", "  connect(motor.flange, j0.flange_a);\n", [], []
    for i in range(n + 1):
        text += (
            f"  mechanical.rotational.Inertia j{i}(J = {rng.uniform(0.05, 2)}, phi(fixed = true), "
            f"w(start = {rng.uniform(0, 30)}, fixed = true));\n"
        )
        energy.append(f"j{i}.J*j{i}.w^2/2")
    for i in range(n):
        kind = rng.integers(0, 5)
        spring = f"c = {rng.uniform(50, 5000)}, d = {rng.uniform(0.1, 20)}"
        part = [
            f"mechanical.rotational.SpringDamper p{i}({spring})",
            f"GearBox p{i}(tau_sync = {rng.uniform(50, 300)})",
            f"mechanical.rotational.ElastoBacklash p{i}({spring}, b = 0.05)",
            f"mechanical.rotational.Damper p{i}(d = {rng.uniform(0.5, 10)})",
            f"mechanical.rotational.FrictionTorque p{i}(tau_pos = [0, {rng.uniform(5, 80)}])",
        ][kind]
        text += f"  {part};\n"
        if kind == 1:
            gears = f"0, {rng.integers(1, 4)}; 1, {rng.integers(-1, 3)}; 2, {rng.integers(1, 6)}"
            text += f"  blocks.IntegerTable lever{i}(table = [{gears}]);\n"
            equations += f"  connect(lever{i}.y, p{i}.gear);\n"
        if kind in (0, 2):
            stretch = "" if kind == 0 else "0.025"
            deflection = (
                f"p{i}.phi_rel"
                if not stretch
                else f"noEvent(max(abs(p{i}.phi_rel) - {stretch}, 0))"
            )
            energy.append(f"p{i}.c*{deflection}^2/2")
        loss.append(f"p{i}.lossPower")
        equations += f"  connect(j{i}.flange_b, p{i}.flange_a);\n"
        equations += f"  connect(p{i}.flange_b, j{i + 1}.flange_a);\n"
    text += f"""  mechanical.rotational.Torque motor;
  blocks.Sine drive(amplitude = {rng.uniform(20, 200)}, f = {rng.uniform(0.2, 2)});
  LongitudinalTyre tyre(load_constant = {rng.uniform(2000, 6000)});
  Mass car(m = {rng.uniform(200, 800)}, s(fixed = true),
    v(start = {rng.uniform(0, 9)}, fixed = true));
  AerodynamicDrag air;
  Real work(start = 0, fixed = true), lost(start = 0, fixed = true);
  Real energy = {" + ".join(energy)} + car.m*car.v^2/2;
equation
{equations}  connect(j{n}.flange_b, tyre.shaft);
  connect(tyre.hub, car.flange_a);
  connect(air.flange, car.flange_b);
  connect(drive.y, motor.tau);
  der(work) = drive.y*j0.w;
  der(lost) = {" + ".join(loss)} + tyre.lossPower + air.f*car.v;
"""
    return text


@pytest.mark.parametrize("seed", range(8))
def test_power_balance_of_random_drive_trains(seed: int) -> None:
    result = simulate(random_train(seed), stop_time=3)
    assert result.times[-1] == 3
    balance = values(result, "energy") - values(result, "work") + values(result, "lost")
    scale = np.max(values(result, "energy"))
    assert balance == pytest.approx(np.full_like(balance, balance[0]), abs=1e-5 * scale)
    assert np.ptp(values(result, "energy")) > 1e-3 * scale
