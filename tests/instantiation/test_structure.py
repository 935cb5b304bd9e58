"""Structural parameters, conditional components, if equations, inclusion without end."""

from __future__ import annotations

import pytest

from acausal.instantiation.instantiate import instantiate
from acausal.modeling.load import choose_model, load_text
from tests.flattening.static import flat, parameters, refused, solve

PIN = (
    "connector Pin Real v; flow Real i; end Pin;\n"
    "model R Pin p, n; parameter Real R = 1; equation p.v - n.v = R*p.i; p.i + n.i = 0; end R;\n"
    "model V Pin p, n; parameter Real V = 10; equation p.v - n.v = V; p.i + n.i = 0; end V;\n"
    "model G Pin p; equation p.v = 0; end G;\n"
)
SIZED = (
    "model A parameter Integer n = 3; Real x[n]; "
    "equation for i in 1:n loop x[i] = i*n; end for; end A;\n"
)


def test_structural_parameters_follow_modifiers_and_each_other():
    text = SIZED + (
        "model M parameter Integer m = 2; A a(n = m); A b(n = 2*m + 1); A c[2](each n = m); end M;"
    )
    found = solve(text)
    assert sum(p.startswith("a.x") for p in found) == 2
    assert found["b.x[5]"] == pytest.approx(25.0)
    assert found["c[2].x[2]"] == pytest.approx(4.0)
    assert "b.x[4]" not in solve(text, given={"m": 1})


def test_structural_parameters_from_outside():
    assert len(solve(SIZED + "model M A a; end M;", given={"a.n": 2})) == 2
    assert refused(SIZED + "model M A a; end M;", given={"a.n": 2.5}).code == "T115"


def test_an_array_of_components_has_one_structure():
    assert refused(SIZED + "model M A c[2](n = {1, 2}); end M;").code == "T116"
    assert len(solve(SIZED + "model M A c[2](n = {2, 2}); end M;")) == 4


def test_equal_structures_share_a_template():
    classes, _ = load_text(SIZED + "model M A a, b, c(n = 4), d(n = 4), e[7](each n = 4); end M;")
    templates, _ = instantiate(choose_model(classes, None, ""), {})
    assert sum(t.name == "A" for t in templates) == 2


def test_real_parameters_make_no_templates():
    text = PIN + "model M R r[3](R = {1, 2, 3}); R a(R = 4); R b(R = 5); end M;"
    classes, _ = load_text(text)
    templates, _ = instantiate(choose_model(classes, None, ""), {})
    assert [t.name for t in templates].count("R") == 1


def test_open_sizes_come_from_the_value():
    found = parameters(
        "model A parameter Real t[:] = {1, 2}; parameter Integer n = size(t, 1); "
        "parameter Real s = sum(t); end A; "
        "model M A a(t = {1, 2, 3}); A b; parameter Real q[:] = {5, 6, 7, 8}; A c(t = q); end M;"
    )
    assert [found[f"{n}.s"] for n in "abc"] == [6.0, 3.0, 26.0]


def test_sizes_must_be_known():
    real = "model A parameter Real r = 3; Real x[integer(r)]; end A;"
    assert refused(real).code == "T103"
    assert refused("model M Real x[-1]; end M;").code == "T122"
    assert refused("model M parameter Integer n; Real x[n]; end M;").code == "N112"
    assert (
        refused("model M parameter Integer a = b; parameter Integer b = a; end M;").code == "N117"
    )


# --- conditional components --------------------------------------------------------------


CHOICE = PIN + (
    "model M parameter Boolean on = true; R a(R = 2) if on; R b(R = 5) if not on; V v; G g; "
    "equation connect(v.p, a.p, b.p); connect(v.n, a.n, b.n, g.p); end M;"
)


@pytest.mark.parametrize(("on", "current"), [(1.0, 5.0), (0.0, 2.0)])
def test_connections_of_absent_components_vanish(on, current):
    assert solve(CHOICE, given={"on": on})["v.n.i"] == pytest.approx(current)


