"""Chains and closed loops against published digits and closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.library.planar.mechanisms import (
    G,
    body_energy,
    reference,
    run,
    run_example,
    solution,
    values,
    vector,
)


def index_of(times: Any, time: float) -> int:
    k = int(np.argmin(np.abs(times - time)))
    assert times[k] == pytest.approx(time, abs=1e-8)
    return k


RODS = reference("double_pendulum_rods")["cases"]


@pytest.mark.parametrize("case", RODS, ids=lambda c: f"{c['l']}-{c['initial']}")
def test_double_pendulum_of_rods(case: dict[str, Any]) -> None:
    first, second = (float(angle) for angle in case["theta0"])
    result = run_example(
        "double_rod_pendulum",
        "DoubleRodPendulum",
        {"l": case["l"], "m": case["m"], "phi0[1]": first, "phi0[2]": second},
        stop_time=5,
        interval=0.5,
        tolerance=1e-10,
    )
    for row in case["trajectory"]:
        k = index_of(result.times, float(row["t"]))
        for path, column in {
            "upper.phi": "theta1",
            "lower.phi": "theta2",
            "upper.w": "omega1",
            "lower.w": "omega2",
        }.items():
            assert values(result, path)[k] == pytest.approx(float(row[column]), abs=2e-5)
    assert np.ptp(values(result, "energy")) < 1e-6


def test_links_are_bodies_with_revolute_joints() -> None:
    # The same double pendulum of frames: bodies with two frames, joints with relative angles.
    result = run(
        """
  Anchor anchor;
  Link upper(r = {0.3, -0.9}, m = 2, phi(start = 1, fixed = true), w(fixed = true));
  Link lower(r = {0, -0.7}, r_CM = {0.1, -0.2}, m = 3, I = 0.4, phi(start = -0.5, fixed = true),
    w(start = 2, fixed = true));
  Fixed fixed;
  Revolute a(phi(start = 1, fixed = true), w(fixed = true));
  BodyShape one(r = {0.3, -0.9}, m = 2);
  Revolute b(phi(start = -1.5, fixed = true), w(start = 2, fixed = true));
  BodyShape two(r = {0, -0.7}, r_CM = {0.1, -0.2}, m = 3, I = 0.4);
equation
  connect(anchor.hinge, upper.hinge_a);
  connect(upper.hinge_b, lower.hinge_a);
  connect(fixed.frame_a, a.frame_a);
  connect(a.frame_b, one.frame_a);
  connect(one.frame_b, b.frame_a);
  connect(b.frame_b, two.frame_a);
