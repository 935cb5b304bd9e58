"""Construction, traversal, differentiation, linearity, evaluation and text of expressions."""

from __future__ import annotations

import gc
import pickle

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from acausal.expressions.build import (
    add,
    and_,
    call,
    div,
    homotopy,
    if_,
    mul,
    neg,
    noevent,
    not_,
    or_,
    power,
    relation,
    smooth,
    sub,
)
from acausal.expressions.differentiate import partial, partials, time_derivative
from acausal.expressions.evaluate import evaluate
from acausal.expressions.latex import latex_name, to_latex
from acausal.expressions.linearity import linear_coefficient, split_linear
from acausal.expressions.nodes import FUNCTIONS, ONE, TIME, ZERO, Expr, const, node, slot
from acausal.expressions.serialize import from_records, to_records
from acausal.expressions.text import to_text
from acausal.expressions.traverse import depends_on, postorder, size, slots, substitute
from tests.expressions.strategies import expressions

X, Y, Z = slot("x"), slot("y"), slot("z")
TWO, THREE = const(2.0), const(3.0)


def test_equal_expressions_are_one_object():
    assert add(X, mul(TWO, Y)) is add(X, mul(TWO, Y))
    assert sub(X, Y) is not sub(Y, X)
    assert const(0.0) is not const(-0.0)


@pytest.mark.parametrize(
    ("made", "expected"),
    [
        (add(ZERO, X), X),
        (add(X, neg(Y)), sub(X, Y)),
        (add(X, mul(const(-1.0), Y)), sub(X, Y)),
        (sub(X, X), ZERO),
        (sub(X, neg(Y)), add(X, Y)),
        (sub(ZERO, X), neg(X)),
        (neg(neg(X)), X),
        (neg(sub(X, Y)), sub(Y, X)),
        (mul(ZERO, X), ZERO),
        (mul(X, ONE), X),
        (mul(neg(X), neg(Y)), mul(X, Y)),
        (div(X, ONE), X),
        (div(neg(X), Y), neg(div(X, Y))),
        (power(X, ONE), X),
        (power(X, ZERO), ONE),
        (add(TWO, THREE), const(5.0)),
        (power(TWO, THREE), const(8.0)),
        (call("sqrt", const(9.0)), THREE),
        (if_(relation("lt", TWO, THREE), X, Y), X),
        (if_(relation("lt", X, Y), Z, Z), Z),
        (and_(ONE, X), X),
        (or_(ZERO, X), X),
        (not_(not_(X)), X),
        (homotopy(X, X), X),
        (call("abs", neg(X)), call("abs", X)),
    ],
)
def test_simplification(made: Expr, expected: Expr):
    assert made is expected


def test_what_would_fail_is_kept():
    assert div(ONE, ZERO) is node("div", (ONE, ZERO))
    assert div(ZERO, ZERO) is node("div", (ZERO, ZERO))
    assert call("log", const(-1.0)).op == "call"
    assert power(const(-1.0), const(0.5)).op == "pow"
    assert mul(const(1e300), const(1e300)).op == "mul"


def test_functions_are_checked():
    with pytest.raises(ValueError, match="no elementary function"):
        call("sin", X, Y)
    with pytest.raises(ValueError, match="not a relation"):
        relation("add", X, Y)


def test_deep_expressions_need_no_recursion():
    total: Expr = X
    for number in range(20_000):
        total = add(total, mul(const(float(number + 2)), slot(number)))
    assert len(slots(total)) == 20_001
    assert depends_on(total, slot(19_999))
    assert partial(total, slot(5)) is const(7.0)
    assert substitute(total, {X: ZERO}).op == "add"
    assert to_text(total, str).endswith("...")
    assert time_derivative(total, lambda s: ONE if s is X else ZERO) is ONE
    del total
    gc.collect()


def test_records_restore_deep_expressions():
    total: Expr = X
    for number in range(20_000):
        total = sub(call("sin", total), const(number + 0.1))
    again = from_records(*pickle.loads(pickle.dumps(to_records(total, add(X, ONE)))))
    assert again[0] is total
    assert again[1] is add(X, ONE)


def test_slots_in_order_of_appearance():
    assert slots(add(mul(Y, X), add(Z, X))) == ("y", "x", "z")


def test_postorder_has_each_node_once_after_its_arguments():
    shared = mul(X, Y)
    order = postorder(add(shared, call("sin", shared)))
    assert len(order) == len(set(order)) == size(add(shared, call("sin", shared))) == 5
    for position, item in enumerate(order):
        assert all(argument in order[:position] for argument in item.args)


