"""Each source as voltage and as current, against its formula."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.library.electrical.circuits import run, values

T = Any
OMEGA = 2 * np.pi * 3


def exponentials(t: T) -> T:
    s = t - 0.1
    rise, top = 3 * (1 - np.exp(-s / 0.05)), 3 * (1 - np.exp(-0.3 / 0.05))
    return np.where(s < 0, 0, np.where(s < 0.3, rise, top * np.exp(-(s - 0.3) / 0.08)))


SHAPES: dict[str, tuple[str, Callable[[T], T]]] = {
    "Step": ("$ = 3", lambda t: np.where(t < 0.1, 0, 3)),
    "Ramp": ("$ = 3, duration = 0.4", lambda t: 3 * np.clip((t - 0.1) / 0.4, 0, 1)),
    "Sine": (
        "$ = 3, f = 3, phase = 0.5",
        lambda t: np.where(t < 0.1, 0, 3 * np.sin(OMEGA * (t - 0.1) + 0.5)),
    ),
    "Cosine": (
        "$ = 3, f = 3, phase = 0.5",
        lambda t: np.where(t < 0.1, 0, 3 * np.cos(OMEGA * (t - 0.1) + 0.5)),
    ),
    "ExpSine": (
        "$ = 3, f = 3, damping = 2",
        lambda t: np.where(t < 0.1, 0, 3 * np.exp(-2 * (t - 0.1)) * np.sin(OMEGA * (t - 0.1))),
    ),
    "Exponentials": (
        "%Max = 3, riseTime = 0.3, riseTimeConst = 0.05, fallTimeConst = 0.08",
        exponentials,
    ),
    "Pulse": (
        "$ = 3, period = 0.2, width = 30",
        lambda t: np.where((t > 0.1) & ((t - 0.1) % 0.2 < 0.06), 3, 0),
    ),
    "SawTooth": (
        "$ = 3, period = 0.2",
        lambda t: np.where(t < 0.1, 0, 3 * ((t - 0.1) % 0.2) / 0.2),
    ),
    "Trapezoid": (
        "$ = 3, rising = 0.05, width = 0.04, falling = 0.02, period = 0.2",
        lambda t: np.where(
            t < 0.1, 0, np.interp((t - 0.1) % 0.2, [0, 0.05, 0.09, 0.11, 0.2], [0, 3, 3, 0, 0])
        ),
    ),
    "Table": (
        "table = [0, 1; 0.3, 4; 2, 2]",
        lambda t: np.where(t < 0.1, 0, np.interp(t - 0.1, [0, 0.3, 2], [1, 4, 2])),
    ),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_voltages_and_currents(shape: str) -> None:
    arguments, formula = SHAPES[shape]
    common = "offset = 0.25, startTime = 0.1"
    result = run(
        f"""
  electrical.{shape}Voltage voltage({arguments.replace("$", "V").replace("%", "v")}, {common});
  electrical.{shape}Current current({arguments.replace("$", "I").replace("%", "i")}, {common});
  electrical.Resistor r(R = 2), s(R = 2);
  electrical.Ground ground;
equation
  connect(voltage.p, r.p);
  connect(current.n, s.p);
  connect(voltage.n, current.p, r.n, s.n, ground.p);
""",
        points=198,
    )
    times = result.times
    events = np.array([e.time for e in result.events])
    apart = np.array([np.min(np.abs(events - t), initial=1) > 1e-9 for t in times])
    expected = 0.25 + formula(times)
    assert values(result, "r.i")[apart] == pytest.approx(expected[apart] / 2, abs=1e-6)
    assert values(result, "s.i")[apart] == pytest.approx(expected[apart], abs=1e-6)
    assert np.ptp(expected) > 1


def test_signals_as_voltage_and_current() -> None:
    result = run(
        """
  electrical.SignalVoltage voltage(v = 1[V]*sin(5*time));
  electrical.SignalCurrent current(i = 1[A]*cos(5*time));
  electrical.Resistor r(R = 2), s(R = 2);
  electrical.Ground ground;
equation
  connect(voltage.p, r.p);
  connect(current.n, s.p);
  connect(voltage.n, current.p, r.n, s.n, ground.p);
