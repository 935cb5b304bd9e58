"""Consistent starts: physics with known answers, and messages for those that have none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from flat_builder import FlatBuilder, S, T, call, t
from hypothesis import given, settings
from hypothesis import strategies as st

from acausal.diagnostics import AcausalError
from acausal.expressions import build
from acausal.initialization.homotopy import newton_homotopy
from acausal.initialization.newton import Outcome, solve
from acausal.initialization.start import consistent_restart, initialize, prepare_restart
from acausal.initialization.system import StartSystem


def system_of(b: FlatBuilder, states) -> StartSystem:
    model = b.build()
    return StartSystem(
        model.families,
        model.n_rows,
        model.initial,
        model.n_initial,
        model.variables,
        model.derivative,
        np.asarray(states, dtype=np.int64),
        model.parameters,
        model.names,
    )


def error_of(system: StartSystem):
    with pytest.raises(AcausalError) as caught:
        initialize(system)
    return caught.value.diagnostics[0]


def rc(**attributes):
    """R*i = u - v, C*der(v) = i, u = 10."""
    b = FlatBuilder()
    v = b.variable("c.v", **attributes)
    i = b.variable("r.i")
    dv = b.der(v)
    R, C = b.parameter("R", 100.0), b.parameter("C", 1e-6)
    b.equation(S[0] * S[1] - 10 + S[2], R, i, v, parameters=[0], text="R*i = 10 - v")
    b.equation(S[0] * S[1] - S[2], C, dv, i, parameters=[0], text="C*der(v) = i")
    return b, v, i, dv


def test_rc_from_a_fixed_start():
    b, v, i, dv = rc(start=2.0, fixed=True)
    start = initialize(system_of(b, [v]))
    np.testing.assert_allclose(start.values[[v, i, dv]], [2.0, 0.08, 8e4])
    assert start.pinned.tolist() == [v]
    assert start.chosen.size == 0
    assert not start.notes
    assert not start.warnings


def test_written_start_is_taken_with_a_note():
    b, v, i, _ = rc(start=2.0)
    start = initialize(system_of(b, [v]))
    assert start.values[i] == pytest.approx(0.08)
    assert start.chosen.tolist() == [v]
    assert "c.v(start = 2)" in start.notes[0]
    assert not start.warnings


def test_default_start_is_taken_with_a_warning():
    b, v, i, _ = rc()
    start = initialize(system_of(b, [v]))
    assert start.values[i] == pytest.approx(0.1)
    (warning,) = start.warnings
    assert warning.code == "I101"
    assert "c.v" in warning.message


def test_steady_state_by_initial_equation():
    b, v, i, dv = rc(start=3.0)
    b.initial(S[0], dv, text="der(c.v) = 0")
    start = initialize(system_of(b, [v]))
    np.testing.assert_allclose(start.values[[v, i, dv]], [10.0, 0.0, 0.0], atol=1e-9)
    assert start.pinned.size == 0


def test_contradicting_conditions_are_named():
    b, v, _, dv = rc(start=2.0, fixed=True)
    b.initial(S[0], dv, text="der(c.v) = 0")
    diagnostic = error_of(system_of(b, [v]))
    assert diagnostic.code == "I010"
    text = " ".join([diagnostic.message, *diagnostic.notes])
    assert "c.v(start = 2, fixed = true)" in text
    assert "der(c.v) = 0" in text


def test_redundant_conditions_that_agree_are_accepted():
    b, v, i, dv = rc(start=10.0, fixed=True)
    b.initial(S[0], dv, text="der(c.v) = 0")
    start = initialize(system_of(b, [v]))
    assert start.values[i] == pytest.approx(0.0, abs=1e-12)


def test_two_fixed_starts_for_one_degree_of_freedom():
    b, v, i, _ = rc(start=2.0, fixed=True)
    b.attributes[1] |= {"start": 0.5, "fixed": True}
    diagnostic = error_of(system_of(b, [v]))
    assert diagnostic.code == "I010"
    assert "r.i(start = 0.5, fixed = true)" in " ".join([diagnostic.message, *diagnostic.notes])
    b.attributes[1] |= {"start": 0.08}
    assert initialize(system_of(b, [v])).values[i] == pytest.approx(0.08)


def test_underdetermined_start_names_what_is_free():
    b = FlatBuilder()
    x, y = b.variable("left.x"), b.variable("right.x")
    dx, dy = b.der(x), b.der(y)
    b.equation(S[0] - t, dx)
    b.equation(S[0] + S[1], dy, y)
    diagnostic = error_of(system_of(b, [y]))
    assert diagnostic.code == "I011"
    assert "left.x" in diagnostic.message


def pendulum(states=("x", "vx"), **starts):
    """x'' = -F x, y'' = -F y - g, x^2 + y^2 = L^2 with its first and second derivative."""
    b = FlatBuilder()
    ids = {}
    for name in ("x", "y"):
        ids[name] = b.variable(name, **starts.get(name, {}))
    for name, of in (("vx", "x"), ("vy", "y"), ("ax", "vx"), ("ay", "vy")):
        ids[name] = b.der(ids[of])
        b.names[ids[name]] = name
        b.attributes.append({"ids": np.array([ids[name]]), **starts.get(name, {})})
    ids["F"] = b.variable("F")
    g, L = b.parameter("g", 9.81), b.parameter("L", 1.0)
    b.equation(S[0] + S[1] * S[2], ids["ax"], ids["F"], ids["x"])
    last = S[0] + S[1] * S[2] + S[3]
    b.equation(last, ids["ay"], ids["F"], ids["y"], g, parameters=[3])
    x, y, vx, vy, ax, ay = (ids[k] for k in ("x", "y", "vx", "vy", "ax", "ay"))
    circle = S[0] * S[0] + S[1] * S[1] - S[2] * S[2]
    b.equation(circle, x, y, L, parameters=[2], text="x^2 + y^2 = L^2")
    b.equation(2 * S[0] * S[2] + 2 * S[1] * S[3], x, y, vx, vy)
    second = 2 * (S[0] * S[4] + S[2] * S[2] + S[1] * S[5] + S[3] * S[3])
    b.equation(second, x, y, vx, vy, ax, ay)
    return system_of(b, [ids[k] for k in states]), ids


NAMES = ("x", "y", "vx", "vy", "ax", "ay", "F")


def check_pendulum(start, ids):
    x, y, vx, vy, ax, ay, F = (
        start.values[ids[k]] for k in ["x", "y", "vx", "vy", "ax", "ay", "F"]
    )
    assert x * x + y * y == pytest.approx(1.0, abs=1e-9)
    assert x * vx + y * vy == pytest.approx(0.0, abs=1e-9)
    assert [ax, ay] == pytest.approx([-F * x, -F * y - 9.81], abs=1e-8)
    assert (vx * vx + vy * vy) - 9.81 * y == pytest.approx(F, abs=1e-7)


def test_pendulum_with_x_given_finds_the_lower_point():
    system, ids = pendulum(x={"start": 0.6, "fixed": True}, y={"start": -1.0})
    start = initialize(system)
    check_pendulum(start, ids)
    assert start.values[[ids["x"], ids["y"]]] == pytest.approx([0.6, -0.8])


def test_pendulum_without_a_guess_for_y():
    """The Jacobian is singular at y = 0."""
    system, ids = pendulum(x={"start": 0.6, "fixed": True}, vx={"start": 0.5})
    start = initialize(system)
    check_pendulum(start, ids)
    assert abs(start.values[ids["y"]]) == pytest.approx(0.8)
    assert start.values[ids["vx"]] == pytest.approx(0.5)


def test_horizontal_pendulum_is_pinned_by_its_height():
    """At (1, 0) the structure lets x be pinned, the numbers do not."""
    system, ids = pendulum(x={"start": 1.0}, y={"start": 0.0})
    start = initialize(system)
    check_pendulum(start, ids)
    assert start.values[[ids["x"], ids["y"]]] == pytest.approx([1.0, 0.0], abs=1e-9)
    assert ids["y"] in start.pinned


def test_impossible_pendulum():
    system, _ = pendulum(x={"start": 2.0, "fixed": True}, y={"start": -1.0})
    diagnostic = error_of(system)
    assert diagnostic.code in ("I020", "I021")
    assert "y" in diagnostic.message
    assert "x^2 + y^2 = L^2" in " ".join([diagnostic.label, *diagnostic.notes])


@given(st.floats(-3.1, 3.1), st.floats(-5, 5))
@settings(max_examples=40, deadline=None)
def test_any_pendulum(angle, speed):
    x, y = np.sin(angle), -np.cos(angle)
    states = ("x", "vx") if abs(y) > 0.1 else ("y", "vy")
    vx, vy = -y * speed, x * speed
    system, ids = pendulum(
        states=states,
        x={"start": x, "fixed": states[0] == "x"},
        y={"start": y, "fixed": states[0] == "y"},
        vx={"start": vx, "fixed": states[0] == "x"},
        vy={"start": vy, "fixed": states[0] == "y"},
    )
    start = initialize(system)
    check_pendulum(start, ids)
    assert start.values[ids["F"]] == pytest.approx(speed**2 - 9.81 * y, abs=1e-6)


def test_diode_and_resistor():
    """10 V over 1 kOhm and a diode: the answer is in Lambert's W."""
    from scipy.special import lambertw

    b = FlatBuilder()
    v, i = b.variable("d.v"), b.variable("d.i")
    Is = b.parameter("Is", 1e-12)
    b.equation(S[0] - S[1] * (call("exp", S[2] / 0.025) - 1), i, Is, v, parameters=[1])
    b.equation(1000 * S[0] + S[1] - 10, i, v)
    start = initialize(system_of(b, []))
    w = lambertw(1e-12 * 1000 / 0.025 * np.exp((10 + 1e-9) / 0.025)).real
    np.testing.assert_allclose(start.values[i], 0.025 / 1000 * w - 1e-12, rtol=1e-8)


