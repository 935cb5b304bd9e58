"""Limits, delays, play and resets against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from tests.library.blocks_runs import after, jumps, run, values

SINE = "blocks.Sine sine(f = 1[Hz], amplitude = 2);"


@pytest.mark.parametrize("strict", ["true", "false"])
def test_limiters_and_dead_zone(strict: str) -> None:
    result = run(
        f"""{SINE}
  blocks.Limiter limiter(uMax = 1, uMin = -0.5, strict = {strict});
  blocks.VariableLimiter variable(strict = {strict});
  blocks.DeadZone zone(uMax = 1, uMin = -0.5);
equation
  connect(sine.y, limiter.u, variable.u, zone.u);
  variable.limit1 = time;
  variable.limit2 = -time;
"""
    )
    t, u = np.asarray(result.times), values(result, "sine.y")
    assert values(result, "limiter.y") == pytest.approx(np.clip(u, -0.5, 1), abs=1e-9)
    assert values(result, "variable.y") == pytest.approx(np.clip(u, -t, t), abs=1e-9)
    assert values(result, "zone.y") == pytest.approx(u - np.clip(u, -0.5, 1), abs=1e-9)
    if strict == "false":
        assert np.abs(t - 1 / 12).min() < 1e-10


def test_integrator_with_reset() -> None:
    result = run(
        """
  blocks.BooleanTable table(table = {0.3, 0.4, 0.7});
  blocks.Integrator plain(k = 2, use_reset = true, y_start = 1);
  blocks.Integrator to_input(use_reset = true, use_set = true);
equation
  plain.u = 1;
  to_input.u = 1;
  to_input.set = -time;
  connect(table.y, plain.reset, to_input.reset);
"""
    )
    t = np.asarray(result.times)
    for time in (0.3, 0.7):
        assert after(result, "plain.y", time) == pytest.approx(1, abs=1e-10)
        assert after(result, "to_input.y", time) == pytest.approx(-time, abs=1e-10)
    end = t > 0.7
    assert values(result, "plain.y")[end] == pytest.approx(1 + 2 * (t[end] - 0.7), abs=1e-9)
    assert values(result, "to_input.y")[end] == pytest.approx(t[end] - 1.4, abs=1e-9)


@pytest.mark.parametrize("strict", ["true", "false"])
def test_limited_integrator_leaves_its_limit_at_once(strict: str) -> None:
    # 2 sin(2 pi t): the integral (1 - cos)/pi passes 0.5 and stays until the input changes sign
    result = run(
        f"""{SINE}
  blocks.LimIntegrator integral(outMax = 0.5, outMin = -0.1, strict = {strict});
equation
  connect(sine.y, integral.u);
"""
    )
    t = np.asarray(result.times)
    y = values(result, "integral.y")
    tolerance = 1e-3 if strict == "true" else 1e-7
    integral = (1 - np.cos(2 * np.pi * t)) / np.pi
    falling = 0.5 + integral - 2 / np.pi
    expected = np.where(t < 0.5, np.minimum(integral, 0.5), np.maximum(falling, -0.1))
    assert y == pytest.approx(expected, abs=tolerance)
    assert (y == 0.5).sum() > 5 or strict == "true"


def test_slew_rate_limiter_follows_ramps() -> None:
    result = run(
        """
  blocks.Step step(startTime = 0.1, height = 1);
  blocks.SlewRateLimiter limiter(Rising = 2, Td = 1e-4);
equation
  connect(step.y, limiter.u);
"""
    )
    t = np.asarray(result.times)
    # the last Td*Rising are made exponentially
    reached = 0.6 - 1e-4
    expected = np.where(
        t < reached, 2 * np.clip(t - 0.1, 0, None),
        1 - 2e-4 * np.exp(-np.clip(t - reached, 0, None) / 1e-4),
    )  # fmt: skip
    assert values(result, "limiter.y") == pytest.approx(expected, abs=1e-7)


def test_delays() -> None:
    result = run(
        f"""{SINE}
  blocks.FixedDelay fixed(delayTime = 0.25);
  blocks.VariableDelay variable(delayMax = 0.5);
equation
  connect(sine.y, fixed.u, variable.u);
  variable.delayTime = 0.1 + 0.3*time;
"""
    )
    t = np.asarray(result.times)
    late = np.clip(t - 0.25, 0, None)
    assert values(result, "fixed.y") == pytest.approx(2 * np.sin(2 * np.pi * late), abs=1e-5)
    late = np.clip(t - 0.1 - 0.3 * t, 0, None)
    assert values(result, "variable.y") == pytest.approx(2 * np.sin(2 * np.pi * late), abs=1e-5)


def test_delayed_step_is_a_step() -> None:
    result = run(
        """
  blocks.Step step(startTime = 0.2);
  blocks.FixedDelay fixed(delayTime = 0.3);
  Real x(start = 0, fixed = true);
equation
  connect(step.y, fixed.u);
  der(x) = fixed.y;
