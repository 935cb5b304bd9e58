"""For and if equations, index arithmetic, slices, array expressions."""

from __future__ import annotations

import numpy as np
import pytest

from tests.flattening.static import refused, solve


def values(found: dict[str, float], name: str, *shape: int) -> list:
    """Return an array variable as nested lists."""
    result = np.empty(shape)
    for index in np.ndindex(*shape):
        result[index] = found[f"{name}[{','.join(str(i + 1) for i in index)}]"]
    return result.round(9).tolist()


def array(declaration: str, name: str, *shape: int, **options) -> list:
    return values(solve(f"model M {declaration} end M;", **options), name, *shape)


def loop(body: str, n: int = 5) -> list:
    return array(f"parameter Integer n = {n}; Real x[n]; equation {body}", "x", n)


def test_a_recursion():
    assert loop("x[1] = 1; for i in 2:n loop x[i] = 2*x[i-1] + i; end for;", 4) == [1, 4, 11, 26]


def test_a_condition_on_the_loop_index_picks_the_equation():
    body = (
        "for i in 1:n loop if i == 1 then x[i] = 1; elseif i == n then x[i] = 100; "
        "else x[i] = x[i-1] + 1; end if; end for;"
    )
    assert loop(body) == [1, 2, 3, 4, 100]


def test_a_condition_inside_of_an_expression_guards_subscripts():
    assert loop("for i in 1:n loop x[i] = if i > 1 then x[i-1] + 1 else 10; end for;") == [
        10, 11, 12, 13, 14,
    ]  # fmt: skip


def test_steps_and_backward_loops():
    assert loop("for i in 1:2:n loop x[i] = i; x[i+1] = -i; end for;", 6) == [1, -1, 3, -3, 5, -5]
    assert loop("for i in n:-1:1 loop x[n+1-i] = i; end for;", 3) == [3, 2, 1]


def test_computed_subscripts():
    assert loop("for i in 1:n loop x[mod(i, n) + 1] = i; end for;", 4) == [4, 1, 2, 3]
    text = (
        "parameter Integer k[3] = {3, 1, 2}; Real x[3]; "
        "equation for i in 1:3 loop x[k[i]] = i; end for;"
    )
    assert array(text, "x", 3) == [2, 3, 1]


def test_loops_over_a_vector():
    assert loop("for i in {5, 1, 2, 4, 3} loop x[i] = i^2; end for;") == [1, 4, 9, 16, 25]


def test_two_indices_and_triangles():
    both = "Real x[2,3]; equation for i in 1:2, j in 1:3 loop x[i,j] = 10*i + j; end for;"
    assert array(both, "x", 2, 3) == [[11, 12, 13], [21, 22, 23]]
    triangle = (
        "Real x[3,3]; equation for i in 1:3 loop for j in 1:i loop x[i,j] = i*j; end for; "
        "for j in i+1:3 loop x[i,j] = 0; end for; end for;"
    )
    assert array(triangle, "x", 3, 3) == [[1, 0, 0], [2, 4, 0], [3, 6, 9]]


def test_an_empty_loop_says_nothing():
    found = solve(
        "model M parameter Integer n = 0; Real x[n]; Real y = sum(x) + 1; "
        "equation for i in 1:n loop x[i] = 1; end for; end M;"
    )
    assert found == pytest.approx({"y": 1.0})


def test_subscripts_out_of_range_are_named():
    message = refused(
        "model M Real x[3]; equation x[1] = 0; for i in 2:4 loop x[i] = x[i-1]; end for; end M;"
    )
    assert message.code == "T114"
    assert "4" in message.message and "1..3" in message.message


def test_slices():
    found = solve(
        "model M Real x[5] = {1, 2, 3, 4, 5}; Real y[3] = x[2:4]; Real z[2] = x[{1, 5}]; "
        "Real w[3] = x[1:2:5]; Real e = x[end]; Real f[2] = x[end-1:end]; end M;"
    )
    assert values(found, "y", 3) == [2, 3, 4]
    assert values(found, "z", 2) == [1, 5]
    assert values(found, "w", 3) == [1, 3, 5]
    assert values(found, "f", 2) == [4, 5]
    assert found["e"] == pytest.approx(5.0)


