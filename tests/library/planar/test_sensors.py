"""Sensors on motions that are known."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.planar.mechanisms import G, body, run, values, vector

#: A disc that turns with 2 rad/s about the origin; a body that flies in a parabola and turns.
MOTIONS = (
    """
  Fixed ground;
  Revolute joint(useFlange = true);
  mechanical.rotational.ConstantSpeed drive(w_fixed = 2, phi(start = 0.3, fixed = true));
  FixedTranslation arm(r = {0.5, 0});
"""
    + body("ball", 2, 0.1, r=(1, 2), v=(1, 3), phi=0.2, w=1.5)
    + """
  Fixed tilted(phi = 0.7);
"""
)
CONNECTED = """
equation
  connect(ground.frame_a, joint.frame_a);
  connect(drive.flange, joint.flange_a);
  connect(joint.frame_b, arm.frame_a);
"""


def turned(angle: np.ndarray | float, v: np.ndarray) -> np.ndarray:
    """Return a vector in the directions of a frame."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * v[0] + s * v[1], c * v[1] - s * v[0]])


@pytest.mark.parametrize("resolve", ["world", "frame_a", "frame_resolve"])
def test_absolute_sensors(resolve: str) -> None:
    sensors = ("AbsolutePosition r", "AbsoluteVelocity v", "AbsoluteAcceleration a")
    lines = "".join(f"  {s}(resolveInFrame = ResolveInFrameA.{resolve});\n" for s in sensors)
    lines += f"  TransformAbsoluteVector t(resolveInFrame = ResolveInFrameA.{resolve}, r_in = v.v,"
    lines += f" frame_r_in = ResolveInFrameA.{'world' if resolve == 'world' else 'frame_a'});\n"
    ends = "  connect(arm.frame_b, r.frame_a, v.frame_a, a.frame_a, t.frame_a);\n"
    if resolve == "frame_resolve":
        ends += "  connect(tilted.frame_a, " + ", ".join(f"{s}.frame_resolve" for s in "rvat")
        ends += ");\n"
    result = run(MOTIONS + lines + CONNECTED + ends)
    phi = 0.3 + 2 * result.times
    angle = {"world": 0 * phi, "frame_a": phi, "frame_resolve": 0.7 + 0 * phi}[resolve]
    out = np.array([np.cos(phi), np.sin(phi)])
    across = np.array([-np.sin(phi), np.cos(phi)])
    assert vector(result, "r.r") == pytest.approx(turned(angle, 0.5 * out), abs=1e-8)
    assert vector(result, "v.v") == pytest.approx(turned(angle, across), abs=1e-8)
    assert vector(result, "a.a") == pytest.approx(turned(angle, -2 * out), abs=1e-8)
    assert values(result, "r.r[3]") == pytest.approx(phi)
    assert values(result, "v.v[3]") == pytest.approx(2)
    assert values(result, "a.a[3]") == pytest.approx(0, abs=1e-9)
    # what comes in is read as a vector in the directions of the arm, but in "world" as it is
    from_arm = 0 if resolve == "world" else phi
    expected = turned(angle - from_arm, turned(angle, across))
    assert vector(result, "t.r_out") == pytest.approx(expected, abs=1e-8)
    assert values(result, "t.r_out[3]") == pytest.approx(2)


