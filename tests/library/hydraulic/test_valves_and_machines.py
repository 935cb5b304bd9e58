"""Valves, pumps, motors, cylinders, accumulators: their characteristics and balances."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from acausal import compile_text

RHO, BETA, ETA, P0 = 870.0, 1.6e9, 0.036, 101325.0


def simulate(text: str, oil: str = "", **options: Any) -> Any:
    text = f"import hydraulic.*;\nmodel M\n  inner Oil oil({oil});\n{text}\nend M;\n"
    return compile_text(text).simulate(**{"tolerance": 1e-8, **options})


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


# Openings P2A, P2B, A2T, B2T (and P2T) at the positions -1, 0, 1.
VALVES = {
    "V4_2": [(1, 0, 0, 1), (0, 1, 1, 0), (0, 1, 1, 0)],
    "V4_3CC": [(1, 0, 0, 1), (0, 0, 0, 0), (0, 1, 1, 0)],
    "ServoValve": [(1, 0, 0, 1), (0, 0, 0, 0), (0, 1, 1, 0)],
    "ProportionalValve": [(1, 0, 0, 1), (0, 0, 0, 0), (0, 1, 1, 0)],
    "V4_3OC": [(1, 0, 0, 1), (0.5, 0.5, 0.5, 0.5), (0, 1, 1, 0)],
    "V4_3OCFloat": [(1, 0, 0, 1), (0, 0, 1, 1), (0, 1, 1, 0)],
    "V4_3OCTandem": [(1, 0, 0, 1), (0, 0, 0, 0), (0, 1, 1, 0)],
    "V4_3CCRegenerative": [(1, 1, 0, 0), (0, 0, 0, 0), (0, 1, 1, 0)],
}


@pytest.mark.parametrize("kind", VALVES)
def test_directional_valve_opens_its_ways(kind: str) -> None:
    result = simulate(
        f"""  {kind} valve(dynamic = false, q_nom = 1e-3);
  ConstPressureSource pump(p_const = 100e5), a(p_const = 60e5), b(p_const = 40e5);
  OpenTank tank;
  blocks.Ramp position(offset = 1, height = -2, duration = 2);
equation
  connect(position.y, valve.control);
  connect(pump.port, valve.portP);
  connect(tank.port, valve.portT);
  connect(a.port, valve.portA);
  connect(b.port, valve.portB);""",
        stop_time=2,
        points=201,
    )
    for time, row in zip((0.0, 1.0, 2.0), VALVES[kind], strict=True):
        at = int(np.argmin(np.abs(result.times - time)))
        for edge, expected in zip(("P2A", "P2B", "A2T", "B2T"), row, strict=True):
            assert values(result, f"valve.{edge}.openFraction")[at] == pytest.approx(expected)
            flow = values(result, f"valve.{edge}.q")[at]
            dp = values(result, f"valve.{edge}.dp")[at]
            rho = values(result, f"valve.{edge}.rho")[at]
            law = expected * 1e-3 * np.sqrt(dp / 1e6 * 850 / rho)
            assert flow == pytest.approx(law, rel=1e-3, abs=2e-3 * 1e-3 * 10)
    if kind == "V4_3OCTandem":
        opening = 1 - np.abs(values(result, "valve.x"))
        assert values(result, "valve.P2T.openFraction") == pytest.approx(opening, abs=1e-9)
    flows = sum(values(result, f"valve.port{x}.m_flow") for x in "PTAB")
    assert flows == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(
    ("kind", "middle"),
    [("V6_3OC", 1), ("SV6_3OCParallel", 1), ("SV6_3OCTandem", 1), ("SV6_3CCParallel", 0)],
)
def test_six_way_valve_closes_its_bypass(kind: str, middle: int) -> None:
    supply = "" if kind == "SV6_3OCTandem" else ", valve.portP1"  # there it is inside
    result = simulate(
        f"""  {kind} valve(dynamic = false, q_nom = 1e-3);
  ConstPressureSource pump(p_const = 100e5), a(p_const = 60e5), b(p_const = 40e5);
  OpenTank tank;
  blocks.Ramp position(offset = -1, height = 2, duration = 2);
