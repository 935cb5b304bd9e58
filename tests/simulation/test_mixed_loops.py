"""Loops of relations and continuous equations: networks of ideal diodes, switches, thyristors."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.simulation.hybrid_runs import instants, jumps, last, run, sides, values

Array = NDArray[np.float64]

NODES, DIODES = 4, 5
RON, GOFF = 1e-3, 1e-4

# Nodes with conductances between them and sources of current, and diodes anywhere; all sources
# jump at 0.5 s, so that any number of diodes has to switch at once.
NETWORK = """
model Network
  parameter Real G[4, 4] = {G}, J0[4] = {J0}, J1[4] = {J1}, A[5, 4] = {A};
  parameter Real Ron = 1e-3, Goff = 1e-4;
  Real v[4], i[5], s[5], x(start = 0, fixed = true);
  Boolean off[5];
equation
  for k in 1:4 loop
    sum(G[k, j]*v[j] for j in 1:4) + sum(A[j, k]*i[j] for j in 1:5)
      = if time < 0.5 then J0[k] else J1[k];
  end for;
  for j in 1:5 loop
    off[j] = s[j] < 0;
    sum(A[j, k]*v[k] for k in 1:4) = s[j]*(if off[j] then 1 else Ron);
    i[j] = s[j]*(if off[j] then Goff else 1);
  end for;
  der(x) = v[1];
end Network;
"""


def braces(matrix: Array) -> str:
    if matrix.ndim == 1:
        return "{" + ", ".join(repr(float(x)) for x in matrix) + "}"
    return "{" + ", ".join(braces(row) for row in matrix) + "}"


def enumerated(conductances: Array, sources: Array, ends: Array) -> Array:
    """Return the node voltages by trying all combinations of conducting diodes."""
    for pattern in itertools.product([False, True], repeat=len(ends)):
        on = np.array(pattern)
        g = np.where(on, 1 / RON, GOFF)
        v = np.linalg.solve(conductances + ends.T @ (g[:, None] * ends), sources)
        across = ends @ v
        if np.all(np.where(on, across >= -1e-12, across <= 1e-12)):
            return np.asarray(v)
    raise AssertionError("no combination is right")


@st.composite
def networks(draw: Any) -> tuple[Array, Array, Array, Array]:
    real = st.floats(0.1, 3.0)
    conductances = np.diag([draw(real) for _ in range(NODES)])
    for a, b in itertools.combinations(range(NODES), 2):
        g = draw(st.sampled_from([0.0, 0.5, 2.0]))
        conductances[[a, b], [a, b]] += g
        conductances[[a, b], [b, a]] -= g
    current = st.integers(-6, 6).map(float)
    first, second = (np.array([draw(current) for _ in range(NODES)]) for _ in range(2))
    ends = np.zeros((DIODES, NODES))
    for j in range(DIODES):
        a, b = draw(st.permutations(range(NODES + 1)))[:2]  # the last one is the ground
        for node, sign in ((a, 1.0), (b, -1.0)):
            if node < NODES:
                ends[j, node] = sign
    return conductances, first, second, ends


@settings(max_examples=40, deadline=None)
@given(networks())
def test_random_networks_of_ideal_diodes(network: tuple[Array, Array, Array, Array]) -> None:
    conductances, first, second, ends = network
    text = NETWORK
    for name, matrix in (("G", conductances), ("J0", first), ("J1", second), ("A", ends)):
        text = text.replace("{" + name + "}", braces(matrix))
    result = run(text, 1.0, points=3)
    for side, sources in ((0, first), (1, second)):
        wanted = enumerated(conductances, sources, ends)
        if side:
            found = np.array([last(result, f"v[{k}]") for k in range(1, NODES + 1)])
        else:
            found = np.array([values(result, f"v[{k}]")[0] for k in range(1, NODES + 1)])
        assert found == pytest.approx(wanted, rel=1e-7, abs=1e-7)


# The same with diodes without any resistance or conductance, each in series with a resistor.
IDEAL = (
    NETWORK.replace("Ron = 1e-3, Goff = 1e-4", "r = 0.5")
    .replace("s[j]*(if off[j] then 1 else Ron)", "(if off[j] then s[j] else 0) + r*i[j]")
    .replace("s[j]*(if off[j] then Goff else 1)", "if off[j] then 0 else s[j]")
)


def enumerated_ideal(conductances: Array, sources: Array, ends: Array) -> Array:
    """Return the node voltages of a network of ideal diodes in series with resistors."""
    for pattern in itertools.product([0.0, 1.0], repeat=len(ends)):
        g = np.array(pattern) / 0.5
        v = np.linalg.solve(conductances + ends.T @ (g[:, None] * ends), sources)
        across = ends @ v
        if np.all(np.where(g > 0, across >= -1e-12, across <= 1e-12)):
            return np.asarray(v)
    raise AssertionError("no combination is right")


@settings(max_examples=40, deadline=None)
@given(networks())
def test_random_networks_of_diodes_without_resistance(
    network: tuple[Array, Array, Array, Array],
) -> None:
    conductances, first, second, ends = network
    text = IDEAL
    for name, matrix in (("G", conductances), ("J0", first), ("J1", second), ("A", ends)):
        text = text.replace("{" + name + "}", braces(matrix))
    result = run(text, 1.0, points=3)
    for side, sources in ((0, first), (-1, second)):
        wanted = enumerated_ideal(conductances, sources, ends)
        found = np.array([values(result, f"v[{k}]")[side] for k in range(1, NODES + 1)])
        assert found == pytest.approx(wanted, rel=1e-7, abs=1e-7)


LADDER = """
import electrical.*;
model Ladder
  parameter Integer n = 8;
  PulseVoltage source(V = 20[V], offset = -10[V], period = 1[s], width = 50);
  IdealDiode d[n], e[n];
  Resistor r(R = 1[Ohm]), q(R = 2[Ohm]);
  Ground ground;
