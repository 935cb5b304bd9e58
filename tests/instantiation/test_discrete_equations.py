"""Boolean, Integer and enumeration variables and the equations that set them."""

from __future__ import annotations

import pytest

from tests.instantiation.shown import assignments, code, equations, shown, template

GEARS = "type Gear = enumeration(low, high, top); "


def test_declarations_say_what_they_are():
    own = template(
        GEARS + "model M Real x = 1; Boolean b = true; Integer n[2] = {1, 2}; Gear g = Gear.low; "
        "discrete Real d; equation when sample(0, 1) then d = 1; end when; end M;",
        "M",
    )
    seen = {n: (v.base, v.literals, v.discrete) for n, v in own.variables.items()}
    assert seen == {
        "x": ("Real", (), False),
        "b": ("Boolean", (), True),
        "n": ("Integer", (), True),
        "g": ("enumeration", ("low", "high", "top"), True),
        "d": ("Real", (), True),
    }


def test_parameters_stay_structural():
    own = template("model M parameter Boolean p = true; parameter Integer n = 2; end M;")
    assert not own.variables and not own.parameters and set(own.structural) == {"p", "n"}


def test_start_and_fixed_are_numbers():
    own = template(
        GEARS + "model M Boolean b(start = true, fixed = true); Gear g(start = Gear.top); "
        "Integer n(start = 4); equation b = time > 1; g = Gear.low; n = 2; end M;",
        "M",
    )
    bound = {(b.target.name, b.attribute): shown(b.value) for b in own.bindings}
    assert bound == {("b", "start"): "1", ("b", "fixed"): "1", ("g", "start"): "3",
                     ("n", "start"): "4"}  # fmt: skip


def test_declaration_equations():
    own = template(
        "model M Real x = time; Boolean b = x > 1, c = b; Integer k[2] = {1, if b then 2 else 3}; "
        "end M;"
    )
    assert equations(own) == ["x - time"]
    assert assignments(own) == ["b := x > 1", "c = b", "k[1] := 1", "k[2] := if b then 2 else 3"]


def test_the_lone_variable_is_set_whatever_its_side():
    own = template(
        "model M Boolean a, b, c, d; equation a and b = c; not a = b; a = true; d = c; end M;"
    )
    assert assignments(own) == ["c := a and b", "b := not a", "a := 1", "d = c"]


def test_a_real_equation_with_an_integer_stays_one():
    own = template("model M Real x, y; Integer n; equation n = 2; x = n; x + y = n; end M;")
    assert equations(own) == ["x - n", "x + y - n"]
    assert assignments(own) == ["n := 2"]


def test_arrays_keep_their_loops():
    own = template(
        "model M Real x[4]; Boolean b[4], c[4], d[2]; equation x = {1, 2, 3, 4}*time; "
        "for i in 1:4 loop b[i] = x[i] > i; end for; c = not b; d = {c[4], b[1]}; end M;"
    )
    assert [d.domain.length for d in own.discrete] == [4, 4, 1, 1]
    assert assignments(own)[3:6] == ["b[4] := x[4] > 4", "c[1] := not b[1]", "c[2] := not b[2]"]
    assert assignments(own)[-2:] == ["d[1] = c[4]", "d[2] = b[1]"]


def test_branches_of_an_if_are_joined():
    own = template(
        "model M Real x = time; Boolean b[2], c; equation "
        "if x > 3 then b = {true, false}; c = b[1]; "
        "else c = true; for i in 1:2 loop b[i] = x > i; end for; end if; end M;"
    )
    assert assignments(own) == [
        "b[1] := if x > 3 then 1 else x > 1",
        "b[2] := if x > 3 then 0 else x > 2",
        "c := if x > 3 then b[1] else 1",
    ]


def test_records_and_functions():
    own = template(
        "record R Integer n; Real x; end R; "
        "function f input Real u; output Real a; output Integer b; "
        "algorithm a := u; b := integer(u); end f; "
        "model M R r, s; Real y; Integer n; equation r.n = 1; r.x = 2; s = r; "
        "(y, n) = f(time); end M;",
        "M",
    )
    assert equations(own) == ["r.x - 2", "s.x - r.x", "y - time"]
    assert assignments(own) == ["r.n := 1", "s.n = r.n", "n := integer(time)"]


