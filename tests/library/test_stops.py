"""Stops, gaps and play: closed forms, momentum, energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from acausal import compile_text


def simulate(text: str, **options: Any) -> Any:
    return compile_text(text).simulate(**{"tolerance": 1e-9, **options})


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


@pytest.mark.parametrize(
    ("bouncing", "position", "velocity", "force"),
    [
        (
            """import mechanical.translational.*;
model Ball
  MassWithStop ball(m = 2, smin = 0, e = 0.5,
    s(start = 1, fixed = true), v(start = 0, fixed = true));
  ConstantForce weight(f_constant = -19.62);
equation
  connect(ball.flange_a, weight.flange);
end Ball;
""",
            "ball.s",
            "ball.v",
            "ball.left.f",
        ),
        (
            """import mechanical.rotational.*;
model Flap
  InertiaWithStop ball(J = 2, phi_min = 0, phi_max = 2, e = 0.5,
    phi(start = 1, fixed = true), w(start = 0, fixed = true));
  ConstantTorque weight(tau_constant = -19.62);
equation
  connect(ball.flange_a, weight.flange);
end Flap;
""",
            "ball.phi",
            "ball.w",
            "ball.backward.tau",
        ),
    ],
)
def test_mass_with_stop_bounces_and_comes_to_rest(
    bouncing: str, position: str, velocity: str, force: str
) -> None:
    result = simulate(
        bouncing,
        stop_time=3,
        points=3001,
    )
    t, s, v = result.times, values(result, position), values(result, velocity)
    fall = np.sqrt(2 / 9.81)
    expected = np.where(t < fall, 1 - 9.81 / 2 * t**2, 0.0)
    start, speed = fall, 0.5 * 9.81 * fall
    for _ in range(60):
        end = start + 2 * speed / 9.81
        flying = (t >= start) & (t < end)
        expected[flying] = (speed - 9.81 / 2 * (t[flying] - start)) * (t[flying] - start)
        start, speed = end, 0.5 * speed
    assert s == pytest.approx(expected, abs=2e-6)
    rest = t > start + 1e-2
    assert set(v[rest]) == {0.0}
    assert set(values(result, "ball.a")[rest]) == {0.0}
    assert values(result, force)[rest] == pytest.approx(-19.62)


def test_mass_at_a_stop_leaves_when_it_is_pulled() -> None:
    result = simulate(
        """import mechanical.translational.*;
model Pulled
  MassWithStop mass(m = 2, smin = 0, s(start = 0, fixed = true), v(start = 0, fixed = true));
  Force pull;
  blocks.Ramp ramp(offset = -4, height = 8, duration = 2);
equation
  connect(ramp.y, pull.f);
  connect(pull.flange, mass.flange_a);
end Pulled;
""",
        stop_time=2,
    )
    t, v = result.times, values(result, "mass.v")
    assert v == pytest.approx(np.maximum(t - 1, 0) ** 2, abs=1e-7)
    assert set(v[t < 0.999]) == {0.0}


@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
def test_impact_of_two_bodies_keeps_their_momentum(e: float) -> None:
    for field, (body, mass, s, v) in {
        "translational": ("Mass", "m", "s", "v"),
        "rotational": ("Inertia", "J", "phi", "w"),
    }.items():
        result = simulate(
            f"""import mechanical.{field}.*;
model Impact
  {body} one({mass} = 2, {s}(start = 0, fixed = true), {v}(start = 3, fixed = true));
  {body} two({mass} = 1, {s}(start = 1.5, fixed = true), {v}(start = 0, fixed = true));
  RigidGap gap(e = {e});
equation
  connect(one.flange_b, gap.flange_a);
  connect(gap.flange_b, two.flange_a);
end Impact;
""",
            stop_time=1,
        )
        t, one, two = result.times, values(result, f"one.{v}"), values(result, f"two.{v}")
        assert 2 * one + two == pytest.approx(6, abs=1e-9)
        after = t > 0.5001
        assert one[after] == pytest.approx(2 - e, abs=1e-8)
        assert two[after] == pytest.approx(2 + 2 * e, abs=1e-8)
        assert one[t < 0.4999] == pytest.approx(3, abs=1e-12)


@pytest.mark.parametrize(
    ("field", "body", "drive", "s", "v", "force", "end"),
    [
        ("translational", "MassWithStopAndFriction", "Force", "s", "v", "f", "smax"),
        ("rotational", "InertiaWithStopAndFriction", "Torque", "phi", "w", "tau", "phi_max"),
    ],
)
def test_stop_stops_a_mass_with_friction(
    field: str, body: str, drive: str, s: str, v: str, force: str, end: str
) -> None:
    # 25 N against 5 N + 10 N exp(-2 v) + v up to the wall; there it stays until the force falls
    # below minus the friction at rest.
    result = simulate(
        f"""import mechanical.{field}.*;
model Stopped
  {body} mass({end} = 1, {s}(fixed = true), {v}(fixed = true));
  {drive} drive;
  blocks.Sine sine(amplitude = 40, f = 0.1);
