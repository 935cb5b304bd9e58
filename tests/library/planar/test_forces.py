"""Springs, dampers and sources: closed forms, SciPy, energy."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.planar.mechanisms import (
    G,
    body,
    body_energy,
    run,
    solution,
    values,
    vector,
)


def damped(
    mass: float, stiffness: float, damping: float, x0: float, v0: float, t: np.ndarray
) -> np.ndarray:
    """Return the closed form of ``m x'' + d x' + c x = 0``, less than critically damped."""
    delta = damping / (2 * mass)
    omega = np.sqrt(stiffness / mass - delta**2)
    moved: np.ndarray = np.exp(-delta * t) * (
        x0 * np.cos(omega * t) + (v0 + delta * x0) / omega * np.sin(omega * t)
    )
    return moved


def test_spring_and_spring_damper_act_in_three_directions() -> None:
    result = run(
        """
  Fixed fixed(r = {1, 2}, phi = 0.3);
  SpringDamper springDamper(c_x = 20, d_x = 1, s_relx0 = 0.5, c_y = 30, d_y = 2, c_phi = 4,
    d_phi = 0.1, phi_rel0 = 0.2, useHeatPort = true);
  thermal.FixedTemperature ambient(T = 300);
  Body body(m = 2, I = 0.5, r(start = {1.8, 2.1}, each fixed = true),
    v(start = {0.2, -0.3}, each fixed = true), phi(start = 0.1, fixed = true),
    w(start = 1, fixed = true));
  Spring spring(c_x = 20, c_y = 30, s_rely0 = -0.4, c_phi = 4);
  Body free(m = 2, I = 0.5, enableGravity = false, r(start = {1.3, 2.1}, each fixed = true),
    v(each fixed = true), phi(start = 0.5, fixed = true), w(fixed = true));
equation
  connect(fixed.frame_a, springDamper.frame_a, spring.frame_a);
  connect(springDamper.frame_b, body.frame_a);
  connect(spring.frame_b, free.frame_a);
  connect(springDamper.heatPort, ambient.port);
""",
        stop_time=3,
    )
    t = result.times
    x = damped(2, 20, 1, 0.3, 0.2, t)
    assert values(result, "body.r[1]") == pytest.approx(1.5 + x, abs=1e-7)
    sag = 2 * G / 30
    y = damped(2, 30, 2, 0.1 + sag, -0.3, t)
    assert values(result, "body.r[2]") == pytest.approx(2 - sag + y, abs=1e-7)
    turn = damped(0.5, 4, 0.1, 0.1 - 0.5, 1, t)
    assert values(result, "body.phi") == pytest.approx(0.5 + turn, abs=1e-7)
    loss = (
        1 * values(result, "body.v[1]") ** 2
        + 2 * values(result, "body.v[2]") ** 2
        + 0.1 * values(result, "body.w") ** 2
    )
    assert values(result, "springDamper.lossPower") == pytest.approx(loss)
    assert values(result, "ambient.port.Q_flow") == pytest.approx(loss)
    assert values(result, "free.r[1]") == pytest.approx(1 + damped(2, 20, 0, 0.3, 0, t), abs=1e-7)
    assert values(result, "free.r[2]") == pytest.approx(1.6 + damped(2, 30, 0, 0.5, 0, t), abs=1e-7)
    assert values(result, "free.phi") == pytest.approx(0.3 + damped(0.5, 4, 0, 0.2, 0, t), abs=1e-7)


LINES = {
    "LineSpringDamper": "LineSpringDamper line(c = 50, d = 3, s_unstretched = 0.6);",
    "LineSpring and Damper": """LineSpring spring(c = 50, s_unstretched = 0.6);
  Damper line(d = 3);""",
    "LineForce": """LineForce line;
  mechanical.translational.SpringDamper inside(c = 50, d = 3, s_rel0 = 0.6);""",
}
CONNECTED = {
    "LineSpringDamper": "",
    "LineSpring and Damper": """
  connect(fixed.frame_a, spring.frame_a);
  connect(spring.frame_b, body.frame_a);""",
    "LineForce": """
  connect(line.flange_a, inside.flange_a);
  connect(line.flange_b, inside.flange_b);""",
}


