"""The crane crab and the crank engine of the examples."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from acausal import compile_text
from tests.library.planar.mechanisms import ROOT, G, run_example, solution, values


def crab(length: float, force: Any) -> Any:
    """Return the equations of motion by Lagrange; force is a function of the state."""

    def motion(_: float, y: np.ndarray) -> list[float]:
        s, phi, v, w = y
        c, sine = np.cos(phi), np.sin(phi)
        mass = [[320, 70 * length * c], [70 * length * c, 70 * length**2]]
        f = force(s, phi, v, w)
        right = [f + 70 * length * w**2 * sine, -70 * G * length * sine]
        return [v, w, *np.linalg.solve(mass, right)]

    return motion


@pytest.mark.parametrize(
    ("model", "length", "phi0", "force"),
    [
        ("CraneCrab", 2.5, 20, lambda s, phi, v, w: 0.0),
        (
            "ControlledCraneCrab",
            2.5,
            20,
            lambda s, phi, v, w: -1000 * (s - 3) - 1510 * v + 3110 * phi + 7 * w,
        ),
        (
            "InvertedCraneCrab",
            -2.5,
            15,
            lambda s, phi, v, w: 1000 * s + 2270 * v - 23600 * phi - 11500 * w,
        ),
    ],
)
def test_crane_crab(model: str, length: float, phi0: float, force: Any) -> None:
    result = run_example("crane_crab", model, tolerance=1e-9)
    expected = solution(crab(length, force), [0, np.radians(phi0), 0, 0], result.times)
    assert values(result, "slide.s") == pytest.approx(expected[0], abs=1e-5)
    assert values(result, "joint.phi") == pytest.approx(expected[1], abs=1e-5)
    if model == "CraneCrab":
        assert np.ptp(values(result, "energy")) < 1e-4
    else:
        place = 3 if model == "ControlledCraneCrab" else 0
        assert values(result, "slide.s")[-1] == pytest.approx(place, abs=0.01)
        assert values(result, "joint.phi")[-1] == pytest.approx(0, abs=0.01)


def test_crank_engine() -> None:
    text = (
        (ROOT / "examples/crank_engine.acm").read_text()
        + """
model Measured
  extends CrankEngine;
  si.Energy work(start = 0, fixed = true), spent(start = 0, fixed = true);
equation
  der(work) = indicated;
  der(spent) = load;
end Measured;
"""
    )
    result = compile_text(text, model="Measured").simulate(
        stop_time=0.5, points=5001, tolerance=1e-8
    )
    phi, w = values(result, "shaft.phi"), values(result, "shaft.w")
    # the piston is where the slider-crank says
    x = 0.04 * np.cos(phi) + np.sqrt(0.13**2 - 0.04**2 * np.sin(phi) ** 2)
    assert values(result, "cylinder.s") == pytest.approx(x, abs=1e-7)
    # every cycle gives the work of two polytropic curves
    clearance = 0.08 * np.pi / 4 * 0.08**2 / (9 - 1)
    compression = 1e5 * 9**1.3 * clearance * (1 - 9**-0.3) / 0.3
    work = values(result, "work")
    cycles = np.arange(0, phi[-1] // (4 * np.pi) + 1)
    assert len(cycles) > 5
    assert np.interp(4 * np.pi * cycles, phi, work) == pytest.approx(
        cycles * 2 * compression, abs=0.5
    )
    assert values(result, "p").max() == pytest.approx(3e5 * 9**1.3, rel=1e-6)
    # what is not spent is in the motion
    rod = np.array([values(result, f"rod.body.v[{k}]") for k in (1, 2)])
    kinetic = (
        (0.25 + 4e-3) * w**2
        + 0.4 * values(result, "cylinder.v") ** 2
        + 0.5 * (rod**2).sum(axis=0)
        + 0.5 * 0.13**2 / 12 * values(result, "rod.w") ** 2
    ) / 2
    potential = G * (0.4 * x + 0.5 * values(result, "rod.body.r[1]"))
    balance = kinetic + potential - work + values(result, "spent")
    assert balance == pytest.approx(balance[0], abs=0.01)
    assert np.ptp(kinetic) > 100
