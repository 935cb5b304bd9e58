"""Drive trains on moving bodies, gears, rolling wheels, coordinates for start values."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.multibody.bodies import G, energy, matrix, run, values, vector

FREE = "gravityType = GravityTypes.NoGravity"
CARRIER = (
    "  Body carrier(r_0(each fixed = true), v_0(each fixed = true), angles_fixed = true,"
    " w_0_fixed = true, w_0_start = {0.3, 0.4, 1}, m = 5, I_11 = 0.3, I_22 = 0.4, I_33 = 0.5);\n"
    "  mechanical.rotational.Torque motor(useSupport = true);\n"
)


def test_a_rotor_of_a_drive_train_acts_as_a_body_on_a_joint() -> None:
    # the rotor of the second model is a body whose inertia is that about the axis only
    results = [
        run(
            CARRIER + part + "equation\n  motor.tau = 0.2;\n" + connections,
            2.0,
            world=FREE,
        )
        for part, connections in (
            (
                "  Mounting1D housing(n = {1, 0, 2});\n"
                "  Rotor1D rotor(J = 0.1, n = {1, 0, 2}, phi(fixed = true), w(start = 3,"
                " fixed = true));\n",
                "  connect(carrier.frame_a, housing.frame_a, rotor.frame_a);\n"
                "  connect(motor.support, housing.flange_b);\n"
                "  connect(motor.flange, rotor.flange_a);\n",
            ),
            (
                "  Revolute rotor(useAxisFlange = true, n = {1, 0, 2}, phi(fixed = true),"
                " w(start = 3, fixed = true));\n"
                "  Body disk(m = 0, I_11 = 0.02, I_31 = 0.04, I_33 = 0.08, I_22 = 0);\n",
                "  connect(carrier.frame_a, rotor.frame_a);\n"
                "  connect(rotor.frame_b, disk.frame_a);\n"
                "  connect(motor.support, rotor.support);\n"
                "  connect(motor.flange, rotor.axis);\n",
            ),
        )
    ]
    for name in ("rotor.phi", "rotor.w", *(f"carrier.w_a[{k}]" for k in (1, 2, 3))):
        one, other = (values(result, name) for result in results)
        assert one == pytest.approx(other, abs=1e-6), name
        assert np.ptp(one) > 0.05


def test_a_rotor_that_does_not_feel_the_turning_of_its_carrier() -> None:
    for world, exact, expected in (("", "false", 2.0), ("", "true", 2.0 - 5), ):  # fmt: skip
        result = run(
            "  Revolute table(n = {0, 0, 1}, useAxisFlange = true, phi(fixed = true));\n"
            "  mechanical.rotational.Accelerate drive;\n"
            "  Rotor1D rotor(J = 0.1, n = {0, 0, 1}, phi(fixed = true), w(start = 2,"
            f" fixed = true), exact = {exact});\nequation\n  drive.a_ref = 5;\n"
            "  connect(drive.flange, table.axis);\n  connect(world.frame_b, table.frame_a);\n"
            "  connect(table.frame_b, rotor.frame_a);\n",
            world=world or FREE,
        )
        assert values(result, "rotor.w")[-1] == pytest.approx(expected, abs=1e-6)
    result = run(
        "  Rotor1D rotor(J = 0.1, w(start = 2, fixed = true), phi(fixed = true));\n"
        "equation\n  connect(world.frame_b, rotor.frame_a);\n",
        world="driveTrainMechanics3D = false",
    )
    assert values(result, "rotor.phi")[-1] == pytest.approx(2)


def test_a_bevel_gear_keeps_the_angular_momentum() -> None:
    result = run(
        CARRIER + "  Mounting1D housing(n = {1, 0, 0});\n"
        "  Rotor1D first(J = 0.1, n = {1, 0, 0}, phi(fixed = true), w(fixed = true));\n"
        "  Rotor1D second(J = 0.3, n = {0, 1, 0});\n"
        "  BevelGear1D gear(ratio = 2, n_a = {1, 0, 0}, n_b = {0, 1, 0});\n"
        "equation\n  motor.tau = 0.5;\n"
        "  connect(carrier.frame_a, housing.frame_a, first.frame_a, second.frame_a);\n"
        "  connect(carrier.frame_a, gear.frame_a);\n"
        "  connect(motor.support, housing.flange_b);\n  connect(motor.flange, first.flange_a);\n"
        "  connect(first.flange_b, gear.flange_a);\n  connect(gear.flange_b, second.flange_a);\n",
        2.0,
        world=FREE,
    )
    w = vector(result, "carrier.w_a")
    spin = np.array([values(result, "first.L"), values(result, "second.L"), 0 * w[0]])
    own = np.array([0.3, 0.4, 0.5])[:, None] * w + spin
    total = np.einsum("jit,jt->it", matrix(result, "carrier.frame_a.R.T"), own)
    assert total == pytest.approx(np.outer(total[:, 0], np.ones(total.shape[1])), abs=1e-6)
    assert values(result, "first.w") == pytest.approx(2 * values(result, "second.w"), abs=1e-9)
    assert np.ptp(values(result, "first.w")) > 1


def test_wheels_of_a_gear_on_a_turning_bearing() -> None:
    inertia = (0.1, 0.2, 0.3)
    wheel = "m = 1, I_11 = 0.1, I_22 = 0.2, I_33 = 0.3"
    result = run(
        "  Revolute arm(n = {0, 1, 0}, phi(fixed = true), w(start = 1, fixed = true));\n"
        "  GearConstraint gear(ratio = -3, n_a = {0, 0, 1}, n_b = {0, 0, 1}, r_a = {0.3, 0, 0},"
        " r_b = {0.5, 0, 0}, revolute_a(phi(fixed = true), w(start = 6, fixed = true)));\n"
        f"  Body a({wheel}), b({wheel}), base({wheel});\nequation\n"
        "  connect(world.frame_b, arm.frame_a);\n"
        "  connect(arm.frame_b, gear.bearing, base.frame_a);\n"
        "  connect(gear.frame_a, a.frame_a);\n  connect(gear.frame_b, b.frame_a);\n"
    )
    total = sum(energy(result, name, 1, (0, 0, 0), inertia) for name in ("a", "b", "base"))
    assert total == pytest.approx(total[0], abs=1e-6)
    one, other = values(result, "gear.revolute_a.w"), values(result, "gear.revolute_b.w")
    assert one == pytest.approx(-3 * other, abs=1e-6)
    assert np.ptp(values(result, "arm.w")) > 0.1


def test_a_wheel_rolls_down_a_slope() -> None:
    # the slope is the plane; gravity is inclined
    alpha = 0.2
    result = run(
        "  RollingWheel wheel(radius = 0.3, m = 10, I_axis = 0.45, I_long = 0.225,"
        " body(r_0(start = {0, 0, 0.3}), phi(start = {0, 0, 0})));\n"
        "initial equation\n  wheel.body.r_0[1:2] = {0, 0};\n  wheel.angles = {0, 0, 0};\n"
        "  wheel.body.w_a = {0, 0, 0};\n",
        2.0,
        world=f"n = {{{np.sin(alpha)}, 0, {-np.cos(alpha)}}}, g = 9.81",
    )
    t = np.asarray(result.times)
    distance = G * np.sin(alpha) / (1 + 0.45 / (10 * 0.09)) * t**2 / 2
    assert values(result, "wheel.body.r_0[1]") == pytest.approx(distance, abs=1e-5)
    assert values(result, "wheel.angles[3]") == pytest.approx(distance / 0.3, abs=1e-4)
    assert values(result, "wheel.contact.f_n") == pytest.approx(10 * G * np.cos(alpha), abs=1e-5)


def test_a_leaning_wheel_rolls_in_a_curve_without_losses() -> None:
    result = run(
        "  RollingWheel wheel(body(r_0(start = {0, 0, 0.29})));\n"
        "initial equation\n  wheel.body.r_0[1:2] = {0, 0};\n  wheel.angles = {0, 0.2, 0};\n"
        "  wheel.body.w_a = {0.1, 8, 0.3};\n",
        2.0,
    )
    total = energy(result, "wheel.body", 10, (0, 0, 0), (0.225, 0.45, 0.225))
    assert total == pytest.approx(total[0], abs=1e-4)
    height = 0.3 * np.cos(values(result, "wheel.angles[2]"))
    assert values(result, "wheel.body.r_0[3]") == pytest.approx(height, abs=1e-7)
    assert np.ptp(values(result, "wheel.body.r_0[2]")) > 0.1
    # the point that touches the ground stands still
    v = vector(result, "wheel.body.v_0")
    v = (
        v
        + np.cross(
            vector(result, "wheel.contact.w_0").T, vector(result, "wheel.contact.delta_0").T
        ).T
    )
    assert v == pytest.approx(0, abs=1e-6)


def test_a_wheel_set_turns_with_the_difference_of_its_wheels() -> None:
    result = run(
        "  RollingWheelSet axle(track = 1.2, revolute1(phi(fixed = true)),"
        " revolute2(phi(fixed = true)));\n"
        "  Body load(m = 20, r_0(start = {0, 0, 0.3}));\n"
        "  mechanical.rotational.Speed left(exact = true), right(exact = true);\n"
        "initial equation\n  load.r_0[1:2] = {0, 0};\n  load.w_a[2] = 0;\n"
        "  load.frame_a.R.T[1, 2:3] = {0, 0};\n"
        "equation\n  connect(load.frame_a, axle.frameMiddle);\n"
        "  left.w_ref = 4;\n  right.w_ref = 6;\n"
        "  connect(left.flange, axle.axis1);\n  connect(right.flange, axle.axis2);\n",
        1.0,
    )
    t = np.asarray(result.times)
    forward, yaw = 0.3 * 5, 0.3 * (6 - 4) / 1.2
    expected = forward / yaw * np.array([np.sin(yaw * t), 1 - np.cos(yaw * t)])
    assert vector(result, "load.r_0")[:2] == pytest.approx(expected, abs=1e-4)
    assert values(result, "load.r_0[3]") == pytest.approx(0.3, abs=1e-6)


def test_single_coordinates_as_start_values() -> None:
    result = run(
        "  Body body(m = 2, I_11 = 0.1, I_22 = 0.2, I_33 = 0.3);\n"
        "  FreeMotionScalarInit free(use_r = true, use_v = true, use_a = true, use_angle = true,"
        " use_angle_d = true, use_angle_dd = true, use_w = true, use_z = true,"
        " sequence_start = {3, 2, 1}, r_rel_a_1(start = 1, fixed = true),"
        " r_rel_a_2(start = 2, fixed = true), r_rel_a_3(start = 3, fixed = true),"
        " v_rel_a_1(start = 4, fixed = true), v_rel_a_2(start = 5, fixed = true),"
        " v_rel_a_3(start = 6, fixed = true), angle_1(start = 0.1, fixed = true),"
        " angle_2(start = 0.2, fixed = true), angle_3(start = 0.3, fixed = true),"
        " angle_d_1(start = 1, fixed = true), w_rel_b_1(start = 0.5, fixed = true),"
        " w_rel_b_2(start = 0.7, fixed = true));\nequation\n"
        "  connect(world.frame_b, free.frame_a);\n  connect(body.frame_a, free.frame_b);\n",
        0.5,
    )
    t = np.asarray(result.times)
    fall = np.array([1 + 4 * t, 2 + 5 * t, 3 + 6 * t - G * t**2 / 2])
    assert vector(result, "body.r_0") == pytest.approx(fall, abs=1e-6)
    assert values(result, "free.a_rel_a_3") == pytest.approx(-G, abs=1e-6)
    start = {"angle_1": 0.1, "angle_2": 0.2, "angle_3": 0.3, "angle_d_1": 1, "w_rel_b_1": 0.5}
    for name, value in start.items():
        assert values(result, f"free.{name}")[0] == pytest.approx(value, abs=1e-7)
    # derivatives belong to what they are derivatives of
    for low, high in (
        ("angle_2", "angle_d_2"),
        ("angle_d_2", "angle_dd_2"),
        ("w_rel_b_3", "z_rel_b_3"),
    ):
        slope = np.gradient(values(result, f"free.{low}"), t)[1:-1]
        assert values(result, f"free.{high}")[1:-1] == pytest.approx(slope, abs=1e-3)
    assert np.array([values(result, f"free.w_rel_b_{k}") for k in (1, 2, 3)]) == pytest.approx(
        vector(result, "body.w_a"), abs=1e-9
    )
