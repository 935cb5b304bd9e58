"""Library components that the examples do not use, in small models with known answers."""

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


TWO_PORT = """
  electrical.ConstantVoltage source(V = 6[V]);
  electrical.Resistor feed(R = 2[Ohm]);
  electrical.Resistor load(R = 4[Ohm]);
  electrical.Ground ground;
  {component} box({arguments});
equation
  connect(source.p, feed.p);
  connect(feed.n, box.p1);
  connect(box.p2, load.p);
  connect(source.n, box.n1, box.n2, load.n, ground.p);
"""


@pytest.mark.parametrize(
    ("component", "arguments", "voltage1", "current1", "voltage2"),
    [
        # a load of 4 Ohm looks like n^2 4 Ohm
        ("IdealTransformer", "n = 3", 6 * 36 / 38, 6 / 38, 2 * 36 / 38),
        # i1 = G2 v2, i2 = -G1 v1, v2 = -4 i2 = 2 v1: the box looks like 1 Ohm
        ("Gyrator", "G1 = 0.5[S], G2 = 0.5[S]", 2.0, 2.0, 4.0),
        ("VCV", "gain = 5", 6.0, 0.0, 30.0),
        ("VCC", "transConductance = 2[S]", 6.0, 0.0, -48.0),
        ("CCV", "transResistance = 7[Ohm]", 0.0, 3.0, 21.0),
        ("CCC", "gain = 2", 0.0, 3.0, -24.0),
    ],
)
def test_two_ports(
    component: str, arguments: str, voltage1: float, current1: float, voltage2: float
) -> None:
    text = TWO_PORT.format(component=f"electrical.{component}", arguments=arguments)
    result = run(text, points=3)
    assert values(result, "box.v1") == pytest.approx(voltage1, abs=1e-6)
    assert values(result, "box.i1") == pytest.approx(current1, abs=1e-6)
    assert values(result, "box.v2") == pytest.approx(voltage2, abs=1e-6)


def test_coils_coupled_by_a_matrix() -> None:
    result = run(
        """
  electrical.M_Transformer coils(N = 2, L = {2, 0.5, 1}, i(each fixed = true));
  electrical.ConstantVoltage source(V = 3[V]);
  electrical.Ground ground;
equation
  connect(source.p, coils.p[1]);
  connect(source.n, coils.n[1], coils.p[2], coils.n[2], ground.p);
"""
    )
    # the second coil is shorted: L i' = (3, 0)
    slope = np.linalg.solve([[2, 0.5], [0.5, 1]], [3, 0])
    assert values(result, "coils.i[1]") == pytest.approx(slope[0] * result.times, abs=1e-6)
    assert values(result, "coils.i[2]") == pytest.approx(slope[1] * result.times, abs=1e-6)


@pytest.mark.parametrize(
    ("amplifier", "gain"), [("IdealOpAmp3Pin", -5.0), ("OpAmp", -5.0), ("IdealOpAmpLimited", -5.0)]
)
def test_inverting_amplifier(amplifier: str, gain: float) -> None:
    supply = """
  electrical.SupplyVoltage supply;
equation
  connect(supply.ground, ground.p);
  connect(supply.pin_p, amplifier.VMax);
  connect(supply.pin_n, amplifier.VMin);
"""
    result = run(
        f"""
  electrical.SineVoltage source(V = 1[V], f = 2[Hz]);
  electrical.Resistor r1(R = 1[kOhm]);
  electrical.Resistor r2(R = 5[kOhm]);
  electrical.{amplifier} amplifier;
  electrical.Ground ground;
  electrical.PotentialSensor sensor;
{supply if amplifier != "IdealOpAmp3Pin" else "equation"}
  connect(source.p, r1.p);
  connect(r1.n, amplifier.in_n, r2.p);
  connect(r2.n, amplifier.out, sensor.p);
  connect(source.n, amplifier.in_p, ground.p);
"""
    )
    expected = gain * np.sin(4 * np.pi * result.times)
    assert values(result, "sensor.phi") == pytest.approx(expected, abs=1e-2)
    assert np.ptp(values(result, "sensor.phi")) > 9


