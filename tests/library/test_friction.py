"""Dry friction: closed forms, no creep, no energy from nothing, momentum kept."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from acausal import compile_text

# Names of the same things in motion along a line and about an axis.
FIELDS = {
    "translational": ("Mass", "m", "s", "v", "Force", "f", "SupportFriction", "FrictionForce"),
    "rotational": (
        "Inertia",
        "J",
        "phi",
        "w",
        "Torque",
        "tau",
        "BearingFriction",
        "FrictionTorque",
    ),
}
both = pytest.mark.parametrize("field", list(FIELDS))


def simulate(text: str, **options: Any) -> Any:
    return compile_text(text).simulate(**{"tolerance": 1e-9, **options})


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def driven_body(
    field: str, source: str, v0: float = 0.0, table: str = "[0, 1]", peak: float = 1.0, **more: Any
) -> dict[str, Any]:
    """Simulate a body of mass 2 with friction under a given force."""
    body, mass, s, v, drive, force, friction, _ = FIELDS[field]
    result = simulate(
        f"""import mechanical.{field}.*;
model Driven
  {body} body({mass} = 2, {s}(fixed = true), {v}(start = {v0}, fixed = true));
  {friction} friction({force}_pos = {table}, peak = {peak});
  {drive} drive;
  {source};
equation
  connect(source.y, drive.{force});
  connect(drive.flange, body.flange_a);
  connect(body.flange_b, friction.flange_a);
end Driven;
""",
        **more,
    )
    names = {
        "s": f"body.{s}",
        "v": f"body.{v}",
        "a": "body.a",
        "friction": f"friction.{force}",
        "mode": "friction.mode",
        "loss": "friction.lossPower",
        "force": "source.y",
    }
    return {"t": result.times, **{key: values(result, path) for key, path in names.items()}}


@both
@pytest.mark.parametrize("sign", [1, -1])
def test_sliding_body_comes_to_rest_and_stays_there(field: str, sign: int) -> None:
    # 2 v' = -1, so it takes 6 s and 9 m from 3 m/s.
    run = driven_body(field, "blocks.Constant source(k = 0)", sign * 3.0, stop_time=10)
    t = np.minimum(run["t"], 6.0)
    assert run["v"] == pytest.approx(sign * (3 - t / 2), abs=1e-8)
    assert run["s"] == pytest.approx(sign * (3 * t - t**2 / 4), abs=1e-7)
    rest = run["t"] > 6.001
    assert set(run["v"][rest]) == {0.0}
    assert set(run["a"][rest]) == {0.0}
    assert np.ptp(run["s"][rest]) == 0.0
    assert set(run["mode"][rest]) == {0.0}
    assert set(run["mode"][run["t"] < 5.999]) == {float(sign)}


@both
@pytest.mark.parametrize("sign", [1, -1])
def test_body_breaks_away_at_the_peak(field: str, sign: int) -> None:
    # The force grows as t; friction holds up to 1.5 and is 1 afterwards: 2 v' = t - 1.
    source = f"blocks.Ramp source(height = {10 * sign}, duration = 10)"
    run = driven_body(field, source, peak=1.5, stop_time=4)
    t = np.maximum(run["t"], 1.5)
    assert run["v"] == pytest.approx(sign * ((t - 1) ** 2 / 4 - 1 / 16), abs=1e-7)
    stuck = run["t"] < 1.4999
    assert set(run["v"][stuck]) == set(run["s"][stuck]) == {0.0}
    assert run["friction"][stuck] == pytest.approx(sign * run["t"][stuck], abs=1e-9)
    assert run["friction"][run["t"] > 1.5001] == pytest.approx(sign)


@both
def test_force_below_the_friction_moves_nothing(field: str) -> None:
    run = driven_body(field, "blocks.Sine source(amplitude = 0.999, f = 1)", stop_time=20)
    assert set(run["v"]) == set(run["s"]) == {0.0}
    assert run["friction"] == pytest.approx(run["force"], abs=1e-9)


@both
def test_oscillating_force_against_the_closed_form(field: str) -> None:
    # A square wave of force 3, period 2: up with a = 1 for 1 s, down with a = -2 in 0.5 s, then
    # down with a = -1 for 0.5 s, ...; friction changes its sign without a pause.
    source = "blocks.Pulse source(amplitude = 6, offset = -3, period = 2, width = 50)"
    run = driven_body(field, source, stop_time=4)
    t = np.array([0.0, 1.0, 1.5, 2.0, 2.25, 3.0, 3.375, 4.0])
    v = np.array([0.0, 1.0, 0.0, -0.5, 0.0, 0.75, 0.0, -0.625])
    assert run["v"] == pytest.approx(np.interp(run["t"], t, v), abs=1e-7)
    sliding = np.abs(run["v"]) > 1e-6
    assert run["friction"][sliding] == pytest.approx(np.sign(run["v"][sliding]))


@both
def test_energy_goes_into_friction_only(field: str) -> None:
    run = driven_body(
        field,
        "blocks.Sine source(amplitude = 8, f = 0.3)",
        table="[0, 3; 0.5, 1.5; 1, 1; 4, 2]",
        peak=1.2,
        stop_time=10,
        points=20001,
        tolerance=1e-10,
    )
    step = np.diff(run["t"])

    def integral(rate: Any) -> Any:
        return np.concatenate([[0], np.cumsum(step * (rate[:-1] + rate[1:]) / 2)])

    work = integral(run["force"] * run["v"])
    lost = integral(run["loss"])
    assert np.all(run["loss"] >= -1e-9)
    assert run["v"] ** 2 == pytest.approx(work - lost, abs=2e-4)
    assert {-1.0, 0.0, 1.0} <= set(run["mode"])
    stuck = run["mode"] == 0
    assert np.all(run["v"][stuck] == 0.0)


@both
def test_table_is_followed_between_and_beyond_its_rows(field: str) -> None:
    run = driven_body(
        field,
        "blocks.Constant source(k = 40)",
        table="[0, 3; 0.5, 1.5; 1, 1; 4, 2.5]",
        stop_time=1,
    )
    v = run["v"]
    inside = np.interp(v, [0, 0.5, 1, 4], [3, 1.5, 1, 2.5])
    assert v[-1] > 10
    expected = np.where(v > 4, 2.5 + 0.5 * (v - 4), inside)
    moving = run["t"] > 0
    assert run["friction"][moving] == pytest.approx(expected[moving], abs=1e-7)


@both
def test_two_bodies_drag_each_other_to_the_common_velocity(field: str) -> None:
    body, mass, s, v, _, force, _, friction = FIELDS[field]
    result = simulate(
        f"""import mechanical.{field}.*;