@pytest.mark.parametrize("name", LINES)
def test_forces_along_a_line(name: str) -> None:
    result = run(
        f"""
  Fixed fixed(r = {{0.1, 0.2}});
  {LINES[name]}
  Body body(m = 2, I = 0.5, r(start = {{0.8, 0.2}}, each fixed = true),
    v(start = {{0, 1.5}}, each fixed = true), phi(fixed = true), w(start = 1, fixed = true));
equation
  connect(fixed.frame_a, line.frame_a);
  connect(line.frame_b, body.frame_a);{CONNECTED[name]}
""",
        stop_time=2,
    )

    def motion(t: float, y: np.ndarray) -> list[float]:
        r, v = y[:2] - np.array([0.1, 0.2]), y[2:]
        length = np.hypot(*r)
        e = r / length
        force = -(50 * (length - 0.6) + 3 * (v @ e)) * e
        return [*v, force[0] / 2, force[1] / 2 - G]

    expected = solution(motion, [0.8, 0.2, 0, 1.5], result.times)
    assert vector(result, "body.r") == pytest.approx(expected[:2], abs=1e-6)
    assert values(result, "body.phi") == pytest.approx(result.times)


def test_line_spring_goes_through_its_anchor() -> None:
    # There the line has no direction, but without an unstretched length the force is c*r anyway.
    result = run(
        body("body", 2, 0.1, r=(1, 0))
        + """
  Fixed fixed;
  LineSpring spring(c = 8);
equation
  connect(fixed.frame_a, spring.frame_a);
  connect(spring.frame_b, body.frame_a);
""",
        stop_time=5,
        gravity="{0, 0}",
    )
    assert values(result, "body.r[1]") == pytest.approx(np.cos(2 * result.times), abs=1e-6)


def test_sources_in_chosen_directions() -> None:
    result = run(
        body("world_", 2, 0.5)
        + body("own", 2, 0.5, w=2)
        + body("other", 2, 0.5)
        + """
  Fixed tilted(phi = 30[deg]);
  WorldForce a(force = {3, 1, 0.2});
  WorldForce b(resolveInFrame = ResolveInFrameB.frame_b, force = {3, 0, 0});
  WorldForce c(resolveInFrame = ResolveInFrameB.frame_resolve, force = {4, 0, 0});
equation
  connect(a.frame_b, world_.frame_a);
  connect(b.frame_b, own.frame_a);
  connect(c.frame_b, other.frame_a);
  connect(c.frame_resolve, tilted.frame_a);
""",
        gravity="{0, 0}",
    )
    t = result.times
    assert vector(result, "world_.r") == pytest.approx(np.outer([0.75, 0.25], t**2), abs=1e-8)
    assert values(result, "world_.phi") == pytest.approx(0.2 * t**2, abs=1e-8)
    # a force that turns with 2 rad/s: v = F/(m w)*(sin w t, 1 - cos w t)
    expected = 3 / (2 * 2) * np.array([np.sin(2 * t), 1 - np.cos(2 * t)])
    assert vector(result, "own.v") == pytest.approx(expected, abs=1e-8)
    direction = [np.cos(np.pi / 6), np.sin(np.pi / 6)]
    assert vector(result, "other.r") == pytest.approx(np.outer(direction, t**2), abs=1e-8)