""",
        stop_time=2,
    )
    assert values(result, "one.phi") == pytest.approx(values(result, "upper.phi"), abs=1e-6)
    assert values(result, "two.phi") == pytest.approx(values(result, "lower.phi"), abs=1e-6)
    assert values(result, "two.frame_b.x") == pytest.approx(values(result, "lower.hinge_b.x"))
    assert values(result, "fixed.frame_a.fy") == pytest.approx(
        values(result, "anchor.hinge.fy"), abs=1e-4
    )
    assert np.ptp(values(result, "two.phi")) > 1


def test_chain_of_rods_keeps_its_energy() -> None:
    result = run_example("double_rod_pendulum", "RodChain", stop_time=1, tolerance=1e-9)
    assert np.ptp(values(result, "energy")) < 1e-6
    assert np.min(values(result, "link[10].rc[2]")) < -0.6


BARS = reference("planar_four_bar")["positions"]


def test_four_bar_linkage_follows_its_reference() -> None:
    result = run_example("four_bar", "FourBar", points=721)
    for row in BARS:
        k = index_of(result.times, np.radians(row["crank_deg"]))
        for path, column in {
            "coupler.phi": "coupler_angle",
            "rocker.phi": "rocker_angle",
            "coupler.w": "coupler_rate",
            "rocker.w": "rocker_rate",
            "coupler.z": "coupler_acc",
            "rocker.z": "rocker_acc",
            "rocker.hinge_b.x": "Cx",
            "rocker.hinge_b.y": "Cy",
        }.items():
            assert values(result, path)[k] == pytest.approx(float(row[column]), abs=1e-9), path


def test_four_bar_linkage_in_its_other_assembly() -> None:
    # The reference of the open branch, with the triangle of coupler and rocker turned over.
    result = run_example("four_bar", "CrossedFourBar", points=721)
    for row in BARS:
        crank = np.radians(row["crank_deg"])
        k = index_of(result.times, crank)
        pin = 0.4 * np.exp(1j * crank)
        line = (1 - pin) / abs(1 - pin)
        joint = float(row["Cx"]) + 1j * float(row["Cy"])
        crossed = pin + line**2 * np.conj(joint - pin)
        found = values(result, "rocker.hinge_b.x")[k] + 1j * values(result, "rocker.hinge_b.y")[k]
        assert found == pytest.approx(crossed, abs=1e-8)


@pytest.mark.parametrize("model", ["FourBar", "CrossedFourBar"])
@pytest.mark.parametrize("crank_deg", [0, 100, 260])
def test_positions_of_both_assemblies_are_found_anywhere(model: str, crank_deg: int) -> None:
    result = run_example("four_bar", model, {"phi0": np.radians(crank_deg)}, stop_time=0.01)
    at_zero = result.times == 0
    pin = 0.4 * np.exp(1j * np.radians(crank_deg))
    joint = (
        values(result, "rocker.hinge_b.x")[at_zero]
        + 1j * (values(result, "rocker.hinge_b.y")[at_zero])
    )
    assert abs(joint - pin) == pytest.approx(0.9)
    assert abs(joint - 1) == pytest.approx(0.7)
    left_of_line = ((joint - pin) / (1 - pin)).imag > 0
    assert np.all(left_of_line == (model == "FourBar"))


def test_swinging_four_bar_linkage_keeps_its_energy() -> None:
    result = run_example("four_bar", "SwingingFourBar", tolerance=1e-10)
    assert np.ptp(values(result, "energy")) < 1e-5
    assert np.ptp(values(result, "crank.phi")) > 4


def test_slider_crank_kinematics() -> None:
    result = run(
        """
  Fixed ground;
  Revolute shaft(useFlange = true);
  FixedTranslation crank(r = {0.15, 0});
  Revolute pin;
  FixedTranslation rod(r = {0.3, 0});
  Revolute eye;
  Prismatic slide(s(start = 0.45));
  Body piston(m = 1, I = 0.1);
  mechanical.rotational.ConstantSpeed drive(w_fixed = 1, phi(start = 0, fixed = true));
equation
  connect(ground.frame_a, shaft.frame_a, slide.frame_a);
  connect(shaft.frame_b, crank.frame_a);
  connect(crank.frame_b, pin.frame_a);
  connect(pin.frame_b, rod.frame_a);
  connect(rod.frame_b, eye.frame_a);
  connect(eye.frame_b, slide.frame_b, piston.frame_a);
  connect(drive.flange, shaft.flange_a);
""",
        stop_time=2 * np.pi,
        points=721,
    )
    for row in reference("slider_crank_kinematics")["values"]:
        k = index_of(result.times, np.radians(row["crank_deg"]))
        for path, column in {"s": "x", "v": "dx_dphi", "a": "d2x_dphi2"}.items():
            assert values(result, f"slide.{path}")[k] == pytest.approx(float(row[column]), abs=1e-8)


def test_rods_between_hinges_and_between_frames_make_a_pendulum() -> None:
    result = run(
        """
  Anchor anchor(r = {1, 2});
  Rod rod(L = 0.8);
  PointMass mass(m = 2, r(start = {1.8, 2}), v(start = {0, 0}));
  Fixed fixed(r = {1, 2});
  LengthConstraint constraint(L = 0.8);
  Body body(m = 2, I = 0.1, r(start = {1.8, 2}), phi(fixed = true), w(start = 3, fixed = true));
  Pendulum pendulum(length = 0.8, mass = 2, phi(start = 1.5707963267948966, fixed = true),
    w(fixed = true));
initial equation
  mass.r[2] = 2;
  mass.v[2] = 0;
  body.r[2] = 2;
  body.v[2] = 0;
equation
  connect(anchor.hinge, rod.hinge_a, pendulum.pivot);
  connect(rod.hinge_b, mass.hinge);
  connect(fixed.frame_a, constraint.frame_a);
  connect(constraint.frame_b, body.frame_a);
