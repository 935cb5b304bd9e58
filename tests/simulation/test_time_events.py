"""Events whose time is known beforehand: hit exactly, to round-off."""

from __future__ import annotations

import numpy as np
import pytest

from tests.simulation.hybrid_runs import instants, jumps, last, run, sides, values

EXACT = 1e-13


def test_relations_that_are_linear_in_time_are_hit_exactly() -> None:
    text = """
    model M
      parameter Real t1 = 0.1, slope = 3, offset = 1/7;
      Real x(start = 0, fixed = true), y, z;
    equation
      y = if time > t1 then 1 else 0;
      z = if slope*time - offset >= 2*time + 0.3 then 1 else 0;
      der(x) = y + 2*z;
    end M;
    """
    result = run(text, 1.0)
    second = 0.3 + 1 / 7
    assert instants(result) == pytest.approx([0.1, second], rel=EXACT)
    assert last(result, "x") == pytest.approx(0.9 + 2 * (1 - second), rel=1e-12)
    assert sides(result, "y", 0.1) == (0, 1)
    assert sides(result, "z", second) == (0, 1)
    assert sides(result, "x", second) == pytest.approx((second - 0.1, second - 0.1), rel=1e-12)


def test_thresholds_that_change_at_events_are_scheduled_anew() -> None:
    text = """
    model Pulses
      Real next(start = 0.1, fixed = true);
      Integer n(start = 0, fixed = true);
    equation
      when time >= pre(next) then
        n = pre(n) + 1;
        next = pre(next) + 0.1*n;
      end when;
    end Pulses;
    """
    result = run(text, 6.0)
    times = [time for time, _ in jumps(result, "n")]
    expected = 0.1 + 0.1 * np.cumsum(np.arange(len(times)))
    assert len(times) == 11
    assert times == pytest.approx(expected, rel=EXACT)


def test_pulse_width_modulation_has_the_exact_duty() -> None:
    text = """
    model PWM
      parameter Real f = 1000, duty = 0.3;
      Boolean on = mod(time*f, 1) < duty;
      Real i(start = 0, fixed = true);
      Integer n(start = 0, fixed = true);
    equation
      der(i) = if on then 1 else 0;
      when not on then
        n = pre(n) + 1;
      end when;
    end PWM;
    """
    result = run(text, 1.0, points=3)
    assert last(result, "i") == pytest.approx(0.3, rel=1e-12)
    assert last(result, "n") == 1000
    off = np.array([time for time, value in jumps(result, "on") if value == 0])
    assert off == pytest.approx((np.arange(1000) + 0.3) / 1000, rel=EXACT)


def test_sample_with_offset() -> None:
    text = """
    model M
      Real x(start = 0, fixed = true), held(start = -1, fixed = true);
      Integer n(start = 0, fixed = true), m(start = 0, fixed = true), both(start = 0, fixed = true);
      Boolean early = sample(-0.9, 0.4);
    equation
      der(x) = 1;
      when sample(0.25, 0.1) then
        n = pre(n) + 1;
        held = x;
      end when;
      when early then
        m = pre(m) + 1;
      end when;
      when sample(0, 0.25) and sample(0, 0.75) then
        both = pre(both) + 1;
      end when;
    end M;
    """
    result = run(text, 1.6)
    assert [t for t, _ in jumps(result, "n")] == pytest.approx(
        [0.25 + 0.1 * k for k in range(14)], rel=EXACT
    )
    assert last(result, "held") == pytest.approx(1.55, rel=1e-9)
    assert [t for t, _ in jumps(result, "m")] == pytest.approx([0.3, 0.7, 1.1, 1.5], rel=1e-12)
    assert last(result, "both") == 3
    assert values(result, "n")[0] == 0


def test_sample_is_true_in_its_instant_only() -> None:
    text = """
    model M
      Boolean tick = sample(0.5, 0.5), seen(start = false, fixed = true);
      Integer ups(start = 0, fixed = true), downs(start = 0, fixed = true);
      Real x(start = 0, fixed = true);
    equation
      der(x) = if tick then 1e6 else 1;
      when tick then
        ups = pre(ups) + 1;
        seen = true;
      end when;
      when not tick then
        downs = pre(downs) + 1;
      end when;
    end M;
    """
    result = run(text, 2.2)
    assert last(result, "x") == pytest.approx(2.2, rel=1e-9)
    assert last(result, "ups") == 4
    assert last(result, "seen") == 1
    assert not values(result, "tick")[1:].all()


