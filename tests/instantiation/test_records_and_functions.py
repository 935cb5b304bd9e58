"""Records as a whole and field by field; functions run where they are called."""

from __future__ import annotations

import pytest

from tests.flattening.static import parameters, refused, solve

Z = "record Z Real a = 2; Real b = 3; end Z;\n"


def values(text: str, *paths: str, **options) -> list[float]:
    found = solve(text, **options)
    return [round(found[p], 9) for p in paths]


# --- records -------------------------------------------------------------------------------


def test_fields_whole_values_and_equations_between_records():
    assert values(
        "record C Real re; Real im; end C; model M C z(re = 1, im = 2); C w; C u = C(3, 4); "
        "parameter C q = C(re = 5, im = 6); C s; equation w = z; s.re = q.re; s.im = u.im; end M;",
        "w.re", "w.im", "u.re", "u.im", "s.re", "s.im",
    ) == [1, 2, 3, 4, 5, 4]  # fmt: skip


@pytest.mark.parametrize(
    ("component", "expected"),
    [
        ("A x", (2, 3)),
        ("A x(z(a = 10))", (10, 3)),
        ("A x(z = Z(20, 30))", (20, 30)),
        ("A x(z(a = 1, b = 4))", (1, 4)),
        ("W x", (7, 8)),
        ("W x(z(a = 10))", (10, 8)),
        ("W x(z = Z(20, 30))", (20, 30)),
        ("E x", (10, 8)),
        ("E x(z = Z(5, 6))", (5, 6)),
        ("E x(z(b = 9))", (10, 9)),
    ],
)
def test_the_outermost_value_of_a_field_wins(component, expected):
    text = Z + (
        "model A Z z; end A; model W Z z = Z(7, 8); end W; model E extends W(z(a = 10)); end E; "
        f"model M {component}; end M;"
    )
    assert values(text, "x.z.a", "x.z.b") == list(expected)


def test_records_in_records():
    text = Z + (
        "record W Z z; Real c = 1; end W; model M W w; W v(z(a = 5)); W u = W(Z(7, 8), 9); "
        "W t(z = Z(1, 1)); end M;"
    )
    assert values(text, "w.z.a", "v.z.a", "v.z.b", "u.z.b", "u.c", "t.z.a", "t.c") == [
        2, 5, 3, 8, 9, 1, 1,
    ]  # fmt: skip


def test_defaults_of_a_constructed_record_follow_its_other_fields():
    found = parameters(
        "package P record B constant Real two = 2; parameter Real a = 1; "
        "parameter Real b = two*a; end B; end P; record C extends P.B(a = 5); end C; "
        "model M parameter P.B p = C(); parameter P.B q = C(a = 7); end M;"
    )
    assert (found["p.a"], found["p.b"], found["q.a"], found["q.b"]) == (5.0, 10.0, 7.0, 14.0)


def test_arrays_of_records():
    text = Z + "model M Z z[3](a = {1, 2, 3}); Real s = sum(z.a); Real t = z[2].a + z[3].b; end M;"
    assert values(text, "s", "t") == [6, 5]


def test_records_of_parameters_are_handed_on():
    found = parameters(
        "record D parameter Real Is = 1; parameter Real n = 2*Is; end D; "
        "model Diode parameter D data; parameter Real x = data.Is*data.n; end Diode; "
        "model M parameter D d(Is = 5); Diode a(data = d); Diode b(data = D(7, 8)); "
        "Diode c(data(n = 9)); Diode e[2](each data = d); end M;"
    )
    assert [found[f"{n}.x"] for n in ("a", "b", "c", "e[2]")] == [50.0, 56.0, 9.0, 50.0]


def test_inherited_fields():
    text = (
        "record A Real a = 1; end A; record B extends A; Real b = 2; end B; "
        "model M B b(a = 5); B c = B(3, 4); end M;"
    )
    assert values(text, "b.a", "b.b", "c.a", "c.b") == [5, 2, 3, 4]


def test_wrong_records():
    assert refused(Z + "model M Z z = Z(1, 2, 3); end M;").code == "T120"
    assert refused(Z + "model M Z z = Z(c = 2); end M;").code == "T120"
    assert refused(Z + "model M Z z; Real x = z.c; end M;").code == "N102"
    other = "record Y Real a; end Y; model M Z z; Y y(a = 1); equation z = y; end M;"
    assert refused(Z + other).code == "T132"


# --- functions -----------------------------------------------------------------------------


def call(body: str, expression: str, outputs: str = "output Real y;", time: float = 0.0) -> float:
    text = f"function f {outputs} {body} end f; model M Real x = {expression}; end M;"
    return round(solve(text, time=time)["x"], 9)


def test_arguments_by_position_and_by_name_with_defaults():
    body = "input Real a; input Real b = 5; algorithm y := 10*a + b;"
    assert [call(body, e) for e in ("f(1)", "f(1, 2)", "f(b = 3, a = 2)", "f(1, b = 7)")] == [
        15, 12, 23, 17,
    ]  # fmt: skip


def test_branches_on_a_variable_join():
    body = (
        "input Real a; algorithm if a > 1 then y := 10; elseif a > 0 then y := 5; "
        "else y := -a; end if; y := y + 1;"
    )
    assert [call(body, "f(time)", time=t) for t in (2.0, 0.5, -3.0)] == [11, 6, 4]


