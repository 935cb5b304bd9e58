"""What happens in one instant: Modelica 3.6, section 8.3.5 and appendix B, on small models."""

from __future__ import annotations

import numpy as np
import pytest

from tests.simulation.hybrid_runs import instants, jumps, last, run, sides, values

CHAIN = """
model Chain
  Real x(start = 0, fixed = true);
  Integer a, b, c, by_edge, by_change, down;
  Real ta(start = -1, fixed = true), tc(start = -1, fixed = true);
  Boolean big = x > 1;
equation
  der(x) = if time < 1.5 then 1 else -1;
  when c >= 1 then
    tc = time;
  end when;
  when b >= 1 then
    c = pre(c) + 1;
  end when;
  when a >= 1 then
    b = pre(b) + 1;
  end when;
  when big then
    a = pre(a) + 1;
    ta = time;
  end when;
  when edge(big) then
    by_edge = pre(by_edge) + 1;
  end when;
  when change(big) then
    by_change = pre(by_change) + 1;
  end when;
  when not big then
    down = pre(down) + 1;
  end when;
end Chain;
"""


def test_one_event_causes_the_next_in_the_same_instant() -> None:
    result = run(CHAIN, 3.0)
    for name in ("a", "b", "c", "by_edge", "down"):
        assert last(result, name) == 1, name
    assert last(result, "by_change") == 2
    assert last(result, "ta") == last(result, "tc") == pytest.approx(1, rel=1e-12)
    assert instants(result) == pytest.approx([1, 1.5, 2], rel=1e-12)
    assert [value for _, value in jumps(result, "by_change")] == [1, 2]


def test_a_condition_that_is_true_from_the_start_does_not_act() -> None:
    text = """
    model M
      Real x(start = 2, fixed = true);
      Integer n, m;
    equation
      der(x) = if time < 1 then -2 else 2;
      when x > 1 then
        n = pre(n) + 1;
      end when;
      when x < 3 then
        m = pre(m) + 1;
      end when;
    end M;
    """
    result = run(text, 3.0)
    assert jumps(result, "n") == [(pytest.approx(1.5, abs=1e-9), 1)]
    assert last(result, "m") == 0


def test_the_first_of_several_branches_acts() -> None:
    text = """
    model M
      Real x(start = 0, fixed = true);
      Integer n, m;
    equation
      der(x) = 1;
      when x > 1 then
        n = 1;
      elsewhen x >= 1 then
        n = 2;
      elsewhen x > 1.5 then
        n = 3;
      end when;
    algorithm
      when x > 1.5 then
        m := 10*pre(m) + 1;
      elsewhen {x > 1, x > 1.7} then
        m := 10*pre(m) + 2;
      end when;
    end M;
    """
    result = run(text)
    assert [value for _, value in jumps(result, "n")] == [1, 3]
    assert [value for _, value in jumps(result, "m")] == [2, 21, 212]


def test_any_of_several_conditions_acts() -> None:
    text = """
    model M
      Real x(start = 0, fixed = true);
      Integer n, both;
    equation
      der(x) = 1;
      when {x > 0.5, x > 1, sample(0.75, 1), x > 1.0} then
        n = pre(n) + 1;
      end when;
      when x > 0.5 and x > 1 then
        both = pre(both) + 1;
      end when;
    end M;
    """
    result = run(text)
    assert [time for time, _ in jumps(result, "n")] == pytest.approx([0.5, 0.75, 1, 1.75])
    assert jumps(result, "both") == [(pytest.approx(1), 1)]


def test_whens_read_each_other_in_the_order_of_their_dependence() -> None:
    # b needs the new a, c the old b; written in the wrong order on purpose.
    text = """
    model M
      Boolean tick = sample(1, 1);
      Real a(start = 1, fixed = true), b(start = 0, fixed = true), c(start = 0, fixed = true);
    equation
      when tick then
        c = pre(b);
      end when;
      when tick then
        b = 2*a;
      end when;
      when tick then
        a = pre(a) + 1;
      end when;
    end M;
    """
    result = run(text, 3.5)
    assert [value for _, value in jumps(result, "a")] == [2, 3, 4]
    assert [value for _, value in jumps(result, "b")] == [4, 6, 8]
    assert [value for _, value in jumps(result, "c")] == [4, 6]


