"""Bridge of six valves: ripple, mean voltage over the firing angle, drop by commutation."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

IDEAL = 3 * np.sqrt(2) / np.pi * 400


def run(simulate: Any, model: str, **parameters: float) -> tuple[Any, Any, Any]:
    result = simulate(
        "three_phase_rectifier",
        model,
        parameters=parameters,
        stop_time=0.1,
        points=10001,
        tolerance=1e-7,
    )
    return result, result.times, np.asarray(result["bridge.vDC"].values)


def mean(times: Any, signal: Any) -> float:
    """Return the mean over the last two periods."""
    late = times >= 0.06
    area = np.sum(np.diff(times[late]) * (signal[late][1:] + signal[late][:-1]) / 2)
    return float(area / (times[late][-1] - times[late][0]))


def test_six_pulses_per_period(simulate: Any) -> None:
    result, times, voltage = run(simulate, "SixPulses")
    phases = (
        400
        * np.sqrt(2 / 3)
        * np.array([np.sin(2 * np.pi * (50 * times - k / 3)) for k in range(3)])
    )
    expected = np.max(phases, axis=0) - np.min(phases, axis=0)
    assert voltage == pytest.approx(expected, abs=0.02)
    assert mean(times, voltage) == pytest.approx(IDEAL, rel=1e-4)
    late = times > 0.08
    assert np.max(voltage[late]) == pytest.approx(400 * np.sqrt(2), rel=1e-4)
    assert np.min(voltage[late]) == pytest.approx(400 * np.sqrt(2) * np.cos(np.pi / 6), rel=1e-3)
    # the load sees 300 Hz: six changes of the conducting pair in 20 ms
    changes = [e.time for e in result.events if 0.08 < e.time < 0.0999]
    assert len(set(np.round(changes, 6))) == 6


@pytest.mark.parametrize("angle", [0.3, np.pi / 3])
def test_mean_voltage_follows_the_firing_angle(simulate: Any, angle: float) -> None:
    _, times, voltage = run(simulate, "Controlled", angle=angle, Lload=0.02)
    assert mean(times, voltage) == pytest.approx(IDEAL * np.cos(angle), rel=2e-3)


def test_commutation_costs_voltage(simulate: Any) -> None:
    result, times, voltage = run(simulate, "Commutation", Lload=0.02)
    current = mean(times, np.asarray(result["load.i"].values))
    drop = 3 * 2 * np.pi * 50 * 1e-3 * current / np.pi
    assert drop > 14
    assert mean(times, voltage) == pytest.approx(IDEAL - drop, rel=2e-3)