equation
  connect(position.y, valve.control);
  connect(pump.port, valve.portP{supply});
  connect(tank.port, valve.portT1, valve.portT2);
  connect(a.port, valve.portA);
  connect(b.port, valve.portB);""",
        stop_time=2,
        points=201,
    )
    at = [int(np.argmin(np.abs(result.times - time))) for time in (0, 1, 2)]
    ways = {"P22T1": (0, middle, 0), "P12A": (0, 0, 1), "P12B": (1, 0, 0)}
    ways |= {"A2T2": ways["P12B"], "B2T2": ways["P12A"]}
    for way, expected in ways.items():
        assert values(result, f"valve.{way}.openFraction")[at] == pytest.approx(expected)
    ports = ["P", "T1", "T2", "A", "B"] + ["P1"] * bool(supply)
    total = sum(values(result, f"valve.port{x}.m_flow") for x in ports)
    assert total == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(
    ("kind", "ports"),
    [
        ("V4_3CCLSHydAntiCavitation", {"P": "pump", "T": "tank"}),
        ("V6_3CCLS", {"P": "pump", "P1": "pump", "T1": "tank", "T2": "tank"}),
    ],
)
def test_the_load_signal_is_the_pressure_of_the_consumer(kind: str, ports: dict[str, str]) -> None:
    result = simulate(
        f"""  {kind} valve(dynamic = false, q_nom = 1e-3);
  ConstPressureSource pump(p_const = 100e5), a(p_const = 60e5), b(p_const = 40e5);
  OpenTank tank;
  Plug gauge;
  blocks.Ramp position(offset = -1, height = 2, duration = 2);
equation
  connect(position.y, valve.control);
  connect(a.port, valve.portA);
  connect(b.port, valve.portB);
  connect(gauge.port, valve.portLS);
"""
        + "".join(f"  connect({o}.port, valve.port{p});\n" for p, o in ports.items()),
        stop_time=2,
        points=201,
    )
    at = [int(np.argmin(np.abs(result.times - time))) for time in (0, 0.5, 1, 1.5, 2)]
    signal = values(result, "valve.portLS.p")[at]
    assert signal == pytest.approx([40e5, 40e5, P0, 60e5, 60e5], rel=1e-3)
    total = sum(values(result, f"valve.port{x}.m_flow") for x in ("A", "B", "LS", *ports))
    assert total == pytest.approx(0, abs=1e-9)


def test_a_consumer_draws_from_the_tank() -> None:
    result = simulate(
        """  V4_3CCLSHydAntiCavitation valve(dynamic = false, q_nom_check = 2e-3);
  ConstPressureSource pump(p_const = 100e5), a(p_const = 51325), b(p_const = 40e5);
  OpenTank tank;
  Plug gauge;
equation
  valve.control = 0;
  connect(pump.port, valve.portP);
  connect(tank.port, valve.portT);
  connect(a.port, valve.portA);
  connect(b.port, valve.portB);
  connect(gauge.port, valve.portLS);""",
        stop_time=1,
    )
    # half open at 0.5 bar
    drawn = values(result, "valve.T2A.q")[-1]
    assert values(result, "valve.T2A.openFraction")[-1] == pytest.approx(0.5)
    rho = values(result, "valve.T2A.rho")[-1]
    assert drawn == pytest.approx(2e-3 * 0.5 * np.sqrt(0.5 * 850 / rho), rel=2e-3)
    assert abs(values(result, "valve.T2B.q")[-1]) < 1e-3 * drawn


def test_sections_in_series_hand_the_oil_on() -> None:
    result = simulate(
        """  SV6_3OCSeries first(dynamic = false), second(dynamic = false);
  ConstVolumeSource pump(q = 2e-4);
  LaminarRestriction one(L = 1, D = 0.01), two(L = 1, D = 0.01);
  OpenTank tank;
equation
  first.control = 1;
  second.control = -1;
  connect(pump.port, first.portP);
  connect(first.portT1, second.portP);
  connect(second.portT1, tank.port);
  connect(first.portA, one.port_a);
  connect(one.port_b, first.portB);
  connect(second.portA, two.port_a);
  connect(two.port_b, second.portB);""",
        stop_time=1,
    )
    assert values(result, "one.q")[-1] == pytest.approx(2e-4, rel=0.02)
    assert values(result, "two.q")[-1] == pytest.approx(-2e-4, rel=0.02)


def test_spool_follows_as_a_second_order_system() -> None:
    result = simulate(
        """  V2_2 valve(bandwidth = 20, dampCoeff = 0.5, q_nom = 1e-3), other(normallyOpen = true);
  V3_2 three;
  ConstPressureSource pump(p_const = 50e5), load(p_const = 20e5);
  OpenTank tank;
  blocks.Step step(height = 0.6, startTime = 0.1);
