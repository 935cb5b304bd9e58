"""Graphs and chains as models."""

from __future__ import annotations

import networkx as nx
import numpy as np
import pytest

import acausal as ac
from acausal.library import electrical as el
from acausal.library.mechanical import planar as pl
from acausal.library.mechanical import translational as tr


def last(result, path):
    return result[path].values[-1]


@pytest.mark.parametrize("kind", [nx.Graph, nx.DiGraph, nx.MultiGraph, nx.MultiDiGraph])
def test_bridge_of_resistors(kind):
    """Effective resistance against the pseudoinverse of the graph's Laplacian."""
    graph = kind()
    values = {("a", "b"): 1.0, ("a", "c"): 2.0, ("b", "c"): 3.0, ("b", "d"): 4.0, ("c", "d"): 5.0}
    for (a, b), R in values.items():
        graph.add_edge(a, b, component="electrical.Resistor", R=R, weight=1 / R)
    laplacian = nx.laplacian_matrix(nx.Graph(graph), nodelist="abcd").toarray()
    graph.add_edge("a", "d", component=el.ConstantVoltage, V=1, name="source", cuts=("p", "n"))
    graph.nodes["d"]["component"] = el.Ground
    result = ac.from_graph(graph, ignore=["weight"]).simulate(stop_time=1, points=2)
    inverse = np.linalg.pinv(laplacian)
    resistance = inverse[0, 0] + inverse[3, 3] - 2 * inverse[0, 3]
    assert -last(result, "source.i") == pytest.approx(1 / resistance)


def test_parallel_edges_and_names():
    graph = nx.MultiDiGraph()
    for R in (1, 2, 4):
        graph.add_edge((0, 0), (0, 1), component="electrical.Resistor", R=R)
    graph.add_edge((0, 0), (0, 1), component="electrical.Conductor", G=1, name="resistor_0_0_0_1_2")
    graph.add_edge((0, 1), (0, 0), component=el.ConstantCurrent, I=11)
    graph.add_node((0, 1), component="electrical.Ground", name="earth")
    model = ac.from_graph(graph, "parallel")
    text = model.to_acm()
    assert text == ac.from_graph(graph, "parallel").to_acm()
    for name in (
        "resistor_0_0_0_1",
        "resistor_0_0_0_1_2",
        "resistor_0_0_0_1_3",
        "resistor_0_0_0_1_4",
        "constantCurrent_0_1_0_0",
        "earth",
    ):
        assert f" {name}" in text
    assert last(model.simulate(stop_time=1), "resistor_0_0_0_1.v") == pytest.approx(4)


def test_oscillator_of_masses_on_nodes():
    """Two masses and three springs: the frequencies are sqrt(k/m) and sqrt(3 k/m)."""
    graph = nx.DiGraph()
    graph.add_node("wall", component="mechanical.translational.Fixed")
    start = {"s": {"start": 0.1, "fixed": True}, "v": {"start": 0, "fixed": True}}
    graph.add_node(
        "left",
        components=[
            ({"component": tr.Mass, "m": 0.5, "parameters": start, "name": "m1"}),
            {"component": tr.Mass, "m": 0.5},
        ],
    )
    graph.add_node("right", component=tr.Mass, m=1, name="m2", parameters=start)
    graph.add_node("other", component=tr.Fixed)
    for a, b in (("wall", "left"), ("left", "right"), ("right", "other")):
        graph.add_edge(a, b, component=tr.Spring, c=4.0)
    result = ac.from_graph(graph, "masses").simulate(stop_time=3, tolerance=1e-8)
    expected = 0.1 * np.cos(2 * result.times)
    assert result["m1.s"].values == pytest.approx(expected, abs=1e-6)
    assert result["mass_left.s"].values == pytest.approx(expected, abs=1e-6)


def test_undirected_edges_point_from_the_node_that_was_first():
    graph = nx.Graph()
    graph.add_nodes_from("ab")
    graph.add_edge("b", "a", component=el.ConstantVoltage, V=5, name="v1")
    graph.add_edge("b", "a", component=el.ConstantVoltage, V=5, name="v1")
    graph.add_edge("b", "c", component=el.Resistor, R=2, cuts={"c": "p", "b": "n"}, name="r1")
    graph.add_edge("c", "a", component=el.Resistor, R=3, name="r2")
    graph.nodes["a"]["component"] = el.Ground
    result = ac.from_graph(graph).simulate(stop_time=1)
    assert last(result, "v1.v") == 5  # from a to b
    assert last(result, "r1.i") == pytest.approx(1)  # from c to b
    assert last(result, "r2.i") == pytest.approx(1)  # from a to c


