"""Bodies and joints in the plane: constraints, energy, and known motions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from acausal import compile_text

HEAD = """
  import mechanical.planar.*;
  inner PlanarWorld world;
"""


def run(text: str, stop_time: float = 1.0, **options: Any) -> Any:
    options = {"tolerance": 1e-9, **options}
    compiled = compile_text(f"model Test\n{HEAD}{text}\nend Test;\n")
    return compiled.simulate(stop_time=stop_time, **options)


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def test_physical_pendulum() -> None:
    result = run(
        """
  Fixed anchor;
  Revolute joint(phi(start = 0.5, fixed = true), w(start = 0, fixed = true));
  FixedTranslation rod(r = {0, -0.8});
  Body body(m = 2[kg], I = 0.3[kg.m2]);
equation
  connect(anchor.frame_a, joint.frame_a);
  connect(joint.frame_b, rod.frame_a);
  connect(rod.frame_b, body.frame_a);
""",
        stop_time=5,
    )
    inertia, weight = 0.3 + 2 * 0.8**2, 2 * 9.81 * 0.8
    expected = solve_ivp(
        lambda t, y: [y[1], -weight / inertia * np.sin(y[0])],
        (0, 5),
        [0.5, 0],
        "DOP853",
        result.times,
        rtol=1e-11,
        atol=1e-12,
    ).y[0]
    assert values(result, "joint.phi") == pytest.approx(expected, abs=1e-6)
    # the joint carries the weight at rest and the centripetal force in motion
    force = -values(result, "anchor.frame_a.fy")
    assert force == pytest.approx(2 * (values(result, "body.a[2]") + 9.81), abs=1e-5)


def test_block_slides_down_a_slope() -> None:
    result = run(
        """
  Fixed ground(phi = -30[deg]);
  Prismatic slide(r = {2, 0}, s(start = 0, fixed = true), v(start = 0, fixed = true));
  Body block_(m = 3[kg], I = 0.1[kg.m2]);
equation
  connect(ground.frame_a, slide.frame_a);
  connect(slide.frame_b, block_.frame_a);
"""
    )
    assert values(result, "slide.s") == pytest.approx(9.81 / 4 * result.times**2, abs=1e-7)
    assert values(result, "slide.a") == pytest.approx(9.81 / 2, abs=1e-6)


def test_driven_joints_take_their_power_from_the_flange() -> None:
    result = run(
        """
  Fixed anchor;
  Revolute joint(useFlange = true, phi(start = 0, fixed = true), w(start = 0, fixed = true));
  FixedTranslation arm(r = {1, 0});
  Body body(m = 2[kg], I = 0.5[kg.m2]);
  mechanical.rotational.ConstantTorque motor(tau_constant = 30[N.m]);
equation
  connect(anchor.frame_a, joint.frame_a);
  connect(joint.frame_b, arm.frame_a);
  connect(arm.frame_b, body.frame_a);
  connect(motor.flange, joint.flange_a);
"""
    )
    phi, w = values(result, "joint.phi"), values(result, "joint.w")
    kinetic = (0.5 + 2) * w**2 / 2
    potential = 2 * 9.81 * np.sin(phi)
    assert kinetic + potential == pytest.approx(30 * phi, abs=1e-5)
    assert phi[-1] > 1


def test_pushed_slide_takes_its_power_from_the_flange() -> None:
    result = run(
        """
  Fixed ground(phi = 90[deg]);
  Prismatic lift(useFlange = true, s(start = 0, fixed = true), v(start = 0, fixed = true));
  Body cabin(m = 3[kg], I = 0.1[kg.m2]);
  mechanical.translational.ConstantForce rope(f_constant = 45[N]);
equation
  connect(ground.frame_a, lift.frame_a);
  connect(lift.frame_b, cabin.frame_a);
  connect(rope.flange, lift.flange_a);
"""
    )
    assert values(result, "lift.a") == pytest.approx(45 / 3 - 9.81, abs=1e-6)
    assert values(result, "cabin.r[2]") == pytest.approx(
        (15 - 9.81) / 2 * result.times**2, abs=1e-7
    )


def test_free_body_flies_in_a_parabola_and_keeps_turning() -> None:
    result = run(
        """
  Body body(m = 1[kg], I = 0.2[kg.m2], r(start = {0, 1}, each fixed = true),
    v(start = {2, 3}, each fixed = true), phi(fixed = true), w(start = 4, fixed = true));
"""
    )
    t = result.times
    assert values(result, "body.r[1]") == pytest.approx(2 * t, abs=1e-7)
    assert values(result, "body.r[2]") == pytest.approx(1 + 3 * t - 9.81 / 2 * t**2, abs=1e-7)
    assert values(result, "body.phi") == pytest.approx(4 * t, abs=1e-7)


def test_point_mass_on_a_planar_spring() -> None:
    result = run(
        """
  Fixed anchor;
  Spring spring(c_x = 20[N/m], c_y = 80[N/m], c_phi = 1[N.m/rad]);
  FixedRotation turn(alpha = 0.3[rad]);
  FrameHinge eye;
  PointMass mass(m = 2[kg], r(start = {0.1, 0}, each fixed = true), v(each fixed = true));
  Body hub(m = 1e-3[kg], I = 1[kg.m2], phi(fixed = true), w(fixed = true));
equation
  connect(anchor.frame_a, spring.frame_a);
  connect(spring.frame_b, hub.frame_a, turn.frame_a);
  connect(turn.frame_b, eye.frame_a);
  connect(eye.hinge, mass.hinge);
""",
        stop_time=3,
    )
    m = 2 + 1e-3
    t = result.times
    assert values(result, "mass.r[1]") == pytest.approx(0.1 * np.cos(np.sqrt(20 / m) * t), abs=1e-6)
    sag = m * 9.81 / 80
    assert values(result, "mass.r[2]") == pytest.approx(
        -sag * (1 - np.cos(np.sqrt(80 / m) * t)), abs=1e-6
    )


def test_four_bar_linkage_closes() -> None:
    # Three rods and the ground: one degree of freedom, three constraints too many for a tree.
    result = run(
        """
  Fixed left;
  Fixed right(r = {2, 0});
  Revolute a(phi(start = 1.2, fixed = true), w(start = 0, fixed = true));
  FixedTranslation crank(r = {1, 0});
  Revolute b(phi(start = -1.2));
  FixedTranslation coupler(r = {2, 0});
  Revolute c(phi(start = 1.2));
  FixedTranslation rocker(r = {-1, 0});
  Revolute d(phi(start = 1));
  Body load(m = 1[kg], I = 0.05[kg.m2]);
equation
  connect(left.frame_a, a.frame_a);
  connect(a.frame_b, crank.frame_a);
  connect(crank.frame_b, b.frame_a);
  connect(b.frame_b, coupler.frame_a);
  connect(coupler.frame_b, c.frame_a, load.frame_a);
  connect(c.frame_b, rocker.frame_a);
  connect(rocker.frame_b, d.frame_a);
  connect(d.frame_b, right.frame_a);
""",
        stop_time=2,
    )
    # a parallelogram: the coupler stays level, the load is the mass of a pendulum of length 1
    assert values(result, "load.phi") == pytest.approx(0, abs=1e-6)
    energy = values(result, "a.w") ** 2 / 2 + 9.81 * np.sin(values(result, "a.phi"))
    assert energy == pytest.approx(9.81 * np.sin(1.2), abs=1e-4)
    assert np.ptp(values(result, "a.phi")) > 1