def test_substitution_is_simultaneous_and_simplifies():
    assert substitute(sub(X, Y), {X: Y, Y: X}) is sub(Y, X)
    assert substitute(add(mul(X, Y), Z), {X: ZERO}) is Z


def test_textbook_derivatives():
    assert partial(power(X, THREE), X) is mul(THREE, power(X, TWO))
    assert partial(call("sin", X), X) is call("cos", X)
    assert partial(call("exp", mul(TWO, X)), X) is mul(call("exp", mul(TWO, X)), TWO)
    assert partial(call("sqrt", X), X) is div(ONE, mul(TWO, call("sqrt", X)))
    assert partial(call("abs", X), X) is call("sign", X)
    assert partial(relation("lt", X, Y), X) is ZERO
    assert partial(call("floor", X), X) is ZERO
    assert partial(call("mod", X, Y), X) is ONE
    assert partial(noevent(mul(X, Y)), X) is Y
    assert partial(smooth(2, mul(X, add(Y, Z))), X) is smooth(1, add(Y, Z))
    assert partial(homotopy(mul(TWO, X), X), X) is homotopy(TWO, ONE)
    assert partial(add(X, add(X, X)), X) is THREE


def test_branch_guards_its_derivative():
    guarded = if_(relation("gt", X, ZERO), call("sqrt", X), ZERO)
    values = evaluate(partial(guarded, X), {"x": [-1.0, 0.0, 4.0]})
    np.testing.assert_array_equal(values, [0.0, 0.0, 0.25])


def test_total_derivative_of_a_constraint():
    # Length constraint of a pendulum: x^2 + y^2 - l^2 = 0 gives 2 x vx + 2 y vy = 0.
    constraint = sub(add(power(X, TWO), power(Y, TWO)), power(slot("l"), TWO))
    rate = {X: slot("vx"), Y: slot("vy")}
    derivative = time_derivative(constraint, lambda s: rate.get(s, ZERO))
    assert derivative is add(mul(mul(TWO, X), slot("vx")), mul(mul(TWO, Y), slot("vy")))
    assert time_derivative(call("sin", mul(TWO, TIME)), lambda s: ZERO) is mul(
        call("cos", mul(TWO, TIME)), TWO
    )


def test_derivative_of_a_shared_dag_stays_small():
    nested: Expr = X
    for _ in range(60):  # as a tree this would have 2^60 nodes
        nested = call("sin", mul(nested, nested))
    assert size(partial(nested, X)) < 600
    doubled: Expr = X
    for _ in range(60):
        doubled = node("add", (doubled, doubled))
    assert partial(doubled, X) is const(2.0**60)


VALUES = st.lists(
    st.floats(-2.0, 2.0, allow_nan=False).map(lambda v: round(v, 3)), min_size=3, max_size=3
)


@settings(max_examples=150, deadline=None)
@given(expressions(), VALUES, st.floats(0.0, 2.0))
def test_partials_equal_finite_differences(expr: Expr, values: list[float], time: float):
    wanted = [slot(0), slot(1), slot(2)]
    derivatives = partials(expr, wanted)
    for j, item in enumerate(wanted):
        slopes = []
        for step in (1e-5, 0.5e-5):
            at = np.array(values)[:, None] + np.zeros(5)
            at[j] += step * np.arange(-2, 3)
            f = np.broadcast_to(evaluate(expr, lambda k, at=at: at[k], time), 5)
            one_sided = (f[3:] - f[1:3]) / step, (f[2:4] - f[0:2]) / step
            # Near a kink or where the expression is steep, differences say nothing.
            assume(np.all(np.isfinite(f)) and np.abs(f).max() < 1e4)
            slopes += [*one_sided[0], *one_sided[1]]
        assume(np.ptp(slopes) < 1e-3 * (1 + abs(slopes[0])))
        exact = float(evaluate(derivatives[item], lambda k: values[k], time))
        central = (8 * (f[3] - f[1]) - (f[4] - f[0])) / (12 * step)
        assert exact == pytest.approx(central, rel=2e-3, abs=2e-3)


@settings(max_examples=100, deadline=None)
@given(expressions(), VALUES)
def test_linear_split_reproduces_the_expression(expr: Expr, values: list[float]):
    split = split_linear(expr, slot(0))
    assume(split is not None)
    a, b = split
    assert not depends_on(a, slot(0))
    assert not depends_on(b, slot(0))
    whole, slope, rest = (float(evaluate(e, lambda k: values[k], 0.5)) for e in (expr, a, b))
    scale = abs(slope * values[0]) + abs(rest) + 1.0
    assert whole == pytest.approx(slope * values[0] + rest, abs=1e-9 * scale)