def test_large_graph():
    """A grid of 10^4 edges, in potential theory: current through the corners."""
    size = 71
    graph = nx.grid_2d_graph(size, size)
    nx.set_edge_attributes(graph, el.Resistor, "component")
    corner = (size - 1, size - 1)
    graph.add_edge((0, 0), corner, component=el.ConstantVoltage, V=-1, name="source")
    graph.nodes[0, 0]["component"] = el.Ground
    laplacian = nx.laplacian_matrix(nx.grid_2d_graph(size, size)).astype(float).tocsc()
    from scipy.sparse.linalg import spsolve

    injected = np.zeros(size * size - 1)
    injected[-1] = 1
    potential = spsolve(laplacian[1:, 1:], injected)[-1]
    compiled = ac.from_graph(graph).compile()
    result = compiled.simulate(stop_time=1, points=2, variables=["source.i"])
    assert abs(last(result, "source.i")) == pytest.approx(1 / potential, rel=1e-8)


def edge(**data):
    graph = nx.DiGraph()
    graph.add_edge("x", "y", **data)
    return graph


def node(**data):
    graph = edge(component="electrical.Resistor")
    graph.add_node("x", **data)
    return graph


MISTAKES = {
    "no component": (edge(R=1), "N160", "edge ('x', 'y') has no component"),
    "class": (edge(component="electrical.Resistr"), "N150", "did you mean electrical.Resistor?"),
    "package": (edge(component="electric.Resistor"), "N150", "did you mean electrical.Resistor?"),
    "empty": (edge(component=""), "N150", "without a name"),
    "a package": (edge(component="electrical"), "N160", "no component class"),
    "instance": (edge(component=el.Resistor(R=1)), "N160", "made already"),
    "number": (edge(component=3), "N160", "3 instead of a class"),
    "parameter": (edge(component=el.Resistor, r=1), "N103", "at edge ('x', 'y')"),
    "weight": (edge(component=el.Resistor, weight=1), "N103", "ignore="),
    "value": (edge(component=el.Resistor, R="1[V]"), "U", "V"),
    "cuts not known": (edge(component="electrical.VCV"), "N161", "p1, n1, p2, n2"),
    "wrong cut": (edge(component=el.Resistor, cuts=("p", "m")), "N161", "no cut m"),
    "three cuts": (edge(component=el.Resistor, cuts=("p", "n", "p")), "N161", "not two"),
    "name": (edge(component=el.Resistor, name="r 1"), "N151", "at edge ('x', 'y')"),
    "number as name": (edge(component=el.Resistor, name=1), "N160", "no text"),
    "parameters": (edge(component=el.Resistor, parameters=[1]), "N160", "no dictionary"),
    "twice": (edge(component=el.Resistor, R=1, parameters={"R": 2}), "N160", "edge ('x', 'y')"),
    "node without component": (node(components=[{"R": 1}]), "N160", "node 'x'"),
    "nodes as text": (node(components="electrical.Ground"), "N160", "no list"),
    "node's cut": (node(component="electrical.VCV"), "N161", "cut="),
    "unlike": (node(component=tr.Fixed), "C101", "at node 'x'"),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_mistakes(case):
    graph, code, text = MISTAKES[case]
    with pytest.raises(ac.AcausalError) as caught:
        ac.from_graph(graph).compile()
    assert caught.value.diagnostics[0].code.startswith(code)
    assert text in str(caught.value)


def test_no_graph():
    with pytest.raises(ac.AcausalError, match="N160"):
        ac.from_graph([("a", "b")])


def test_two_names_alike():
    graph = nx.path_graph(3)
    nx.set_edge_attributes(graph, {e: {"component": el.Resistor, "name": "r"} for e in graph.edges})
    with pytest.raises(ac.AcausalError, match="N105"):
        ac.from_graph(graph)


@pytest.mark.parametrize("n", [1, 2, 10])
def test_chain_is_that_of_the_examples(n):
    start = {"phi": {"start": np.pi / 2, "fixed": True}, "w": {"start": 0, "fixed": True}}
    links = ac.chain(pl.Pendulum(length=1, mass=1, shape=n, **start), start=pl.Anchor())
    links.world = pl.PlanarWorld()
    model = {1: "SinglePendulum", 2: "DoublePendulum", 10: "Chain10"}[n]
    example = ac.compile_file("examples/pendulum_chain.acm", model)
    expected = example.simulate(stop_time=1, tolerance=1e-9)
    result = links.simulate(stop_time=1, tolerance=1e-9)
    for k in range(1, n + 1):
        path = f"link[{k}].phi"
        assert result[path].values == pytest.approx(expected[path].values, abs=1e-6)


def test_chain_with_an_end():
    """Resistors in series between a source and ground."""
    line = ac.chain(
        el.Resistor(R=[1, 2, 3], shape=3), start=el.Ground(), end=el.ConstantVoltage(V=6)
    )
    line.connect(line.end_.n, line.start.p)
    assert last(line.simulate(stop_time=1), "link[2].v") == pytest.approx(-2)


@pytest.mark.parametrize(
    ("links", "code"),
    [(el.Resistor(), "N160"), (el.Resistor(shape=(2, 2)), "N160"), (el.VCV(shape=3), "N161")],
)
def test_mistakes_in_chains(links, code):
    with pytest.raises(ac.AcausalError, match=code):
        ac.chain(links)