"""
    )
    assert jumps(result, "fixed.y") == [(pytest.approx(0.5, abs=1e-12), 1)]
    assert values(result, "x")[-1] == pytest.approx(0.5, abs=1e-9)


@pytest.mark.parametrize(("n", "m"), [(1, 1), (2, 1), (3, 3), (6, 5)])
def test_pade_approximation(n: int, m: int) -> None:
    from scipy.interpolate import pade
    from scipy.special import factorial

    result = run(
        f"""
  blocks.Sine sine(f = 1[Hz]);
  blocks.PadeDelay late(delayTime = 0.3, n = {n}, m = {m});
equation
  connect(sine.y, late.u);
""",
        tolerance=1e-9,
    )
    series = (-0.3) ** np.arange(n + m + 1) / factorial(np.arange(n + m + 1))
    numerator, denominator = pade(series, n)
    t = np.linspace(0, 1, 20001)
    _, expected, _ = signal.lsim((numerator.coeffs, denominator.coeffs), np.sin(2 * np.pi * t), t)
    found = values(result, "late.y")
    assert found == pytest.approx(np.interp(result.times, t, expected), abs=1e-5)


def play(u: np.ndarray, width: float, start: float) -> np.ndarray:
    """Return the output of a play, step by step."""
    y = np.empty_like(u)
    last = start
    for k, value in enumerate(u):
        last = min(max(last, value - width / 2), value + width / 2)
        y[k] = last
    return y


def test_play_follows_and_rests() -> None:
    result = run(
        """
  Real phi = 2*constants.pi*time*1[1/s];
  Real u = (1 + 0.5[1/s]*time)*sin(phi) + 0.3*sin(3*phi);
  blocks.Play play(b = 0.8);
equation
  play.u = u;
""",
        stop_time=3,
        points=3001,
    )
    u = values(result, "u")
    assert values(result, "play.y") == pytest.approx(play(u, 0.8, 0.0), abs=1e-5)
    # while it rests it does not move at all
    rests = np.flatnonzero(values(result, "play.mode") == 0)
    assert len(rests) > 500
    rest = values(result, "play.y")[rests]
    assert len(np.unique(rest)) < 30


def test_play_with_a_jumping_input() -> None:
    result = run(
        """
  blocks.CombiTimeTable table(table = [0, 0; 1, 2; 1, 0.5; 2, 0.5; 2, -3; 3, -2],
    extrapolation = blocks.Extrapolation.HoldLastPoint);
  blocks.Play play(b = 1);
equation
  connect(table.y[1], play.u);
""",
        stop_time=3,
    )
    found = play(values(result, "table.y[1]"), 1.0, 0.0)
    assert values(result, "play.y") == pytest.approx(found, abs=1e-8)


def test_relay_oscillates() -> None:
    # up and down with the slope 1, between the two levels
    result = run(
        """
  Real x(start = 0, fixed = true);
  blocks.Relay relay(uLow = -1, uHigh = 1, startHigh = false);
equation
  relay.u = x;
  der(x) = -relay.y;
""",
        stop_time=10,
    )
    times = [t for t, _ in jumps(result, "relay.y")]
    assert times == pytest.approx([1, 3, 5, 7, 9], abs=1e-9)


def test_pid_controller_does_not_wind_up() -> None:
    def step_response(windup: str) -> float:
        result = run(
            f"""
  blocks.Step step(startTime = 0);
  blocks.LimPID pid(k = 10, Ti = 0.5, Td = 0.05, yMax = 2, {windup});
  blocks.SecondOrder plant(w = 3, D = 0.4, k = 1, initType = blocks.Init.InitialState);
equation
  connect(step.y, pid.u_s);
  connect(pid.y, plant.u);
  connect(plant.y, pid.u_m);
""",
            stop_time=10,
        )
        y = values(result, "pid.y")
        assert y.max() <= 2 + 1e-9
        assert values(result, "plant.y")[-1] == pytest.approx(1, abs=0.02)
        return float(values(result, "plant.y").max())

    assert step_response("Ni = 0.3") < step_response("Ni = 1e6") - 0.05


def test_pid_controller_is_its_transfer_function() -> None:
    result = run(
        """
  blocks.LimPID pid(k = 2, Ti = 0.5, Td = 0.1, Nd = 10, yMax = 1e6, wd = 1);
equation
  pid.u_s = sin(3[1/s]*time);
  pid.u_m = 0;
""",
        stop_time=5,
        tolerance=1e-9,
    )
    # k (1 + 1/(Ti s) + Td s/(1 + Td/Nd s)) times its denominator Ti s (1 + Td/Nd s)
    lag = np.array([0.01, 1])
    denominator = np.polymul([0.5, 0], lag)
    numerator = 2 * np.polyadd(np.polyadd(denominator, lag), np.polymul([0.05, 0], [1, 0]))
    t = np.linspace(0, 5, 50001)
    _, expected, _ = signal.lsim((numerator, denominator), np.sin(3 * t), t)
    found = values(result, "pid.y")
    assert found == pytest.approx(np.interp(result.times, t, expected), abs=1e-4)
