"""Rectifier, buck converter and dimmer against their piecewise equations."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from acausal import compile_file

FILE = Path(__file__).parents[2] / "examples" / "power_electronics.acm"


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def test_bridge_rectifier_with_capacitor() -> None:
    result = compile_file(FILE, model="BridgeRectifier").simulate()

    def rate(t: float, v: Any) -> Any:
        charging = (abs(24 * np.sin(100 * np.pi * t)) - 1.4 - v) / (0.5 + 2e-5)
        return (np.maximum(charging, 0) - v / 20) / 2.2e-3

    times, place = np.unique(result.times, return_inverse=True)
    expected = solve_ivp(
        rate, (0, 0.1), [0.0], "LSODA", times, rtol=1e-9, atol=1e-10, max_step=1e-4
    ).y[0][place]
    assert values(result, "load.v") == pytest.approx(expected, abs=2e-3)
    # what the mains delivers is stored, used and lost
    into = np.trapezoid(-values(result, "mains.v") * values(result, "mains.i"), result.times)
    parts = [
        values(result, f"{d}_{s}.LossPower") for d in ("upper", "lower") for s in ("left", "right")
    ]
    parts += [values(result, "load.LossPower"), values(result, "winding.LossPower")]
    stored = 2.2e-3 / 2 * values(result, "smoothing.v")[-1] ** 2
    assert into == pytest.approx(np.trapezoid(sum(parts), result.times) + stored, rel=1e-3)


def buck(times: Any) -> Any:
    """Integrate from one switching instant to the next, ``(current, voltage)`` at ``times``."""
    period, on = 20e-6, 8e-6
    now, state, found = 0.0, np.zeros(2), []

    def rate(_: float, x: Any, drive: float) -> Any:
        return [(drive - x[1]) / 100e-6, (x[0] - x[1] / 5) / 47e-6]

    def empty(_: float, x: Any) -> Any:
        return [0.0, -x[1] / 5 / 47e-6]

    def ends(_: float, x: Any, drive: float) -> float:
        return float(x[0]) if drive == 0 else 1.0

    ends.terminal, ends.direction = True, -1  # type: ignore[attr-defined]
    stops = np.sort(np.concatenate([period * np.arange(1, 101), period * np.arange(100) + on]))
    for k, stop in enumerate(stops):
        drive, options = (12.0 if k % 2 == 0 else 0.0), {"rtol": 1e-10, "atol": 1e-12}
        while now < stop - 1e-15:
            idle = drive == 0.0 and state[0] <= 0.0 and state[1] >= 0.0
            part = solve_ivp(
                empty if idle else rate,
                (now, stop),
                state,
                args=None if idle else (drive,),
                events=None if idle else ends,
                dense_output=True,
                **options,
            )
            inside = (times > now) & (times <= part.t[-1])
            found.append(np.vstack([times[inside], part.sol(times[inside])]))
            now, state = part.t[-1], part.y[:, -1]
            if not idle and len(part.t_events[0]):
                state[0] = 0.0
    return np.hstack(found)


def test_buck_converter_from_rest() -> None:
    result = compile_file(FILE, model="BuckConverter").simulate()
    times = np.unique(np.round(result.times, 12))
    times = times[times > 0]
    when, current, voltage = buck(times)
    found_current = np.interp(when, result.times, values(result, "coil.i"))
    found_voltage = np.interp(when, result.times, values(result, "smoothing.v"))
    assert found_voltage == pytest.approx(voltage, abs=2e-3)
    assert found_current == pytest.approx(current, abs=5e-3)
    assert voltage[-1] == pytest.approx(4.8, abs=0.1)


def test_dimmer_with_a_coil() -> None:
    result = compile_file(FILE, model="Dimmer").simulate()
    omega = 100 * np.pi
    impedance, phase = np.hypot(40, omega * 0.1), np.arctan2(omega * 0.1, 40)
    alpha = np.radians(100)

    def pulse(angle: Any) -> Any:
        free = np.sin(alpha - phase) * np.exp(-(angle - alpha) / np.tan(phase))
        return 325 / impedance * (np.sin(angle - phase) - free)

    angle = omega * result.times
    # each pulse begins at its firing angle and ends before the next half wave's
    count = np.floor((angle - alpha) / np.pi)
    within = angle - count * np.pi
    expected = np.where(count >= 0, np.maximum(pulse(within), 0) * (-1.0) ** count, 0.0)
    assert values(result, "inductance.i") == pytest.approx(expected, abs=2e-2)
