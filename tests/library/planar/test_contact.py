"""Points against walls: impacts, friction, sticking."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.planar.mechanisms import G, body, run, values, vector


def test_thrown_stone_bounces_slides_and_stops() -> None:
    # Impacts on a rigid floor are without friction; friction acts once the stone rests on it.
    e, mu, v0 = 0.5, 0.3, 2.0
    result = run(
        body("stone", 2, 0.1, r=(0, 0.5), v=(v0, 0))
        + f"""
  Fixed floor;
  CoulombContact2D contact(law = ContactLaw.restitution, mu = {mu}, e = {e});
equation
  connect(floor.frame_a, contact.frame_a);
  connect(contact.frame_b, stone.frame_a);
""",
        stop_time=2,
        points=2001,
    )
    t, fall = result.times, np.sqrt(1 / G)
    landing = fall * (1 + e) / (1 - e)
    x, vx = values(result, "stone.r[1]"), values(result, "stone.v[1]")
    flying = t < landing - 0.01
    assert x[flying] == pytest.approx(v0 * t[flying], abs=1e-7)
    heights = 0.5 * e ** (2 * np.arange(4))
    tops = fall * (1 + 2 * (e ** np.arange(1, 5)).cumsum()) - fall * e ** np.arange(1, 5)
    tops = np.concatenate([[0], tops[:3]])
    for top, height in zip(tops, heights, strict=True):
        k = np.argmin(np.abs(t - top))
        assert values(result, "stone.r[2]")[k] == pytest.approx(height, abs=1e-4)
    sliding = (t > landing + 0.01) & (t < landing + v0 / (mu * G) - 0.01)
    assert vx[sliding] == pytest.approx(v0 - mu * G * (t[sliding] - landing), abs=1e-2)
    assert np.gradient(vx[sliding], t[sliding]) == pytest.approx(-mu * G, rel=1e-6)
    stopped = t > landing + v0 / (mu * G) + 0.01
    assert np.any(stopped)
    assert set(values(result, "contact.friction.mode")[stopped]) == {0.0}
    assert vx[stopped] == pytest.approx(0, abs=1e-12)
    assert x[-1] == pytest.approx(v0 * landing + v0**2 / (2 * mu * G), abs=1e-2)


@pytest.mark.parametrize("law", ["restitution", "springDamper"])
@pytest.mark.parametrize("slope", [10, 30])
def test_block_on_a_slope_sticks_or_slides(law: str, slope: int) -> None:
    alpha, mu, c = np.radians(slope), 0.3, 1e4
    sag = 0 if law == "restitution" else 2 * G * np.cos(alpha) / c
    start = -sag * np.array([np.sin(alpha), np.cos(alpha)])
    result = run(
        body("block_", 2, 0.1, r=tuple(start))
        + f"""
  Fixed floor(phi = {-slope}[deg]);
  CoulombContact2D contact(law = ContactLaw.{law}, mu = {mu}, peak = 1.2, c = {c}, d = 10);
equation
  connect(floor.frame_a, contact.frame_a);
  connect(contact.frame_b, block_.frame_a);
""",
        tolerance=1e-8,
    )
    t = result.times
    a = G * (np.sin(alpha) - mu * np.cos(alpha))
    moved = values(result, "contact.friction.s")
    assert moved == pytest.approx(max(a, 0) / 2 * t**2, abs=1e-6)
    assert values(result, "contact.friction.f_normal") == pytest.approx(2 * G * np.cos(alpha))
    force = 2 * G * min(np.sin(alpha), mu * np.cos(alpha))
    assert values(result, "contact.friction.f_t")[1:] == pytest.approx(-force, abs=1e-5)


def test_block_on_a_board_that_moves() -> None:
    # A block slides on a board that rolls freely: momentum stays, friction takes the energy.
    result = run(
        body("block_", 1, 0.1, r=(0, 0.1), v=(3, 0))
        + """
  Fixed ground;
  Prismatic wheels(s(fixed = true), v(fixed = true));
  FixedTranslation top(r = {0, 0.1});
  Body board(m = 2, I = 1);
  CoulombContact2D contact(law = ContactLaw.restitution, mu = 0.4);
  Real lost(start = 0, fixed = true);
