"""Switches, ideal diodes and thyristors, arcs and operational amplifiers against closed forms."""

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


def mean(result: Any, path: str, start: float = 0.0) -> float:
    """Return the mean value from ``start`` to the end; jumps have two samples at one time."""
    inside = result.times >= start
    times, signal = result.times[inside], values(result, path)[inside]
    return float(np.trapezoid(signal, times) / (times[-1] - times[0]))


BRIDGE = """
  electrical.SineVoltage source(V = 10[V], f = 1[Hz]);
  electrical.IdealDiode a{mod}, b{mod}, c{mod}, d{mod};
  electrical.Resistor load(R = 5[Ohm]);
  electrical.Ground ground;
{more}
equation
  connect(source.p, a.p, c.n);
  connect(source.n, b.p, d.n);
  connect(a.n, b.n, load.p);
  connect(c.p, d.p, load.n, ground.p);
{connects}
"""


def test_bridge_rectifier_has_the_mean_of_a_rectified_sine() -> None:
    result = run(BRIDGE.format(mod="", more="", connects=""), points=4001)
    assert mean(result, "load.v") == pytest.approx(20 / np.pi, rel=2e-5)
    expected = np.abs(10 * np.sin(2 * np.pi * result.times))
    # both ends of the source hang in the air while nothing conducts: Goff = 1e-5 S against 0.2 S
    assert values(result, "load.v") == pytest.approx(expected, abs=1e-3)


def test_knee_voltage_shortens_the_time_of_conduction() -> None:
    result = run(BRIDGE.format(mod="(Vknee = 0.7[V])", more="", connects=""), points=4001)
    expected = np.maximum(np.abs(10 * np.sin(2 * np.pi * result.times)) - 1.4, 0)
    assert values(result, "load.v") == pytest.approx(expected, abs=2e-3)
    # two diodes of 0.7 V in the path
    angle = np.arcsin(0.14)
    area = (20 * np.cos(angle) - 1.4 * (np.pi - 2 * angle)) / np.pi
    assert mean(result, "load.v") == pytest.approx(area, rel=5e-4)


def test_bridge_turns_what_it_loses_into_heat() -> None:
    diodes = "abcd"
    result = run(
        BRIDGE.format(
            mod="(Vknee = 0.7[V], Ron = 0.1[Ohm], useHeatPort = true)",
            more="  thermal.HeatCapacitor heat(C = 1[J/K], T(start = 300, fixed = true));\n"
            "  Real source_energy(start = 0, fixed = true), load_energy(start = 0, fixed = true);",
            connects=f"connect(heat.port, {', '.join(f'{d}.heatPort' for d in diodes)});\n"
            "der(source_energy) = -source.v*source.i;\nder(load_energy) = load.v*load.i;",
        )
    )
    heat = values(result, "heat.T")[-1] - 300
    delivered, used = values(result, "source_energy")[-1], values(result, "load_energy")[-1]
    assert heat > 0.5
    assert delivered == pytest.approx(used + heat, rel=1e-6)


HALF_WAVE = """
  electrical.SineVoltage source(V = 10[V], f = 1[Hz]);
  electrical.{valve} valve(off(fixed = true));
  electrical.Resistor load(R = 5[Ohm]);
  electrical.Ground ground;
  blocks.BooleanPulse gate(period = 1[s], startTime = {start}[s], width = {width});
equation
  connect(source.p, valve.p);
  connect(valve.n, load.p);
  connect(load.n, source.n, ground.p);
  connect(gate.y, valve.fire);
"""


@pytest.mark.parametrize("degrees", [30, 60, 90, 135])
def test_thyristor_conducts_from_the_firing_angle_to_the_zero_of_the_current(degrees: int) -> None:
    text = HALF_WAVE.format(valve="IdealThyristor", start=degrees / 360, width=1)
    result = run(text, stop_time=2.0, points=2001)
    expected = 10 / (2 * np.pi) * (1 + np.cos(np.radians(degrees)))
    assert mean(result, "load.v") == pytest.approx(expected, rel=2e-4)


def test_gto_thyristor_ends_with_its_gate_signal() -> None:
    text = HALF_WAVE.format(valve="IdealGTOThyristor", start=0.1, width=20)
    result = run(text, stop_time=2.0, points=2001)
    expected = 10 / (2 * np.pi) * (np.cos(0.2 * np.pi) - np.cos(0.6 * np.pi))
    assert mean(result, "load.v") == pytest.approx(expected, rel=2e-4)


