"""Discrete variables: who defines them, in which order, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from acausal.flattening.model import Operand
from tests.events.lowered import State, hybrid_of, lowered, refused, values_of

BLOCKS = """
connector BooleanInput = input Boolean;
connector BooleanOutput = output Boolean;
connector RealInput = input Real;
connector RealOutput = output Real;
model Not BooleanInput u; BooleanOutput y; equation y = not u; end Not;
model And BooleanInput u[2]; BooleanOutput y; equation y = u[1] and u[2]; end And;
model Step parameter Real t0 = 1; BooleanOutput y; equation y = time >= t0; end Step;
model Gain parameter Real k = 2; RealInput u; RealOutput y; equation y = k*u; end Gain;
model Ramp RealOutput y; equation y = time; end Ramp;
model Hold
  parameter Real T = 0.1; RealInput u; RealOutput y;
equation
  when sample(0, T) then y = u; end when;
end Hold;
model Row
  parameter Integer n = 3; BooleanInput u[n]; BooleanOutput y[n]; Not no[n];
equation
  connect(u, no.u); connect(no.y, y);
end Row;
"""


def test_boolean_connectors_share_places_and_make_no_rows():
    state = State(lowered(BLOCKS + """
    model M
      Step s[3](t0 = {1, 2, 3}); Row a; Row b; Not last; And both;
    equation
      connect(s.y, a.u); connect(a.y, b.u); connect(b.y[2], last.u);
      connect(b.y[1], both.u[1]); connect(last.y, both.u[2]);
    end M;
    """))  # fmt: skip
    assert state.model.n_rows == 0
    assert state.hybrid.n_discrete == 3 + 3 + 3 + 1 + 1
    assert state.place("s[2].y") == state.place("a.u[2]") == state.place("a.no[2].u")
    for time in (0.5, 1.5, 2.5, 3.5):
        state.settle(time)
        steps = [time >= t for t in (1, 2, 3)]
        assert [state[f"b.y[{k}]"] for k in (1, 2, 3)] == steps
        assert state["both.y"] == (steps[0] and not steps[1])


def test_whether_a_real_is_discrete_depends_on_the_instance():
    model = lowered(BLOCKS + """
    model M
      Ramp r; Gain g; Gain h; Hold hold[2];
    equation
      connect(r.y, g.u); connect(g.y, hold[1].u); connect(hold[1].y, h.u);
      connect(h.y, hold[2].u);
    end M;
    """)  # fmt: skip
    hybrid = hybrid_of(model)
    held = {model.names.variable(int(i)) for i in np.flatnonzero(hybrid.place >= 0)}
    assert held == {"hold[1].y", "hold[2].y"}
    assert hybrid.sample_interval.tolist() == [0.1, 0.1]


def test_a_long_row_of_gates_is_put_in_order():
    n = 40
    state = State(
        lowered(f"""
    model M
      Boolean b[{n}];
    equation
      for i in 1:{n - 1} loop b[i] = not b[i + 1]; end for;
      b[{n}] = time > 1;
    end M;
    """)
    )
    for time in (0.0, 2.0):
        state.settle(time)
        assert state["b[1]"] == float((time > 1) == (n % 2 == 1))


def test_a_when_fires_once_and_keeps_its_value():
    state = State(
        lowered("""
    model M
      Real x(start = 0, fixed = true); Integer n(start = 3); discrete Real v(start = 7);
    equation
      der(x) = 1;
      when x > 0.5 then
        n = pre(n) + 1; v = x;
      elsewhen x < -0.5 then
        n = pre(n) - 1; v = pre(v);
      end when;
    end M;
    """)
    )
    seen = []
    for x in (0.0, 0.6, 0.7, 0.0, -0.6, -0.7):
        state["x"] = x
        state.settle()
        seen.append((state["n"], state["v"]))
        state.forget()
    assert seen == [(3, 7), (4, 0.6), (4, 0.6), (4, 0.6), (3, 0.6), (3, 0.6)]


def test_a_when_in_a_loop_has_a_condition_for_each_pass_and_instance():
    state = State(
        lowered("""
    model A
      parameter Real t0 = 0; Integer n[2, 3]; Real x(start = 0, fixed = true);
    equation
      der(x) = 1;
      for i in 1:2 loop
        when x > t0 + i then
          for j in 1:3 loop n[i, j] = 10*i + j; end for;
        end when;
      end for;
    end A;
    model M A a[2](t0 = {0, 5}); end M;
    """)
    )
    assert len(state.hybrid.conditions) == 4
    state["a[1].x"], state["a[2].x"] = 2.5, 6.5
    state.settle()
    values = [[state[f"a[{k}].n[{i},{j}]"] for i in (1, 2) for j in (1, 2, 3)] for k in (1, 2)]
    assert values == [[11, 12, 13, 21, 22, 23], [11, 12, 13, 0, 0, 0]]


def test_the_value_before_of_a_continuous_variable_is_a_limit():
    state = State(
        lowered("""
    model M
      Real x(start = 1, fixed = true); Real y;
    equation
      der(x) = -x;
      when time > 1 then y = pre(x); end when;
    end M;
    """)
    )
    (limit,) = state.hybrid.limits
    assert limit.operands.tolist() == [[state.find("x")]]
    assert state.hybrid.place[state.find("y")] >= 0


def test_initial_equations_replace_assignments_at_the_start():
    hybrid = hybrid_of(
        lowered("""
    model M
      Boolean b(start = false); Integer n; Boolean c;
    equation
      when time > 1 then b = not pre(b); end when;
      when time > 2 then n = 3; end when;
      c = b;
    initial equation
      b = true; pre(n) = 5;
    end M;
    """)
    )
    assert sum(f.count for f in hybrid.initial) == sum(f.count for f in hybrid.assignments)
    constant = [f for f in hybrid.initial if f.template.op == "const"]
    assert [f.rows.tolist() for f in constant] == [[int(hybrid.place[0])]]
    (before,) = hybrid.initial_pre
    assert before.rows.tolist() == [hybrid.n_discrete + int(hybrid.place[1])]


def test_initial_equations_of_discrete_variables_of_components_are_assignments():
    model = lowered(BLOCKS + """
    model M
      Hold h; Hold g; Real z;
    equation
      h.u = time; g.u = z; der(z) = h.y;
    initial equation
      2*h.y = 3; z = 1; pre(g.y) = 4;
    end M;
    """)  # fmt: skip
    assert model.n_initial == 1
    (row,) = model.initial
    assert row.rows.tolist() == [0]
    state = State(model)
    hybrid = state.hybrid
    for family in (*hybrid.initial, *hybrid.initial_pre):
        new = values_of(family, state.variables, state.parameters, 0.0)
        state.parameters[hybrid.first + family.rows] = new
    assert state["h.y"] == 1.5
    assert state.held(hybrid.n_discrete + state.place("g.y")) == 4.0


def test_start_values_are_those_of_the_variable_that_an_equation_defines():
    model = lowered("""
    type Color = enumeration(red, green, blue);
    model M
      Integer n(start = 4); Boolean b; Color c; Color d(start = Color.blue);
    equation
      when time > 1 then n = 1; b = true; c = Color.green; d = Color.red; end when;
    end M;
    """)
    state = State(model)
    assert [state[v] for v in "nbcd"] == [4, 0, 1, 3]
    n = state.hybrid.n_discrete
    assert state.held(n + state.place("d")) == 3.0
    assert not model.variables.fixed.any()


def test_every_place_is_assigned_once_and_operands_are_plain():
    hybrid = hybrid_of(lowered(BLOCKS + """
    model M
      Step s; Not n; Boolean b; Real x(start = 0, fixed = true);
    equation
      connect(s.y, n.u);
      der(x) = if n.y then 1 else -1;
      when {n.y, x > 2, initial()} then b = x > 1; end when;
    end M;
    """))  # fmt: skip
    rows = np.concatenate([f.rows for f in hybrid.assignments])
    assert np.array_equal(np.sort(rows), np.arange(hybrid.n_discrete))
    for family in (*hybrid.assignments, *hybrid.limits, *(r.family for r in hybrid.relations)):
        assert set(family.kinds) <= {Operand.VARIABLE, Operand.PARAMETER}


@pytest.mark.parametrize(
    ("code", "words", "body"),
    [
        ("E020", ["a"], "Boolean a; Boolean b; equation a = b; b = a;"),
        ("E021", ["s.y"], "Step s; equation when time > 1 then s.y = true; end when;"),
        ("E022", ["a", "b"], "Boolean a; Boolean b; equation a = not b; b = a and time > 1;"),
        ("E023", ["der(h.y)"], "Hold h; Real x; equation h.u = time; x = der(h.y);"),
        ("E025", ["-1 s"], "Hold h(T = -1); equation h.u = time;"),
    ],
)
def test_what_is_refused(code, words, body):
    found = refused(BLOCKS + f"model M {body} end M;")
    assert found.code == code, found
    assert [w for w in words if w not in found.message] == []
    assert found.span is not None


def test_an_input_that_is_left_open_has_a_name():
    found = refused(BLOCKS + "model M Step s; And both; equation connect(s.y, both.u[1]); end M;")
    assert found.code == "E020"
    assert "both.u[2]" in found.message


def test_two_sources_on_one_input():
    found = refused(BLOCKS + """
    model M Step s; Step t; Not n; equation connect(s.y, n.u); connect(t.y, n.u); end M;
    """)  # fmt: skip
    assert found.code == "E021"
    assert "s.y" in found.message
    assert "t.y" in found.message
