"""What every integrator promises."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from native_problems import build, oscillators
from systems import rlc, rlc_exact

from acausal.diagnostics import AcausalError
from acausal.solvers.protocol import Options, Status, create

START = np.array([0.0, 0.0, 2.0, 0.0])
SLOPE = np.array([4.0, 0.0, 0.0, 0.0])


def begin(solver, t=0.0, **options):
    return create(solver, rlc(), t, START, SLOPE, Options(**options))


def test_steps_never_pass_the_limit(solver):
    integrator = begin(solver)
    last = 0.0
    for limit in (0.1, 0.1 + 1e-7, 0.5, 1.0):
        while True:
            result = integrator.step(limit)
            assert last < result.t <= limit
            assert result.t == integrator.t
            last = result.t
            if result.status is Status.REACHED:
                break
            assert result.status is Status.STEPPED
        assert integrator.t == limit
        assert integrator.y[1] == pytest.approx(float(rlc_exact(limit)), abs=1e-4)


def test_arguments_are_copied(solver):
    y, yp = START.copy(), SLOPE.copy()
    integrator = create(solver, rlc(), 0.0, y, yp)
    integrator.step(1.0)
    np.testing.assert_array_equal(y, START)
    np.testing.assert_array_equal(yp, SLOPE)


def test_interpolation_inside_the_last_step(solver):
    integrator = begin(solver)
    checked = 0
    before = 0.0
    while integrator.t < 2.0:
        integrator.step(2.0)
        after = integrator.t
        y = integrator.y.copy()
        for share in (0.0, 0.3, 0.7, 1.0):
            t = before + share * (after - before)
            value, slope = integrator.interpolate(t), integrator.interpolate(t, 1)
            assert value[1] == pytest.approx(float(rlc_exact(t)), abs=1e-4)
            assert 0.1 * slope[1] == pytest.approx(value[0], abs=2e-3)
            checked += 1
        np.testing.assert_array_equal(integrator.y, y)  # looking back changes nothing
        assert integrator.t == after
        before = after
    assert checked > 100
    with pytest.raises(ValueError, match="last step"):
        integrator.interpolate(0.5)


def test_restart_jumps(solver):
    """At t = 1 the circuit starts again from rest."""
    integrator = begin(solver)
    times = np.linspace(0, 1, 5)
    out, outp = np.empty((5, 4)), np.empty((5, 4))
    integrator.run(times, out, outp)
    steps = integrator.statistics.steps
    integrator.restart(1.0, START, SLOPE)
    assert integrator.t == 1.0
    np.testing.assert_array_equal(integrator.y, START)
    again, againp = np.empty((5, 4)), np.empty((5, 4))
    result = integrator.run(1.0 + times, again, againp)
    assert result.status is Status.REACHED
    np.testing.assert_allclose(again[:, 1], rlc_exact(times), atol=1e-4)
    assert integrator.statistics.steps > steps  # the sum of both


def test_restart_with_another_problem(solver):
    """From one pattern to another of the same size, as when other states are chosen."""
    coupled = oscillators(2, 2.0)
    n = coupled.n
    w = coupled.w.copy()
    w[coupled.parameter_position] = 9.0
    faster = replace(coupled, w=w)
    y = np.array([1.0, 1, 0, 0, -4, -4])
    yp = np.array([0.0, 0, -4, -4, 0, 0])
    integrator = create(solver, coupled, 0.0, y, yp, Options(relative_tolerance=1e-8))
    integrator.run(np.array([np.pi]), np.empty((1, n)), np.empty((1, n)))
    assert integrator.y[0] == pytest.approx(1.0, abs=1e-4)
    y[4:], yp[2:4] = -9.0, -9.0
    integrator.restart(np.pi, y, yp, faster)
    times = np.pi + np.linspace(0, 2, 9)
    out = np.empty((9, n))
    assert integrator.run(times, out, np.empty((9, n))).status is Status.REACHED
    np.testing.assert_allclose(out[:, 0], np.cos(3 * (times - np.pi)), atol=1e-4)


def test_restart_refuses_another_size(solver):
    integrator = begin(solver)
    with pytest.raises(ValueError, match="size"):
        integrator.restart(0.0, START, SLOPE, oscillators(1))


def test_many_restarts(solver):
    """A sawtooth: restart every 0.05 s; the accuracy of one period is kept."""
    integrator = begin(solver)
    for k in range(60):
        while integrator.step(0.05 * (k + 1)).status is Status.STEPPED:
            pass
        assert integrator.y[1] == pytest.approx(float(rlc_exact(0.05)), abs=1e-5)
        integrator.restart(integrator.t, START, SLOPE)


def test_negative_and_late_start_times(solver):
    for t in (-3.0, 1e5):
        integrator = begin(solver, t)
        times = t + np.linspace(0, 1, 5)
        out = np.empty((5, 4))
        assert integrator.run(times, out, np.empty((5, 4))).status is Status.REACHED
        np.testing.assert_allclose(out[:, 1], rlc_exact(times - t), atol=1e-4)


def test_looking_ahead(solver):
    """With a later limit, output times cost no steps of their own."""
    pieces = np.linspace(0, 2, 401)
    integrator = begin(solver)
    for left, right in itertools.pairwise(pieces):
        out = np.empty((1, 4))
        integrator.run(np.array([right]), out, np.empty((1, 4)), t_limit=2.0)
        assert integrator.t == right > left
        assert out[0, 1] == pytest.approx(float(rlc_exact(right)), abs=1e-4)
    if solver != "radau":  # which ends a step on every output time
        assert integrator.statistics.steps < 300
    # step() goes on from the end of the last step
    integrator = begin(solver)
    integrator.run(np.array([0.9]), np.empty((1, 4)), np.empty((1, 4)), t_limit=3.0)
    result = integrator.step(3.0)
    assert 0.9 < result.t <= 3.0
    assert integrator.y[1] == pytest.approx(float(rlc_exact(result.t)), abs=1e-4)


def test_limit_inside_the_last_step(solver):
    integrator = begin(solver)
    integrator.run(np.array([0.9]), np.empty((1, 4)), np.empty((1, 4)), t_limit=3.0)
    integrator.step(3.0)
    limit = integrator.t + 1e-9
    result = integrator.step(limit)
    assert result.status is Status.REACHED
    assert integrator.t == limit
    assert integrator.y[1] == pytest.approx(float(rlc_exact(limit)), abs=1e-4)


def test_run_of_no_times(solver):
    integrator = begin(solver)
    result = integrator.run(np.zeros(0), np.empty((0, 4)), np.empty((0, 4)))
    assert (result.rows, result.status) == (0, Status.REACHED)


def test_max_step(solver):
    integrator = begin(solver, max_step=0.01)
    last = 0.0
    while integrator.step(0.5).status is Status.STEPPED:
        assert integrator.t - last <= 0.01 * (1 + 1e-9)
        last = integrator.t
    assert integrator.statistics.steps >= 50


def test_initial_step(solver):
    integrator = begin(solver, initial_step=1e-9)
    assert integrator.step(1.0).t == pytest.approx(1e-9, rel=0.5)


def test_tolerance_matters(solver):
    errors = []
    times = np.linspace(0, 3, 31)
    for tolerance in (1e-3, 1e-6, 1e-9):
        out = np.empty((31, 4))
        begin(solver, relative_tolerance=tolerance, absolute_tolerance=tolerance).run(
            times, out, np.empty((31, 4))
        )
        errors.append(np.abs(out[:, 1] - rlc_exact(times)).max())
    assert errors[0] > 10 * errors[1] > 100 * errors[2]


def test_progress_is_told(solver):
    told = []
    integrator = begin(solver, progress=told.append)
    integrator.run(np.linspace(0, 1, 3), np.empty((3, 4)), np.empty((3, 4)))
    assert told
    assert told == sorted(told)
    assert told[-1] == 1.0


def test_statistics(solver):
    integrator = begin(solver)
    while integrator.step(1.0).status is Status.STEPPED:
        pass
    statistics = integrator.statistics
    assert statistics.steps > 20
    assert statistics.residual_evaluations >= statistics.steps
    assert statistics.jacobian_evaluations > 0
    assert statistics.last_step > 0


def test_no_unknowns(solver):
    problem = build(np.zeros(0, bool), [], [])
    integrator = create(solver, problem, 0.0, np.zeros(0), np.zeros(0), Options(max_step=0.5))
    assert integrator.step(0.7).status is Status.STEPPED
    assert integrator.step(0.7).status is Status.REACHED
    assert integrator.run(np.array([1.0, 2.0]), np.empty((2, 0)), np.empty((2, 0))).rows == 2
    assert integrator.t == 2.0


def test_no_states(solver):
    """Only algebraic equations: y = sin(t)."""
    from systems import CallbackSystem

    system = CallbackSystem(
        lambda t, y, yp: [y[0] + 0.1 * y[0] ** 3 - np.sin(t)],
        lambda t, y, yp: [[1 + 0.3 * y[0] ** 2]],
        lambda *_: [[0.0]],
        [False],
    )
    integrator = create(solver, system, 0.0, np.zeros(1), np.zeros(1))
    times = np.linspace(0, 3, 7)
    out = np.empty((7, 1))
    assert integrator.run(times, out, np.empty((7, 1))).status is Status.REACHED
    y = out[:, 0]
    np.testing.assert_allclose(y + 0.1 * y**3, np.sin(times), atol=1e-5)


def test_unknown_name():
    with pytest.raises(AcausalError) as caught:
        create("euler", rlc(), 0.0, START, SLOPE)
    assert caught.value.diagnostics[0].code == "R100"
    assert "radau" in caught.value.diagnostics[0].help


def test_output_of_wrong_shape():
    integrator = begin("ida")
    with pytest.raises(ValueError, match="shape"):
        integrator.run(np.array([1.0]), np.empty((1, 3)), np.empty((1, 4)))
    with pytest.raises(ValueError, match="contiguous"):
        integrator.run(np.array([1.0, 2.0]), np.empty((4, 2)).T, np.empty((2, 4)))


def test_closing_twice(solver):
    integrator = begin(solver)
    integrator.close()
    integrator.close()


def test_algebraic_unknowns_do_not_dilute_the_error(solver):
    """The same states with hundreds of algebraic unknowns beside them: as accurate."""
    from systems import CallbackSystem

    def oscillator(extra):
        n = 2 + extra
        dy, dyp = np.eye(n), np.zeros((n, n))
        dy[:2, :2] = [[0, -1], [4, 0]]
        dy[2:, 0] = -1.0
        dyp[0, 0] = dyp[1, 1] = 1.0
        mask = (dy != 0) | (dyp != 0)
        return CallbackSystem(
            lambda t, y, yp: dyp @ yp + dy @ y,
            lambda *_: dy,
            lambda *_: dyp,
            [True, True] + [False] * extra,
            mask,
        )

    times = np.linspace(0, 10, 21)
    errors = []
    for extra in (1, 300):
        y, yp = np.ones(2 + extra), np.zeros(2 + extra)
        y[1], yp[1] = 0.0, -4.0
        out = np.empty((21, 2 + extra))
        integrator = create(solver, oscillator(extra), 0.0, y, yp)
        assert integrator.run(times, out, np.empty_like(out)).status is Status.REACHED
        errors.append(np.abs(out[:, 0] - np.cos(2 * times)).max())
        np.testing.assert_allclose(out[:, -1], out[:, 0], atol=1e-7)
    assert errors[1] < 3 * errors[0]
