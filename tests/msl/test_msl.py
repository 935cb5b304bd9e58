"""Examples of the Modelica Standard Library stay in the tube around their references."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from acausal import compile_file
from tests.msl.__main__ import lines
from tests.msl.cases import (
    DATA,
    HERE,
    REASONS,
    SIGNALS,
    Comparison,
    compare,
    description,
    has_reference,
    shares,
    simulate,
)
from tests.msl.tube import share, tube

CASES = sorted(path.stem for path in HERE.glob("*.acm"))
COMPARED = [c for c in CASES if has_reference(c) or description(c)["tube"]]


@pytest.mark.parametrize("case", COMPARED)
def test_inside_the_tube(case: str) -> None:
    found = shares(case, simulate(case))
    print(f"{case}: {found}")
    assert set(found) >= set(SIGNALS[case])
    assert max(found.values()) <= 1.0, found


def test_every_case_is_compared_or_has_a_reason() -> None:
    assert len(SIGNALS) == 71
    assert sorted(set(CASES) - set(SIGNALS)) == []
    assert sorted(set(REASONS) & set(COMPARED)) == []
    assert (DATA / "_cases.json").is_file()


def test_the_table_tells_what_fails(tmp_path: Any) -> None:
    good = Comparison("A.Good", {"x": 0.25, "y": 0.5}, 1.0)
    bad = Comparison("A.Bad", {"x": 1.5}, 1.0)
    table = lines([good, bad, Comparison("A.Away", {}, reason="not translated")])
    assert table[1].split() == ["A.Good", "2", "0.500", "y", "1.00", "s"]
    assert table[2].endswith("!")
    assert table[-3:] == [
        "1 of 3 cases inside of the tube, 3 signals",
        "  A.Bad: x leaves the tube",
        "  A.Away: not translated",
    ]
    assert math.isnan(compare("Electrical.Unknown").worst[1])
    assert compare("Electrical.Unknown").reason == "not translated"


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
    assert share(times, values, times, values) < 0.02
    assert share(times, values, times, values + 0.002) == pytest.approx(0.4, abs=0.15)
    assert share(times, values, times, values + 0.2) > 10.0


def test_the_tube_is_as_wide_as_it_is_said_to_be() -> None:
    times = np.array([0.0, 0.5, 0.5, 1.0])
    step = np.array([0.0, 0.0, 1.0, 1.0])
    at = np.array([0.4975, 0.4985, 0.5015, 0.5025])
    bounds = tube(times, step, at)
    assert bounds.lower == pytest.approx([-0.002, -0.002, -0.002, 0.998])
    assert bounds.upper == pytest.approx([0.002, 1.002, 1.002, 1.002])
