"""Junctions and transistors against their laws, mirror images, and the balance of powers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from acausal import compile_text


def run(text: str, stop_time: float = 1.0, **options: Any) -> Any:
    options = {"tolerance": 1e-6, **options}
    return compile_text(f"model Test\n{text}\nend Test;\n").simulate(stop_time=stop_time, **options)


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


SWEEP = """
  electrical.RampVoltage source(V = {span}[V], offset = {offset}[V], duration = 1[s]);
  electrical.{device} device{more};
  electrical.Ground ground;
equation
  connect(source.p, device.p);
  connect(source.n, device.n, ground.p);
"""


def test_zener_diode_follows_its_law_on_both_sides() -> None:
    result = run(SWEEP.format(span=6, offset=-5.5, device="ZDiode", more=""))
    v = values(result, "device.v")
    expected = 1e-6 * np.expm1(v / 0.04) - 0.7 * np.exp(-(v + 5.1) / (0.74 * 0.04)) + v / 1e8
    assert values(result, "device.i") == pytest.approx(expected, rel=1e-6, abs=1e-15)
    assert np.min(expected) < -100


def test_zener_diode_holds_a_voltage() -> None:
    result = run(
        """
  electrical.RampVoltage source(V = 10[V], offset = 8[V], duration = 1[s]);
  electrical.Resistor feed(R = 100[Ohm]);
  electrical.ZDiode device;
  electrical.Ground ground;
equation
  connect(source.p, feed.p);
  connect(feed.n, device.n);
  connect(source.n, device.p, ground.p);
"""
    )
    held = -values(result, "device.v")
    assert np.all((held > 5.0) & (held < 5.1))
    assert np.ptp(held) < 0.06


def test_diode_with_series_resistance_breaks_through() -> None:
    result = run(SWEEP.format(span=6.5, offset=-5, device="Diode2", more="(Bv = 4[V])"))
    thermal = 1.380649e-23 * 293.15 / 1.602176634e-19
    vd, i, v = (values(result, f"device.{name}") for name in ("vd", "i", "v"))
    knee = 0.7 + thermal
    forward = 1e-13 * np.where(
        vd < knee,
        np.expm1(np.minimum(vd, knee) / thermal),
        np.exp(knee / thermal) * (1 + (vd - knee) / thermal) - 1,
    )
    backward = 1e-13 * (2 * np.exp(-2 / thermal) - 1 - np.exp(-(vd + 4) / thermal))
    current = np.where(vd < -2, backward, forward)
    assert i == pytest.approx(current + 1e-6 * v, rel=1e-5, abs=1e-14)
    assert v == pytest.approx(vd + 16 * current, abs=1e-5)
    assert i[0] < -1e-3
    assert i[-1] > 1e-2


@pytest.mark.parametrize(("device", "sign"), [("NMOS", 1), ("PMOS", -1)])
def test_field_effect_transistor_against_its_three_regions(device: str, sign: int) -> None:
    result = run(
        f"""
  electrical.ConstantVoltage supply(V = {3 * sign}[V]);
  electrical.RampVoltage gate(V = {5 * sign}[V], duration = 1[s]);
  electrical.{device} t;
  electrical.Ground ground;
equation
  connect(supply.p, t.D);
  connect(gate.p, t.G);
  connect(supply.n, gate.n, t.S, t.B, ground.p);
"""
    )
    beta, threshold, k5, shorter = {
        "NMOS": (0.041e-3, 0.8, 0.7311, 1.5e-6),
        "PMOS": (0.0105e-3, 1.0, 0.839, 2.1e-6),
    }[device]
    gain = beta * 17.5e-6 / (6e-6 - shorter)
    over = (sign * values(result, "gate.v") - threshold) * k5
    saturated = gain * over**2 / 2
    linear = gain * 3 * (over - 1.5)
    expected = np.where(over <= 0, 0, np.where(over > 3, linear, saturated)) + 3 / 1e7
    assert sign * values(result, "t.D.i") == pytest.approx(expected, rel=1e-9)
    assert sign * values(result, "t.S.i") == pytest.approx(-expected, rel=1e-9)
    assert np.max(over) > 3


def test_field_effect_transistor_is_symmetric() -> None:
    # drain and source change places: the current changes its direction
    result = run(
        """
  electrical.SineVoltage supply(V = 3[V], f = 1[Hz]);
  electrical.ConstantVoltage gate(V = 8[V]), bulk(V = -4[V]);
  electrical.NMOS t, u;
  electrical.Ground ground;
equation
  connect(supply.p, t.D, u.S);
  connect(gate.p, t.G, u.G);
  connect(bulk.p, t.B, u.B);
  connect(supply.n, gate.n, bulk.n, t.S, u.D, ground.p);
