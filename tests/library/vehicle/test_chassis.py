"""Single-track vehicle: reference data, linear model, load transfer, power balance."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from acausal import compile_file
from tests.library.vehicle.running import DATA, magic_formula, simulate, values

EXAMPLE = Path(__file__).parents[3] / "examples" / "single_track_vehicle.acm"
REFERENCE = json.loads((DATA / "single_track_magic_formula.json").read_text())
MANOEUVRES: list[dict[str, Any]] = [
    {"v_start": 20.0, "delta_constant": 0.02},
    {"v_start": 20.0, "delta_constant": 0.1},
    {"v_start": 25.0, "delta_constant": 0.0, "delta_amplitude": 0.05},
]


@pytest.mark.parametrize("case", range(3))
def test_vehicle_follows_the_reference(case: int) -> None:
    compiled = compile_file(EXAMPLE, model="RollingFreely", parameters=MANOEUVRES[case])
    result = compiled.simulate(stop_time=4, tolerance=1e-10, points=41)
    names = {"X": "x", "Y": "y", "psi": "psi", "vx": "v_x", "vy": "v_y", "yaw_rate": "r"}
    for row in REFERENCE["cases"][case]["trajectory"]:
        k = int(np.argmin(np.abs(result.times - row["t"])))
        for theirs, ours in names.items():
            value = values(result, f"car.chassis.{ours}")[k]
            assert value == pytest.approx(float(row[theirs]), abs=2e-7), (row["t"], ours)


CAR = """  parameter Real v0 = 20, angle = 0.005;
  SingleTrackVehicle car(h = 0, c_w = 0, fR0 = 0, fR1 = 0, fR4 = 0, useShafts = false,
    relaxation = false, l_f = 1.1, l_r = 1.5, m = 1300, I_z = 2000, B_f = 9, B_r = 11,
    chassis(v_x(start = v0, fixed = true), x(fixed = true), y(fixed = true), psi(fixed = true),
    v_y(fixed = true), r(fixed = true)));
equation
  car.delta = angle;
"""


@pytest.mark.parametrize("v0", [10.0, 20.0, 35.0])
def test_stationary_circle_and_understeer_gradient(v0: float) -> None:
    # delta = l/rho + EG a_y, EG = m/l (l_r/C_f - l_f/C_r), with the stiffnesses C = B C D.
    result = simulate(CAR, {"v0": v0, "angle": 2e-4}, stop_time=3, tolerance=1e-10)
    l_f, l_r, m = 1.1, 1.5, 1300.0
    load = m * 9.80665 / (l_f + l_r)
    front = 9 * 1.3 * 0.7 * load * l_r
    rear = 11 * 1.3 * 0.7 * load * l_f
    gradient = m / (l_f + l_r) * (l_r / front - l_f / rear)
    yaw = v0 / ((l_f + l_r) + gradient * v0**2) * 2e-4
    assert values(result, "car.r")[-1] == pytest.approx(yaw, rel=2e-3)
    assert values(result, "car.a_y")[-1] == pytest.approx(yaw * v0, rel=2e-3)
    beta = yaw * (l_r / v0 - m * v0 * l_f / ((l_f + l_r) * rear))
    assert values(result, "car.beta")[-1] == pytest.approx(beta, rel=1e-2)


def test_small_motion_has_the_eigenvalues_of_the_linear_model() -> None:
    # Yaw rate after a lateral kick, against the matrix of the linear single-track model.
    text = CAR.replace("v_y(fixed = true)", "v_y(start = 0.01, fixed = true)")
    result = simulate(text, {"v0": 30.0, "angle": 0.0}, stop_time=1, tolerance=1e-10, points=101)
    l_f, l_r, m, inertia, v = 1.1, 1.5, 1300.0, 2000.0, 30.0
    load = m * 9.80665 / (l_f + l_r)
    front, rear = 9 * 1.3 * 0.7 * load * l_r, 11 * 1.3 * 0.7 * load * l_f
    matrix = np.array(
        [
            [-(front + rear) / (m * v), -v - (front * l_f - rear * l_r) / (m * v)],
            [
                -(front * l_f - rear * l_r) / (inertia * v),
                -(front * l_f**2 + rear * l_r**2) / (inertia * v),
            ],
        ]
    )
    eigenvalues, vectors = np.linalg.eig(matrix)
    weights = np.linalg.solve(vectors, np.array([0.01, 0.0]))
    expected = (vectors[1] * weights * np.exp(np.outer(result.times, eigenvalues))).sum(1).real
    assert values(result, "car.r") == pytest.approx(expected, abs=2e-7)


def test_axle_loads_shift_with_acceleration_and_slope() -> None:
    result = simulate(
        """  LongitudinalChassis car(m = 1000, l_f = 1, l_r = 1.5, h = 0.5, c_w = 0.4, A = 2,
    v_wind = -5,
    inclination_constant = 0.2, s(fixed = true), v_x(start = 20, fixed = true));
  mechanical.translational.ConstantForce push(f_constant = 4000);
