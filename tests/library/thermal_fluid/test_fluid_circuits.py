"""Heat in flowing media: characteristics, closed forms, and the balance of random circuits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acausal import AcausalError, compile_text

RHO, CP = 995.6, 4177.0  # water


def run(text: str, stop_time: float = 1.0, **options: Any) -> Any:
    options = {"tolerance": 1e-9, "points": 101, **options}
    text = f"import thermal.fluid.*;\nmodel Test\n{text}\nend Test;\n"
    return compile_text(text).simulate(stop_time=stop_time, **options)


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


@pytest.mark.parametrize(
    ("medium", "density", "capacity", "volume_capacity"),
    [
        ("Medium", 1, 1, 1),
        ("Air_30degC", 1.149, 1007, 720),
        ("Air_70degC", 1.015, 1010, 723),
        ("Water", 995.6, 4177, 4177),
        ("Water_10degC", 999.7, 4192, 4192),
        ("Water_90degC", 965.3, 4205, 4205),
        ("Glycol20_20degC", 1028, 3910, 3910),
        ("Glycol50_20degC", 1078, 3300, 3300),
        ("MineralOil", 868, 2010, 2010),
    ],
)
def test_media_carry_heat(
    medium: str, density: float, capacity: float, volume_capacity: float
) -> None:
    # A plug that is warmed up: first order lag with the time constant m cv/(m_flow cp).
    result = run(
        f"""  parameter Medium medium = {medium}();
  Ambient source(medium = medium, constantAmbientTemperature = 300);
  VolumeFlow pump(medium = medium, constantVolumeFlow = 2, m = 0);
  HeatedPipe pipe(medium = medium, m = medium.rho*1[m3], T0 = 300, T0fixed = true);
  Ambient sink(medium = medium);
  thermal.FixedHeatFlow heat(Q_flow = 10[K.m3/s]*medium.rho*medium.cp);
equation
  connect(source.flowPort, pump.flowPort_a);
  connect(pump.flowPort_b, pipe.flowPort_a);
  connect(pipe.flowPort_b, sink.flowPort);
  connect(heat.port, pipe.heatPort);
"""
    )
    rate = 2 * capacity / volume_capacity
    expected = 300 + 5 * (1 - np.exp(-rate * result.times))
    assert values(result, "pipe.T") == pytest.approx(expected, abs=1e-5)
    assert values(result, "pump.flowPort_a.m_flow") == pytest.approx(2 * density)
    assert values(result, "pipe.dT") == pytest.approx(expected - 300, abs=1e-5)


def test_media_conduct_and_flow_as_they_should() -> None:
    # Prandtl numbers of the textbooks
    media = {
        "Air_30degC": 0.71,
        "Air_70degC": 0.71,
        "Water": 5.4,
        "Water_10degC": 9.44,
        "Water_90degC": 1.95,
    }
    text = "".join(
        f"  parameter Medium m{k} = {medium}();\n"
        f"  Real Pr{k} = m{k}.nu*m{k}.rho*m{k}.cp/m{k}.lambda;\n"
        for k, medium in enumerate(media)
    )
    result = run(text)
    found = [values(result, f"Pr{k}")[0] for k in range(len(media))]
    assert found == pytest.approx(list(media.values()), rel=0.03)


@pytest.mark.parametrize("sign", [1, -1])
def test_pipe_friction_height_and_loss(sign: int) -> None:
    result = run(
        f"""  Ambient a(medium = Water()), b(medium = Water());
  VolumeFlow pump(medium = Water(), m = 0, useVolumeFlowInput = true,
    volumeFlow = {sign}*2e-3*time);
  IsolatedPipe pipe(medium = Water(), m = 0, h_g = 3, V_flowLaminar = 5e-4, dpLaminar = 100,
    V_flowNominal = 1.5e-3, dpNominal = 2000, frictionLoss = 0.5);
  RelPressureSensor dp(medium = Water());
equation
  connect(a.flowPort, pump.flowPort_a);
  connect(pump.flowPort_b, pipe.flowPort_a, dp.flowPort_a);
  connect(pipe.flowPort_b, b.flowPort, dp.flowPort_b);