def test_triac_conducts_in_both_half_waves() -> None:
    result = run(
        """
  electrical.SineVoltage source(V = 10[V], f = 1[Hz]);
  electrical.IdealTriac triac(Vknee = 0[V], Rdis = 1e6[Ohm], Cdis = 1e-9[F],
    capacitor(v(fixed = true)),
    idealThyristor(off(fixed = true)), idealThyristor1(off(fixed = true)));
  electrical.Resistor load(R = 5[Ohm]);
  electrical.Ground ground;
  blocks.BooleanPulse gate(period = 0.5[s], startTime = 0.25[s], width = 1);
equation
  connect(source.p, triac.p);
  connect(triac.n, load.p);
  connect(load.n, source.n, ground.p);
  connect(gate.y, triac.fire1);
""",
        stop_time=2.0,
        points=4001,
    )
    # a firing angle of 90 degrees: the square has half the mean of the full wave
    square = np.trapezoid(values(result, "load.v") ** 2, result.times) / 2
    assert square == pytest.approx(25, rel=1e-3)
    assert mean(result, "load.v") == pytest.approx(0, abs=2e-3)


def test_buck_converter_in_continuous_conduction() -> None:
    duty, supply, period, inductance = 0.4, 12.0, 2e-4, 2e-3
    result = run(
        f"""
  electrical.ConstantVoltage source(V = {supply}[V]);
  electrical.IdealClosingSwitch switch;
  electrical.IdealDiode diode;
  electrical.Inductor coil(L = {inductance}[H], i(start = 1.2, fixed = true));
  electrical.Capacitor capacitor(C = 1e-3[F], v(start = 4.8, fixed = true));
  electrical.Resistor load(R = 4[Ohm]);
  electrical.Ground ground;
  blocks.BooleanPulse pulse(period = {period}[s], width = {100 * duty});
equation
  connect(source.p, switch.p);
  connect(switch.n, diode.n, coil.p);
  connect(coil.n, capacitor.p, load.p);
  connect(source.n, diode.p, capacitor.n, load.n, ground.p);
  connect(pulse.y, switch.control);
""",
        stop_time=0.06,
        points=60001,
    )
    assert mean(result, "load.v", 0.05) == pytest.approx(duty * supply, rel=1e-3)
    settled = result.times >= 0.0599
    ripple = np.ptp(values(result, "coil.i")[result.times >= 0.0598])
    assert ripple == pytest.approx(supply * duty * (1 - duty) * period / inductance, rel=1e-2)
    assert np.min(values(result, "coil.i")[settled]) > 0


@pytest.mark.parametrize(
    ("switch", "signal", "conducts"),
    [
        ("IdealOpeningSwitch", "control", lambda t: t < 0.5),
        ("IdealClosingSwitch", "control", lambda t: t >= 0.5),
        ("ControlledIdealOpeningSwitch", "pin", lambda t: t < 0.5),
        ("ControlledIdealClosingSwitch", "pin", lambda t: t >= 0.5),
    ],
)
def test_switches(switch: str, signal: str, conducts: Any) -> None:
    boolean = signal == "control"
    result = run(
        f"""
  electrical.ConstantVoltage source(V = 6[V]);
  electrical.{switch} switch;
  electrical.Resistor load(R = 3[Ohm]);
  electrical.Ground ground;
  {"blocks.BooleanStep" if boolean else "electrical.StepVoltage"} step(startTime = 0.5[s]);
equation
  connect(source.p, switch.p);
  connect(switch.n, load.p);
  connect(load.n, source.n, ground.p);
  {
            "connect(step.y, switch.control);"
            if boolean
            else "connect(step.p, switch.control); connect(step.n, ground.p);"
        }
""",
        points=102,
    )
    expected = np.where(conducts(result.times), 2 / (1 + 1e-5 / 3), 2 * 3e-5 / (1 + 3e-5))
    away = np.abs(result.times - 0.5) > 1e-9
    assert values(result, "load.i")[away] == pytest.approx(expected[away], rel=1e-6)


# The control of a switch: a truth value, or the potential of a pin.
CONTROLS = {
    "Ideal": ("blocks.BooleanStep", "connect(step.y, switch.control);"),
    "ControlledIdeal": (
        "electrical.StepVoltage",
        "connect(step.p, switch.control); connect(step.n, ground.p);",
    ),
}


@pytest.mark.parametrize("prefix", CONTROLS)
def test_two_way_switch_connects_one_of_two_pins(prefix: str) -> None:
    kind, wiring = CONTROLS[prefix]
    result = run(
        f"""
  electrical.ConstantVoltage source(V = 6[V]);
  electrical.{prefix}TwoWaySwitch switch;
  electrical.Resistor first(R = 3[Ohm]), second(R = 2[Ohm]);
  electrical.Ground ground;
  {kind} step(startTime = 0.5[s]);
equation
  connect(source.p, switch.p);
  connect(switch.n1, first.p);
  connect(switch.n2, second.p);
  connect(first.n, second.n, source.n, ground.p);
  {wiring}
""",
        points=102,
    )
    high = result.times > 0.5 + 1e-9
    low = result.times < 0.5 - 1e-9
    assert values(result, "first.i")[low] == pytest.approx(2, rel=1e-4)
    assert values(result, "second.i")[high] == pytest.approx(3, rel=1e-4)
    assert values(result, "first.i")[high] == pytest.approx(6e-5, rel=1e-3)
    assert values(result, "second.i")[low] == pytest.approx(6e-5, rel=1e-3)