def test_ten_thousand_samples_do_not_drift() -> None:
    text = """
    model M
      Integer n(start = 0, fixed = true);
      Real t(start = 0, fixed = true);
    equation
      when sample(0.1, 0.1) then
        n = pre(n) + 1;
        t = time;
      end when;
    end M;
    """
    result = run(text, 1000.05, points=3)
    assert last(result, "n") == 10000
    assert last(result, "t") == pytest.approx(1000, rel=EXACT)
    assert np.diff(instants(result)) == pytest.approx(0.1, abs=1e-12)


STEPS = """
model Steps
  Real saw = mod(time, 0.25), tooth = rem(time, 0.25), whole = div(time, 0.25);
  Real down = floor(-time/0.25), up = ceil(time/0.25);
  Integer k = integer(time/0.25);
  Real negative = mod(-time, 0.25), signed = rem(-time, 0.25), area(start = 0, fixed = true);
equation
  der(area) = saw;
end Steps;
"""


@pytest.mark.parametrize(
    ("name", "before", "after"),
    [
        ("saw", 0.25, 0),
        ("tooth", 0.25, 0),
        ("whole", 1, 2),
        ("down", -2, -3),
        ("up", 2, 3),
        ("k", 1, 2),
        ("negative", 0, 0.25),
        ("signed", -0.25, 0),
    ],
)
def test_steps_of_time(name: str, before: float, after: float) -> None:
    result = run(STEPS, 1.1)
    # saw is an unknown of the solver, as der(area) needs it
    exact = 1e-9 if name == "saw" else 1e-13
    assert sides(result, name, 0.5) == pytest.approx((before, after), abs=exact)
    assert instants(result) == pytest.approx([0.25, 0.5, 0.75, 1], rel=EXACT)
    assert last(result, "area") == pytest.approx(4 * 0.25**2 / 2 + 0.1**2 / 2, rel=1e-7)


def test_steps_of_time_between_events() -> None:
    result = run(STEPS, 1.1, points=111)
    t = np.asarray(result.times)
    inside = np.abs(t / 0.25 - np.round(t / 0.25)) > 1e-9
    t = t[inside]
    expected = {
        "saw": t % 0.25,
        "tooth": t % 0.25,
        "whole": t // 0.25,
        "down": np.floor(-t / 0.25),
        "up": np.ceil(t / 0.25),
        "k": t // 0.25,
        "negative": -t % 0.25,
        "signed": -(t % 0.25),
    }
    for name, wanted in expected.items():
        assert values(result, name)[inside] == pytest.approx(wanted, abs=1e-9), name


def test_time_events_at_the_same_instant_are_one() -> None:
    text = """
    model M
      Integer n[4](each start = 0, each fixed = true), sum_(start = 0, fixed = true);
      Boolean a = time > 0.3, b = 10*time >= 3, c = time/3 > 0.1, d = sample(0.3, 5);
    equation
      when a then
        n[1] = pre(n[1]) + 1;
      end when;
      when b then
        n[2] = pre(n[2]) + 1;
      end when;
      when c then
        n[3] = pre(n[3]) + 1;
      end when;
      when d then
        n[4] = pre(n[4]) + 1;
      end when;
      when {a, b, c, d} then
        sum_ = pre(sum_) + sum(n);
      end when;
    end M;
    """
    result = run(text, 1.0)
    assert len(instants(result)) == 1
    assert [last(result, f"n[{k}]") for k in range(1, 5)] == [1] * 4
    assert last(result, "sum_") == 4


def test_events_at_start_and_stop() -> None:
    text = """
    model M
      Integer n(start = 0, fixed = true), m(start = 0, fixed = true);
      Real y = if time >= 1 then 2 else 1, z = if time > 0 then 2 else 1;
    equation
      when sample(0, 0.5) then
        n = pre(n) + 1;
      end when;
      when time >= 1 then
        m = pre(m) + 1;
      end when;
    end M;
    """
    result = run(text, 1.0)
    assert values(result, "n")[0] == 1
    assert last(result, "n") == 3
    assert last(result, "m") == 1
    assert sides(result, "y", 1.0) == (1, 2)
    assert last(result, "z") == 2