"""
    )
    V = 2e-3 * result.times
    k = (2000 - 300) / 1e-3**2
    drop = 100 * V / 5e-4 + k * np.maximum(V - 5e-4, 0) ** 2
    assert values(result, "pipe.pressureDrop") == pytest.approx(sign * drop, abs=1e-6)
    assert values(result, "dp.y") == pytest.approx(sign * drop + RHO * 9.80665 * 3, abs=1e-6)
    assert values(result, "pipe.Q_friction") == pytest.approx(0.5 * V * drop, abs=1e-8)
    # what is lost to friction is in the medium: m cp dT = loss
    flowing = V > 1e-4
    rise = 0.5 * drop[flowing] / (RHO * CP)
    assert values(result, "pipe.dT")[flowing] == pytest.approx(sign * rise, abs=1e-6)


@pytest.mark.parametrize(
    ("V", "dp", "message"), [(2, 0.1, "larger than the laminar"), (0.1, 0.5, "at least that of")]
)
def test_friction_refuses_curves_that_do_not_exist(V: float, dp: float, message: str) -> None:
    with pytest.raises(AcausalError, match=message):
        run(
            f"""  Ambient a, b(constantAmbientPressure = 1);
  Pipe pipe(V_flowLaminar = {V}, dpLaminar = {dp});
equation
  connect(a.flowPort, pipe.flowPort_a);
  connect(pipe.flowPort_b, b.flowPort);
"""
        )


@pytest.mark.parametrize("linear", ["true", "false"])
def test_characteristics_of_valves(linear: str) -> None:
    result = run(
        f"""  Ambient a(medium = Water(), constantAmbientPressure = 4e5), b(medium = Water());
  Valve valve(medium = Water(), LinearCharacteristic = {linear}, y1 = 2, Kv1 = 1e-3, kv0 = 0.05,
    dp0 = 1e5, rho0 = 1000, frictionLoss = 1, y = 2.5*time - 0.25);
  VolumeFlowSensor V(medium = Water());
  MassFlowSensor m(medium = Water());
  EnthalpyFlowSensor H(medium = Water());
  TemperatureSensor T(medium = Water());
equation
  connect(a.flowPort, valve.flowPort_a);
  connect(valve.flowPort_b, V.flowPort_a);
  connect(V.flowPort_b, m.flowPort_a);
  connect(m.flowPort_b, H.flowPort_a);
  connect(H.flowPort_b, b.flowPort, T.flowPort);
"""
    )
    y = np.clip(2.5 * result.times - 0.25, 0, 2) / 2
    Kv = 1e-3 * (0.05 + 0.95 * y if linear == "true" else 0.05 ** (1 - y))
    V = Kv * np.sqrt(4 * 1000 / RHO)
    assert values(result, "V.y") == pytest.approx(V, rel=1e-6)
    assert values(result, "m.y") == pytest.approx(RHO * V, rel=1e-6)
    T = 293.15 + 4e5 / (RHO * CP)  # throttling with its loss in the medium
    assert values(result, "T.y") == pytest.approx(T, abs=1e-5)
    assert values(result, "H.y") == pytest.approx(RHO * V * CP * T, rel=1e-6)


def test_one_way_valve_rectifies() -> None:
    result = run(
        """  Ambient a(medium = Water(), usePressureInput = true), b(medium = Water());
  OneWayValve valve(medium = Water(), V_flowNominal = 1e-3, dpForward = 100, dpNominal = 1e5,
    V_flowBackward = 1e-8, frictionLoss = 1);
  Pipe pipe(medium = Water(), m = 0, V_flowLaminar = 1e-3, dpLaminar = 1e5, V_flowNominal = 1.1e-3,
    dpNominal = 1.1e5);
equation
  a.ambientPressure = 1e5*sin(2*constants.pi*time);
  connect(a.flowPort, valve.flowPort_a);
  connect(valve.flowPort_b, pipe.flowPort_a);
  connect(pipe.flowPort_b, b.flowPort);
