"""Impacts of bodies that constraints tie to others, against independent references.

The references in ``tests/data/hybrid`` come from minimal coordinates and explicit mass matrices;
the models here are written as a person would: positions, rods as constraints, ``reinit`` of one
velocity.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import acausal as ac

DATA = Path(__file__).parent.parent / "data" / "hybrid"


def reference(name: str) -> dict[str, Any]:
    return json.loads((DATA / f"{name}.json").read_text(encoding="utf-8"))


def run(text: str, stop: float, tolerance: float = 1e-9, **parameters: float) -> Any:
    compiled = ac.compile_text(text, parameters=parameters)
    result = compiled.simulate(stop_time=stop, tolerance=tolerance)
    assert result.ending.value == "complete", result.diagnostics
    return result


def sides(result: Any, path: str, time: float) -> tuple[float, float]:
    """Return the values just before and just after an event."""
    near = np.flatnonzero(np.abs(result.times - time) < 1e-6)
    both = np.flatnonzero(result.times == result.times[near[0]])
    values = result[path].values
    return float(values[both[0]]), float(values[both[-1]])


PENDULUM = """
model PendulumAndWall
  parameter Real m = 1, l = 1, g = 9.81, e = 0.8, wall = 0.3;
  parameter Real phi0 = -1, w0 = 0;
  Real x(start = l*sin(phi0), fixed = true), y(start = -l*cos(phi0));
  Real vx(start = l*w0*cos(phi0), fixed = true), vy, F;
equation
  x^2 + y^2 = l^2;
  vx = der(x);
  vy = der(y);
  m*der(vx) = -F*x;
  m*der(vy) = -F*y - m*g;
  when x >= wall then
    reinit(vx, -e*pre(vx));
  end when;
end PendulumAndWall;
"""


def test_pendulum_of_positions_meets_a_wall() -> None:
    data = reference("pendulum_and_wall")
    p = data["parameters"]
    start = data["start"]
    result = run(
        PENDULUM, data["times"][-1], phi0=start[0], w0=start[1], m=p["m"], l=p["l"], g=p["g"],
        e=p["e"], wall=p["wall"],
    )  # fmt: skip
    for event in data["events"][:4]:
        for path, k in (("vx", 0), ("vy", 1)):
            before, after = sides(result, path, event["time"])
            assert before == pytest.approx(event["velocity_before"][k], abs=1e-6)
            assert after == pytest.approx(event["velocity_after"][k], abs=1e-6)


LEVER = """
model BallOnLever
  parameter Real m = 0.5, M = 2, b = 0.6, e = 0.7, g = 9.81;
  Real x(start = -0.9, fixed = true), y(start = 0.35, fixed = true);
  Real phi(start = 0.3, fixed = true);
  Real vx(start = 0, fixed = true), vy(start = 0, fixed = true), w(start = 0, fixed = true);
  Real gap, vgap, agap;
equation
  vx = der(x);
  vy = der(y);
  w = der(phi);
  m*der(vx) = 0;
  m*der(vy) = -m*g;
  M*b^2*der(w) = -M*g*b*cos(phi);
  gap = y*cos(phi) - x*sin(phi);
  vgap = der(gap);
  agap = der(vgap);
  when gap <= 0 then
    reinit(vgap, -e*pre(vgap));
  end when;
end BallOnLever;
"""


def test_ball_falls_on_a_lever() -> None:
    data = reference("ball_on_lever")
    result = run(LEVER, data["times"][-1])
    names = data["variables"]
    for event in data["events"]:
        for k, path in enumerate(names):
            before, after = sides(result, path, event["time"])
            assert before == pytest.approx(event["before"][k], abs=1e-6)
            assert after == pytest.approx(event["after"][k], abs=1e-6)


CHAIN = """
model ChainOnWall
  parameter Real m1 = 1.5, m2 = 0.7, ratio = 1, e = 0.65, speed = 3, distance = 2;
  Real x1(start = 0, fixed = true), x2, v1(start = speed, fixed = true), v2, f;
equation
  x2 = ratio*x1 + 1;
  v1 = der(x1);
  v2 = der(x2);
  m1*der(v1) = -ratio*f;
  m2*der(v2) = f;
  when x1 >= distance then
    reinit(v1, -e*pre(v1));
  end when;
end ChainOnWall;
"""


@pytest.mark.parametrize("number", range(3))
def test_mass_and_mass_joined_by_a_lever_ratio(number: int) -> None:
    key = next(k for k, v in reference("chain_on_wall").items() if isinstance(v, list))
    row = reference("chain_on_wall")[key][number]
    given = {k: row[k] for k in ("m1", "m2", "ratio", "e", "speed", "distance")}
    result = run(CHAIN, 1.0, **given)
    _, v1 = sides(result, "v1", row["time"])
    _, v2 = sides(result, "v2", row["time"])
    np.testing.assert_allclose([v1, v2], row["velocities_after"], rtol=1e-9)


DOUBLE = """
model DoublePendulum
  parameter Real m1 = 1, m2 = 0.8, l1 = 1, l2 = 0.7, e = 0.6, g = 9.81, limit = 0.5;
  parameter Real p1 = 0, p2 = 0, r1 = 0, r2 = 0;
  parameter Boolean relative = true;
  Real x1(start = l1*sin(p1)), y1(start = -l1*cos(p1));
  Real x2(start = l1*sin(p1) + l2*sin(p2)), y2(start = -l1*cos(p1) - l2*cos(p2));
  Real vx1, vy1, vx2, vy2, F1, F2;
  Real phi1(start = p1, fixed = true), phi2(start = p2, fixed = true);
  Real w1(start = r1, fixed = true), w2(start = r2, fixed = true);
  Real angle, rate, acceleration;
equation
  x1 = l1*sin(phi1);
  y1 = -l1*cos(phi1);
  x2 = x1 + l2*sin(phi2);
  y2 = y1 - l2*cos(phi2);
  w1 = der(phi1);
  w2 = der(phi2);
  vx1 = der(x1);
  vy1 = der(y1);
  vx2 = der(x2);
  vy2 = der(y2);
  m1*der(vx1) = -F1*sin(phi1) + F2*sin(phi2);
  m1*der(vy1) = F1*cos(phi1) - F2*cos(phi2) - m1*g;
  m2*der(vx2) = -F2*sin(phi2);
  m2*der(vy2) = F2*cos(phi2) - m2*g;
  angle = if relative then phi2 - phi1 else phi2;
  rate = der(angle);
  acceleration = der(rate);
  when angle >= limit then
    reinit(rate, -e*pre(rate));
  end when;
end DoublePendulum;
"""


@pytest.mark.parametrize("relative", [True, False])
def test_second_link_of_a_double_pendulum_meets_a_stop(relative: bool) -> None:
    data = reference(f"double_pendulum_{'relative' if relative else 'absolute'}_stop")
    p, start = data["parameters"], data["start"]
    result = run(
        DOUBLE, data["times"][-1], relative=float(relative),
        limit=p["limit"], p1=start[0], p2=start[1], r1=start[2], r2=start[3],
    )  # fmt: skip
    for event in data["events"][:3]:
        for k, path in enumerate(("phi1", "phi2", "w1", "w2")):
            before, after = sides(result, path, event["time"])
            assert before == pytest.approx(event["before"][k], abs=2e-5)
            assert after == pytest.approx(event["after"][k], abs=2e-5)