""",
        stop_time=3,
    )
    phi, w = values(result, "pendulum.phi"), values(result, "pendulum.w")
    expected = np.array([1 + 0.8 * np.sin(phi), 2 - 0.8 * np.cos(phi)])
    assert vector(result, "mass.r") == pytest.approx(expected, abs=2e-6)
    assert vector(result, "body.r") == pytest.approx(expected, abs=2e-6)
    assert values(result, "body.phi") == pytest.approx(3 * result.times)
    tension = 2 * (0.8 * w**2 + G * np.cos(phi))
    assert values(result, "rod.f") == pytest.approx(tension, abs=1e-3)
    assert values(result, "constraint.f") == pytest.approx(tension, abs=1e-3)


def test_excited_pivot_holds_a_pendulum_upright() -> None:
    # Kapitza: a pivot that shakes fast enough makes the upper position stable.
    amplitude, frequency, length = 0.02, 60.0, 0.25
    result = run(
        f"""
  Fixed ground(phi = 90[deg]);
  Prismatic shaker(useFlange = true);
  Revolute joint(phi(start = 1.77, fixed = true), w(fixed = true));
  FixedTranslation rod(r = {{0, -{length}}});
  FrameHinge eye;
  PointMass mass(m = 0.1);
  mechanical.translational.Position drive(exact = true);
  blocks.Sine sine(amplitude = {amplitude}, f = {frequency});
equation
  connect(ground.frame_a, shaker.frame_a);
  connect(shaker.frame_b, joint.frame_a);
  connect(joint.frame_b, rod.frame_a);
  connect(rod.frame_b, eye.frame_a);
  connect(eye.hinge, mass.hinge);
  connect(sine.y, drive.s_ref);
  connect(drive.flange, shaker.flange_a);
""",
        stop_time=3,
        tolerance=1e-8,
        points=3001,
    )
    # joint.phi is measured from the frame, which is turned by 90 degrees: pi/2 is upright.
    omega = 2 * np.pi * frequency
    expected = solution(
        lambda t, y: [
            y[1],
            -(G - amplitude * omega**2 * np.sin(omega * t)) / length * np.sin(y[0]),
        ],
        [1.77 + np.pi / 2, 0.0],
        result.times,
    )[0]
    angle = values(result, "joint.phi") + np.pi / 2
    assert angle == pytest.approx(expected, abs=1e-4)
    assert np.max(np.abs(angle - np.pi)) < 0.5
    assert np.min(angle) < np.pi - 0.3


def test_kinematic_loop_with_springs_keeps_its_energy() -> None:
    result = run(
        """
  Fixed left;
  Fixed right(r = {1.2, 0});
  Revolute a(useFlange = true, phi(start = 1.2, fixed = true), w(fixed = true));
  BodyShape crank(r = {0.5, 0}, m = 1);
  Revolute b(phi(start = -1));
  BodyShape coupler(r = {1, 0}, m = 2);
  Revolute c(phi(start = -1.5));
  BodyShape rocker(r = {0.8, 0}, m = 1.5);
  Revolute d(phi(start = 1));
  LineSpring diagonal(c = 60, s_unstretched = 0.7);
  Spring middle(c_x = 30, c_y = 20, c_phi = 4, s_relx0 = 0.5, s_rely0 = 0.5, phi_rel0 = 0.3);
  mechanical.rotational.SpringDamper torsion(c = 5, d = 0);
  mechanical.rotational.Fixed wall;
equation
  connect(left.frame_a, a.frame_a, diagonal.frame_a, middle.frame_a);
  connect(a.frame_b, crank.frame_a);
  connect(crank.frame_b, b.frame_a);
  connect(b.frame_b, coupler.frame_a);
  connect(coupler.frame_b, c.frame_a, diagonal.frame_b, middle.frame_b);
  connect(c.frame_b, rocker.frame_a);
  connect(rocker.frame_b, d.frame_a);
  connect(d.frame_b, right.frame_a);
  connect(wall.flange, torsion.flange_a);
  connect(torsion.flange_b, a.flange_a);
""",
        stop_time=4,
    )
    energy = sum(
        body_energy(result, f"{name}.body", m, m * length**2 / 12)
        for name, m, length in [("crank", 1, 0.5), ("coupler", 2, 1), ("rocker", 1.5, 0.8)]
    )
    energy = energy + 60 * (values(result, "diagonal.length") - 0.7) ** 2 / 2
    energy = energy + 30 * (values(result, "middle.s_relx") - 0.5) ** 2 / 2
    energy = energy + 20 * (values(result, "middle.s_rely") - 0.5) ** 2 / 2
    energy = energy + 4 * (values(result, "middle.phi_rel") - 0.3) ** 2 / 2
    energy = energy + 5 * values(result, "a.phi") ** 2 / 2
    assert np.ptp(energy) < 1e-5
    assert np.ptp(values(result, "a.phi")) > 0.5
