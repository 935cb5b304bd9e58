"""Random magnetic circuits against their nodal equations, and Tellegen's theorem."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.library.magnetic.circuits import last, simulate


@st.composite
def circuits(draw: Any) -> tuple[int, list[tuple[int, int, float, float]]]:
    """Number of nodes, and tubes: from, to, reluctance, magnetic potential difference."""
    nodes = draw(st.integers(2, 5))
    number = st.integers(1, 50)
    # a chain connects all nodes with each other, then some more
    ends = [(k, k + 1) for k in range(nodes - 1)]
    node = st.integers(0, nodes - 1)
    ends += draw(
        st.lists(st.tuples(node, node).filter(lambda e: e[0] != e[1]), min_size=1, max_size=5)
    )
    return nodes, [(a, b, float(draw(number)), float(draw(st.integers(-20, 20)))) for a, b in ends]


@settings(max_examples=15, derandomize=True, deadline=None)
@given(circuits())
def test_random_circuits(circuit: tuple[int, list[tuple[int, int, float, float]]]) -> None:
    nodes, tubes = circuit
    declarations = ["  Ground ground;"]
    cuts: list[list[str]] = [[] for _ in range(nodes)]
    cuts[0].append("ground.port")
    equations = []
    for k, (start, end, reluctance, potential) in enumerate(tubes):
        declarations.append(f"  ConstantReluctance tube{k}(R_m = {reluctance});")
        declarations.append(f"  ConstantMagneticPotentialDifference source{k}(V_m = {potential});")
        cuts[start].append(f"tube{k}.port_p")
        cuts[end].append(f"source{k}.port_n")
        equations.append(f"  connect(tube{k}.port_n, source{k}.port_p);")
    equations += [f"  connect({', '.join(c)});" for c in cuts if len(c) > 1]
    result = simulate("\n".join([*declarations, "equation", *equations]))
    incidence = np.zeros((nodes, len(tubes)))
    for k, (start, end, _, _) in enumerate(tubes):
        incidence[start, k], incidence[end, k] = 1, -1
    permeance = np.diag([1 / t[2] for t in tubes])
    sources = np.array([t[3] for t in tubes])
    reduced = incidence[1:]
    potentials = np.linalg.solve(reduced @ permeance @ reduced.T, reduced @ permeance @ sources)
    flux = permeance @ (reduced.T @ potentials - sources)
    found = np.array([last(result, f"tube{k}.Phi") for k in range(len(tubes))])
    assert found == pytest.approx(flux, abs=1e-9)
    across = np.array([last(result, f"tube{k}.V_m") + tubes[k][3] for k in range(len(tubes))])
    assert across @ found == pytest.approx(0, abs=1e-8)
