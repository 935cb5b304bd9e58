"""Valves, cylinders and lines in circuits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from acausal import compile_text

R, T0, P0 = 287.05, 293.15, 101325.0


def simulate(text: str, **options: Any) -> Any:
    text = f"import pneumatic.*;\nmodel M\n  inner Gas gas;\n{text}\nend M;\n"
    return compile_text(text).simulate(**{"tolerance": 1e-8, **options})


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def choked(p: float, c: float, t: float = T0) -> float:
    return c * 1.185 * p * np.sqrt(293.15 / t)


def test_directional_valves_open_their_ways() -> None:
    result = simulate(
        """  V5_2 two(dynamic = false, C = 2e-8, b = 0.3);
  V5_3 three(dynamic = false, C = 2e-8, b = 0.3);
  V3_2 small(dynamic = false);
  V2_2 shut(dynamic = false);
  ConstPressureSource supply(p_const = 7e5), a(p_const = 3.5e5), b(p_const = 3e5);
  Environment outside;
  blocks.Ramp up(duration = 1), both(offset = -1, height = 2, duration = 1);
equation
  connect(up.y, two.control, small.control, shut.control);
  connect(both.y, three.control);
  connect(supply.port, two.portP, three.portP, small.portP, shut.port_a);
  connect(a.port, two.portA, three.portA, small.portA, shut.port_b);
  connect(b.port, two.portB, three.portB);
  connect(outside.port, two.portR, two.portS, three.portR, three.portS, small.portR);""",
        stop_time=1,
        points=101,
    )
    ways = {"P2A": (0, 1), "P2B": (1, 0), "A2R": (1, 0), "B2S": (0, 1)}
    for valve in ("two", "three"):
        for way, ends in ways.items():
            opening = values(result, f"{valve}.{way}.openFraction")
            assert opening[[0, -1]] == pytest.approx(ends, abs=2e-6)
            assert opening[50] == pytest.approx(0, abs=2e-6)
    assert values(result, "small.A2R.m_flow")[0] == pytest.approx(
        choked(3.5e5, 1e-8) * np.sqrt(1 - ((P0 / 3.5e5 - 0.3) / 0.7) ** 2 * (P0 / 3.5e5 > 0.3)),
        rel=1e-3,
    )
    x = (0.5 - 0.3) / 0.7
    assert values(result, "small.P2A.m_flow")[-1] == pytest.approx(
        choked(7e5, 1e-8) * np.sqrt(1 - x**2), rel=1e-5
    )
    assert values(result, "shut.edge.m_flow")[[0, -1]] == pytest.approx(
        choked(7e5, 1e-8) * np.sqrt(1 - x**2) * np.array([1e-6, 1]), rel=1e-5
    )
    sums = sum(values(result, f"three.port{x}.m_flow") for x in "PABRS")
    assert sums == pytest.approx(0, abs=1e-15)


@pytest.mark.parametrize("process", ["adiabatic", "isothermal", "polytropic", "exchange"])
def test_cylinder_goes_out_and_in(process: str) -> None:
    result = simulate(
        f"""  DoubleActingCylinder cylinder(process = Process.{process}, boreDiameter = 32e-3,
    rodDiameter = 12e-3,
    head(p(start = 101325, fixed = true)), rodSide(p(start = 101325, fixed = true)));
  mechanical.translational.Mass load(m = 5, s(start = 0.3, fixed = true), v(start = 0,
    fixed = true));
  mechanical.translational.Fixed fixed;
  V5_2 valve(C = 5e-9);
  ConstPressureSource supply(p_const = 6e5);
  Line hose(L = 2, D = 4e-3);
  Environment outside;
  blocks.Pulse pulse(width = 50, period = 4);