def test_linear_coefficients():
    assert linear_coefficient(sub(X, mul(Y, Z)), X) is ONE
    assert linear_coefficient(sub(X, mul(Y, Z)), Y) is neg(Z)
    assert linear_coefficient(div(X, Y), X) is div(ONE, Y)
    assert linear_coefficient(div(X, Y), Y) is None
    assert linear_coefficient(mul(X, X), X) is None
    assert linear_coefficient(call("sin", X), X) is None
    assert linear_coefficient(Y, X) is ZERO
    switch = if_(relation("gt", Y, ZERO), X, mul(TWO, X))
    assert linear_coefficient(switch, X) is if_(relation("gt", Y, ZERO), ONE, TWO)
    assert linear_coefficient(switch, Y) is None


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_constant_folding_agrees_with_evaluation(name: str):
    for numbers in ((0.5, -0.75), (0.25, 2.0), (-0.5, 0.3)):
        arguments = numbers[: FUNCTIONS[name]]
        folded = call(name, *map(const, arguments))
        expected = evaluate(
            node("call", tuple(slot(i) for i in range(len(arguments))), name), arguments.__getitem__
        )
        if folded.op == "const":
            assert folded.value == pytest.approx(float(expected), rel=1e-15)
        else:
            assert not np.isfinite(expected)


def test_integer_functions_as_in_modelica():
    def value(name: str, *numbers: float) -> float:
        return float(evaluate(node("call", tuple(map(const, numbers)), name), {}))

    assert value("integer", -1.5) == -2.0
    assert value("div", -7.0, 2.0) == -3.0
    assert value("mod", -1.4, 1.5) == pytest.approx(0.1)
    assert value("rem", -1.4, 1.5) == pytest.approx(-1.4)


@pytest.mark.parametrize(
    ("expr", "text"),
    [
        (add(X, mul(Y, Z)), "x + y*z"),
        (mul(add(X, Y), Z), "(x + y)*z"),
        (sub(X, sub(Y, Z)), "x - (y - z)"),
        (sub(sub(X, Y), Z), "x - y - z"),
        (div(X, mul(Y, Z)), "x/(y*z)"),
        (power(add(X, ONE), TWO), "(x + 1)^2"),
        (power(neg(X), TWO), "(-x)^2"),
        (neg(power(X, TWO)), "-x^2"),
        (mul(const(-2.0), X), "-2*x"),
        (sub(Y, node("mul", (const(-2.0), X))), "y - (-2*x)"),
        (mul(const(1e-6), X), "1e-6*x"),
        (call("atan2", X, add(Y, ONE)), "atan2(x, y + 1)"),
        (and_(relation("lt", X, Y), not_(relation("ge", Y, Z))), "x < y and not y >= z"),
        (add(ONE, if_(relation("ne", X, Y), X, Y)), "1 + (if x <> y then x else y)"),
        (noevent(add(X, TIME)), "noEvent(x + time)"),
        (smooth(2, add(X, Y)), "smooth(2, x + y)"),
    ],
)
def test_text(expr: Expr, text: str):
    assert to_text(expr) == text


@pytest.mark.parametrize(
    ("expr", "text"),
    [
        (div(X, add(Y, ONE)), r"\frac{x}{y + 1}"),
        (call("sqrt", mul(TWO, X)), r"\sqrt{2 \, x}"),
        (power(call("sin", X), TWO), r"{\sin\left(x\right)}^{2}"),
        (mul(X, TWO), r"x \cdot 2"),
        (mul(const(1e-6), X), r"10^{-6} \, x"),
        (call("exp", div(X, Y)), r"e^{\frac{x}{y}}"),
        (noevent(call("abs", X)), r"\left|x\right|"),
    ],
)
def test_latex(expr: Expr, text: str):
    assert to_latex(expr) == text


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("phi_rel", r"\varphi_{\mathrm{rel}}"),
        ("der(x)", r"\dot{x}"),
        ("der(der(phi))", r"\ddot{\varphi}"),
        ("R1", "R_{1}"),
        ("r[3].v", r"v_{\mathrm{r}[3]}"),
        ("body.r_0[2]", r"r_{0,2,\mathrm{body}}"),
        ("velocity", r"\mathit{velocity}"),
    ],
)
def test_latex_names(name: str, text: str):
    assert latex_name(name) == text