def test_newton_is_invariant_to_row_scaling():
    results = []
    for factor in (1.0, 1e9):
        b = FlatBuilder()
        x, y = b.variable("x", start=3.0), b.variable("y", start=-1.0)
        b.equation(factor * (call("exp", S[0]) - S[1] - 5), x, y)
        b.equation(S[0] * S[1] - 1 + S[0], y, x)
        results.append(initialize(system_of(b, [])).values)
    np.testing.assert_allclose(results[0], results[1], rtol=1e-9)


def homotopy_model():
    """Newton's method on the actual equation runs away from every default guess."""
    b = FlatBuilder()
    x = b.variable("x", start=20.0)
    actual = call("atan", 1000 * (S[0] - 2)) + 1e-3 * (S[0] - 2)
    simplified = S[0] - 1
    b.equation(T(build.homotopy(actual.expr, simplified.expr)), x, text="homotopy")
    return b, x


def test_homotopy_operator_leads_to_the_solution():
    b, x = homotopy_model()
    start = initialize(system_of(b, []))
    assert start.values[x] == pytest.approx(2.0)


def test_newton_homotopy_alone():
    class Atan:
        indptr = np.array([0, 1])
        indices = np.array([0], dtype=np.int32)
        scale = np.array([1.0])
        minimum = np.array([-np.inf])
        maximum = np.array([np.inf])

        def residual(self, x):
            return x**3 - 2 * x + 2

        def jacobian(self, x):
            return 3 * x**2 - 2

    path = newton_homotopy(Atan(), np.array([-3.0]))
    assert path.arrived
    np.testing.assert_allclose(path.result.x, -1.769292354238631)


