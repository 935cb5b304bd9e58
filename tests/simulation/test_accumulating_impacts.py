"""Infinitely many impacts in finite time end in rest, and rest ends when its support does."""

from __future__ import annotations

import numpy as np
import pytest

from tests.simulation.hybrid_runs import run, values

G = 9.81

BALL = """
model Ball
  parameter Real e = 0.5;
  Real h(start = 1, fixed = true), v(start = 0, fixed = true), pull;
  Integer n(start = 0, fixed = true);
equation
  der(h) = v;
  der(v) = -pull;
  pull = PULL;
  when h < 0 then
    reinit(v, -e*pre(v));
    n = pre(n) + 1;
  end when;
end Ball;
"""


def rest_time(e: float, h0: float = 1.0) -> float:
    return float(np.sqrt(2 * h0 / G) * (1 + e) / (1 - e))


@pytest.mark.parametrize("unit", ["h", "1000*h", "h/1000"])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-9])
@pytest.mark.parametrize("e", [0.0, 1e-6, 1e-4, 0.01, 0.1, 0.5, 0.8])
def test_ball_lies_still_until_the_end(e: float, tolerance: float, unit: str) -> None:
    text = BALL.replace("PULL", "9.81").replace("when h <", f"when {unit} <")
    result = run(text, 20.0, parameters={"e": e}, points=201, tolerance=tolerance)
    t = np.asarray(result.times)
    assert any("comes to rest" in event.text for event in result.events)
    after = t > rest_time(e) + max(1e-5, tolerance)
    assert np.sum(after) > 50
    assert np.abs(values(result, "h")[after]).max() < 1e-9
    assert np.all(values(result, "v")[after] == 0)
    assert values(result, "h").min() > -1e-9
    assert result.events[-1].time == pytest.approx(rest_time(e), abs=max(1e-4, tolerance**0.5))


@pytest.mark.parametrize(
    ("pull", "away", "position"),
    [
        # linear in time, zero at 8 s
        ("9.81*(1 - time/8)", 8.0, lambda s: 9.81 / 8 * s**3 / 6),
        # a jump at 8 s
        ("if time < 8 then 9.81 else -1", 8.0, lambda s: s**2 / 2),
        # not linear: 9.81 cos(0.2 t)
        ("9.81*cos(0.2*time)", 2.5 * np.pi, None),
    ],
)
def test_ball_leaves_the_floor_when_it_is_lifted(pull: str, away: float, position: object) -> None:
    result = run(BALL.replace("PULL", pull), 12.0, tolerance=1e-9, points=241)
    t, h = np.asarray(result.times), values(result, "h")
    lying = (t > 3) & (t < away - 1e-6)
    assert np.all(values(result, "v")[lying] == 0)
    assert np.abs(h[lying]).max() < 1e-9
    leaves = [event.time for event in result.events if "leaves its rest" in event.text]
    assert leaves == pytest.approx([away], abs=1e-7)
    flying = t > away
    s = t[flying] - away
    if callable(position):
        assert h[flying] == pytest.approx(position(s), abs=1e-5)
    else:
        expected = 9.81 * (s / 0.2 - np.sin(0.2 * s) / 0.04)
        assert h[flying] == pytest.approx(expected, abs=1e-5)


def test_ball_falls_back_and_rests_again() -> None:
    # Lifted with 1 m/s^2 from 4 s to 4.5 s, then let go.
    text = BALL.replace("PULL", "if time < 4 or time >= 4.5 then 9.81 else -1")
    result = run(text, 10.0, tolerance=1e-9, points=201)
    rests = [event.time for event in result.events if "comes to rest" in event.text]
    assert len(rests) == 2
    h, v = 0.5**2 / 2, 0.5
    impact = (v + np.sqrt(v**2 + 2 * G * h)) / G
    speed = np.sqrt(v**2 + 2 * G * h)
    assert rests[1] == pytest.approx(4.5 + impact + 2 * speed / G, abs=1e-3)
    t = np.asarray(result.times)
    assert np.all(values(result, "v")[t > rests[1] + 1e-6] == 0)
    assert np.abs(values(result, "h")[t > rests[1] + 1e-6]).max() < 1e-9