def test_connectors_and_blocks():
    own = template(
        "connector BooleanInput = input Boolean; connector BooleanOutput = output Boolean; "
        "block Not BooleanInput u; BooleanOutput y; equation y = not u; end Not; "
        "model M Not a(u = time > 1), b[2]; equation b[1].u = a.y; connect(b[1].y, b[2].u); "
        "end M;",
        "M",
    )
    assert assignments(own) == ["a.u := time > 1", "b[1].u = a.y"]
    inside = own.children["a"].template
    assert assignments(inside) == ["y := not u"]
    leaf = inside.children["u"].template.variables[""]
    assert (leaf.base, leaf.discrete) == ("Boolean", True)


def test_enumerations_index_arrays_and_convert():
    own = template(
        GEARS + "model M Gear g; Integer n; Real ratio[Gear] = {3, 2, 1}*time, now = ratio[g]; "
        "equation g = if time > 1 then Gear.high else Gear.low; n = Integer(g); end M;",
        "M",
    )
    assert equations(own)[-1] == (
        "now - (if g == 1 then ratio[1] else if g == 2 then ratio[2] else ratio[3])"
    )
    assert assignments(own) == ["g := if time > 1 then 2 else 1", "n = g"]


def test_a_subscript_may_change():
    own = template(
        "model M Integer n = if time > 1 then 2 else 1; Real a[2, 2] = {{1, 2}, {3, 4}}*time; "
        "Real row[2] = a[n, :]; end M;"
    )
    assert equations(own)[-2:] == [
        "row[1] - (if n == 1 then a[1,1] else a[2,1])",
        "row[2] - (if n == 1 then a[1,2] else a[2,2])",
    ]


def test_initial_equations_of_discrete_variables():
    own = template(
        "model M Real x(start = 0), y; Boolean b; discrete Real d; "
        "equation der(x) = 1; b = x > 1; when b then y = x; d = 1; end when; "
        "initial equation pre(b) = true; b = false; y = 4; 5 = pre(y); d = 2; x = 3; end M;"
    )
    assert assignments(own, initial=True) == [
        "pre(b) := 1", "b := 0", "y := 4", "pre(y) := 5", "d := 2",
    ]  # fmt: skip
    assert equations(own, initial=True) == ["x - 3"]


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("Boolean a, b, c; equation a and b = c or a;", "E005"),
        ("Integer i, j; equation i + j = 3; i = j;", "E005"),
        ("Boolean a; equation a = a;", "B103"),
        ("Boolean a; equation true = false;", "B104"),
        ("Real x = 1; Boolean b; equation b = x;", "T101"),
        ("Real x = 1; Integer n; equation n = 2*x;", "T101"),
        ("Integer n = 1.5;", "T101"),
        ("Integer n = floor(time);", "T101"),
        ("Boolean b = 1;", "T101"),
        ("Boolean b(start = 1) = true;", "T101"),
        ("Real x = b; Boolean b = true;", "T101"),
        ("Boolean b = true; Real x = if b == 1 then 1 else 2;", "T106"),
        ("Real x = time; Boolean b, c; equation if x > 1 then b = true; else c = true; end if;",
         "E009"),
        ("String s;", "T110"),
    ],
)  # fmt: skip
def test_refused(text, wanted):
    assert code(f"model M {text} end M;") == wanted


def test_enumerations_do_not_mix():
    other = "type Other = enumeration(low, high); "
    for body in ("Gear g = Other.low;", "Gear g; equation g = Other.low;", "Gear g = 1;"):
        assert code(GEARS + other + f"model M {body} end M;") == "T101"


def test_cuts_of_different_types_are_not_connected():
    assert (
        code(
            "connector B = input Boolean; connector R = input Real; "
            "block P B u; end P; block Q R u; end Q; "
            "model M P p; Q q; equation connect(p.u, q.u); end M;"
        )
        == "C101"
    )


def test_loops_over_an_enumeration():
    own = template(
        GEARS + "model M Gear g = Gear.low; Boolean on[Gear]; equation "
        "for e in Gear loop on[e] = g == e; end for; end M;",
        "M",
    )
    assert assignments(own)[1:] == ["on[1] := g == 1", "on[2] := g == 2", "on[3] := g == 3"]