@pytest.mark.parametrize("resolve", ["world", "frame_a", "frame_b", "frame_resolve"])
def test_relative_sensors(resolve: str) -> None:
    sensors = ("RelativePosition r", "RelativeVelocity v", "RelativeAcceleration a")
    lines = "".join(f"  {s}(resolveInFrame = ResolveInFrameAB.{resolve});\n" for s in sensors)
    lines += f"""
  TransformRelativeVector t(resolveInFrame = ResolveInFrameAB.{resolve}, r_in = {{1, 2, 3}});
  TransformRelativeVector u(resolveInFrame = ResolveInFrameAB.{resolve}, r_in = {{1, 2, 3}},
    frame_r_in = ResolveInFrameAB.frame_a);
  Distance distance;
"""
    names = "rvatu"
    ends = "  connect(arm.frame_b, " + ", ".join(f"{s}.frame_a" for s in names)
    ends += ", distance.frame_a);\n  connect(ball.frame_a, "
    ends += ", ".join(f"{s}.frame_b" for s in names) + ", distance.frame_b);\n"
    if resolve == "frame_resolve":
        ends += "  connect(tilted.frame_a, " + ", ".join(f"{s}.frame_resolve" for s in names)
        ends += ");\n"
    result = run(MOTIONS + lines + CONNECTED + ends)
    t = result.times
    phi, own = 0.3 + 2 * t, 0.2 + 1.5 * t
    choice = {"world": 0 * t, "frame_a": phi, "frame_b": own, "frame_resolve": 0.7 + 0 * t}
    angle = choice[resolve]
    # complex numbers: what an observer on the arm sees is z*exp(-i*phi)
    arm = 0.5 * np.exp(1j * phi)
    ball = 1 + t + 1j * (2 + 3 * t - G / 2 * t**2)
    rate = 1 + 1j * (3 - G * t)
    z, dz, ddz = ball - arm, rate - 2j * arm, -1j * G + 4 * arm
    seen = [z, dz - 2j * z, ddz - 4j * dz - 4 * z]  # in world directions
    for name, path, expected in zip("rva", ("r_rel", "v_rel", "a_rel"), seen, strict=True):
        resolved = expected * np.exp(-1j * angle)
        found = vector(result, f"{name}.{path}")
        assert found == pytest.approx(np.array([resolved.real, resolved.imag]), abs=1e-6), name
    assert values(result, "r.r_rel[3]") == pytest.approx(own - phi, abs=1e-8)
    assert values(result, "v.v_rel[3]") == pytest.approx(-0.5, abs=1e-8)
    assert values(result, "a.a_rel[3]") == pytest.approx(0, abs=1e-8)
    assert values(result, "distance.distance") == pytest.approx(abs(z), abs=1e-7)
    for name, given in (("t", own), ("u", phi)):
        expected = (1 + 2j) * np.exp(1j * (given - angle))
        found = vector(result, f"{name}.r_out")
        assert found == pytest.approx(np.array([expected.real, expected.imag]), abs=1e-7)


@pytest.mark.parametrize("resolve", ["world", "frame_a", "frame_resolve"])
@pytest.mark.parametrize("positive", ["true", "false"])
def test_cut_sensors_in_a_pendulum(resolve: str, positive: str) -> None:
    options = f"(resolveInFrame = ResolveInFrameA.{resolve}, positiveSign = {positive})"
    resolved = "connect(tilted.frame_a, {});".format(
        ", ".join(f"{s}.frame_resolve" for s in ("force", "torque", "both", "power"))
    )
    result = run(
        f"""
  Fixed ground;
  Fixed tilted(phi = 0.7);
  Revolute joint(useFlange = true, phi(start = 1, fixed = true), w(start = 0.5, fixed = true));
  mechanical.rotational.ConstantTorque motor(tau_constant = 3);
  FixedTranslation rod(r = {{0, -0.4}});
  CutForce force{options};
  CutTorque torque{options};
  CutForceAndTorque both{options};
  Power power{options};
  Body body(m = 2, I = 0.1);
equation
  connect(ground.frame_a, joint.frame_a);
  connect(joint.frame_b, rod.frame_a);
  connect(motor.flange, joint.flange_a);
  connect(rod.frame_b, force.frame_a);
  connect(force.frame_b, torque.frame_a);
  connect(torque.frame_b, both.frame_a);
  connect(both.frame_b, power.frame_a);
  connect(power.frame_b, body.frame_a);
  {resolved if resolve == "frame_resolve" else ""}
"""
    )
    sign = 1 if positive == "true" else -1
    phi, w, z = (values(result, f"joint.{name}") for name in ("phi", "w", "z"))
    angle = {"world": 0, "frame_a": phi, "frame_resolve": 0.7}[resolve]
    # what acts on the body: m*(a - g), I*z
    force = 2 * (vector(result, "body.a") + np.array([[0], [G]]))
    expected = turned(angle, sign * force)
    assert vector(result, "force.force") == pytest.approx(expected, abs=1e-5)
    assert vector(result, "both.force") == pytest.approx(expected, abs=1e-5)
    assert values(result, "torque.torque") == pytest.approx(sign * 0.1 * z, abs=1e-5)
    assert values(result, "both.torque") == pytest.approx(sign * 0.1 * z, abs=1e-5)
    power = (force * vector(result, "body.v")).sum(axis=0) + 0.1 * z * w
    assert values(result, "power.power") == pytest.approx(sign * power, abs=1e-5)
    assert np.ptp(power) > 1


def test_distance_that_vanishes() -> None:
    result = run(
        body("one", 1, 0.1, r=(-1, 0), v=(2, 0))
        + """
  Fixed fixed;
  Distance distance(s_small = 0.2);
equation
  connect(fixed.frame_a, distance.frame_a);
  connect(distance.frame_b, one.frame_a);
""",
        gravity="{0, 0}",
    )
    x = np.abs(2 * result.times - 1)
    expected = np.where(x > 0.2, x, x**2 / 0.4 * (3 - x**2 / 0.04))
    assert values(result, "distance.distance") == pytest.approx(expected, abs=1e-8)