equation
  connect(step.y, valve.control, other.control, three.control);
  connect(pump.port, valve.port_a, other.port_a, three.portP);
  connect(tank.port, valve.port_b, other.port_b, three.portT);
  connect(load.port, three.portA);""",
        stop_time=0.5,
    )
    w, d = 2 * np.pi * 20, 0.5
    t = np.maximum(result.times - 0.1, 0)
    wd = w * np.sqrt(1 - d**2)
    x = 0.6 * (1 - np.exp(-d * w * t) * (np.cos(wd * t) + d * w / wd * np.sin(wd * t)))
    assert values(result, "valve.x") == pytest.approx(x, abs=1e-6)
    # Another valve with other dynamics, open without signal.
    assert values(result, "other.edge.openFraction")[[0, -1]] == pytest.approx([1, 0.4], abs=1e-4)
    assert values(result, "three.A2T.openFraction")[[0, -1]] == pytest.approx([1, 0], abs=1e-4)
    assert values(result, "three.P2A.openFraction")[[0, -1]] == pytest.approx([0, 0.2], abs=1e-4)


def test_pressure_valves_hold_their_pressures() -> None:
    result = simulate(
        """  VarVolumeSource pump;
  VolumeClosed line(V = 1e-3, p(start = 101325, fixed = true));
  ReliefValve relief(dp_relief = 10e6, q_nom = 2e-3);
  PressureReducingValve reducing(p_set = 3e6, q_nom = 1e-3, timeConstant = 2e-3);
  VolumeClosed low(V = 1e-3, p(start = 101325, fixed = true));
  GenericPressureLoss consumer(D = 1.5e-3, zeta = 2);
  Anticavitation_ReliefValve both(dp_relief = 10e6);
  OpenTank tank;
  PressureSensor gauge;
  blocks.Trapezoid rate(amplitude = 1.2e-3, rising = 1, width = 1, falling = 0.5, period = 10,
    nperiod = 1, offset = -1e-4);
equation
  connect(rate.y, pump.control);
  connect(pump.port, line.port, relief.port_a, reducing.port_a, both.port_a, gauge.port);
  connect(reducing.port_b, low.port, consumer.port_a);
  connect(relief.port_b, consumer.port_b, both.port_b, tank.port);""",
        stop_time=4,
    )
    p, t = values(result, "gauge.p"), result.times
    late = (t > 1.5) & (t < 2)
    assert np.all(p[late] > 10e6 + P0)
    assert np.all(p[late] < 10.5e6 + P0)
    low = values(result, "low.p")[late]
    assert np.all(low < 3e6)
    assert np.all(low > 2.8e6)
    opening = values(result, "relief.valvePosition")[late]
    expected = (values(result, "relief.dp")[late] - 10e6) / 0.5e6
    assert opening == pytest.approx(expected, rel=1e-3)
    # Drawn from: the anticavitation valve lets oil in from the tank.
    assert p[-1] == pytest.approx(P0, rel=0.3)
    assert values(result, "both.checkValve.q")[-1] > 0.8e-4


def test_shuttle_and_compensator() -> None:
    result = simulate(
        """  VarPressureSource one;
  ConstPressureSource two(p_const = 5e6), load(p_const = 6e6);
  ShuttleValve shuttle(q_nom = 1e-4);
  VolumeClosed line(V = 1e-5, p(start = 5e6, fixed = true));
  PostPCValve compensator(p_margin = 1e5, dynamic = false, q_nom = 1e-3);
  VariableRestriction metering(control = 0.5, q_nom = 1e-3);
  ConstPressureSource supply(p_const = 8e6);
  blocks.Sine sine(amplitude = 3e6, offset = 5e6, f = 1);
