"""Types with attributes and units, enumerations, constants."""

from __future__ import annotations

import pytest

from tests.flattening.static import flat, parameters, refused, solve


def test_attributes_of_types_and_declarations():
    variables = flat(
        'type V = Real(unit = "V", min = 0, nominal = 5); type W = V(max = 9); '
        "model M W x(start = 2, max = 8) = 3; W y[2] = {1, 2}; end M;"
    ).model.variables
    assert variables.minimum.tolist() == [0, 0, 0]
    assert variables.maximum.tolist() == [8, 9, 9]
    assert variables.nominal.tolist() == [5, 5, 5]
    assert variables.start.tolist() == [2, 0, 0]
    assert variables.start_given.tolist() == [True, False, False]


def test_types_that_are_arrays():
    found = solve(
        'type Vector = Real[3]; type Position = Vector(each unit = "m"); '
        "model M Vector v = {1, 2, 3}; Position w[2] = {{1, 2, 3}, {4, 5, 6}}; end M;"
    )
    assert (found["v[3]"], found["w[2,3]"]) == pytest.approx((3.0, 6.0))


def test_state_select_literals():
    variables = flat(
        "model M Real x(stateSelect = StateSelect.always); "
        "Real y(stateSelect = StateSelect.never); "
        "equation der(x) = 1; y = x; end M;"
    ).model.variables
    assert variables.state_select.tolist()[:2] == [5, 1]


# --- units ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("unit", "literal", "si"),
    [
        ("V", "3[kV]", 3000.0),
        ("V", "2[mV]", 0.002),
        ("rad", "180[deg]", 3.141592653589793),
        ("rad/s", "60[rpm]", 6.283185307179586),
        ("1/s", "1300[1/min]", 1300 / 60),
        ("K", "20[degC]", 293.15),
        ("N/m", "25[N/mm]", 25000.0),
        ("m2", "10[mm2]", 1e-5),
        ("Pa", "2[bar]", 2e5),
    ],
)
def test_numbers_are_converted_to_si(unit, literal, si):
    found = solve(f'model M Real x(unit = "{unit}") = {literal}; end M;')
    assert found["x"] == pytest.approx(si, rel=1e-12)


GOOD = [
    'Real x(unit = "V") = 3; Real y(unit = "A") = x/2[Ohm];',
    'Real x(unit = "m2") = 4; Real y(unit = "m") = sqrt(x);',
    'Real x(unit = "m") = 4; Real y(unit = "m3") = x^3;',
    'Real x(unit = "m3") = 4; Real y(unit = "m") = x^(1/3);',
    'Real x(unit = "rad") = 4; Real y = sin(x);',
    'Real x(unit = "m") = 4; Real y(unit = "m") = max(x, 3[mm]);',
    'Real x(unit = "m") = 4; Real y = if x > 3[mm] then 1 else 2;',
    'Real x(unit = "m") = 4; Real y(unit = "m") = 2*x + 1;',
    'Real x(unit = "N.m") = 4; Real y(unit = "J") = x;',
    'Real x[2](each unit = "m") = {1, 2}; Real y(unit = "m2") = x*x;',
    'Real x(unit = "m") = 4; Real q = 5; Real y(unit = "s") = q*x;',
]


@pytest.mark.parametrize("body", GOOD)
def test_units_that_fit(body):
    flat(f"model M {body} end M;")


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ('Real x(unit = "V") = 3[A];', "U102"),
        ('Real x(unit = "V") = 3; Real y(unit = "A") = 2; Real z = x + y;', "U101"),
        ('Real x(unit = "V"); Real y(unit = "A") = 2; equation x = y;', "U102"),
        ('Real x(unit = "m"); Real v(unit = "m/s"); equation v = der(x); v = -x;', "U102"),
        ('Real x(unit = "m") = 4; Real v = sin(x);', "U103"),
        ('Real x(unit = "m") = 4; Real v = 2^x;', "U103"),
        ('Real x(unit = "m") = 2; Real y = if time > 1 then x else 3[s];', "U101"),
        ('Real x(unit = "m") = 2; Real y = if x > 3[s] then 1 else 2;', "U105"),
        ('Real x(unit = "m") = 2; Real y[2] = {x, 3[s]};', "U101"),
        ('Real x(unit = "m") = 2; Real y = max(x, 3[s]);', "U101"),
        ('Real x(unit = "mm/h/") = 2;', "U104"),
        ("Real x = 3[foo];", "U104"),
        ('parameter Real T(unit = "K") = 3; parameter Real v(unit = "V") = T;', "U102"),
        ('Real x(unit = "m", start = 3[s]); equation der(x) = -x/1[s];', "U102"),
    ],
)
def test_units_that_do_not_fit(body, code):
    assert refused(f"model M {body} end M;").code == code


