"""Chambers and nozzles against the closed forms of an ideal gas."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from acausal import compile_text

R, KAPPA, T0, P0 = 287.05, 1.4, 293.15, 101325.0


def simulate(text: str, **options: Any) -> Any:
    text = f"import pneumatic.*;\nmodel M\n  inner Gas gas;\n{text}\nend M;\n"
    return compile_text(text).simulate(**{"tolerance": 1e-9, **options})


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


@pytest.mark.parametrize(
    ("process", "exponent"), [("adiabatic", 1.4), ("isothermal", 1.0), ("polytropic", 1.25)]
)
def test_enclosed_gas_follows_its_process(process: str, exponent: float) -> None:
    result = simulate(
        f"""  Cylinder gas_(A = 1e-2, V0 = 1e-3, process = Process.{process}, n = 1.25,
    p(start = {P0}, fixed = true){", T(start = 293.15, fixed = true)" * (process == "adiabatic")});
  mechanical.translational.Position drive(exact = true, useSupport = true);
  mechanical.translational.Fixed fixed;
  blocks.Sine sine(amplitude = 0.08, f = 2);
  Real heat(start = 0, fixed = true), work(start = 0, fixed = true);
equation
  der(heat) = gas_.Q_flow;
  der(work) = gas_.p*der(gas_.V);
  connect(sine.y, drive.s_ref);
  connect(fixed.flange, drive.support, gas_.flange_a);
  connect(drive.flange, gas_.flange_b);""",
        stop_time=1,
    )
    p, volume = values(result, "gas_.p"), values(result, "gas_.V")
    assert volume.min() == pytest.approx(0.2e-3, rel=1e-3)
    assert p == pytest.approx(P0 * (1e-3 / volume) ** exponent, rel=1e-6)
    assert values(result, "gas_.T") == pytest.approx(T0 * (p * volume) / (P0 * 1e-3), rel=1e-6)
    assert values(result, "gas_.m") == pytest.approx(P0 * 1e-3 / (R * T0), rel=1e-6)
    energy = values(result, "gas_.U") + values(result, "work") - values(result, "heat")
    assert energy == pytest.approx(energy[0], abs=5e-4)
    heat = (KAPPA - exponent) / (KAPPA - 1) * values(result, "work")
    assert values(result, "heat") == pytest.approx(heat, abs=1e-3)


def test_heat_through_the_wall_warms_expanded_gas() -> None:
    # From 250 K: m cv T' = G (Tw - T) at constant volume.
    result = simulate(
        """  VolumeClosed tank(V_const = 2e-3, process = Process.exchange, G = 0.5,
    useHeatPort = true,
    p(start = 2e5, fixed = true), T(start = 250, fixed = true));
  thermal.FixedTemperature wall(T = 310);
equation
  connect(wall.port, tank.heatPort);""",
        stop_time=60,
    )
    mass = 2e5 * 2e-3 / (R * 250)
    rate = 0.5 / (mass * R / (KAPPA - 1))
    expected = 310 - 60 * np.exp(-rate * result.times)
    assert values(result, "tank.T") == pytest.approx(expected, abs=1e-5)


CHOKED = np.sqrt(KAPPA) * (2 / (KAPPA + 1)) ** ((KAPPA + 1) / (2 * (KAPPA - 1)))


@pytest.mark.parametrize("process", ["adiabatic", "isothermal"])
def test_tank_blows_down_through_a_choked_nozzle(process: str) -> None:
    fixed = ", T(start = 293.15, fixed = true)" if process == "adiabatic" else ""
    result = simulate(
        f"""  VolumeClosed tank(V_const = 1e-2, process = Process.{process},
    p(start = 1e6, fixed = true){fixed});
  Nozzle nozzle(A = 2e-6);
  ConstPressureSource outside(p_const = 1e4);
equation
  connect(tank.port, nozzle.port_a);
  connect(nozzle.port_b, outside.port);""",
        stop_time=30,
    )
    rate = 2e-6 * CHOKED * np.sqrt(R * T0) / 1e-2
    if process == "adiabatic":
        factor = 1 + (KAPPA - 1) / 2 * rate * result.times
        p, temperature = 1e6 * factor ** (-2 * KAPPA / (KAPPA - 1)), T0 * factor**-2.0
    else:
        p, temperature = 1e6 * np.exp(-rate * result.times), T0 + 0 * result.times
    assert p[-1] > 2e4  # choked to the end
    assert values(result, "tank.p") == pytest.approx(p, rel=1e-6)
    assert values(result, "tank.T") == pytest.approx(temperature, rel=1e-6)


def test_charging_heats_the_gas() -> None:
    # Energy of a tank that is filled from p1, T1 by gas of the temperature Ts to p2 without losses.
    result = simulate(
        """  VolumeClosed tank(p(start = 20000, fixed = true), T(start = 280, fixed = true));
  Restriction valve(C = 2e-9);
  ConstPressureSource supply(p_const = 7e5, T = 300);