equation
  connect(sine.y, one.control);
  connect(one.port, shuttle.PortA);
  connect(two.port, shuttle.PortB);
  connect(shuttle.PortC, line.port, compensator.port_LS);
  connect(supply.port, metering.port_a);
  connect(metering.port_b, compensator.port_a);
  connect(compensator.port_b, load.port);""",
        stop_time=1,
        points=2001,
    )
    first = values(result, "one.control")
    found = values(result, "line.p")
    apart = (np.abs(first - 5e6) > 1e5) & (result.times > 0.01)
    assert found[apart] == pytest.approx(np.maximum(first, 5e6)[apart], rel=2e-3)
    # The pressure behind the metering edge lies above that of the load by up to the margin, while
    # the load can be overcome; then the flow through the edge depends on this difference only.
    active = found < 7.8e6
    above = values(result, "compensator.port_a.p") - found
    reached = values(result, "compensator.valvePosition")
    assert above[active & (reached < 0.99)] == pytest.approx(
        1e5 * reached[active & (reached < 0.99)], abs=1.0
    )


def test_pump_and_motor_losses() -> None:
    result = simulate(
        """  mechanical.rotational.ConstantSpeed engine(w_fixed = 150), shaft(w_fixed = -20);
  ConstantDisplacementPump pump(Dconst = 2e-5);
  VariableDisplacementPump other(Dmax = 2e-5, dispFraction = 0.4);
  FluidPower2MechRotVar ideal(Dmax = 2e-5, Dmin = -2e-5, dispFraction = -0.7);
  FluidPower2MechRotConst simple(Dconst = 3e-5);
  Motor motor(Dconst = 5e-5, usePRV = true, dp_relief = 30e6);
  ConstPressureSource high(p_const = 20e6);
  CircuitTank tank(V_init = 0.2);
  PowerSensor power;
  FlowSensor meter;
equation
  connect(engine.flange, pump.flange_a, other.flange_a, ideal.flange_a, simple.flange_a);
  connect(shaft.flange, motor.flange_b);
  connect(pump.portP, power.port_a);
  connect(power.port_b, meter.port_a);
  connect(meter.port_b, high.port, other.portP, ideal.port_b, simple.port_b, motor.portA);
  connect(tank.port_b, pump.portT, other.portT, ideal.port_a, simple.port_a);
  connect(tank.port_a, motor.portB);""",
        stop_time=1,
    )
    dp, w, d = 20e6 - P0, 150.0, 2e-5 / (2 * np.pi)
    rho = RHO * np.exp(dp / 2 / BETA)
    leak = 1.8e-9 * dp * 2e-5 / ETA + dp / BETA * w * d * (0.54 + 1)
    out = -values(result, "pump.portP.m_flow") / rho
    assert out == pytest.approx(d * w - leak, rel=1e-9)
    torque = d * (dp + 60000 * ETA * w + 0.007 * dp * w / np.sqrt(w**2 + 1))
    assert values(result, "pump.flange_a.tau") == pytest.approx(torque, rel=1e-9)
    efficiency = out * dp / (torque * w)
    assert np.all((efficiency > 0.8) & (efficiency < 1))
    assert values(result, "other.q") == pytest.approx(0.4 * d * w)
    assert values(result, "ideal.q") == pytest.approx(-0.7 * d * w)
    assert values(result, "simple.flange_a.tau") == pytest.approx(3e-5 / (2 * np.pi) * dp)
    assert values(result, "power.power") == pytest.approx(values(result, "meter.y") * dp)
    # A motor that turns backwards against the pressure is a pump.
    assert values(result, "motor.idealMotor.q") == pytest.approx(-20 * 5e-5 / (2 * np.pi))
    assert np.all(values(result, "motor.losses.lossPower") > 0)
    flow = values(result, "tank.port_a.m_flow") + values(result, "tank.port_b.m_flow")
    content = values(result, "tank.volumeOpen.V_actual")
    assert content[-1] - 0.2 == pytest.approx(flow[0] / RHO, rel=1e-6)


@pytest.mark.parametrize("kind", ["PCLSPump", "PCLSPumpSignalControlled"])
def test_load_sensing_pump_keeps_its_margin(kind: str) -> None:
    sensed = {
        "PCLSPump": "connect(pump.portLS, load.port);",
        "PCLSPumpSignalControlled": "connect(pressure.y, pump.control);",
    }[kind]
    result = simulate(
        f"""  mechanical.rotational.ConstantSpeed engine(w_fixed = 150);
  {kind} pump(Dmax = 5e-5, p_margin = 2e6, propGain = 1e-5);
  VolumeClosed line(V = 1e-3, p(start = 7e6, fixed = true));
  VariableRestriction metering(q_nom = 5e-4, dp_nom = 2e6, control = 0.6);
  VarPressureSource load;
  OpenTank tank;
  blocks.Ramp pressure(offset = 5e6, height = 8e6, duration = 1, startTime = 0.5);