"""
    )
    assert values(result, "t.D.i") == pytest.approx(values(result, "u.S.i"), rel=1e-12)
    assert np.min(values(result, "t.D.i")) < -1e-5


STAGE = """
  electrical.ConstantVoltage supply(V = {supply}[V]);
  electrical.RampVoltage drive(V = {drive}[V], duration = 1[s]);
  electrical.Resistor load(R = 1[kOhm]), base(R = 100[kOhm]);
  electrical.{device} t(Vak = 0, vbc(fixed = true), vbe(fixed = true){more});
  electrical.Ground ground;
equation
  connect(supply.p, load.p);
  connect(load.n, t.C);
  connect(drive.p, base.p);
  connect(base.n, t.B);
  connect(supply.n, drive.n, t.E, ground.p);
"""


@pytest.mark.parametrize(("device", "sign"), [("NPN", 1), ("PNP", -1)])
def test_bipolar_transistor_amplifies_its_base_current(device: str, sign: int) -> None:
    text = STAGE.format(device=device, supply=10 * sign, drive=10 * sign, more="")
    result = run(text)
    base, collector = sign * values(result, "t.B.i"), sign * values(result, "t.C.i")
    active = (sign * values(result, "drive.v") > 1) & (sign * values(result, "t.C.v") > 1)
    assert np.count_nonzero(active) > 100
    assert collector[active] == pytest.approx(50 * base[active], rel=1e-3)
    law = 1e-16 * np.expm1(values(result, "t.vbe") / 0.02585)
    assert collector[active] == pytest.approx(law[active], rel=1e-3)


def test_pnp_transistor_is_the_mirror_image_of_an_npn_transistor() -> None:
    up = run(STAGE.format(device="NPN", supply=10, drive=10, more=""))
    down = run(STAGE.format(device="PNP", supply=-10, drive=-10, more=""))
    for path in ("t.C.v", "t.B.v", "t.C.i"):
        expected, scale = values(up, path), np.max(np.abs(values(up, path)))
        found = np.interp(up.times, down.times, values(down, path))
        assert -found == pytest.approx(expected, abs=1e-4 * scale)


def test_losses_of_a_transistor_are_what_flows_in() -> None:
    text = STAGE.format(
        device="NPN",
        supply=10,
        drive=10,
        more=", Ccs = 1e-18[F], Cje = 1e-18[F], Cjc = 1e-18[F], Tauf = 1e-18[s], Taur = 1e-18[s]",
    )
    result = run(text)
    steady = result.times > 0.01
    flows = sum(values(result, f"t.{pin}.i") * values(result, f"t.{pin}.v") for pin in "CBE")
    assert values(result, "t.LossPower")[steady] == pytest.approx(flows[steady], rel=1e-6)


@pytest.mark.parametrize("device", ["HeatingNPN", "HeatingPNP"])
def test_warm_transistor_needs_less_base_voltage(device: str) -> None:
    sign = 1 if device == "HeatingNPN" else -1
    temperatures = (290.0, 300.15, 330.0)
    found = []
    for temperature in temperatures:
        result = run(
            STAGE.format(device=device, supply=10 * sign, drive=5 * sign, more="").replace(
                "equation",
                f"  thermal.FixedTemperature ambient(T = {temperature}[K]);\n"
                "equation\n  connect(ambient.port, t.heatPort);",
            )
        )
        found.append(values(result, "t.vbe")[-1])
    # Is grows by T^3 exp(-EG q/(k T)); the collector current hardly changes
    thermal = 1.380649e-23 / 1.602176634e-19 * np.array(temperatures)
    ratio = np.array(temperatures) / 300.15
    saturation = 1e-16 * ratio**3 * np.exp((ratio - 1) * 1.11 / thermal)
    current = 50 * (5 - np.array(found)) / 1e5
    assert found == pytest.approx(thermal * np.log(current / saturation), rel=1e-3)
    assert found[0] > found[1] > found[2]


def test_thyristor_switches_on_by_its_gate_and_off_by_its_current() -> None:
    result = run(
        """
  electrical.SineVoltage source(V = 30[V], f = 1000[Hz]);
  electrical.Resistor load(R = 10[Ohm]);
  electrical.PulseCurrent gate(I = 10e-3[A], period = 1e-3[s], startTime = 0.2e-3[s], width = 5);
  electrical.Thyristor t(vControl(fixed = true));
  electrical.Ground ground;
equation
  connect(source.p, t.Anode);
  connect(t.Cathode, load.p, gate.p);
  connect(gate.n, t.Gate);
  connect(load.n, source.n, ground.p);
""",
        stop_time=1e-3,
        points=2001,
    )
    voltage, current = values(result, "source.v"), values(result, "load.i")
    before = result.times < 0.199e-3
    conducts = (result.times > 0.22e-3) & (result.times < 0.49e-3)
    after = result.times > 0.55e-3
    assert np.max(np.abs(current[before])) < 1e-3 * 3
    # in conduction it is a resistance of 1 V over 25 A
    assert current[conducts] == pytest.approx(voltage[conducts] / 10.04, rel=5e-3)
    assert np.max(np.abs(current[after])) < 2e-2
