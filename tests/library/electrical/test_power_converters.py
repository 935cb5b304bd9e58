"""Rectifiers, choppers and inverters against the mean values that textbooks give."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.library.electrical.circuits import run, values

PERIOD = 0.02


def mean(result: Any, path: str, start: float) -> float:
    """Return the mean from a time on."""
    late = result.times >= start
    t, y = result.times[late], values(result, path)[late]
    return float(np.sum(np.diff(t) * (y[1:] + y[:-1]) / 2) / (t[-1] - t[0]))


SINGLE = """
  import electrical.power_converters.*;
  electrical.SineVoltage upper(V = 100, f = 50), lower(V = 100, f = 50);
  electrical.Resistor load(R = 10);
  electrical.Ground ground;
  {bridge};
equation
  connect(upper.n, lower.p);
"""
BRIDGE = """  connect(upper.p, bridge.ac_p);
  connect(lower.n, bridge.ac_n);
  connect(bridge.dc_p, load.p);
  connect(bridge.dc_n, load.n, ground.p);
"""
TAP = """  connect(upper.p, bridge.ac_p);
  connect(lower.n, bridge.ac_n);
  connect(bridge.dc_p, load.p);
  connect(upper.n, load.n, ground.p);
"""
ANGLE = 0.25
FIRED = f"(fire_p = mod(time, 0.02) > {ANGLE}*0.01 and mod(time, 0.02) < 0.0099, "
FIRED += f"fire_n = mod(time, 0.02) > 0.01 + {ANGLE}*0.01)"


@pytest.mark.parametrize(
    ("bridge", "wiring", "peak", "angle"),
    [
        ("DiodeBridge2Pulse bridge(RonDiode = 1e-6)", BRIDGE, 200, 0),
        (f"ThyristorBridge2Pulse bridge{FIRED}", BRIDGE, 200, np.pi * ANGLE),
        (f"HalfControlledBridge2Pulse bridge{FIRED}", BRIDGE, 200, np.pi * ANGLE),
        ("DiodeCenterTap2Pulse bridge(RonDiode = 1e-6)", TAP, 100, 0),
        (f"ThyristorCenterTap2Pulse bridge{FIRED}", TAP, 100, np.pi * ANGLE),
    ],
)
def test_two_pulses(bridge: str, wiring: str, peak: float, angle: float) -> None:
    result = run(SINGLE.format(bridge=bridge) + wiring, 0.04, points=4001, tolerance=1e-7)
    # resistive load: what is left of each half wave
    expected = peak / np.pi * (1 + np.cos(angle))
    assert mean(result, "load.v", 0.02) == pytest.approx(expected, rel=2e-3)
    assert np.max(values(result, "load.v")) == pytest.approx(peak, rel=1e-3)
    assert mean(result, "bridge.iDC", 0.02) == pytest.approx(expected / 10, rel=2e-3)


POLY = """
  import electrical.power_converters.*;
  electrical.polyphase.SineVoltage mains(V = fill(100, 3), f = fill(50, 3));
  electrical.polyphase.Star star;
  electrical.Resistor load(R = 10);
  electrical.Inductor coil(L = 0.2, i(start = {start}, fixed = true));
  electrical.Ground ground;
  {bridge};
equation
  connect(mains.plug_n, star.plug_p);
  connect(mains.plug_p, bridge.ac);
  connect(bridge.dc_p, coil.p);
  connect(coil.n, load.p);
"""
NEGATIVE = "  connect(load.n, bridge.dc_n);\n  connect(star.pin_n, ground.p);\n"
STAR = "  connect(load.n, star.pin_n, ground.p);\n"
CONTROL = """;
  Signal2mPulse control(constantFiringAngle = 0.5, v = mains.v)"""
FIRE_P = "  connect(control.fire_p, bridge.fire_p);\n"
FIRE_N = "  connect(control.fire_n, bridge.fire_n);\n"
SIX, THREE = 300 * np.sqrt(3) / np.pi, 150 * np.sqrt(3) / np.pi


@pytest.mark.parametrize(
    ("bridge", "wiring", "expected"),
    [
        ("DiodeBridge2mPulse bridge(m = 3)", NEGATIVE, SIX),
        ("ThyristorBridge2mPulse bridge" + CONTROL, NEGATIVE + FIRE_P + FIRE_N, SIX * np.cos(0.5)),
        (
            "HalfControlledBridge2mPulse bridge" + CONTROL,
            NEGATIVE + FIRE_P,
            SIX * (1 + np.cos(0.5)) / 2,
        ),
        ("DiodeCenterTapmPulse bridge(m = 3)", STAR, THREE),
        ("ThyristorCenterTapmPulse bridge" + CONTROL, STAR + FIRE_P, THREE * np.cos(0.5)),
    ],
)
def test_three_phases(bridge: str, wiring: str, expected: float) -> None:
    text = POLY.format(bridge=bridge, start=expected / 10) + wiring
    result = run(text, 0.12, points=6001, tolerance=1e-6)
    assert mean(result, "load.v", 0.1) == pytest.approx(expected, rel=0.01)
    assert mean(result, "coil.v", 0.1) == pytest.approx(0, abs=expected * 0.02)


CHOPPER = """
  import electrical.power_converters.*;
  electrical.ConstantVoltage supply(V = 12);
  SignalPWM clock(f = 20000, constantDutyCycle = 0.4);
  electrical.Capacitor smoothing(C = 1e-4, v(start = {start}, fixed = true));
  electrical.Resistor load(R = 5);
  electrical.Ground ground;
  {chopper};