model Pair
  {body} one({mass} = 2, {s}(fixed = true), {v}(start = 4, fixed = true));
  {friction} between({force}_pos = [0, 3]);
  {body} two({mass} = 3, {s}(fixed = true), {v}(start = -1, fixed = true));
equation
  connect(one.flange_b, between.flange_a);
  connect(between.flange_b, two.flange_a);
end Pair;
""",
        stop_time=5,
    )
    t, end = result.times, 2.0
    one, two = values(result, f"one.{v}"), values(result, f"two.{v}")
    assert one == pytest.approx(4 - 1.5 * np.minimum(t, end), abs=1e-8)
    assert two == pytest.approx(-1 + np.minimum(t, end), abs=1e-8)
    locked = t > end + 1e-3
    assert set(values(result, f"between.{v}_rel")[locked]) == {0.0}
    assert 2 * one + 3 * two == pytest.approx(5, abs=1e-9)


@both
@pytest.mark.parametrize("opened", [False, True])
def test_clutch_locks_with_the_angular_momentum_of_both(field: str, opened: bool) -> None:
    body, mass, s, v, *_ = FIELDS[field]
    result = simulate(
        f"""import mechanical.{field}.*;
model Coupling
  {body} one({mass} = 2, {s}(fixed = true), {v}(start = 10, fixed = true));
  Clutch clutch(fn_max = 6, cgeo = 2, mu_pos = [0, 0.5; 10, 0.25]);
  {body} two({mass} = 3, {s}(fixed = true), {v}(start = 0, fixed = true));
  blocks.Step actuation(height = {-1 if opened else 1}, startTime = 1, offset = {int(opened)});
equation
  connect(actuation.y, clutch.f_normalized);
  connect(one.flange_b, clutch.flange_a);
  connect(clutch.flange_b, two.flange_a);
end Coupling;
""",
        stop_time=6,
        points=6001,
    )
    t = result.times
    one, two = values(result, f"one.{v}"), values(result, f"two.{v}")
    assert 2 * one + 3 * two == pytest.approx(20, abs=1e-8)
    energy = one**2 + 1.5 * two**2
    assert np.all(np.diff(energy) <= 1e-9)
    mode = values(result, "clutch.mode")
    if opened:
        assert set(mode[t > 1.001]) == {2.0}
        assert np.ptp(one[t > 1.001]) < 1e-12
        assert set(mode[t < 0.999]) == {-1.0}
    else:
        assert set(mode[t < 0.999]) == {2.0}
        assert np.ptp(one[t < 0.999]) == 0.0
        assert one[-1] == two[-1] == pytest.approx(4, abs=1e-8)
        assert set(values(result, f"clutch.{v}_rel")[mode == 0]) == {0.0}


@both
def test_brake_holds_a_load_and_lets_it_go(field: str) -> None:
    body, mass, s, v, drive, force, *_ = FIELDS[field]
    result = simulate(
        f"""import mechanical.{field}.*;
