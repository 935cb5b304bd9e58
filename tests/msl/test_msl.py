"""Examples of the Modelica Standard Library stay in the tube around their references."""

from __future__ import annotations

import csv
import gzip
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from acausal import compile_file
from tests.msl.tube import tube

HERE = Path(__file__).parent
DATA = HERE.parent / "data" / "msl"
CASES = sorted(path.stem for path in HERE.glob("*.acm"))


# The tool that made these references took no notice of the events: it has no samples at the jumps,
# so its peaks are cut off. Ours are compared where it has samples.
NO_EVENTS_IN_REFERENCE = {"Electrical.Analog.OpAmps.Multivibrator"}


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
    assert result.times[-1] == pytest.approx(reference["time"][-1])
    compared = np.ones(len(result.times), np.bool_)
    if case in NO_EVENTS_IN_REFERENCE:
        compared = np.isin(np.round(result.times, 9), np.round(reference["time"], 9))
    worst = {}
    for signal in description(case)["signals"]:
        bounds = tube(reference["time"], reference[signal], result.times[compared])
        worst[signal] = bounds.worst(np.asarray(result[signal].values)[compared])
    print(f"{case}: {worst}")
    assert max(worst.values()) == 0.0, worst


@pytest.mark.parametrize(
    "case",
    [c for c in CASES if not (DATA / f"{c}.csv.gz").is_file() and description(c)["tube"]],
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


@pytest.fixture(scope="module")
def transformers() -> Any:
    # There is no published reference; the first seconds suffice.
    compiled = compile_file(HERE / "Electrical.Analog.CompareTransformers.acm")
    return compiled.simulate(stop_time=2, points=2001, tolerance=1e-8)


def voltage(t: float) -> float:
    return 0.1 + 0.1 * np.sin(2 * np.pi * 10 * t + np.pi / 2)


def test_coupled_coils_against_their_equations(transformers: Any) -> None:
    omega, n = 2 * np.pi * 10, 2.0
    mutual = 10 / omega / n
    primary, secondary = 0.05 / omega + mutual * n, 0.05 / omega / n**2 + mutual / n
    inductance = np.linalg.inv([[primary, mutual], [mutual, secondary]])
    resistance = np.array([0.01, 0.01 / n**2 + 1 / n**2])
    expected = solve_ivp(
        lambda t, i: inductance @ (np.array([voltage(t), 0]) - resistance * i),
        (0, 2),
        [0, 0],
        "Radau",
        transformers.times,
        rtol=1e-9,
        atol=1e-11,
    ).y
    for path, current in zip(("i1B", "i2B"), expected, strict=True):
        found = np.asarray(transformers[path].values)
        # the current of the load resistor leaves the second coil
        found = found if path == "i1B" else -found
        assert found == pytest.approx(current, abs=1e-6)


def test_ideal_transformer_against_its_equation(transformers: Any) -> None:
    omega, n = 2 * np.pi * 10, 2.0
    inductance, resistance = 0.05 / omega * 2, 0.01 + 0.01 + 1
    expected = solve_ivp(
        lambda t, i: (voltage(t) - resistance * i) / inductance,
        (0, 2),
        [0],
        "Radau",
        transformers.times,
        rtol=1e-9,
        atol=1e-11,
    ).y[0]
    assert np.asarray(transformers["i1I"].values) == pytest.approx(expected, abs=1e-6)
    assert np.asarray(transformers["i2I"].values) == pytest.approx(n * expected, abs=2e-6)


def test_both_transformers_agree_with_a_magnetising_current() -> None:
    compiled = compile_file(
        HERE / "Electrical.Analog.CompareTransformers.acm",
        parameters={"idealTransformer.considerMagnetization": True},
    )
    result = compiled.simulate(stop_time=2, points=2001, tolerance=1e-8)
    for basic, ideal in (("v1B", "v1I"), ("i1B", "i1I"), ("v2B", "v2I"), ("i2B", "i2I")):
        expected = np.asarray(result[ideal].values)
        assert np.asarray(result[basic].values) == pytest.approx(expected, abs=1e-5)
        assert np.ptp(expected) > 1e-2


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
