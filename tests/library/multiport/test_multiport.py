"""S05: the multiport passes on what it gets, for any matrix and between any fields."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acausal import compile_text

ENTRY = st.floats(-5, 5, allow_subnormal=False)


def simulate(body: str, **options: Any) -> Any:
    text = f"import multiport.*;\nmodel M\n{body}end M;\n"
    return compile_text(text).simulate(**{"stop_time": 1, "tolerance": 1e-9, **options})


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def rows(matrix: Any) -> str:
    return "[" + "; ".join(", ".join(repr(float(x)) for x in row) for row in matrix) + "]"


@st.composite
def networks(draw: Any) -> tuple[Any, Any, Any]:
    """Draw a matrix, sources and loads."""
    n, m = draw(st.integers(1, 5)), draw(st.integers(1, 5))
    matrix = draw(st.lists(st.lists(ENTRY, min_size=n, max_size=n), min_size=m, max_size=m))
    sources = draw(st.lists(ENTRY, min_size=n, max_size=n))
    loads = draw(st.lists(st.floats(0.1, 10), min_size=m, max_size=m))
    return np.array(matrix), np.array(sources), np.array(loads)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(networks())
def test_any_matrix_conserves_the_power(network: tuple[Any, Any, Any]) -> None:
    matrix, sources, loads = network
    m, n = matrix.shape
    body = f"  AcrossSource source[{n}](ac = {{{', '.join(map(repr, sources.tolist()))}}});\n"
    body += f"  Multiport box(K = {rows(matrix)});\n"
    body += f"  Dissipator load[{m}](G = {{{', '.join(map(repr, loads.tolist()))}}});\n"
    body += "equation\n  connect(source.cut, box.incoming);\n  connect(box.outgoing, load.cut);\n"
    result = simulate(body)
    across = matrix @ sources
    power = float(loads @ across**2)
    scale = 1 + abs(power)
    assert values(result, "box.powerIn") == pytest.approx(power, abs=1e-9 * scale)
    assert values(result, "box.powerOut") == pytest.approx(power, abs=1e-9 * scale)
    for j, through in enumerate(matrix.T @ (loads * across)):
        assert values(result, f"box.incoming[{j + 1}].th") == pytest.approx(
            through, abs=1e-9 * scale
        )


def test_a_chain_of_multiports_multiplies_their_matrices() -> None:
    rng = np.random.default_rng(3)
    first, second = rng.normal(size=(4, 2)), rng.normal(size=(3, 4))
    result = simulate(
        f"""  AcrossSource source[2](ac = {{1, -2}});
  Multiport a(K = {rows(first)}), b(K = {rows(second)});
  Dissipator load[3](G = {{1, 2, 3}});
equation
  connect(source.cut, a.incoming);
  connect(a.outgoing, b.incoming);
  connect(b.outgoing, load.cut);
"""
    )
    across = second @ first @ [1, -2]
    for i in range(3):
        assert values(result, f"load[{i + 1}].cut.ac") == pytest.approx(across[i])
    assert values(result, "a.powerIn") == pytest.approx(values(result, "b.powerOut"))


def test_two_sources_of_flow_share_a_store() -> None:
    result = simulate(
        """  ThroughSource push[2](th = {3, -1});
  Dissipator leak[2](each G = 1);
  Multiport box(K = [2; -1]);
  Storage store(C = 4, ac(start = 0, fixed = true));
equation
  connect(push.cut, leak.cut, box.outgoing);
  connect(box.incoming[1], store.cut);
"""
    )
    # ac' = (2, -1) u; each outgoing cut gets th - ac'; 4 u' = 2 (3 - 2 u) - (-1 + u).
    u = 7 / 5 * (1 - np.exp(-5 / 4 * result.times))
    assert values(result, "store.ac") == pytest.approx(u, abs=1e-7)


def test_between_circuit_shaft_and_rod() -> None:
    # A gyrating machine: one voltage drives a shaft and a rod through one matrix.
    result = simulate(
        """  electrical.ConstantVoltage supply(V = 12);
  electrical.Resistor wire(R = 2);
  electrical.Ground ground;
  FromPins pins;
  Multiport machine(K = [5; -0.4]);
  FromShaft shaft;
  FromFlange rod;
  mechanical.rotational.Inertia rotor(J = 0.02, phi(fixed = true), w(start = 0, fixed = true));
  mechanical.translational.Mass sledge(m = 3, s(fixed = true));
