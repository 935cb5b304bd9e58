"""Three-phase rectifiers and an H-bridge: many switches at once, against textbook formulas."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from acausal import compile_text

AMPLITUDE, FREQUENCY = 100.0, 50.0
OMEGA = 2 * np.pi * FREQUENCY


def run(text: str, stop_time: float, **options: Any) -> Any:
    options = {"tolerance": 1e-6, **options}
    return compile_text(f"model Test\n{text}\nend Test;\n").simulate(stop_time=stop_time, **options)


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def mean(result: Any, path: str, start: float) -> float:
    inside = result.times >= start
    times, signal = result.times[inside], values(result, path)[inside]
    return float(np.trapezoid(signal, times) / (times[-1] - times[0]))


SOURCES = """
  electrical.SineVoltage source[3](each V = 100[V], each f = 50[Hz],
    phase = {0, -2*constants.pi/3, -4*constants.pi/3});
"""
SIX_PULSE = """
  electrical.{valve} upper[3]{modifier}, lower[3]{modifier};
  electrical.Ground ground;
  {load}
equation
  for k in 1:3 loop
    connect(source[k].n, ground.p);
    connect(source[k].p, upper[k].p, lower[k].n);
    connect(upper[k].n, load.p);
    connect(lower[k].p, load.n);
  end for;
{more}
"""


def test_six_diodes_with_a_resistor() -> None:
    text = SOURCES + SIX_PULSE.format(
        valve="IdealDiode", modifier="", load="electrical.Resistor load(R = 10[Ohm]);", more=""
    )
    result = run(text, 0.04, points=4001)
    phases = AMPLITUDE * np.sin(
        OMEGA * result.times[:, None] - 2 * np.pi / 3 * np.arange(3)[None, :]
    )
    assert values(result, "load.v") == pytest.approx(np.ptp(phases, axis=1), abs=5e-3)
    assert mean(result, "load.v", 0.02) == pytest.approx(3 * np.sqrt(3) / np.pi * 100, rel=1e-5)


def test_source_inductance_takes_its_share_in_commutation() -> None:
    # two diodes carry the current while it changes over: 3 omega L I/(2 pi) are lost
    result = run(
        SOURCES
        + """
  electrical.Inductor line[3](each L = 2e-3[H], i(each start = 5));
  electrical.IdealDiode valve[3];
  electrical.Inductor choke(L = 0.5[H], i(start = 15, fixed = true));
  electrical.Resistor load(R = 5[Ohm]);
  electrical.Ground ground;
equation
  connect(source.p, line.p);
  connect(line.n, valve.p);
  for k in 1:3 loop
    connect(source[k].n, ground.p);
    connect(valve[k].n, choke.p);
  end for;
  connect(choke.n, load.p);
  connect(load.n, ground.p);
""",
        0.4,
        points=20001,
    )
    current = mean(result, "load.i", 0.38)
    expected = (3 * np.sqrt(3) * 100 - 3 * OMEGA * 2e-3 * current) / (2 * np.pi)
    assert mean(result, "load.v", 0.38) == pytest.approx(expected, rel=2e-3)
    # two at a time at most: current never flows backwards
    assert min(np.min(values(result, f"line[{k}].i")) for k in (1, 2, 3)) > -1e-2


def test_six_diodes_behind_coils() -> None:
    # the currents of the coils add up to zero: two states, not three
    result = run(
        SOURCES
        + """
  electrical.Inductor line[3](each L = 1e-3[H], i(each start = 0));
  electrical.IdealDiode upper[3], lower[3];
  electrical.Inductor choke(L = 0.5[H], i(start = 15, fixed = true));
  electrical.Resistor load(R = 10[Ohm]);
  electrical.Ground ground;
equation
  connect(source.p, line.p);
  for k in 1:3 loop
    connect(source[k].n, ground.p);
    connect(line[k].n, upper[k].p, lower[k].n);
    connect(upper[k].n, choke.p);
    connect(lower[k].p, load.n);
  end for;
  connect(choke.n, load.p);
""",
        0.4,
        points=20001,
    )
    assert len(result.states) == 3
    current = mean(result, "load.i", 0.38)
    expected = (3 * np.sqrt(3) * 100 - 3 * OMEGA * 1e-3 * current) / np.pi
    assert mean(result, "load.v", 0.38) == pytest.approx(expected, rel=1e-3)
    balance = sum(values(result, f"line[{k}].i") for k in (1, 2, 3))
    assert balance == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("degrees", [20, 60, 110])
def test_six_thyristors_with_a_current_source(degrees: int) -> None:
    # the mean falls with the cosine of the firing angle, below zero beyond 90 degrees
    pulses = "\n".join(
        f"  blocks.BooleanPulse gate_{name}{k}(period = 0.02[s], width = 40,\n"
        f"    startTime = {(degrees - 330 + 180 * n + 120 * (k - 1)) / 360 * 0.02}[s]);"
        for n, name in enumerate(("upper", "lower"))
        for k in (1, 2, 3)
    )
    text = SOURCES + SIX_PULSE.format(
        valve="IdealThyristor",
        modifier="(off(each fixed = true))",
        load="electrical.ConstantCurrent load(I = 5[A]);\n" + pulses,
        more="\n".join(
            f"  connect(gate_{name}{k}.y, {name}[{k}].fire);"
            for name in ("upper", "lower")
            for k in (1, 2, 3)
        ),
    )
    result = run(text, 0.08, points=8001)
    expected = 3 * np.sqrt(3) / np.pi * 100 * np.cos(np.radians(degrees))
    assert mean(result, "load.v", 0.04) == pytest.approx(expected, rel=1e-3)


def test_h_bridge_turns_the_current_round() -> None:
    # diodes carry the current of the coil back while the switches are crossed over
    result = run(
        """
  electrical.ConstantVoltage supply(V = 20[V]);
  electrical.IdealClosingSwitch s1, s2, s3, s4;
  electrical.IdealDiode d1, d2, d3, d4;
  electrical.Inductor coil(L = 10e-3[H], i(start = 0, fixed = true));
  electrical.Resistor load(R = 2[Ohm]);
  electrical.Ground ground;
  blocks.BooleanPulse clock(period = 0.02[s], width = 50);
  blocks.Not inverse;
equation
  connect(clock.y, inverse.u, s1.control, s4.control);
  connect(inverse.y, s2.control, s3.control);
  connect(supply.p, s1.p, s3.p, d1.n, d3.n);
  connect(s1.n, d1.p, s2.p, d2.n, coil.p);
  connect(s3.n, d3.p, s4.p, d4.n, load.n);
  connect(coil.n, load.p);
  connect(supply.n, s2.n, s4.n, d2.p, d4.p, ground.p);
""",
        0.1,
        points=5001,
    )
    # steady state of a square wave of 20 V on 10 mH and 2 Ohm
    decay = np.exp(-0.01 * 200)
    top = 10 * (1 - decay) / (1 + decay)
    phase = np.mod(result.times + 1e-12, 0.02)
    half = phase < 0.01
    local = np.where(half, phase, phase - 0.01)
    wave = 10 - (10 + top) * np.exp(-200 * local)
    expected = np.where(half, wave, -wave)
    late = result.times > 0.06
    assert values(result, "coil.i")[late] == pytest.approx(expected[late], abs=5e-3)