def test_newton_cycle_is_broken_by_damping():
    """x^3 - 2 x + 2 from 0 cycles between 0 and 1 without damping."""
    b = FlatBuilder()
    x = b.variable("x", start=0.0)
    b.equation(S[0] * S[0] * S[0] - 2 * S[0] + 2, x)
    assert initialize(system_of(b, [])).values[x] == pytest.approx(-1.769292354238631)


def test_division_by_zero_at_the_start_is_left_when_possible():
    b = FlatBuilder()
    x, y = b.variable("x"), b.variable("y")
    b.equation(1 / S[0] - S[1], x, y)
    b.equation(S[0] - 4, y)
    assert initialize(system_of(b, [])).values[x] == pytest.approx(0.25)


def test_division_by_zero_that_is_certain_is_explained():
    b = FlatBuilder()
    x = b.variable("mass.x", start=0.0, fixed=True)
    y = b.variable("force.f")
    dx = b.der(x)
    b.equation(S[0] - 1 / S[1], y, x, text="f = 1/x")
    b.equation(S[0] - S[1], dx, y)
    diagnostic = error_of(system_of(b, [x]))
    assert diagnostic.code == "I030"
    assert "division by zero: mass.x is 0" in diagnostic.message
    assert "f = 1/x" in " ".join([diagnostic.label, *diagnostic.notes])
    assert diagnostic.span is not None