equation
  connect(ground.frame_a, wheels.frame_a);
  connect(wheels.frame_b, board.frame_a, top.frame_a);
  connect(top.frame_b, contact.frame_a);
  connect(contact.frame_b, block_.frame_a);
  der(lost) = contact.friction.lossPower;
""",
    )
    t, block, board = result.times, values(result, "block_.v[1]"), values(result, "wheels.v")
    assert block + 2 * board == pytest.approx(3, abs=1e-7)
    end = 3 / (0.4 * G * (1 + 1 / 2))
    assert block[t < end] == pytest.approx(3 - 0.4 * G * t[t < end], abs=1e-7)
    assert block[t > end] == pytest.approx(1, abs=1e-7)
    assert values(result, "lost")[-1] == pytest.approx((9 - 3) / 2, abs=1e-6)
    assert values(result, "contact.friction.vs")[-1] == 0


def test_rod_hits_the_floor_with_its_end() -> None:
    # p = (1 + e) v/(1/m + a^2/I): lever a from the centre of mass to the impulse
    angle, e = 0.6, 0.4
    result = run(
        f"""
  Fixed floor;
  BodyShape rod(r = {{1, 0}}, m = 2, phi(start = {angle}, fixed = true), w(fixed = true),
    body(r(start = {{0, 1}}, each fixed = true), v(start = {{0.7, 0}}, each fixed = true)));
  RigidWall wall(e = {e});
equation
  connect(floor.frame_a, wall.frame_a);
  connect(wall.frame_b, rod.frame_a);
""",
        stop_time=0.5,
    )
    m, inertia, lever = 2, 2 / 12, 0.5 * np.cos(angle)
    fall = np.sqrt(2 * (1 - 0.5 * np.sin(angle)) / G)
    before, after = result.times < fall, result.times > fall + 1e-6
    impulse = (1 + e) * G * fall / (1 / m + lever**2 / inertia)
    assert values(result, "rod.w")[before] == pytest.approx(0, abs=1e-9)
    first = np.argmax(after)
    turn = -impulse * lever / inertia
    assert values(result, "rod.w")[first] == pytest.approx(turn, rel=1e-6)
    flight = result.times[first] - fall
    rise = -G * fall + impulse / m - G * flight
    assert values(result, "rod.body.v[2]")[first] == pytest.approx(rise, rel=1e-6)
    assert values(result, "rod.body.v[1]") == pytest.approx(0.7, abs=1e-9)


@pytest.mark.parametrize(
    ("law", "e"), [("restitution", 0.0), ("restitution", 0.3), ("springDamper", 0.0)]
)
def test_rod_falls_slides_and_comes_to_rest(law: str, e: float) -> None:
    result = run(
        f"""
  Fixed floor;
  BodyShape rod(r = {{1, 0}}, m = 1, phi(start = 0.6, fixed = true), w(fixed = true),
    body(r(start = {{0, 1}}, each fixed = true), v(start = {{2, 0}}, each fixed = true)));
  CoulombContact2D left(law = ContactLaw.{law}, mu = 0.3, e = {e}, c = 1e5, d = 200);
  CoulombContact2D right(law = ContactLaw.{law}, mu = 0.3, e = {e}, c = 1e5, d = 200, creep = 1e-9);
equation
  connect(floor.frame_a, left.frame_a, right.frame_a);
  connect(left.frame_b, rod.frame_a);
  connect(right.frame_b, rod.frame_b);
""",
        stop_time=3,
        tolerance=1e-7,
    )
    energy = (
        (vector(result, "rod.body.v") ** 2).sum(axis=0) / 2
        + values(result, "rod.w") ** 2 / 24
        + G * values(result, "rod.body.r[2]")
    )
    if law == "springDamper":
        for side in ("left", "right"):
            energy = energy + 1e5 / 2 * np.minimum(values(result, f"{side}.elastic.h"), 0) ** 2
    assert np.max(np.diff(energy)) < 2e-4 * energy[0]
    assert values(result, "rod.phi")[-1] == pytest.approx(0, abs=1e-6)
    assert values(result, "rod.body.r[2]")[-1] == pytest.approx(0, abs=1e-4)
    assert values(result, "rod.body.v[1]")[-1] == pytest.approx(0, abs=1e-9)
    assert {values(result, f"{side}.friction.mode")[-1] for side in ("left", "right")} == {0.0}
    assert values(result, "rod.body.r[1]")[-1] > 0.3


def test_elastic_wall_throws_a_ball_back() -> None:
    # half an oscillation of mass and spring; a wall that is turned and moved
    m, c, speed = 0.5, 2000.0, 3.0
    normal = np.array([-np.sin(0.5), np.cos(0.5)])
    place = np.array([1, 2]) + 0.3 * normal
    result = run(
        body("ball", m, 0.1, r=tuple(place), v=tuple(-speed * normal))
        + f"""
  Fixed wall(r = {{1, 2}}, phi = 0.5);
  ElasticWall contact(c = {c}, d = 0);