""",
        points=401,
    )
    p = 1e5 * np.sin(2 * np.pi * result.times)
    expected = np.where(p > 0, p / (1e8 + 1e5), p / (1e8 + 1e13))
    assert values(result, "valve.V_flow") == pytest.approx(expected, abs=1e-12)
    assert len(result.events) == 1
    assert np.all(values(result, "valve.Q_flow") >= -1e-12)


def test_mixing() -> None:
    result = run(
        """  Ambient cold(medium = Water(), constantAmbientTemperature = 280);
  Ambient warm(medium = Water(), useTemperatureInput = true, ambientTemperature = 350 + 10*time);
  Ambient sink(medium = Water(), constantAmbientTemperature = 300);
  VolumeFlow one(medium = Water(), m = 0, constantVolumeFlow = 1e-3);
  MassFlow other(medium = Water(), m = 0, useMassFlowInput = true, massFlow = 3e-3*995.6);
  RelTemperatureSensor rise(medium = Water());
equation
  connect(cold.flowPort, one.flowPort_a, rise.flowPort_a);
  connect(warm.flowPort, other.flowPort_a);
  connect(one.flowPort_b, other.flowPort_b, sink.flowPort, rise.flowPort_b);
"""
    )
    mixed = (280 + 3 * (350 + 10 * result.times)) / 4
    assert values(result, "sink.T_port") == pytest.approx(mixed, abs=1e-6)
    assert values(result, "rise.y") == pytest.approx(280 - mixed, abs=1e-6)
    assert values(result, "sink.T") == pytest.approx(300)


def test_the_heat_port_lies_between_inlet_and_outlet() -> None:
    result = run(
        """  parameter Integer n = 3;
  Ambient a[n](each medium = Water()), b[n](each medium = Water());
  VolumeFlow pump[n](each medium = Water(), each m = 0, each constantVolumeFlow = 1e-3);
  HeatedPipe pipe[n](each medium = Water(), each m = 0, tapT = {0, 0.5, 1});
  thermal.FixedHeatFlow heat[n](each Q_flow = 41.77e3);
  thermal.TemperatureSensor wall[n];
equation
  connect(a.flowPort, pump.flowPort_a);
  connect(pump.flowPort_b, pipe.flowPort_a);
  connect(pipe.flowPort_b, b.flowPort);
  connect(heat.port, pipe.heatPort, wall.port);
"""
    )
    rise = 41.77e3 / (RHO * 1e-3 * CP)
    for k, part in enumerate((0, 0.5, 1), 1):
        assert values(result, f"wall[{k}].T") == pytest.approx(293.15 + part * rise, abs=1e-6)


@pytest.mark.parametrize("backwards", [1, -1])
def test_pump_curve_and_power(backwards: int) -> None:
    result = run(
        f"""  Ambient a(medium = Water()), b(medium = Water());
  IdealPump pump(medium = Water(), m = 0, wNominal = 150, dp0 = 3e5, V_flow0 = 2e-3);
  mechanical.rotational.Speed speed(exact = true, w_ref = {backwards}*(30 + 270*time));
  Pipe pipe(medium = Water(), m = 0, V_flowLaminar = 1e-3, dpLaminar = 5e4, V_flowNominal = 2e-3,
    dpNominal = 1e5);
equation
  connect(speed.flange, pump.flange_a);
  connect(a.flowPort, pump.flowPort_a);
  connect(pump.flowPort_b, pipe.flowPort_a);
  connect(pipe.flowPort_b, b.flowPort);
"""
    )
    r = 0.2 + 1.8 * result.times
    V = 3e5 * r**2 / (5e7 + 3e5 * r / 2e-3)
    assert values(result, "pump.V_flow") == pytest.approx(backwards * V, abs=1e-9)
    assert values(result, "pipe.dp") == pytest.approx(backwards * 5e7 * V, abs=1e-3)
    shaft = values(result, "pump.flange_a.tau") * values(result, "pump.w")
    assert shaft == pytest.approx(5e7 * V**2, abs=1e-5)


def test_tank_empties_through_a_laminar_pipe() -> None:
    result = run(
        """  OpenTank tank(medium = Water(), ATank = 0.5, hTank = 2, pAmbient = 1e5,
    useHeatPort = true, T0 = 330, T0fixed = true, level(start = 1, fixed = true));
  Pipe pipe(medium = Water(), m = 0, V_flowLaminar = 1, dpLaminar = 1e5,
    V_flowNominal = 2, dpNominal = 2e5);
  Ambient out(medium = Water(), constantAmbientPressure = 1e5);
  thermal.FixedHeatFlow sun(Q_flow = 500e3);
