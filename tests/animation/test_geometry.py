"""Where shapes are, against what is known in closed form."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import acausal as ac
from acausal.animation.animation import Animation
from acausal.animation.build import extent_of
from acausal.animation.raster import view_axes
from acausal.animation.scene import suited_speed

EXAMPLES = Path(__file__).parents[2] / "examples"


@cache
def scene(file, model=None, stop=None, points=401):
    compiled = ac.compile_file(EXAMPLES / f"{file}.acm", model)
    return Animation(compiled.simulate(stop_time=stop, points=points)).scene(fps=60)


def sprites(scene, name, kind=None):
    return [s for s in scene.sprites if s.name == name and kind in (None, s.kind)]


def test_pendulum_keeps_its_length():
    s = scene("cartesian_pendulum", stop=3)
    (rod,) = sprites(s, "", "stretched")[:1]
    ax, ay, bx, by = rod.channels
    assert ax.max() == ay.max() == 0
    # Interpolation between stored points cuts corners a little.
    np.testing.assert_allclose(np.hypot(bx, by), 1, atol=1e-4)
    assert bx[0] == pytest.approx(0.5) and by[0] == pytest.approx(-np.sqrt(0.75))


def test_links_of_a_chain_hang_on_one_another():
    s = scene("pendulum_chain", "TriplePendulum", 2)
    rods = [sprites(s, f"link[{k}]", "stretched")[0] for k in (1, 2, 3)]
    assert [float(c[0]) for c in rods[0].channels[:2]] == [0, 0]
    for one, two in pairwise(rods):
        np.testing.assert_array_equal(one.channels[2], two.channels[0])
        np.testing.assert_array_equal(one.channels[3], two.channels[1])
    colors = {rod.geometry[0].fill for rod in rods}
    assert len(colors) == 3


def test_four_bar_linkage_is_closed():
    s = scene("four_bar", "FourBar")
    ends = {n: sprites(s, n, "stretched")[0].channels for n in ("crank", "coupler", "rocker")}
    t = s.times
    np.testing.assert_allclose(ends["crank"][2], 0.4 * np.cos(t), atol=1e-4)
    np.testing.assert_allclose(ends["crank"][3], 0.4 * np.sin(t), atol=1e-4)
    lengths = {"crank": 0.4, "coupler": 0.9, "rocker": 0.7}
    for name, (ax, ay, bx, by) in ends.items():
        np.testing.assert_allclose(np.hypot(bx - ax, by - ay), lengths[name], atol=2e-4)
    np.testing.assert_allclose(ends["coupler"][2], ends["rocker"][2], atol=1e-6)


def test_hammer_touches_the_tool_and_stays_behind_the_exciter():
    s = scene("percussion_hammer_components", points=2001)
    pistons = [p for p in sprites(s, "", "stretched") if len(p.channels[0]) > 1]
    striker = next(p for p in pistons if p.geometry[0].fill == "#3b78b5")
    exciter = next(p for p in pistons if p.geometry[0].fill == "#c9a227")
    assert -1e-3 < striker.channels[0].min() < 2e-3
    assert (exciter.channels[0] >= striker.channels[2] - 1e-3).all()
    np.testing.assert_allclose(striker.channels[2] - striker.channels[0], 0.045, atol=1e-9)
    (rod,) = (p for p in pistons if p.geometry[0].fill == "#4f9d69")
    ax, ay, bx, by = rod.channels
    np.testing.assert_allclose(np.hypot(bx - ax, by - ay), 0.076, atol=5e-5)


def test_rods_of_the_suspension_have_constant_lengths():
    s = scene("five_link_suspension")
    assert s.dimension == 3
    for k in range(1, 6):
        (rod,) = sprites(s, f"suspension.link[{k}]", "stretched")
        c = [np.broadcast_to(x, len(s.times)) for x in rod.channels]
        length = np.sqrt(sum((c[i + 3] - c[i]) ** 2 for i in range(3)))
        assert np.ptp(length) < 1e-4 * length[0]
    wheel = next(p for p in sprites(s, "suspension", "placed"))
    np.testing.assert_allclose(wheel.channels[2][[0, -1]], [0.31 - 0.08, 0.31 + 0.08], atol=1e-6)


def test_gyroscope_precesses_level():
    s = scene("gyroscope", points=2001)
    disc = next(p for p in sprites(s, "", "placed") if len(p.geometry) > 4)
    x, y, z = disc.channels[3:6]  # the axle
    spin, m, length, inertia = 3000 * 2 * np.pi / 60, 1.0, 0.1, 2e-3
    rate = m * 9.80665 * length / (inertia * spin)
    turned = np.unwrap(np.arctan2(y, x))
    np.testing.assert_allclose(turned, rate * s.times, atol=2e-2)
    assert np.abs(z).max() < 0.02
    axes = np.array(disc.channels[3:9]).reshape(2, 3, -1)
    np.testing.assert_allclose((axes[0] * axes[1]).sum(axis=0), 0, atol=1e-9)


def test_car_and_its_wheels():
    s = scene("single_track_vehicle")
    compiled = ac.compile_file(EXAMPLES / "single_track_vehicle.acm")
    result = compiled.simulate(points=401)
    body = next(p for p in sprites(s, "car", "placed") if len(p.geometry) == 4)
    tyres = [p for p in sprites(s, "car", "placed") if len(p.geometry) == 3]
    assert len(tyres) == 4
    psi = result["car.chassis.psi"](s.times)
    np.testing.assert_allclose(body.channels[2], psi, atol=1e-3)
    left, right = (p for p in tyres if np.abs(p.channels[2] - body.channels[2]).max() > 0.01)
    middle = (left.channels[0] + right.channels[0]) / 2 - body.channels[0]
    np.testing.assert_allclose(middle, 1.19016 * np.cos(body.channels[2]), atol=2e-3)
    assert (left.channels[2] - body.channels[2])[-1] == pytest.approx(0.02, abs=1e-6)
    assert s.camera.follow and s.camera.extent[0] == 26


def test_watt_governor_lifts_its_balls():
    s = scene("watt_governor")
    ball = next(p for p in sprites(s, "ball_r", "ball"))
    assert ball.channels[2][-1] > ball.channels[2][0]
    assert s.camera.up == (0, 0, 1)
    other = next(p for p in sprites(s, "ball_l", "ball"))
    np.testing.assert_allclose(ball.channels[0], -other.channels[0], atol=1e-5)


@pytest.mark.parametrize(
    ("file", "model"), [("crane_crab", "ControlledCraneCrab"), ("crank_engine", None)]
)
def test_everything_is_in_view(file, model):
    s = scene(file, model, 1.0)
    low, high = extent_of(s.sprites, 2)
    cx, cy = s.camera.center
    width, height = s.camera.extent
    assert cx - width / 2 < low[0] and high[0] < cx + width / 2
    assert cy - height / 2 < low[1] and high[1] < cy + height / 2


def test_parts_along_a_line_lie_side_by_side():
    result = ac.compile_text("""