def test_loops_break_return_and_while():
    assert (
        call("input Integer n; algorithm y := 1; for i in 2:n loop y := y*i; end for;", "f(5)")
        == 120
    )
    stop = (
        "input Real v[:]; algorithm y := 0; for i in 1:size(v, 1) loop "
        "if v[i] > 2 then break; end if; y := i; end for;"
    )
    assert call(stop, "f({1, 2, 3, 4})") == 2
    leave = "input Real a; algorithm y := 1; if a > 0 then return; end if; y := 2;"
    assert [call(leave, e) for e in ("f(1)", "f(-1)")] == [1, 2]
    halve = (
        "input Integer n; protected Integer k; algorithm k := n; "
        "y := 0; while k > 1 loop k := div(k, 2); y := y + 1; end while;"
    )
    assert call(halve, "f(37)") == 5


def test_recursion():
    assert call("input Integer n; algorithm y := if n <= 1 then 1 else n*f(n - 1);", "f(6)") == 720
    message = refused(
        "function f input Real x; output Real y; algorithm y := f(x); end f; "
        "model M Real a = f(5); end M;"
    )
    assert message.code == "N106"


def test_arrays_in_and_out():
    text = (
        "function cumulate input Real x[:]; output Real y[size(x, 1)]; protected Real s; "
        "algorithm s := 0; for i in 1:size(x, 1) loop s := s + x[i]; y[i] := s; end for; "
        "end cumulate; model M Real a[4] = cumulate({1, 2, 3, 4}); "
        "Real b[2] = cumulate({time, 1}); end M;"
    )
    assert values(text, "a[4]", "b[1]", "b[2]", time=3.0) == [10, 3, 4]


def test_several_outputs():
    text = (
        "function f input Real x; output Real s; output Real d; algorithm s := x; d := -x; end f; "
        "model M Real a; Real b; Real c; Real e = f(7); "
        "equation (a, b) = f(3); (, c) = f(4); end M;"
    )
    assert values(text, "a", "b", "c", "e") == [3, -3, -4, 7]


def test_calls_with_arrays_where_scalars_are_declared():
    text = (
        "function f input Real x; input Real k = 2; output Real y; output Real z; "
        "algorithm y := k*x^2; z := -x; end f; "
        "model M Real a[3] = f({1, 2, 3}); "
        "Real b[2] = f({1, 2}, {5, 6}); Real c[2,2] = f([1, 2; 3, 4]); "
        "Real d[2]; Real e[2]; parameter Integer n = 3; Real g[n]; "
        "equation (d, e) = f({1, 2}); g = f(a, 1); end M;"
    )
    assert values(text, "a[3]", "b[2]", "c[2,1]", "d[2]", "e[2]", "g[2]") == [18, 24, 18, 8, -2, 64]
    assert (
        refused(
            "function f input Real x; input Real k; output Real y; algorithm y := k*x; end f; "
            "model M Real a[3] = f({1, 2, 3}, {1, 2}); end M;"
        ).code
        == "T104"
    )


def test_records_as_arguments_and_results():
    text = (
        "record C Real re; Real im; end C; "
        "function mul input C a; input C b; output C c; "
        "algorithm c := C(a.re*b.re - a.im*b.im, a.re*b.im + a.im*b.re); end mul; "
        "function conj input C a; output C c; algorithm c.re := a.re; c.im := -a.im; end conj; "
        "model M C x = mul(C(1, 2), C(3, 4)); C y = conj(x); end M;"
    )
    assert values(text, "x.re", "x.im", "y.im") == [-5, 10, -10]


def test_functions_give_parameters_and_sizes():
    found = parameters(
        "function f input Real x; output Real y; algorithm y := x + 1; end f; "
        "model M parameter Real p = f(3); parameter Integer n = integer(f(2)); "
        "parameter Real q[n] = ones(n); end M;"
    )
    assert found == {"p": 4.0, "q[1]": 1.0, "q[2]": 1.0, "q[3]": 1.0}


def test_functions_see_constants_around_them():
    text = (
        "package P constant Real k = 3; function f input Real x; output Real y; "
        "algorithm y := k*x; end f; end P; model M Real a = P.f(2); end M;"
    )
    assert values(text, "a") == [6]


@pytest.mark.parametrize(
    ("body", "expression", "code"),
    [
        ("input Real a; algorithm y := a;", "f(1, 2)", "T120"),
        ("input Real a; algorithm y := a;", "f()", "T120"),
        ("input Real a; algorithm y := a;", "f(aa = 1)", "T120"),
        ("input Real a; algorithm y := z;", "f(1)", "N102"),
        ("input Real a; algorithm a := 1; y := a;", "f(1)", "T126"),
        ("input Real a; algorithm if a > 0 then y := 1; end if;", "f(time)", "T123"),
        ("input Real a; algorithm while a > 0 loop y := 1; end while;", "f(time)", "T128"),
        ("input Real a[2]; algorithm y := a[1];", "f({1, 2, 3})", "T104"),
        ('input Real a(unit = "m"); algorithm y := a;', "f(3[s])", "U106"),
    ],
)
def test_wrong_functions(body, expression, code):
    text = f"function f output Real y; {body} end f; model M Real x = {expression}; end M;"
    assert refused(text).code == code
