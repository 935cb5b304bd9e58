"""When equations: conditions, assignments, reinits, terminations."""

from __future__ import annotations

import pytest

from tests.instantiation.shown import (
    assignments,
    code,
    equations,
    reinits,
    shown,
    signals,
    template,
)


def test_a_when_holds_its_variable():
    own = template(
        "model M Real x = time, y; Integer n; equation "
        "when x > 1 then y = 2*x; n = pre(n) + 1; end when; end M;"
    )
    assert signals(own) == ["condition(x > 1)"]
    assert assignments(own) == [
        "y := if $0 and not pre($0) then 2*x else pre(y)",
        "n := if $0 and not pre($0) then pre(n) + 1 else pre(n)",
    ]
    assert all(d.held for d in own.discrete)
    assert equations(own) == ["x - time"]


def test_elsewhen_comes_after():
    own = template(
        "model M Real x, v; Integer n; equation der(x) = v; der(v) = 1; "
        "when x > 1 then n = 1; reinit(x, 0); elsewhen x > 2 then n = 2; reinit(v, -pre(v)); "
        "end when; end M;"
    )
    assert assignments(own) == [
        "n := if $0 and not pre($0) then 1 else if $1 and not pre($1) then 2 else pre(n)"
    ]
    assert reinits(own) == [
        "x := 0 at $0 and not pre($0)",
        "v := -pre(v) at $1 and not pre($1) and not ($0 and not pre($0))",
    ]


def test_several_conditions_fire_one_by_one():
    own = template(
        "model M Real x[2] = {time, 2*time}; Integer n; equation "
        "when {initial(), sample(0, 2), x[1] > 1} then n = pre(n) + 1; end when; end M;"
    )
    assert signals(own) == ["sample(0, 2)", "condition($0)", "condition(x[1] > 1)"]
    assert assignments(own) == [
        "n := if initial() or $1 and not pre($1) or $2 and not pre($2) then pre(n) + 1 else pre(n)"
    ]


def test_terminal_is_an_instant_of_its_own():
    own = template("model M Boolean b; equation when terminal() then b = true; end when; end M;")
    assert assignments(own) == ["b := if terminal() then 1 else pre(b)"]


def test_a_when_in_a_loop_has_a_condition_for_every_pass():
    own = template(
        "model M Real x[3] = {1, 2, 3}*time; Integer n[3]; equation for i in 1:3 loop "
        "when x[i] > i then n[i] = pre(n[i]) + i; end when; end for; end M;"
    )
    assert [(s.domain.length, s.kind) for s in own.signals] == [(3, "condition")]
    assert signals(own)[2] == "condition(x[3] > 3)"
    assert assignments(own)[2] == "n[3] := if $0 and not pre($0) then pre(n[3]) + 3 else pre(n[3])"


def test_what_does_not_depend_on_the_loop_is_one_signal():
    own = template(
        "model M Integer n[3]; equation for i in 1:3 loop when sample(0, 1) then "
        "n[i] = i; end when; end for; end M;"
    )
    assert [s.domain.length for s in own.signals] == [1, 1]


def test_a_condition_on_a_sample_has_its_loops():
    own = template(
        "model M Integer n[3]; equation for i in 1:3 loop when sample(0, i) then "
        "n[i] = i; end when; end for; end M;"
    )
    assert [s.domain.names for s in own.signals] == [("i#0",), ("i#0",)]


def test_loops_of_branches_may_name_their_index_differently():
    own = template(
        "model M Integer n[3]; equation when time > 1 then for i in 1:3 loop n[i] = i; end for; "
        "elsewhen time > 2 then for j in 1:3 loop n[j] = pre(n[j]) + j; end for; end when; end M;"
    )
    assert assignments(own)[1] == (
        "n[2] := if $0 and not pre($0) then 2 else if $1 and not pre($1) then pre(n[2]) + 2 "
        "else pre(n[2])"
    )


def test_if_and_for_inside():
    own = template(
        "model M Real x(start = 0), y; Real s[2](each start = 0); equation der(x) = 1; "
        "der(s) = {1, 2}; when x > 1 then "
        "if s[1] > 1 then y = 1; reinit(x, 0); else y = 2; end if; "
        "for i in 1:2 loop reinit(s[i], i); end for; end when; end M;"
    )
    assert assignments(own) == [
        "y := if $0 and not pre($0) then (if s[1] > 1 then 1 else 2) else pre(y)"
    ]
    assert reinits(own) == [
        "x := 0 at $0 and not pre($0) and s[1] > 1",
        "s[1] := 1 at $0 and not pre($0)",
        "s[2] := 2 at $0 and not pre($0)",
    ]


