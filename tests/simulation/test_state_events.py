"""Events of the solution: when they are found, and what goes on through them."""

from __future__ import annotations

import importlib.util
import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.simulation.hybrid_runs import instants, jumps, last, run, sides, values

HAVE_ODES = any(importlib.util.find_spec(name) for name in ("scikits_odes_sundials", "scikits"))


def test_no_event_and_smooth_make_no_events() -> None:
    text = """
    model M
      Real x(start = 0, fixed = true), y, z, q, w;
    equation
      der(x) = 1;
      y = noEvent(if x > 1 then 2 else 3);
      z = smooth(0, if x > 0.5 then x - 0.5 else 0);
      q = abs(x - 0.3) + max(x, 0.7) + min(x, 0.2) + sign(x - 0.9);
      w = noEvent(floor(3*x));
    end M;
    """
    result = run(text)
    assert len(result.events) == 0
    assert np.all(np.diff(result.times) > 0)
    assert last(result, "y") == 2
    assert last(result, "z") == pytest.approx(1.5)
    assert last(result, "w") == 5
    with_events = run(text.replace("noEvent", "").replace("smooth(0, ", "("))
    # 1/3, 0.5, 2/3, 1 (y and w at once), 4/3, 5/3; 2 is the end
    assert len(instants(with_events)) >= 6


def test_relations_of_parameters_and_discrete_variables_make_no_events() -> None:
    text = """
    model M
      parameter Real p = 2;
      Integer n(start = 0, fixed = true);
      Real x(start = 0, fixed = true);
    equation
      der(x) = if p > 1 then (if n > 1 then 2 else 1) else 0;
      when sample(0.5, 0.5) then
        n = pre(n) + 1;
      end when;
    end M;
    """
    result = run(text, 1.75)
    assert instants(result) == pytest.approx([0.5, 1, 1.5])
    assert last(result, "x") == pytest.approx(1 + 2 * 0.75, rel=1e-9)


def test_steps_of_states() -> None:
    # x goes up to 2.25 and back: every whole number is crossed upwards and downwards.
    text = """
    model M
      Real x(start = 0.25, fixed = true), v(start = 2, fixed = true);
      Real saw = mod(x, 0.5), up = ceil(x), whole = div(x, 0.5), rest = rem(x, 0.5);
      Integer k = integer(x);
      Integer changes(start = 0, fixed = true);
    equation
      der(x) = v;
      der(v) = -1;
      when change(k) then
        changes = pre(changes) + 1;
      end when;
    end M;
    """
    result = run(text, 4.2, points=211, tolerance=1e-10)
    t = np.asarray(result.times)
    x = 0.25 + 2 * t - t**2 / 2
    inside = np.abs(x / 0.5 - np.round(x / 0.5)) > 1e-6
    assert np.sum(inside) > 180
    expected = {
        "saw": x % 0.5,
        "up": np.ceil(x),
        "whole": np.trunc(x / 0.5),
        "rest": np.fmod(x, 0.5),
        "k": np.floor(x),
    }
    for name, wanted in expected.items():
        found = values(result, name)[inside]
        assert found == pytest.approx(wanted[inside], abs=1e-8), name
    crossings = [2 - np.sqrt(4 - 2 * (n - 0.25)) for n in (1, 2)]
    crossings += [2 + np.sqrt(4 - 2 * (n - 0.25)) for n in (2, 1, 0)]
    assert [time for time, _ in jumps(result, "k")] == pytest.approx(crossings, abs=1e-8)
    assert [value for _, value in jumps(result, "k")] == [1, 2, 1, 0, -1]
    assert last(result, "changes") == 5
    assert sides(result, "saw", crossings[0]) == pytest.approx((0.5, 0), abs=1e-8)
    assert sides(result, "saw", crossings[-1]) == pytest.approx((0, 0.5), abs=1e-8)


BALL = """
model Ball
  parameter Real e = 0.8;
  Real h(start = 1, fixed = true), v(start = 0, fixed = true), energy;
  Real other(start = 3, fixed = true), third(start = 1, fixed = true);
  Integer n(start = 0, fixed = true);
equation
  der(h) = v;
  der(v) = -9.81;
  der(other) = -0.5*other + h;
  third^3 + der(third) = other;
  energy = v^2/2 + 9.81*h;
  when h < 0 then
    reinit(v, -e*pre(v));
    n = pre(n) + 1;
  end when;
end Ball;
"""