equation
  connect(tank.flowPort, pipe.flowPort_a);
  connect(pipe.flowPort_b, out.flowPort);
  connect(sun.port, tank.heatPort);
""",
        stop_time=10,
    )
    rate = RHO * 9.80665 / 1e5 / 0.5
    level = np.exp(-rate * result.times)
    assert values(result, "tank.level") == pytest.approx(level, abs=1e-7)
    # m cp der(T) = Q, as what flows out has the temperature of the tank
    rise = 500e3 / (0.5 * RHO * CP) * (1 / level - 1) / rate
    assert values(result, "tank.TTank") == pytest.approx(330 + rise, abs=1e-5)
    assert values(result, "tank.H") == pytest.approx(
        values(result, "tank.m") * CP * (330 + rise), rel=1e-6
    )


def test_tank_that_runs_dry_says_so() -> None:
    result = run(
        """  OpenTank tank(level(start = 0.5, fixed = true), T0fixed = true);
  VolumeFlow pump(m = 0, constantVolumeFlow = 1);
  Ambient out;
equation
  connect(tank.flowPort, pump.flowPort_a);
  connect(pump.flowPort_b, out.flowPort);
""",
        stop_time=0.6,
        points=7,
    )
    assert any("runs dry" in str(found) for found in result.diagnostics)


@pytest.mark.parametrize("support", ["true", "false"])
def test_piston_on_a_cylinder(support: str) -> None:
    fixed = "connect(cylinder.support, ground.flange);" if support == "true" else ""
    ground = "mechanical.translational.Fixed ground(s0 = 0.5);" if support == "true" else ""
    offset = 0.5 if support == "true" else 0
    result = run(
        f"""  Cylinder cylinder(medium = Water(), A = 0.01, L = 2, T0 = 320, T0fixed = true,
    useSupport = {support});
  mechanical.translational.Mass mass(m = 50, L = 0, s(start = {0.2 + offset}, fixed = true),
    v(start = 0, fixed = true));
  {ground}
  Pipe pipe(medium = Water(), m = 0, V_flowLaminar = 1, dpLaminar = 1e7,
    V_flowNominal = 2, dpNominal = 2e7);
  Ambient supply(medium = Water(), constantAmbientPressure = 1e4, constantAmbientTemperature = 300);
equation
  connect(supply.flowPort, pipe.flowPort_a);
  connect(pipe.flowPort_b, cylinder.flowPort);
  connect(cylinder.flange, mass.flange_a);
  {fixed}
""",
        stop_time=0.5,
    )
    # m a = A (p - R A v)
    t, tau = result.times, 50 / (1e7 * 1e-4)
    v_end = 1e4 / (1e7 * 0.01)
    s = 0.2 + v_end * (t - tau * (1 - np.exp(-t / tau)))
    assert values(result, "cylinder.s") == pytest.approx(s, abs=1e-6)
    assert values(result, "mass.s") == pytest.approx(s + offset, abs=1e-6)
    mixed = (0.2 * 320 + (s - 0.2) * 300) / s
    assert values(result, "cylinder.T") == pytest.approx(mixed, abs=1e-3)


def test_heat_swings_to_and_fro_with_the_flow() -> None:
    # Two pipes in a ring, the flow reverses twice: no heat is lost, and at rest nothing moves.
    result = run(
        """  VolumeFlow pump(m = 0, useVolumeFlowInput = true);
  Pipe a(m = 1, T0 = 350, T0fixed = true), b(m = 2, T0 = 290, T0fixed = true);
  AbsolutePressure vessel(p = 1e5);
  PressureSensor p;
equation
  pump.volumeFlow = 1[m3/s]*(if time < 1 then 0 elseif time < 3 then sin(constants.pi*time) else 0);
  connect(pump.flowPort_b, a.flowPort_a);
  connect(a.flowPort_b, b.flowPort_a, vessel.flowPort, p.flowPort);
  connect(b.flowPort_b, pump.flowPort_a);