@pytest.mark.parametrize(
    ("expression", "shape", "expected"),
    [
        ("{1, 2}.*{3, 4}", (2,), [3, 8]),
        ("{1, 2}./{2, 4}", (2,), [0.5, 0.5]),
        ("{1, 2}.^2", (2,), [1, 4]),
        ("2*{1, 2} - {1, 1}/2", (2,), [1.5, 3.5]),
        ("{1, 2} .+ 1", (2,), [2, 3]),
        ("-{1, 2}", (2,), [-1, -2]),
        ("sin({0, 0})", (2,), [0, 0]),
        ("[1, 2, 3; 4, 5, 6]*{1, 0, 2}", (2,), [7, 16]),
        ("{1, 2}*[1, 2; 3, 4]", (2,), [7, 10]),
        ("[1, 2; 3, 4]*[0, 1; 1, 0]", (2, 2), [[2, 1], [4, 3]]),
        ("[1, 1; 0, 1]^3", (2, 2), [[1, 3], [0, 1]]),
        ("transpose([1, 2, 3; 4, 5, 6])", (3, 2), [[1, 4], [2, 5], [3, 6]]),
        ("identity(2)", (2, 2), [[1, 0], [0, 1]]),
        ("diagonal({3, 4})", (2, 2), [[3, 0], [0, 4]]),
        ("linspace(0, 1, 3)", (3,), [0, 0.5, 1]),
        ("0:0.5:1", (3,), [0, 0.5, 1]),
        ("cross({1, 0, 0}, {0, 1, 0})", (3,), [0, 0, 1]),
        ("cat(1, {1, 2}, {3})", (3,), [1, 2, 3]),
        ("[[1, 2]; [3, 4]]", (2, 2), [[1, 2], [3, 4]]),
        ("fill(7, 2, 2)", (2, 2), [[7, 7], [7, 7]]),
        ("outerProduct({1, 2}, {3, 4})", (2, 2), [[3, 4], [6, 8]]),
        ("skew({1, 2, 3})", (3, 3), [[0, -3, 2], [3, 0, -1], [-2, 1, 0]]),
        ("{i^2 for i in 1:3}", (3,), [1, 4, 9]),
        ("{i*j for i in 1:2, j in 1:2}", (2, 2), [[1, 2], [2, 4]]),
        ("if time > 1 then {1, 2} else {3, 4}", (2,), [3, 4]),
    ],
)
def test_array_expressions(expression, shape, expected):
    dimensions = ", ".join(map(str, shape))
    assert array(f"Real x[{dimensions}] = {expression};", "x", *shape) == expected


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("sum({1, 2, 3})", 6),
        ("sum(i^2 for i in 1:4)", 30),
        ("sum(i*j for i in 1:2, j in 1:3)", 18),
        ("sum(zeros(0))", 0),
        ("product(i for i in 1:4)", 24),
        ("max({1, 5, 3})", 5),
        ("min(i^2 for i in 2:4)", 4),
        ("{1, 2}*{3, 4}", 11),
        ("size([1, 2, 3; 4, 5, 6], 2)", 3),
        ("ndims([1, 2; 3, 4])", 2),
        ("scalar({{7}})", 7),
        ("mod(-7, 3)", 2),
        ("rem(-7, 3)", -1),
        ("div(-7, 3)", -2),
        ("integer(-2.5)", -3),
        ("if not (1 > 2 or false) and true then 1 else 0", 1),
        ("semiLinear(-2, 3, 5)", -10),
        ("homotopy(actual = 3, simplified = 1)", 3),
    ],
)
def test_scalar_expressions(expression, expected):
    assert solve(f"model M Real x = {expression}; end M;")["x"] == pytest.approx(expected)


def test_derivatives_of_expressions():
    found = solve(
        "model M Real x(start = 2); Real y; equation der(x) = 3; y = der(x^2 + time); end M;"
    )
    assert found["y"] == pytest.approx(13.0)


@pytest.mark.parametrize(
    ("expression", "code"),
    [
        ("{1, 2} + {1, 2, 3}", "T104"),
        ("[1, 2; 3, 4]*{1, 2, 3}", "T104"),
        ("1/{1, 2}", "T105"),
        ("sum(i for i in 1:1000000)", "T107"),
        ("{1, 2}[3]", "P"),
        ("x + true", "T101"),
        ("if 1 then 2 else 3", "T102"),
        ("if time > 0 then {1, 2} else 3", "T104"),
        ("{1, true}", "T101"),
        ("foo(1)", "N116"),
        ("sin(1, 2)", "T120"),
        ("1:0:3", "T109"),
    ],
)
def test_wrong_expressions(expression, code):
    found = refused(f"model M Real x; Real y = {expression}; equation x = 1; end M;")
    assert found.code.startswith(code)