equation
  connect(engine.flange, pump.flange_a);
  connect(tank.port, pump.portT);
  connect(pump.portP, line.port, metering.port_a);
  connect(metering.port_b, load.port);
  connect(pressure.y, load.control);
  {sensed}""",
        stop_time=2,
    )
    late = (result.times > 0.3) & (result.times < 0.5) | (result.times > 1.7)
    margin = (values(result, "line.p") - values(result, "load.control"))[late]
    x = values(result, "pump.x")[late]
    assert margin == pytest.approx(2e6 - x / 1e-5, abs=1e4)
    assert np.all((x > 0.1) & (x < 0.9))
    flow = values(result, "metering.q")[late]
    assert flow == pytest.approx(0.6 * 5e-4, rel=0.05)


def test_accumulator_takes_what_the_polytropic_law_says() -> None:
    result = simulate(
        """  VarVolumeSource pump;
  Accumulator accumulator(liquidVolume = 0.8e-3, gasVolume = 1e-3, p_precharge = 5e6,
    exponent = 1.3,
    p(start = 1e6, fixed = true));
  blocks.Constant rate(k = 1e-4);
equation
  connect(rate.y, pump.control);
  connect(pump.port, accumulator.port);""",
        stop_time=9,
    )
    p, liquid = values(result, "accumulator.p"), values(result, "accumulator.V_liquid")
    full = 5e6 * 5**1.3
    between = (p > 5e6) & (p < full)
    assert liquid[between] == pytest.approx(1e-3 * (1 - (5e6 / p[between]) ** (1 / 1.3)), abs=1e-9)
    assert set(liquid[p < 5e6]) == {0.0}
    assert np.max(liquid) == pytest.approx(0.8e-3)
    assert p[-1] > full
    rho = RHO * np.exp((p - P0) / BETA)
    assert values(result, "accumulator.m") == pytest.approx(rho * (0.016e-3 + liquid), rel=1e-9)
    gas = values(result, "accumulator.p") * values(result, "accumulator.V_gas") ** 1.3
    assert gas[between] == pytest.approx(5e6 * 1e-3**1.3, rel=1e-9)


def test_air_chamber_springs_back() -> None:
    # A mass on a column of gas: small oscillations with the stiffness n p A^2/V.
    result = simulate(
        """  AirChamber gas(A = 1e-2, p_precharge = 101325, V_precharge = 2e-3,
    residualVolume = 0, exponent = 1.4);
  mechanical.translational.Mass mass(m = 5, s(start = 0.2001, fixed = true), v(start = 0,
    fixed = true));
  mechanical.translational.Fixed fixed;
equation
  connect(fixed.flange, gas.flange_a);
  connect(gas.flange_b, mass.flange_a);""",
        stop_time=1,
    )
    w = np.sqrt(1.4 * P0 * 1e-4 / 2e-3 / 5)
    expected = 0.2 + 1e-4 * np.cos(w * result.times)
    assert values(result, "mass.s") == pytest.approx(expected, abs=1e-6)


def test_double_acting_cylinder_moves_between_its_stops() -> None:
    result = simulate(
        """  DoubleActingCylinder cylinder(boreDiameter = 50e-3, rodDiameter = 30e-3,
    strokeLength = 0.2,
    useCushionRod = true, closedLength = 0.3, D_B2Env = 1e-4,
    cylinderChamberHead(p(start = 101325, fixed = true)), cylinderChamberRod(p(start = 101325,
    fixed = true)));
  mechanical.translational.Mass load(m = 80, s(start = 0.3, fixed = true), v(start = 0,
    fixed = true));
  mechanical.translational.Fixed fixed;
  V4_3CC valve(q_nom = 5e-4, dp_nom = 1e6, bandwidth = 100);
  ConstPressureSource pump(p_const = 8e6);
  OpenTank tank;
  blocks.Step out(height = 1), back(height = -2, startTime = 1.5);
