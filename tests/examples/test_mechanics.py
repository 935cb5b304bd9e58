"""S04, S06, S08, S10 and S12: moving bodies keep energy, momentum and constraints."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

G = 9.81


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def test_forced_spring_and_mass(simulate: Any) -> None:
    result = simulate("spring_and_mass", stop_time=10, tolerance=1e-9)
    own, w, r, l0 = 10.0, 5.0, 0.01, 0.2
    forced = r * own**2 / (own**2 - w**2)
    expected = l0 + (0.02 - forced) * np.cos(own * result.times) + forced * np.cos(w * result.times)
    assert values(result, "mass.s") == pytest.approx(expected, abs=1e-6)
    assert values(result, "foot.s") == pytest.approx(r * np.cos(w * result.times), abs=1e-9)
    assert values(result, "spring.f") == pytest.approx(
        100 * (values(result, "mass.s") - values(result, "foot.s") - l0), abs=1e-6
    )


def test_pendulum_turns_over_and_over_on_its_circle(simulate: Any) -> None:
    # Fast enough to pass the top, where neither x nor y alone could be a state all the way.
    parameters = {"phi0": 0.0, "w0": 8.0}
    result = simulate("cartesian_pendulum", None, parameters, stop_time=20, tolerance=1e-8)
    x, y = values(result, "x"), values(result, "y")
    assert np.max(np.abs(x**2 + y**2 - 1)) < 1e-6
    assert np.max(np.abs(x * values(result, "vx") + y * values(result, "vy"))) < 1e-5
    angle = np.unwrap(np.arctan2(x, -y))
    assert angle[-1] > 10 * 2 * np.pi
    assert values(result, "energy") == pytest.approx(32 - G, abs=1e-4)


def test_pendulum_stays_on_its_circle_for_a_long_time(simulate: Any) -> None:
    result = simulate(
        "cartesian_pendulum", None, {"phi0": 2.0}, stop_time=1000, tolerance=1e-7, points=5001
    )
    error = np.abs(values(result, "x") ** 2 + values(result, "y") ** 2 - 1) / 2
    assert np.max(error) < 1e-6


@pytest.mark.parametrize(
    ("model", "links", "time"),
    [
        ("SinglePendulum", 1, 10.0),
        ("DoublePendulum", 2, 10.0),
        ("TriplePendulum", 3, 10.0),
        ("Chain10", 10, 5.0),
        ("Chain100", 100, 10.0),
    ],
)
def test_chain_of_pendulums(simulate: Any, model: str, links: int, time: float) -> None:
    result = simulate("pendulum_chain", model, stop_time=time, tolerance=1e-7, points=101)
    scale = G * links * (links + 1) / 2
    assert values(result, "energy") == pytest.approx(0, abs=1e-3 * scale)
    x, y = np.zeros(len(result.times)), np.zeros(len(result.times))
    for k in range(links):
        x_tip, y_tip = (
            values(result, f"link[{k + 1}].tip.x"),
            values(result, f"link[{k + 1}].tip.y"),
        )
        assert np.max(np.abs(np.hypot(x_tip - x, y_tip - y) - 1)) < 1e-6
        x, y = x_tip, y_tip
    swing = values(result, "link[1].phi")
    assert swing[0] == pytest.approx(np.pi / 2)
    assert np.ptp(swing) > 0.1


def test_the_first_hinge_carries_weight_and_motion_of_all_links(simulate: Any) -> None:
    result = simulate("pendulum_chain", "TriplePendulum", stop_time=3, tolerance=1e-9, points=3001)
    vertical = sum(values(result, f"link[{k}].vy") for k in (1, 2, 3))
    force = -values(result, "anchor.hinge.fy")
    rate = np.gradient(vertical, result.times)
    middle = slice(5, -5)
    expected = force[middle] - 3 * G
    assert np.median(np.abs(rate[middle] - expected)) < 1e-2 * np.max(np.abs(expected))


def test_spherical_pendulum(simulate: Any) -> None:
    result = simulate("spherical_pendulum", stop_time=10, tolerance=1e-9)
    x, y, z = (values(result, name) for name in "xyz")
    assert np.max(np.abs(x**2 + y**2 + z**2 - 1)) < 1e-7
    assert values(result, "energy") == pytest.approx(2 - G / 2, abs=1e-5)
    assert values(result, "momentum") == pytest.approx(np.sin(np.pi / 3) * 2, abs=1e-6)
    assert np.ptp(z) > 0.1


@pytest.mark.parametrize("pieces", [1, 6, 200])
def test_beam_swings_in_its_first_mode(simulate: Any, pieces: int) -> None:
    continuum = np.pi / 2 * np.sqrt(2.1e11 / 7850)
    discrete = 2 * pieces * np.sqrt(2.1e11 / 7850) * np.sin(np.pi / (4 * pieces))
    result = simulate(
        "longitudinal_beam", None, {"n": pieces}, stop_time=2e-3, tolerance=1e-8, points=101
    )
    tip = values(result, f"piece[{pieces}].s")
    assert tip == pytest.approx(tip[0] * np.cos(discrete * result.times), abs=2e-8)
    assert discrete == pytest.approx(continuum, rel=np.pi**2 / (90 * pieces**2) + 1e-12)
