"""Roots of compiled functions, with every integrator."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rooted import ball, clock, logarithm, rectifier, sine_of_time

from acausal.codegen.driver import NativeProblem
from acausal.solvers.protocol import Integrator, Options, Status, create

TIGHT = Options(relative_tolerance=1e-9, absolute_tolerance=1e-11)


def until_root(integrator: Integrator, limit: float) -> Status:
    while True:
        result = integrator.step(limit)
        assert result.status is not Status.FAILED, result.failure
        if result.status is not Status.STEPPED:
            return result.status


def thrown(solver: str, height: float = 1.0, options: Options = TIGHT) -> Integrator:
    return create(
        solver,
        ball(),
        0.0,
        np.array([height, 0.0, -9.81]),
        np.array([0.0, -9.81, 0.0]),
        options,
    )


def test_time_of_fall(solver):
    integrator = thrown(solver)
    assert until_root(integrator, 10.0) is Status.ROOT
    time = math.sqrt(2.0 / 9.81)
    assert integrator.t == pytest.approx(time, abs=1e-12 if solver == "ida" else 1e-7)
    np.testing.assert_array_equal(integrator.roots_found, [-1])
    assert abs(integrator.y[0]) < 1e-12
    assert integrator.y[2] == pytest.approx(-9.81)
    assert integrator.y[1] == pytest.approx(-9.81 * time, rel=1e-6)


def test_bounces_by_restarts(solver):
    integrator = thrown(solver)
    integrator.set_root_directions(np.array([-1], np.int32))
    times = []
    for _ in range(4):
        assert until_root(integrator, 10.0) is Status.ROOT
        times.append(integrator.t)
        y, yp = integrator.y.copy(), integrator.yp.copy()
        y[0], y[1] = 0.0, -0.5 * y[1]
        assert integrator.consistent(integrator.t, y, yp) >= 0
        np.testing.assert_allclose(yp[:2], [y[1], -9.81])
        integrator.restart(integrator.t, y, yp)
    fall = math.sqrt(2.0 / 9.81)
    known = fall * (1.0 + 2.0 * np.cumsum([0.0, 0.5, 0.25, 0.125]))
    np.testing.assert_allclose(times, known, rtol=1e-7)


def test_goes_on_after_a_root_without_restart(solver):
    integrator = create(solver, clock(3), 0.0, np.zeros(1), np.ones(1))
    found = []
    while until_root(integrator, 1.9) is Status.ROOT:
        found.append((integrator.t, integrator.roots_found.tolist()))
    np.testing.assert_allclose([t for t, _ in found], [0.5, 1.0, 1.5], rtol=1e-9)
    assert [f for _, f in found] == [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    assert integrator.t == 1.9


def test_several_roots_at_once(solver):
    problem = clock(4)
    problem.roots.shift[2:] = [1.0, 1.5]  # now y - 0.5, as the first, and y - 0.5 again
    integrator = create(solver, problem, 0.0, np.zeros(1), np.ones(1))
    assert until_root(integrator, 0.9) is Status.ROOT
    assert integrator.t == pytest.approx(0.5)
    # Where the integrator stands is known to round-off only, which decides what has crossed yet.
    found = integrator.roots_found
    if solver == "ida":
        np.testing.assert_array_equal(found, [1, 0, 1, 1])
    assert found[1] == 0
    assert found.sum() >= 1


def test_directions(solver):
    integrator = thrown(solver)
    integrator.set_root_directions(np.array([1], np.int32))
    assert until_root(integrator, 1.0) is Status.REACHED
    integrator.restart(0.0, np.array([-1.0, 10.0, -9.81]), np.array([10.0, -9.81, 0.0]))
    assert until_root(integrator, 1.0) is Status.ROOT
    np.testing.assert_array_equal(integrator.roots_found, [1])
    assert integrator.t == pytest.approx((10.0 - math.sqrt(100.0 - 2 * 9.81)) / 9.81, rel=1e-6)


def test_a_shift_may_change_between_steps(solver):
    """A shift that turns the sign of a function between two calls makes no root."""
    problem = clock(1)
    integrator = create(solver, problem, 0.0, np.zeros(1), np.ones(1), Options(max_step=0.05))
    for _ in range(3):
        assert integrator.step(2.0).status is Status.STEPPED
    problem.roots.shift[0] = 10.0
    assert until_root(integrator, 1.0) is Status.REACHED
    problem.roots.shift[0] = -1.0
    assert until_root(integrator, 2.0) is Status.ROOT
    assert integrator.t == pytest.approx(1.5)


def test_zero_at_the_start_is_no_root(solver):
    integrator = thrown(solver, height=0.0)
    integrator.restart(0.0, np.array([0.0, 5.0, -9.81]), np.array([5.0, -9.81, 0.0]))
    assert until_root(integrator, 3.0) is Status.ROOT
    assert integrator.t == pytest.approx(10.0 / 9.81, rel=1e-6)


def test_root_at_the_limit_is_a_root(solver):
    integrator = create(solver, clock(1), 0.0, np.zeros(1), np.ones(1))
    assert until_root(integrator, 0.5 + 1e-15) is Status.ROOT
    assert integrator.t == pytest.approx(0.5, abs=1e-9)
    times, out = np.array([0.25, 0.5 + 1e-15]), np.zeros((2, 1))
    integrator.restart(0.0, np.zeros(1), np.ones(1))
    result = integrator.run(times, out, np.zeros((2, 1)))
    assert result.status is Status.ROOT


def test_run_stops_at_the_root(solver):
    integrator = thrown(solver)
    times = np.linspace(0.0, 1.0, 101)
    y, yp = np.full((101, 3), np.nan), np.full((101, 3), np.nan)
    result = integrator.run(times, y, yp)
    fall = math.sqrt(2.0 / 9.81)
    assert result.status is Status.ROOT
    assert result.rows == int(np.searchsorted(times, fall, "right"))
    assert integrator.t == pytest.approx(fall, abs=1e-7)
    filled = times[: result.rows]
    np.testing.assert_allclose(y[: result.rows, 0], 1.0 - 0.5 * 9.81 * filled**2, atol=1e-7)
    assert np.isnan(y[result.rows :]).all()
    assert abs(integrator.y[0]) < 1e-9
    # and goes on
    rest = times[result.rows :]
    result = integrator.run(rest, y[: len(rest)], yp[: len(rest)])
    assert (result.rows, result.status) == (len(rest), Status.REACHED)
    np.testing.assert_allclose(y[: len(rest), 0], 1.0 - 0.5 * 9.81 * rest**2, atol=1e-6)


def test_roots_of_algebraic_unknowns_solve_the_equations(solver):
    """log(x) passes 1 at t = 1; between the steps it is interpolated badly."""
    integrator = create(
        solver,
        logarithm(),
        0.0,
        np.array([1.0, -1.0]),
        np.array([1.0, 0.0]),
        Options(relative_tolerance=1e-7, absolute_tolerance=1e-7),
    )
    assert until_root(integrator, 3.0) is Status.ROOT
    assert integrator.t == pytest.approx(1.0, abs=1e-5)
    assert integrator.y[1] == pytest.approx(0.0, abs=1e-6)
    assert integrator.y[0] == pytest.approx(math.e, rel=1e-6)


def test_functions_that_are_not_finite_have_no_roots(solver):
    """The voltage of the ball's logarithm: not a number where it is below the floor."""
    from rooted import A, with_roots

    from acausal.expressions.build import call

    problem = with_roots(ball(), (call("log", A), [2]))
    integrator = create(
        solver, problem, 0.0, np.array([0.5, 0.0, -9.81]), np.array([0.0, -9.81, 0.0])
    )
    assert until_root(integrator, 1.0) is Status.REACHED


