"""Waves on lines without losses, and the limits of lines made of segments."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from acausal import compile_text


def run(text: str, stop_time: float = 1.0, **options: Any) -> Any:
    options = {"tolerance": 1e-8, **options}
    return compile_text(f"model Test\n{text}\nend Test;\n").simulate(stop_time=stop_time, **options)


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


@pytest.mark.parametrize(
    ("line", "arguments"),
    [("TLine1", "TD = 0.1[s]"), ("TLine2", "F = 5[Hz], NL = 0.5"), ("TLine3", "F = 2.5[Hz]")],
)
@pytest.mark.parametrize(("source", "load"), [(50, 50), (10, 200), (100, 10)])
def test_step_runs_to_and_fro(line: str, arguments: str, source: float, load: float) -> None:
    result = run(
        f"""
  electrical.StepVoltage step(V = 1[V], startTime = 0.05[s]);
  electrical.Resistor feed(R = {source}[Ohm]), load(R = {load}[Ohm]);
  electrical.{line} line(Z0 = 50[Ohm], {arguments});
  electrical.Ground ground;
equation
  connect(step.p, feed.p);
  connect(feed.n, line.p1);
  connect(line.p2, load.p);
  connect(step.n, line.n1, line.n2, load.n, ground.p);
""",
        points=1001,
    )
    # each arrival at the load adds a wave that is smaller by both reflections
    at_load, at_source = (load - 50) / (load + 50), (source - 50) / (source + 50)
    wave, expected = 50 / (source + 50), np.zeros(len(result.times))
    for k in range(6):
        arrival = 0.05 + 0.1 + 0.2 * k
        expected += wave * (1 + at_load) * (result.times > arrival)
        wave *= at_load * at_source
    phase = np.mod(result.times - 0.05 + 0.05, 0.1) - 0.05
    away = np.abs(phase) > 1e-6
    assert values(result, "load.v")[away] == pytest.approx(expected[away], abs=1e-6)


def test_line_with_resistance_and_capacitance_is_a_divider_in_the_end() -> None:
    result = run(
        """
  electrical.ConstantVoltage source(V = 1[V]);
  electrical.ULine line(N = 5, length = 2[m], r = 3, c = 0.01, C(each v(fixed = true)));
  electrical.Resistor load(R = 4[Ohm]);
  electrical.Ground ground;
equation
  connect(source.p, line.p1);
  connect(line.p2, load.p);
  connect(source.n, line.p3, load.n, ground.p);
""",
        stop_time=5,
    )
    assert values(result, "load.v")[0] < 0.1
    assert values(result, "load.v")[-1] == pytest.approx(0.4, rel=1e-5)


def test_many_segments_delay_a_wave_as_the_line_they_stand_for() -> None:
    # 1 H/m and 1 F/m: the wave takes 1 s over 1 m
    result = run(
        """
  electrical.StepVoltage step(V = 1[V], startTime = 0.1[s]);
  electrical.Resistor feed(R = 1[Ohm]), load(R = 1[Ohm]);
  electrical.OLine line(N = 60, r = 1e-9, g = 1e-9,
    C(each v(fixed = true)), L(each i(fixed = true)));
  electrical.Ground ground;
equation
  connect(step.p, feed.p);
  connect(feed.n, line.p1);
  connect(line.p2, load.p);
  connect(step.n, line.p3, load.n, ground.p);
""",
        stop_time=3,
        points=3001,
        tolerance=1e-6,
    )
    arrived = result.times[np.argmax(values(result, "load.v") > 0.25)]
    assert arrived == pytest.approx(1.1, abs=0.03)
    assert values(result, "load.v")[-1] == pytest.approx(0.5, abs=0.02)
