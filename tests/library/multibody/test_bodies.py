"""Free bodies, pendulums, gyroscopes, gravity: closed forms and independent solutions."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from tests.library.multibody.bodies import (
    ROOT,
    G,
    energy,
    matrix,
    run,
    run_example,
    solution,
    values,
    vector,
)
from tests.msl.tube import tube

INERTIA = np.array([0.2, 0.5, 0.6])
START = [0.3, 5.0, -0.2]


def torque_free(_: float, w: Any) -> Any:
    return -np.cross(w, INERTIA * w) / INERTIA


@pytest.mark.parametrize("states", ["quaternions", "angles", "joint"])
def test_a_free_body_turns_by_euler_s_equations_and_falls(states: str) -> None:
    use = "false" if states == "angles" else "true"
    joint = "  FreeMotion joint(r_rel_a(each fixed = true), v_rel_a(start = {1, 2, 3}, each fixed = true), angles_fixed = true, w_rel_b_fixed = true, w_rel_b_start = {0.3, 5, -0.2});\n"  # noqa: E501
    free = "r_0(each fixed = true), v_0(start = {1, 2, 3}, each fixed = true), angles_fixed = true, w_0_fixed = true, w_0_start = {0.3, 5, -0.2}, "  # noqa: E501
    text = (
        (joint if states == "joint" else "")
        + f"  Body body({'' if states == 'joint' else free}m = 2, I_11 = 0.2, I_22 = 0.5, I_33 = 0.6, useQuaternions = {use});\n"  # noqa: E501
        + "equation\n"
        + (
            "  connect(world.frame_b, joint.frame_a);\n  connect(joint.frame_b, body.frame_a);\n"
            if states == "joint"
            else ""
        )
    )
    result = run(text, 2.0, tolerance=1e-10)
    t = np.asarray(result.times)
    w = solution(torque_free, START, t)
    assert vector(result, "body.w_a") == pytest.approx(w, abs=1e-6)
    momentum = np.einsum("jit,jt->it", matrix(result, "body.frame_a.R.T"), INERTIA[:, None] * w)
    assert momentum == pytest.approx(np.outer(INERTIA * START, np.ones_like(t)), abs=1e-6)
    fall = np.array([t, 2 * t, 3 * t - G * t**2 / 2])
    assert vector(result, "body.r_0") == pytest.approx(fall, abs=1e-7)


def test_states_of_a_body_far_from_its_centre_of_mass() -> None:
    result = run(
        "  Body body(r_0(each fixed = true), v_0(each fixed = true), angles_fixed = true,"
        " angles_start = {0.5, 0.2, 0.1}, sequence_start = {3, 2, 1}, w_0_fixed = true,"
        " w_0_start = {1, -2, 3}, r_CM = {0.3, 0.1, -0.2}, m = 2, I_11 = 0.2, I_22 = 0.3,"
        " I_33 = 0.4, I_21 = 0.05, I_31 = 0.02, I_32 = -0.03);\n",
        2.0,
    )
    tensor = np.array([[0.2, 0.05, 0.02], [0.05, 0.3, -0.03], [0.02, -0.03, 0.4]])
    total = energy(result, "body", 2, (0.3, 0.1, -0.2), tensor)
    assert total == pytest.approx(total[0], abs=1e-6)
    centre = vector(result, "body.r_0") + np.einsum(
        "jit,j->it", matrix(result, "body.frame_a.R.T"), [0.3, 0.1, -0.2]
    )
    t = np.asarray(result.times)
    velocity = np.cross([1, -2, 3], centre[:, 0])
    fall = centre[:, :1] + np.outer(velocity, t) - np.outer([0, 0, G / 2], t**2)
    assert centre == pytest.approx(fall, abs=1e-6)


def test_the_initial_angular_acceleration_can_be_given() -> None:
    w = np.array([1.0, 2.0, 3.0])
    inertia = np.array([0.1, 0.2, 0.4])
    z = -np.cross(w, inertia * w) / inertia
    result = run(
        "  Body body(r_0(each fixed = true), v_0(each fixed = true), angles_fixed = true,"
        f" z_0_fixed = true, z_0_start = {{{z[0]}, {z[1]}, {z[2]}}},"
        " w_a(start = {0.9, 2.2, 3.1}),"
        " I_11 = 0.1, I_22 = 0.2, I_33 = 0.4);\n",
        0.01,
        world="gravityType = GravityTypes.NoGravity",
    )
    assert vector(result, "body.w_a")[:, 0] == pytest.approx(w, abs=1e-6)
    assert vector(result, "body.z_a")[:, 0] == pytest.approx(z, abs=1e-6)


def test_a_point_mass_on_a_circular_orbit() -> None:
    result = run(
        "  PointMass mass(r_0(start = {7e6, 0, 0}, each fixed = true), v_0(start = {0, v, 0},"
        " each fixed = true));\n  parameter Real v = sqrt(3.986004418e14/7e6);\n",
        6000,
        world="gravityType = GravityTypes.PointGravity",
        tolerance=1e-10,
    )
    angle = np.sqrt(3.986004418e14 / 7e6**3) * np.asarray(result.times)
    expected = 7e6 * np.array([np.cos(angle), np.sin(angle), 0 * angle])
    assert vector(result, "mass.r_0") == pytest.approx(expected, abs=50)


def test_without_gravity_nothing_falls() -> None:
    result = run(
        "  PointMass mass(r_0(each fixed = true), v_0(each fixed = true));\n",
        world="gravityType = GravityTypes.NoGravity",
    )
    assert vector(result, "mass.r_0") == pytest.approx(0, abs=1e-12)


def test_shapes_have_mass_and_inertia_of_their_geometry() -> None:
    result = run(
        "  Fixed a, b, c;\n"
        "  BodyBox box(r = {0, 0.4, 0}, width = 0.2, height = 0.1, innerWidth = 0.1,"
        " innerHeight = 0.05, density = 1000, widthDirection = {1, 0, 0});\n"
        "  Real m = box.m, I_box[3, 3] = box.body.I, I_cylinder[3, 3] = cylinder.body.I;\n"
        "  Real r_CM[3] = cylinder.r_CM;\n"
        "  BodyCylinder cylinder(r = {0, 0, 0.5}, diameter = 0.2, innerDiameter = 0.1);\n"
        "  BodyShape shape(r = {1, 2, 3}, r_CM = {0.5, 0, 0}, m = 3, I_11 = 0.1, I_21 = 0.01);\n"
        "equation\n  connect(a.frame_b, box.frame_a);\n  connect(b.frame_b, cylinder.frame_a);\n"
        "  connect(c.frame_b, shape.frame_a);\n"
    )
    box, hollow = 1000 * 0.4 * 0.2 * 0.1, 1000 * 0.4 * 0.1 * 0.05
    assert values(result, "m")[0] == pytest.approx(box - hollow)
    # x is the width, y the length, z the height
    expected = [
        (box * (0.4**2 + 0.1**2) - hollow * (0.4**2 + 0.05**2)) / 12,
        (box * (0.2**2 + 0.1**2) - hollow * (0.1**2 + 0.05**2)) / 12,
        (box * (0.4**2 + 0.2**2) - hollow * (0.4**2 + 0.1**2)) / 12,
    ]
    assert matrix(result, "I_box")[:, :, 0] == pytest.approx(np.diag(expected), abs=1e-12)
    outer, inner = 7700 * np.pi * 0.5 * 0.1**2, 7700 * np.pi * 0.5 * 0.05**2
    across = (outer * (0.25 + 3 * 0.01) - inner * (0.25 + 3 * 0.0025)) / 12
    about = (outer * 0.01 - inner * 0.0025) / 2
    assert matrix(result, "I_cylinder")[:, :, 0] == pytest.approx(
        np.diag([across, across, about]), abs=1e-12
    )
    assert vector(result, "r_CM")[:, 0] == pytest.approx([0, 0, 0.25])
    # the mass of what hangs on a fixed frame is its weight there
    assert vector(result, "c.frame_b.f")[:, 0] == pytest.approx([0, 0, -3 * G], abs=1e-9)
    assert vector(result, "c.frame_b.t")[:, 0] == pytest.approx([0, 1.5 * G, 0], abs=1e-9)
    assert vector(result, "shape.frame_b.r_0")[:, 0] == pytest.approx([1, 2, 3])


def test_the_gyroscope_precesses_regularly() -> None:
    result = run_example("gyroscope", tolerance=1e-9, stop_time=1.0)
    speed = G / 9.81 * 9.80665 * 0.1 / (2e-3 * 3000 * np.pi / 30)
    assert values(result, "psi") == pytest.approx(speed * np.asarray(result.times), abs=1e-6)
    assert values(result, "theta") == pytest.approx(0, abs=1e-6)


def test_the_spherical_pendulum_of_bodies_is_that_of_equations() -> None:
    options = {"stop_time": 4.0, "points": 401, "tolerance": 1e-9}
    bodies = run_example("spherical_pendulum_bodies", **options)
    equations = run_example("spherical_pendulum", **options)
    for k, name in enumerate("xyz"):
        assert values(bodies, f"r[{k + 1}]") == pytest.approx(values(equations, name), abs=1e-5)
    for name in ("energy", "momentum"):
        conserved = values(bodies, name)
        assert conserved == pytest.approx(conserved[0], abs=1e-6)
        assert abs(conserved[0]) > 1
    length = np.linalg.norm(vector(bodies, "r"), axis=0)
    assert length == pytest.approx(1, abs=1e-12)


def test_the_governor_settles_where_the_moments_balance() -> None:
    result = run_example("watt_governor", tolerance=1e-8, stop_time=12.0)
    theta, w = values(result, "theta")[-1], 4 * np.pi
    assert w**2 * (0.04 + 0.3 * np.sin(theta)) == pytest.approx(9.80665 * np.tan(theta), rel=1e-3)
    assert values(result, "hinge_l.phi") == pytest.approx(values(result, "theta"), abs=1e-7)


def test_the_chain_in_space_keeps_its_energy() -> None:
    result = run_example("spatial_chain", tolerance=1e-8, stop_time=0.6)
    m = 7700 * np.pi * 0.2 * 0.01**2
    across = m * (0.2**2 + 3 * 0.01**2) / 12
    kinds = {"m": m, "r_cm": (0, 0, -0.1), "inertia": (across, across, m * 0.01**2 / 2)}
    each = [energy(result, f"link[{k}].bar.body", g=9.80665, **kinds) for k in range(1, 9)]
    total = np.sum(each, axis=0)
    assert total == pytest.approx(total[0], abs=1e-5 * np.ptp(each[-1]))


def test_the_five_link_suspension_against_its_reference() -> None:
    result = run_example("five_link_suspension", "FiveLinkRig", points=401, tolerance=1e-9)
    reference = json.loads((ROOT / "tests/data/classic/five_link_suspension.json").read_text())
    travel = values(result, "dz")
    for row in reference["solutions"]:
        at = {
            "x": np.interp(row["dz_mm"] / 1e3, travel, values(result, "centre[1]")),
            "y": np.interp(row["dz_mm"] / 1e3, travel, values(result, "centre[2]")),
        }
        for k, name in enumerate(("gamma", "beta", "alpha")):
            angle = values(result, f"suspension.angles[{k + 1}]")
            at[name] = np.interp(row["dz_mm"] / 1e3, travel, angle)
        for name, found in at.items():
            assert found == pytest.approx(float(row[name]), abs=5e-7)
        gamma, beta, alpha = (float(row[name]) for name in ("gamma", "beta", "alpha"))
        # second column of Rz Ry Rx
        axle = [
            np.cos(gamma) * np.sin(beta) * np.sin(alpha) - np.sin(gamma) * np.cos(alpha),
            np.sin(gamma) * np.sin(beta) * np.sin(alpha) + np.cos(gamma) * np.cos(alpha),
            np.cos(beta) * np.sin(alpha),
        ]
        toe = np.interp(row["dz_mm"] / 1e3, travel, values(result, "suspension.toe"))
        camber = np.interp(row["dz_mm"] / 1e3, travel, values(result, "suspension.camber"))
        assert toe == pytest.approx(np.arctan2(-axle[0], axle[1]), abs=5e-7)
        assert camber == pytest.approx(-np.arcsin(axle[2]), abs=5e-7)


def test_a_loop_of_seven_joints_is_the_one_with_a_rod_of_one_constraint() -> None:
    import csv
    import gzip

    path = ROOT / "tests/data/msl/Mechanics.MultiBody.Loops.Fourbar2.csv.gz"
    with gzip.open(path, "rt") as file:
        rows = list(csv.reader(file))
    reference = np.array(rows[1:], float)
    result = run_example("spatial_loop", stop_time=5.0, interval=0.01, tolerance=1e-6)
    for ours, theirs in (("crank.phi", "j1.phi"), ("crank.w", "j1.w")):
        bounds = tube(
            reference[:, 0], reference[:, rows[0].index(theirs)], np.asarray(result.times)
        )
        assert bounds.worst(values(result, ours)) == 0.0
