"""Interpolation at any time with the solver's own polynomial."""

from __future__ import annotations

import numpy as np
import pytest

import acausal as ac

OSCILLATOR = """
model Oscillator
  Real x(start = 1, fixed = true);
  Real v(start = 0, fixed = true);
  Real energy = 0.5*(x^2 + v^2);
equation
  der(x) = v;
  der(v) = -x;
end Oscillator;
"""
BALL = """
model Ball
  Real h(start = 1, fixed = true, unit = "m");
  Real v(start = 0, fixed = true, unit = "m/s");
  discrete Integer bounces(start = 0, fixed = true);
equation
  der(h) = v;
  der(v) = -9.81[m/s2];
  when h < 0 then
    reinit(v, -0.8*pre(v));
    bounces = pre(bounces) + 1;
  end when;
end Ball;
"""
PENDULUM = """
model Pendulum
  Real x(start = 1, fixed = true);
  Real y(start = 0);
  Real vx(start = 0, fixed = true);
  Real vy;
  Real tension;
equation
  der(x) = vx;
  der(y) = vy;
  der(vx) = -tension*x;
  der(vy) = -tension*y - 9.81;
  x^2 + y^2 = 1;
end Pendulum;
"""


@pytest.mark.parametrize("solver", ["ida", "radau"])
def test_between_two_points_it_is_as_exact_as_the_run(solver):
    run = ac.compile_text(OSCILLATOR).simulate(
        stop_time=10.0, points=3, dense=True, tolerance=1e-8, solver=solver
    )
    times = np.linspace(0, 10, 999)
    np.testing.assert_allclose(run["x"](times), np.cos(times), atol=2e-6)
    np.testing.assert_allclose(run.at(times, "der(x)"), -np.sin(times), atol=1e-5)
    np.testing.assert_allclose(run.at(times, "energy"), 0.5, atol=2e-6)
    np.testing.assert_allclose(run.at(times, "x*x + v*v"), 1.0, atol=4e-6)
    assert len(run.times) == 3
    peak = (run["x"] * 2).min()
    assert peak.time == pytest.approx(10.0, abs=3.2)
    linear = ac.compile_text(OSCILLATOR).simulate(stop_time=10.0, points=3)
    assert abs(linear["x"](2.5) - np.cos(2.5)) > 0.1


def test_it_meets_what_a_finer_output_stores():
    compiled = ac.compile_text(OSCILLATOR)
    coarse = compiled.simulate(stop_time=5.0, points=2, dense=True)
    fine = compiled.simulate(stop_time=5.0, points=777)
    assert coarse.statistics["steps"] == fine.statistics["steps"]
    np.testing.assert_allclose(coarse["x"](fine.times), fine["x"].values, atol=1e-13)
    np.testing.assert_allclose(coarse["energy"](fine.times), fine["energy"].values, atol=1e-13)


def test_both_sides_of_an_event():
    run = ac.compile_text(BALL).simulate(stop_time=1.5, points=4, dense=True)
    hit = np.sqrt(2 / 9.81)
    jumps = run["v"].jumps()
    assert len(jumps) == 2
    assert jumps[0].time == pytest.approx(hit, abs=1e-6)
    for jump in jumps:
        assert run.at(jump.time, "v", side="before") == pytest.approx(jump.before, abs=1e-9)
        assert run.at(jump.time, "v") == pytest.approx(jump.after, abs=1e-9)
        assert jump.after == pytest.approx(-0.8 * jump.before, rel=1e-9)
    (first, second) = (jump.time for jump in jumps)
    assert run.at(first, "bounces", side="before") == 0
    assert run.at(first, "bounces") == 1
    middle = 0.5 * (first + second)
    assert run.at(middle, "bounces") == 1
    after = 0.8 * 9.81 * hit
    exact = after * (middle - first) - 0.5 * 9.81 * (middle - first) ** 2
    assert run.at(middle, "h") == pytest.approx(exact, abs=1e-6)
    both = run.at([0.1, 0.2], "h", "v")
    np.testing.assert_allclose(both["v"], [-0.981, -1.962], atol=1e-6)


def test_algebraic_unknowns_and_changes_of_states():
    run = ac.compile_text(PENDULUM).simulate(stop_time=3.0, points=5, dense=True)
    times = np.linspace(0, 3, 301)
    found = run.at(times, "x", "y", "vx", "vy", "tension")
    np.testing.assert_allclose(found["x"] ** 2 + found["y"] ** 2, 1, atol=1e-9)
    np.testing.assert_allclose(found["x"] * found["vx"] + found["y"] * found["vy"], 0, atol=1e-8)
    speed = found["vx"] ** 2 + found["vy"] ** 2
    np.testing.assert_allclose(found["tension"], speed - 9.81 * found["y"], atol=1e-6)


def test_the_ends_and_outside():
    run = ac.compile_text(BALL).simulate(stop_time=0.3, points=2, dense=True)
    assert run.at(0.0, "h") == 1.0
    assert run.at(0.3, "h") == run["h"].values[-1]
    assert run["h"].sampled([0.1, 0.2]).values.shape == (2,)
    with pytest.raises(ac.AcausalError) as error:
        run.at(0.31, "h")
    assert error.value.diagnostics[0].code == "F211"
