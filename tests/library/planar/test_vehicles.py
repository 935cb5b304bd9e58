"""Wheels seen from above: closed forms, SciPy, energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from acausal import compile_text
from tests.library.planar.mechanisms import body, run, solution, values, vector

LEVEL = "{0, 0}"


def triple_s(x: float, x_max: float, x_sat: float, y_max: float, y_sat: float) -> float:
    """Return the curve of friction over slip, written with other formulas than the library."""
    size = abs(x)
    if size <= x_max:
        value = y_max * (1.5 * size / x_max - 0.5 * (size / x_max) ** 3)
    elif size <= x_sat:
        p = (size - x_max) / (x_sat - x_max)
        value = y_max * (1 + 2 * p) * (1 - p) ** 2 + y_sat * p**2 * (3 - 2 * p)
    else:
        value = y_sat
    return float(np.copysign(value, x))


def test_triple_s_is_smooth_and_goes_through_its_points() -> None:
    result = compile_text("""import mechanical.planar.*;
model Curve
  Real x = 4*(time - 0.5);
  Real y = tripleS(0.2, 0.7, 1.1, 0.6, x);
  Real z = x*tripleSOverX(0.2, 0.7, 1.1, 0.6, x^2);
  Real slope = der(y);
end Curve;
""").simulate(stop_time=1, points=2001)
    x, y = values(result, "x"), values(result, "y")
    assert y == pytest.approx([triple_s(v, 0.2, 0.7, 1.1, 0.6) for v in x], abs=1e-12)
    assert values(result, "z") == pytest.approx(y, abs=1e-12)
    assert y == pytest.approx(-y[::-1], abs=1e-12)
    assert np.max(np.abs(np.diff(values(result, "slope")))) < 0.7  # of at most 33


DISC = """
  Fixed pole;
  Revolute pivot(phi(fixed = true), w(start = {w}, fixed = true));
  Prismatic arm(s(start = 1, fixed = true){v});
  Body hub(m = 10, I = 1);
  {wheel};
  mechanical.rotational.Inertia inertia(J = 1, phi(fixed = true){roll});
  mechanical.rotational.ConstantTorque motor(tau_constant = 10);
equation
  connect(pole.frame_a, pivot.frame_a);
  connect(pivot.frame_b, arm.frame_a);
  connect(arm.frame_b, hub.frame_a, wheel.frame_a);
  connect(motor.flange, inertia.flange_a);
  connect(inertia.flange_b, wheel.flange_a);
