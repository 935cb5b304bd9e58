"""SPICE elements: wave forms, laws of diodes and transistors, charges, the operating point."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from acausal import compile_text

VT = 1.380649e-23 * 300.15 / 1.602176634e-19


def run(text: str, stop_time: float = 1.0, **options: Any) -> Any:
    options = {"tolerance": 1e-8, "points": 201, **options}
    text = f"import electrical.spice.*;\nmodel Test\n{text}\nend Test;\n"
    return compile_text(text).simulate(stop_time=stop_time, **options)


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def pulse(t: Any) -> Any:
    return np.interp((t - 0.1) % 0.5, [0, 0.05, 0.15, 0.25, 0.5], [-1, 3, 3, -1, -1])


WAVES = {
    "constant": ("{0} = 3", lambda t: 3 + 0 * t),
    "sin": (
        "{0}O = 1, {0}A = 2, FREQ = 3, TD = 0.2, THETA = 1.5",
        lambda t: np.where(
            t < 0.2, 1, 1 + 2 * np.exp(-1.5 * (t - 0.2)) * np.sin(6 * np.pi * (t - 0.2))
        ),
    ),
    "pulse": (
        "{0}1 = -1, {0}2 = 3, TD = 0.1, TR = 0.05, TF = 0.1, PW = 0.1, PER = 0.5",
        lambda t: np.where(t < 0.1, -1, pulse(t)),
    ),
    "exp": (
        "{0}1 = 1, {0}2 = 5, TD1 = 0.1, TAU1 = 0.2, TD2 = 0.5, TAU2 = 0.1",
        lambda t: (
            1
            + 4 * (1 - np.exp(-np.maximum(t - 0.1, 0) / 0.2))
            - 4 * (1 - np.exp(-np.maximum(t - 0.5, 0) / 0.1))
        ),
    ),
    "pwl": (
        "table = [0, 1; 0.3, 4; 0.6, -2]",
        lambda t: np.interp(t, [0, 0.3, 0.6], [1, 4, -2]),
    ),
    "sffm": (
        "{0}O = 1, {0}A = 2, FC = 8, MDI = 3, FS = 2",
        lambda t: 1 + 2 * np.sin(16 * np.pi * t + 3 * np.sin(4 * np.pi * t)),
    ),
}


@pytest.mark.parametrize("wave", WAVES)
def test_wave_forms(wave: str) -> None:
    modifiers, expected = WAVES[wave]
    result = run(
        f"""  V_{wave} v({modifiers.format("V")});
  I_{wave} i({modifiers.format("I")});
  R_Resistor load(R = 2), other(R = 3);
  Ground ground;
equation
  connect(v.p, load.p);
  connect(i.n, other.p);
  connect(v.n, load.n, i.p, other.n, ground.p);
"""
    )
    t = result.times
    assert values(result, "load.i") == pytest.approx(expected(t) / 2, abs=1e-7)
    assert values(result, "other.v") == pytest.approx(expected(t) * 3, abs=1e-7)


def test_pulse_without_rise_is_a_jump() -> None:
    result = run(
        """  V_pulse v(V1 = 1, V2 = 2, TD = 0.3);
  R_Resistor r;
  Ground ground;
equation
  connect(v.p, r.p);
  connect(v.n, r.n, ground.p);
"""
    )
    t, v = result.times, values(result, "v.v")
    jump = np.flatnonzero(np.diff(v))
    assert t[jump] == pytest.approx([0.3])
    assert v[jump + 1] == pytest.approx([2])


def test_controlled_sources() -> None:
    result = run(
        """  V_constant v(V = 2);
  I_constant i(I = 3);
  E_VCV e(gain = 5);
  G_VCC g(transConductance = 0.1);
  H_CCV h(transResistance = 4);
  F_CCC f(gain = 6);
  R_Resistor a(R = 1), b(R = 2), c(R = 3), d(R = 4);
  Ground ground;
equation
  connect(v.p, e.p1, g.p1);
  connect(i.n, h.p1);
  connect(h.n1, f.p1);
  connect(e.p2, a.p);
  connect(g.p2, b.p);
  connect(h.p2, c.p);
  connect(f.p2, d.p);
  connect(ground.p, v.n, i.p, e.n1, g.n1, f.n1, e.n2, g.n2, h.n2, f.n2, a.n, b.n, c.n, d.n);