equation
  connect(supply.port, valve.port_a);
  connect(valve.port_b, tank.port);""",
        stop_time=5,
    )
    p = values(result, "tank.p")
    expected = KAPPA * 300 / (1 + 20000 / p * (KAPPA * 300 / 280 - 1))
    assert p[-1] == pytest.approx(7e5, rel=2e-5)
    filling = p < 6.99e5
    assert values(result, "tank.T")[filling] == pytest.approx(expected[filling], rel=1e-5)
    assert values(result, "tank.T")[-1] > 400


def test_flow_after_iso_6358_and_through_a_nozzle() -> None:
    result = simulate(
        """  VarPressureSource up(T = 350), down;
  blocks.Ramp ramp(offset = 6e5, height = -5.5e5, duration = 1);
  blocks.Constant supply(k = 3e5);
  Restriction iso(C = 1e-8, b = 0.35);
  Nozzle nozzle(A = 1e-6, Cd = 0.9);
equation
  connect(supply.y, up.control);
  connect(ramp.y, down.control);
  connect(up.port, iso.port_a, nozzle.port_a);
  connect(down.port, iso.port_b, nozzle.port_b);""",
        stop_time=1,
        points=2001,
    )
    down = values(result, "down.control")
    forward = down < 3e5
    high, low = np.maximum(down, 3e5), np.minimum(down, 3e5)
    ratio, t_up, sign = low / high, np.where(forward, 350, 293.15), np.where(forward, 1, -1)
    clear = ratio < 0.999
    x = (np.maximum(ratio, 0.35) - 0.35) / 0.65
    iso = sign * 1e-8 * 1.185 * high * np.sqrt(293.15 / t_up) * np.sqrt(np.maximum(0, 1 - x**2))
    assert values(result, "iso.m_flow")[clear] == pytest.approx(iso[clear], rel=1e-9)
    critical = (2 / (KAPPA + 1)) ** (KAPPA / (KAPPA - 1))
    r = np.maximum(ratio, critical)
    flow = np.sqrt(2 * KAPPA / (KAPPA - 1) * np.maximum(0, r ** (2 / 1.4) - r ** (2.4 / 1.4)))
    nozzle = sign * 0.9e-6 * high / np.sqrt(R * t_up) * flow
    assert values(result, "nozzle.m_flow")[clear] == pytest.approx(nozzle[clear], rel=1e-9)
    # Around equal pressures: steady, increasing, at most what the law without regularisation gives.
    near = (ratio > 0.99) & (np.diff(down, append=0) < 0)
    assert np.all(np.diff(values(result, "iso.m_flow")[near]) > 0)
    assert np.all(np.abs(values(result, "iso.m_flow")) <= np.abs(iso) * (1 + 1e-9))


def test_flows_mix_where_they_meet() -> None:
    result = simulate(
        """  ConstMassFlowSource cold(m_flow = 1e-3, T = 280), hot(m_flow = 3e-3, T = 360);
  Restriction out(C = 1e-8);
  TemperatureSensor sensor;
  PressureSensor gauge;
  FlowSensor meter;
  Environment environment;
equation
  connect(cold.port, hot.port, meter.port_a, sensor.port, gauge.port);
  connect(meter.port_b, out.port_a);
  connect(out.port_b, environment.port);""",
        stop_time=1,
    )
    assert values(result, "sensor.T") == pytest.approx(340, rel=1e-6)
    assert values(result, "meter.m_flow") == pytest.approx(4e-3)
    flow = 1e-8 * 1.185 * np.sqrt(293.15 / 340)
    assert values(result, "gauge.p") == pytest.approx(4e-3 / flow, rel=1e-6)
    assert P0 / (4e-3 / flow) < 0.3


def test_friction_in_a_tube_is_laminar_then_turbulent() -> None:
    result = simulate(
        """  VarPressureSource up;
  WallFriction tube(L = 2, D = 4e-3, roughness = 0);
  LaminarRestriction thin(L = 2, D = 4e-3);
  Environment environment;
  blocks.Ramp source(offset = 101326, height = 2e5, duration = 1);
equation
  connect(source.y, up.control);
  connect(up.port, tube.port_a, thin.port_a);
  connect(tube.port_b, thin.port_b, environment.port);""",
        stop_time=1,
        points=4001,
    )
    re = values(result, "tube.Re")
    flow, thin = values(result, "tube.m_flow"), values(result, "thin.m_flow")
    laminar = re < 1999
    assert np.sum(laminar) > 5
    assert flow[laminar] == pytest.approx(thin[laminar], rel=1e-6)
    turbulent = re > 4001
    squares = values(result, "up.control")[turbulent] ** 2 - P0**2
    friction = squares * 4e-3 / (R * T0 * 2) * (np.pi / 4 * 16e-6 / flow[turbulent]) ** 2
    haaland = (1.8 * np.log10(6.9 / re[turbulent])) ** -2
    assert friction == pytest.approx(haaland, rel=1e-6)
    assert np.all(np.diff(flow)[np.diff(result.times) > 0] > 0)
