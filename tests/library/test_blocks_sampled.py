"""Sampled blocks against the difference equations they stand for."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from tests.library.blocks_runs import Array, after, jumps, run, values

SINE = "blocks.Sine sine(f = 1[Hz], phase = 0.3);"


def sine(t: Array) -> Array:
    return np.sin(2 * np.pi * t + 0.3)


def at_instants(result: object, path: str, instants: Array) -> Array:
    """Return the values in the middle between instants, where nothing is ambiguous."""
    middle = instants + 0.5 * (instants[1] - instants[0])
    return np.interp(middle, result.times, values(result, path))  # type: ignore[attr-defined]


@pytest.mark.parametrize("start", [0.0, 0.2])
def test_sampling_and_holding(start: float) -> None:
    result = run(
        f"""{SINE}
  blocks.sampled.Sampler sampler(samplePeriod = 0.05, startTime = {start});
  blocks.sampled.ZeroOrderHold hold(samplePeriod = 0.05, startTime = {start});
  blocks.sampled.UnitDelay before(samplePeriod = 0.05, startTime = {start}, y_start = 9);
equation
  connect(sine.y, sampler.u, hold.u, before.u);
"""
    )
    instants = start + 0.05 * np.arange(int((1 - start) / 0.05))
    expected = sine(instants)
    assert at_instants(result, "sampler.y", instants) == pytest.approx(expected, abs=1e-12)
    assert at_instants(result, "hold.y", instants) == pytest.approx(expected, abs=1e-12)
    delayed = np.concatenate([[9], expected[:-1]])
    assert at_instants(result, "before.y", instants) == pytest.approx(delayed, abs=1e-12)
    if start:
        # what a sampler shows before the first instant is the input at the start
        assert values(result, "sampler.y")[0] == pytest.approx(np.sin(0.3))
        assert values(result, "hold.y")[0] == 0


def test_first_order_hold_connects_the_samples() -> None:
    result = run(
        f"""{SINE}
  blocks.sampled.FirstOrderHold hold(samplePeriod = 0.1);
equation
  connect(sine.y, hold.u);
"""
    )
    t = np.asarray(result.times)
    instants = 0.1 * np.arange(11)
    # one period late, and constant during the first one
    expected = np.interp(t - 0.1, instants, sine(instants))
    assert values(result, "hold.y") == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(
    ("b", "a"),
    [([0.2, 0.3], [1, -0.5]), ([1], [2, 1, 0.3]), ([1, 2, 3], [1, 0, -0.2]), ([3], [2])],
)
def test_transfer_function_filters_like_a_difference_equation(
    b: list[float], a: list[float]
) -> None:
    def text(c: list[float]) -> str:
        return "{" + ", ".join(map(str, c)) + "}"

    result = run(
        f"""{SINE}
  blocks.sampled.TransferFunction g(b = {text(b)}, a = {text(a)}, samplePeriod = 0.02);
equation
  connect(sine.y, g.u);
"""
    )
    instants = 0.02 * np.arange(50)
    padded = [0.0] * (len(a) - len(b)) + b
    expected = signal.lfilter(padded, a, sine(instants))
    assert at_instants(result, "g.y", instants) == pytest.approx(expected, abs=1e-12)


def test_state_space_of_two_inputs_and_two_outputs() -> None:
    result = run(
        """
  blocks.Sine sine(f = 1[Hz]);
  blocks.Ramp ramp(duration = 1);
  blocks.sampled.StateSpace g(A = [0.5, 0.2; -0.1, 0.7], B = [1, 0; 0.5, 2],
    C = [1, 1; 0, 3], D = [0, 1; 0, 0], samplePeriod = 0.04);
equation
  connect(sine.y, g.u[1]);
  connect(ramp.y, g.u[2]);