def test_potentiometer_divides_the_voltage() -> None:
    result = run(
        """
  electrical.ConstantVoltage source(V = 10[V]);
  electrical.Potentiometer divider(R = 1[kOhm], useRinput = true);
  blocks.Ramp position(height = 1, duration = 1[s]);
  electrical.Ground ground;
  electrical.PotentialSensor sensor;
equation
  connect(source.p, divider.pin_p);
  connect(source.n, divider.pin_n, ground.p);
  connect(divider.contact, sensor.p);
  connect(position.y, divider.r);
"""
    )
    assert values(result, "sensor.phi") == pytest.approx(10 * result.times, abs=1e-6)


def test_variable_elements() -> None:
    result = run(
        """
  electrical.ConstantVoltage source(V = 10[V]);
  electrical.VariableResistor resistor;
  electrical.VariableConductor conductor;
  electrical.VariableCapacitor capacitor;
  electrical.VariableInductor inductor(i(fixed = true));
  blocks.Ramp ramp(offset = 2, height = 2, duration = 1[s]);
  electrical.Ground ground;
equation
  connect(source.p, resistor.p, conductor.p, capacitor.p, inductor.p);
  connect(source.n, resistor.n, conductor.n, capacitor.n, inductor.n, ground.p);
  connect(ramp.y, resistor.R, conductor.G, capacitor.C, inductor.L);
""",
        stop_time=0.9,
    )
    level = 2 + 2 * result.times
    assert values(result, "resistor.i") == pytest.approx(10 / level, abs=1e-6)
    assert values(result, "conductor.i") == pytest.approx(10 * level, abs=1e-6)
    assert values(result, "capacitor.i") == pytest.approx(20, abs=1e-4)
    assert values(result, "inductor.i") == pytest.approx(10 * result.times / level, abs=1e-5)


def test_sensors_do_not_disturb() -> None:
    result = run(
        """
  electrical.ConstantVoltage source(V = 12[V]);
  electrical.Resistor load(R = 4[Ohm]);
  electrical.CurrentSensor current;
  electrical.VoltageSensor voltage;
  electrical.MultiSensor all_;
  electrical.PowerSensor power;
  electrical.Ground ground;
equation
  connect(source.p, current.p);
  connect(current.n, all_.pc);
  connect(all_.nc, power.pc);
  connect(power.nc, load.p, voltage.p, all_.pv, power.pv);
  connect(source.n, load.n, voltage.n, all_.nv, power.nv, ground.p);
""",
        points=3,
    )
    assert values(result, "current.i") == pytest.approx(3)
    assert values(result, "voltage.v") == pytest.approx(12)
    assert values(result, "all_.power") == pytest.approx(36)
    assert values(result, "power.power") == pytest.approx(36)


SOURCES = [
    ("Step", "height = 2, startTime = 0.3[s], offset = 1", lambda t: 1 + 2 * (t > 0.3)),
    ("Ramp", "height = 2, duration = 0.5[s]", lambda t: 2 * np.minimum(t / 0.5, 1)),
    ("Sine", "f = 3[Hz], phase = 1[rad]", lambda t: np.sin(6 * np.pi * t + 1)),
    ("Cosine", "f = 3[Hz], phase = 1[rad]", lambda t: np.cos(6 * np.pi * t + 1)),
    ("Pulse", "period = 0.25[s], width = 40", lambda t: 1.0 * (t % 0.25 < 0.1)),
    ("SawTooth", "period = 0.25[s], nperiod = 2", lambda t: t % 0.25 / 0.25 * (t < 0.5)),
    (
        "Trapezoid",
        "period = 1[s], rising = 0.2[s], width = 0.3[s], falling = 0.2[s]",
        lambda t: np.clip(np.minimum(t / 0.2, (0.7 - t) / 0.2), 0, 1),
    ),
    (
        "ExpSine",
        "f = 2[Hz], damping = 3[1/s]",
        lambda t: np.exp(-3 * t) * np.sin(4 * np.pi * t),
    ),
    (
        "Exponentials",
        "riseTime = 0.4[s], riseTimeConst = 0.1[s]",
        lambda t: np.where(
            t < 0.4, 1 - np.exp(-t / 0.1), (1 - np.exp(-4)) * np.exp(-(t - 0.4) / 0.1)
        ),
    ),
]