equation
  connect(clock.fire, chopper.fire_p);
"""


@pytest.mark.parametrize(
    ("chopper", "wiring", "expected"),
    [
        (
            "ChopperStepDown chopper; electrical.Inductor coil(L = 2e-4, i(fixed = true))",
            "connect(supply.p, chopper.dc_p1); connect(chopper.dc_p2, coil.p); "
            "connect(coil.n, smoothing.p, load.p); "
            "connect(supply.n, chopper.dc_n1, smoothing.n, load.n, ground.p);",
            12 * 0.4,
        ),
        (
            "ChopperStepUp chopper; electrical.Inductor coil(L = 2e-4, i(fixed = true))",
            "connect(supply.p, coil.p); connect(coil.n, chopper.dc_p1); "
            "connect(chopper.dc_p2, smoothing.p, load.p); "
            "connect(supply.n, chopper.dc_n1, smoothing.n, load.n, ground.p);",
            12 / 0.6,
        ),
        (
            "ChopperBuckBoost chopper(L = 2e-4, inductor(i(fixed = true)))",
            "connect(supply.p, chopper.dc_p1); connect(chopper.dc_p2, smoothing.p, load.p); "
            "connect(supply.n, chopper.dc_n1, smoothing.n, load.n, ground.p);",
            -12 * 0.4 / 0.6,
        ),
    ],
)
def test_choppers(chopper: str, wiring: str, expected: float) -> None:
    text = CHOPPER.format(chopper=chopper, start=expected)
    result = run(f"{text}  {wiring}", 10e-3, points=2001, tolerance=1e-6)
    assert mean(result, "load.v", 9e-3) == pytest.approx(expected, rel=0.01)
    # no power is lost
    assert mean(result, "supply.i", 9e-3) * -12 == pytest.approx(expected**2 / 5, rel=0.05)


def test_h_bridge_drives_both_directions() -> None:
    result = run(
        """
  import electrical.power_converters.*;
  electrical.ConstantVoltage supply(V = 24);
  SignalPWM clock(useConstantDutyCycle = false, f = 5000,
    dutyCycle = if time < 0.02 then 0.75 else 0.25);
  HBridge bridge;
  electrical.Inductor coil(L = 5e-3, i(fixed = true));
  electrical.Resistor load(R = 5);
  electrical.Ground ground;
equation
  connect(supply.p, bridge.dc_p1);
  connect(supply.n, bridge.dc_n1, ground.p);
  connect(bridge.dc_p2, coil.p);
  connect(coil.n, load.p);
  connect(load.n, bridge.dc_n2);
  connect(clock.fire, bridge.fire_p);
  connect(clock.notFire, bridge.fire_n);
""",
        0.04,
        points=2001,
        tolerance=1e-6,
    )
    late = (result.times > 0.018) & (result.times < 0.02)
    first = np.mean(values(result, "load.i")[late])
    assert first == pytest.approx(12 / 5, rel=0.01)
    assert mean(result, "load.i", 0.038) == pytest.approx(-12 / 5, rel=0.01)


def test_inverter_makes_three_phases_of_six_steps() -> None:
    result = run(
        """
  import electrical.power_converters.*;
  electrical.ConstantVoltage supply(V = 300);
  Polyphase2Level inverter(m = 3, fire_p = {mod(50*time + k/3, 1) < 0.5 for k in {0, 2, 1}},
    fire_n = {mod(50*time + k/3, 1) >= 0.5 for k in {0, 2, 1}});
  electrical.polyphase.Resistor load(R = fill(10, 3));
  electrical.polyphase.Star star;
  electrical.Ground ground;
equation
  connect(supply.p, inverter.dc_p);
  connect(supply.n, inverter.dc_n, ground.p);
  connect(inverter.ac, load.plug_p);
  connect(load.plug_n, star.plug_p);
""",
        0.04,
        points=1999,
        tolerance=1e-6,
    )
    steps = np.array([100, 200, 100, -100, -200, -100])
    place = np.mod(50 * result.times, 1) * 6
    inside = np.abs(place - np.round(place)) > 1e-3
    expected = steps[np.floor(place[inside]).astype(int) % 6]
    assert values(result, "load.v[1]")[inside] == pytest.approx(expected, rel=1e-4)


def test_triacs_set_the_power_of_a_lamp() -> None:
    result = run(
        f"""
  import electrical.power_converters.*;
  electrical.polyphase.SineVoltage mains(V = fill(100, 3), f = fill(50, 3));
  PolyphaseTriac triac(m = 3,
    fire1 = {{mod(50*time - k/3, 1) > {ANGLE}/2 and mod(50*time - k/3, 1) < 0.49 for k in 0:2}},
    fire2 = {{mod(50*time - k/3, 1) > 0.5 + {ANGLE}/2 for k in 0:2}});
  electrical.polyphase.Resistor lamp(R = fill(10, 3));
  electrical.polyphase.Star star, other;
  electrical.Ground ground;
  Real power = lamp.v*lamp.i;
equation
  connect(mains.plug_p, triac.ac1);
  connect(triac.ac2, lamp.plug_p);
  connect(mains.plug_n, star.plug_p);
  connect(lamp.plug_n, other.plug_p);
  connect(star.pin_n, other.pin_n, ground.p);
""",
        0.06,
        points=6001,
        tolerance=1e-7,
    )
    angle = np.pi * ANGLE
    share = 1 - angle / np.pi + np.sin(2 * angle) / (2 * np.pi)
    assert mean(result, "power", 0.04) == pytest.approx(3 * 100**2 / 20 * share, rel=2e-3)
