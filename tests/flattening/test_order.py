"""The order of declarations and of equations changes nothing."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acausal.compiler import compile_text
from tests.flattening.static import solve

PIN = (
    "connector Pin Real v; flow Real i; end Pin;\n"
    "model C Pin p, n; parameter Real C = 1; Real u; equation {c} end C;\n"
    "model R Pin p, n; parameter Real R = 1; equation p.v - n.v = R*p.i; p.i + n.i = 0; end R;\n"
    "model V Pin p, n; parameter Real V = 6; equation p.v - n.v = V; p.i + n.i = 0; end V;\n"
    "model G Pin p; equation p.v = 0; end G;\n"
)
CAPACITOR = ["p.v - n.v = u;", "p.i + n.i = 0;", "p.i = C*der(u);"]
DECLARATIONS = [
    "R a(R = k);",
    "R b[2](R = {2, 3});",
    "C c(u(start = 1, fixed = true));",
    "C d(C = 2, u(start = -1, fixed = true));",
    "V v;",
    "G g;",
    "parameter Real k = 2*j;",
    "parameter Real j = 0.5;",
    "Real power;",
]
EQUATIONS = [
    "connect(v.p, a.p);",
    "connect(a.n, b[1].p, c.p);",
    "connect(b[1].n, d.p);",
    "connect(d.p, b[2].p);",
    "connect(b[2].n, g.p);",
    "connect(v.n, g.p);",
    "connect(c.n, g.p, d.n);",
    "power = v.n.i*v.V;",
]


def model(declarations, equations, capacitor) -> str:
    return (
        PIN.format(c=" ".join(capacitor))
        + f"model M {' '.join(declarations)} equation {' '.join(equations)} end M;"
    )


ORDERS = st.tuples(
    st.permutations(DECLARATIONS), st.permutations(EQUATIONS), st.permutations(CAPACITOR)
)
STATES = {"c.u": 1.0, "d.u": -1.0}


@given(ORDERS)
@settings(max_examples=40, deadline=None)
def test_the_flat_equations_mean_the_same(order):
    first = solve(model(DECLARATIONS, EQUATIONS, CAPACITOR), states=STATES)
    other = solve(model(*order), states=STATES)
    assert other.keys() == first.keys()
    assert other == pytest.approx(first, abs=1e-7)


@given(ORDERS)
@settings(max_examples=6, deadline=None)
def test_the_trajectory_is_the_same(order):
    first = compile_text(model(DECLARATIONS, EQUATIONS, CAPACITOR)).simulate(
        stop_time=3.0, tolerance=1e-9
    )
    other = compile_text(model(*order)).simulate(stop_time=3.0, tolerance=1e-9)
    for path in ("c.u", "d.u", "power", "b[1].p.i"):
        assert other[path].values == pytest.approx(first[path].values, rel=1e-6, abs=1e-7)


@given(st.permutations(["A", "B", "M"]))
@settings(max_examples=6, deadline=None)
def test_the_order_of_classes_is_free(order):
    classes = {
        "A": "model A parameter Real p = B.k; Real x = p; end A;",
        "B": "package B constant Real k = 3; end B;",
        "M": "model M A a; Real y = 2*a.x; end M;",
    }
    text = "\n".join(classes[name] for name in order)
    assert solve(text, "M")["y"] == pytest.approx(6.0)


def test_scaling_by_units_changes_nothing():
    """A model in other units of the same quantities has the same solution in SI."""
    text = (
        'model M parameter Real R(unit = "Ohm") = {R}; parameter Real C(unit = "F") = {C}; '
        'Real u(unit = "V", start = {u}, fixed = true); equation R*C*der(u) = -u; end M;'
    )
    runs = [
        compile_text(text.format(R=r, C=c, u=u)).simulate(stop_time=1.0)
        for r, c, u in (("1e3", "1e-3", "5"), ("1[kOhm]", "1[mF]", "5000[mV]"))
    ]
    assert runs[0]["u"].values == pytest.approx(runs[1]["u"].values, rel=1e-12)