"""


def test_ideal_wheel_drives_round_a_pole() -> None:
    result = run(
        DISC.format(wheel="IdealWheelJoint wheel(r = {0, 2}, radius = 0.3)", w=0, v="", roll=""),
        stop_time=5,
        gravity=LEVEL,
    )
    # (J + (I + m s^2) radius^2/s^2) w' = tau
    expected = 10 / (1 + 11 * 0.3**2) * result.times
    assert values(result, "inertia.w") == pytest.approx(expected, abs=1e-6)
    assert values(result, "pivot.w") == pytest.approx(0.3 * expected, abs=1e-6)
    assert values(result, "arm.s") == pytest.approx(1, abs=1e-7)  # the wheel does not move outwards
    assert values(result, "wheel.a") == pytest.approx(3 / 1.99, abs=1e-7)
    # the wheel holds the hub against the centrifugal force
    force = np.hypot(values(result, "wheel.frame_a.fx"), values(result, "wheel.frame_a.fy"))
    across = 10 * values(result, "pivot.w") ** 2
    along = values(result, "wheel.f_long")
    assert force**2 == pytest.approx(across**2 + along**2, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("slip_based", [False, True])
def test_friction_wheel_against_an_independent_solution(slip_based: bool) -> None:
    options = "radius = 0.3, r = {0, 1}, N = 100, mu_A = 1, mu_S = 0.7"
    if slip_based:
        wheel = "SlipBasedWheelJoint wheel(sAdhesion = 0.05, sSlide = 0.15, vAdhesion_min = 0.06, "
        wheel += f"vSlide_min = 0.2, useDynamicLoad = true, {options})"
    else:
        wheel = f"DryFrictionWheelJoint wheel(vAdhesion = 0.1, vSlide = 0.3, {options})"
    text = DISC.format(wheel=wheel, w=0, v=", v(fixed = true)", roll=", w(fixed = true)")
    if slip_based:
        text = text.replace("equation", "  blocks.Sine load(amplitude = 20, f = 1);\nequation")
        text += "  connect(load.y, wheel.dynamicLoad);\n"
    text = text.replace("equation", "  Real lost(start = 0, fixed = true);\nequation")
    text += "  der(lost) = wheel.lossPower;\n"
    result = run(text, stop_time=3, gravity=LEVEL)

    def friction(t: float, along: float, across: float, roll: float) -> tuple[float, float]:
        slip = np.hypot(along, across)
        if slip == 0:
            return 0.0, 0.0
        edges, normal = (0.1, 0.3), 100.0
        if slip_based:
            speed = abs(0.3 * roll)
            edges = (max(0.05 * speed, 0.06), max(0.15 * speed, 0.2))
            normal += 20 * np.sin(2 * np.pi * t)
        f = normal * triple_s(slip, *edges, 1, 0.7)
        return f * along / slip, f * across / slip

    def motion(t: float, y: np.ndarray) -> list[float]:
        s, w, v, roll = y[1:5]
        along, across = s * w - 0.3 * roll, -v  # driving direction is y of the arm, left is -x
        f_along, f_across = friction(t, along, across, roll)
        return [
            w,
            v,
            (-f_along * s - 20 * s * w * v) / (1 + 10 * s**2),
            s * w**2 + f_across / 10,
            10 + 0.3 * f_along,
            f_along * along + f_across * across,
        ]

    expected = solution(motion, [0, 1, 0, 0, 0, 0], result.times)
    for row, path in enumerate(["pivot.phi", "arm.s", "pivot.w", "arm.v", "inertia.w", "lost"]):
        assert values(result, path) == pytest.approx(expected[row], rel=1e-5, abs=1e-5), path
    slip = values(result, "wheel.v_slip")
    assert np.max(slip) > 0.3
    assert values(result, "wheel.lossPower") == pytest.approx(
        slip * values(result, "wheel.f"), rel=1e-6, abs=1e-6
    )


def test_simple_wheel() -> None:
    result = run(
        body("hub", 10, 1, v=(1, 0.5))
        + """
  SimpleWheel wheel(radius = 0.25, c_x = 2, c_y = 20);
  Real torque = 5;
equation
  wheel.thrust = torque;
  connect(hub.frame_a, wheel.frame_a);
""",
        stop_time=3,
        gravity=LEVEL,
    )
    t = result.times
    final = 5 / 0.25 / 2
    assert values(result, "hub.v[1]") == pytest.approx(
        final + (1 - final) * np.exp(-0.2 * t), abs=1e-7
    )
    assert values(result, "hub.v[2]") == pytest.approx(0.5 * np.exp(-2 * t), abs=1e-7)


def test_air_drag() -> None:
    result = run(
        body("car", 1000, 500, v=(30, 0))
        + body("driftingCar", 1000, 500, v=(18, 24), phi=float(np.arctan2(4, 3)))
        + """
  AirResistanceLongitudinal drag(c_W = 0.3, area = 2.2, rho = 1.2);
  AirResistanceLongitudinal other(c_W = 0.3, area = 2.2, rho = 1.2);
  Body cart(m = 10, I = 1, r(each fixed = true), v(each fixed = true), phi(fixed = true),
    w(fixed = true));
  AirResistanceLongitudinal sail(v_wind = {-6, 100});
equation
  connect(car.frame_a, drag.frame_a);
  connect(driftingCar.frame_a, other.frame_a);
  connect(cart.frame_a, sail.frame_a);