def test_eliminated_variable_without_a_finite_value():
    from acausal.elimination.eliminate import eliminate

    b = FlatBuilder()
    x, y = b.variable("x", start=0.0, fixed=True), b.variable("y")
    b.equation(S[0] - 1, b.der(x), text="der(x) = 1")
    b.equation(S[0] - 1 / S[1], y, x, text="y = 1/x")
    reduced = eliminate(b.build())
    system = system_of(b, [x])
    system = replace(
        system,
        families=reduced.model.families,
        n_rows=reduced.model.n_rows,
        definitions=reduced.definitions,
    )
    diagnostic = error_of(system)
    assert diagnostic.code == "I030"
    assert diagnostic.message == "division by zero: x is 0 at t = 0 s"
    assert diagnostic.label == "y = 1/x in part[0]"


def test_logarithm_outside_its_domain():
    b = FlatBuilder()
    p, x = b.parameter("p", -2.0), b.variable("x")
    b.equation(S[0] - call("log", S[1]), x, p, parameters=[1], text="x = log(p)")
    diagnostic = error_of(system_of(b, []))
    assert diagnostic.code == "I030"
    assert "log(p) with p = -2" in diagnostic.message


def test_singular_equations():
    b = FlatBuilder()
    x, y = b.variable("x"), b.variable("y")
    b.equation(S[0] + S[1] - 1, x, y, text="x + y = 1")
    b.equation(2 * S[0] + 2 * S[1] - 5, x, y, text="2*x + 2*y = 5")
    diagnostic = error_of(system_of(b, []))
    assert diagnostic.code in ("I020", "I021")
    assert "x, y" in diagnostic.message


def test_nearest_of_several_solutions():
    for guess in (-1.5, 0.2, 3.0):
        b = FlatBuilder()
        x = b.variable("x", start=guess)
        b.equation(S[0] * (S[0] - 2) * (S[0] + 1), x)
        found = initialize(system_of(b, [])).values[x]
        assert abs(found - guess) == pytest.approx(min(abs(r - guess) for r in (0, 2, -1)))


def test_restart_keeps_the_states():
    system, ids = pendulum(x={"start": 0.6, "fixed": True}, y={"start": -1.0})
    start = initialize(system)
    values = start.values.copy()
    states = np.array([ids["x"], ids["vx"]])
    values[states] = [-0.6, 2.0]
    restart = prepare_restart(system, states)
    found = restart.solve(values, 0.0)
    np.testing.assert_allclose(found[states], [-0.6, 2.0])
    assert found[ids["y"]] == pytest.approx(-0.8)
    np.testing.assert_allclose(consistent_restart(system, values, 0.0, states), found)
    # other states: the same motion told by y
    other = np.array([ids["y"], ids["vy"]])
    np.testing.assert_allclose(consistent_restart(system, found, 0.0, other), found, atol=1e-9)


def test_large_system_is_solved_as_a_whole():
    n = 20_000
    b = FlatBuilder(named=False)
    v = b.variables("v", n, start=0.0, fixed=True)
    i = b.variables("i", n)
    dv = b.der(v)
    b.equation(S[0] - (call("exp", S[1]) - 1) - S[2], i[1:], i[1:] * 0 + v[1:], i[:-1])
    b.equation(S[0] - 1, i[:1])
    b.equation(S[0] - S[1], dv, i)
    start = initialize(system_of(b, v))
    np.testing.assert_allclose(start.values[i], 1.0)
    assert start.statistics.blocks == 0


def test_time_enters():
    b = FlatBuilder()
    x = b.variable("x")
    b.equation(S[0] - 3 * t, x)
    assert initialize(system_of(b, []), time=2.0).values[x] == 6.0


def test_newton_reports_what_stopped_it():
    class Quadratic:
        indptr = np.array([0, 1])
        indices = np.array([0], dtype=np.int32)
        scale = np.array([1.0])
        minimum = np.array([-np.inf])
        maximum = np.array([np.inf])

        def residual(self, x):
            return x * x + 1

        def jacobian(self, x):
            return 2 * x

    assert solve(Quadratic(), np.array([0.0])).outcome is Outcome.SINGULAR
    assert not solve(Quadratic(), np.array([0.5])).converged
