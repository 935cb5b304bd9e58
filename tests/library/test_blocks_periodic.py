"""Periodic sources change at the times that can be calculated, without spikes."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.blocks_runs import jumps, run, values


@pytest.mark.parametrize("period", [0.1, 0.3, 1 / 3, 0.7])
def test_pulses_of_awkward_periods(period: float) -> None:
    result = run(
        f"""
  blocks.Pulse pulse(period = {period!r}, width = 30, amplitude = 2, offset = -1, startTime = 0.05);
""",
        stop_time=50 * period,
    )
    found = jumps(result, "pulse.y")
    edges = 0.05 + period * (np.arange(100)[:, None] + np.array([0, 0.3])).ravel()
    edges = edges[edges <= 50 * period * (1 - 1e-9)]
    assert [t for t, _ in found] == pytest.approx(edges.tolist(), rel=1e-13)
    assert [v for _, v in found] == [1.0, -1.0] * (len(found) // 2) + [1.0] * (len(found) % 2)


def test_number_of_periods() -> None:
    result = run(
        """
  blocks.Pulse pulse(period = 0.1, nperiod = 3);
  blocks.SawTooth saw(period = 0.1, nperiod = 3, startTime = 0.2);
  blocks.Trapezoid trapezoid(period = 0.1, nperiod = 2, rising = 0.02, width = 0.03,
    falling = 0.04);
"""
    )
    assert [t for t, _ in jumps(result, "pulse.y")][-5:] == pytest.approx(
        [0.05, 0.1, 0.15, 0.2, 0.25]
    )
    t = np.asarray(result.times)
    saw = values(result, "saw.y")
    inside = (t > 0.2) & (t < 0.5)
    away = np.abs((t + 0.01) % 0.1 - 0.01) > 1e-9
    assert saw[inside & away] == pytest.approx(10 * (t % 0.1)[inside & away], abs=1e-9)
    assert saw.min() >= -1e-9
    assert set(saw[(t < 0.2) | (t > 0.5)]) == {0.0}
    shape = np.interp(t % 0.1, [0, 0.02, 0.05, 0.09, 0.1], [0, 1, 1, 0, 0])
    expected = np.where(t < 0.2, shape, 0)
    assert values(result, "trapezoid.y")[away] == pytest.approx(expected[away], abs=1e-9)


def test_integral_of_a_long_train() -> None:
    result = run(
        """
  blocks.Pulse pulse(period = 0.01, width = 25);
  blocks.Integrator integral;
equation
  connect(pulse.y, integral.u);
""",
        stop_time=10,
    )
    assert values(result, "integral.y")[-1] == pytest.approx(2.5, abs=1e-7)
    assert len(jumps(result, "pulse.y")) == pytest.approx(2000, abs=2)


def test_waves_begin_at_their_start_time() -> None:
    result = run(
        """
  blocks.Sine sine(f = 2[Hz], startTime = 0.3, offset = 1);
  blocks.Ramp ramp(startTime = 0.2, duration = 0.5, height = 3);
  blocks.Step step(startTime = 0.1, height = 2, offset = 1);
  blocks.Integrator a, b, c;
equation
  connect(sine.y, a.u);
  connect(ramp.y, b.u);
  connect(step.y, c.u);
""",
        tolerance=1e-9,
    )
    end = {path: values(result, path)[-1] for path in ("a.y", "b.y", "c.y")}
    wave = (1 - np.cos(4 * np.pi * 0.7)) / (4 * np.pi)
    assert end["a.y"] == pytest.approx(1 + wave, abs=1e-7)
    assert end["b.y"] == pytest.approx(0.75 + 0.9, abs=1e-8)
    assert end["c.y"] == pytest.approx(1 + 1.8, abs=1e-8)
    assert jumps(result, "step.y") == [(0.1, 3)]
