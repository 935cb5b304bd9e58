"""Wheels on the ground and wheels in mesh: closed forms, SciPy, energy."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.planar.mechanisms import G, body, body_energy, run, solution, values


def test_ideal_rolling_down_a_slope() -> None:
    # a = g sin(alpha)/(1 + I/(m R^2)); the plane is tilted by tilting gravity
    result = run(
        """
  Body disc(m = 2, I = 0.01);
  IdealRolling rolling(R = 0.1, phi(fixed = true), x(fixed = true), vx(start = 1, fixed = true));
equation
  connect(disc.frame_a, rolling.frame_a);
""",
        gravity="{9.81*sin(0.3), -9.81*cos(0.3)}",
    )
    t = result.times
    a = G * np.sin(0.3) / (1 + 0.01 / (2 * 0.1**2))
    assert values(result, "rolling.x") == pytest.approx(t + a / 2 * t**2, abs=1e-7)
    assert values(result, "rolling.phi") == pytest.approx(-values(result, "rolling.x") / 0.1)
    assert values(result, "rolling.N") == pytest.approx(2 * G * np.cos(0.3))


def test_counter_spin_slides_and_then_rolls() -> None:
    # A ring is thrown forward with backspin. While it slides the friction is m g mu_S; when the
    # slip has gone it rolls. Angular momentum about the ground decides on its final velocity.
    m, inertia, radius, mu = 0.01, 0.0005, 0.1, 0.15
    result = run(
        f"""
  Body ring(m = {m}, I = {inertia});
  DryFrictionBasedRolling rolling(R = {radius}, vAdhesion = 1e-3, vSlide = 3e-3, mu_A = 0.5,
    mu_S = {mu}, phi(fixed = true), w(start = 15, fixed = true), vx(start = 2, fixed = true),
    x(fixed = true));
  Real lost(start = 0, fixed = true) = 0;
equation
  connect(ring.frame_a, rolling.frame_a);
""".replace(
            "  Real lost(start = 0, fixed = true) = 0;\n", "  Real lost(start = 0, fixed = true);\n"
        )
        + "  der(lost) = rolling.lossPower;\n",
        stop_time=3,
    )
    t = result.times
    vx, w = values(result, "rolling.vx"), values(result, "rolling.w")
    slipping = 2 + radius * 15
    rate = mu * G * (1 + m * radius**2 / inertia)
    end = slipping / rate
    sliding = t < end - 0.01
    assert vx[sliding] == pytest.approx(2 - mu * G * t[sliding], abs=1e-7)
    assert w[sliding] == pytest.approx(15 - mu * m * G * radius / inertia * t[sliding], abs=1e-5)
    rolling = t > end + 0.01
    final = -(inertia * 15 - m * radius * 2) / (inertia / radius + m * radius)
    assert vx[rolling] == pytest.approx(final, abs=1e-6)
    assert w[rolling] == pytest.approx(-final / radius, abs=1e-5)
    energy = body_energy(result, "ring", m, inertia) + values(result, "lost")
    assert energy == pytest.approx(energy[0], rel=1e-6)


def test_wheel_based_crane_crab() -> None:
    # A wheel that rolls carries a pendulum on its axle.
    result = run(
        """
  Body wheel(m = 2, I = 0.02);
  IdealRolling rolling(R = 0.2, x(fixed = true), vx(fixed = true), phi(fixed = true));
  FrameHinge axle;
  Link rod(r = {0, -0.6}, m = 1.5, phi(start = 1, fixed = true), w(fixed = true));
equation
  connect(wheel.frame_a, rolling.frame_a, axle.frame_a);
  connect(axle.hinge, rod.hinge_a);
""",
        stop_time=4,
    )
    m, half, inertia, whole = 1.5, 0.3, 1.5 * 0.6**2 / 12, 2 + 0.02 / 0.2**2

    def motion(_: float, y: np.ndarray) -> list[float]:
        phi, w = y[1], y[3]
        mass = [
            [whole + m, m * half * np.cos(phi)],
            [m * half * np.cos(phi), m * half**2 + inertia],
        ]
        right = [m * half * w**2 * np.sin(phi), -m * G * half * np.sin(phi)]
        return [*y[2:], *np.linalg.solve(mass, right)]

    expected = solution(motion, [0, 1, 0, 0], result.times)
    assert values(result, "rolling.x") == pytest.approx(expected[0], abs=1e-6)
    assert values(result, "rod.phi") == pytest.approx(expected[1], abs=1e-6)


PLANETARY = """
  Fixed centre;
  Revolute sunBearing, carrierBearing(useFlange = true), planetBearing;
  Body sun(m = 1e-3, I = 0.02), planet(m = 0.5, I = 0.003);
  FixedTranslation carrier(r = {0.3, 0});
  RigidNoLossExternal mesh(r_a = 0.2, r_b = 0.1);
  mechanical.rotational.ConstantTorque drive(tau_constant = 2);