import mechanical.translational.*;
model Two
  Fixed wall;
  Spring c1(c = 10); Damper d1(d = 1);
  Mass m1(s(start = 0.1, fixed = true), v(start = 0, fixed = true));
  Spring c2(c = 10);
  Mass m2(s(start = 0, fixed = true), v(start = 0, fixed = true));
equation
  connect(wall.flange, c1.flange_a, d1.flange_a);
  connect(c1.flange_b, d1.flange_b, m1.flange_a);
  connect(m1.flange_b, c2.flange_a);
  connect(c2.flange_b, m2.flange_a);
end Two;
""").simulate(stop_time=5)
    s = Animation(result).scene()
    assert s.dimension == 2
    ends = {n: sprites(s, n, "stretched")[0].channels for n in ("c1", "d1", "m1", "c2", "m2")}
    # From left to right, none inside another, at all times.
    for one, two in (("c1", "m1"), ("m1", "c2"), ("c2", "m2")):
        np.testing.assert_allclose(ends[one][2], ends[two][0], atol=1e-12)
    for ax, _, bx, _ in ends.values():
        assert (bx - ax).min() > 0.02
    # Motion is true to scale, and spring and damper have lanes of their own.
    m1 = result["m1.s"](s.times)
    np.testing.assert_allclose(ends["m1"][0] - ends["m1"][0][0], m1 - m1[0], atol=1e-12)
    assert ends["c1"][1][0] != ends["d1"][1][0]


def test_turning_parts_show_their_angles():
    result = ac.compile_text("""
import mechanical.rotational.*;
model Shaft
  Inertia a(J = 1, phi(start = 0, fixed = true), w(start = 3, fixed = true));
  Spring c(c = 10);
  Inertia b(J = 2, phi(start = 0, fixed = true), w(start = 0, fixed = true));
equation
  connect(a.flange_b, c.flange_a);
  connect(c.flange_b, b.flange_a);
end Shaft;
""").simulate(stop_time=5)
    s = Animation(result).scene()
    (wheel,) = sprites(s, "a", "placed")
    np.testing.assert_allclose(wheel.channels[2], result["a.phi"](s.times), atol=1e-9)
    (other,) = sprites(s, "b", "placed")
    assert wheel.channels[0][0] != other.channels[0][0]


def test_directions_of_view_are_perpendicular():
    for up in ((0, 0, 1), (0, 1, 0), (0.6, 0, 0.8)):
        right, above, viewer, east, north = view_axes(30, 20, np.array(up, dtype=float))
        basis = np.array([right, above, viewer])
        np.testing.assert_allclose(basis @ basis.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(basis) == pytest.approx(1)
        assert above @ np.array(up) > 0.9
        assert abs(east @ north) < 1e-12


@pytest.mark.parametrize(
    ("duration", "speed"), [(10, 1), (0.5, 0.05), (0.02, 0.002), (1000, 100), (2, 0.2)]
)
def test_speed_is_round(duration, speed):
    assert suited_speed(duration) == pytest.approx(speed)
