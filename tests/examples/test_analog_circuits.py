"""Loudspeaker, oscillator and filters against impedances and equations written down by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

STIFFNESS = 900 + 1.4 * 101325 * 133e-4**2 / 10e-3
RESONANCE = np.sqrt(STIFFNESS / 14e-3) / (2 * np.pi)


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def amplitude(times: Any, signal: Any, frequency: float) -> complex:
    """Return the complex amplitude of a sine at the end of a run."""
    late = times > times[-1] - 5 / frequency
    omega = 2 * np.pi * frequency
    columns = np.column_stack([np.cos(omega * times[late]), np.sin(omega * times[late])])
    (real, imaginary), *_ = np.linalg.lstsq(columns, signal[late], rcond=None)
    return complex(imaginary, real)


def impedance(frequency: float) -> complex:
    s = 2j * np.pi * frequency
    return 5.6 + s * 0.6e-3 + 6.5**2 / (s * 14e-3 + 1.1 + STIFFNESS / s)


@pytest.mark.parametrize("frequency", [40.0, RESONANCE, 300.0])
def test_impedance_of_the_loudspeaker(simulate: Any, frequency: float) -> None:
    result = simulate(
        "loudspeaker",
        "Tone",
        parameters={"f": frequency, "V": 0.05},
        stop_time=0.3,
        points=6001,
        tolerance=1e-9,
    )
    current = amplitude(result.times, values(result, "current"), frequency)
    assert 0.05 / current == pytest.approx(impedance(frequency), rel=1e-3)
    pressure = amplitude(result.times, values(result, "sound"), frequency)
    velocity = (0.05 - (5.6 + 2j * np.pi * frequency * 0.6e-3) * current) / 6.5
    expected = 1.2 * 133e-4 / (2 * np.pi) * 2j * np.pi * frequency * velocity
    assert pressure == pytest.approx(expected, rel=1e-3)


def test_impedance_peaks_at_the_resonance(simulate: Any) -> None:
    result = simulate("loudspeaker", "Sweep", stop_time=3, points=12001, tolerance=1e-6)
    times, current = result.times, np.abs(values(result, "current"))
    # largest current in a window of 40 ms
    centres = np.linspace(1.0, 2.6, 161)
    envelope = [np.max(current[np.abs(times - c) < 0.02]) for c in centres]
    weakest = centres[int(np.argmin(envelope))]
    # the sweep is fast against the width of the resonance
    assert 10 * 100 ** (weakest / 4) == pytest.approx(RESONANCE, rel=0.05)
    assert 1 / np.min(envelope) == pytest.approx(5.6 + 6.5**2 / 1.1, rel=0.1)


@pytest.mark.parametrize("gain", [25.0, 33.0])
def test_oscillator_grows_above_a_gain_of_29(simulate: Any, gain: float) -> None:
    result = simulate(
        "phase_shift_oscillator",
        parameters={"gain": gain},
        stop_time=0.01,
        points=1001,
        tolerance=1e-10,
    )
    # the amplifier has the gain 15000: the output is -k times the voltage behind the capacitors
    k = gain / (1 + (1 + gain) / 15000)
    last = -np.ones(3) / (1 + k)
    second = last + np.array([0, 0, 1])
    first = second + np.array([0, 1, 0])
    through = [last * (1 - k / 15000), second, first]
    matrix = np.cumsum(through, axis=0)[::-1] / (10e3 * 10e-9)
    expected = [-k * last @ expm(matrix * t) @ [0.01, 0, 0] for t in result.times]
    assert values(result, "y") == pytest.approx(expected, abs=1e-5)
    grows = np.max(np.linalg.eigvals(matrix).real)
    assert np.sign(grows) == np.sign(gain - 29)


def test_frequency_of_the_oscillator(simulate: Any) -> None:
    result = simulate(
        "phase_shift_oscillator", parameters={"gain": 29.0}, stop_time=0.05, tolerance=1e-9
    )
    y, t = values(result, "y"), result.times
    rising = np.flatnonzero((y[:-1] < 0) & (y[1:] >= 0))
    crossings = t[rising] - y[rising] * (t[rising + 1] - t[rising]) / (y[rising + 1] - y[rising])
    period = (crossings[-1] - crossings[2]) / (len(crossings) - 3)
    assert 1 / period == pytest.approx(1 / (2 * np.pi * 1e-4 * np.sqrt(6)), rel=1e-3)
    loud = simulate("phase_shift_oscillator", stop_time=0.08, points=2001)
    assert np.max(values(loud, "y")) == pytest.approx(12, rel=1e-3)


def sallen_key(t: float, x: Any) -> Any:
    across, upper, out = x
    u, r, small, a = float(t >= 1e-4), 1 / (2 * np.pi * 1e3 * np.sqrt(2) * 1e-8), 1e-8, out + across
    return [
        ((u - a) - (a - upper)) / r / (2 * small),
        (a - upper) / r / small,
        (1e5 * (upper - out) - out) * 20 * np.pi,
    ]


def multiple_feedback(t: float, x: Any) -> Any:
    node, across, out = x
    u, small = float(t >= 1e-4), 1e-8
    r = 1 / (2 * np.pi * 1e3 * 3 * np.sqrt(0.5) * small)
    minus = out + across
    return [
        ((u - node) + (out - node) + (minus - node)) / r / (4.5 * small),
        (node - minus) / r / small,
        (-1e5 * minus - out) * 20 * np.pi,
    ]


@pytest.mark.parametrize(
    ("model", "equations", "sign"),
    [("SallenKey", sallen_key, 1), ("MultipleFeedback", multiple_feedback, -1)],
)
def test_step_response_of_the_filters(simulate: Any, model: str, equations: Any, sign: int) -> None:
    result = simulate("active_filters", model, stop_time=2e-3, points=201, tolerance=1e-8)
    late = result.times > 1.0001e-4
    found = solve_ivp(
        equations, (1e-4, 2e-3), [0, 0, 0], "Radau", result.times[late], rtol=1e-9, atol=1e-12
    ).y[2]
    assert values(result, "y")[late] == pytest.approx(found, abs=1e-5)
    # Butterworth: overshoot exp(-pi)
    assert np.max(sign * values(result, "y")) == pytest.approx(1 + np.exp(-np.pi), abs=3e-3)