equation
  connect(wall.frame_a, contact.frame_a);
  connect(contact.frame_b, ball.frame_a);
""",
        stop_time=0.3,
        gravity="{0, 0}",
    )
    t, omega = result.times, np.sqrt(c / m)
    touch = 0.3 / speed
    h = np.where(
        t < touch,
        0.3 - speed * t,
        np.where(
            t < touch + np.pi / omega,
            -speed / omega * np.sin(omega * (t - touch)),
            speed * (t - touch - np.pi / omega),
        ),
    )
    assert values(result, "contact.h") == pytest.approx(h, abs=1e-6)
    assert values(result, "contact.fn") == pytest.approx(-c * np.minimum(h, 0), abs=1e-2)
    assert values(result, "contact.s") == pytest.approx(0, abs=1e-9)


def test_rest_ends_when_the_body_is_lifted() -> None:
    result = run(
        body("load", 2, 0.1)
        + """
  Fixed floor;
  CoulombContact2D contact(law = ContactLaw.restitution, mu = 0.5);
  WorldForce crane;
equation
  connect(floor.frame_a, contact.frame_a);
  connect(contact.frame_b, load.frame_a);
  connect(crane.frame_b, load.frame_a);
  crane.force = {4, 19.62*time, 0};
""",
        stop_time=1.5,
        tolerance=1e-8,
    )
    t = result.times
    # until the normal force has shrunk to 4/mu = 8 N the load sticks; at 1 s it leaves the floor
    slip, leave = 1 - 8 / 19.62, 1.0
    x, y = vector(result, "load.r")
    assert x[t <= slip] == pytest.approx(0, abs=1e-9)
    sliding = (t > slip) & (t < leave)
    rate = 19.62 * 0.5 / 2  # growth of the acceleration: mu*weight per second / m
    assert x[sliding] == pytest.approx(rate / 6 * (t[sliding] - slip) ** 3, abs=1e-6)
    assert y[t <= leave] == pytest.approx(0, abs=1e-9)
    assert y[t > leave] == pytest.approx(G / 6 * (t[t > leave] - 1) ** 3, abs=1e-6)
    assert values(result, "contact.rigid.fn")[-1] == 0


def test_friction_under_a_given_normal_force() -> None:
    # A belt that is pressed on a block takes it along until both have the same velocity.
    result = run(
        body("block_", 2, 0.1)
        + """
  Fixed ground;
  Prismatic rollers(useFlange = true);
  mechanical.translational.ConstantSpeed drive(v_fixed = 1.5, s(start = 0, fixed = true));
  WallFriction belt(mu = 0.4, useHeatPort = true);
  blocks.Step pressed(height = 10, startTime = 0.2);
  thermal.FixedTemperature ambient(T = 300);
equation
  connect(ground.frame_a, rollers.frame_a);
  connect(drive.flange, rollers.flange_a);
  connect(rollers.frame_b, belt.frame_a);
  connect(belt.frame_b, block_.frame_a);
  connect(pressed.y, belt.f_normal);
  connect(belt.heatPort, ambient.port);
""",
        gravity="{0, 0}",
    )
    t = result.times
    assert values(result, "block_.v[1]") == pytest.approx(np.clip(2 * (t - 0.2), 0, 1.5), abs=1e-7)
    stuck = t > 0.2 + 1.5 / 2 + 1e-6
    assert set(values(result, "belt.mode")[stuck]) == {0.0}
    assert values(result, "ambient.port.Q_flow")[t < 0.2] == pytest.approx(0)
    k = np.argmax(t > 0.2)
    assert values(result, "ambient.port.Q_flow")[k] == pytest.approx(4 * (1.5 - 2 * (t[k] - 0.2)))