def test_balls_of_different_restitution_rest_each_in_its_time() -> None:
    text = """
    model Balls
      parameter Real e[3] = {0.3, 0.5, 0.7}, h0[3] = {2, 1, 0.5};
      Real h[3](start = h0, each fixed = true), v[3](each start = 0, each fixed = true);
    equation
      der(h) = v;
      for i in 1:3 loop
        der(v[i]) = -9.81;
        when h[i] < 0 then
          reinit(v[i], -e[i]*pre(v[i]));
        end when;
      end for;
    end Balls;
    """
    result = run(text, 6.0, points=301)
    t = np.asarray(result.times)
    rests = {e.text.split(": ")[1]: e.time for e in result.events if "comes to rest" in e.text}
    for i, (e, h0) in enumerate(zip((0.3, 0.5, 0.7), (2, 1, 0.5), strict=True), 1):
        assert rests[f"v[{i}] comes to rest"] == pytest.approx(rest_time(e, h0), abs=1e-3)
        after = t > rest_time(e, h0) + 1e-3
        assert np.all(values(result, f"v[{i}]")[after] == 0)
        assert np.abs(values(result, f"h[{i}]")[after]).max() < 1e-9
        assert values(result, f"h[{i}]").min() > -1e-9


def test_body_on_an_inclined_track_rests_at_its_stop() -> None:
    # A constraint ties x and y; it slides down with g sin(a) and bounces at y = 0.
    text = """
    model Track
      parameter Real e = 0.5, a = 0.5;
      Real x, y(start = 1, fixed = true), vx, vy(start = 0, fixed = true), F;
    equation
      y = x*tan(a);
      vx = der(x);
      vy = der(y);
      der(vx) = -F*sin(a);
      der(vy) = -9.81 + F*cos(a);
      when y < 0 then
        reinit(vy, -e*pre(vy));
      end when;
    end Track;
    """
    result = run(text, 5.0, tolerance=1e-9, points=101)
    a, e = 0.5, 0.5
    first = np.sqrt(2 / np.sin(a) / (G * np.sin(a)))
    t = np.asarray(result.times)
    after = t > first * (1 + e) / (1 - e) + 1e-3
    assert np.sum(after) > 20
    assert np.abs(values(result, "y")[after]).max() < 1e-9
    assert np.abs(values(result, "vy")[after]).max() < 1e-12
    assert np.abs(values(result, "vx")[after]).max() < 1e-12
    # at rest the stop carries what the track does not
    speed = np.hypot(values(result, "vx"), values(result, "vy"))
    energy = speed**2 / 2 + G * values(result, "y")
    assert np.all(np.diff(energy) < 1e-6)


def test_impacts_that_do_not_accumulate_go_on() -> None:
    result = run(BALL.replace("PULL", "9.81"), 20.0, parameters={"e": 1.0}, tolerance=1e-9)
    assert not any("rest" in event.text for event in result.events)
    period = 2 * np.sqrt(2 / G)
    assert values(result, "n")[-1] == int(20 / period + 0.5)
    energy = values(result, "v") ** 2 / 2 + G * values(result, "h")
    assert energy == pytest.approx(G, rel=1e-5)


SHAKEN = """
model Shaken
  parameter Real e = 0.3;
  Real y(start = 0.5, fixed = true), v(start = 0, fixed = true), h, w;
equation
  der(y) = v;
  der(v) = -9.81;
  h = y - 0.01*sin(10*time);
  w = 0.1*cos(10*time);
  when h < 0 then
    reinit(v, w - e*(pre(v) - w));
  end when;
end Shaken;
"""

STACK = """
model Stack
  parameter Real e = 0.5;
  Real h1(start = 1, fixed = true), v1(start = 0, fixed = true);
  Real h2(start = 2, fixed = true), v2(start = 0, fixed = true);
equation
  der(h1) = v1;
  der(v1) = -9.81;
  der(h2) = v2;
  der(v2) = -9.81;
  when h1 < 0 then
    reinit(v1, -e*pre(v1));
  end when;
  when h2 < h1 then
    reinit(v1, pre(v1) + (1 + e)/2*(pre(v2) - pre(v1)));
    reinit(v2, pre(v2) - (1 + e)/2*(pre(v2) - pre(v1)));
  end when;
end Stack;
"""


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("e", [0.0, 0.1, 0.3, 0.5])
def test_what_meets_a_moving_body_never_goes_through_in_silence(e: float, tolerance: float) -> None:
    # They ought to move on together, which reinit alone does not say.
    result = run(SHAKEN, 3.0, ending="failed", parameters={"e": e}, tolerance=tolerance)
    assert [d.code for d in result.diagnostics] == ["E045"]
    assert any("h < 0" in note for note in result.diagnostics[0].notes)
    assert values(result, "h").min() > -1e-9


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_balls_on_top_of_each_other_do_not_go_through_in_silence(tolerance: float) -> None:
    result = run(STACK, 5.0, ending="failed", tolerance=tolerance)
    assert [d.code for d in result.diagnostics] == ["E045"]
    assert (values(result, "h2") - values(result, "h1")).min() > -1e-9


