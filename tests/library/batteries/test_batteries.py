"""Batteries and double layer capacitors: charge, voltage, losses, limits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acausal import compile_text


def run(text: str, stop_time: float = 1.0, **options: Any) -> Any:
    options = {"tolerance": 1e-8, "points": 101, **options}
    text = f"import electrical.batteries.*;\nmodel Test\n{text}\nend Test;\n"
    return compile_text(text).simulate(stop_time=stop_time, **options)


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


CELL = "Qnom = 36000, OCVmax = 4, OCVmin = 3, Ri = 0.01"
LOAD = """  electrical.ConstantCurrent load(I = {0});
  electrical.Ground ground;
equation
  connect(battery.p, load.p);
  connect(battery.n, load.n, ground.p);
"""


def test_stack_of_cells() -> None:
    result = run(
        f"""  CellStack battery(Ns = 5, Np = 2, cellData({CELL}, alpha = 0.01),
    T = 303.15, SOCStart = 0.8);
{LOAD.format(20)}""",
        stop_time=3600,
    )
    SOC = 0.8 - 20 * result.times / 72000 * 1
    assert values(result, "battery.SOC") == pytest.approx(SOC, abs=1e-8)
    R = 0.01 * 1.1 * 5 / 2
    assert values(result, "battery.v") == pytest.approx(5 * (3 + SOC) - R * 20, abs=1e-6)
    assert values(result, "battery.LossPower") == pytest.approx(R * 400)


def test_open_circuit_voltage_by_table() -> None:
    table = "[0, 0.7; 0.2, 0.85; 0.9, 0.95; 1, 1]"
    result = run(
        f"""  CellStack battery(
    cellData({CELL}, useLinearSOCDependency = false, OCV_SOC = {table}));
{LOAD.format(10)}""",
        stop_time=3600,
    )
    expected = 4 * np.interp(1 - result.times / 3600, [0, 0.2, 0.9, 1], [0.7, 0.85, 0.95, 1])
    assert values(result, "battery.v") == pytest.approx(expected - 0.1, abs=1e-5)


def test_slow_part_of_the_resistance() -> None:
    result = run(
        f"""  CellRCStack battery(Ns = 3, Np = 2, nRC = 2, R = {{0.002, 0.005}},
    C = {{5000, 20000}}, cellData({CELL}));
{LOAD.format(20)}""",
        stop_time=200,
    )
    t = result.times
    slow = 0.002 * (1 - np.exp(-t / 10)) + 0.005 * (1 - np.exp(-t / 100))
    expected = 3 * (4 - 10 * t / 36000 - 10 * (0.003 + slow))
    assert values(result, "battery.v") == pytest.approx(expected, abs=1e-6)


def test_self_discharge() -> None:
    result = run(
        f"""  CellStack battery(Np = 3, cellData({CELL}, Idis = 2));
{LOAD.format(0)}""",
        stop_time=7200,
    )
    # i = 2 (3 + SOC)/4 per cell
    SOC = 4 * np.exp(-2 / 4 * result.times / 36000) - 3
    assert values(result, "battery.SOC") == pytest.approx(SOC, abs=1e-7)


def test_an_empty_battery_warns() -> None:
    result = run(
        f"  CellStack battery(SOCStart = 0.1, cellData({CELL}));\n{LOAD.format(10)}", stop_time=600
    )
    assert any("beyond empty" in str(found) for found in result.diagnostics)


def test_double_layer_capacitor() -> None:
    result = run(
        """  SuperCap battery(Vnom = 2.5, C = 500, Rs = 2e-3, Idis = 0.5, SOCStart = 0.8,
    alpha = 0.02, T = 313.15);
"""
        + LOAD.format(5),
        stop_time=50,
    )
    tau, end = 500 * 2.5 / 0.5, -5 * 2.5 / 0.5
    vC = end + (2 - end) * np.exp(-result.times / tau)
    assert values(result, "battery.vC") == pytest.approx(vC, abs=1e-6)
    assert values(result, "battery.v") == pytest.approx(vC - 5 * 2e-3 * 1.4, abs=1e-6)
    assert values(result, "battery.SOC") == pytest.approx(vC / 2.5, abs=1e-6)


@given(
    st.sampled_from(["CellStack", "CellRCStack"]),
    st.integers(1, 5),
    st.integers(1, 3),
    st.floats(-100, 100),
    st.floats(0, 1),
)
@settings(max_examples=6, deadline=None, derandomize=True)
def test_power_is_stored_or_becomes_heat(
    kind: str, Ns: int, Np: int, current: float, leak: float
) -> None:
    field = f"{Ns * Np}*sum(battery.C[k]*battery.vElement[k]^2/2 for k in 1:2)"
    result = run(
        f"""  {kind} battery(Ns = {Ns}, Np = {Np}, SOCStart = 0.5, useHeatPort = true,
    cellData({CELL}, alpha = 0.005, Idis = {leak}));
  thermal.HeatCapacitor case(C = 100, T(start = 300, fixed = true));
  Real work(start = 0, fixed = true, nominal = 1e4);
  Real chemical(start = 0, fixed = true, nominal = 1e4);
  Real polarised = {field if kind == "CellRCStack" else "0"};
  electrical.ConstantCurrent load(I = {current});
  electrical.Ground ground;
equation
  connect(battery.p, load.p);
  connect(battery.n, load.n, ground.p);
  connect(battery.heatPort, case.port);
  der(work) = battery.power;
  der(chemical) = battery.OCV*{Np}*36000*der(battery.SOC);
""",
        stop_time=300,
        tolerance=1e-9,
    )
    heat = 100 * (values(result, "case.T") - 300)
    balance = values(result, "chemical") + values(result, "polarised") + heat
    scale = max(1.0, float(np.abs(values(result, "work")).max()))
    assert balance == pytest.approx(values(result, "work"), abs=1e-5 * scale)
    assert np.all(np.diff(heat) >= -1e-6)