""",
        stop_time=4,
        points=401,
        max_step=2e-3,
    )
    t, a, b = result.times, values(result, "a.T"), values(result, "b.T")
    assert a + 2 * b == pytest.approx(350 + 580, abs=1e-4)
    assert a[t < 1] == pytest.approx(350, abs=1e-3)
    # every second of half a sine moves 2/pi kg through each pipe
    passed = 2 * (2 / np.pi)
    assert a[-1] - b[-1] == pytest.approx(60 * np.exp(-1.5 * passed), abs=1e-3)
    assert values(result, "p.y") == pytest.approx(1e5)


@st.composite
def circuits(draw: st.DrawFn) -> tuple[int, list[tuple[int, int, float, float]], float, float]:
    nodes = draw(st.integers(2, 4))
    size, mass = st.floats(0.5, 3), st.sampled_from([0.0, 0.5, 1.0, 2.0])
    ring = [(k, k + 1, draw(size), draw(mass) + (k == 0)) for k in range(nodes - 1)]
    more = []
    for _ in range(draw(st.integers(1, 3))):
        a, b = draw(st.permutations(range(nodes)))[:2]
        more.append((a, b, draw(size), draw(mass)))
    return nodes, ring + more, draw(st.floats(1, 8)), draw(st.sampled_from([0.0, 2.0, 5.0]))


@given(circuits())
@settings(max_examples=8, deadline=None, derandomize=True)
def test_random_circuits_lose_nothing(circuit: Any) -> None:
    nodes, pipes, pressure, swing = circuit
    ends: dict[int, list[str]] = {k: [] for k in range(nodes)}
    text = "  PressureIncrease pump(m = 0, usePressureIncreaseInput = true);\n"
    text += "  AbsolutePressure vessel;\n  Real heat(start = 0, fixed = true), losses;\n"
    ends[0] += ["pump.flowPort_b", "vessel.flowPort"]
    ends[nodes - 1].append("pump.flowPort_a")
    heats, losses = [], []
    for k, (a, b, size, mass) in enumerate(pipes):
        fixed = "true" if mass else "false"
        text += (
            f"  HeatedPipe pipe{k}(m = {mass}, T0 = {290 + 20 * k}, T0fixed = {fixed},"
            f" V_flowLaminar = {size}, dpLaminar = 1, V_flowNominal = {3 * size},"
            f" dpNominal = 8, frictionLoss = 0.5);\n"
            f"  thermal.PrescribedHeatFlow heat{k}(Q_flow = {(-1) ** k * size}*time*1[W/s]);\n"
        )
        ends[a].append(f"pipe{k}.flowPort_a")
        ends[b].append(f"pipe{k}.flowPort_b")
        heats += [f"heat{k}.Q_flow", f"pipe{k}.Q_friction"]
        losses.append(f"pipe{k}.V_flow*pipe{k}.dp")
    text += "equation\n"
    text += "".join(f"  connect(pipe{k}.heatPort, heat{k}.port);\n" for k in range(len(pipes)))
    text += "".join(f"  connect({', '.join(cuts)});\n" for cuts in ends.values())
    text += f"  pump.pressureIncrease = {pressure}*cos({swing}*time);\n"
    text += f"  der(heat) = {' + '.join(heats)};\n  losses = {' + '.join(losses)};\n"
    result = run(text, stop_time=1)

    # each storage has m cv T; what comes in is the heat and the friction
    stored = sum(mass * values(result, f"pipe{k}.T") for k, (*_, mass) in enumerate(pipes) if mass)
    if any(mass for *_, mass in pipes):
        assert stored - values(result, "heat") == pytest.approx(stored[0], abs=1e-5 * stored[0])
    # the pump gives what friction takes
    work = -values(result, "pump.dp") * values(result, "pump.V_flow")
    assert values(result, "losses") == pytest.approx(work, abs=1e-7)
    assert np.all(work >= -1e-9)
    assert values(result, "vessel.flowPort.m_flow") == pytest.approx(0, abs=1e-9)