def test_ripple_counter_settles_in_one_instant() -> None:
    text = """
    model Ripple
      parameter Integer n = 8;
      Boolean bit[n](each start = false, each fixed = true);
      Integer value, falls;
    equation
      when sample(1, 1) then
        bit[1] = not pre(bit[1]);
      end when;
      for i in 2:n loop
        when not bit[i - 1] then
          bit[i] = not pre(bit[i]);
        end when;
      end for;
      value = sum({if bit[i] then integer(2^(i - 1)) else 0 for i in 1:n});
      when not bit[n] then
        falls = pre(falls) + 1;
      end when;
    end Ripple;
    """
    result = run(text, 300.5, points=11)
    assert jumps(result, "value") == [(k, k % 256) for k in range(1, 301)]
    assert last(result, "falls") == 1


def test_pre_of_real_discrete_and_continuous_variables() -> None:
    text = """
    model M
      Real x(start = 1, fixed = true), y, left(start = 0, fixed = true);
      Real right(start = 0, fixed = true), left_y(start = 0, fixed = true);
      Integer k(start = 0, fixed = true), before(start = 0, fixed = true);
    equation
      der(x) = -1;
      y = if k > 0 then 10*x else x;
      when x < 0.25 then
        k = pre(k) + 1;
        before = pre(k);
        reinit(x, pre(x) + k);
        left = pre(x);
        left_y = pre(y);
      end when;
      when change(k) then
        right = y;
      end when;
    end M;
    """
    result = run(text, 4.0)
    first, second = 0.75, 1.75
    assert sides(result, "x", first) == pytest.approx((0.25, 1.25), abs=1e-9)
    assert sides(result, "x", second) == pytest.approx((0.25, 2.25), abs=1e-9)
    assert sides(result, "y", first) == pytest.approx((0.25, 12.5), abs=1e-8)
    assert sides(result, "y", second) == pytest.approx((2.5, 22.5), abs=1e-8)
    assert sides(result, "left_y", first)[1] == pytest.approx(0.25, abs=1e-9)
    assert sides(result, "left_y", second)[1] == pytest.approx(2.5, abs=1e-8)
    assert last(result, "k") == 3
    assert last(result, "before") == 2
    assert last(result, "left") == pytest.approx(0.25, abs=1e-9)


def test_ten_relations_cross_at_the_same_time() -> None:
    text = """
    model M
      Real x[10](each start = 0, each fixed = true);
      Integer n[10], total, hits;
    equation
      for i in 1:10 loop
        der(x[i]) = i;
        when x[i] > i then
          n[i] = pre(n[i]) + 1;
        end when;
      end for;
      total = sum(n);
      when total >= 10 then
        hits = pre(hits) + 1;
      end when;
    end M;
    """
    result = run(text)
    assert [last(result, f"n[{i}]") for i in range(1, 11)] == [1] * 10
    assert last(result, "hits") == 1
    assert last(result, "total") == 10
    # what lies within round-off of each other may be a few events, at one time
    assert np.ptp(instants(result)) < 1e-12


def test_initial_and_terminal_act_once() -> None:
    text = """
    model M
      Real x(start = 1, fixed = true);
      Real a(start = 0, fixed = true), b(start = 0, fixed = true), y, z;
      Integer n(start = 0, fixed = true), m(start = 5, fixed = true);
    equation
      der(x) = -x;
      when initial() then
        a = x;
      end when;
      when terminal() then
        b = x;
      end when;
      when {initial(), terminal(), x < 0.5} then
        n = pre(n) + 1;
      end when;
      when initial() then
        m = pre(m) + 1;
      elsewhen x < 0.5 then
        m = 0;
      end when;
      y = if initial() then 7 else x;
      z = if n > 2 then 1 else 0;
    end M;
    """
    result = run(text)
    assert values(result, "a")[0] == last(result, "a") == 1
    assert values(result, "b")[-2] == 0
    assert last(result, "b") == pytest.approx(np.exp(-2), abs=1e-6)
    assert values(result, "n")[0] == 1
    assert last(result, "n") == 3
    assert last(result, "z") == 1
    assert values(result, "m")[0] == 6
    assert last(result, "m") == 0
    assert values(result, "y")[0] == 1


