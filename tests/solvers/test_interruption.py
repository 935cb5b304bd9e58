"""Ctrl-C stops a run soon, keeps its rows, and the run can go on."""

import os
import signal
import threading

import numpy as np
import pytest
from native_problems import oscillators
from systems import rlc

from acausal.solvers import ida as ida_module
from acausal.solvers.pacing import Pace, interruptible
from acausal.solvers.protocol import Options, Status, create

needs_signals = pytest.mark.skipif(os.name == "nt", reason="POSIX signals")


def interrupt_soon(seconds=0.05):
    timer = threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    return timer


def start(count):
    problem = oscillators(count)
    y, yp = np.zeros(3 * count), np.zeros(3 * count)
    y[:count], y[2 * count :], yp[count : 2 * count] = 1, -1, -1
    return problem, y, yp


@needs_signals
@pytest.mark.parametrize(
    ("count", "slow"), [(1, False), (20, False), (20_000, True)], ids=["small", "sparse", "thread"]
)
def test_interruption(count, slow):
    problem, y, yp = start(count)
    integrator = create("ida", problem, 0.0, y, yp, Options(1e-9, 1e-9))
    if slow:
        integrator._pace.slow = True
    rows = 40
    # Far enough to last for minutes.
    times = np.concatenate([np.linspace(0, 0.01, rows - 1), [1e6]])
    out = np.full((rows, 3 * count), np.nan)
    timer = interrupt_soon(0.4)
    result = integrator.run(times, out, np.empty_like(out))
    timer.join()
    assert result.status is Status.INTERRUPTED
    assert result.failure is None
    assert np.isfinite(out[: result.rows]).all()
    assert np.isnan(out[result.rows :]).all()
    np.testing.assert_allclose(out[: result.rows, 0], np.cos(times[: result.rows]), atol=1e-5)
    # The solver is intact: it goes on from where it is.
    t = integrator.t
    assert 0 < t < 1e6
    more = np.empty((1, 3 * count))
    assert integrator.run(np.array([t + 0.1]), more, more.copy()).status is Status.REACHED
    assert more[0, 0] == pytest.approx(np.cos(t + 0.1), abs=1e-2)


@needs_signals
def test_interruption_of_python_steppers(solver):
    if solver == "ida":
        pytest.skip("has its own test")
    system = rlc()
    integrator = create(solver, system, 0.0, np.array([0.0, 0, 2, 0]), np.array([4.0, 0, 0, 0]))
    times = np.linspace(0, 1, 11)
    seen = []

    def residual(t, y, yp, out, original=system.residual):
        if t > 0.45 and not seen:
            seen.append(t)
            signal.raise_signal(signal.SIGINT)
        original(t, y, yp, out)

    system.residual = residual
    out = np.full((11, 4), np.nan)
    result = integrator.run(times, out, np.empty((11, 4)))
    assert result.status is Status.INTERRUPTED
    assert seen
    assert 3 <= result.rows <= 5
    assert np.isfinite(out[: result.rows]).all()


def test_thread_gives_the_same(monkeypatch):
    problem, y, yp = start(3)
    outs = []
    for slow in (False, True):
        integrator = create("ida", problem, 0.0, y, yp)
        integrator._pace.slow = slow
        monkeypatch.setattr(ida_module.Pace, "learn", lambda self, steps, elapsed: None)
        out = np.empty((21, 9))
        integrator.run(np.linspace(0, 10, 21), out, np.empty_like(out))
        outs.append(out)
    np.testing.assert_array_equal(*outs)


def test_stretches_change_nothing():
    """A budget of a few steps per stretch gives bit for bit the same run."""
    problem, y, yp = start(3)
    outs = []
    for steps, rows in ((1000, 1000), (7, 3)):
        integrator = create("ida", problem, 0.0, y, yp)
        integrator._pace.steps, integrator._pace.rows = steps, rows
        integrator._pace.learn = lambda steps, elapsed: None
        out, outp = np.empty((101, 9)), np.empty((101, 9))
        assert integrator.run(np.linspace(0, 20, 101), out, outp).rows == 101
        outs.append(np.hstack([out, outp]))
    np.testing.assert_array_equal(*outs)


def test_pace_learns():
    pace = Pace(10)
    pace.learn(1000, 0.01)  # 10 microseconds a step
    assert not pace.slow
    assert pace.steps == pytest.approx(1000, abs=1)
    pace.learn(2, 0.1)
    assert pace.slow
    assert pace.steps == 10
    pace.learn(0, 0.1)
    assert pace.steps == 10


@needs_signals
def test_interruptible_waits_for_the_work():
    halted, ended = threading.Event(), []

    def work(number):
        assert halted.wait(10)
        ended.append(number)
        return number

    timer = interrupt_soon()
    with pytest.raises(KeyboardInterrupt):
        interruptible(work, (3,), halted.set)
    timer.join()
    assert ended == [3]
    assert interruptible(lambda: 7, (), halted.set) == 7