equation
  valve.control = out.y + back.y;
  connect(fixed.flange, cylinder.flange_a);
  connect(cylinder.flange_b, load.flange_a);
  connect(pump.port, valve.portP);
  connect(tank.port, valve.portT);
  connect(valve.portA, cylinder.port_a);
  connect(valve.portB, cylinder.port_b);""",
        stop_time=3,
        points=3001,
    )
    t, s, v = result.times, values(result, "cylinder.s"), values(result, "load.v")
    assert values(result, "load.s") == pytest.approx(s + 0.3, abs=1e-9)
    # Steady extension: the same spool opening meters both sides, flows in the ratio of the areas.
    head, rod = np.pi / 4 * 50e-3**2, np.pi / 4 * (50e-3**2 - 30e-3**2)
    steady = (s > 0.1) & (s < 0.15) & (t < 1.5)
    pa = values(result, "cylinder.cylinderChamberHead.p")[steady]
    pb = values(result, "cylinder.cylinderChamberRod.p")[steady]
    assert head * (pa - P0) - rod * (pb - P0) == pytest.approx(1e3 * v[steady], rel=2e-2)
    assert values(result, "valve.P2A.q")[steady] == pytest.approx(head * v[steady], rel=5e-3)
    # The cushion brakes over the last 30 mm, the stop holds, the piston returns to the other one.
    assert np.max(v[(s > 0.195) & (t < 1.5)]) < 0.5 * np.max(v[steady])
    assert s[np.searchsorted(t, 1.4)] == pytest.approx(0.2, abs=1e-3)
    assert s[-1] == pytest.approx(0, abs=1e-3)
    assert s.min() > -1e-3
    assert s.max() < 0.201


def test_single_acting_cylinder_and_spring() -> None:
    result = simulate(
        """  SingleActingCylinder cylinder(boreDiameter = 40e-3, strokeLength = 0.1,
    springRate = 5e3, preload = 200,
    cylinderChamberHead(p(start = 101325, fixed = true)));
  mechanical.translational.Fixed fixed;
  LaminarRestriction pipe(L = 1, D = 10e-3);
  VarPressureSource source;
  blocks.TimeTable p(table = [0, 101325; 1, 101325; 2, 5e5; 4, 5e5; 5, 2e6; 6, 2e6]);
equation
  connect(p.y, source.control);
  connect(source.port, pipe.port_a);
  connect(pipe.port_b, cylinder.port_a);
  connect(fixed.flange, cylinder.flange_a);""",
        stop_time=6,
    )
    t, s = result.times, values(result, "cylinder.s")
    area = np.pi / 4 * 40e-3**2
    assert s[np.searchsorted(t, 0.9)] == pytest.approx(-200 / 1e8, abs=1e-5)
    expected = (area * (5e5 - P0) - 200) / 5e3
    assert s[np.searchsorted(t, 3.9)] == pytest.approx(expected, rel=1e-3)
    assert s[-1] == pytest.approx(0.1, abs=1e-4)


def test_seat_valve_forces() -> None:
    # Lift prescribed: flow over the area of a cone, forces of pressure and flow on the flange.
    result = simulate(
        """  SeatValve valve(d_seat = 2e-3, alpha = 0.5);
  ConstPressureSource high(p_const = 15e6);
  OpenTank tank;
  mechanical.translational.Position drive(exact = true);
  blocks.Ramp lift(offset = -1e-4, height = 1e-3, duration = 1);
equation
  connect(lift.y, drive.s_ref);
  connect(drive.flange, valve.flange);
  connect(high.port, valve.port_a);
  connect(valve.port_b, tank.port);""",
        stop_time=1,
    )
    dp = 15e6 - P0
    s = values(result, "valve.s")
    area = np.clip(np.pi * 2e-3 * np.sin(0.5) * s, 0, np.pi * 1e-6)
    rho = RHO * np.exp(dp / 2 / BETA)
    flow = 0.7 * area * np.sqrt(2 * dp / rho)
    open_ = area > 2e-7
    assert values(result, "valve.q")[open_] == pytest.approx(flow[open_], rel=2e-3)
    assert np.all(np.abs(values(result, "valve.q")[s <= 0]) < 1e-8)
    force = np.pi * 1e-6 * dp - 2 * 0.49 * np.cos(0.5) * area * dp
    assert -values(result, "valve.flange.f") == pytest.approx(force, rel=1e-9)
