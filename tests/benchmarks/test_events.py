"""The models of the benchmark of events, and its C programs, give what they should."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from acausal import compile_file  # noqa: E402
from benchmarks import spice  # noqa: E402
from benchmarks.events import CASES, FILE, Case  # noqa: E402
from benchmarks.processes import FailedError  # noqa: E402
from benchmarks.reference_program import EVENTS, ReferenceProgram, build  # noqa: E402

DATA = ROOT / "tests" / "data" / "hybrid"
BY_MODEL = {case.model: case for case in CASES}


def reference(name: str) -> dict[str, Any]:
    data: dict[str, Any] = json.loads((DATA / f"{name}.json").read_text(encoding="utf-8"))
    return data


def ball(stop: float) -> tuple[int, float]:
    """Bounces until a time, and the height then."""
    first, speed = np.sqrt(2 / 9.81), np.sqrt(2 * 9.81)
    bounces = int((stop + first) // (2 * first))
    since = stop - (2 * bounces - 1) * first
    return bounces, speed * since - 9.81 * since**2 / 2


def pwm_at_period(number: int) -> float:
    """Current at the end of a period, from zero."""
    rate = 2 / 10e-3
    q, on = np.exp(-rate * 1e-4), np.exp(-rate * 0.4e-4)
    gain = 12 * (1 - on) * np.exp(-rate * 0.6e-4)
    return float(gain * (1 - q**number) / (1 - q))


def ends() -> dict[str, tuple[float, float]]:
    """Stop times and values there, by model."""
    found = {"Ball": (20.0, ball(20.0)[1]), "Pwm": (0.01, pwm_at_period(100))}
    for model, name, point, place in (
        ("HalfWave", "half_wave", 30, 0),
        ("Bridge", "full_wave_bridge", 30, 0),
        ("StickSlip", "stick_slip", 81, 0),
    ):
        data = reference(name)
        found[model] = data["times"][point], data["values"][point][place]
    found["Buck"] = 40 / 50e3, reference("buck_continuous")["at_end_of_period"][39][1]
    return found


ENDS = ends()


@pytest.mark.parametrize("model", sorted(ENDS))
def test_models_end_where_they_should(model: str) -> None:
    case, (stop, value) = BY_MODEL[model], ENDS[model]
    result = compile_file(FILE, model=model).simulate(stop_time=stop, tolerance=1e-8, points=2)
    assert result.ending.value == "complete"
    assert abs(float(result[case.compared].values[-1]) - value) <= 1e-5 * case.scale


def test_the_ball_counts_its_bounces() -> None:
    result = compile_file(FILE, model="Ball").simulate(stop_time=20.0, tolerance=1e-8)
    assert float(result["bounces"].values[-1]) == ball(20.0)[0]
    energy = result["energy"].values
    assert np.ptp(energy) <= 1e-5 * energy[0]


def test_relations_that_never_change_make_no_event() -> None:
    values = []
    for clamped in (True, False):
        model = compile_file(FILE, model="Array", parameters={"N": 20, "clamped": clamped})
        result = model.simulate(points=2)
        assert not result.events
        values.append([float(result[f"v[{k}]"].values[-1]) for k in range(1, 21)])
    np.testing.assert_allclose(values[0], values[1], rtol=0, atol=1e-6)


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> ReferenceProgram:
    try:
        return build(tmp_path_factory.mktemp("program"), EVENTS)
    except FailedError as reason:
        pytest.skip(str(reason))


@pytest.mark.parametrize("model", sorted(ENDS))
def test_c_programs_end_where_they_should(
    model: str, program: ReferenceProgram, tmp_path: Path
) -> None:
    case, (stop, value) = BY_MODEL[model], ENDS[model]
    program.solve_events(case.reference, 1, stop, (1e-9, 1e-12), end_file=tmp_path / "end")
    found = float(np.fromfile(tmp_path / "end")[1 + case.place])
    assert abs(found - value) <= 2e-7 * case.scale


@pytest.mark.skipif(shutil.which("ngspice") is None, reason="ngspice is not installed")
@pytest.mark.parametrize("case", [c for c in CASES if c.circuit], ids=lambda c: str(c.circuit))
def test_circuits_are_the_same(case: Case, tmp_path: Path) -> None:
    stop, value = ENDS[case.model]
    found = spice.solve(case.circuit, case.quantity, stop, case.step, 1e-5, tmp_path)
    assert abs(case.factor * found["final"] - value) <= 1e-2 * case.scale
    assert found["points"] > 10
