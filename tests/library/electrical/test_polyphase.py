"""Polyphase circuits against phasors, and star against delta."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.electrical.circuits import run, values

OMEGA = 2 * np.pi * 50


def test_star_of_resistors_and_coils() -> None:
    result = run(
        """
  import electrical.polyphase.*;
  SineVoltage source(m = 3, V = fill(300, 3), f = fill(50, 3));
  Star star(m = 3), neutral(m = 3);
  Resistor resistor(m = 3, R = {10, 20, 30});
  Inductor inductor(m = 3, L = fill(0.05, 3), inductor(i(each fixed = true, each start = 0)));
  CurrentSensor ammeter(m = 3);
  VoltageSensor voltmeter(m = 3);
  PowerSensor wattmeter(m = 3);
  electrical.Ground ground;
equation
  connect(source.plug_p, wattmeter.pc, wattmeter.pv);
  connect(wattmeter.nc, ammeter.plug_p);
  connect(ammeter.plug_n, resistor.plug_p, voltmeter.plug_p);
  connect(resistor.plug_n, voltmeter.plug_n, inductor.plug_p);
  connect(inductor.plug_n, neutral.plug_p);
  connect(source.plug_n, star.plug_p, wattmeter.nv);
  connect(star.pin_n, neutral.pin_n, ground.p);
""",
        stop_time=0.1,
        points=1001,
    )
    late = result.times > 0.08
    t = result.times[late]
    power = 0.0
    for k, resistance in enumerate((10, 20, 30)):
        phasor = 300 * np.exp(-2j * np.pi * k / 3) / (resistance + 0.05j * OMEGA)
        expected = np.imag(phasor * np.exp(1j * OMEGA * t))
        assert values(result, f"ammeter.i[{k + 1}]")[late] == pytest.approx(expected, abs=1e-4)
        found = values(result, f"voltmeter.v[{k + 1}]")[late]
        assert found == pytest.approx(resistance * expected, abs=3e-3)
        power += resistance * abs(phasor) ** 2 / 2
    watts = values(result, "wattmeter.power")[late]
    assert np.mean(watts[-201:-1]) == pytest.approx(power, rel=1e-3)


def test_delta_takes_three_times_the_power_of_a_star() -> None:
    result = run(
        """
  import electrical.polyphase.*;
  CosineVoltage source(V = fill(325, 3), f = fill(50, 3));
  Star star, neutral;
  Delta delta;
  Conductor in_star(G = fill(0.1, 3)), in_delta(G = fill(0.1, 3));
  PlugToPin_p first(k = 1);
  PlugToPin_n second(k = 2);
  electrical.VoltageSensor between;
  electrical.Ground ground;
  Real p_star = in_star.v*in_star.i, p_delta = in_delta.v*in_delta.i;
equation
  connect(source.plug_p, in_star.plug_p, in_delta.plug_p, delta.plug_p, first.plug_p);
  connect(source.plug_p, second.plug_n);
  connect(in_delta.plug_n, delta.plug_n);
  connect(in_star.plug_n, neutral.plug_p);
  connect(source.plug_n, star.plug_p);
  connect(first.pin_p, between.p);
  connect(second.pin_n, between.n);
  connect(star.pin_n, ground.p);
""",
        stop_time=0.02,
        points=101,
    )
    assert values(result, "p_star") == pytest.approx(0.1 * 1.5 * 325**2, rel=1e-9)
    assert values(result, "p_delta") == pytest.approx(3 * 0.1 * 1.5 * 325**2, rel=1e-9)
    line = np.sqrt(3) * 325 * np.cos(OMEGA * result.times + np.pi / 6)
    assert values(result, "between.v") == pytest.approx(line, abs=1e-6)
    # the star point that nothing holds stays at zero in a symmetric system
    assert values(result, "neutral.pin_n.v") == pytest.approx(0, abs=1e-9)


def test_six_phases_are_two_stars_or_two_deltas() -> None:
    result = run(
        """
  import electrical.polyphase.*;
  ConstantVoltage source(m = 6, V = {1, 2, 3, 4, 5, 6});
  Star star(m = 6);
  Resistor in_stars(m = 6, R = fill(1, 6)), in_deltas(m = 6, R = fill(1, 6));
  MultiStar stars(m = 6);
  MultiDelta deltas(m = 6);
  electrical.Ground ground;
equation
  connect(source.plug_n, star.plug_p);
  connect(star.pin_n, ground.p);
  connect(source.plug_p, in_stars.plug_p, in_deltas.plug_p, deltas.plug_p);
  connect(in_stars.plug_n, stars.plug_p);
  connect(in_deltas.plug_n, deltas.plug_n);