def test_functions_and_records_inside():
    own = template(
        "record R Integer n; Real x; end R; function f input Real u; output R r; output Real y; "
        "algorithm r.n := integer(u); r.x := u; y := 2*u; end f; model M R r; Real y; equation "
        "when sample(0, 1) then (r, y) = f(time); end when; end M;",
        "M",
    )
    assert assignments(own) == [
        "r.n := if $1 and not pre($1) then integer(time) else pre(r.n)",
        "r.x := if $1 and not pre($1) then time else pre(r.x)",
        "y := if $1 and not pre($1) then 2*time else pre(y)",
    ]


def test_assert_and_terminate_act_in_the_instant():
    own = template(
        'model M Real x = time; equation when x > 1 then assert(x < 2, "late"); '
        'terminate("done at " + String(x)); end when; if x > 3 then terminate("far"); end if; '
        "end M;"
    )
    assert [shown(a.condition) for a in own.asserts] == ["not ($0 and not pre($0)) or x < 2"]
    assert [(shown(t.fires), t.message) for t in own.terminates] == [
        ("$0 and not pre($0)", "done at …"),
        ("x > 3", "far"),
    ]


def test_an_assert_under_a_condition_holds_where_it_does():
    own = template(
        'model M Real x = time; equation if x > 1 then assert(x < 2, "a"); '
        'else assert(x < 0, "b"); end if; end M;'
    )
    assert [shown(a.condition) for a in own.asserts] == ["not x > 1 or x < 2", "x > 1 or x < 0"]


def test_the_impulse_of_an_impact():
    own = template(
        "connector Flange Real s; through Real f; end Flange; "
        "model M Flange a; Real v = der(a.s); equation "
        "when a.s < 0 then reinit(v, -pre(v), a.f); end when; end M;"
    )
    assert reinits(own) == ["v := -pre(v) at $0 and not pre($0) impulse a.f"]


def test_a_condition_that_never_changes_never_fires():
    own = template(
        "model M parameter Boolean p = true; Integer n; equation "
        "when p then n = 1; end when; end M;"
    )
    assert assignments(own) == ["n := pre(n)"]


@pytest.mark.parametrize(
    ("body", "wanted"),
    [
        ("when x > 1 then y = 1; end when; when x > 2 then y = 2; end when;", "E006"),
        ("when x > 1 then y = 1; y = 2; end when;", "E006"),
        ("for i in 1:2 loop when x > i then y = i; end when; end for;", "E006"),
        ("for i in 1:2 loop when x > i then a[i] = i; end when; end for; "
         "when x > 3 then a[2] = 0; end when;", "E006"),
        ("when x > 1 then when x > 2 then y = 1; end when; end when;", "E008"),
        ("if x > 3 then when x > 1 then y = 1; end when; end if;", "E008"),
        ('terminate("x");', "E008"),
        ("y = reinit(x, 1);", "E008"),
        ("when x > 1 then y = 1; elsewhen x > 2 then reinit(x, 3); end when;", "E009"),
        ("when x > 1 then if x > 2 then y = 1; end if; end when;", "E009"),
        ("reinit(x, 1);", "E010"),
        ("when x > 1 then reinit(p, 1); end when;", "E010"),
        ("when x > 1 then reinit(2*x, 1); end when;", "E010"),
        ("when x > 1 then reinit(n, 1); end when;", "E010"),
        ("when x > 1 then reinit(d, 1); end when;", "E010"),
        ("when x > 1 then reinit(x, 1, y); end when;", "E010"),
        ("when x > 1 then reinit(x); end when;", "T120"),
        ("when x > 1 then reinit(x, {1, 2}); end when;", "T104"),
        ("when x > 1 then x + y = 1; end when;", "E014"),
        ("when x > 1 then pre(y) = 1; end when;", "E014"),
        ("when x > 1 then n = x; end when;", "T101"),
        ("when x then y = 1; end when;", "T102"),
        ("initial equation when initial() then y = 1; end when;", "E008"),
    ],
)  # fmt: skip
def test_refused(body, wanted):
    declared = "Real x, y, a[2]; Integer n; parameter Real p = 1; discrete Real d;"
    assert code(f"model M {declared} equation der(x) = 1; {body} end M;") == wanted


def test_set_twice_in_different_elements_is_fine():
    own = template(
        "model M Integer a[4]; equation for i in 1:2 loop when time > i then a[i] = i; end when; "
        "when time > i + 2 then a[i + 2] = i; end when; end for; end M;"
    )
    assert len(assignments(own)) == 4
