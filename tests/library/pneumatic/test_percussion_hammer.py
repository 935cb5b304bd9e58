"""S16 from components against the reference solution and against the model in equations."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acausal import compile_file

ROOT = Path(__file__).parents[3]
DATA = ROOT / "tests" / "data" / "classic" / "percussion_hammer.json"


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


@pytest.fixture(scope="module")
def hammer() -> Any:
    model = compile_file(ROOT / "examples" / "percussion_hammer_components.acm")
    return model.simulate(stop_time=0.5, tolerance=1e-10)


def test_impacts_of_the_reference(hammer: Any) -> None:
    about = json.loads(DATA.read_text())["variants"]["clipped"]
    strikes = np.flatnonzero(np.diff(values(hammer, "impacts")) > 0) + 1
    known = about["impacts"]
    assert len(strikes) == len(known) == 10
    times = np.array([one["t_begin"] for one in known])
    assert hammer.times[strikes] == pytest.approx(times, abs=1e-7)
    speeds = np.array([one["v_impact"] for one in known])
    assert values(hammer, "v_impact")[strikes] == pytest.approx(speeds, abs=1e-4)
    rebounds = values(hammer, "v_rebound")[[*(strikes[1:] - 1), -1]]
    assert rebounds == pytest.approx([one["v_rebound"] for one in known], abs=1e-4)
    assert values(hammer, "restitution")[-1] == pytest.approx(known[-1]["restitution"], abs=1e-5)
    samples = about["samples"]
    at = np.array([one["t"] for one in samples])
    x = np.interp(at, hammer.times, values(hammer, "piston.s"))
    assert x == pytest.approx([one["x"] for one in samples], abs=1e-4)


def test_model_in_equations_moves_alike(hammer: Any) -> None:
    model = compile_file(ROOT / "examples" / "percussion_hammer.acm")
    other = model.simulate(stop_time=0.5, tolerance=1e-10)
    at = np.linspace(0, 0.5, 501)
    for path in ("piston.s", "air.p", "impacts"):
        one, two = (np.interp(at, r.times, values(r, path)) for r in (hammer, other))
        scale = np.max(np.abs(two))
        assert one == pytest.approx(two, abs=1e-4 * scale)


def test_motor_gives_what_the_air_takes(hammer: Any) -> None:
    # The crank passes on power: torque times speed is the force on the slider times its velocity.
    phi = values(hammer, "crank.phi")
    w = 1300 * 2 * np.pi / 60
    root = np.sqrt(0.076**2 - (0.022 * np.sin(phi)) ** 2)
    speed = w * (0.022 * np.sin(phi) + 0.022**2 * np.sin(phi) * np.cos(phi) / root)
    torque, force = values(hammer, "crank.flange_a.tau"), values(hammer, "crank.flange_b.f")
    assert torque * w + force * speed == pytest.approx(0, abs=1e-6 * np.max(np.abs(torque * w)))
