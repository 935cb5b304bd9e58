"""Extends and modifiers: which value wins, and in which scope it is read."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.flattening.static import flat, parameters, refused, solve

A = "model A parameter Real p = 1; parameter Real q = 2*p; end A;\n"


def test_the_outermost_modifier_wins():
    found = parameters(
        A + "model B extends A(p = 3); end B; model C B b(p = 5); end C; "
        "model D extends C(b(p = 7)); end D;"
    )
    assert found == {"b.p": 7.0, "b.q": 14.0}


def test_what_is_not_modified_keeps_the_nearest_value():
    found = parameters(
        A + "model B extends A(p = 3); end B; model C extends B; end C; "
        "model M A a; B b; C c; C d(p = 9); end M;"
    )
    assert [found[f"{n}.p"] for n in "abcd"] == [1.0, 3.0, 3.0, 9.0]


def test_a_modifier_is_read_where_it_is_written():
    found = parameters(
        A + "model B parameter Real k = 4; extends A(p = 2*k); end B; "
        "model M parameter Real k = 100; B b; B c(k = 5); B d(p = k); end M;"
    )
    assert (found["b.p"], found["c.p"], found["d.p"]) == (8.0, 10.0, 100.0)


def test_each_gives_all_elements_one_value_and_arrays_give_each_their_own():
    found = parameters(
        A + "model M A a[3](each p = 5); A b[2](p = {1, 2}); "
        "A c[2](p = {10*i for i in 1:2}); end M;"
    )
    assert [found[f"a[{k}].p"] for k in (1, 2, 3)] == [5.0] * 3
    assert [found[f"{n}[{k}].p"] for n in "bc" for k in (1, 2)] == [1.0, 2.0, 10.0, 20.0]


def test_nested_arrays_of_components():
    found = parameters(
        A + "model B A a[2](p = {3, 4}); end B; model M B b[3]; B c[3](a(each p = 7)); "
        "B d[2](a(p = {{1, 2}, {3, 4}})); B e[2](each a(p = {5, 6})); end M;"
    )
    assert [found[f"b[{k}].a[{i}].p"] for k in (1, 2, 3) for i in (1, 2)] == [3.0, 4.0] * 3
    assert {found[f"c[{k}].a[{i}].p"] for k in (1, 2, 3) for i in (1, 2)} == {7.0}
    assert [found[f"d[{k}].a[{i}].p"] for k in (1, 2) for i in (1, 2)] == [1.0, 2.0, 3.0, 4.0]
    assert [found[f"e[{k}].a[{i}].p"] for k in (1, 2) for i in (1, 2)] == [5.0, 6.0] * 2


def test_one_value_for_many_needs_each():
    message = refused(A + "model M A a[3](p = 5); end M;")
    assert message.code == "T118"
    assert "each" in message.help


@pytest.mark.parametrize(
    "text",
    [
        "model A final parameter Real p = 1; end A; model M A a(p = 5); end M;",
        "model A parameter Real p = 1; end A; model B A a(final p = 2); end B; "
        "model M B b(a(p = 5)); end M;",
        "model A parameter Real p = 1; end A; model B extends A(final p = 2); end B; "
        "model M B b(p = 5); end M;",
        "model A parameter Real p(final min = 0) = 1; end A; model M A a(p(min = 5)); end M;",
        "model A final parameter Real p = 1; end A; model M extends A(p = 5); end M;",
    ],
)
def test_final_values_cannot_be_modified(text):
    assert refused(text).code == "N109"


def test_attributes_of_nested_components():
    flattened = flat(
        "model A Real x(start = 1); equation der(x) = -x; end A; model B A a(x(start = 2)); end B; "
        "model M B b(a(x(start = 3))); B c; A d[2](x(start = {5, 6})); A e[2](each x(start = 8)); "
        "end M;"
    )
    names, start = flattened.model.names, flattened.model.variables.start
    patterns = ("*.a.x", "d.x", "e.x")
    found = {p: start[i] for pattern in patterns for p, i in names.find_variables(pattern)}
    assert found == {
        "b.a.x": 3.0, "c.a.x": 2.0, "d[1].x": 5.0, "d[2].x": 6.0, "e[1].x": 8.0, "e[2].x": 8.0,
    }  # fmt: skip


def test_the_declaration_equation_of_a_variable_can_be_replaced():
    found = solve(
        "model A Real x = 1; Real y = 2*x; end A; "
        "model M A a; A b(x = 5); A c(x = a.y); A d[2](x = {7, 8}); end M;"
    )
    assert [found[f"{n}.y"] for n in ("a", "b", "c", "d[1]", "d[2]")] == pytest.approx(
        [2.0, 10.0, 4.0, 14.0, 16.0]
    )


def test_a_short_class_with_a_modifier():
    found = solve(
        "model A Real x = 1; Real y = 2*x; end A; model Big = A(x = 8); "
        "model M Big b; Big c(x = 7); end M;"
    )
    assert (found["b.y"], found["c.y"]) == pytest.approx((16.0, 14.0))


def test_what_comes_over_two_ways_is_there_once():
    found = solve(
        "model A parameter Real p = 1; Real x; equation x = p; end A; model B extends A; end B; "
        "model C extends A; Real y = x; end C; model D extends B; extends C; end D;"
    )
    assert found == pytest.approx({"x": 1.0, "y": 1.0})


def test_two_ways_must_agree():
    assert (
        refused(
            A + "model B extends A(p = 2); end B; model C extends A(p = 3); end C; "
            "model D extends B; extends C; end D;"
        ).code
        == "N105"
    )


def test_a_declaration_may_be_repeated_but_not_changed():
    assert parameters(A + "model B extends A; parameter Real p = 1; end B;")["p"] == 1.0
    assert refused(A + "model B extends A; parameter Real p = 2; end B;").code == "N105"
    same = "model B parameter Real p = 1; end B; model C extends A; extends B; end C;"
    assert parameters(A + same)["p"] == 1.0
    other = "model B parameter Real p = 9; end B; model C extends A; extends B; end C;"
    assert refused(A + other).code == "N105"


@pytest.mark.parametrize(
    ("modifier", "code"),
    [("pp = 1", "N103"), ("p(strat = 1)", "N103"), ("p = 1, p = 2", "N105"), ('p = "x"', "T101")],
)
def test_wrong_modifiers(modifier, code):
    assert refused(A + f"model M A a({modifier}); end M;").code == code


def test_partial_classes_cannot_be_components():
    assert refused("partial model A Real x = 1; end A; model M A a; end M;").code == "N111"


LEVEL = st.tuples(
    st.sampled_from(["extends", "component", "array"]), st.none() | st.integers(0, 99)
)


@given(st.lists(LEVEL, min_size=1, max_size=6))
@settings(max_examples=60, deadline=None)
def test_the_outermost_of_any_levels_wins(levels):
    """Each class extends or contains the one before, and may modify ``p`` at its far end."""
    text = "model L0 parameter Real p = -1; end L0;\n"
    path: list[str] = []  # names from the class to p, without subscripts
    expected = -1.0
    full = "p"
    for k, (kind, value) in enumerate(levels, 1):
        modifier = f"p = {value}"
        for name in reversed(path):
            modifier = f"{name}({'each ' if name.startswith('a') else ''}{modifier})"
        if kind == "array" and value is not None:
            modifier = f"each {modifier}"
        own = "" if value is None else f"({modifier})"
        if kind == "extends":
            text += f"model L{k} extends L{k - 1}{own}; end L{k};\n"
        elif kind == "component":
            text += f"model L{k} L{k - 1} c{k}{own}; end L{k};\n"
            path.insert(0, f"c{k}")
            full = f"c{k}.{full}"
        else:
            text += f"model L{k} L{k - 1} a{k}[2]{own}; end L{k};\n"
            path.insert(0, f"a{k}")
            full = f"a{k}[2].{full}"
        if value is not None:
            expected = float(value)
    assert parameters(text)[full] == expected
