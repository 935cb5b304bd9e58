"""Quarter and half car, suspension parts."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acausal import compile_file
from tests.library.vehicle.running import DATA, simulate, values

EXAMPLE = Path(__file__).parents[3] / "examples" / "quarter_car.acm"
CASES = json.loads((DATA / "quarter_car.json").read_text())["cases"]


@pytest.mark.parametrize("case", CASES, ids=[case["note"] for case in CASES])
def test_step_of_the_road(case: dict[str, Any]) -> None:
    parameters = {f"car.{name}": float(case[name]) for name in ("c_R", "d_A")}
    compiled = compile_file(EXAMPLE, model="RoadStep", parameters=parameters)
    stop = float(case["road_step_0_05m"][-1]["t"])
    result = compiled.simulate(stop_time=stop, tolerance=1e-10, points=round(stop / 0.01) + 1)
    names = {"z_A": "z_A", "v_A": "body.v", "z_R": "z_R", "v_R": "wheel.v"}
    assert len(case["road_step_0_05m"]) > 5
    for row in case["road_step_0_05m"]:
        k = int(np.argmin(np.abs(result.times - float(row["t"]))))
        for theirs, ours in names.items():
            assert values(result, f"car.{ours}")[k] == pytest.approx(float(row[theirs]), abs=1e-7)
    load = -float(case["c_R"]) * (values(result, "car.z_R") - 0.05)
    assert values(result, "car.F_dyn") == pytest.approx(load, abs=1e-4)


def test_worksheet_resonates_with_the_eigenfrequency() -> None:
    result = compile_file(EXAMPLE, model="Worksheet").simulate(stop_time=60, tolerance=1e-8)
    case = next(c for c in CASES if c["c_R"] == 25000 and c["d_A"] == 250)
    c_a, c_r, d, m_a, m_r, w = 25e3, 25e3, 250, 380, 35, 2 * np.pi * 0.9025
    stiffness = np.array(
        [
            [c_a + 1j * w * d - w**2 * m_a, -c_a - 1j * w * d],
            [-c_a - 1j * w * d, c_a + c_r + 1j * w * d - w**2 * m_r],
        ]
    )
    amplitude = np.linalg.solve(stiffness, [0, c_r * 0.01])
    late = result.times > 55
    assert np.ptp(values(result, "car.z_A")[late]) / 2 == pytest.approx(abs(amplitude[0]), rel=0.06)
    assert abs(amplitude[0]) > 10 * 0.01
    assert float(case["eigenvalues"][0]["f_Hz"]) == pytest.approx(0.9025, rel=1e-3)


def test_half_car_moves_in_its_eigenmodes() -> None:
    result = simulate(
        """  HalfCar car(body(z(start = 0.02, fixed = true), v(fixed = true), theta(fixed = true),
    w(start = 0.1, fixed = true)), front(wheel(s(fixed = true), v(fixed = true))),
    rear(wheel(s(fixed = true), v(fixed = true))));
  Fixed ground;
equation
  connect(ground.flange, car.road_front, car.road_rear);
""",
        stop_time=1.5,
        tolerance=1e-10,
    )
    m = np.diag([700.0, 1100.0, 40.0, 40.0])
    front, rear = np.array([1.0, -1.2, -1.0, 0.0]), np.array([1.0, 1.4, 0.0, -1.0])
    tyres = np.diag([0.0, 0.0, 200e3, 200e3])
    k = 22e3 * np.outer(front, front) + 24e3 * np.outer(rear, rear) + tyres
    d = 1500 * np.outer(front, front) + 1600 * np.outer(rear, rear)
    inverse = np.linalg.inv(m)
    a = np.block([[np.zeros((4, 4)), np.eye(4)], [-inverse @ k, -inverse @ d]])
    start = np.array([0.02, 0, 0, 0, 0, 0.1, 0, 0])
    eigenvalues, vectors = np.linalg.eig(a)
    weights = np.linalg.solve(vectors, start)
    motion = (vectors * weights) @ np.exp(np.outer(eigenvalues, result.times))
    for row, name in enumerate(("body.z", "body.theta", "front.z_R", "rear.z_R")):
        assert values(result, f"car.{name}") == pytest.approx(motion[row].real, abs=1e-7), name


def test_characteristics_are_followed() -> None:
    result = simulate(
        """  CharacteristicSpring spring(table = [-0.1, -2000; 0, 0; 0.05, 1000; 0.1, 5000]);
  CharacteristicDamper damper(table = [-1, -500; 0, 0; 1, 1500], useHeatPort = true);
  thermal.FixedTemperature air(T = 293.15);
  Fixed wall;
  Position shaker(exact = true);
  blocks.Sine wave(amplitude = 0.09, f = 1);
equation
  connect(wave.y, shaker.s_ref);
  connect(shaker.flange, spring.flange_b, damper.flange_b);
  connect(wall.flange, spring.flange_a, damper.flange_a);
  connect(damper.heatPort, air.port);
""",
        stop_time=1,
    )
    s = 0.09 * np.sin(2 * np.pi * result.times)
    force = -np.interp(-s, [-0.1, 0, 0.05, 0.1], [-2000, 0, 1000, 5000])
    assert values(result, "spring.f") == pytest.approx(force, abs=1e-5)
    v = 0.09 * 2 * np.pi * np.cos(2 * np.pi * result.times)
    force = np.interp(v, [-1, 0, 1], [-500, 0, 1500])
    assert values(result, "damper.f") == pytest.approx(force, abs=1e-4)
    assert np.all(values(result, "air.port.Q_flow") >= -1e-9)


def test_wheel_leaves_the_road_and_comes_back() -> None:
    result = compile_file(EXAMPLE, model="Bump").simulate(stop_time=3, tolerance=1e-8)
    load = values(result, "tyre.load")
    contact = values(result, "tyre.contact").astype(bool)
    assert np.min(load) >= -1e-2
    assert np.any(~contact)
    assert np.max(np.abs(load[~contact])) < 1e-2
    assert np.max(load) > 2 * 415 * 9.80665
    assert load[-1] == pytest.approx(415 * 9.80665, rel=2e-2)


def test_bouncing_half_car_keeps_contact_forces_positive() -> None:
    result = simulate(
        """  HalfCar car(lifts = true, body(z(start = 0.25, fixed = true), v(fixed = true),
    theta(fixed = true), w(fixed = true)), front(wheel(s(start = 0.2, fixed = true),
    v(fixed = true))), rear(wheel(s(start = 0.2, fixed = true), v(fixed = true))));
  Fixed ground;
equation
  connect(ground.flange, car.road_front, car.road_rear);
""",
        stop_time=4,
    )
    for axle in ("front", "rear"):
        assert values(result, f"car.{axle}.tyre.load")[0] == 0
        assert np.min(values(result, f"car.{axle}.tyre.load")) >= 0
        assert abs(values(result, f"car.{axle}.F_dyn")[-1]) < 50