"""
    )
    instants = 0.04 * np.arange(25)
    u = np.stack([np.sin(2 * np.pi * instants), instants], axis=1)
    system = ([[0.5, 0.2], [-0.1, 0.7]], [[1, 0], [0.5, 2]], [[1, 1], [0, 3]], [[0, 1], [0, 0]])
    _, y, _ = signal.dlsim((*map(np.array, system), 0.04), u)
    for k in range(2):
        found = at_instants(result, f"g.y[{k + 1}]", instants)
        assert found == pytest.approx(y[:, k], abs=1e-12)


def test_triggered_sampling() -> None:
    result = run(
        f"""{SINE}
  blocks.BooleanTable trigger(table = {{0.1, 0.2, 0.65, 0.7, 0.9}});
  blocks.sampled.TriggeredSampler sampler(y_start = 5);
  blocks.sampled.TriggeredMax largest;
equation
  connect(sine.y, sampler.u, largest.u);
  connect(trigger.y, sampler.trigger, largest.trigger);
"""
    )
    at = sine(np.array([0.1, 0.65, 0.9]))
    found = jumps(result, "sampler.y")
    assert [t for t, _ in found] == [0.1, 0.65, 0.9]
    assert [v for _, v in found] == pytest.approx(at)
    assert values(result, "sampler.y")[0] == 5
    assert after(result, "largest.y", 1.0) == pytest.approx(np.abs(at).max())


def test_digital_control_of_a_continuous_plant() -> None:
    # x' = u with u(k) = -K x(k): x(k+1) = (1 - K T) x(k)
    result = run(
        """
  Real x(start = 1, fixed = true);
  blocks.sampled.ZeroOrderHold hold(samplePeriod = 0.1);
equation
  hold.u = -4*x;
  der(x) = hold.y;
""",
        stop_time=2,
    )
    instants = 0.1 * np.arange(21)
    found = np.interp(instants, result.times, values(result, "x"))
    assert found == pytest.approx(0.6 ** np.arange(21), abs=1e-8)


def test_averages_over_full_periods() -> None:
    result = run(
        """
  Real u = 1 + 3*sin(2*constants.pi*5[Hz]*time) + 2*cos(2*constants.pi*10[Hz]*time);
  blocks.Mean mean(f = 5, y0 = -1);
  blocks.RectifiedMean rectified(f = 10);
  blocks.RootMeanSquare rms(f = 5);
  blocks.Harmonic second(f = 5, k = 2), first(f = 5);
  blocks.ContinuousMean all;
  blocks.SignalExtrema extrema(samplePeriod = 0.01);
equation
  mean.u = u;
  rectified.u = u - 1 - 2*cos(2*constants.pi*10[Hz]*time);
  rms.u = u;
  first.u = u;
  second.u = u;
  all.u = u;
  extrema.u = u;
"""
    )
    assert values(result, "mean.y")[0] == -1
    assert after(result, "mean.y", 1.0) == pytest.approx(1, abs=1e-6)
    assert after(result, "rectified.y", 1.0) == pytest.approx(6 / np.pi, abs=1e-6)
    assert after(result, "rms.y", 1.0) == pytest.approx(np.sqrt(1 + 4.5 + 2), abs=1e-6)
    assert after(result, "second.y_rms", 1.0) == pytest.approx(np.sqrt(2), abs=1e-6)
    assert after(result, "second.y_arg", 1.0) == pytest.approx(0, abs=1e-6)
    assert after(result, "first.y_rms", 1.0) == pytest.approx(3 / np.sqrt(2), abs=1e-6)
    assert after(result, "first.y_arg", 1.0) == pytest.approx(-np.pi / 2, abs=1e-6)
    assert after(result, "all.y", 1.0) == pytest.approx(1, abs=1e-6)
    t = 0.01 * np.arange(101)
    u = 1 + 3 * np.sin(10 * np.pi * t) + 2 * np.cos(20 * np.pi * t)
    assert after(result, "extrema.y_max", 1.0) == pytest.approx(u.max(), abs=1e-7)
    assert after(result, "extrema.y_min", 1.0) == pytest.approx(u.min(), abs=1e-7)