equation
  connect(source.p, d[1].p, e[n].n);
  for i in 1:n - 1 loop
    connect(d[i].n, d[i + 1].p);
    connect(e[i].n, e[i + 1].p);
  end for;
  connect(d[n].n, r.p);
  connect(e[1].p, q.p);
  connect(r.n, q.n, ground.p, source.n);
end Ladder;
"""


def test_all_diodes_of_two_branches_switch_at_once() -> None:
    result = run(LADDER, 2.25, points=10)
    assert instants(result) == pytest.approx([0.5, 1, 1.5, 2], rel=1e-12)
    for time, sign in ((0.5, -1), (1.0, 1), (1.5, -1)):
        before, after = sides(result, "r.v", time)
        forward, backward = (after, before) if sign > 0 else (before, after)
        assert forward == pytest.approx(10, abs=1e-3)
        assert backward == pytest.approx(0, abs=1e-3)
        assert sides(result, "q.v", time)[sign < 0] == pytest.approx(-10, abs=1e-3)


THREE_PHASES = """
import electrical.*;
model ThreePhases
  parameter Real pi = 3.141592653589793;
  SineVoltage u[3](each V = 100[V], each f = 50[Hz], phase = {0, -2*pi/3, 2*pi/3});
  IdealDiode top[3](each Ron = RON, each Goff = GOFF);
  IdealDiode bottom[3](each Ron = RON, each Goff = GOFF);
  Resistor load(R = 10[Ohm]);
  Ground ground;
equation
  for k in 1:3 loop
    connect(u[k].n, ground.p);
    connect(u[k].p, top[k].p, bottom[k].n);
    connect(top[k].n, load.p);
    connect(bottom[k].p, load.n);
  end for;
end ThreePhases;
"""


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize(("ron", "goff"), [("1e-5", "1e-5"), ("1e-6", "1e-9"), ("1e-3", "1e-5")])
def test_three_phase_bridge_commutates_every_sixth_of_a_period(
    ron: str, goff: str, tolerance: float
) -> None:
    # Between two diodes the current commutates within 0.5 ns to 0.5 us, about T/12 + k T/6.
    text = THREE_PHASES.replace("RON", ron).replace("GOFF", goff)
    result = run(text, 0.039, points=401, tolerance=tolerance)
    t = np.asarray(result.times)
    phases = [100 * np.sin(2 * np.pi * (50 * t - k / 3)) for k in range(3)]
    expected = np.max(phases, axis=0) - np.min(phases, axis=0)
    assert values(result, "load.v") == pytest.approx(expected, abs=0.05 if ron == "1e-3" else 2e-3)
    middle = instants(result).reshape(12, 2).mean(axis=1)
    assert middle == pytest.approx(0.02 / 12 + np.arange(12) * 0.02 / 6, abs=1e-8)


THYRISTOR = """
model Thyristor
  parameter Real Ron = 1e-6, Goff = 1e-9;
  Real u = 10*sin(2*3.141592653589793*time), v, i, s;
  Boolean off(start = true, fixed = true), fire = sample(0.1, 1);
  Boolean gate(start = false, fixed = true);
equation
  when {fire, sample(0.6, 1)} then
    gate = fire;
  end when;
  off = s < 0 or pre(off) and not gate;
  v = s*(if off then 1 else Ron);
  i = s*(if off then Goff else 1);
  u = v + 2*i;
end Thyristor;
"""


def test_ideal_thyristor_waits_for_its_gate() -> None:
    result = run(THYRISTOR, 2.0, tolerance=1e-10)
    found = jumps(result, "off")
    assert [value for _, value in found] == [0, 1, 0, 1]
    assert [time for time, _ in found] == pytest.approx([0.1, 0.5, 1.1, 1.5], abs=1e-8)
    t = np.asarray(result.times)
    inside = (t > 0.1 + 1e-9) & (t < 0.5 - 1e-9)
    expected = 5 * np.sin(2 * np.pi * t[inside])
    assert values(result, "i")[inside] == pytest.approx(expected, abs=1e-5)


def test_mode_of_the_start_is_found() -> None:
    # Not one of the relations as the start values have them has a solution.
    text = """
    model M
      Real s[2](each start = 0), i, x(start = 0, fixed = true);
      Boolean on[2];
    equation
      for k in 1:2 loop
        on[k] = s[k] > 0;
      end for;
      10 = (if on[1] then 0 else s[1]) + (if on[2] then 0 else s[2]) + 5*i;
      i = if on[1] then s[1] else 0;
      i = if on[2] then s[2] else 0;
      der(x) = i;
    end M;
    """
    result = run(text, 1.0)
    assert last(result, "i") == pytest.approx(2)
    assert last(result, "x") == pytest.approx(2)
