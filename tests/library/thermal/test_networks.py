"""Heat in solids: closed forms, independent solutions, and the balance of random networks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from acausal import compile_text

SIGMA = 5.670374419e-8


def run(text: str, stop_time: float = 1.0, **options: Any) -> Any:
    options = {"tolerance": 1e-9, "points": 51, **options}
    return compile_text(f"model Test\n{text}\nend Test;\n").simulate(stop_time=stop_time, **options)


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


@pytest.mark.parametrize(
    ("scale", "number", "kelvin"),
    [
        ("celsius", 20, 293.15),
        ("celsius", -273.15, 0),
        ("fahrenheit", 212, 373.15),
        ("fahrenheit", -459.67, 0),
        ("rankine", 491.67, 273.15),
        ("rankine", 180, 100),
    ],
)
def test_scales_of_temperature(scale: str, number: float, kelvin: float) -> None:
    name = {"celsius": "Celsius", "fahrenheit": "Fahrenheit", "rankine": "Rankine"}[scale]
    result = run(
        f"""  import thermal.{scale}.*;
  FixedTemperature fixed(T = {number});
  PrescribedTemperature prescribed(T = {number});
  TemperatureSensor sensor, other;
  thermal.TemperatureSensor absolute;
  FromKelvin from(Kelvin = {kelvin});
  ToKelvin to({name} = {number});
equation
  connect(fixed.port, sensor.port, absolute.port);
  connect(prescribed.port, other.port);
"""
    )
    assert values(result, "absolute.T") == pytest.approx(kelvin, abs=1e-10)
    assert values(result, "prescribed.port.T") == pytest.approx(kelvin, abs=1e-10)
    assert values(result, "to.Kelvin") == pytest.approx(kelvin, abs=1e-10)
    for path in ("sensor.T", "other.T", f"from.{name}"):
        assert values(result, path) == pytest.approx(number, abs=1e-9)


@pytest.mark.parametrize("source", ["FixedHeatFlow", "PrescribedHeatFlow"])
def test_heat_flow_that_depends_on_temperature(source: str) -> None:
    result = run(
        f"""  thermal.{source} source(Q_flow = 100, T_ref = 300, alpha = -0.01);
  thermal.HeatCapacitor body(C = 50, T(start = 300, fixed = true));
equation
  connect(source.port, body.port);
""",
        stop_time=3,
    )
    expected = 300 + 100 * (1 - np.exp(-0.02 * result.times))
    assert values(result, "body.T") == pytest.approx(expected, abs=1e-5)
    assert values(result, "body.der_T") == pytest.approx(2 * np.exp(-0.02 * result.times), abs=1e-5)


def test_convection_by_conductance_and_by_resistance() -> None:
    result = run(
        """  thermal.HeatCapacitor a(C = 2, T(start = 350, fixed = true));
  thermal.HeatCapacitor b(C = 2, T(start = 350, fixed = true));
  thermal.Convection by_conductance(Gc = 4);
  thermal.ConvectiveResistor by_resistance(Rc = 0.25);
  thermal.PrescribedTemperature air(T = 300 + 10*time);
equation
  connect(a.port, by_conductance.solid);
  connect(b.port, by_resistance.solid);
  connect(by_conductance.fluid, by_resistance.fluid, air.port);
"""
    )
    t = result.times
    expected = 300 + 10 * t - 5 + 55 * np.exp(-2 * t)
    assert values(result, "a.T") == pytest.approx(expected, abs=1e-5)
    assert values(result, "b.T") == pytest.approx(expected, abs=1e-5)


def test_radiation_of_two_bodies() -> None:
    result = run(
        """  thermal.HeatCapacitor hot(C = 200, T(start = 1200, fixed = true));
  thermal.HeatCapacitor cold(C = 500, T(start = 300, fixed = true));
  thermal.BodyRadiation radiation(Gr = 0.05);
  thermal.HeatFlowSensor sensor;
  thermal.RelTemperatureSensor difference;
equation
  connect(hot.port, radiation.port_a, difference.port_a);
  connect(radiation.port_b, sensor.port_a);
  connect(sensor.port_b, cold.port, difference.port_b);
""",
        stop_time=100,
    )

    def slopes(_: float, T: Any) -> Any:
        flow = 0.05 * SIGMA * (T[0] ** 4 - T[1] ** 4)
        return [-flow / 200, flow / 500]

    expected = solve_ivp(
        slopes, (0, 100), [1200, 300], "DOP853", result.times, rtol=1e-11, atol=1e-9
    ).y
    assert values(result, "hot.T") == pytest.approx(expected[0], abs=1e-4)
    assert values(result, "cold.T") == pytest.approx(expected[1], abs=1e-4)
    flow = 0.05 * SIGMA * (expected[0] ** 4 - expected[1] ** 4)
    assert values(result, "sensor.Q_flow") == pytest.approx(flow, rel=1e-6)
    assert values(result, "difference.T_rel") == pytest.approx(expected[0] - expected[1], abs=1e-3)


def test_collectors_join_ports() -> None:
    result = run(
        """  thermal.FixedHeatFlow row[4](Q_flow = {1, 2, 3, 4});
  thermal.FixedHeatFlow matrix[2, 3](each Q_flow = 5);
  thermal.ThermalCollector collector(m = 4);
  thermal.ThermalCollectorMatrix all(m = 2, n = 3);
  thermal.ThermalResistor wall(R = 0.5);
  thermal.FixedTemperature outside(T = 280);
equation
  connect(row.port, collector.port_a);
  connect(matrix.port, all.port_a);
  connect(collector.port_b, all.port_b, wall.port_a);
  connect(wall.port_b, outside.port);
