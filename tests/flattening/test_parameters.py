"""Values of parameters: chains, arrays, values from outside, what cannot be computed."""

from __future__ import annotations

import pytest

from tests.flattening.static import flat, parameters, refused


def test_chains_in_any_order():
    found = parameters(
        "model M parameter Real a = b + 1; parameter Real b = c*2; parameter Real c = 3; "
        "parameter Real d[3] = {a, b, c}; parameter Real e[3] = 2*d; "
        "parameter Real f = e[2] + sum(d); end M;"
    )
    assert (found["a"], found["e[2]"], found["f"]) == (7.0, 12.0, 28.0)


def test_an_array_may_depend_on_its_own_elements():
    found = parameters(
        "model M parameter Integer n = 6; "
        "parameter Real a[n] = {if i == 1 then 1 else a[i-1]*2 for i in 1:n}; end M;"
    )
    assert found["a[6]"] == 32.0


def test_values_that_differ_between_instances():
    found = parameters(
        "model A parameter Real p = 1; parameter Real q = p^2; end A; "
        "model M parameter Real k = 2; A a[3](p = {i*k for i in 1:3}); end M;"
    )
    assert [found[f"a[{k}].q"] for k in (1, 2, 3)] == [4.0, 16.0, 36.0]


def test_values_from_outside_win_over_everything():
    text = (
        "model A parameter Real p = 1; parameter Real q = p; end A; "
        "model M A a(p = 5); A b[2]; end M;"
    )
    assert parameters(text, given={"a.p": 9})["a.q"] == 9.0
    found = parameters(text, given={"b[*].p": 7, "b[2].q": 3})
    assert (found["b[1].q"], found["b[2].p"], found["b[2].q"]) == (7.0, 7.0, 3.0)


def test_misspelt_values_from_outside():
    text = "model A parameter Real pressure = 1; end A; model M A a; end M;"
    message = refused(text, given={"a.presure": 1})
    assert message.code == "N119"
    assert "a.pressure" in " ".join(message.notes)
    assert refused(text, given={"b.pressure": 1}).code == "N119"


def test_the_start_value_stands_in_with_a_warning():
    flattened = flat("model M parameter Real a(start = 4); parameter Real b = a; end M;")
    assert flattened.model.parameters.tolist() == [4.0, 4.0]
    assert [w.code for w in flattened.model.warnings] == ["N120"]


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ("parameter Real a = b; parameter Real b = a;", "N117"),
        ("parameter Real a[2] = {a[2], a[1]};", "N117"),
        ("parameter Real a;", "N112"),
        ("parameter Real a = x; Real x = 1;", "T134"),
        ("parameter Real a = 0; parameter Real b = a/a;", "I010"),
        ("parameter Real a(fixed = false, start = 1);", "E004"),
    ],
)
def test_values_that_cannot_be_computed(body, code):
    assert refused(f"model M {body} end M;").code == code


def test_attributes_follow_parameters():
    variables = flat(
        (
            "model M parameter Real p = 3; "
            "Real x(start = 2*p, nominal = p); equation der(x) = -x; end M;"
        ),
        given={"p": 5},
    ).model.variables
    assert (variables.start[0], variables.nominal[0]) == (10.0, 5.0)


def test_equal_numbers_of_a_loop_are_constants_and_others_are_not():
    same = flat("model M Real x[3]; equation for i in 1:3 loop x[i] = 2*3; end for; end M;")
    other = flat("model M Real x[3]; equation for i in 1:3 loop x[i] = 2*i; end for; end M;")
    assert same.model.parameters.tolist() == []
    assert other.model.parameters.tolist() == [2.0, 4.0, 6.0]