""",
        points=3,
    )
    found = [values(result, f"stars.starpoints[{k}].v")[-1] for k in (1, 2)]
    assert found == pytest.approx([2, 5])
    found = [values(result, f"in_deltas.i[{k}]")[-1] for k in range(1, 7)]
    assert found == pytest.approx([-1, -1, 2, -1, -1, 2])


def test_transformers_and_current_sources() -> None:
    result = run(
        """
  import electrical.polyphase.*;
  SineCurrent source(I = fill(2, 3), f = fill(50, 3));
  CosineCurrent parallel_(I = fill(1, 3), f = fill(50, 3));
  ConstantCurrent bias(I = {0, 0, 0});
  Transformer transformer(L1 = fill(0.4, 3), L2 = fill(0.1, 3), M = fill(0.15, 3));
  IdealTransformer ideal(n = 2);
  SignalVoltage held(v = fill(1, 3));
  Resistor open_(R = fill(1e9, 3)), load(R = fill(3, 3));
  Star a, b, c, d;
  electrical.Ground ground;
equation
  connect(source.plug_n, parallel_.plug_n, bias.plug_n, transformer.plug_p1);
  connect(source.plug_p, parallel_.plug_p, bias.plug_p, transformer.plug_n1, a.plug_p);
  connect(transformer.plug_p2, open_.plug_p);
  connect(transformer.plug_n2, open_.plug_n, b.plug_p);
  connect(held.plug_p, ideal.plug_p1);
  connect(held.plug_n, ideal.plug_n1, c.plug_p);
  connect(ideal.plug_p2, load.plug_p);
  connect(ideal.plug_n2, load.plug_n, d.plug_p);
  connect(a.pin_n, b.pin_n, c.pin_n, d.pin_n, ground.p);
""",
        stop_time=0.02,
        points=201,
    )
    phase = OMEGA * result.times - 2 * np.pi / 3
    induced = 0.15 * OMEGA * (2 * np.cos(phase) - np.sin(phase))
    assert values(result, "open_.v[2]")[2:] == pytest.approx(induced[2:], abs=0.05)
    assert values(result, "load.v[3]") == pytest.approx(0.5)
    assert values(result, "held.plug_p[3].i") == pytest.approx(-0.5 / 3 / 2)


def test_capacitors_and_switches() -> None:
    result = run(
        """
  import electrical.polyphase.*;
  ConstantVoltage source(V = {1, -2, 3});
  Star star, other;
  IdealDiode diode;
  IdealClosingSwitch closer(control = fill(time > 0.5, 3));
  IdealOpeningSwitch opener(control = fill(time > 0.5, 3));
  IdealThyristor thyristor(fire = fill(time > 0.25, 3));
  IdealGTOThyristor gto(fire = fill(time > 0.25 and time < 0.75, 3));
  Resistor r1(R = fill(1, 3)), r2(R = fill(1, 3)), r3(R = fill(1, 3)), r4(R = fill(1, 3));
  Resistor r5(R = fill(1, 3)), r6(R = fill(0.1, 3));
  Capacitor capacitor(C = fill(1, 3), capacitor(v(each start = 0, each fixed = true)));
  electrical.Ground ground;
equation
  connect(source.plug_n, star.plug_p);
  connect(star.pin_n, other.pin_n, ground.p);
  connect(source.plug_p, diode.plug_p, closer.plug_p, opener.plug_p, thyristor.plug_p, gto.plug_p);
  connect(source.plug_p, r6.plug_p);
  connect(diode.plug_n, r1.plug_p);
  connect(closer.plug_n, r2.plug_p);
  connect(opener.plug_n, r3.plug_p);
  connect(thyristor.plug_n, r4.plug_p);
  connect(gto.plug_n, r5.plug_p);
  connect(r6.plug_n, capacitor.plug_p);
  connect(r1.plug_n, r2.plug_n, r3.plug_n, r4.plug_n, r5.plug_n, capacitor.plug_n, other.plug_p);
""",
        points=97,
    )
    t = result.times
    away = np.min(np.abs(t[:, None] - [0.25, 0.5, 0.75]), axis=1) > 1e-6
    for k, voltage in enumerate((1, -2, 3), 1):
        expected = {
            "r1": np.full_like(t, max(voltage, 0)),
            "r2": np.where(t > 0.5, voltage, 0),
            "r3": np.where(t < 0.5, voltage, 0),
            "r4": np.where(t > 0.25, max(voltage, 0), 0),
            "r5": np.where((t > 0.25) & (t < 0.75), max(voltage, 0), 0),
            "capacitor": voltage * (1 - np.exp(-t / 0.1)),
        }
        for name, signal in expected.items():
            assert values(result, f"{name}.v[{k}]")[away] == pytest.approx(signal[away], abs=1e-4)