equation
  connect(sine.y, drive.{force});
  connect(drive.flange, mass.flange_a);
end Stopped;
""",
        stop_time=8,
        points=8001,
    )
    t, x, u = result.times, values(result, f"mass.{s}"), values(result, f"mass.{v}")
    starts = np.arcsin(15 * 1.001 / 40) / (0.2 * np.pi)
    assert set(u[t < starts - 1e-3]) == set(x[t < starts - 1e-3]) == {0.0}
    at_wall = (x > 1 - 1e-9) & (t < 5 + starts - 1e-3)
    assert np.sum(at_wall) > 3000
    assert set(u[at_wall][1:]) <= {0.0}
    assert np.max(x) <= 1 + 1e-9
    assert x[-1] < 0
    assert u[t > 5 + starts + 1e-3][0] < 0


def test_play_between_springs_against_the_closed_form() -> None:
    # Free over b at 1 m/s, then half a period of the oscillator.
    for field, (body, mass, s, v) in {
        "translational": ("Mass", "m", "s", "v"),
        "rotational": ("Inertia", "J", "phi", "w"),
    }.items():
        result = simulate(
            f"""import mechanical.{field}.*;
model Play
  {body} body({mass} = 1, {s}(start = 0, fixed = true), {v}(start = 1, fixed = true));
  ElastoBacklash springs(c = 400, b = 0.2);
  Fixed fixed;
equation
  connect(fixed.flange, springs.flange_a);
  connect(springs.flange_b, body.flange_a);
end Play;
""",
            stop_time=5,
            points=5001,
        )
        period = 2 * 0.2 + 2 * np.pi / 20
        phase = (result.times + 0.1) % period
        half = phase % (period / 2)
        side = np.where(phase < period / 2, 1, -1)
        inside = half < 0.2
        x = np.where(inside, half - 0.1, 0.1 + np.sin(20 * (half - 0.2)) / 20)
        assert values(result, f"body.{s}") == pytest.approx(side * x, abs=1e-6)
        w = np.where(inside, 1, np.cos(20 * (half - 0.2)))
        assert values(result, f"body.{v}") == pytest.approx(side * w, abs=2e-5)


@pytest.mark.parametrize("kind", ["ElastoGap", "ElastoGap2"])
@pytest.mark.parametrize(
    ("field", "body", "m", "drive", "s", "v", "force"),
    [
        ("translational", "Mass", "m", "Force", "s", "v", "f"),
        ("rotational", "Inertia", "J", "Torque", "phi", "w", "tau"),
    ],
)
def test_elastic_contact_never_pulls_and_takes_energy(
    kind: str, field: str, body: str, m: str, drive: str, s: str, v: str, force: str
) -> None:
    result = simulate(
        f"""import mechanical.{field}.*;
model Contact
  {body} ball({m} = 1, {s}(start = 1, fixed = true), {v}(start = 0, fixed = true));
  Constant{drive} weight({force}_constant = -10);
  {kind} contact(c = 1000, d = 20);
  Fixed floor;
equation
  connect(weight.flange, ball.flange_b);
  connect(floor.flange, contact.flange_a);
  connect(contact.flange_b, ball.flange_a);
end Contact;
""",
        stop_time=4,
        points=8001,
    )
    x, u, f = (values(result, path) for path in (f"ball.{s}", f"ball.{v}", f"contact.{force}"))
    assert np.all(f <= 1e-9)
    assert np.all(f[x > 1e-9] == 0.0)
    assert np.all(values(result, "contact.lossPower") >= -1e-6)
    energy = u**2 / 2 + 10 * x + 500 * np.minimum(x, 0) ** 2
    if kind == "ElastoGap":
        assert np.all(np.diff(energy) <= 1e-6)
    assert energy[0] == pytest.approx(10)
    assert energy[-1] < 2


def test_contact_that_sticks_is_a_spring_and_damper_while_closed() -> None:
    # x = -exp(-D w t) sin(W t) v0/W from the touch until x = 0 again.
    result = simulate(
        """import mechanical.translational.*;
model Touch
  Mass ball(m = 1, s(start = 0.1, fixed = true), v(start = -1, fixed = true));
  ElastoGap2 contact(c = 10000, d = 20, sticky = true);
  Fixed floor;
equation
  connect(floor.flange, contact.flange_a);
  connect(contact.flange_b, ball.flange_a);
end Touch;
""",
        stop_time=0.3,
        points=3001,
    )
    t = result.times - 0.1
    damping, frequency = 10.0, np.sqrt(10000 - 100)
    end = np.pi / frequency
    inside = (t > 0) & (t < end)
    expected = -np.exp(-damping * t) * np.sin(frequency * t) / frequency
    assert values(result, "ball.s")[inside] == pytest.approx(expected[inside], abs=1e-8)
    assert values(result, "ball.v")[-1] == pytest.approx(np.exp(-damping * end), abs=1e-7)
