"""Random networks: Tellegen's theorem, the energy balance, and the equations of the network."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from tests.library.electrical.circuits import run, values

MODELS = {
    "R": "electrical.Resistor b{k}(R = {value})",
    "C": "electrical.Capacitor b{k}(C = {value}, v(start = 0, fixed = true))",
    "L": "electrical.Inductor b{k}(L = {value}, i(start = 0, fixed = true))",
    "I": "electrical.ConstantCurrent b{k}(I = {value})",
}


@dataclass
class Branch:
    """A part between two nodes."""

    kind: str
    start: int
    end: int
    value: float


@st.composite
def networks(draw: Any) -> tuple[int, list[Branch]]:
    """Number of nodes, and branches; each node has a resistor and a capacitor to ground.

    So all voltages of nodes are states, and each network has one solution.
    """
    nodes = draw(st.integers(2, 5))
    number = st.integers(1, 20).map(lambda n: n / 10)
    branches = []
    for node in range(1, nodes):
        branches.append(Branch("C", node, 0, draw(number)))
        branches.append(Branch("R", node, 0, draw(number)))
    node = st.integers(0, nodes - 1)
    pair = st.tuples(node, node).filter(lambda p: p[0] != p[1])
    for kind in draw(st.lists(st.sampled_from("RLI"), min_size=2, max_size=6)):
        start, end = draw(pair)
        branches.append(Branch(kind, start, end, draw(number)))
    branches.append(Branch("I", 0, nodes - 1, draw(number)))
    return nodes, branches


def text_of(nodes: int, branches: list[Branch]) -> str:
    cuts: list[list[str]] = [[] for _ in range(nodes)]
    cuts[0].append("ground.p")
    lines = ["  electrical.Ground ground;"]
    for k, branch in enumerate(branches):
        lines.append(f"  {MODELS[branch.kind].format(k=k, value=branch.value)};")
        cuts[branch.start].append(f"b{k}.p")
        cuts[branch.end].append(f"b{k}.n")
    lines += ["equation", *(f"  connect({', '.join(c)});" for c in cuts)]
    return "\n".join(lines)


def solution(nodes: int, branches: list[Branch], t: float) -> Any:
    """Return the voltages of the nodes: C u' = -G u - A i + s, L i' = A^T u."""
    coils = [b for b in branches if b.kind == "L"]
    size = nodes - 1 + len(coils)
    mass, rate, drive = np.zeros((size, size)), np.zeros((size, size)), np.zeros(size)

    def stamp(matrix: Any, branch: Branch, value: float) -> None:
        for a, sign in ((branch.start, 1), (branch.end, -1)):
            for b, other in ((branch.start, 1), (branch.end, -1)):
                if a and b:
                    matrix[a - 1, b - 1] += sign * other * value

    for branch in branches:
        if branch.kind == "C":
            stamp(mass, branch, branch.value)
        elif branch.kind == "R":
            stamp(rate, branch, -1 / branch.value)
        elif branch.kind == "I":
            for node, sign in ((branch.start, -1), (branch.end, 1)):
                if node:
                    drive[node - 1] += sign * branch.value
    for k, branch in enumerate(coils, nodes - 1):
        mass[k, k] = branch.value
        for node, sign in ((branch.start, 1), (branch.end, -1)):
            if node:
                rate[k, node - 1] += sign
                rate[node - 1, k] -= sign
    # one row more for the constant drive
    whole = np.zeros((size + 1, size + 1))
    whole[:size, :size] = np.linalg.solve(mass, rate)
    whole[:size, size] = np.linalg.solve(mass, drive)
    return (expm(whole * t) @ np.eye(size + 1)[size])[: nodes - 1]


@settings(max_examples=15, derandomize=True, deadline=None)
@given(networks())
def test_random_networks(network: tuple[int, list[Branch]]) -> None:
    nodes, branches = network
    result = run(text_of(nodes, branches), 2.0, points=41, tolerance=1e-9)
    voltage = np.array([values(result, f"b{k}.v") for k in range(len(branches))])
    current = np.array([values(result, f"b{k}.i") for k in range(len(branches))])
    # the power of all branches adds up to nothing, at each instant
    assert np.sum(voltage * current, axis=0) == pytest.approx(0, abs=1e-7)
    of_nodes = [k for k, b in enumerate(branches[: 2 * (nodes - 1)]) if b.kind == "C"]
    for sample in (0, 13, 40):
        expected = solution(nodes, branches, result.times[sample])
        assert voltage[of_nodes, sample] == pytest.approx(expected, abs=1e-6)
