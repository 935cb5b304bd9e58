"""Trajectories of classic systems against solutions of much higher accuracy.

The references (closed forms in 30 digits, or extrapolation in extended precision) are in
``tests/data/classic``.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acausal import compile_file

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
HERE = Path(__file__).parent


def reference(name: str) -> dict[str, Any]:
    """Return a reference of ``tests/data/classic``."""
    data: dict[str, Any] = json.loads((ROOT / "tests/data/classic" / f"{name}.json").read_text())
    return data


def check(
    result: Any, rows: list[dict[str, Any]], columns: dict[str, str], tolerance: float
) -> None:
    """Compare at the reference's times; ``columns`` maps our paths to the reference's names."""
    for row in rows:
        time = float(row["t"])
        index = int(np.argmin(np.abs(result.times - time)))
        assert result.times[index] == pytest.approx(time, rel=1e-9, abs=1e-12)
        for path, column in columns.items():
            expected = float(row[column])
            actual = float(result[path].values[index])
            assert actual == pytest.approx(expected, abs=tolerance), (path, time)


@pytest.mark.parametrize("case", reference("pendulum")["cases"], ids=lambda c: c["theta0_deg"])
def test_pendulum_in_cartesian_coordinates(case: dict[str, Any]) -> None:
    compiled = compile_file(
        EXAMPLES / "cartesian_pendulum.acm", parameters={"phi0": np.radians(case["theta0_deg"])}
    )
    result = compiled.simulate(stop_time=10, interval=0.25, tolerance=1e-11)
    check(result, case["trajectory"], {"x": "x", "y": "y", "lambda": "tension_per_mass"}, 1e-5)


@pytest.mark.parametrize("case", reference("pendulum")["cases"], ids=lambda c: c["theta0_deg"])
def test_pendulum_as_a_component(case: dict[str, Any]) -> None:
    compiled = compile_file(
        EXAMPLES / "pendulum_chain.acm",
        model="SinglePendulum",
        parameters={"phi0[1]": np.radians(case["theta0_deg"])},
    )
    result = compiled.simulate(stop_time=10, interval=0.25, tolerance=1e-11)
    columns = {"link[1].phi": "theta", "link[1].w": "omega", "link[1].tip.x": "x"}
    check(result, case["trajectory"], columns, 5e-6)


@pytest.mark.parametrize(
    "case", reference("double_pendulum_point_masses")["cases"], ids=lambda c: c["initial"]
)
def test_double_pendulum(case: dict[str, Any]) -> None:
    compiled = compile_file(
        EXAMPLES / "pendulum_chain.acm",
        model="DoublePendulum",
        parameters={f"phi0[{k + 1}]": float(angle) for k, angle in enumerate(case["theta0"])},
    )
    result = compiled.simulate(stop_time=5, interval=0.5, tolerance=1e-10)
    columns = {
        "link[1].phi": "theta1",
        "link[2].phi": "theta2",
        "link[1].w": "omega1",
        "link[2].w": "omega2",
        "link[2].tip.x": "x2",
        "link[2].tip.y": "y2",
    }
    check(result, case["trajectory"], columns, 2e-4)
    assert result["energy"].values == pytest.approx(float(case["energy"]), abs=1e-5)


@pytest.mark.parametrize("case", reference("lotka_volterra")["cases"], ids=lambda c: c["alpha"])
def test_lotka_volterra(case: dict[str, Any]) -> None:
    compiled = compile_file(
        EXAMPLES / "predator_prey.acm",
        model="PredatorPrey",
        parameters={
            "a": case["alpha"],
            "b": case["beta"],
            "c": case["gamma"],
            "d": case["delta"],
            "xB0": case["x0"],
            "xR0": case["y0"],
        },
    )
    result = compiled.simulate(stop_time=20, interval=1, tolerance=1e-10)
    check(result, case["trajectory"], {"xB": "x", "xR": "y"}, 1e-5)
    assert result["invariant"].values == pytest.approx(float(case["invariant"]), abs=1e-5)


@pytest.mark.parametrize("case", reference("logistic")["cases"], ids=lambda c: c["r"])
def test_logistic(case: dict[str, Any]) -> None:
    compiled = compile_file(
        EXAMPLES / "logistic_growth.acm",
        model="LogisticGrowth",
        parameters={"a": case["r"], "k": case["K"], "x0": case["y0"]},
    )
    result = compiled.simulate(stop_time=10, interval=0.5, tolerance=1e-9)
    check(result, case["values"], {"x": "y"}, 1e-6 * case["K"])


@pytest.mark.parametrize("mode", range(6))
def test_beam_of_six_masses(mode: int) -> None:
    # A chain of equal springs, fixed at one end: it swings in one eigenmode if it starts in it.
    systems = reference("beam_6_masses")["systems"]
    chain = systems["longitudinal_or_torsional_chain_6_equal_masses"]["fixed-free"]
    n, length, area, rho, elasticity = 6, 1.0, 1e-4, 7850.0, 2.1e11
    stiffness, mass = elasticity * area * n / length, rho * area * length / n
    omega = float(chain["omega_over_sqrt_c_m"][mode]) * np.sqrt(stiffness / mass)
    shape = 1e-3 * np.sin((2 * mode + 1) * np.pi / (2 * n + 1) * np.arange(1, n + 1))
    compiled = compile_file(
        EXAMPLES / "longitudinal_beam.acm",
        parameters={"n": n, "wallFactor": 1.0, **{f"u0[{i + 1}]": shape[i] for i in range(n)}},
    )
    result = compiled.simulate(stop_time=4 * np.pi / omega, points=41, tolerance=1e-9)
    swing = np.cos(omega * result.times)
    for i in range(n):
        assert result[f"piece[{i + 1}].s"].values == pytest.approx(shape[i] * swing, abs=1e-8)


@pytest.mark.parametrize("case", reference("rlc_series_step")["cases"], ids=lambda c: c["R"])
def test_series_rlc(case: dict[str, Any]) -> None:
    names = ("R", "L", "C", "U")
    compiled = compile_file(
        HERE / "rlc_series_step.acm", parameters={name: case[name] for name in names}
    )
    times = [float(row["t"]) for row in case["step_response"]]
    result = compiled.simulate(stop_time=times[-1], interval=times[1], tolerance=1e-9)
    check(result, case["step_response"], {"c.v": "u_C", "l.i": "i"}, 1e-6)


@pytest.mark.parametrize(
    "case", reference("spring_mass_damper")["cases"], ids=lambda c: f"{c['m']}-{c['d']}-{c['c']}"
)
def test_spring_mass_damper(case: dict[str, Any]) -> None:
    names = {"m": "m", "d": "d", "c": "c", "x0": "x0", "v0": "v0", "F": "F_step"}
    compiled = compile_file(
        HERE / "spring_mass_damper.acm",
        parameters={ours: case[theirs] for ours, theirs in names.items()},
    )
    result = compiled.simulate(stop_time=5, interval=0.1, tolerance=1e-9)
    check(result, case["trajectory"], {"mass.s": "x", "mass.v": "v"}, 1e-6)