"""
    )
    assert values(result, "a.v") == pytest.approx(10)
    assert values(result, "b.i") == pytest.approx(-0.2)
    assert values(result, "c.v") == pytest.approx(12)
    assert values(result, "d.i") == pytest.approx(-18)


@pytest.mark.parametrize("uic", ["true", "false"])
def test_operating_point_or_given_start(uic: str) -> None:
    result = run(
        f"""  V_constant v(V = 6);
  R_Resistor r(R = 2), q(R = 4);
  C_Capacitor c(C = 0.1, IC = 1, UIC = {uic});
  L_Inductor l(L = 0.5, IC = 3, UIC = {uic});
  Ground ground;
equation
  connect(v.p, r.p, l.p);
  connect(r.n, c.p);
  connect(l.n, q.p);
  connect(v.n, c.n, q.n, ground.p);
"""
    )
    decay = np.exp(-result.times / 0.2) if uic == "true" else 0
    fade = np.exp(-result.times * 8) if uic == "true" else 0
    assert values(result, "c.vinternal") == pytest.approx(6 - 5 * decay, abs=1e-6)
    assert values(result, "l.iinternal") == pytest.approx(1.5 + 1.5 * fade, abs=1e-6)


@pytest.mark.parametrize("k", [0.6, -0.6])
def test_coupled_coils_keep_their_energy(k: float) -> None:
    result = run(
        f"""  L_Inductor a(L = 2, IC = 1, UIC = true), b(L = 0.5, IC = 2, UIC = true);
  K_CoupledInductors k(k = {k});
  C_Capacitor c(C = 0.1, IC = 0, UIC = true), d(C = 0.2, IC = 5, UIC = true);
  Ground ground;
equation
  connect(a.ICP, k.inductiveCouplePin1);
  connect(b.ICP, k.inductiveCouplePin2);
  connect(a.p, c.p);
  connect(b.p, d.p);
  connect(a.n, c.n, b.n, d.n, ground.p);
""",
        tolerance=1e-10,
    )
    i, j = values(result, "a.i"), values(result, "b.i")
    assert values(result, "k.M") == pytest.approx(k)
    energy = i**2 + 0.25 * j**2 - k * i * j
    energy += 0.05 * values(result, "c.v") ** 2 + 0.1 * values(result, "d.v") ** 2
    assert energy == pytest.approx(energy[0], rel=1e-6)
    assert np.ptp(i) > 1


def diode_current(v: float, IS: float = 1e-14, N: float = 1.0) -> float:
    return IS * (np.exp(v / (N * VT)) - 1) + 1e-12 * v


def test_diode_law() -> None:
    result = run(
        """  V_pwl source(table = [0, -12; 1, 5]);
  R_Resistor r(R = 100);
  D_DIODE d(AREA = 2, modelcarddiode(IS = 3e-14, N = 1.2, RS = 4, BV = 10, IBV = 1e-3));
  Ground ground;
equation
  connect(source.p, r.p);
  connect(r.n, d.p);
  connect(source.n, d.n, ground.p);
"""
    )
    vj, i = values(result, "d.vj"), values(result, "d.i")
    law = diode_current(vj, 6e-14, 1.2) - 2e-3 * np.exp(-(10 + vj) / VT)
    assert i == pytest.approx(law, rel=1e-5, abs=1e-13)
    assert values(result, "d.v") == pytest.approx(vj + 2 * i, abs=1e-9)
    assert i[0] < -1e-2
    assert i[-1] > 1e-2


@pytest.mark.parametrize("celsius", [-20, 27, 100])
def test_diode_at_other_temperatures(celsius: float) -> None:
    result = run(
        f"""  I_constant source(I = 1e-3);
  D_DIODE d(TEMP = {celsius});
  Ground ground;
equation
  connect(source.n, d.p);
  connect(source.p, d.n, ground.p);