@pytest.mark.parametrize("prefix", CONTROLS)
def test_intermediate_switch_crosses_its_pairs(prefix: str) -> None:
    kind, wiring = CONTROLS[prefix]
    result = run(
        f"""
  electrical.ConstantVoltage source(V = 6[V]);
  electrical.{prefix}IntermediateSwitch switch;
  electrical.Resistor load(R = 3[Ohm]);
  electrical.Ground ground;
  {kind} step(startTime = 0.5[s]);
equation
  connect(source.p, switch.p1);
  connect(source.n, switch.p2, ground.p);
  connect(switch.n1, load.p);
  connect(switch.n2, load.n);
  {wiring}
""",
        points=102,
    )
    away = np.abs(result.times - 0.5) > 1e-9
    expected = np.where(result.times < 0.5, 2.0, -2.0)
    assert values(result, "load.i")[away] == pytest.approx(expected[away], rel=1e-3)
    assert values(result, "switch.LossPower")[away] == pytest.approx(
        2 * 1e-5 * 4 + 2 * 1e-5 * 36, rel=1e-2
    )


@pytest.mark.parametrize("controlled", [False, True])
def test_arc_carries_the_current_of_a_coil_down(controlled: bool) -> None:
    # a coil of 1 mH with 10 A against 12 V of the source and 60 V of the arc
    kind, step = ("ControlledOpenerWithArc", "electrical.StepVoltage")
    wiring = "connect(step.p, switch.control); connect(step.n, ground.p);"
    if not controlled:
        kind, step = ("OpenerWithArc", "blocks.BooleanStep")
        wiring = "connect(step.y, switch.control);"
    result = run(
        f"""
  electrical.ConstantVoltage source(V = 12[V]);
  electrical.{kind} switch(V0 = 60[V], Vmax = 60[V]);
  electrical.Inductor coil(L = 1e-3[H], i(start = 10, fixed = true));
  electrical.Ground ground;
  {step} step(startTime = 1e-4[s]);
equation
  connect(source.p, switch.p);
  connect(switch.n, coil.p);
  connect(coil.n, source.n, ground.p);
  {wiring}
""",
        stop_time=5e-4,
        points=1001,
    )
    top = 10 + 12 / 1e-3 * 1e-4
    expected = np.where(
        result.times < 1e-4,
        10 + 12e3 * result.times,
        np.maximum(top - 48e3 * (result.times - 1e-4), 1.2e-4),
    )
    assert values(result, "coil.i") == pytest.approx(expected, abs=1e-3)
    assert bool(values(result, "switch.quenched")[-1])


def test_arc_voltage_rises_to_its_limit() -> None:
    result = run(
        """
  electrical.ConstantVoltage source(V = 12[V]);
  electrical.CloserWithArc switch(V0 = 30[V], dVdt = 1e5[V/s], Vmax = 60[V]);
  electrical.Inductor coil(L = 10e-3[H], i(start = 10, fixed = true));
  electrical.Ground ground;
  blocks.BooleanStep step(startTime = 1e-4[s], startValue = true);
equation
  connect(source.p, switch.p);
  connect(switch.n, coil.p);
  connect(coil.n, source.n, ground.p);
  connect(step.y, switch.control);
""",
        stop_time=6e-4,
        points=1001,
    )
    burns = result.times > 1e-4 + 1e-9
    expected = np.minimum(60, 30 + 1e5 * (result.times - 1e-4))
    assert values(result, "switch.v")[burns] == pytest.approx(expected[burns], rel=1e-6)


@pytest.mark.parametrize("amplifier", ["IdealizedOpAmpLimited", "OpAmpLimited"])
def test_amplifier_stops_at_its_supply(amplifier: str) -> None:
    result = run(
        f"""
  electrical.SineVoltage source(V = 5[V], f = 1[Hz]);
  electrical.Resistor r1(R = 1[kOhm]), r2(R = 5[kOhm]);
  electrical.{amplifier} amplifier(Vps = 12[V], Vns = -8[V]);
  electrical.Ground ground;
equation
  connect(source.p, r1.p);
  connect(r1.n, amplifier.in_n, r2.p);
  connect(r2.n, amplifier.out);
  connect(source.n, amplifier.in_p, ground.p);
""",
        points=1001,
    )
    # gain -5 with a finite amplification of 15000
    ideal = -25 / (1 + 6 / 15000) * np.sin(2 * np.pi * result.times)
    assert values(result, "amplifier.v_out") == pytest.approx(np.clip(ideal, -8, 12), abs=1e-5)
    balance = values(result, "amplifier.p_s") + values(result, "amplifier.p_out")
    assert balance + values(result, "amplifier.p_in") == pytest.approx(0, abs=1e-12)