@pytest.mark.parametrize(("block", "arguments", "signal"), SOURCES, ids=[s[0] for s in SOURCES])
def test_sources_of_signals(block: str, arguments: str, signal: Any) -> None:
    # The integral shows that the integrator sees the signal, not only the output points.
    result = run(
        f"""
  blocks.{block} source({arguments});
  blocks.Integrator integral;
equation
  connect(source.y, integral.u);
""",
        points=778,
    )
    jumps = np.array([0, 0.1, 0.25, 0.3, 0.35, 0.5, 0.6, 0.75, 0.85, 1])
    far = np.min(np.abs(result.times[:, None] - jumps), axis=1) > 1e-6
    found, expected = values(result, "source.y"), signal(result.times)
    assert found[far] == pytest.approx(expected[far], abs=1e-6)
    fine = np.linspace(0, 1, 200001)
    area = np.sum(signal((fine[1:] + fine[:-1]) / 2)) * 5e-6
    assert values(result, "integral.y")[-1] == pytest.approx(area, abs=2e-5)


@pytest.mark.parametrize("kind", ["Voltage", "Current"])
def test_electrical_sources_carry_their_signal(kind: str) -> None:
    quantity, unit = ("v", "V") if kind == "Voltage" else ("i", "A")
    connect = "connect(source.p, load.p); connect(source.n, load.n, ground.p);"
    result = run(
        f"""
  electrical.Pulse{kind} source({unit if unit == "V" else "I"} = 3, period = 0.5[s], width = 50);
  electrical.Resistor load(R = 2[Ohm]);
  electrical.Ground ground;
equation
  {connect}
"""
    )
    inside = np.abs((result.times + 0.125) % 0.25 - 0.125) > 1e-3
    expected = 3.0 * (result.times % 0.5 < 0.25)
    assert values(result, f"source.{quantity}")[inside] == pytest.approx(expected[inside], abs=1e-6)


def test_transfer_function_and_state_space_are_the_same() -> None:
    result = run(
        """
  blocks.Sine source(f = 1[Hz]);
  blocks.TransferFunction fraction(
    b = {1, 2}, a = {1, 0.5, 4}, initType = blocks.Init.InitialState);
  blocks.StateSpace space(
    A = [-0.5, -4; 1, 0], B = [1; 0], C = [1, 2], initType = blocks.Init.InitialState);
  blocks.SecondOrder lag(k = 1, w = 2, D = 0.125, initType = blocks.Init.InitialState);
  blocks.Der rate;
equation
  connect(source.y, fraction.u, space.u[1], lag.u);
  connect(lag.y, rate.u);
""",
        stop_time=5,
    )
    by_fraction = values(result, "fraction.y")
    assert values(result, "space.y[1]") == pytest.approx(by_fraction, abs=1e-6)
    # lag: 4/(s^2 + 0.5 s + 4)
    by_lag = (values(result, "rate.y") + 2 * values(result, "lag.y")) / 4
    assert by_lag == pytest.approx(by_fraction, abs=1e-6)
    assert np.ptp(by_fraction) > 0.1


def test_controller_brings_the_level_to_its_command() -> None:
    result = run(
        """
  blocks.Constant command(k = 2);
  blocks.Feedback difference;
  blocks.PID controller(k = 3, Ti = 1[s], Td = 0.05[s]);
  blocks.FirstOrder plant(k = 1, T = 1[s], initType = blocks.Init.InitialState);
equation
  connect(command.y, difference.u1);
  connect(plant.y, difference.u2);
  connect(difference.y, controller.u);
  connect(controller.y, plant.u);
""",
        stop_time=20,
    )
    assert values(result, "plant.y")[0] == pytest.approx(0)
    assert values(result, "plant.y")[-1] == pytest.approx(2, abs=1e-4)


