"""Switches without any resistance or conductance: what is determined runs, the rest is named."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from acausal import compile_text


def run(text: str, stop_time: float = 1.2, **options: Any) -> Any:
    options = {"tolerance": 1e-7, "points": 241, **options}
    return compile_text(f"model Test\n{text}\nend Test;\n").simulate(stop_time=stop_time, **options)


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def test_peak_rectifier_without_losses() -> None:
    # while the diode conducts, the source determines the voltage of the capacitor
    result = run(
        """
  electrical.SineVoltage source(V = 10[V], f = 1[Hz]);
  electrical.IdealDiode diode(Ron = 0[Ohm], Goff = 0[S]);
  electrical.Capacitor capacitor(C = 1[F], v(start = 0, fixed = true));
  electrical.Resistor load(R = 2[Ohm]);
  electrical.Ground ground;
equation
  connect(source.p, diode.p);
  connect(diode.n, capacitor.p, load.p);
  connect(load.n, capacitor.n, source.n, ground.p);
"""
    )
    omega, times = 2 * np.pi, result.times
    ends = (np.pi - np.arctan(2 * omega)) / omega  # C u' + u/R = 0
    drive = 10 * np.sin(omega * times)
    falling = 10 * np.sin(omega * ends) * np.exp(-(times - ends) / 2)
    again = (times > 1) & (drive > falling)
    expected = np.where((times < ends) | again, drive, falling)
    assert values(result, "capacitor.v") == pytest.approx(expected, abs=1e-4)
    assert result.events[0].time == pytest.approx(ends, abs=1e-6)


def test_freewheel_without_leakage() -> None:
    result = run(
        """
  electrical.PulseVoltage source(V = 10[V], period = 0.4[s]);
  electrical.IdealDiode feed(Goff = 0[S]), freewheel(Goff = 0[S]);
  electrical.Inductor coil(L = 1[H], i(start = 0, fixed = true));
  electrical.Resistor load(R = 2[Ohm]);
  electrical.Ground ground;
equation
  connect(source.p, feed.p);
  connect(feed.n, freewheel.n, coil.p);
  connect(coil.n, load.p);
  connect(load.n, source.n, freewheel.p, ground.p);
""",
        stop_time=0.4,
    )
    peak = 5 * (1 - np.exp(-0.4))
    expected = np.where(
        result.times < 0.2,
        5 * (1 - np.exp(-2 * result.times)),
        peak * np.exp(-2 * (result.times - 0.2)),
    )
    assert values(result, "coil.i") == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize(
    "text",
    [
        """
  electrical.ConstantVoltage source(V = 10[V]);
  electrical.IdealOpeningSwitch switch(Goff = 0[S]);
  electrical.Inductor coil(L = 1[H], i(start = 0, fixed = true));
  electrical.Resistor load(R = 1[Ohm]);
  electrical.Ground ground;
  blocks.BooleanStep step(startTime = 0.5[s]);
equation
  connect(source.p, switch.p);
  connect(switch.n, coil.p);
  connect(coil.n, load.p);
  connect(load.n, source.n, ground.p);
  connect(step.y, switch.control);
""",
        """
  electrical.IdealClosingSwitch switch(Ron = 0[Ohm]);
  electrical.Capacitor capacitor(C = 1[F], v(start = 1, fixed = true));
  electrical.Resistor load(R = 1[Ohm]);
  electrical.Ground ground;
  blocks.BooleanStep step(startTime = 0.5[s]);
equation
  connect(capacitor.p, switch.p, load.p);
  connect(capacitor.n, switch.n, load.n, ground.p);
  connect(step.y, switch.control);
""",
    ],
    ids=["current_of_a_coil_cut_off", "capacitor_shorted"],
)
def test_what_has_no_solution_ends_with_a_message(text: str) -> None:
    result = run(text)
    last = result.diagnostics[-1]
    assert last.code == "E042"
    assert "0.5 s" in last.message
    assert any("switch" in note or "s.s" in note for note in last.notes)
    # what was computed before is kept
    assert result.times[-1] == pytest.approx(0.5)
    assert len(result.times) > 90