""",
        stop_time=60,
        gravity=LEVEL,
    )
    k = 0.3 * 2.2 * 1.2 / 2 / 1000
    speed = 30 / (1 + 30 * k * result.times)
    assert values(result, "car.v[1]") == pytest.approx(speed, abs=1e-6)
    assert vector(result, "driftingCar.v") == pytest.approx(np.outer([0.6, 0.8], speed), abs=1e-6)
    # the wind carries the cart along, backwards, up to its own speed
    k = 0.5 * 2 * 1.18 / 2 / 10
    wind = -6 + 6 / (1 + 6 * k * result.times)
    assert values(result, "cart.v[1]") == pytest.approx(wind, abs=1e-6)
    assert values(result, "cart.v[2]") == pytest.approx(0, abs=1e-12)


def test_differential_gear() -> None:
    result = run(
        """
  DifferentialGear differential;
  mechanical.rotational.Inertia left(J = 1, phi(fixed = true), w(fixed = true));
  mechanical.rotational.Inertia right(J = 3, phi(fixed = true), w(fixed = true));
  mechanical.rotational.ConstantTorque motor(tau_constant = 6);
equation
  connect(motor.flange, differential.flange_b);
  connect(differential.flange_left, left.flange_a);
  connect(differential.flange_right, right.flange_a);
"""
    )
    t = result.times
    assert values(result, "left.w") == pytest.approx(3 * t, abs=1e-8)
    assert values(result, "right.w") == pytest.approx(t, abs=1e-8)
    assert values(result, "differential.flange_b.phi") == pytest.approx(t**2, abs=1e-8)


def tyre(name: str) -> str:
    return (
        f"  SlipBasedWheelJoint {name}(radius = 0.3, N = 4000, sAdhesion = 0.05, sSlide = 0.15, "
        "vAdhesion_min = 0.1, vSlide_min = 0.3);\n"
    )


def test_single_track_vehicle_keeps_its_power_balance() -> None:
    result = run(
        tyre("front")
        + tyre("rear")
        + body("chassis", 800, 600, v=(8, 0))
        + """
  FixedTranslation toFront(r = {1.2, 0}), toRear(r = {-1.3, 0});
  Revolute steering(useFlange = true);
  mechanical.rotational.Position wheel(exact = true);
  blocks.Sine steer(offset = 0.08, amplitude = 0.08, f = 0.1, phase = -90[deg]);
  Body frontAxle(m = 30, I = 1), rearAxle(m = 30, I = 1);
  mechanical.rotational.Inertia frontWheel(J = 1, phi(fixed = true), w(start = 26, fixed = true));
  mechanical.rotational.Inertia rearWheel(J = 1, phi(fixed = true), w(start = 26, fixed = true));
  mechanical.rotational.ConstantTorque engine(tau_constant = 300);
  AirResistanceLongitudinal drag;
  Real work(start = 0, fixed = true), lost(start = 0, fixed = true);
equation
  connect(chassis.frame_a, toFront.frame_a, toRear.frame_a, drag.frame_a);
  connect(toFront.frame_b, steering.frame_a);
  connect(steer.y, wheel.phi_ref);
  connect(wheel.flange, steering.flange_a);
  connect(steering.frame_b, front.frame_a, frontAxle.frame_a);
  connect(toRear.frame_b, rear.frame_a, rearAxle.frame_a);
  connect(front.flange_a, frontWheel.flange_b);
  connect(engine.flange, rearWheel.flange_a);
  connect(rearWheel.flange_b, rear.flange_a);
  der(work) = engine.tau*rearWheel.w - wheel.flange.tau*der(steering.phi);
  der(lost) = front.lossPower + rear.lossPower + drag.fDrag*drag.v_air;