def test_gears() -> None:
    result = run(
        """
  mechanical.rotational.ConstantTorque motor(tau_constant = 2[N.m]);
  mechanical.rotational.Inertia rotor(J = 1[kg.m2], phi(fixed = true), w(fixed = true));
  mechanical.rotational.IdealGear gear(ratio = 4);
  mechanical.rotational.Inertia drum(J = 8[kg.m2]);
  mechanical.rotational.IdealRollingWheel wheel(radius = 0.5[m]);
  mechanical.translational.Mass car(m = 6[kg]);
equation
  connect(motor.flange, rotor.flange_a);
  connect(rotor.flange_b, gear.flange_a);
  connect(gear.flange_b, drum.flange_a);
  connect(drum.flange_b, wheel.flangeR);
  connect(wheel.flangeT, car.flange_a);
"""
    )
    acceleration = 2 / (1 + (8 + 6 * 0.5**2) / 4**2)
    assert values(result, "rotor.w") == pytest.approx(acceleration * result.times, abs=1e-6)
    assert values(result, "car.v") == pytest.approx(acceleration / 8 * result.times, abs=1e-6)


def test_planetary_gear_with_a_fixed_ring() -> None:
    result = run(
        """
  mechanical.rotational.ConstantSpeed drive(w_fixed = 6[rad/s]);
  mechanical.rotational.IdealPlanetary gear(ratio = 2);
  mechanical.rotational.Fixed housing;
  mechanical.rotational.Damper brake(d = 3[N.m.s/rad]);
equation
  connect(drive.flange, gear.sun);
  connect(gear.ring, housing.flange, brake.flange_a);
  connect(gear.carrier, brake.flange_b);
"""
    )
    assert values(result, "brake.w_rel") == pytest.approx(2, abs=1e-6)
    assert values(result, "gear.sun.tau") == pytest.approx(2, abs=1e-6)


@pytest.mark.parametrize(
    ("field", "inertia", "argument", "speed"),
    [("translational", "Mass", "m = 2", "v"), ("rotational", "Inertia", "J = 2", "w")],
)
def test_spring_damper_warms_its_surroundings(
    field: str, inertia: str, argument: str, speed: str
) -> None:
    # What the mass loses is found as heat.
    result = run(
        f"""
  import mechanical.{field}.*;
  {inertia} body({argument}, {speed}(start = 3, fixed = true));
  SpringDamper link(c = 50, d = 1.5, useHeatPort = true);
  Fixed wall;
  thermal.HeatCapacitor heat(C = 10[J/K], T(start = 300, fixed = true));
equation
  connect(wall.flange, link.flange_a);
  connect(link.flange_b, body.flange_a);
  connect(link.heatPort, heat.port);
""",
        stop_time=20,
    )
    assert values(result, "heat.T")[-1] == pytest.approx(300 + 9 / 10, abs=1e-4)
    assert np.abs(values(result, f"body.{speed}")[-1]) < 1e-2


def test_mechanical_sensors() -> None:
    result = run(
        """
  import mechanical.translational.*;
  ConstantForce force(f_constant = 6[N]);
  ForceSensor cut;
  PowerSensor power;
  Mass mass(m = 2[kg], s(fixed = true), v(fixed = true));
  PositionSensor position;
  SpeedSensor speed;
  AccSensor acceleration;
  RelSpeedSensor relative;
  Fixed wall(s0 = -1[m]);
equation
  connect(force.flange, cut.flange_a);
  connect(cut.flange_b, power.flange_a);
  connect(power.flange_b, mass.flange_a, position.flange, speed.flange, acceleration.flange);
  connect(wall.flange, relative.flange_a);
  connect(mass.flange_b, relative.flange_b);
"""
    )
    t = result.times
    assert values(result, "cut.f") == pytest.approx(6)
    assert values(result, "position.s") == pytest.approx(1.5 * t**2, abs=1e-6)
    assert values(result, "speed.v") == pytest.approx(3 * t, abs=1e-6)
    assert values(result, "acceleration.a") == pytest.approx(3, abs=1e-6)
    assert values(result, "relative.v_rel") == pytest.approx(3 * t, abs=1e-6)
    assert values(result, "power.power") == pytest.approx(18 * t, abs=1e-5)