equation
  connect(push.flange, car.flange);
""",
        stop_time=5,
    )
    slope, v = np.arctan(0.2), values(result, "car.v_x")
    drag = 0.6 * 0.4 * 2 * (v + 5) ** 2
    weight = 1000 * 9.80665
    assert 1000 * values(result, "car.a_x") == pytest.approx(
        4000 - drag - weight * np.sin(slope), rel=1e-7
    )
    # Moments about the rear contact: what pushes acts on the ground.
    front = (weight * np.cos(slope) * 1.5 - 0.5 * (4000 - drag)) / 2.5
    assert values(result, "car.load_front") == pytest.approx(front, rel=1e-7)
    total = values(result, "car.load_front") + values(result, "car.load_rear")
    assert total == pytest.approx(np.full_like(total, weight * np.cos(slope)))


def test_steering_step_at_100_km_h() -> None:
    result = compile_file(EXAMPLE, model="SteeringStep").simulate(stop_time=6, tolerance=1e-7)
    t = result.times
    speed = values(result, "car.v")
    assert np.max(np.abs(speed - 100 / 3.6)) < 0.2
    before, late = t < 0.99, t > 5.5
    assert np.max(np.abs(values(result, "car.r")[before])) < 1e-9
    yaw, side = values(result, "car.r")[late].mean(), values(result, "car.a_y")[late].mean()
    assert side == pytest.approx(yaw * speed[late].mean(), rel=1e-3)
    # Nearly linear: EG from the stiffnesses of the data.
    front, rear = 10.96 * 1.3 * 4560.4, 12.67 * 1.3 * 3947.81
    gradient = 1239 / 2.565 * (1.37484 / front - 1.19016 / rear)
    linear = speed[late].mean() / (2.565 + gradient * speed[late].mean() ** 2) * 0.02
    assert yaw == pytest.approx(linear, rel=0.06)
    assert values(result, "car.beta")[late].mean() < -0.02
    # The vehicle overshoots a little, and the engine turns at 3.91 times the wheel in fourth gear.
    assert 1.01 < np.max(values(result, "car.r")) / yaw < 1.3
    ratio = values(result, "engine.w") / values(result, "car.rear.w")
    assert ratio[late] == pytest.approx(3.91, rel=1e-6)


def random_drive(seed: int) -> tuple[str, float]:
    """Return a vehicle with random parameters that is driven, braked and steered."""
    rng = np.random.default_rng(seed)
    m, inertia, j = rng.uniform(700, 2500), rng.uniform(800, 4000), rng.uniform(0.5, 5)
    combined = ["Separate", "Ellipse", "Weighting"][seed % 3]
    v = rng.uniform(8, 35)
    text = f"""  SingleTrackVehicle car(m = {m}, I_z = {inertia}, J = {j},
    h = {rng.uniform(0, 0.7)},
    l_f = {rng.uniform(0.9, 1.6)}, l_r = {rng.uniform(0.9, 1.6)}, c_w = {rng.uniform(0.2, 0.5)},
    B_f = {rng.uniform(6, 12)}, B_r = {rng.uniform(9, 14)}, mu_f = {rng.uniform(0.5, 1.1)},
    relaxation = {"true" if seed % 2 else "false"}, combined = CombinedSlip.{combined},
    inclination = {rng.uniform(-0.1, 0.1)}, mu_road = {rng.uniform(0.4, 1)},
    chassis(v_x(start = {v}, fixed = true), x(fixed = true), y(fixed = true), psi(fixed = true),
    v_y(fixed = true), r(fixed = true)), front(phi(fixed = true), w(start = {v / 0.302},
    fixed = true)), rear(phi(fixed = true), w(start = {v / 0.302}, fixed = true)));
  blocks.Sine steering(amplitude = {rng.uniform(0.01, 0.1)}, f = {rng.uniform(0.2, 1)});
  blocks.Sine drive(amplitude = {rng.uniform(100, 1200)}, f = {rng.uniform(0.2, 1)});
  blocks.Sine pressed(offset = -0.1, amplitude = 0.4, f = {rng.uniform(0.3, 1)});
  mechanical.rotational.Torque motor;
  Brake brake;
  Real energy = car.m*(car.chassis.v_x^2 + car.chassis.v_y^2)/2 + car.I_z*car.chassis.r^2/2
    + car.J*(car.front.w^2 + car.rear.w^2)/2;
  Real work(start = 0, fixed = true), lost(start = 0, fixed = true);