def test_a_kick_in_passing_is_no_contact() -> None:
    text = """
    model Booster
      Real x(start = 0, fixed = true), v(start = 1, fixed = true);
      Integer laps(start = 0, fixed = true);
    equation
      der(x) = v;
      der(v) = -0.5*v;
      when x > 1 then
        reinit(v, 2);
      end when;
      when x > 2 then
        reinit(x, 0);
        laps = pre(laps) + 1;
      end when;
    end Booster;
    """
    result = run(text, 20.0)
    assert values(result, "laps")[-1] > 5


def test_bodies_without_a_force_bounce_between_walls() -> None:
    text = """
    model Walls
      Real x(start = 0, fixed = true), v(start = 1, fixed = true);
      Integer n(start = 0, fixed = true);
    equation
      der(x) = v;
      der(v) = 0;
      when abs(x) > 1 then
        reinit(v, -pre(v));
        n = pre(n) + 1;
      end when;
    end Walls;
    """
    result = run(text, 10.0)
    assert values(result, "n")[-1] == 5
    assert np.abs(values(result, "x")).max() == pytest.approx(1, abs=1e-9)


def test_ball_in_a_box_rests_on_its_floor() -> None:
    text = """
    model Box
      Real x(start = 0.5, fixed = true), v(start = 5, fixed = true);
    equation
      der(x) = v;
      der(v) = -9.81;
      when {x > 1, x < 0} then
        reinit(v, -0.5*pre(v));
      end when;
    end Box;
    """
    result = run(text, 10.0)
    assert 0 <= values(result, "x").max() <= 1 + 1e-9
    assert values(result, "x").min() > -1e-9
    assert values(result, "v")[-1] == 0


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-9])
def test_a_stop_holds_what_is_pressed_against_it_only(tolerance: float) -> None:
    text = """
    model Stop
      Real x(start = 0, fixed = true), v(start = 0, fixed = true);
    equation
      der(x) = v;
      der(v) = FORCE;
      when x > 0.5 then
        reinit(v, 0);
      end when;
    end Stop;
    """
    # cos(t) presses until pi/2; then x goes back as 0.5 - (t - pi/2) + ... of -cos
    result = run(text.replace("FORCE", "cos(time)"), 4.0, tolerance=tolerance)
    t = np.asarray(result.times)
    held = (t > np.arccos(0.5) + 1e-6) & (t < np.pi / 2 - 1e-6)
    assert np.all(values(result, "v")[held] == 0)
    back = t > np.pi / 2
    expected = 0.5 - np.cos(t[back]) - (t[back] - np.pi / 2)
    assert values(result, "x")[back] == pytest.approx(expected, abs=100 * tolerance)
    # a spring pulls away at once: no rest
    result = run(text.replace("FORCE", "-x").replace("v(start = 0", "v(start = 1"), 6.0)
    assert not any("rest" in event.text for event in result.events)
    assert values(result, "x").min() == pytest.approx(-0.5, abs=1e-3)


def test_integrate_and_fire() -> None:
    text = """
    model Neuron
      parameter Real I = 1.5;
      Real u(start = 0, fixed = true);
      Integer spikes(start = 0, fixed = true);
    equation
      der(u) = I - u;
      when u > 1 then
        reinit(u, 0);
        spikes = pre(spikes) + 1;
      end when;
    end Neuron;
    model Net
      parameter Integer n = 50;
      Neuron c[n](I = {1.2 + i/n for i in 1:n});
    end Net;
    """
    result = run(text, 5.0, points=3)
    currents = 1.2 + np.arange(1, 51) / 50
    expected = np.floor(5 / np.log(currents / (currents - 1)))
    found = [values(result, f"c[{i}].spikes")[-1] for i in range(1, 51)]
    assert found == pytest.approx(expected)
