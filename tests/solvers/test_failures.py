"""Runs that cannot go on: what is said, and that what was computed is kept."""

import numpy as np
import pytest
from systems import CallbackSystem, rlc

from acausal.solvers.failures import Reason
from acausal.solvers.protocol import Options, Status, create


class Names:
    """Names as the simulation gives them."""

    def unknown(self, index):
        return ["height", "flow", "pressure", "x3"][index]

    def row(self, index):
        return f"row of line {10 + index}"


def scalar(f, dy, dyp=lambda *_: 1.0):
    """F(t, y, y') = 0 with one state."""
    return CallbackSystem(
        lambda t, y, yp: [f(t, y[0], yp[0])],
        lambda t, y, yp: [[dy(t, y[0], yp[0])]],
        lambda t, y, yp: [[dyp(t, y[0], yp[0])]],
        [True],
    )


def run(solver, system, y, yp, times, **options):
    n = len(y)
    integrator = create(
        solver, system, times[0], np.array(y), np.array(yp), Options(labels=Names(), **options)
    )
    out = np.full((len(times), n), np.nan)
    result = integrator.run(np.asarray(times), out, np.empty_like(out))
    return integrator, result, out


def check(result, *reasons):
    assert result.status is Status.FAILED
    diagnostic = result.failure.diagnostics[0]
    assert result.failure.failure.reason in reasons, diagnostic
    assert diagnostic.code == result.failure.failure.reason.value
    assert "at time" in diagnostic.message
    assert diagnostic.help
    return diagnostic


def test_growth_without_limit(solver):
    """x' = x^2 from 1 reaches infinity at t = 1."""
    system = scalar(lambda t, x, xp: xp - x**2, lambda t, x, xp: -2 * x)
    times = np.linspace(0, 2, 21)
    _, result, out = run(solver, system, [1.0], [1.0], times)
    check(result, Reason.ERROR_TEST, Reason.CONVERGENCE, Reason.NOT_FINITE, Reason.EXPLICIT_FORM)
    assert result.rows in (10, 11)  # 0, 0.1, ... 0.9, and 1 if that is reached from below
    np.testing.assert_allclose(out[:9, 0], 1 / (1 - times[:9]), rtol=1e-3)
    assert result.failure.failure.time == pytest.approx(1.0, abs=1e-2)


def test_not_finite(solver):
    """x' = -1/(2 x), x^2 = 1 - t, and a logarithm of x: no value from t = 1 on."""
    system = CallbackSystem(
        lambda t, y, yp: [yp[0] + 1, y[1] - (np.log(y[0]) if y[0] > 0 else np.nan)],
        lambda t, y, yp: [[0, 0], [-1 / max(y[0], 1e-300), 1]],
        lambda *_: [[1, 0], [0, 0]],
        [True, False],
    )
    times = np.linspace(0, 2, 21)
    integrator, result, out = run(solver, system, [1.0, 0.0], [-1.0, -1.0], times)
    diagnostic = check(result, Reason.NOT_FINITE)
    assert result.rows in (10, 11)
    np.testing.assert_allclose(out[:10, 1], np.log(1 - times[:10]), atol=1e-4)
    assert "not a finite number" in diagnostic.message
    assert "division by zero" in diagnostic.help
    assert integrator.t == pytest.approx(1.0, abs=1e-6)
    if solver == "ida":
        assert result.failure.failure.rows == (1,)
        assert any("row of line 11" in note for note in diagnostic.notes)


def test_not_finite_from_the_start(solver):
    system = scalar(lambda t, x, xp: np.nan, lambda *_: 0.0)
    _, result, _ = run(solver, system, [1.0], [1.0], [0.0, 1.0])
    diagnostic = check(result, Reason.NOT_FINITE)
    assert result.rows == 1  # the start itself
    assert any("row of line 10" in note for note in diagnostic.notes)


def test_singular(solver):
    """Nothing determines flow and pressure apart from their sum."""
    system = CallbackSystem(
        lambda t, y, yp: [yp[0] + y[0], y[1] + y[2] - y[0], 2 * (y[1] + y[2] - y[0])],
        lambda *_: [[1, 0, 0], [-1, 1, 1], [-2, 2, 2]],
        lambda *_: [[1, 0, 0], [0, 0, 0], [0, 0, 0]],
        [True, False, False],
    )
    _, result, _ = run(solver, system, [1.0, 0.5, 0.5], [-1.0, 0, 0], [0.0, 1.0])
    diagnostic = check(result, Reason.SINGULAR)
    assert set(result.failure.failure.unknowns) == {1, 2}
    assert set(result.failure.failure.rows) >= {1} or set(result.failure.failure.rows) >= {2}
    notes = " ".join(diagnostic.notes)
    assert "flow" in notes
    assert "pressure" in notes
    assert "height" not in notes