""",
        points=51,
    )
    assert values(result, "r.i") == pytest.approx(np.sin(5 * result.times) / 2, abs=1e-9)
    assert values(result, "s.v") == pytest.approx(np.cos(5 * result.times) * 2, abs=1e-9)


def test_variable_frequency_and_amplitude() -> None:
    result = run(
        """
  Real size = 1 + time, f = 2 + 3*time;
  electrical.SineVoltageVariableFrequencyAndAmplitude sv(phi(fixed = true), V = size, f = f);
  electrical.CosineVoltageVariableFrequencyAndAmplitude cv(phi(fixed = true), V = size, f = f);
  electrical.SineCurrentVariableFrequencyAndAmplitude si_(phi(fixed = true), I = size, f = f);
  electrical.CosineCurrentVariableFrequencyAndAmplitude ci(phi(fixed = true), I = size,
    useConstantFrequency = true, constantFrequency = 3);
  electrical.Resistor a, b, c, d;
  electrical.Ground ground;
equation
  connect(sv.p, a.p);
  connect(cv.p, b.p);
  connect(si_.n, c.p);
  connect(ci.n, d.p);
  connect(sv.n, cv.n, si_.p, ci.p, a.n, b.n, c.n, d.n, ground.p);
""",
        points=101,
    )
    t = result.times
    phase = 2 * np.pi * (2 * t + 1.5 * t**2)
    assert values(result, "a.v") == pytest.approx((1 + t) * np.sin(phase), abs=1e-5)
    assert values(result, "b.v") == pytest.approx((1 + t) * np.cos(phase), abs=1e-5)
    assert values(result, "c.v") == pytest.approx((1 + t) * np.sin(phase), abs=1e-5)
    assert values(result, "d.v") == pytest.approx((1 + t) * np.cos(6 * np.pi * t), abs=1e-5)


def test_power_supply_has_three_regions() -> None:
    result = run(
        """
  electrical.DCPowerSupply supply(V0 = 24, P0 = 200, I0 = 10);
  electrical.DCPowerSupply soft(V0 = 24, P0 = 1e4, I0 = 10, Rcv = 0.2, Gcc = 0.05);
  electrical.VariableResistor r(R = 6 - 5.99*time), s(R = 6 - 5.99*time);
  electrical.Ground ground;
equation
  connect(supply.p, r.p);
  connect(soft.p, s.p);
  connect(supply.n, soft.n, r.n, s.n, ground.p);
""",
        points=101,
    )
    load = 6 - 5.99 * result.times
    expected = np.minimum(24, np.minimum(np.sqrt(200 * load), 10 * load))
    assert values(result, "supply.v") == pytest.approx(expected, abs=1e-6)
    expected = np.minimum(24 * load / (load + 0.2), 10 * load / (1 + 0.05 * load))
    assert values(result, "soft.v") == pytest.approx(expected, abs=1e-6)
    assert set(values(result, "supply.region")) == {1, 2, 3}


def test_lightning_impulse() -> None:
    result = run(
        """
  electrical.LightningImpulseVoltage fast(V = 100e3, startTime = 1e-6);
  electrical.LightningImpulseCurrent smooth_(I = 30e3, startTime = 1e-6,
    approximation = electrical.ImpulseApproximation.Heidler);
  electrical.Ground ground;
equation
  connect(fast.n, smooth_.p, smooth_.n, ground.p);
""",
        stop_time=101e-6,
        points=20001,
    )
    t, v = result.times - 1e-6, values(result, "fast.v") / 100e3
    peak = int(np.argmax(v))
    assert v[peak] == pytest.approx(1, abs=1e-4)
    rising = slice(0, peak)
    front = 1.67 * (np.interp(0.9, v[rising], t[rising]) - np.interp(0.3, v[rising], t[rising]))
    assert front == pytest.approx(1.2e-6, rel=0.02)
    half = np.interp(-0.5, -v[peak:], t[peak:])
    assert half == pytest.approx(50e-6, rel=0.01)
    i = values(result, "smooth_.i") / 30e3
    assert np.max(i) == pytest.approx(1, rel=0.02)
    # without a kink at the start
    assert np.max(i[t < 0.1e-6]) < 1e-4