"""
    )
    T = celsius + 273.15
    vt = VT * T / 300.15
    IS = 1e-14 * (T / 300.15) ** 3 * np.exp((T / 300.15 - 1) * 1.11 / vt)
    assert values(result, "d.v")[-1] == pytest.approx(vt * np.log(1e-3 / IS), abs=1e-6)


def test_what_flows_into_a_diode_stays_or_passes() -> None:
    result = run(
        """  V_pulse source(V1 = -5, V2 = 5, TD = 1e-6, TR = 1e-7, TF = 1e-7, PW = 3e-6);
  R_Resistor r(R = 1000);
  D_DIODE d(modelcarddiode(TT = 2e-7, CJO = 4e-12, VJ = 0.8, M = 0.4));
  Ground ground;
  Real moved(unit = "C", start = 0, fixed = true, nominal = 1e-9);
equation
  connect(source.p, r.p);
  connect(r.n, d.p);
  connect(source.n, d.n, ground.p);
  der(moved) = d.i - d.id;
""",
        stop_time=8e-6,
        points=8001,
    )
    t = result.times
    vj, Q = values(result, "d.vj"), values(result, "d.Q")
    assert vj[0] == pytest.approx(-5, abs=1e-6)  # the operating point
    assert Q - Q[0] == pytest.approx(values(result, "moved"), abs=1e-4 * np.ptp(Q))
    low = vj < 0
    depletion = 4e-12 * 0.8 / 0.6 * (1 - (1 - vj[low] / 0.8) ** 0.6)
    assert Q[low] == pytest.approx(depletion + 2e-7 * values(result, "d.id")[low], rel=1e-6)
    # stored charge keeps it conducting after the voltage has turned
    recovery = t[(t > 4.2e-6) & (vj > 0)]
    assert 5e-8 < recovery.max() - 4.2e-6 < 5e-7


def mos(vgs: Any, vds: Any, vbs: Any) -> Any:
    """Return the square law with threshold 1 V, bulk effect and channel length modulation."""
    flipped = np.where(vds < 0, -1, 1)
    vgs, vbs = np.where(vds < 0, vgs - vds, vgs), np.where(vds < 0, vbs - vds, vbs)
    vds = np.abs(vds)
    over = np.maximum(vgs - 1 - 0.5 * (np.sqrt(0.7 - vbs) - np.sqrt(0.7)), 0)
    triode = vds * (over - vds / 2)
    return (
        flipped * 5e-5 * 10 * np.where(over < vds, over**2 / 2, triode) * (1 + 0.03 * np.abs(vds))
    )


@pytest.mark.parametrize(("kind", "sign"), [("M_NMOS", 1), ("M_PMOS", -1)])
@pytest.mark.parametrize("gate", [0.5, 2.5, 5.0])
def test_field_effect_transistors(kind: str, sign: int, gate: float) -> None:
    result = run(
        f"""  V_pwl drain(table = [0, {-sign * 2}; 1, {sign * 6}]);
  V_constant vg(V = {sign * gate}), vb(V = {-sign * 4});
  {kind} m(L = 1e-5, modelcard(VTO = {sign}, KP = 5e-5, GAMMA = 0.5, PHI = 0.7, LAMBDA = 0.03));
  Ground ground;
equation
  connect(drain.p, m.D);
  connect(vg.p, m.G);
  connect(vb.p, m.B);
  connect(drain.n, vg.n, vb.n, m.S, ground.p);
"""
    )
    vds = -2 + 8 * result.times
    expected = mos(gate + 0 * vds, vds, -4 + 0 * vds)
    assert sign * values(result, "m.D.i") == pytest.approx(expected, abs=1e-10)
    assert values(result, "m.G.i") == pytest.approx(0, abs=1e-15)
    total = sum(values(result, f"m.{pin}.i") for pin in "DGSB")
    assert total == pytest.approx(0, abs=1e-15)


def test_inverter_switches_and_charges_its_load() -> None:
    result = run(
        """  V_constant vdd(V = 5);
  V_pulse vin(V1 = 0, V2 = 5, TD = 1e-6, TR = 1e-8, TF = 1e-8, PW = 2e-6, PER = 5e-6);
  M_NMOS n(L = 1e-5, modelcard(VTO = 1, KP = 5e-5, CBD = 1e-14, CBS = 1e-14,
    CGSO = 1e-10, CGDO = 1e-10, CGBO = 1e-10));
  M_PMOS p(L = 1e-5, W = 2.5e-4, modelcard(VTO = -1, KP = 2e-5, CBD = 1e-14, CBS = 1e-14));
  C_Capacitor c(C = 1e-12);
  Ground ground;
