"""S15, S16 and S27: what happens suddenly happens at the right time and by the right amount."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

DATA = Path(__file__).parents[1] / "data" / "classic"


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def reference(name: str) -> Any:
    return json.loads((DATA / f"{name}.json").read_text())


@pytest.mark.parametrize("case", range(4))
def test_bouncing_ball_hits_the_floor_in_time(simulate: Any, case: int) -> None:
    about = reference("bouncing_ball")["cases"][case]
    start = {"h0": about["h0"], "v0": about["v0_up"], "e": about["e"]}
    known = np.array([float(t) for t in about["impact_times"]])
    stop = (known[-1] + known[-2]) / 2
    result = simulate("bouncing_ball", None, start, stop_time=stop, tolerance=1e-10)
    t, impacts = result.times, values(result, "impacts")
    found = t[1:][np.diff(impacts) > 0]
    assert len(found) == len(known) - 1
    assert found == pytest.approx(known[:-1], abs=1e-9)
    before = t[:-1][np.diff(impacts) > 0]
    assert before == pytest.approx(known[:-1], abs=1e-9)
    speeds = np.array([float(v) for v in about["impact_speeds_before"]])[:-1]
    v = values(result, "v")
    jump = np.flatnonzero(np.diff(impacts) > 0)
    assert v[jump] == pytest.approx(-speeds, abs=1e-8)
    assert v[jump + 1] == pytest.approx(about["e"] * speeds, abs=1e-8)


@pytest.mark.parametrize("case", range(4))
def test_bouncing_ball_comes_to_rest_on_the_floor(simulate: Any, case: int) -> None:
    about = reference("bouncing_ball")["cases"][case]
    start = {"h0": about["h0"], "v0": about["v0_up"], "e": about["e"]}
    result = simulate("bouncing_ball", None, start, stop_time=10, tolerance=1e-9)
    t, h, v = result.times, values(result, "h"), values(result, "v")
    rest = t > float(about["zeno_time"]) + 1e-6
    assert np.sum(rest) > 10
    assert h[rest] == pytest.approx(0, abs=1e-9)
    assert v[rest] == pytest.approx(0, abs=1e-9)
    assert np.min(h) > -1e-9


@pytest.mark.parametrize(("variant", "sticky"), [("clipped", False), ("unclipped", True)])
def test_percussion_hammer_strikes_ten_times(simulate: Any, variant: str, sticky: bool) -> None:
    about = reference("percussion_hammer")["variants"][variant]
    result = simulate(
        "percussion_hammer", None, {"contact.sticky": sticky}, stop_time=0.5, tolerance=1e-10
    )
    impacts = values(result, "impacts")
    strikes = np.flatnonzero(np.diff(impacts) > 0) + 1
    known = about["impacts"]
    assert len(strikes) == len(known) == 10
    times = np.array([one["t_begin"] for one in known])
    assert result.times[strikes] == pytest.approx(times, abs=1e-7)
    assert values(result, "t_impact")[strikes] == pytest.approx(times, abs=1e-7)
    speeds = np.array([one["v_impact"] for one in known])
    assert values(result, "v_impact")[strikes] == pytest.approx(speeds, abs=1e-4)
    rebounds = values(result, "v_rebound")[[*(strikes[1:] - 1), -1]]
    assert rebounds == pytest.approx([one["v_rebound"] for one in known], abs=1e-4)
    assert -rebounds / speeds == pytest.approx([one["restitution"] for one in known], abs=1e-5)
    samples = about["samples"]
    at = np.array([one["t"] for one in samples])
    x = np.interp(at, result.times, values(result, "piston.s"))
    assert x == pytest.approx([one["x"] for one in samples], abs=1e-4)


def test_impact_exchanges_momentum(simulate: Any) -> None:
    result = simulate("discontinuities", "Impact", stop_time=1, tolerance=1e-9)
    left, right = values(result, "left.v"), values(result, "right.v")
    after = result.times > 0.5 + 1e-6
    assert left[after] == pytest.approx(1.5, abs=1e-9)
    assert right[after] == pytest.approx(3.0, abs=1e-9)
    assert 2 * left + right == pytest.approx(6, abs=1e-9)


def test_stick_slip_has_the_phases_of_the_closed_form(simulate: Any) -> None:
    # Stick at 0.1 m/s until the spring pulls with 5 N; slip as an oscillator about the 3 N of
    # friction until the mass is as fast as the belt again.
    result = simulate("discontinuities", "StickSlip", stop_time=5, tolerance=1e-10)
    t, s, v = result.times, values(result, "mass.s"), values(result, "mass.v")
    speed, frequency, amplitude = 0.1, 10.0, 0.02
    slip = (2 * np.pi - 2 * np.arctan(amplitude * frequency / speed)) / frequency
    stick = 2 * amplitude / speed
    first = 0.05 / speed
    phase = (t - first) % (slip + stick)
    slips = (t > first) & (phase < slip)
    middle, angle = 0.03, frequency * phase
    expected = np.where(
        slips,
        middle + amplitude * np.cos(angle) + speed / frequency * np.sin(angle),
        np.where(t <= first, speed * t, middle - amplitude + speed * (phase - slip)),
    )
    assert s == pytest.approx(expected, abs=1e-6)
    mode = values(result, "friction.mode")
    inner = np.minimum(np.abs(phase - slip), np.minimum(phase, slip + stick - phase)) > 1e-4
    assert set(mode[inner & slips]) == {-1.0}
    assert set(mode[inner & ~slips]) == {0.0}
    # Stuck is stuck: no creep.
    relative = values(result, "friction.v_rel")[inner & ~slips]
    assert np.max(np.abs(relative)) < 1e-25
    assert np.all(v <= speed + 1e-9)
    assert np.sum(np.diff(mode) != 0) == 2 * int((5 - first) / (slip + stick)) + 2
    energy_lost = values(result, "friction.lossPower")
    assert np.all(energy_lost >= -1e-9)


def test_play_keeps_the_energy(simulate: Any) -> None:
    result = simulate("discontinuities", "Play", stop_time=5, tolerance=1e-10)
    v, e = values(result, "mass.v"), np.abs(values(result, "mass.s")) - 0.1
    energy = v**2 / 2 + 200 * np.maximum(e, 0) ** 2
    assert energy == pytest.approx(0.5, abs=1e-6)
    v_free = np.abs(v[e < 0])
    assert v_free == pytest.approx(1, abs=1e-6)
