"""What the elimination makes of the hybrid part: aliases, signs, definitions."""

from __future__ import annotations

import numpy as np

from acausal.elimination.eliminate import eliminate
from acausal.expressions.nodes import slot
from tests.events.lowered import lowered, values_of

STOP = """
connector Flange
  Real s; through Real f;
end Flange;
model Mass
  parameter Real m = 2; Flange a; Flange b; Real s; Real v; Real w;
equation
  a.s = s; b.s = s; v = der(s); w = -v; m*der(v) = a.f + b.f;
end Mass;
model Wall
  Flange a; Boolean hit;
equation
  a.f = if hit then 1e3*a.s else 0;
  hit = a.s < 0;
end Wall;
model M
  Mass mass; Wall wall;
equation
  connect(mass.b, wall.a);
  when wall.hit then
    reinit(mass.w, -0.5*pre(mass.w));
  end when;
end M;
"""


def test_a_reinit_of_a_negated_alias_acts_on_who_stands_for_it():
    model = lowered(STOP)
    elimination = eliminate(model)
    hybrid = elimination.model.hybrid
    assert hybrid is not None
    names = model.names
    w = names.find_variables("mass.w")[0][1]
    reinits = hybrid.reinits
    assert reinits.wanted.tolist() == [w]
    assert reinits.states.tolist() == [elimination.representative[w]]
    assert reinits.signs.tolist() == [elimination.sign[w]]
    assert elimination.active[reinits.states].all()
    # Whatever the signs, w = -0.5 pre(w) has to come out.
    values = np.zeros(model.variables.count)
    values[reinits.states] = elimination.sign[w] * 3.0
    parameters = model.parameters.copy()
    parameters[parameters == 0] = 0.0
    for family in hybrid.limits:
        limit = values_of(family, values, parameters, 0.0)
        parameters[hybrid.first + family.rows] = limit
        assert limit.tolist() == [3.0]
    (value,) = (values_of(f, values, parameters, 0.0)[0] for f in reinits.values)
    assert reinits.signs[0] * value * elimination.sign[w] == -1.5


def test_everything_that_is_carried_refers_to_active_variables():
    elimination = eliminate(lowered(STOP))
    hybrid = elimination.model.hybrid
    assert hybrid is not None
    families = [
        *elimination.model.families, *hybrid.limits, *hybrid.assignments, *hybrid.reinits.values,
        *hybrid.reinits.fires, *(r.family for r in hybrid.relations),
    ]  # fmt: skip
    for family in families:
        for kind, ids in zip(family.kinds, family.operands, strict=True):
            assert kind or elimination.active[ids].all()
    assert not elimination.active[hybrid.place >= 0].any()


def test_a_dependency_through_a_continuous_variable_is_put_in_order():
    """The gain's output is continuous and eliminated: the second block reads the first at once."""
    text = """
    connector RealInput = input Real;
    connector RealOutput = output Real;
    model Count
      RealInput u; RealOutput y;
    equation
      when time > 1 then y = u; end when;
    end Count;
    model Gain RealInput u; RealOutput y; equation y = 2*u; end Gain;
    model M
      Count b; Gain g; Count a;
    equation
      a.u = 3;
      connect(a.y, g.u); connect(g.y, b.u);
    end M;
    """
    model = lowered(text)
    hybrid = eliminate(model).model.hybrid
    assert hybrid is not None
    order = np.concatenate([f.rows for f in hybrid.assignments]).tolist()
    first, second = (
        int(hybrid.place[model.names.find_variables(f"{name}.y")[0][1]]) for name in "ab"
    )
    assert order.index(first) < order.index(second)
    assert not hybrid.relevant.any()


def test_the_variable_that_carries_an_impulse_stays():
    text = STOP.replace("reinit(mass.w, -0.5*pre(mass.w))", "reinit(mass.v, 1, wall.a.f)")
    model = lowered(text)
    elimination = eliminate(model)
    hybrid = elimination.model.hybrid
    assert hybrid is not None
    f = model.names.find_variables("wall.a.f")[0][1]
    reinits = hybrid.reinits
    assert reinits.impulses.tolist() == [elimination.representative[f]]
    assert reinits.impulse_signs.tolist() == [elimination.sign[f]]
    assert elimination.active[reinits.impulses].all()


def test_a_relation_on_a_definition_watches_what_defines_it():
    model = lowered("""
    model M
      Real u; Real x(start = 0, fixed = true);
    equation
      u = 2*time - 1; der(x) = if u > 0 then 1 else 0;
    end M;
    """)
    hybrid = eliminate(model).model.hybrid
    assert hybrid is not None
    (relation,) = hybrid.relations
    assert not relation.family.kinds
    assert slot(0) is not relation.family.template
