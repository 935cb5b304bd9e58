"""Junctions: across variables are equal, through variables sum to zero, seen from both sides."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acausal.connections.junctions import find_junctions
from tests.flattening.static import flat, refused, solve

PIN = (
    "connector Pin Real v; flow Real i; end Pin;\n"
    "model R Pin p, n; parameter Real R = 1; equation p.v - n.v = R*p.i; p.i + n.i = 0; end R;\n"
    "model V Pin p, n; parameter Real V = 6; equation p.v - n.v = V; p.i + n.i = 0; end V;\n"
    "model G Pin p; equation p.v = 0; end G;\n"
)
SIGNAL = (
    "connector In = input Real; connector Out = output Real;\n"
    "model Source Out y; parameter Real k = 5; equation y = k; end Source;\n"
    "model Gain In u; Out y; parameter Real k = 2; equation y = k*u; end Gain;\n"
)


def current(body: str, declarations: str = "", **options) -> float:
    """Return the current that a 6 V source ``v`` delivers into a network grounded at ``v.n``."""
    text = PIN + f"model M V v; G g; {declarations} equation connect(v.n, g.p); {body} end M;"
    return round(solve(text, **options)["v.n.i"], 9)


def test_any_number_of_cuts_meet_at_one_junction():
    assert (
        current(
            "connect(v.p, r[1].p, r[2].p, r[3].p); connect(v.n, r[1].n, r[2].n, r[3].n);",
            "R r[3](R = {1, 2, 3});",
        )
        == 11
    )


def test_the_same_connection_twice_changes_nothing():
    body = "connect(v.p, r.p); connect(r.p, v.p); connect(v.n, r.n); connect(r.n, g.p);"
    assert current(body, "R r(R = 2);") == 3


def test_arrays_are_connected_element_by_element():
    body = (
        "connect(r.n, q.p); for k in 1:3 loop connect(v.p, r[k].p); connect(q[k].n, v.n); end for;"
    )
    assert current(body, "R r[3](R = {1, 2, 3}); R q[3];") == pytest.approx(6 / 2 + 6 / 3 + 6 / 4)


def test_slices_make_a_chain():
    body = "connect(r[1:2].n, r[2:3].p); connect(v.p, r[1].p); connect(r[end].n, v.n);"
    assert current(body, "R r[3](R = {1, 2, 3});") == 1


def test_rows_of_a_grid():
    body = (
        "connect(r[1,:].n, r[2,:].p); "
        "for j in 1:2 loop connect(v.p, r[1,j].p); connect(r[2,j].n, v.n); end for;"
    )
    assert current(body, "R r[2,2](R = {{1, 2}, {3, 4}});") == pytest.approx(6 / 4 + 6 / 6)


def test_a_loop_with_a_condition():
    body = (
        "for k in 1:3 loop if k == 1 then connect(v.p, r[k].p); "
        "else connect(r[k-1].n, r[k].p); end if; end for; connect(r[3].n, v.n);"
    )
    assert current(body, "R r[3];") == 2


# --- cuts of composite components ------------------------------------------------------------

SECTION = PIN + (
    "model S Pin a, b; R r(R = 1), q(R = 2); "
    "equation connect(a, r.p); connect(r.n, q.p); connect(q.n, b); end S;\n"
    "model T Pin a, b; S x, y; equation connect(a, x.a); "
    "connect(x.b, y.a); connect(y.b, b); end T;\n"
    "model Wire Pin a, b; equation connect(a, b); end Wire;\n"
)


@pytest.mark.parametrize(("kind", "expected"), [("S", 2.0), ("T", 1.0)])
def test_what_flows_in_outside_flows_on_inside(kind, expected):
    found = solve(
        SECTION + f"model M V v; {kind} s; G g; "
        "equation connect(v.p, s.a); connect(s.b, v.n, g.p); end M;"
    )
    assert found["s.a.i"] == pytest.approx(expected)
    assert found["s.b.i"] == pytest.approx(-expected)
    inner = "s.r.p.i" if kind == "S" else "s.x.r.p.i"
    assert found[inner] == pytest.approx(expected)


def test_a_wire_through_a_component():
    found = solve(
        SECTION + "model M V v; Wire w; R r(R = 3); G g; "
        "equation connect(v.p, w.a); connect(w.b, r.p); connect(r.n, v.n, g.p); end M;"
    )
    assert found["w.a.i"] == pytest.approx(2.0)
    assert found["w.b.v"] == pytest.approx(6.0)


def test_equations_may_use_a_cut_that_is_handed_on():
    found = solve(
        SECTION + "model A Pin a, b; Real i; R r; "
        "equation connect(a, r.p); connect(r.n, b); i = a.i; end A; "
        "model M V v; A w; G g; equation connect(v.p, w.a); connect(w.b, v.n, g.p); end M;"
    )
    assert found["w.i"] == pytest.approx(6.0)


def test_an_open_end_carries_nothing():
    found = solve(
        SECTION + "model M V v; S s; G g; equation connect(v.p, s.a); connect(v.n, g.p); end M;"
    )
    assert found["s.b.i"] == pytest.approx(0.0)
    assert found["s.b.v"] == pytest.approx(6.0)


def test_a_cut_of_the_model_itself_carries_nothing():
    found = solve(
        SECTION + "model M Pin a; R r; G g; equation connect(a, r.p); connect(r.n, g.p); end M;"
    )
    assert found["a.i"] == pytest.approx(0.0)


# --- kinds of connectors ---------------------------------------------------------------------


def test_several_pairs_of_variables():
    found = solve(
        "connector F Real x; Real y; flow Real fx; flow Real fy; end F; "
        "model A F a; equation a.x = 1; a.y = 2; end A; "
        "model B F a; parameter Real k = 3; equation a.fx = k*a.x; a.fy = k*a.y; end B; "
        "model M A a; B b; B c(k = 5); equation connect(a.a, b.a, c.a); end M;"
    )
    assert (found["a.a.fx"], found["a.a.fy"]) == pytest.approx((-8.0, -16.0))


def test_across_and_through_are_the_same_as_plain_and_flow():
    found = solve(
        "connector Pin across Real v; through Real i; end Pin; "
        "connector Pole Real v; flow Real i; end Pole; "
        "model A Pin p; equation p.v = 3; end A; model B Pole p; equation p.i = 2*p.v; end B; "
        "model M A a; B b; equation connect(a.p, b.p); end M;"
    )
    assert found["a.p.i"] == pytest.approx(-6.0)


def test_connectors_of_connectors():
    found = solve(
        PIN + "connector Plug Pin pin[3]; end Plug; "
        "model Load Plug p; "
        "equation for k in 1:3 loop p.pin[k].v = k*p.pin[k].i; end for; end Load; "
        "model Source Plug p; equation for k in 1:3 loop p.pin[k].v = 6; end for; end Source; "
        "model M Load l; Source s; equation connect(l.p, s.p); end M;"
    )
    assert [found[f"s.p.pin[{k}].i"] for k in (1, 2, 3)] == pytest.approx([-6.0, -3.0, -2.0])


def test_signals_go_to_many_and_through_composites():
    found = solve(
        SIGNAL + "model Two In u; Out y; Gain a, b; "
        "equation connect(u, a.u); connect(a.y, b.u); connect(b.y, y); end Two; "
        "model M Source s; Gain g(k = 3); Two t; equation connect(s.y, g.u, t.u); end M;"
    )
    assert (found["g.y"], found["t.y"]) == pytest.approx((15.0, 20.0))


def test_arrays_of_signals():
    found = solve(
        SIGNAL + "model Sum parameter Integer n = 2; In u[n]; Out y; equation y = sum(u); end Sum; "
        "model M Source s[3](k = {1, 2, 3}); Sum g(n = 3); equation connect(s.y, g.u); end M;"
    )
    assert found["g.y"] == pytest.approx(6.0)


# --- mistakes --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ("connect(r, v.p);", "C101"),
        ("connect(r.R, v.p);", "C101"),
        ("connect(r.q, v.p);", "N102"),
        ("connect(s.p, v.p);", "N102"),
        ("connect(r.p, q.p);", "C102"),
        ("connect(q[1:2].p, q[1:3].n);", "C102"),
        ("connect(q[4].p, v.p);", "T114"),
        ("for k in 1:3 loop connect(q[k].n, q[k+1].p); end for;", "T114"),
        ("connect(r.p.v, v.p);", "C1"),
        ("connect(x, v.p);", "C101"),
        ("if time > 1 then connect(r.p, v.p); end if;", "C105"),
    ],
)
def test_wrong_connections(body, code):
    text = PIN + f"model M V v; R r; R q[3]; Real x = 1; equation {body} end M;"
    assert refused(text).code.startswith(code)


def test_unlike_cuts_name_both_kinds():
    message = refused(
        PIN + "connector F Real s; flow Real f; end F; model B F a; equation a.s = 0; end B; "
        "model M V v; B b; equation connect(v.p, b.a); end M;"
    )
    assert message.code == "C101"
    assert "Pin" in message.message and "F" in message.message
    assert len(message.labels) == 2


def test_cuts_of_unlike_units():
    message = refused(
        'connector A Real e(unit = "V"); flow Real f; end A; '
        'connector B Real e(unit = "m"); flow Real f; end B; '
        "model X A a; equation a.e = 1; end X; model Y B b; equation b.f = 1; end Y; "
        "model M X x; Y y; equation connect(x.a, y.b); end M;"
    )
    assert message.code == "U107"


def test_connections_do_not_belong_into_initial_equations():
    text = PIN + "model M V v; R r; initial equation connect(v.p, r.p); end M;"
    assert refused(text).code == "C104"


# --- large and random ------------------------------------------------------------------------


def test_one_junction_of_many_cuts():
    flattened = flat(
        PIN + "model M parameter Integer n = 3000; V v; R r[n](each R = 3000); G g; equation "
        "for k in 1:n loop connect(v.p, r[k].p); connect(r[k].n, g.p); end for; "
        "connect(v.n, g.p); end M;"
    )
    junctions = find_junctions(flattened.numbering)
    sizes = np.bincount(junctions.junction[0::2])
    assert sorted(sizes[sizes > 1].tolist()) == [3001, 3002]


@given(
    st.integers(2, 7).flatmap(
        lambda n: st.tuples(
            st.just(n),
            st.lists(st.tuples(st.integers(1, n), st.integers(1, n)), min_size=1, max_size=12),
        )
    )
)
@settings(max_examples=40, deadline=None)
def test_random_networks_obey_the_laws_of_kirchhoff(network):
    """Resistors between random nodes, a source at the first node, the last one grounded."""
    n, branches = network
    body = "".join(
        f"connect(r[{k}].p, node[{a}].p); connect(r[{k}].n, node[{b}].p); "
        for k, (a, b) in enumerate(branches, 1)
    )
    # A large resistor from every node to the ground keeps all potentials determined.
    found = solve(
        PIN + "model Node Pin p; R r(R = 1000); G g; equation connect(p, r.p); connect(r.n, g.p); "
        f"end Node; model M parameter Integer m = {len(branches)}; Node node[{n}]; "
        "R r[m](R = {k for k in 1:m}); V v; G g; equation "
        + body
        + f"connect(v.p, node[1].p); connect(v.n, g.p, node[{n}].p); end M;"
    )
    conductance = np.zeros((n, n))
    for k, (a, b) in enumerate(branches, 1):
        for x, y in ((a, b), (b, a)):
            conductance[x - 1, x - 1] += 1 / k
            conductance[x - 1, y - 1] -= 1 / k
    conductance += np.eye(n) / 1000
    free = list(range(1, n - 1))
    potential = np.zeros(n)
    potential[0] = 6.0
    potential[free] = np.linalg.solve(conductance[np.ix_(free, free)], -conductance[free, 0] * 6.0)
    assert [found[f"node[{k}].p.v"] for k in range(1, n + 1)] == pytest.approx(potential, abs=1e-6)
    assert -found["v.p.i"] == pytest.approx(conductance[0] @ potential, abs=1e-6)
