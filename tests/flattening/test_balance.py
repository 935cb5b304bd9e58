"""The count of equations and unknowns of a class, and what its message says."""

from __future__ import annotations

import pytest

from acausal.diagnostics import AcausalError
from acausal.flattening.open_inputs import refuse_open_inputs
from tests.flattening.static import flat, refused

PIN = (
    "connector Pin Real v; flow Real i; end Pin; "
    "connector In = input Real; connector Out = output Real;\n"
)


@pytest.mark.parametrize(
    "text",
    [
        "model M Real x; Real y; equation x = 1; y = x; end M;",
        "model M Real x[3]; equation for i in 1:3 loop x[i] = i; end for; end M;",
        "model A Pin p, n; equation p.i + n.i = 0; p.v = n.v; end A; model M A a; end M;",
        (
            "model A In u; Out y; equation y = 2*u; end A; "
            "model M A a, b; equation connect(a.y, b.u); a.u = 1; end M;"
        ),
        "model A input Real u; Real y = u; end A; model M A a(u = 3); end M;",
        "record R Real a; Real b = 2; end R; model A R r(a = 1); end A; model M A x; end M;",
        "model A Real x = 1; end A; model M A a(x = 2); end M;",
    ],
)
def test_balanced(text):
    flat(PIN + text)


@pytest.mark.parametrize(
    ("text", "code", "rows", "unknowns"),
    [
        ("model M Real x; Real y; equation x = 1; end M;", "B101", 1, 2),
        ("model M Real x; equation x = 1; x = 2; end M;", "B102", 2, 1),
        ("model A Pin p, n; equation p.i + n.i = 0; end A; model M A a; end M;", "B101", 1, 2),
        ("model A Pin p; equation p.i = 0; p.v = 0; end A; model M A a; end M;", "B102", 2, 1),
        ("model A In u; Out y; equation y = 2*u; u = 1; end A; model M A a; end M;", "B102", 2, 1),
        ("model M Real x[4]; equation for i in 2:4 loop x[i] = i; end for; end M;", "B101", 3, 4),
    ],
)
def test_unbalanced_classes_are_counted(text, code, rows, unknowns):
    message = refused(PIN + text)
    assert message.code == code
    assert f"{rows} equations for {unknowns} unknowns" in message.message
    assert message.span is not None
    assert f"{abs(rows - unknowns)} too" in message.label


def test_the_class_is_named_not_the_model():
    message = refused(PIN + "model Bad Real x; end Bad; model M Bad a; Real y = 1; end M;")
    assert message.message.startswith("Bad ")


def test_equations_that_say_nothing_or_cannot_hold():
    assert refused("model M Real x; equation x = x; end M;").code == "B103"
    assert refused("model M Real x; equation 1 = 2; end M;").code == "B104"


GAIN = PIN + (
    "model Gain In u; Out y; equation y = 2*u; end Gain; "
    "model Source Out y; equation y = 3; end Source; "
)


@pytest.mark.parametrize(
    ("text", "path"),
    [
        ("model M In u; Real x = u; end M;", "u"),
        ("model M input Real u; Real x = u; end M;", "u"),
        ("model M Gain g; end M;", "g.u"),
        ("model M Gain g[3]; Source s; equation connect(s.y, g[1].u); end M;", "g[2].u"),
        ("model B Gain g; end B; model M B b; end M;", "b.g.u"),
    ],
)
def test_open_inputs_are_named_in_the_model_of_the_user(text, path):
    with pytest.raises(AcausalError) as caught:
        refuse_open_inputs(flat(GAIN + text))
    message = caught.value.diagnostics[0]
    assert message.code == "B101"
    assert f"the input {path} " in message.message
    assert message.span is not None and message.label


@pytest.mark.parametrize(
    "text",
    [
        "model M Gain g(u = 3); end M;",
        "model M Gain g; equation g.u = time; end M;",
        "model B Gain g; In u; equation connect(u, g.u); end B; "
        "model M B b; Source s; equation connect(s.y, b.u); end M;",
    ],
)
def test_inputs_may_be_given_in_any_way(text):
    refuse_open_inputs(flat(GAIN + text))


def test_missing_equations_are_not_blamed_on_inputs_that_have_a_value():
    # The search for singular equations says what is missing.
    text = "model M Gain g; Source s; Real x; equation connect(s.y, g.u); end M;"
    refuse_open_inputs(flat(GAIN + text))
