"""Memristor, adaptors, coupled lines, and a detailed amplifier."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.electrical.circuits import run, values


def test_memristor_knows_the_charge_only() -> None:
    result = run(
        """
  electrical.SineVoltage source(V = 1.2, f = 1);
  electrical.Memristor memristor(x(start = 0.1, fixed = true));
  electrical.Ground ground;
  Real charge(start = 0, fixed = true);
equation
  der(charge) = memristor.i;
  connect(source.p, memristor.p);
  connect(source.n, memristor.n, ground.p);
""",
        stop_time=2,
        points=401,
    )
    # logistic growth over the charge
    growth = 4 * 1e-14 * 100 / 1e-16 * values(result, "charge")
    expected = 1 / (1 + 9 * np.exp(-growth))
    assert values(result, "memristor.x") == pytest.approx(expected, abs=1e-6)
    voltage = values(result, "memristor.v")
    current = values(result, "memristor.i")
    assert voltage == pytest.approx(current * (16000 - 15900 * expected), abs=1e-5)
    assert np.ptp(values(result, "memristor.M")) > 2000


def test_a_circuit_cut_in_two_by_signals() -> None:
    result = run(
        """
  electrical.SineVoltage source(V = 5, f = 1);
  electrical.Resistor r(R = 2), leak(R = 7);
  electrical.Capacitor c(C = 0.1, v(start = 0, fixed = true));
  electrical.GeneralCurrentToVoltageAdaptor left;
  electrical.GeneralVoltageToCurrentAdaptor right;
  electrical.Ground ground;
equation
  connect(source.p, r.p);
  connect(r.n, c.p, left.pin_p);
  connect(right.pin_p, leak.p);
  connect(source.n, c.n, left.pin_n, right.pin_n, leak.n, ground.p);
  connect(left.p, right.p);
  connect(right.f, left.f);
  assert(abs(left.pder*c.C - c.i) < 1e-9, "derivative");
""",
        points=101,
    )
    conductance = 1 / 2 + 1 / 7
    omega = 2 * np.pi
    wave = 2.5 / (conductance + 0.1j * omega)
    t = result.times
    steady = np.imag(wave * np.exp(1j * omega * t))
    expected = steady - np.imag(wave) * np.exp(-conductance / 0.1 * t)
    assert values(result, "c.v") == pytest.approx(expected, abs=1e-6)
    assert values(result, "right.f") == pytest.approx(-expected / 7, abs=1e-6)


@pytest.mark.parametrize(("sign", "l", "c", "g"), [(1, 1.4, 0.2, 0.1), (-1, 0.6, 0.6, 0.3)])
def test_coupled_lines_have_two_modes(sign: int, l: float, c: float, g: float) -> None:  # noqa: E741
    # Both conductors driven alike see the sum of the inductances, driven against each other the
    # difference, and the coupling twice.
    result = run(
        f"""
  electrical.PulseVoltage one(V = 1, period = 0.8), other(V = {sign}, period = 0.8);
  electrical.PulseVoltage alone(V = 1, period = 0.8);
  electrical.M_OLine pair(length = 1, N = 4, lines = 2, r = {{0.3, 0.3}}, l = {{1, 0.4, 1}},
    g = {{0.1, 0.1, 0.1}}, c = {{0.2, 0.2, 0.2}}, i(each fixed = true), v(each fixed = true));
  electrical.OLine single(length = 1, N = 4, r = 0.3, l = {l}, g = {g}, c = {c},
    L(i(each fixed = true)), C(v(each fixed = true)));
  electrical.Resistor feed(R = 0.5), feed1(R = 0.5), feed2(R = 0.5);
  electrical.Resistor load(R = 2), load1(R = 2), load2(R = 2);
  electrical.Ground ground;
equation
  connect(alone.p, feed.p);
  connect(feed.n, single.p1);
  connect(single.p2, load.p);
  connect(one.p, feed1.p);
  connect(feed1.n, pair.p[1]);
  connect(pair.n[1], load1.p);
  connect(other.p, feed2.p);
  connect(feed2.n, pair.p[2]);
  connect(pair.n[2], load2.p);
  connect(alone.n, one.n, other.n, load.n, load1.n, load2.n, single.p3, pair.p3, ground.p);
""",
        stop_time=3,
        points=301,
    )
    expected = values(result, "load.v")
    assert np.ptp(expected) > 0.5
    assert values(result, "load1.v") == pytest.approx(expected, abs=1e-5)
    assert values(result, "load2.v") == pytest.approx(sign * expected, abs=1e-5)
    assert values(result, "pair.p3.i") == pytest.approx((1 + sign) * values(result, "single.p3.i"),
                                                        abs=1e-5)  # fmt: skip


AMPLIFIER = """
  electrical.OpAmpDetailed amplifier;
  electrical.SupplyVoltage supply(Vps = 15, Vns = -15);
  electrical.StepVoltage source(V = {V}, startTime = 1e-6);
  electrical.Resistor load(R = {R});
  electrical.Ground ground;
equation
  connect(supply.pin_p, amplifier.p_supply);
  connect(supply.pin_n, amplifier.m_supply);
  connect(source.p, amplifier.p);
  connect(amplifier.outp, load.p);
  connect(supply.ground, source.n, load.n, ground.p);