"""


@pytest.mark.parametrize("ring_first", [True, False])
def test_planetary_gear_of_wheels_in_a_plane(ring_first: bool) -> None:
    ends = ("centre.frame_a, ring.frame_a", "planet.frame_a, ring.frame_b")
    radii = "r_a = 0.4, r_b = 0.1"
    if not ring_first:
        ends = ("centre.frame_a, ring.frame_b", "planet.frame_a, ring.frame_a")
        radii = "r_a = 0.1, r_b = 0.4"
    result = run(
        PLANETARY
        + f"""
  RigidNoLossInternal ring({radii});
equation
  connect({ends[0]});
  connect({ends[1]});
  connect(centre.frame_a, sunBearing.frame_a, carrierBearing.frame_a);
  connect(sunBearing.frame_b, sun.frame_a, mesh.frame_a);
  connect(carrierBearing.frame_b, carrier.frame_a);
  connect(carrier.frame_b, planetBearing.frame_a);
  connect(planetBearing.frame_b, planet.frame_a, mesh.frame_b);
  connect(drive.flange, carrierBearing.flange_a);
""",
        gravity="{0, 0}",
        stop_time=2,
    )
    w = values(result, "carrierBearing.w")
    assert values(result, "sun.w") == pytest.approx(3 * w, abs=1e-6)  # Willis: 1 + r_ring/r_sun
    assert values(result, "planet.w") == pytest.approx(-3 * w, abs=1e-6)
    inertia = 0.02 * 9 + 0.003 * 9 + 0.5 * 0.3**2
    assert w == pytest.approx(2 / inertia * result.times, abs=1e-6)
    assert values(result, "mesh.length") == pytest.approx(0.3)
    # the sun is accelerated by the teeth
    assert values(result, "mesh.F_n")[1:] * 0.2 == pytest.approx(
        values(result, "sun.z")[1:] * 0.02, abs=1e-6
    )
    assert values(result, "mesh.v_mesh") == pytest.approx(0.2 * 2 * w, abs=1e-6)
    assert values(result, "ring.w_gear") == pytest.approx(w, abs=1e-6)


def test_two_wheels_in_mesh_on_a_swinging_arm_keep_their_energy() -> None:
    result = run(
        """
  Fixed pivot;
  Revolute a(phi(start = 1, fixed = true), w(fixed = true));
  FixedTranslation arm(r = {0, -0.5}), spacer(r = {0.25, 0});
  Revolute first(phi(fixed = true), w(start = 20, fixed = true)), second;
  Body one(m = 1, I = 0.01), two(m = 2, I = 0.03);
  RigidNoLossExternal mesh(r_a = 0.1, r_b = 0.15);
equation
  connect(pivot.frame_a, a.frame_a);
  connect(a.frame_b, arm.frame_a);
  connect(arm.frame_b, first.frame_a, spacer.frame_a);
  connect(spacer.frame_b, second.frame_a);
  connect(first.frame_b, one.frame_a, mesh.frame_a);
  connect(second.frame_b, two.frame_a, mesh.frame_b);
""",
        stop_time=3,
    )
    energy = body_energy(result, "one", 1, 0.01) + body_energy(result, "two", 2, 0.03)
    assert np.ptp(energy) < 1e-5
    assert 0.1 * values(result, "first.w") == pytest.approx(-0.15 * values(result, "second.w"))
    assert np.ptp(values(result, "a.phi")) > 1


def test_wheels_at_the_wrong_distance_are_reported() -> None:
    result = run(
        body("one", 1, 0.1)
        + body("two", 1, 0.1, r=(0.5, 0))
        + """
  RigidNoLossExternal mesh(r_a = 0.1, r_b = 0.15);
equation
  connect(one.frame_a, mesh.frame_a);
  connect(two.frame_a, mesh.frame_b);
""",
        gravity="{0, 0}",
    )
    assert any("distance" in d.message for d in result.diagnostics)