def test_singular_on_the_way(solver):
    """(1 - t) a = 1 has no solution at t = 1."""
    system = CallbackSystem(
        lambda t, y, yp: [yp[0] - y[1], (1 - t) * y[1] - 1],
        lambda t, y, yp: [[0, -1], [0, 1 - t]],
        lambda *_: [[1, 0], [0, 0]],
        [True, False],
    )
    times = np.linspace(0, 2, 21)
    _, result, out = run(solver, system, [0.0, 1.0], [1.0, 0.0], times)
    if result.status is Status.FAILED:
        assert result.rows in (10, 11)
        assert result.failure.failure.time == pytest.approx(1.0, abs=1e-2)
    np.testing.assert_allclose(out[:9, 0], -np.log(1 - times[:9]), rtol=1e-3)


def test_too_many_steps(solver):
    times = np.linspace(0, 5, 51)
    integrator, result, out = run(solver, rlc(), [0, 0, 2, 0], [4, 0, 0, 0], times, max_steps=60)
    diagnostic = check(result, Reason.TOO_MANY_STEPS)
    assert any("60" in note for note in diagnostic.notes)
    assert 60 <= integrator.statistics.steps < 80
    assert 1 < result.rows < 51
    assert np.isfinite(out[: result.rows]).all()
    assert np.isnan(out[result.rows :]).all()
    step = integrator.step(5.0)
    assert step.status is Status.FAILED
    check(step, Reason.TOO_MANY_STEPS)


def test_jumps_are_passed(solver):
    """A square wave as right-hand side, without events: x is a triangle."""
    system = CallbackSystem(
        lambda t, y, yp: [yp[0] - y[1], y[1] - (1.0 if t % 2 < 1 else -1.0)],
        lambda *_: [[0, -1], [0, 1]],
        lambda *_: [[1, 0], [0, 0]],
        [True, False],
    )
    times = np.linspace(0, 8, 33)
    _, result, out = run(solver, system, [0.0, 1.0], [1.0, 0.0], times, max_step=0.2)
    assert result.status is Status.REACHED, result.failure
    triangle = np.where(times % 2 < 1, times % 2, 2 - times % 2)
    np.testing.assert_allclose(out[:, 0], triangle, atol=1e-3)


@pytest.mark.parametrize("scale", [1e-9, 1e-12])
def test_stiff_start_far_off_the_slow_solution(solver, scale):
    """A transient many orders of magnitude faster than the simulation."""
    system = CallbackSystem(
        lambda t, y, yp: [scale * yp[0] + y[0] - np.cos(t), y[1] - y[0] ** 3],
        lambda t, y, yp: [[1, 0], [-3 * y[0] ** 2, 1]],
        lambda *_: [[scale, 0], [0, 0]],
        [True, False],
    )
    times = np.linspace(0, 3, 13)
    _, result, out = run(solver, system, [-5.0, -125.0], [6 / scale, 0.0], times)
    assert result.status is Status.REACHED, result.failure
    np.testing.assert_allclose(out[1:, 0], np.cos(times[1:]), atol=1e-4)
    np.testing.assert_allclose(out[1:, 1], np.cos(times[1:]) ** 3, atol=1e-4)


@pytest.mark.parametrize("name", ["odes-ida", "odes-cvode"])
def test_missing_extra_is_told(name, monkeypatch):
    import importlib

    from acausal.diagnostics import AcausalError

    real = importlib.import_module

    def missing(module, *arguments):
        if module.startswith("scikits"):
            raise ImportError(module)
        return real(module, *arguments)

    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(AcausalError) as caught:
        create(name, rlc(), 0.0, np.zeros(4), np.zeros(4))
    assert caught.value.diagnostics[0].code == "R102"
    assert "acausal[odes]" in caught.value.diagnostics[0].help


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("odes-ida", marks=pytest.mark.odes),
        pytest.param("odes-cvode", marks=pytest.mark.odes),
        "radau",
    ],
)
def test_exceptions_in_callbacks_stop_the_run(name, request):
    """Python callbacks may raise; scikits-odes would print it and go on."""
    if name != "radau":
        pytest.importorskip("scikits_odes_sundials")
    system = rlc()
    residual, calls = system.residual, []

    def broken(t, y, yp, out):
        calls.append(t)
        if t > 0.3:
            raise RuntimeError("broken on purpose")
        return residual(t, y, yp, out)

    system.residual = broken
    integrator = create(name, system, 0.0, np.array([0.0, 0, 2, 0]), np.array([4.0, 0, 0, 0]))
    with pytest.raises(RuntimeError, match="on purpose"):
        integrator.run(np.linspace(0, 1, 11), np.empty((11, 4)), np.empty((11, 4)))
    assert sum(t > 0.3 for t in calls) == 1