"""
FOLLOWER = AMPLIFIER + "  connect(amplifier.outp, amplifier.m);\n"


def test_detailed_amplifier_as_a_follower_is_limited_by_its_slew_rate() -> None:
    result = run(FOLLOWER.format(V=5, R=2000), stop_time=60e-6, points=6001, tolerance=1e-7)
    output, t = values(result, "load.v"), result.times
    # at first the input capacitance draws the output along
    first, last = np.argmax((t > 2e-6) & (output > 1)), np.argmax((t > 2e-6) & (output > 4))
    slope = (output[last] - output[first]) / (t[last] - t[first])
    assert slope == pytest.approx(0.5e6 * 2000 / 2075, rel=1e-3)
    assert output[-1] == pytest.approx(5 - 1e-3, abs=2e-3)


def test_detailed_amplifier_has_an_offset_and_limits() -> None:
    result = run(FOLLOWER.format(V=0, R=2000), stop_time=20e-6, tolerance=1e-9)
    # the offset, up to the finite gain
    assert values(result, "load.v")[-1] == pytest.approx(-1e-3, rel=1e-2)
    assert values(result, "amplifier.p.i")[-1] == pytest.approx(90e-9, rel=0.02)
    shorted = run(FOLLOWER.format(V=5, R=10), stop_time=100e-6, tolerance=1e-7)
    assert values(shorted, "load.i")[-1] == pytest.approx(25e-3, rel=1e-3)
    open_loop = AMPLIFIER + "  connect(amplifier.m, ground.p);\n"
    result = run(open_loop.format(V=0.1, R=2000), stop_time=200e-6, tolerance=1e-7)
    assert values(result, "amplifier.v_source")[-1] == pytest.approx(15, rel=1e-3)
    assert np.max(values(result, "amplifier.v_source")) < 15.001


def test_line_given_by_frequency_or_delay() -> None:
    result = run(
        """
  electrical.StepVoltage step(startTime = 0.05);
  electrical.Resistor feed(R = 50), feed1(R = 50), load(R = 50), load1(R = 50);
  electrical.TLine line(Z0 = 50, TD = 0.2), line1(Z0 = 50, F = 5, NL = 1);
  electrical.Ground ground;
equation
  connect(step.p, feed.p, feed1.p);
  connect(feed.n, line.p1);
  connect(feed1.n, line1.p1);
  connect(line.p2, load.p);
  connect(line1.p2, load1.p);
  connect(step.n, line.n1, line.n2, line1.n1, line1.n2, load.n, load1.n, ground.p);
""",
        points=998,
    )
    expected = np.where(result.times < 0.25, 0, 0.5)
    away = np.abs(result.times - 0.25) > 1e-9
    for name in ("load", "load1"):
        assert values(result, f"{name}.v")[away] == pytest.approx(expected[away], abs=1e-9)


def test_ideal_parts_that_are_wires_or_nothing() -> None:
    result = run(
        """
  electrical.ConstantVoltage source(V = 6);
  electrical.Short wire(i(start = 0));
  electrical.Idle gap(v(start = 0));
  electrical.IdealOpAmp amplifier(v1(start = 0));
  electrical.Resistor r(R = 2), s(R = 6), load(R = 3);
  electrical.Ground ground;
equation
  connect(source.p, wire.p, gap.p);
  connect(wire.n, r.p);
  connect(r.n, s.p, amplifier.n1);
  connect(s.n, amplifier.p2, load.p);
  connect(source.n, amplifier.p1, amplifier.n2, load.n, ground.p, gap.n);
""",
        points=3,
    )
    assert values(result, "load.v") == pytest.approx(-18)
    assert values(result, "wire.i") == pytest.approx(3)
    assert values(result, "gap.v") == pytest.approx(6)


def test_switches_under_their_former_names() -> None:
    result = run(
        """
  electrical.ConstantVoltage source(V = 6);
  electrical.RampVoltage control(V = 1, duration = 1);
  electrical.IdealCommutingSwitch by_signal(control = time > 0.4);
  electrical.ControlledIdealCommutingSwitch by_pin(level = 0.6);
  electrical.Resistor a(R = 2), b(R = 3), c(R = 2), d(R = 3);
  electrical.Ground ground;
equation
  connect(source.p, by_signal.p, by_pin.p);
  connect(by_signal.n1, a.p);
  connect(by_signal.n2, b.p);
  connect(by_pin.n1, c.p);
  connect(by_pin.n2, d.p);
  connect(control.p, by_pin.control);
  connect(source.n, control.n, a.n, b.n, c.n, d.n, ground.p);
""",
        points=98,
    )
    for switched, first, second in ((0.4, "a", "b"), (0.6, "c", "d")):
        before = result.times < switched - 1e-6
        after = result.times > switched + 1e-6
        assert values(result, f"{first}.i")[before] == pytest.approx(3, rel=1e-4)
        assert values(result, f"{second}.i")[before] == pytest.approx(0, abs=1e-4)
        assert values(result, f"{second}.i")[after] == pytest.approx(2, rel=1e-4)
        assert values(result, f"{first}.i")[after] == pytest.approx(0, abs=1e-4)