equation
  connect(steering.y, car.delta);
  connect(drive.y, motor.tau);
  connect(pressed.y, brake.pedal);
  connect(motor.flange, car.shaft_rear);
  connect(brake.flange_b, car.shaft_front);
  der(work) = drive.y*car.rear.w - car.m*car.chassis.g*sin(car.chassis.slope)*car.chassis.v_x;
  der(lost) = car.front.lossPower + car.rear.lossPower + brake.lossPower
    + car.chassis.drag*car.chassis.v_x;
"""
    return text, m * v**2 / 2


@pytest.mark.parametrize("seed", range(6))
def test_power_balance_of_random_vehicles(seed: int) -> None:
    text, scale = random_drive(seed)
    result = simulate(text, stop_time=3)
    balance = values(result, "energy") - values(result, "work") + values(result, "lost")
    assert balance == pytest.approx(np.full_like(balance, balance[0]), abs=2e-6 * scale)
    assert np.ptp(values(result, "energy")) > 1e-3 * scale


def test_planar_vehicle_from_a_body_and_two_wheels() -> None:
    # The single-track vehicle built of planar parts moves as the one in the library.
    parameters = """combined = CombinedSlip.Separate, R = 0.3, J = 1.5, load_constant = 6000,
    fR0 = 0, fR1 = 0, fR4 = 0, relaxation = true, phi(fixed = true),
    w(start = 20/0.3, fixed = true), u_x(fixed = true), u_y(fixed = true)"""
    result = simulate(
        f"""  inner mechanical.planar.PlanarWorld world(g = {{0, 0}});
  mechanical.planar.Body body(m = 1200, I = 1500, r(start = {{0, 0}}, each fixed = true),
    v(start = {{20, 0}}, each fixed = true), phi(fixed = true), w(fixed = true));
  mechanical.planar.FixedTranslation ahead(r = {{1.2, 0}}), behind(r = {{-1.4, 0}});
  mechanical.planar.FixedRotation steered(alpha = 0.03);
  Wheel front({parameters}), rear({parameters});
  SingleTrackChassis chassis(m = 1200, I_z = 1500, c_w = 0, v_x(start = 20, fixed = true),
    x(fixed = true), y(fixed = true), psi(fixed = true), v_y(fixed = true), r(fixed = true));
  Wheel frontOther({parameters}), rearOther({parameters});
  blocks.Constant delta(k = 0.03);
equation
  connect(body.frame_a, ahead.frame_a, behind.frame_a);
  connect(ahead.frame_b, steered.frame_a);
  connect(steered.frame_b, front.hub);
  connect(behind.frame_b, rear.hub);
  connect(delta.y, chassis.delta);
  connect(chassis.front, frontOther.hub);
  connect(chassis.rear, rearOther.hub);
