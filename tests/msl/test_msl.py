"""Examples of the Modelica Standard Library stay inside the tube around their published references."""

from __future__ import annotations

import csv
import gzip
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.msl.tube import tube

from acausal import compile_file

HERE = Path(__file__).parent
DATA = HERE.parent / "data" / "msl"
CASES = sorted(path.stem for path in HERE.glob("*.acm"))


def description(case: str) -> dict[str, Any]:
    data: dict[str, Any] = json.loads((DATA / f"{case}.json").read_text())
    return data


def read_reference(case: str) -> dict[str, np.ndarray]:
    with gzip.open(DATA / f"{case}.csv.gz", "rt") as file:
        rows = list(csv.reader(file))
    table = np.array(rows[1:], dtype=float)
    return {name if k else "time": table[:, k] for k, name in enumerate(rows[0])}


def simulate(case: str) -> Any:
    about = description(case)
    run = about["experiment"]
    compiled = compile_file(HERE / f"{case}.acm", model=about["model"])
    return compiled.simulate(
        stop_time=run["stop"],
        interval=run["interval"],
        tolerance=min(run["solver_tolerance"], 1e-6),
    )


@pytest.mark.parametrize("case", [c for c in CASES if (DATA / f"{c}.csv.gz").is_file()])
def test_inside_the_tube(case: str) -> None:
    result = simulate(case)
    reference = read_reference(case)
    worst = {}
    for signal in description(case)["signals"]:
        bounds = tube(reference["time"], reference[signal], result.times)
        worst[signal] = bounds.worst(np.asarray(result[signal].values))
    print(f"{case}: {worst}")
    assert max(worst.values()) == 0.0, worst


@pytest.mark.parametrize(
    "case",
    [c for c in CASES if not (DATA / f"{c}.csv.gz").is_file() and description(c)["times"]],
)
def test_inside_the_tube_at_the_known_times(case: str) -> None:
    # Of these references only some samples of the tube are known.
    about = description(case)
    result = simulate(case)
    worst = {}
    for signal, bounds in about["tube"].items():
        values = np.interp(about["times"], result.times, result[signal].values)
        low, high = np.array(bounds).T
        worst[signal] = float(np.max(np.maximum(low - values, values - high)))
    print(f"{case}: {worst}")
    assert max(worst.values()) <= 0.0, worst


def test_both_transformers_agree() -> None:
    # There is no reference: coupled coils and an ideal transformer with stray coils are the same.
    result = simulate("Electrical.Analog.CompareTransformers")
    for basic, ideal in (("v1B", "v1I"), ("i1B", "i1I"), ("v2B", "v2I"), ("i2B", "i2I")):
        expected = np.asarray(result[ideal].values)
        size = np.ptp(expected)
        assert np.asarray(result[basic].values) == pytest.approx(expected, abs=2e-3 * size)
        assert size > 1e-3


def test_the_tube_accepts_itself_and_refuses_a_shift() -> None:
    times = np.linspace(0.0, 1.0, 501)
    values = np.sin(20 * times)
    assert tube(times, values, times).worst(values) == 0.0
    assert tube(times, values, times).worst(values + 0.003) == 0.0
    assert tube(times, values, times).worst(values + 0.2) > 10.0


def test_the_tube_is_as_wide_as_it_is_said_to_be() -> None:
    times = np.array([0.0, 0.5, 0.5, 1.0])
    step = np.array([0.0, 0.0, 1.0, 1.0])
    at = np.array([0.4975, 0.4985, 0.5015, 0.5025])
    bounds = tube(times, step, at)
    assert bounds.lower == pytest.approx([-0.002, -0.002, -0.002, 0.998])
    assert bounds.upper == pytest.approx([0.002, 1.002, 1.002, 1.002])