equation
  connect(pulse.y, valve.control);
  connect(fixed.flange, cylinder.flange_a);
  connect(cylinder.flange_b, load.flange_a);
  connect(supply.port, hose.port_a);
  connect(hose.port_b, valve.portP);
  connect(valve.portA, cylinder.port_a);
  connect(valve.portB, cylinder.port_b);
  connect(outside.port, valve.portR, valve.portS);""",
        stop_time=4,
    )
    t, s = result.times, values(result, "cylinder.s")
    assert s[np.searchsorted(t, 1.9)] == pytest.approx(0.2, abs=1e-3)
    assert s[-1] == pytest.approx(0, abs=1e-3)
    # At the end of the stroke the stop carries pressure times area.
    head, rod = np.pi / 4 * 32e-3**2, np.pi / 4 * (32e-3**2 - 12e-3**2)
    at = np.searchsorted(t, 1.95)
    pushed = head * (values(result, "cylinder.head.p")[at] - P0)
    pushed -= rod * (values(result, "cylinder.rodSide.p")[at] - P0)
    assert (s[at] - 0.2) * 1e6 == pytest.approx(pushed, rel=1e-2)
    temperature = values(result, "cylinder.head.T")
    if process == "isothermal":
        assert temperature == pytest.approx(T0)
    else:
        assert 150 < temperature.min() < T0 < temperature.max() < 450


def test_pressure_valves_and_closed_ends() -> None:
    result = simulate(
        """  VarMassFlowSource compressor(T = 320);
  VolumeClosed tank(V_const = 1e-3, process = Process.isothermal, p(start = 2e5, fixed = true));
  ReliefValve safety(C = 5e-8, dp_relief = 7e5, dp_open = 8e5);
  CheckValve check(C = 5e-8);
  // Between a source of flow and a valve that closes the pressure needs a volume to be known.
  VolumeClosed pipe(V_const = 1e-5, process = Process.isothermal, p(start = 2e5, fixed = true));
  PressureReducingValve regulator(C = 1e-8, p_set = 3e5);
  VariableRestriction throttle(C = 2e-9, control = 0.5);
  VolumeClosed low(V_const = 1e-3, p(start = 101325, fixed = true), T(start = 293.15,
    fixed = true));
  Plug plug;
  Environment outside;
  blocks.Trapezoid rate(amplitude = 5e-3, rising = 0.5, width = 5, falling = 0.5,
    period = 100, nperiod = 1);
equation
  connect(rate.y, compressor.control);
  connect(compressor.port, pipe.port, check.port_a);
  connect(check.port_b, tank.port, safety.port_a, regulator.port_a, plug.port);
  connect(regulator.port_b, low.port, throttle.port_a);
  connect(safety.port_b, throttle.port_b, outside.port);""",
        stop_time=20,
    )
    t, tank, low = result.times, values(result, "tank.p"), values(result, "low.p")
    late = (t > 4) & (t < 5.5)
    assert np.all((tank[late] > P0 + 7e5) & (tank[late] < P0 + 8e5))
    assert np.all((low[late] > 2.8e5) & (low[late] < 3e5))
    # After the compressor has stopped the tank empties through the throttle only.
    mass = values(result, "tank.m") + values(result, "low.m")
    outflow = values(result, "throttle.m_flow")
    end = t > 8
    drained = np.sum(np.diff(t[end]) * (outflow[end][1:] + outflow[end][:-1]) / 2)
    assert mass[end][0] - mass[-1] == pytest.approx(drained, rel=0.05)
    assert values(result, "throttle.openFraction") == pytest.approx(0.5)


def test_air_cushion_is_the_adiabatic_chamber() -> None:
    text = """  {air};
  mechanical.translational.Mass piston(m = 0.5, s(start = 0.08, fixed = true), v(start = -3,
    fixed = true));
  mechanical.translational.Fixed fixed;
equation
  connect(fixed.flange, air.flange_a);
  connect(air.flange_b, piston.flange_a);"""
    cushion = simulate(
        text.format(air="AirCushion air(A = 1e-3, l0 = 0.08)"), stop_time=0.1, points=501
    )
    chamber = simulate(
        text.format(air="Cylinder air(A = 1e-3, V0 = 0, p(fixed = true), T(fixed = true))"),
        stop_time=0.1,
        points=501,
    )
    assert values(cushion, "air.p").max() > 2e5
    assert values(cushion, "air.p") == pytest.approx(values(chamber, "air.p"), rel=1e-5)
    assert values(cushion, "piston.s") == pytest.approx(values(chamber, "piston.s"), rel=1e-6)