def test_a_plain_number_in_a_function_fits_every_unit():
    body = 'parameter Real v(unit = "V") = 0.05; Real x = exp(v/0.025);'
    assert solve(f"model A {body} end A; ")["x"] == pytest.approx(7.38905609893065)


# --- enumerations --------------------------------------------------------------------------

E = 'type E = enumeration(one, two "second", three);\n'


def test_enumerations_choose():
    found = solve(
        E + "model A parameter E e = E.two; "
        "Real x = if e == E.one then 1 elseif e == E.two then 2 else 3; end A; "
        "model M A a; A b(e = E.three); A c(e = E.one); end M;"
    )
    assert [found[f"{n}.x"] for n in "abc"] == pytest.approx([2.0, 3.0, 1.0])


def test_enumerations_compare_in_order_and_become_integers():
    found = solve(
        E + "model M parameter Integer k = Integer(E.three); Real x = k; Real y = Integer(E.two); "
        "Real z = if E.one < E.two then 1 else 0; end M;"
    )
    assert [found[n] for n in "xyz"] == pytest.approx([3.0, 2.0, 1.0])


def test_arrays_of_and_by_enumerations():
    found = solve(
        E + "model M parameter E es[2] = {E.one, E.three}; "
        "Real x[2] = {if es[i] == E.one then 1 else 9 for i in 1:2}; "
        "Real a[E] = {1, 2, 3}; Real b = a[E.two]; end M;"
    )
    assert [found[n] for n in ("x[1]", "x[2]", "b")] == pytest.approx([1.0, 9.0, 2.0])


def test_wrong_enumerations():
    message = refused(E + "model M parameter E e = E.tow; end M;")
    assert message.code == "N102"
    assert "two" in " ".join(message.notes)
    two = E + "type F = enumeration(one, two);\n"
    assert refused(two + "model M Real x = if E.one == F.one then 1 else 2; end M;").code == "T106"
    assert refused(E + "model M Real x = if E.one == 1 then 1 else 2; end M;").code == "T106"


# --- constants -----------------------------------------------------------------------------


def test_constants_of_packages():
    found = solve(
        "package C constant Real g = 9.81; constant Real h = 2*g; constant Integer n = 3; "
        "package D constant Real k = h + 1; end D; end C; "
        "model M Real x = C.g + C.h; Real y[C.n] = ones(C.n); Real z = C.D.k; end M;"
    )
    assert (found["x"], found["z"]) == pytest.approx((3 * 9.81, 2 * 9.81 + 1))


def test_constants_of_a_package_can_be_changed_by_extending_it():
    found = solve(
        "package C constant Real k = 7; constant Real twice = 2*k; end C; "
        "package D extends C(k = 9); end D; model M Real x = C.twice; Real y = D.twice; end M;"
    )
    assert (found["x"], found["y"]) == pytest.approx((14.0, 18.0))


def test_constants_in_a_model_and_arrays_of_them():
    found = solve(
        "model M constant Integer k[3] = {4, 5, 6}; constant Real c = 2; Real x = c*k[2]; end M;"
    )
    assert found["x"] == pytest.approx(10.0)


def test_wrong_constants():
    assert refused("model M constant Real a = b; constant Real b = a; end M;").code == "N117"
    assert refused("model M constant Real a; Real x = a; end M;").code == "N112"
    assert refused("model M Real y = 1; constant Real a = y; end M;").code == "T103"
    assert parameters("model M constant Real a = 2; parameter Real b = a; end M;") == {"b": 2.0}