""",
        stop_time=2,
        tolerance=1e-9,
    )
    for planar, single in (("body.r[1]", "x"), ("body.r[2]", "y"), ("body.phi", "psi")):
        theirs = values(result, f"chassis.{single}")
        assert values(result, planar) == pytest.approx(theirs, abs=2e-6)
    assert values(result, "chassis.y")[-1] > 2


def scipy_vehicle(torque: float, brake: float, angle: float, v0: float, stop: float) -> Any:
    """Integrate the whole vehicle, written down once more by hand; return v_x, v_y, r, w, w."""
    m, inertia, l_f, l_r, h, radius, j = 1239.0, 1752.0, 1.19016, 1.37484, 0.5, 0.302, 3.0
    g, length = 9.80665, 1.19016 + 1.37484

    def tyre(u: Any, w: float, velocity: Any, load: float, b: float) -> Any:
        kappa, alpha = u[0], np.arctan(u[1])
        s_x, s_y = 12 * 1.65 * kappa, b * 1.3 * alpha
        s = np.sqrt(s_x**2 + s_y**2 + 1e-12)
        long = s_x / s * magic_formula(s / (12 * 1.65), 12, 1.65, load, 0.3)
        side = s_y / s * magic_formula(s / (b * 1.3), b, 1.3, 0.7 * load, -0.5)
        hold = max(0.03, magic_formula(s / (12 * 1.65), 12, 1.65, 1, 0.3) / s)
        slip = velocity[0] - radius * w
        rates = [
            (-slip - abs(velocity[0]) * u[0]) / (0.15 * hold),
            (-velocity[1] - abs(velocity[0]) * u[1]) / (0.4 * hold),
        ]
        x = velocity[0] * 3.6 / 100
        rolling = radius * load * (0.009 + 0.002 * x + 0.0003 * x**4) * np.tanh(4 * radius * w)
        return long, side, rates, rolling

    def rates(_: float, z: Any) -> Any:
        vx, vy, r, wf, wr = z[:5]
        drag = 1.25 / 2 * 0.3 * 1.44 * vx * abs(vx)
        c, s = np.cos(angle), np.sin(angle)
        front = (c * vx + s * (vy + l_f * r), -s * vx + c * (vy + l_f * r))
        a_x = 0.0
        for _ in range(60):
            load = m * (g * l_r - h * a_x) / length, m * (g * l_f + h * a_x) / length
            xf, yf, uf, roll_f = tyre(z[5:7], wf, front, load[0], 10.96)
            xr, yr, ur, roll_r = tyre(z[7:9], wr, (vx, vy - l_r * r), load[1], 12.67)
            a_x = (c * xf - s * yf + xr - drag) / m
        lateral = s * xf + c * yf
        return [
            a_x + vy * r,
            (lateral + yr) / m - vx * r,
            (l_f * lateral - l_r * yr) / inertia,
            (-brake - radius * xf - roll_f) / j,
            (torque - radius * xr - roll_r) / j,
            *uf,
            *ur,
        ]

    start = [v0, 0, 0, v0 / radius, v0 / radius, 0, 0, 0, 0]
    times = np.linspace(0, stop, 41)
    return solve_ivp(rates, (0, stop), start, "LSODA", times, rtol=1e-9, atol=1e-10).y[:5]


@pytest.mark.parametrize(
    ("torque", "brake", "angle"), [(300.0, 0.0, 0.02), (0.0, 900.0, -0.03), (900.0, 0.0, 0.06)]
)
def test_vehicle_against_an_independent_program(torque: float, brake: float, angle: float) -> None:
    result = simulate(
        f"""  SingleTrackVehicle car(chassis(v_x(start = 28, fixed = true), x(fixed = true),
    y(fixed = true), psi(fixed = true), v_y(fixed = true), r(fixed = true)),
    front(phi(fixed = true), w(start = 28/0.302, fixed = true), u_x(fixed = true),
    u_y(fixed = true)), rear(phi(fixed = true), w(start = 28/0.302, fixed = true),
    u_x(fixed = true), u_y(fixed = true)));
  mechanical.rotational.ConstantTorque drive(tau_constant = {torque});
  mechanical.rotational.ConstantTorque slow(tau_constant = {-brake});
  blocks.Constant delta(k = {angle});
equation
  connect(drive.flange, car.shaft_rear);
  connect(slow.flange, car.shaft_front);
  connect(delta.y, car.delta);
""",
        stop_time=2,
        tolerance=1e-9,
        points=41,
    )
    expected = scipy_vehicle(torque, brake, angle, 28.0, 2.0)
    names = ("chassis.v_x", "chassis.v_y", "chassis.r", "front.w", "rear.w")
    for row, name in zip(expected, names, strict=True):
        own = np.interp(np.linspace(0, 2, 41), result.times, values(result, f"car.{name}"))
        assert own == pytest.approx(row, abs=1e-4 * max(1.0, np.max(np.abs(row)))), name
