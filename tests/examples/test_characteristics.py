"""S33: play, curves and maps of measured points."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import PchipInterpolator, RegularGridInterpolator

from tests.examples.conftest import Simulate


def values(result: object, path: str) -> np.ndarray:
    return np.asarray(result[path].values)  # type: ignore[index]


def test_mass_between_springs_with_play(simulate: Simulate) -> None:
    result = simulate("characteristics", "ForceWithPlay", tolerance=1e-9, points=2001)
    # half a swing: across the play, and half a sine in the spring
    half = 0.2 / 1 + np.pi * np.sqrt(1 / 400)
    s, t = values(result, "mass.s"), np.asarray(result.times)
    passes = np.flatnonzero(s[1:-1] * s[2:] < 0) + 1
    found = t[passes] - s[passes] * (t[passes + 1] - t[passes]) / (s[passes + 1] - s[passes])
    assert found == pytest.approx(half * np.arange(1, len(found) + 1), abs=1e-5)
    assert len(found) > 10
    assert s.max() == pytest.approx(0.1 + 1 / 20, abs=1e-4)


def test_engine_speeds_up_along_its_map(simulate: Simulate) -> None:
    result = simulate("characteristics", "Engine", tolerance=1e-8)
    torque = RegularGridInterpolator(
        (np.array([100.0, 300, 500]), np.array([0.0, 0.5, 1])),
        np.array([[-10.0, 60, 100], [-20, 80, 180], [-40, 40, 120]]),
        bounds_error=False,
        fill_value=None,  # type: ignore[arg-type]
    )

    def slope(t: float, w: np.ndarray, late: bool) -> np.ndarray:
        pedal = 0.0 if late else min(0.1 + 0.45 * t, 1.0)
        load = 100 * (w[0] / 400) ** 2
        return (torque([[w[0], pedal]]) - load) / 0.5

    options = {"rtol": 1e-8, "atol": 1e-8, "max_step": 0.01}
    first = solve_ivp(slope, (0, 6), [100.0], args=(False,), dense_output=True, **options)
    second = solve_ivp(slope, (6, 10), first.y[:, -1], args=(True,), dense_output=True, **options)
    t = np.asarray(result.times)
    expected = np.where(t <= 6, first.sol(np.minimum(t, 6))[0], second.sol(np.maximum(t, 6))[0])
    assert values(result, "inertia.w") == pytest.approx(expected, abs=1e-3)
    # full pedal: torque and load are in equilibrium where 180 - 0.3 (w - 300) = 100 (w/400)^2
    a, b, c = 100 / 400**2, 0.3, -270
    steady = (-b + np.sqrt(b**2 - 4 * a * c)) / (2 * a)
    assert values(result, "inertia.w").max() == pytest.approx(steady, rel=1e-3)


def test_wheel_is_braked_to_a_stop(simulate: Simulate) -> None:
    result = simulate("characteristics", "Braking", tolerance=1e-9)
    curve = PchipInterpolator([0, 0.2, 0.6, 1], [0, 0, 1500, 4000])
    ramp, _ = quad(curve, 0, 1, points=[0.2, 0.6])
    # 100 (80 - w) = integral of the torque; after the ramp it is 4000 N m
    end = 1.5 + (8000 - ramp) / 4000
    assert result.times[-1] == pytest.approx(end, abs=1e-6)
    assert values(result, "wheel.w")[-1] == pytest.approx(0, abs=1e-6)


def test_steering_with_play(simulate: Simulate) -> None:
    result = simulate("characteristics", "Steering", tolerance=1e-9, points=8001)
    u, y = values(result, "linkage.u"), values(result, "linkage.y")
    last, expected = 0.0, []
    for value in u:
        last = min(max(last, value - 0.2), value + 0.2)
        expected.append(last)
    assert y == pytest.approx(np.array(expected), abs=1e-5)
    t = np.asarray(result.times)
    assert set(y[t < 1]) == {0.0}  # smaller swings than the play do nothing
    assert np.ptp(y[t > 6]) > 1