@pytest.mark.parametrize("resolve", ["world", "frame_a", "frame_b", "frame_resolve"])
def test_relative_force_moves_no_centre_of_mass_and_keeps_the_angular_momentum(
    resolve: str,
) -> None:
    result = run(
        f"""
  Body one(m = 2, I = 0.5, r(start = {{0, 0}}, each fixed = true), v(each fixed = true),
    phi(fixed = true), w(start = 1, fixed = true));
  Body two(m = 1, I = 0.2, r(start = {{1, 0.5}}, each fixed = true), v(each fixed = true),
    phi(fixed = true), w(start = -2, fixed = true));
  RelativeForce force(resolveInFrame = ResolveInFrameAB.{resolve}, force = {{1, 2, 0.3}});
  Fixed tilted(phi = 1);
equation
  connect(force.frame_a, one.frame_a);
  connect(force.frame_b, two.frame_a);
  {"connect(tilted.frame_a, force.frame_resolve);" if resolve == "frame_resolve" else ""}
""",
        gravity="{0, 0}",
    )
    r1, r2 = vector(result, "one.r"), vector(result, "two.r")
    v1, v2 = vector(result, "one.v"), vector(result, "two.v")
    assert 2 * v1 + v2 == pytest.approx(0, abs=1e-7)
    spin = 0.5 * values(result, "one.w") + 0.2 * values(result, "two.w")
    orbit = 2 * (r1[0] * v1[1] - r1[1] * v1[0]) + r2[0] * v2[1] - r2[1] * v2[0]
    assert spin + orbit == pytest.approx(0.5 - 0.4, abs=1e-7)
    angle = {"world": 0.0, "frame_a": 0.0, "frame_b": 0.0, "frame_resolve": 1.0}[resolve]
    push = np.array([np.cos(angle) - 2 * np.sin(angle), np.sin(angle) + 2 * np.cos(angle)])
    assert vector(result, "two.a")[:, 0] == pytest.approx(push)
    last = {"frame_a": values(result, "one.phi")[-1], "frame_b": values(result, "two.phi")[-1]}
    angle = last.get(resolve, angle)
    push = np.array([np.cos(angle) - 2 * np.sin(angle), np.sin(angle) + 2 * np.cos(angle)])
    assert vector(result, "two.a")[:, -1] == pytest.approx(push, abs=1e-6)
    assert values(result, "two.z")[-1] == pytest.approx(0.3 / 0.2, abs=1e-6)


@pytest.mark.parametrize("resolve", ["world", "frame_b", "frame_resolve"])
def test_quadratic_drag(resolve: str) -> None:
    result = run(
        f"""
  Body body(m = 2, I = 0.5, r(each fixed = true), v(start = {{3, 0}}, each fixed = true),
    phi(fixed = true), w(start = {0 if resolve == "frame_b" else 4}, fixed = true));
  QuadraticSpeedDependentForce drag(resolveInFrame = ResolveInFrameB.{resolve},
    F_nominal = -10, v_nominal = 2, tau_nominal = -1.5, w_nominal = 3);
  Fixed level;
equation
  connect(drag.frame_b, body.frame_a);
  {"connect(level.frame_a, drag.frame_resolve);" if resolve == "frame_resolve" else ""}
""",
        gravity="{0, 0}",
    )
    t = result.times
    k, q = 10 / 4 / 2, 1.5 / 9 / 0.5
    assert values(result, "body.v[1]") == pytest.approx(3 / (1 + 3 * k * t), abs=1e-7)
    assert values(result, "body.v[2]") == pytest.approx(0, abs=1e-12)
    w0 = 0 if resolve == "frame_b" else 4
    assert values(result, "body.w") == pytest.approx(w0 / (1 + w0 * q * t), abs=1e-7)


def test_free_bodies_keep_their_energy() -> None:
    result = run(
        """
  Body body(m = 1.5, I = 0.2, r(start = {0, 1}, each fixed = true),
    v(start = {2, 3}, each fixed = true), phi(fixed = true), w(start = 4, fixed = true));
  BodyShape shape(r = {1, 0.5}, r_CM = {0.3, 0.1}, m = 1.5, I = 0.2,
    body(r(start = {0, 1}, each fixed = true), v(start = {2, 3}, each fixed = true)),
    phi(start = 0.4, fixed = true), w(start = 4, fixed = true));
"""
    )
    t = result.times
    for name in ("body", "shape.body"):
        energy = body_energy(result, name, 1.5, 0.2)
        assert energy == pytest.approx(energy[0])
        assert values(result, f"{name}.r[2]") == pytest.approx(1 + 3 * t - G / 2 * t**2, abs=1e-7)
    tip = vector(result, "shape.body.r") + np.array(
        [
            0.7 * np.cos(0.4 + 4 * t) - 0.4 * np.sin(0.4 + 4 * t),
            0.7 * np.sin(0.4 + 4 * t) + 0.4 * np.cos(0.4 + 4 * t),
        ]
    )
    assert values(result, "shape.frame_b.x") == pytest.approx(tip[0], abs=1e-6)
    assert values(result, "shape.frame_b.y") == pytest.approx(tip[1], abs=1e-6)