@pytest.mark.parametrize(("exact", "error"), [("true", 1e-6), ("false", 0.05)])
def test_prescribed_motion(exact: str, error: float) -> None:
    result = run(
        f"""
  import mechanical.translational.*;
  Position position(exact = {exact});
  Speed speed(exact = {exact}, s(fixed = true));
  Mass a(m = 1[kg]);
  Mass b(m = 1[kg]);
  blocks.Sine wave(f = 0.5[Hz]);
equation
  connect(wave.y, position.s_ref, speed.v_ref);
  connect(position.flange, a.flange_a);
  connect(speed.flange, b.flange_a);
""",
        stop_time=4,
    )
    omega = np.pi
    assert values(result, "a.s") == pytest.approx(np.sin(omega * result.times), abs=error)
    way = (1 - np.cos(omega * result.times)) / omega
    assert values(result, "b.s") == pytest.approx(way, abs=error)


def test_radiation_and_convection_reach_equilibrium() -> None:
    result = run(
        """
  thermal.FixedHeatFlow heater(Q_flow = 500[W]);
  thermal.HeatCapacitor plate(C = 1000[J/K], T(start = 300, fixed = true));
  thermal.BodyRadiation radiation(Gr = 0.5[m2]);
  thermal.Convection convection;
  blocks.Constant conductance(k = 4);
  thermal.celsius.FixedTemperature room(T = 20);
  thermal.celsius.TemperatureSensor sensor;
equation
  connect(heater.port, plate.port, radiation.port_a, convection.solid, sensor.port);
  connect(radiation.port_b, convection.fluid, room.port);
  connect(conductance.y, convection.Gc);
""",
        stop_time=4000,
    )
    final = values(result, "plate.T")[-1]
    lost = 0.5 * 5.670374419e-8 * (final**4 - 293.15**4) + 4 * (final - 293.15)
    assert lost == pytest.approx(500, rel=1e-4)
    assert values(result, "sensor.T")[-1] == pytest.approx(final - 273.15)


def test_thermal_collector_adds_heat_flows() -> None:
    result = run(
        """
  thermal.FixedHeatFlow heater[3](Q_flow = {1, 2, 3});
  thermal.ThermalCollector collector(m = 3);
  thermal.ThermalResistor wall(R = 2[K/W]);
  thermal.FixedTemperature room(T = 290[K]);
equation
  connect(heater.port, collector.port_a);
  connect(collector.port_b, wall.port_a);
  connect(wall.port_b, room.port);
""",
        points=3,
    )
    assert values(result, "heater[2].port.T") == pytest.approx(302)


def test_diode_follows_its_law() -> None:
    result = run(
        """
  electrical.RampVoltage source(V = 1[V], duration = 1[s]);
  electrical.Diode diode;
  electrical.Ground ground;
equation
  connect(source.p, diode.p);
  connect(source.n, diode.n, ground.p);
"""
    )
    x = result.times / 0.04
    law = np.where(x > 15, np.exp(15) * (1 + x - 15), np.exp(np.minimum(x, 15)))
    expected = 1e-6 * (law - 1) + result.times / 1e8
    assert values(result, "diode.i") == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_magnetic_circuit_without_a_gap_is_an_inductor() -> None:
    result = run(
        """
  electrical.ConstantVoltage source(V = 2[V]);
  electrical.Ground ground;
  magnetic.ElectroMagneticConverter coil(N = 100, Phi(start = 0, fixed = true));
  magnetic.ConstantReluctance core(R_m = 5e4[1/H]);
  magnetic.MagneticFluxSensor sensor;
  magnetic.Ground zero;
equation
  connect(source.p, coil.p);
  connect(source.n, coil.n, ground.p);
  connect(coil.port_p, core.port_p);
  connect(core.port_n, sensor.port_p);
  connect(sensor.port_n, coil.port_n, zero.port);
"""
    )
    inductance = 100**2 / 5e4
    assert values(result, "coil.i") == pytest.approx(2 * result.times / inductance, abs=1e-5)
    assert values(result, "sensor.Phi") == pytest.approx(2 * result.times / 100, abs=1e-8)