equation
  connect(supply.p, wire.p);
  connect(wire.n, pins.p);
  connect(pins.n, supply.n, ground.p);
  connect(pins.cut, machine.incoming[1]);
  connect(machine.outgoing[1], shaft.cut);
  connect(machine.outgoing[2], rod.cut);
  connect(shaft.flange, rotor.flange_a);
  connect(rod.flange, sledge.flange_a);
"""
    )
    capacity = 0.02 * 5**2 + 3 * 0.4**2
    voltage = 12 * (1 - np.exp(-result.times / (2 * capacity)))
    assert values(result, "rotor.w") == pytest.approx(5 * voltage, abs=1e-6)
    assert values(result, "sledge.v") == pytest.approx(-0.4 * voltage, abs=1e-6)


def test_magnetic_circuit_behind_a_winding() -> None:
    # V_m = N i and v = N der(Phi): L = N^2/R_m.
    result = simulate(
        """  electrical.ConstantVoltage supply(V = 10);
  electrical.Ground ground;
  electrical.Resistor wire(R = 5);
  FromPins pins;
  Gyrator winding(k = 100);
  FromMagneticPorts core(Phi(fixed = true));
  magnetic.ConstantReluctance iron(R_m = 1e4);
  magnetic.Ground earth;
equation
  connect(supply.p, wire.p);
  connect(wire.n, pins.p);
  connect(pins.n, supply.n, ground.p);
  connect(pins.cut, winding.a);
  connect(winding.b, core.cut);
  connect(core.port_p, iron.port_p);
  connect(core.port_n, iron.port_n, earth.port);
"""
    )
    current = 2 * (1 - np.exp(-result.times * 5 / (100**2 / 1e4)))
    assert values(result, "wire.i") == pytest.approx(current, abs=1e-6)
    assert values(result, "iron.V_m") == pytest.approx(100 * current, abs=1e-4)


def test_pump_between_shaft_and_liquid() -> None:
    # p = tau/V and q = V w, with the displacement V per angle.
    result = simulate(
        """  inner hydraulic.Oil oil;
  mechanical.rotational.ConstantTorque motor(tau_constant = 8);
  mechanical.rotational.Inertia rotor(J = 0.1, phi(fixed = true), w(start = 0, fixed = true));
  FromShaft shaft;
  Gyrator pump(k = 1e5);
  FromFluidPorts liquid(rho = 870);
  hydraulic.LaminarRestriction drop;
  hydraulic.OpenTank tank;
equation
  connect(motor.flange, rotor.flange_a);
  connect(rotor.flange_b, shaft.flange);
  connect(shaft.cut, pump.a);
  connect(pump.b, liquid.cut);
  connect(liquid.port_a, drop.port_a);
  connect(drop.port_b, liquid.port_b, tank.port);
""",
        stop_time=100,
    )
    w, pressure = values(result, "rotor.w"), values(result, "drop.dp")
    volume = values(result, "drop.m_flow") / 870
    assert volume == pytest.approx(1e-5 * w, rel=1e-6, abs=1e-12)
    inertia = 0.1 * np.gradient(w, result.times)
    assert pressure[5:-5] == pytest.approx((8 - inertia[5:-5]) / 1e-5, rel=2e-2)
    assert pressure[-1] > 1e5


def test_reversible_heat_engine_has_the_efficiency_of_carnot() -> None:
    # What entropy the hot side gives the cold side takes.
    result = simulate(
        """  FromHeatPort hot, cold;
  Multiport engine(K = [1, -1]);
  thermal.FixedTemperature source(T = 600), sink(T = 300);
  Dissipator load(G = 2);
equation
  connect(source.port, hot.port);
  connect(sink.port, cold.port);
  connect(hot.cut, engine.incoming[1]);
  connect(cold.cut, engine.incoming[2]);
  connect(engine.outgoing[1], load.cut);
"""
    )
    work = values(result, "engine.powerOut")
    heat = -values(result, "source.port.Q_flow")
    assert work / heat == pytest.approx(1 - 300 / 600)