"""
    )
    assert values(result, "wall.Q_flow") == pytest.approx(10 + 30)
    assert values(result, "row[3].port.T") == pytest.approx(280 + 20)
    assert values(result, "matrix[2,3].port.T") == pytest.approx(280 + 20)


@pytest.mark.parametrize("fixed", ["true", "false"])
def test_sensor_with_a_constant_temperature_behind_it(fixed: str) -> None:
    result = run(
        f"""  thermal.HeatCapacitor body(C = 1, T(start = 400, fixed = true));
  thermal.HeatCapacitor other(C = 1, T(start = 300, fixed = true));
  thermal.ThermalConductor wall(G = 2);
  thermal.ConditionalFixedHeatFlowSensor sensor(T = 300, useFixedTemperature = {fixed});
equation
  connect(body.port, wall.port_a);
  connect(wall.port_b, sensor.port_a);
  connect(sensor.port_b, other.port);
"""
    )
    rate = 2 if fixed == "true" else 4
    expected = 200 * np.exp(-rate * result.times)
    assert values(result, "sensor.Q_flow") == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("rates", ["true", "false"])
def test_two_halves_that_exchange_signals_are_a_whole(rates: str) -> None:
    pass_rate = "connect(left.pder, right.pder);" if rates == "true" else ""
    result = run(
        f"""  thermal.HeatCapacitor a(C = 2, T(start = 400, fixed = true));
  thermal.HeatCapacitor b(C = 1, T(start = 300, fixed = true));
  thermal.ThermalConductor wall(G = 3);
  thermal.GeneralHeatFlowToTemperatureAdaptor left(use_pder = {rates});
  thermal.GeneralTemperatureToHeatFlowAdaptor right(use_pder = {rates});
equation
  connect(a.port, left.heatPort);
  connect(left.p, right.p);
  {pass_rate}
  connect(right.f, left.f);
  connect(right.heatPort, wall.port_a);
  connect(wall.port_b, b.port);
"""
    )
    end = (2 * 400 + 300) / 3
    decay = np.exp(-3 * 1.5 * result.times)
    assert values(result, "a.T") == pytest.approx(end + (400 - end) * decay, abs=1e-5)
    assert values(result, "b.T") == pytest.approx(end + (300 - end) * decay, abs=1e-5)
    assert values(result, "left.f") == pytest.approx(-300 * decay, abs=1e-4)
    if rates == "true":
        assert values(result, "right.pder") == pytest.approx(-150 * decay, abs=1e-4)


@st.composite
def networks(draw: st.DrawFn) -> tuple[list[float], list[float], list[tuple[str, int, int, float]]]:
    size = draw(st.integers(2, 5))
    positive = st.floats(0.2, 5)
    capacities = draw(st.lists(positive, min_size=size, max_size=size))
    starts = draw(st.lists(st.floats(250, 900), min_size=size, max_size=size))
    kinds = st.sampled_from(["conductor", "resistor", "convection", "radiation"])
    # a chain holds all bodies together, more elements lie across it
    elements = [(draw(kinds), k, k + 1, draw(positive)) for k in range(size - 1)]
    for _ in range(draw(st.integers(0, 4))):
        a, b = sorted(draw(st.permutations(range(size)))[:2])
        elements.append((draw(kinds), a, b, draw(positive)))
    return capacities, starts, elements


ELEMENT = {
    "conductor": ("ThermalConductor", "G = {0}", "port_a", "port_b"),
    "resistor": ("ThermalResistor", "R = 1/{0}", "port_a", "port_b"),
    "convection": ("Convection", "Gc = {0}", "solid", "fluid"),
    "radiation": ("BodyRadiation", "Gr = {0}/100", "port_a", "port_b"),
}


@given(networks())
@settings(max_examples=8, deadline=None, derandomize=True)
def test_random_networks_keep_their_heat(network: Any) -> None:
    capacities, starts, elements = network
    text, links = "", ""
    for k, (C, T) in enumerate(zip(capacities, starts, strict=True)):
        text += f"  thermal.HeatCapacitor c{k}(C = {C}, T(start = {T}, fixed = true));\n"
    for k, (kind, a, b, size) in enumerate(elements):
        name, modifier, first, second = ELEMENT[kind]
        text += f"  thermal.{name} e{k}({modifier.format(size)});\n"
        links += f"  connect(c{a}.port, e{k}.{first});\n  connect(e{k}.{second}, c{b}.port);\n"
    result = run(f"{text}equation\n{links}", stop_time=1)

    temperatures = np.array([values(result, f"c{k}.T") for k in range(len(capacities))])
    heat = np.array(capacities) @ temperatures
    assert heat == pytest.approx(heat[0], rel=1e-7)
    flows = sum(values(result, f"c{k}.port.Q_flow") for k in range(len(capacities)))
    assert flows == pytest.approx(0, abs=1e-6 * abs(temperatures).max())
    # heat flows from hot to cold, and differences only shrink
    for k, (_, a, b, _size) in enumerate(elements):
        fall = temperatures[a] - temperatures[b]
        assert np.all(values(result, f"e{k}.Q_flow") * fall >= -1e-6)
    assert np.all(np.diff(np.ptp(temperatures, axis=0)) <= 1e-5)

    if all(kind != "radiation" for kind, *_ in elements):
        G = np.zeros((len(capacities), len(capacities)))
        for _, a, b, size in elements:
            G[[a, b], [a, b]] += size
            G[[a, b], [b, a]] -= size
        end = expm(-G / np.array(capacities)[:, None]) @ np.array(starts)
        assert temperatures[:, -1] == pytest.approx(end, abs=1e-4)
