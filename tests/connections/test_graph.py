"""The connection graph: components, junctions, islands, loops, neighbours."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import networkx
import numpy as np
import pytest

import acausal
from acausal.connections.graph import connection_graph, connections, islands, loops, neighbours
from acausal.diagnostics import AcausalError
from tests.connections.test_junctions import PIN, SECTION, SIGNAL
from tests.flattening.static import flat

EXAMPLES = Path(__file__).parents[2] / "examples"
LOOP = PIN + (
    "model M V v; R a, b, c; G g; equation connect(v.p, a.p); connect(a.n, b.p, c.p); "
    "connect(b.n, c.n, v.n, g.p); end M;"
)


def graph(text: str):
    return connection_graph(flat(text))


def test_nodes_and_edges():
    found = graph(LOOP)
    kinds = dict(found.nodes(data="kind"))
    assert [n for n in found if kinds[n] == "component"] == ["v", "a", "b", "c", "g"]
    assert sorted(n for n in found if kinds[n] == "junction") == [0, 1, 2]
    assert found.nodes["a"]["type"] == "R"
    cuts = {key: data for _, _, key, data in found.edges(keys=True, data=True)}
    assert sorted(cuts) == ["a.n", "a.p", "b.n", "b.p", "c.n", "c.p", "g.p", "v.n", "v.p"]
    assert cuts["a.n"]["junction"] == cuts["b.p"]["junction"]
    assert cuts["a.n"]["connector"] == "Pin" and cuts["a.n"]["physical"]


def test_neighbours_by_cut():
    found = graph(LOOP)
    assert neighbours(found, "a") == {"a.p": ["v.p"], "a.n": ["b.p", "c.p"]}


def test_neighbours_of_nobody():
    with pytest.raises(AcausalError) as caught:
        neighbours(graph(LOOP), "aa")
    assert caught.value.diagnostics[0].code == "N102"


def test_a_basis_of_loops():
    found = loops(graph(LOOP))
    assert len(found) == 2
    assert sorted(sorted(loop) for loop in found) in (
        [["a", "b", "v"], ["b", "c"]],
        [["a", "c", "v"], ["b", "c"]],
    )


def test_a_short_circuited_component_is_a_loop():
    found = graph(PIN + "model M R a; G g; equation connect(a.p, a.n, g.p); end M;")
    assert loops(found) == [["a"]]
    assert found.number_of_edges("a", found.edges["a", 0, "a.p"]["junction"]) == 2


def test_islands():
    text = PIN + (
        "model M V v, w; R a, b; G g, h; equation connect(v.p, a.p); connect(v.n, a.n, g.p); "
        "connect(w.p, b.p); connect(w.n, b.n, h.p); end M;"
    )
    assert islands(graph(text)) == [["v", "a", "g"], ["w", "b", "h"]]
    edges = connections(flat(text))
    count, of_component, of_junction = edges.islands()
    assert count == 2
    assert (of_component[edges.component] == of_junction[edges.junction]).all()


def test_composite_components_hand_their_cuts_through():
    found = graph(
        SECTION
        + ("model M V v; T t; G g; equation connect(v.p, t.a); connect(t.b, v.n, g.p); end M;")
    )
    assert "t" not in found and "t.x" not in found and "t.x.r" in found
    assert neighbours(found, "v")["v.p"] == ["t.x.r.p"]
    assert neighbours(found, "t.x.q")["t.x.q.n"] == ["t.y.r.p"]
    assert [len(loop) for loop in loops(found)] == [5]
    kinds = [kind for _, _, kind in found.edges(data="kind")]
    assert kinds.count("passage") == 6


def test_a_composite_that_uses_its_cut_stands_in_the_graph():
    found = graph(
        SECTION + "model A Pin a, b; Real i; R r; "
        "equation connect(a, r.p); connect(r.n, b); i = a.i; end A; "
        "model M V v; A w; G g; equation connect(v.p, w.a); connect(w.b, v.n, g.p); end M;"
    )
    assert {"w", "w.r"} <= set(found)


def test_open_cuts_are_ends():
    found = graph(PIN + "model M R r; G g; equation connect(r.p, g.p); end M;")
    (end,) = (n for n in found if isinstance(n, int) and found.degree(n) == 1)
    assert found.has_edge("r", end, "r.n")


def test_signals_are_not_physical():
    found = graph(SIGNAL + "model M Source s; Gain g; equation connect(s.y, g.u); end M;")
    assert {p for _, _, p in found.edges(data="physical")} == {False}


def test_a_large_ladder_as_arrays():
    n = 20_000
    edges = connections(
        flat(
            SECTION + f"model M parameter Integer n = {n}; S s[n]; V v; G g; equation "
            "for k in 1:n-1 loop connect(s[k].b, s[k+1].a); end for; "
            "connect(v.p, s[1].a); connect(s[n].b, v.n, g.p); end M;"
        )
    )
    assert edges.n_components == 2 * n + 2
    assert len(edges.passage) == 2 * n
    assert edges.islands()[0] == 1
    degree = np.bincount(edges.component)
    assert sorted(np.unique(degree).tolist()) == [1, 2]


def test_a_compiled_model_gives_its_graph_from_the_cache_too(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("ACAUSAL_CACHE", str(tmp_path))
    graphs = [
        acausal.compile_file(EXAMPLES / "simple_network.acm").connection_graph() for _ in range(2)
    ]
    assert graphs[0].nodes == graphs[1].nodes
    assert networkx.utils.graphs_equal(*graphs)
    assert islands(graphs[0]) == [["u", "r1", "r2", "l", "c", "ground"]]


def test_networkx_is_only_imported_when_a_graph_is_asked_for():
    script = (
        "import sys, acausal.compiler, acausal.connections.graph; print('networkx' in sys.modules)"
    )
    out = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "False"