model Hoist
  {body} load({mass} = 2, {s}(fixed = true), {v}(start = 1, fixed = true));
  Brake brake(fn_max = 100);
  Constant{drive} weight({force}_constant = 20);
  blocks.Ramp release(height = -1, offset = 1, duration = 1, startTime = 1);
equation
  connect(release.y, brake.f_normalized);
  connect(weight.flange, load.flange_a);
  connect(load.flange_b, brake.flange_a);
end Hoist;
""",
        stop_time=2.5,
    )
    # Sliding: 2 v' = 20 - 50; held until the brake force 50 (2 - t) has come down to 20 at 1.6 s;
    # then 2 v' = 50 t - 80, and 2 v' = 20 from 2 s on.
    t, found = result.times, values(result, f"load.{v}")
    early = np.maximum(1 - 15 * t, 0)
    slipping = 12.5 * np.clip(t - 1.6, 0, 0.4) ** 2 + 10 * np.maximum(t - 2, 0)
    assert found == pytest.approx(early + slipping, abs=1e-7)
    held = (t > 0.07) & (t < 1.599)
    assert set(found[held]) == {0.0}
    assert set(values(result, "brake.mode")[t > 2.001]) == {2.0}


def test_one_way_clutch_overtakes_and_carries_along() -> None:
    result = simulate(
        """import mechanical.rotational.*;
model Freewheel
  Speed crank(exact = true, phi(fixed = true));
  blocks.Cosine speed(amplitude = 10, f = 0.5);
  OneWayClutch freewheel(stateSelect = StateSelect.always);
  blocks.Constant open(k = 0);
  Inertia wheel(J = 2, w(start = 10, fixed = true));
  Damper bearing(d = 2);
  Fixed fixed;
equation
  connect(speed.y, crank.w_ref);
  connect(open.y, freewheel.f_normalized);
  connect(crank.flange, freewheel.flange_a);
  connect(freewheel.flange_b, wheel.flange_a);
  connect(wheel.flange_b, bearing.flange_a);
  connect(bearing.flange_b, fixed.flange);
end Freewheel;
""",
        stop_time=4,
        points=8001,
    )
    t, w = result.times, values(result, "wheel.w")
    drive = 10 * np.cos(np.pi * t)
    assert np.all(w >= drive - 1e-7)
    # The wheel slows down as exp(-t) as soon as the crank is slower: where 10 pi sin(pi t) = w.
    release = np.arctan(1 / np.pi) / np.pi
    free = (t > release) & (t < 1.5)
    expected = 10 * np.cos(np.pi * release) * np.exp(release - t)
    assert w[free] == pytest.approx(expected[free], abs=1e-6)
    assert w[t < release - 1e-3] == pytest.approx(drive[t < release - 1e-3], abs=1e-7)
    assert np.all(values(result, "freewheel.tau") <= 1e-7)


def test_impact_turns_the_friction_round() -> None:
    # A mass slides to and fro between two walls and loses friction times way.
    result = simulate(
        """import mechanical.translational.*;
model Puck
  MassWithStop puck(m = 2, L = 0.2, smin = -1.1, smax = 1.1, e = 1,
    s(fixed = true), v(start = 3, fixed = true));
  SupportFriction ice(f_pos = [0, 0.5]);
equation
  connect(puck.flange_b, ice.flange_a);
end Puck;
""",
        stop_time=20,
        points=4001,
    )
    s, v = values(result, "puck.s"), values(result, "puck.v")
    # 18 m of way altogether, v^2 = 9 - way/2: 1 m to the first wall, then 8 times 2 m and 1 m.
    assert s[-1] == pytest.approx(0, abs=1e-6)
    way = 18 * (1 - (1 - np.minimum(result.times, 12) / 12) ** 2)
    assert np.abs(v) == pytest.approx(np.sqrt(9 - way / 2), abs=1e-6)
    turns = (way + 1) / 2
    assert s == pytest.approx(1 - 2 * np.abs(turns / 2 % 1 * 2 - 1), abs=1e-6)
    assert set(v[result.times > 12.001]) == {0.0}