def test_absent_components_cannot_be_used():
    message = refused(PIN + "model M R r if false; Real x = r.R; end M;")
    assert message.code == "N114"


def test_conditions_must_be_known():
    assert refused(PIN + "model M R r if time > 1; end M;").code == "T103"


def test_if_equations_decided_before_the_simulation():
    text = (
        "model A parameter Boolean b = true; Real x; Real y; equation "
        "if b then x = 1; y = 2; else x = 2; end if; if not b then y = 3; end if; end A; "
        "model M A a; A d(b = false); end M;"
    )
    found = solve(text)
    assert [found[p] for p in ("a.x", "a.y", "d.x", "d.y")] == pytest.approx([1, 2, 2, 3])


def test_if_equations_decided_during_the_simulation_need_equal_branches():
    text = "model M Real x = time; Real y; equation if x > 1 then y = 2*x; {} end if; end M;"
    assert solve(text.format("else y = -x;"), time=3.0)["y"] == pytest.approx(6.0)
    assert solve(text.format("else y = -x;"), time=0.5)["y"] == pytest.approx(-0.5)
    assert refused(text.format("")).code == "B105"


def test_connections_under_a_condition():
    text = PIN + (
        "model M parameter Boolean h = false; V v; R r; G g; equation connect(v.n, g.p, r.n); "
        "if h then connect(v.p, r.p); end if; end M;"
    )
    assert solve(text)["v.n.i"] == pytest.approx(0.0)
    assert solve(text, given={"h": 1.0})["v.n.i"] == pytest.approx(10.0)
    changing = text.replace("if h then", "if time > 1 then")
    assert refused(changing).code == "C105"


def test_text_parameters_choose():
    text = (
        'model A parameter String s = "a"; Real x = if s == "a" then 1 else 2; end A; '
        'model M A a; A b(s = "q"); end M;'
    )
    found = solve(text)
    assert (found["a.x"], found["b.x"]) == pytest.approx((1.0, 2.0))


def test_a_class_must_not_contain_itself_without_end():
    assert refused("model A A a; end A;").code == "N106"
    ending = "model A parameter Integer n = 3; A a(n = n - 1) if n > 1; Real x = n; end A;"
    assert solve(ending)["a.a.x"] == pytest.approx(1.0)


def test_declarations_may_stand_in_any_order():
    text = (
        "model M Real y[k] = ones(k); A a(n = k); parameter Integer k = 2*j; "
        "parameter Integer j = 1; end M;"
    )
    assert len(solve(SIZED + text)) == 4


def test_a_long_array_is_one_template():
    flattened = flat(SIZED + "model M parameter Integer n = 5000; A a[n](each n = 2); end M;")
    assert len(flattened.model.families) == 1
    assert flattened.model.n_rows == 10_000


def test_sizes_of_arrays_of_components():
    found = solve(
        "model A Real y = 5; end A; model B A a[2,3]; end B; "
        "model M A a[4]; B b[5]; Real n = size(a, 1); "
        "Real m = size(b.a, 3); Real k = size(b[2].a, 1); "
        "Real s = sum(a[i].y for i in 1:size(a, 1)); Real last = a[end].y; end M;"
    )
    assert [found[n] for n in ("n", "m", "k", "s", "last")] == pytest.approx([4, 3, 2, 20, 5])


def test_members_of_nested_arrays_of_components():
    found = solve(
        "model A Real x[3] = {1, 2, 3}; Real y = 5; end A; model B A a[2](y = {7, 8}); end B; "
        "model M B b[3]; Real s = sum(b.a.y); Real t = b[2].a[1].x[3]; Real u[3,2] = b.a.y; "
        "Real v[2] = b[1].a.x[2]; Real w[3,2,3] = b.a.x; Real z[2] = b[2:3].a[2].y; end M;"
    )
    assert [found[n] for n in ("s", "t", "u[3,2]", "v[2]", "w[3,2,1]", "z[1]")] == pytest.approx(
        [45, 3, 8, 2, 1, 8]
    )
