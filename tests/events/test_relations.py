"""Which relations make events, and what stands in their place."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from acausal.events.relations import unique_columns
from tests.events.lowered import State, hybrid_of, lowered, values_of


def one_equation(right: str, more: str = "") -> str:
    return f"model M\n  Real x; Real y; {more}\nequation\n  x = time;\n  y = {right};\nend M;"


@pytest.mark.parametrize(
    "right",
    ["2*x", "noEvent(if x > 0 then 1 else 2)", "smooth(0, if x > 0 then x else 0)", "abs(x)",
     "max(x, 0) + min(x, 1)", "sign(x)", "if p > 0 then x else 2", "if p > 0 then floor(p) else x"],
)  # fmt: skip
def test_smooth_models_stay_as_they_are(right):
    model = lowered(one_equation(right, "parameter Real p = 1;"))
    assert model.hybrid is None
    assert len(model.parameters) == (1 if "p" in right else len(model.parameters))


@pytest.mark.parametrize(
    ("relation", "kind", "flipped"),
    [("x > 1", "gt", False), ("x >= 1", "ge", False), ("x < 1", "ge", True),
     ("x <= 1", "gt", True), ("1 < x", "gt", False), ("1 >= x", "gt", True)],
)  # fmt: skip
def test_a_relation_and_its_opposite_watch_the_same_function(relation, kind, flipped):
    state = State(lowered(one_equation(f"if {relation} then 5 else 7")))
    (found,) = state.hybrid.relations
    assert found.kind == kind
    for x in (0.5, 1.0, 1.5):
        state["x"], state["y"] = x, 0.0
        state.settle(time=x)
        expected = eval(relation.replace("x", str(x)))
        assert state.residuals(x)[1] == (-5.0 if expected else -7.0)
        assert (state.held(int(found.family.rows[0])) != 0.0) == (expected != flipped)


def test_equal_relations_are_one_and_different_ones_are_not():
    text = """
    model M
      Real x[3]; Real y[3]; Real z[3]; parameter Real a[3] = {1, 2, 1};
    equation
      for i in 1:3 loop
        x[i] = time;
        y[i] = if x[i] > a[i] then 1 else 0;
        z[i] = if x[i] <= a[i] then 1 else if time > 2 then 3 else 4;
      end for;
    end M;
    """
    hybrid = hybrid_of(lowered(text))
    assert [r.family.count for r in hybrid.relations] == [3, 1]


def test_a_relation_inside_a_relation_comes_first():
    state = State(lowered(one_equation("if x > (if time > 3 then 10 else 1) then 1 else 0")))
    inner, outer = state.hybrid.relations
    assert not inner.family.kinds
    for x, time, expected in [(5, 0, 1), (5, 4, 0), (11, 4, 1)]:
        state["x"], state["y"] = x, 0.0
        state.settle(time)
        assert -state.residuals(time)[1] == expected
    assert outer.family.rows[0] != inner.family.rows[0]


@given(
    x=st.floats(-20, 20).filter(lambda v: abs(v) > 1e-3),
    y=st.sampled_from([0.7, 3.0, -2.5]),
    name=st.sampled_from(["floor", "ceil", "integer", "div", "mod", "rem"]),
)
def test_rounded_values_are_what_the_functions_give(x, y, name):
    call = f"{name}(x, {y})" if name in ("div", "mod", "rem") else f"{name}(x)"
    state = State(lowered(one_equation(call)))
    assert [r.kind for r in state.hybrid.relations] == ["floor"]
    state["x"], state["y"] = x, 0.0
    state.settle(time=x)
    q = x / y
    expected = {
        "floor": np.floor(x), "ceil": np.ceil(x), "integer": np.floor(x), "div": np.trunc(q),
        "mod": x - np.floor(q) * y, "rem": x - np.trunc(q) * y,
    }[name]  # fmt: skip
    assert -state.residuals(x)[1] == pytest.approx(expected, abs=1e-12)


def test_a_relation_inside_noevent_stays_though_it_also_stands_outside():
    right = "(if x > 1 then 5 else 7) + noEvent(if x > 1 then 1 else 2)"
    state = State(lowered(one_equation(right)))
    state["x"], state["y"] = 0.0, 0.0
    state.settle(0.0)
    assert -state.residuals()[1] == 9.0
    state["x"] = 2.0
    assert -state.residuals()[1] == 8.0


def test_a_when_sees_the_relation_that_fires_it():
    text = """
    model M
      Real x(start=0, fixed=true); Boolean b; Boolean c; Boolean d;
    equation
      der(x) = 1;
      when x > 1 then b = x > 1; c = x > 2; d = x <= 1; end when;
    end M;
    """
    state = State(lowered(text))
    (relation,) = state.hybrid.relations
    assert relation.family.count == 1
    state["x"] = 1.5
    state.settle()
    assert [state[v] for v in "bcd"] == [1, 0, 0]
    # The root was found a little early: the relation is true, the numbers do not say so yet.
    state.forget()
    h = state.hybrid
    state.parameters[h.first + h.n_discrete + h.conditions] = 0.0
    state.parameters[h.first + relation.family.rows] = 1.0
    state["x"] = 1.0 - 1e-12
    for family in h.assignments:
        new = values_of(family, state.variables, state.parameters, 1.0)
        state.parameters[h.first + family.rows] = new
    assert [state[v] for v in "bcd"] == [1, 0, 0]


def test_only_what_rows_read_is_relevant():
    text = """
    model M
      Real x(start=0, fixed=true); Boolean b; Integer n(start=0);
    equation
      der(x) = if x > 1 then -1 else 1;
      b = x > 2;
      when b then n = pre(n) + 1; end when;
    end M;
    """
    hybrid = hybrid_of(lowered(text))
    first, second = (int(r.family.rows[0]) for r in hybrid.relations)
    assert np.flatnonzero(hybrid.relevant).tolist() == [first]
    assert second != first


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 3)), min_size=1, max_size=30))
def test_unique_columns_keep_the_order_of_first_appearance(columns):
    first, inverse = unique_columns(np.array(columns, np.int64).T)
    seen = list(dict.fromkeys(columns))
    assert [columns[k] for k in first] == seen
    assert [seen[k] for k in inverse] == columns


def test_columns_without_rows_are_equal():
    first, inverse = unique_columns(np.zeros((0, 4), np.int64))
    assert first.tolist() == [0]
    assert inverse.tolist() == [0, 0, 0, 0]