def ball_impacts(e: float, number: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    first = np.sqrt(2 / 9.81)
    return np.asarray(first * (1 + 2 * np.cumsum(np.concatenate([[0], e ** np.arange(1, number)]))))


def test_both_sides_of_an_event_are_stored() -> None:
    result = run(BALL, 1.5, tolerance=1e-10)
    first, second = ball_impacts(0.8, 2)
    speed = 9.81 * np.sqrt(2 / 9.81)
    assert sides(result, "v", first) == pytest.approx((-speed, 0.8 * speed), rel=1e-8)
    assert sides(result, "v", second) == pytest.approx((-0.8 * speed, 0.64 * speed), rel=1e-8)
    assert sides(result, "n", first) == (0, 1)
    assert sides(result, "n", second) == (1, 2)
    before, after = sides(result, "energy", first)
    assert after == pytest.approx(0.64 * before, rel=1e-8)
    assert sides(result, "der(h)", first) == pytest.approx((-speed, 0.8 * speed), rel=1e-8)


def test_other_states_go_on_as_they_are() -> None:
    result = run(BALL, 2.0, tolerance=1e-9)
    t = np.asarray(result.times)
    double = np.flatnonzero(np.diff(t) == 0)
    assert len(double) >= 3
    for name in ("h", "other", "third"):
        found = values(result, name)
        assert found[double + 1] == pytest.approx(found[double], abs=1e-12), name
    # The history counts: the value at the end is that of a run of this linear part by itself.
    exact = 3 * np.exp(-0.5 * t[-1])
    fine = run(BALL, 2.0, tolerance=1e-9, points=4001)
    t, h = np.asarray(fine.times), values(fine, "h")
    weights = np.exp(-0.5 * (t[-1] - t))
    assert last(result, "other") == pytest.approx(exact + np.trapezoid(weights * h, t), abs=1e-5)


def test_events_next_to_the_output_points_keep_times_in_order() -> None:
    result = run(BALL, 2.0, points=1001)
    t = np.asarray(result.times)
    assert np.all(np.diff(t) >= 0)
    grid = np.linspace(0, 2, 1001)
    assert np.all(np.isin(grid, t))


def test_a_thousand_balls_meet_the_floor_each_at_its_time() -> None:
    text = """
    model Ball
      parameter Real h0 = 1;
      Real h(start = h0, fixed = true), v(start = 0, fixed = true);
      Real hit(start = -1, fixed = true);
    equation
      der(h) = v;
      der(v) = -9.81;
      when h < 0 then
        hit = time;
        reinit(v, 2);
      end when;
    end Ball;
    model Balls
      parameter Integer n = 1000;
      Ball ball[n](h0 = {0.5 + i/n for i in 1:n});
    end Balls;
    """
    result = run(text, 0.56, points=2, tolerance=1e-8)
    heights = 0.5 + np.arange(1, 1001) / 1000
    found = np.array([last(result, f"ball[{i}].hit") for i in range(1, 1001)])
    assert found == pytest.approx(np.sqrt(2 * heights / 9.81), abs=1e-6)


def test_two_balls_meet_the_floor_at_once() -> None:
    text = """
    model Balls
      parameter Real e[2] = {0.5, 0.7};
      Real h[2](each start = 1, each fixed = true), v[2](each start = 0, each fixed = true);
      Integer n[2](each start = 0, each fixed = true);
    equation
      der(h) = v;
      for i in 1:2 loop
        der(v[i]) = -9.81;
        when h[i] < 0 then
          reinit(v[i], -e[i]*pre(v[i]));
          n[i] = pre(n[i]) + 1;
        end when;
      end for;
    end Balls;
    """
    result = run(text, 1.0, tolerance=1e-10)
    first = np.sqrt(2 / 9.81)
    speed = 9.81 * first
    for i, e in ((1, 0.5), (2, 0.7)):
        assert jumps(result, f"n[{i}]")[0] == (pytest.approx(first, abs=1e-9), 1)
        after = values(result, f"v[{i}]")[result.times > first + 1e-9][0]
        time = result.times[result.times > first + 1e-9][0] - first
        assert after == pytest.approx(e * speed - 9.81 * time, abs=1e-8)


DAMPED = """
model Damped
  Real h(start = 1, fixed = true), v(start = 0, fixed = true);
  Integer n(start = 0, fixed = true);
  Boolean high = h > 0.3;
equation
  der(h) = v;
  der(v) = -9.81 - 0.2*v;
  when h < 0 then
    reinit(v, -0.8*pre(v));
    n = pre(n) + 1;
  end when;
end Damped;
"""


@pytest.fixture(scope="module")
def by_ida() -> Any:
    return run(DAMPED, 2.0, tolerance=1e-9)


@pytest.mark.parametrize("solver", ["odes-ida", "odes-cvode", "radau"])
def test_all_solvers_find_the_same_events(solver: str, by_ida: Any) -> None:
    if solver.startswith("odes") and not HAVE_ODES:
        pytest.skip("needs the odes extra")
    result = run(DAMPED, 2.0, tolerance=1e-9, solver=solver)
    for name in ("n", "high"):
        expected, found = jumps(by_ida, name), jumps(result, name)
        assert [v for _, v in found] == [v for _, v in expected]
        assert [t for t, _ in found] == pytest.approx([t for t, _ in expected], abs=1e-7)
    assert last(result, "h") == pytest.approx(last(by_ida, "h"), abs=1e-6)


def test_two_runs_give_the_same_bytes() -> None:
    first, second = run(DAMPED, 2.0), run(DAMPED, 2.0)
    assert first.times.tobytes() == second.times.tobytes()
    for name in ("h", "v", "n", "high"):
        assert values(first, name).tobytes() == values(second, name).tobytes(), name
    assert first.events == second.events


DECLARATIONS = [
    "Real x(start = 0, fixed = true);",
    "Real y(start = 1, fixed = true);",
    "Boolean up(start = true, fixed = true);",
    "Integer n(start = 0, fixed = true);",
    "Integer m(start = 0, fixed = true);",
    "Real force;",
]
EQUATIONS = [
    "der(x) = force;",
    "der(y) = -y + (if x > 0.5 then 1 else 0);",
    "force = if up then 1 else -2;",
    "up = x < 0 or pre(up) and x < 1;",
    "when up then n = pre(n) + 1; end when;",
    "when {sample(0.3, 0.7), change(n)} then m = pre(m) + 1 + n; end when;",
]


def written(declarations: list[str], equations: list[str]) -> str:
    lines = ["model M", *declarations, "equation", *equations, "end M;"]
    return "\n".join(lines)


def test_hysteresis_oscillates_between_its_limits() -> None:
    result = run(written(DECLARATIONS, EQUATIONS), 5.0, tolerance=1e-10)
    expected = list(itertools.accumulate([1, 0.5, 1, 0.5, 1, 0.5]))
    assert [t for t, _ in jumps(result, "up")] == pytest.approx(expected, abs=1e-8)
    assert last(result, "n") == 3


@settings(max_examples=8, deadline=None)
@given(st.permutations(DECLARATIONS), st.permutations(EQUATIONS))
def test_the_order_of_writing_changes_nothing(declared: list[str], equations: list[str]) -> None:
    expected = run(written(DECLARATIONS, EQUATIONS), 3.0)
    result = run(written(declared, equations), 3.0)
    assert instants(result) == pytest.approx(instants(expected), abs=1e-7)
    for name in ("x", "y", "n", "m", "up"):
        assert last(result, name) == pytest.approx(last(expected, name), abs=1e-6), name


PENDULUM = """
model Pendulum
  parameter Real v0 = 7;
  Real x(start = 0, fixed = true), y(start = -1), vx(start = v0, fixed = true), vy, F;
  Integer turns(start = 0, fixed = true);
  Real last_turn(start = 0, fixed = true), period(start = 0, fixed = true);
equation
  x^2 + y^2 = 1;
  vx = der(x);
  vy = der(y);
  der(vx) = -F*x;
  der(vy) = -F*y - 9.81;
  when x > 0 and y < 0 then
    turns = pre(turns) + 1;
    last_turn = time;
    period = time - pre(last_turn);
  end when;
end Pendulum;
"""


def test_pendulum_goes_round_and_is_counted_at_the_bottom() -> None:
    # Period of a full turn: 4/w0 K(4 g/(l w0^2)), w0 the speed at the bottom.
    from scipy.special import ellipk

    w0 = 7.0
    expected = 4 / w0 * ellipk(4 * 9.81 / w0**2)
    result = run(PENDULUM, 10.0, tolerance=1e-9)
    # the first count is that of the start, when x > 0 becomes true
    assert last(result, "turns") == int(10.0 / expected) + 1
    assert last(result, "period") == pytest.approx(expected, rel=1e-6)
    radius = values(result, "x") ** 2 + values(result, "y") ** 2
    assert radius == pytest.approx(1, abs=1e-8)
    speed = np.hypot(values(result, "vx"), values(result, "vy"))
    energy = speed**2 / 2 + 9.81 * values(result, "y")
    assert energy == pytest.approx(w0**2 / 2 - 9.81, abs=1e-4)