""",
        stop_time=5,
        gravity=LEVEL,
        tolerance=1e-8,
    )
    work, lost = values(result, "work"), values(result, "lost")
    kinetic = (values(result, "frontWheel.w") ** 2 + values(result, "rearWheel.w") ** 2) / 2
    for name, mass, inertia in (("chassis", 800, 600), ("frontAxle", 30, 1), ("rearAxle", 30, 1)):
        kinetic += mass / 2 * (vector(result, f"{name}.v") ** 2).sum(axis=0)
        kinetic += inertia / 2 * values(result, f"{name}.w") ** 2
    assert kinetic - work + lost == pytest.approx(kinetic[0], rel=1e-6)
    assert np.all(np.diff(lost) >= -1e-9)
    # it goes to the left in a circle: yaw rate and speed belong to each other
    speed = np.hypot(*vector(result, "chassis.v"))
    late = result.times > 4
    radius = speed[late] / values(result, "chassis.w")[late]
    assert np.all((radius > 2.5 / np.tan(0.16) * 0.9) & (radius < 60))
    assert speed[-1] > 10


def test_two_tracks_with_a_differential_gear() -> None:
    wheels: dict[str, Any] = {
        "fl": (1.2, 0.75),
        "fr": (1.2, -0.75),
        "rl": (-1, 0.75),
        "rr": (-1, -0.75),
    }
    parts = "".join(
        f"""
  FixedTranslation to_{name}(r = {{{x}, {y}}});
  DryFrictionWheelJoint {name}(radius = 0.25, N = 1500, vAdhesion = 0.1, vSlide = 0.3);
  mechanical.rotational.Inertia j_{name}(J = 1, phi(fixed = true), w(fixed = true));
"""
        for name, (x, y) in wheels.items()
    )
    ends = "".join(
        f"  connect({name}.flange_a, j_{name}.flange_b);\n"
        + f"  connect(chassis.frame_a, to_{name}.frame_a);\n"
        + (
            f"  connect(to_{name}.frame_b, {name}.frame_a);\n"
            if name[0] == "r"
            else f"  connect(to_{name}.frame_b, turn_{name}.frame_a);\n"
            f"  connect(turn_{name}.frame_b, {name}.frame_a);\n"
        )
        for name in wheels
    )
    result = run(
        body("chassis", 500, 300)
        + parts
        + """
  FixedRotation turn_fl(alpha = 0.25), turn_fr(alpha = 0.2);
  DifferentialGear differential;
  mechanical.rotational.ConstantTorque engine(tau_constant = 60);
  Real lost(start = 0, fixed = true), work(start = 0, fixed = true);
equation
  connect(engine.flange, differential.flange_b);
  connect(differential.flange_left, j_rl.flange_a);
  connect(differential.flange_right, j_rr.flange_a);
  der(lost) = fl.lossPower + fr.lossPower + rl.lossPower + rr.lossPower;
  der(work) = engine.tau*der(differential.flange_b.phi);
"""
        + ends,
        stop_time=8,
        gravity=LEVEL,
        tolerance=1e-8,
    )
    spin = {name: values(result, f"j_{name}.w") for name in wheels}
    kinetic = (
        250 * (vector(result, "chassis.v") ** 2).sum(axis=0)
        + 150 * values(result, "chassis.w") ** 2
        + sum(w**2 for w in spin.values()) / 2
    )
    work, lost = values(result, "work"), values(result, "lost")
    assert kinetic + lost == pytest.approx(work, rel=1e-6, abs=1e-3)
    # the outer wheel of the driven axle turns faster, both get the same torque
    assert np.all(spin["rr"][50:] > spin["rl"][50:])
    drive = 2 * np.gradient(work, result.times, edge_order=2)
    assert np.all(drive[50:-50] > 0)
    assert values(result, "differential.flange_left.tau") == pytest.approx(-30)
    assert values(result, "differential.flange_right.tau") == pytest.approx(-30)
    # it drives round the point where the axles of its wheels meet
    radius = np.hypot(*vector(result, "chassis.v"))[1:] / values(result, "chassis.w")[1:]
    assert radius[200] == pytest.approx(2.2 / np.tan(0.22), rel=0.1)
