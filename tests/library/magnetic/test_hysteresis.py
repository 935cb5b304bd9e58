"""Hysteresis after Tellinen: limiting loop, minor loops, losses, demagnetisation."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.library.magnetic.circuits import simulate, values

SLOPE = np.log((1 + 0.95 / 1.8) / (1 - 0.95 / 1.8)) / (2 * 50)


def branch(field: Any, shift: float) -> Any:
    return 1.8 * np.tanh(SLOPE * (field + shift))


DRIVEN = """  SignalMagneticPotentialDifference source(V_m = 0.1*{field});
  Ground ground;
  GenericHystTellinenSoft tube(J(start = 0, fixed = true));
equation
  connect(source.port_p, tube.port_p);
  connect(source.port_n, tube.port_n, ground.port);
"""


def test_limiting_loop_and_its_losses() -> None:
    field = "600[A]*sin(2*constants.pi*time)"
    result = simulate(DRIVEN.format(field=field), stop_time=2.25, points=9001, tolerance=1e-8)
    t, h, j = result.times, values(result, "tube.H"), values(result, "tube.J")
    assert h == pytest.approx(600 * np.sin(2 * np.pi * t), abs=1e-6)
    falling = (t > 0.5) & (t < 0.74)
    rising = (t > 1.0) & (t < 1.24)
    # from saturation the branches of the loop are followed
    assert j[falling] == pytest.approx(branch(h[falling], 50), abs=2e-3)
    assert j[rising] == pytest.approx(branch(h[rising], -50), abs=2e-3)
    assert np.interp(0.5, t, j) == pytest.approx(0.95, abs=2e-3)
    # the area of the loop is 4 Js Hc, whatever the shape of the branches
    cycle = (t >= 1.25) & (t <= 2.25)
    area = np.sum(np.diff(j[cycle]) * (h[cycle][1:] + h[cycle][:-1]) / 2)
    assert area == pytest.approx(4 * 1.8 * 50, rel=0.01)


def test_minor_loops_stay_inside() -> None:
    field = "(if time < 1 then 80[A] else 30[A])*sin(2*constants.pi*time)"
    result = simulate(DRIVEN.format(field=field), stop_time=4, points=4001, tolerance=1e-8)
    h, j = values(result, "tube.H"), values(result, "tube.J")
    assert np.all(j < branch(h, 50) + 1e-6)
    assert np.all(j > branch(h, -50) - 1e-6)
    late = result.times > 3
    area = np.sum(np.diff(j[late]) * (h[late][1:] + h[late][:-1]) / 2)
    assert 0 < area < 4 * 1.8 * 50 / 4


def test_coil_around_a_core_with_hysteresis() -> None:
    # a voltage gives the flux: the current follows with the shape of the loop
    result = simulate(
        """  electrical.CosineVoltage source(V = 2, f = 50);
  electrical.Resistor wire(R = 1e-3);
  electrical.Ground earth;
  ElectroMagneticConverter coil(N = 60, i(start = 0, fixed = true));
  GenericHystTellinenSoft core(A = 1e-4, l = 0.1, J(start = 0, fixed = true));
  Ground ground;
equation
  connect(source.p, wire.p);
  connect(wire.n, coil.p);
  connect(coil.n, source.n, earth.p);
  connect(coil.port_p, core.port_p);
  connect(core.port_n, coil.port_n, ground.port);
""",
        stop_time=0.08,
        points=4001,
        tolerance=1e-8,
    )
    t = result.times
    expected = 2 / (2 * np.pi * 50) / 60 / 1e-4 * np.sin(2 * np.pi * 50 * t)
    assert np.max(expected) > 1
    assert values(result, "core.B") == pytest.approx(expected, abs=5e-3)
    late = t > 0.06
    power = values(result, "coil.v") * values(result, "coil.i")
    lost = np.sum(np.diff(t[late]) * (power[late][1:] + power[late][:-1]) / 2)
    b, h = values(result, "core.B")[late], values(result, "core.H")[late]
    area = np.sum(np.diff(b) * (h[1:] + h[:-1]) / 2)
    assert lost == pytest.approx(area * 1e-5, rel=1e-3)
    assert area > 50


def test_magnet_is_demagnetised_by_a_strong_field_only() -> None:
    text = """  SignalMagneticPotentialDifference source;
  Ground ground;
  GenericHystTellinenPermanentMagnet magnet;
  GenericHystTellinenHard fresh(J(start = 0, fixed = true));
equation
  source.V_m = -0.01*{peak}*sin(constants.pi*time);
  connect(source.port_p, magnet.port_p, fresh.port_p);
  connect(source.port_n, magnet.port_n, fresh.port_n, ground.port);
"""
    weak = simulate(text.format(peak=60e3), points=101)
    strong = simulate(text.format(peak=400e3), points=101)
    assert 0.3 < values(weak, "magnet.J")[-1] < 0.38
    assert values(strong, "magnet.J")[-1] == pytest.approx(-0.38, abs=0.01)
    assert values(strong, "fresh.J")[-1] == pytest.approx(-0.38, abs=0.01)
    assert values(weak, "magnet.B")[0] == pytest.approx(0.38, abs=1e-6)