equation
  connect(vdd.p, p.S, p.B);
  connect(p.D, n.D, c.p);
  connect(n.S, n.B, vdd.n, vin.n, ground.p, c.n);
  connect(vin.p, n.G, p.G);
""",
        stop_time=5e-6,
        points=5001,
        tolerance=1e-6,
    )
    assert result.times[-1] == 5e-6
    t, v = result.times, values(result, "c.v")
    assert v[t < 1e-6] == pytest.approx(5, abs=1e-4)
    assert v[(t > 1.1e-6) & (t < 3e-6)] == pytest.approx(0, abs=1e-4)
    assert v[t > 3.1e-6] == pytest.approx(5, abs=1e-3)
    # discharge with a constant saturation current of 4 mA down to 4 V, through 1.02 pF
    falling = np.interp(-4.0, -v[(t > 1.01e-6) & (t < 1.1e-6)], t[(t > 1.01e-6) & (t < 1.1e-6)])
    assert falling == pytest.approx(1.01e-6, abs=6e-9)


def gummel_poon(vbe: float, vbc: float, BF: float) -> tuple[float, float]:
    """Return collector and base current."""
    forward, reverse = diode_current(vbe, 2e-16), diode_current(vbc, 2e-16)
    q1 = 1 / (1 - vbc / 50 - vbe / 20)
    qb = q1 / 2 * (1 + np.sqrt(1 + 4 * (forward / 0.01 + reverse / 0.02)))
    base = forward / BF + 1e-14 * (np.exp(vbe / 1.5 / VT) - 1)
    back = reverse / 2 + 1e-13 * (np.exp(vbc / 2 / VT) - 1)
    return (forward - reverse) / qb - back, base + back


@pytest.mark.parametrize(("kind", "sign"), [("Q_NPNBJT", 1), ("Q_PNPBJT", -1)])
@pytest.mark.parametrize("collector", [3.0, 0.2, -0.05])
def test_bipolar_transistors(kind: str, sign: int, collector: float) -> None:
    result = run(
        f"""  V_pwl base(table = [0, {sign * 0.4}; 1, {sign * 0.85}]);
  V_constant vc(V = {sign * collector});
  {kind} q(modelcard(IS = 2e-16, BF = 150, BR = 2, VAF = 50, VAR = 20, IKF = 0.01, IKR = 0.02,
    ISE = 1e-14, ISC = 1e-13));
  Ground ground;
equation
  connect(base.p, q.B);
  connect(vc.p, q.C);
  connect(base.n, vc.n, q.E, ground.p);
"""
    )
    vbe = 0.4 + 0.45 * result.times
    expected = np.array([gummel_poon(v, v - collector, 150) for v in vbe]).T
    assert sign * values(result, "q.C.i") == pytest.approx(expected[0], rel=1e-6, abs=1e-12)
    assert sign * values(result, "q.B.i") == pytest.approx(expected[1], rel=1e-6, abs=1e-12)


def test_amplifier_starts_at_its_operating_point() -> None:
    result = run(
        """  V_constant supply(V = 10), bias(V = 2);
  V_sin signal(VO = 0, VA = 0.01, FREQ = 1e3);
  R_Resistor rc(R = 4700), re(R = 1000);
  Q_NPNBJT q(modelcard(RB = 50, RE = 1, RC = 10, TF = 3e-10, TR = 1e-8, CJE = 4e-12, CJC = 2e-12));
  C_Capacitor c(C = 1e-12);
  Ground ground;
equation
  connect(supply.p, rc.p);
  connect(rc.n, q.C, c.p);
  connect(q.E, re.p);
  connect(bias.p, signal.n);
  connect(signal.p, q.B);
  connect(re.n, bias.n, supply.n, c.n, ground.p);
""",
        stop_time=1e-3,
    )

    def excess(vbe: float) -> float:
        i = 1e-16 * (np.exp(vbe / VT) - 1) + 1e-12 * vbe
        return 2 - vbe - 50 * i / 100 - 1001 * i * 1.01

    i = 1e-16 * np.exp(brentq(excess, 0.5, 0.9) / VT)
    v = values(result, "c.v")
    assert v[0] == pytest.approx(10 - 4700 * i, abs=0.05)
    gain = np.ptp(v) / 0.02
    assert gain == pytest.approx(4700 / (1001 + VT / i), rel=0.02)
