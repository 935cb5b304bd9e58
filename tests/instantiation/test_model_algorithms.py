"""Algorithm sections of models: one equation for every variable they set."""

from __future__ import annotations

import pytest

from tests.instantiation.shown import assignments, code, equations, shown, signals, template


def test_loops_and_conditions():
    own = template(
        "model M Real x = time, y, z(start = 7); algorithm y := 0; "
        "for i in 1:4 loop y := y + i*x; if i == 2 then break; end if; end for; "
        "if y > 2 then z := y; end if; end M;"
    )
    assert equations(own) == [
        "x - time",
        "y - (x + 2*x)",
        "z - (if x + 2*x > 2 then x + 2*x else 7)",
    ]


def test_what_is_read_before_it_is_set():
    own = template(
        "model M Real y(start = 3), z; Integer n(start = 5); Boolean b; algorithm "
        "z := y; y := time; b := n > 3; n := if b then pre(n) + 1 else n; end M;"
    )
    assert equations(own) == ["z - 3", "y - time"]
    assert assignments(own) == ["b := pre(n) > 3", "n := if b then pre(n) + 1 else pre(n)"]


def test_whens():
    own = template(
        "model M Real x = time, d, s; Integer n; Boolean b; algorithm b := x > 1; "
        "when b then n := pre(n) + 1; d := x; elsewhen {initial(), sample(0, 1)} then n := 0; "
        "end when; s := d + n; end M;"
    )
    assert signals(own) == ["condition(b)", "sample(0, 1)", "condition($1)"]
    assert assignments(own) == [
        "b := x > 1",
        "n := if $0 and not pre($0) then pre(n) + 1 else "
        "if initial() or $2 and not pre($2) then 0 else pre(n)",
        "d := if $0 and not pre($0) then x else pre(d)",
    ]
    assert [d.held for d in own.discrete] == [False, True, True]
    assert equations(own) == ["x - time", "s - (d + n)"]


def test_a_real_set_in_a_when_and_elsewhere_is_continuous():
    own = template(
        "model M Real y; algorithm y := 2*time; when time > 1 then y := 1; end when; end M;"
    )
    assert equations(own) == ["y - (if $0 and not pre($0) then 1 else 2*time)"]
    assert not own.discrete


def test_conditions_are_about_the_middle_of_the_section():
    own = template(
        "model M Boolean b, c; equation when b then c = true; end when; algorithm "
        "when b then b := false; end when; b := time > 1; end M;"
    )
    assert signals(own) == ["condition(b)", "condition(pre(b))"]
    assert assignments(own)[1:] == ["b := time > 1"]


def test_elements_of_arrays():
    own = template(
        "model M Real x[3]; Integer k[2], n; equation n = if time > 1 then 2 else 1; "
        "algorithm x := {1, 2, 3}*time; x[2:3] := {7, 8}; x[1] := x[2]; "
        "k := {5, 6}; k[n] := 7; end M;"
    )
    assert equations(own) == ["x[1] - 7", "x[2] - 7", "x[3] - 8"]
    assert assignments(own)[1:] == [
        "k[1] := if n == 1 then 7 else 5",
        "k[2] := if n == 1 then 6 else 7",
    ]


def test_a_changing_subscript_is_that_of_its_moment():
    own = template(
        "model M Integer n; Real table[2] = {1, 2}*time, y; algorithm "
        "n := 1; when time > 1 then n := pre(n) + 1; end when; y := table[n]; end M;"
    )
    assert equations(own)[-1] == "y - (if n == 1 then table[1] else table[2])"


def test_components_records_and_functions():
    own = template(
        "record R Real a; Integer b; end R; block S output Real y; R r; end S; "
        "function f input Real u; output Real p; output Integer q; "
        "algorithm p := u; q := integer(u); end f; "
        "model M S s; R r; algorithm (r.a, r.b) := f(time); s.r := r; s.y := 2*r.a; end M;",
        "M",
    )
    assert equations(own) == ["r.a - time", "s.r.a - time", "s.y - 2*time"]
    assert assignments(own) == ["r.b := integer(time)", "s.r.b := r.b"]


def test_loops_whose_end_is_computed():
    own = template(
        "model M Real x; Integer k; algorithm k := 0; x := time; "
        "while k < 3 loop k := k + 1; x := 2*x; end while; end M;"
    )
    assert equations(own) == ["x - 2*(2*(2*time))"]
    assert assignments(own) == ["k := 3"]


def test_assert_and_terminate():
    own = template(
        'model M Real x = time; Real y; algorithm y := x + 1; assert(y < 5, "a"); '
        'if y > 2 then assert(x > 1, "b"); end if; when y > 3 then terminate("c"); end when; '
        "end M;"
    )
    assert [shown(a.condition) for a in own.asserts] == ["x + 1 < 5", "not x + 1 > 2 or x > 1"]
    assert [shown(t.fires) for t in own.terminates] == ["$0 and not pre($0)"]


def test_derivatives():
    own = template("model M Real x, y; algorithm x := der(y); y := time; x := x + der(y); end M;")
    assert equations(own) == ["x - (der(y) + 1)", "y - time"]


def test_initial_algorithm():
    own = template(
        "model M Real x(start = 0), d; Integer n; equation der(x) = 1; "
        "when x > 1 then d = x; n = 1; end when; "
        "initial algorithm x := 2; d := 4; n := if x > 3 then 8 else 9; end M;"
    )
    assert equations(own, initial=True) == ["x - 2"]
    assert assignments(own, initial=True) == ["d := 4", "n := 9"]


@pytest.mark.parametrize(
    ("body", "wanted"),
    [
        ("return;", "T112"),
        ("break;", "T112"),
        ("u := 1;", "T126"),
        ("p := 1;", "T126"),
        ("time := 1;", "T126"),
        ("for i in 1:2 loop i := 1; end for;", "T126"),
        ("reinit(x, 1);", "E010"),
        ('terminate("x");', "E008"),
        ("when x > 1 then when x > 2 then y := 1; end when; end when;", "E008"),
        ("if x > 1 then when x > 2 then y := 1; end when; end if;", "E008"),
        ("while x < 1 loop x := x + 1; end while;", "T128"),
        ("for i in 1:3 loop if x > i then break; end if; end for;", "T127"),
        ("n := 1.5;", "T101"),
        ("b := 1;", "T101"),
        ("x := {1, 2};", "T104"),
        ("a[3] := 1;", "T114"),
        ("when x > 1 then y := 1; end when; equation when x > 2 then y = 2; end when;", "E006"),
        ("initial algorithm when initial() then y := 1; end when;", "E008"),
    ],
)  # fmt: skip
def test_refused(body, wanted):
    declared = "Real x, y, a[2]; Integer n; Boolean b; input Real u; parameter Real p = 1;"
    assert code(f"model M {declared} algorithm {body} end M;") == wanted