def test_diode(solver):
    """A rectifier whose diode is closed and opened by hand: a mode problem."""
    problem = rectifier()
    native = NativeProblem(problem)
    options = Options(relative_tolerance=1e-8, absolute_tolerance=1e-10)
    closed, shift = problem.w[6:7], problem.roots.shift
    y, yp = np.array([0.5, 0.0]), np.array([-0.5, 0.0])
    integrator = create(solver, native, 0.0, y, yp, options)
    integrator.set_root_directions(np.array([1, 0], np.int32))
    assert until_root(integrator, 3.0) is Status.ROOT
    opened = integrator.t
    assert math.sin(opened) == pytest.approx(0.5 * math.exp(-opened), abs=1e-6)
    closed[0] = 1.0
    shift[:] = [10.0, 1e-9]  # away from zero
    y, yp = integrator.y.copy(), integrator.yp.copy()
    assert integrator.consistent(opened, y, yp) >= 0
    assert y[0] == integrator.y[0]  # the capacitor keeps its voltage
    assert 0.01 * y[1] == pytest.approx(math.sin(opened) - y[0], abs=1e-12)
    integrator.set_root_directions(np.array([0, -1], np.int32))
    integrator.restart(opened, y, yp)
    assert until_root(integrator, 4.0) is Status.ROOT
    np.testing.assert_array_equal(integrator.roots_found, [0, -1])
    # Behind the small resistance the capacitor follows: i = 0 where cos(t) + sin(t) = 0, nearly.
    assert integrator.t == pytest.approx(0.75 * math.pi, abs=0.02)


def test_functions_of_time_alone(solver):
    integrator = create(solver, sine_of_time(3.0), 0.0, np.zeros(0), np.zeros(0))
    times, out = np.linspace(0.1, 4.0, 5), np.zeros((5, 0))
    found, rows = [], 0
    while True:
        result = integrator.run(times[rows:], out, out)
        rows += result.rows
        if result.status is Status.REACHED:
            break
        assert result.status is Status.ROOT
        found.append(integrator.t)
    np.testing.assert_allclose(found, np.pi * np.arange(1, 4) / 3.0, rtol=1e-12)


def test_many_stretches_change_no_root(solver):
    if solver != "ida":
        pytest.skip("is about the native output loop")
    results = []
    for steps, rows in ((1000, 1000), (3, 2)):
        integrator = thrown(solver)
        integrator._pace.steps, integrator._pace.rows = steps, rows
        integrator._pace.learn = lambda steps, elapsed: None
        times, y, yp = np.linspace(0.0, 1.0, 51), np.zeros((51, 3)), np.zeros((51, 3))
        result = integrator.run(times, y, yp)
        results.append((result.rows, integrator.t, y.tobytes(), integrator.y.tobytes()))
    assert results[0] == results[1]
