"""pre, edge, change, initial, terminal, sample, delay."""

from __future__ import annotations

import pytest

from tests.instantiation.shown import assignments, code, equations, signals, template


def test_values_before_the_event():
    own = template(
        "model M Real x = time, y = pre(x); Boolean b[2] = {x > 1, x > 2}, c[2] = pre(b), "
        "e = edge(b[1]), f = change(b[2]); parameter Integer p = 3; Integer n = pre(p); end M;"
    )
    assert equations(own) == ["x - time", "y - pre(x)"]
    assert assignments(own)[2:] == [
        "c[1] := pre(b[1])", "c[2] := pre(b[2])", "e := b[1] and not pre(b[1])",
        "f := b[2] <> pre(b[2])", "n := 3",
    ]  # fmt: skip


def test_pre_of_a_component_in_a_loop():
    own = template(
        "block B output Integer n; equation n = 1; end B; model M B b[3]; Integer k[3]; equation "
        "for i in 1:3 loop k[i] = pre(b[i].n) + 1; end for; end M;"
    )
    assert assignments(own)[2] == "k[3] := pre(b[3].n) + 1"


def test_first_and_last_instant():
    own = template("model M Real x; equation x = if initial() then 1 else 2; end M;")
    assert equations(own) == ["x - (if initial() then 1 else 2)"]
    assert not own.signals


def test_samples():
    own = template(
        "model M parameter Real T = 2, start[2] = {1, 2}; Boolean a = sample(0, T), b[2], c[2]; "
        "equation for i in 1:2 loop b[i] = sample(start[i], T/2); end for; "
        "c = {sample(start[i], T) for i in 1:2}; end M;"
    )
    assert signals(own) == [
        "sample(0, T)", "sample(start[1], T/2)", "sample(start[2], T/2)",
        "sample(start[1], T)", "sample(start[2], T)",
    ]  # fmt: skip
    assert assignments(own) == ["a := $0", "b[1] := $1", "b[2] := $1", "c[1] := $2", "c[2] := $3"]


def test_equal_signals_are_one():
    own = template("model M Boolean a = sample(0, 1), b = sample(0, 1); end M;")
    assert len(own.signals) == 1


def test_a_loop_that_is_written_out_leaves_no_signals_behind():
    own = template(
        "model M Boolean s[2]; Real x[2]; equation for i in 1:2 loop s[i] = sample(0, i); "
        "x[i] = sum({k*time for k in 1:i}); end for; end M;"
    )
    assert signals(own) == ["sample(0, 1)", "sample(0, 2)"]


def test_delays():
    own = template(
        "model M parameter Real T = 1; Real x[2] = {time, 2*time}, y = delay(x[1] + 1, T), "
        "z = delay(x[2], T*x[1], 2*T), w[2] = delay(x, 0.5), p = delay(T, 1); end M;"
    )
    assert signals(own) == [
        "delay(x[1] + 1, T, T)", "delay(x[2], T*x[1], 2*T)",
        "delay(x[1], 0.5, 0.5)", "delay(x[2], 0.5, 0.5)",
    ]  # fmt: skip
    assert equations(own)[2:] == ["y - $0", "z - $1", "w[1] - $2", "w[2] - $3", "p - T"]


@pytest.mark.parametrize(
    ("body", "wanted"),
    [
        ("y = pre(x + 1);", "E007"),
        ("y = pre(time);", "E007"),
        ("y = pre(der(x));", "E007"),
        ("b = edge(x > 1);", "E007"),
        ("b = edge(x);", "T102"),
        ("b = change(2*x);", "E007"),
        ("b = sample(0, x);", "E011"),
        ("b = sample(x, 1);", "E011"),
        ("b = sample(0, -1);", "E011"),
        ("b = sample(0);", "T120"),
        ("y = delay(x, x);", "E011"),
        ("y = delay(x, 1, x);", "E011"),
        ("y = delay(x, -1);", "E011"),
        ("y = delay(b, 1);", "T101"),
        ("b = sample(0, 1[m]);", "U106"),
        ("y = der(n);", "E013"),
        ("y = der(n*time);", "E013"),
        ("y = String(3);", "E001"),
        ("y = f(x);", "E008"),
        ("y = g(x);", "E008"),
        ("y = h(x);", "E008"),
        ("initial(1);", "T120"),
    ],
)
def test_refused(body, wanted):
    functions = (
        "function f input Real u; output Real y; algorithm y := pre(u); end f; "
        "function g input Real u; output Real y; algorithm y := if initial() then 1 else u; end g; "
        "function h input Real u; output Real y; "
        "algorithm when u > 1 then y := 1; end when; end h; "
    )
    declared = "Real x(start = 1), y; Boolean b; Integer n;"
    assert code(f"{functions} model M {declared} equation der(x) = 1; {body} end M;") == wanted


def test_parameters_know_no_events():
    assert code("model M parameter Real p = if initial() then 1 else 2; end M;") == "T134"
    assert code("model M Real y = time; Real x(start = pre(y)) = 1; end M;") == "T134"