def test_terminate_ends_the_run_at_the_instant() -> None:
    text = """
    model M
      Real x(start = 1, fixed = true);
    equation
      der(x) = -x;
      when x < 0.5 then
        terminate("half is gone");
      end when;
    end M;
    """
    result = run(text, ending="terminated", tolerance=1e-10)
    assert result.times[-1] == pytest.approx(np.log(2), abs=1e-9)
    assert "half is gone" in result.events[-1].text
    assert last(result, "x") == pytest.approx(0.5, abs=1e-9)


ASSERTION = """
model M
  Real x(start = 1, fixed = true);
  Integer n(start = 0, fixed = true);
equation
  der(x) = -x;
  when x < 0.5 then
    n = pre(n) + 1;
    assert(x > 0.6, "too low"LEVEL);
  end when;
end M;
"""


def test_assertion_in_a_when_is_looked_at_in_its_instant() -> None:
    result = run(ASSERTION.replace("LEVEL", ""), ending="failed")
    assert result.times[-1] == pytest.approx(np.log(2), abs=1e-6)
    (found,) = result.diagnostics
    assert found.code == "R020"
    assert "too low" in found.message
    assert found.span is not None and found.span.line == 9
    warned = run(ASSERTION.replace("LEVEL", ", AssertionLevel.warning"))
    assert [d.code for d in warned.diagnostics] == ["R021"]
    assert warned.times[-1] == 2.0


def test_initial_equations_of_discrete_variables() -> None:
    text = """
    model M
      Boolean b, c;
      Integer n, seen;
      Real x(start = 3, fixed = true), held;
    equation
      der(x) = -1;
      when x < 1 then
        n = pre(n) + 1;
        b = not pre(b);
        held = x;
      end when;
      when c then
        seen = pre(seen) + 1;
      end when;
      c = x < 2;
    initial equation
      pre(n) = 4;
      b = true;
      held = 2*x;
    end M;
    """
    result = run(text, 3.0)
    assert values(result, "n")[0] == 4
    assert last(result, "n") == 5
    assert values(result, "b")[0] == 1
    assert last(result, "b") == 0
    assert values(result, "held")[0] == 6
    assert last(result, "held") == pytest.approx(1, abs=1e-9)
    assert last(result, "seen") == 1


def test_enumerations_make_state_machines() -> None:
    text = """
    type Light = enumeration(red, green, amber);
    model M
      Light light(start = Light.red, fixed = true);
      Integer cycles(start = 0, fixed = true);
      Real t0(start = 0, fixed = true);
    equation
      when pre(light) == Light.red and time > pre(t0) + 3 then
        light = Light.green;
        t0 = time;
      elsewhen pre(light) == Light.green and time > pre(t0) + 2 then
        light = Light.amber;
        t0 = time;
      elsewhen pre(light) == Light.amber and time > pre(t0) + 0.5 then
        light = Light.red;
        t0 = time;
      end when;
      when light == Light.red then
        cycles = pre(cycles) + 1;
      end when;
    end M;
    """
    result = run(text, 20.0)
    found = jumps(result, "light")
    expected = [c * 5.5 + t for c in range(4) for t in (3, 5, 5.5)]
    expected = [t for t in expected if t < 20]
    assert [t for t, _ in found] == pytest.approx(expected, rel=1e-13)
    assert [v for _, v in found] == ([2, 3, 1] * 4)[: len(expected)]
    assert last(result, "cycles") == 3