def test_amplifier_tells_when_it_is_limited() -> None:
    result = run(
        """
  electrical.SineVoltage source(V = 2[mV], f = 1[Hz]);
  electrical.OpAmpLimited amplifier(useFirstOrder = true, Tau = 1e-6[s]);
  electrical.Resistor load(R = 1[kOhm]);
  electrical.Ground ground;
equation
  connect(source.p, amplifier.in_p);
  connect(source.n, amplifier.in_n, load.n, ground.p);
  connect(amplifier.out, load.p);
""",
        points=1001,
    )
    # 2 mV times 15000 are 30 V: limited from 30 to 150 and from 210 to 330 degrees
    up, down = values(result, "amplifier.satPos"), values(result, "amplifier.satNeg")
    angle = 360 * result.times
    far = np.min(np.abs(angle[:, None] - np.array([30, 150, 210, 330])), axis=1) > 0.01
    assert np.array_equal(up[far] > 0.5, ((angle > 30) & (angle < 150))[far])
    assert np.array_equal(down[far] > 0.5, ((angle > 210) & (angle < 330))[far])


def test_multivibrator_jumps_where_its_characteristic_ends() -> None:
    # The output jumps where gain times input falls to the limit: at 15 V (1/2 - 1/15000).
    result = run(
        """
  electrical.IdealizedOpAmpLimited amplifier;
  electrical.Resistor r1(R = 1[kOhm], i(start = 0)), r2(R = 1[kOhm]), r(R = 1[kOhm]);
  electrical.Capacitor c(C = 1e-4[F], v(start = 1, fixed = true));
  electrical.Ground ground;
equation
  connect(amplifier.out, r.p, r2.p);
  connect(r.n, amplifier.in_n, c.p);
  connect(r2.n, amplifier.in_p, r1.p);
  connect(ground.p, r1.n, c.n);
"""
    )
    limit = 15 * (0.5 - 1 / 15000)
    out = values(result, "amplifier.v_out")
    sign = out[0] / 15
    times = result.times[np.flatnonzero(np.abs(np.diff(out)) > 20) + 1]
    first = 0.1 * np.log((15 - sign) / (15 - limit))
    half_period = 0.1 * np.log((15 + limit) / (15 - limit))
    assert abs(sign) == pytest.approx(1)
    assert times == pytest.approx(first + half_period * np.arange(len(times)), abs=1e-6)
    assert len(times) > 7


def test_schmitt_trigger_has_its_hysteresis() -> None:
    result = run(
        """
  electrical.SineVoltage source(V = 12[V], f = 1[Hz]);
  electrical.IdealizedOpAmpLimited amplifier(Vps = 10[V], Vns = -10[V]);
  electrical.Resistor r1(R = 1[kOhm]), r2(R = 1[kOhm]);
  electrical.Ground ground;
equation
  connect(source.p, amplifier.in_n);
  connect(amplifier.out, r2.p);
  connect(r2.n, amplifier.in_p, r1.p);
  connect(ground.p, r1.n, source.n);
""",
        stop_time=2.0,
        points=1001,
    )
    out, drive = values(result, "amplifier.v_out"), values(result, "source.v")
    jumps = np.flatnonzero(np.abs(np.diff(out)) > 15)
    threshold = 10 * (0.5 - 1 / 15000)
    assert len(jumps) >= 3
    # from 10 V to -10 V on the way up, back on the way down
    assert drive[jumps] == pytest.approx(threshold * np.sign(out[jumps]), abs=1e-4)


@pytest.mark.parametrize(("kind", "variable"), [("Voltage", "v"), ("Current", "i")])
def test_source_with_a_table(kind: str, variable: str) -> None:
    result = run(
        f"""
  electrical.Table{kind} source(table = [0, 1; 0.4, 3; 0.4, -2; 0.8, -2; 1, 0],
    offset = 1, startTime = 0.1[s]);
  electrical.Resistor load(R = 2[Ohm]);
  electrical.Ground ground;
equation
  connect(source.p, load.p);
  connect(source.n, load.n, ground.p);
""",
        points=107,
    )
    times = result.times - 0.1
    table = np.interp(times, [0, 0.4, 0.4 + 1e-12, 0.8, 1], [1, 3, -2, -2, 0])
    expected = 1 + np.where(times < 0, 0, table)
    away = np.min(np.abs(times[:, None] - np.array([0, 0.4])), axis=1) > 1e-9
    assert values(result, f"source.{variable}")[away] == pytest.approx(expected[away], abs=1e-9)
