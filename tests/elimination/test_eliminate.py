"""Elimination keeps every solution and finds what is there to find."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from flat_builder import FlatBuilder, OnePorts, S, call, ladder, t
from hypothesis import example, given, settings
from hypothesis import strategies as st

from acausal import compile_text
from acausal.diagnostics import AcausalError
from acausal.elimination.eliminate import Elimination, eliminate
from acausal.elimination.families import row_counts
from acausal.elimination.recover import divisors_hold, family_values, recovered
from acausal.expressions.text import to_text
from acausal.flattening.model import FlatModel, StateSelect


def residual(model: FlatModel, values: np.ndarray, time: float) -> np.ndarray:
    result = np.zeros(model.n_rows)
    for family in model.families:
        np.add.at(result, family.rows, family_values(family, values, model.parameters, time))
    return result


def check_equivalence(model: FlatModel, result: Elimination, seed: int = 0) -> None:
    """Rows that are left have the same residual, rows that are gone hold, at any point."""
    rng = np.random.default_rng(seed)
    active = np.where(result.active, rng.uniform(-1.0, 1.0, model.variables.count), np.nan)
    values = recovered(result, active, 0.3)
    used = np.zeros(model.variables.count, dtype=bool)
    for family in model.families:
        used[family.operands[[k for k, kind in enumerate(family.kinds) if kind == 0]]] = True
    assert np.isfinite(values[used]).all()
    before = residual(model, values, 0.3)
    after = residual(result.model, active, 0.3)
    assert np.isfinite(after).all()
    same = ~np.isin(result.row_of, result.recombined)
    np.testing.assert_allclose(before[result.row_of[same]], after[same], atol=1e-12, rtol=1e-12)
    if result.recombined.size:
        check_recombined(model, result, rng)
    gone = np.setdiff1d(np.arange(model.n_rows), np.union1d(result.row_of, result.recombined))
    np.testing.assert_allclose(before[gone], 0.0, atol=1e-12)
    # nothing that was eliminated is left in the reduced model
    for family in result.model.families:
        for k, kind in enumerate(family.kinds):
            if kind == 0:
                assert result.active[family.operands[k]].all()


def check_recombined(model: FlatModel, result: Elimination, rng: np.random.Generator) -> None:
    """Rows before and after are sums of each other where rows were added to others."""
    points = 3 * model.n_rows + 10
    before, after = np.zeros((points, model.n_rows)), np.zeros((points, result.model.n_rows))
    for k in range(points):
        active = np.where(result.active, rng.uniform(-1.0, 1.0, model.variables.count), np.nan)
        before[k] = residual(model, recovered(result, active, 0.3), 0.3)
        after[k] = residual(result.model, active, 0.3)
    for one, other in ((before, after), (after, before)):
        weights = np.linalg.lstsq(other, one, rcond=None)[0]
        np.testing.assert_allclose(other @ weights, one, atol=1e-9)


def balance(model: FlatModel, result: Elimination) -> None:
    """As many unknowns as rows are taken out, except for redundant rows."""

    def unknowns(derivative: np.ndarray, present: np.ndarray) -> int:
        is_derivative = np.zeros(present.shape[0], dtype=bool)
        is_derivative[derivative[derivative >= 0]] = True
        return int((present & ~is_derivative).sum())

    before = unknowns(model.derivative, np.ones(model.variables.count, dtype=bool))
    after = unknowns(result.model.derivative, result.active)
    assert model.n_rows - before == result.model.n_rows + result.redundant_rows.size - after


def name_of(model: FlatModel, ids) -> list[str]:
    return [model.names.variable(int(i)) for i in ids]


def test_alias_chain_with_signs():
    b = FlatBuilder()
    x, y, z, u = (b.variable(n) for n in "xyzu")
    b.equation(S[0] + S[1], x, y)
    b.equation(2 * S[0] - 2 * S[1], z, y)
    b.equation(-S[0] - S[1], z, u)
    b.equation(S[0] * S[0] - t, u)
    model = b.build()
    result = eliminate(model)
    assert result.representative.tolist() == [x, x, x, x]
    assert result.sign.tolist() == [1, -1, -1, 1]
    assert result.model.n_rows == 1
    check_equivalence(model, result)
    balance(model, result)


def test_contradicting_signs_are_zero():
    b = FlatBuilder()
    x, y, z = (b.variable(n) for n in "xyz")
    b.equation(S[0] - S[1], x, y)
    b.equation(S[0] + S[1], x, y)
    b.equation(S[0] - S[1] * S[1] - 1, z, y)
    model = b.build()
    result = eliminate(model)
    assert result.sign.tolist()[:2] == [0, 0]
    assert result.redundant_rows.size == 0
    check_equivalence(model, result)
    balance(model, result)


def test_zero_spreads_through_templates_and_junctions():
    b = FlatBuilder()
    i = b.variables("i", 4)
    v, w = b.variable("v"), b.variable("w")
    b.junction(i[0], i[1], i[2])
    b.equation(S[0], i[0])
    b.equation(S[0] - S[1] * S[2], v, i[0], w)  # v = i*w becomes v = 0
    b.equation(S[0] - S[1], i[2], i[3])
    b.equation(S[0] * S[1] - 1, w, i[3])
    b.equation(S[0] - S[1] - S[2], w, i[1], v)
    model = b.build()
    result = eliminate(model)
    assert result.sign[[i[0], v]].tolist() == [0, 0]
    assert result.sign[i[1]] == -result.sign[i[2]]
    check_equivalence(model, result)
    balance(model, result)


def test_second_order_chain():
    b = FlatBuilder()
    x = b.variable("x", start=1.0, fixed=True)
    v = b.variable("v")
    a = b.variable("a")
    dx, dv = b.der(x), b.der(v)
    b.equation(S[0] - S[1], v, dx)
    b.equation(S[0] - S[1], a, dv)
    b.equation(S[0] + S[1], a, x)
    model = b.build()
    result = eliminate(model)
    # a = der(v) = -x would make x its own second derivative: that row stays.
    assert result.model.n_rows == 1
    assert result.model.derivative[x] == v
    assert result.representative[dx] == v
    assert result.model.derivative[v] == dv
    assert (result.representative[a], result.sign[a]) == (x, -1)
    check_equivalence(model, result)
    balance(model, result)


@pytest.mark.parametrize("sign", [1, -1])
def test_variable_is_not_merged_with_its_derivative(sign):
    b = FlatBuilder()
    x, y = b.variable("x"), b.variable("y")
    dx = b.der(x)
    b.equation(S[0] - sign * S[1], y, x)
    b.equation(S[0] - S[1], dx, y)
    model = b.build()
    result = eliminate(model)
    assert result.model.n_rows == 1
    assert result.model.derivative[result.representative[x]] == dx
    check_equivalence(model, result)


def test_cycle_of_two_derivatives():
    b = FlatBuilder()
    x, y = b.variable("x"), b.variable("y")
    dx, dy = b.der(x), b.der(y)
    b.equation(S[0] - S[1], dx, y)
    b.equation(S[0] + S[1], dy, x)
    model = b.build()
    result = eliminate(model)
    # One of the two is an alias; both would make x its own second derivative.
    assert result.model.n_rows == 1
    assert result.model.derivative[[x, y]].tolist() == [y, dy]
    assert result.representative[dx] == y
    check_equivalence(model, result)


def test_derivative_congruence():
    b = FlatBuilder()
    x, y, f, g = (b.variable(n) for n in "xyfg")
    dx, dy = b.der(x), b.der(y)
    b.equation(S[0] + S[1], x, y)
    b.equation(S[0] - S[1] - S[2], dx, f, g)
    b.equation(S[0] * S[1] - t, g, f)
    b.equation(S[0] * S[1] - 1, f, dy)
    model = b.build()
    result = eliminate(model)
    assert result.representative[y] == x
    assert result.sign[y] == -1
    assert (result.representative[dy], result.sign[dy]) == (dx, -1)
    check_equivalence(model, result)


def test_constant_variable_keeps_its_differential_equation():
    b = FlatBuilder()
    x, y = b.variable("x", start=2.0, fixed=True), b.variable("y")
    dx = b.der(x)
    b.equation(S[0], dx)
    b.equation(S[0] - S[1] * S[1], y, x)
    result = eliminate(b.build())
    assert result.sign[x] == 1
    assert result.model.derivative[x] == dx
    assert result.model.n_rows == 1


def test_derivative_of_zero_is_zero():
    b = FlatBuilder()
    x, f = b.variable("x"), b.variable("f")
    dx = b.der(x)
    b.equation(S[0], x)
    b.equation(S[0] - S[1], dx, f)
    result = eliminate(b.build())
    assert not result.sign.any()
    assert result.model.n_rows == 0


def test_negative_derivative_alias():
    """h' = -v with v' in use: no variable can stand for h', the row stays."""
    b = FlatBuilder()
    h, v = b.variable("h"), b.variable("v")
    dh, dv = b.der(h), b.der(v)
    b.equation(S[0] + S[1], dh, v)
    b.equation(S[0] - 9.81, dv)
    model = b.build()
    result = eliminate(model)
    assert result.model.n_rows == 2
    assert result.model.derivative[[h, v]].tolist() == [dh, dv]
    check_equivalence(model, result)


def test_redundant_connection_loop():
    b = FlatBuilder()
    x = b.variables("x", 3)
    rows = [b.equation(S[0] - S[1], x[k], x[(k + 1) % 3]) for k in range(3)]
    b.equation(S[0] - t, x[0])
    model = b.build()
    result = eliminate(model)
    assert result.redundant_rows.tolist() == rows[2].tolist()
    balance(model, result)


def test_row_that_becomes_nothing_is_reported():
    b = FlatBuilder()
    p, n, v = (b.variable(k) for k in "pnv")
    b.equation(S[0] - S[1], p, n)
    row = b.equation(S[0] - S[1] - (S[0] - S[2]), v, p, n)  # p = n once more
    b.equation(S[0] * S[1] - 1, v, p)
    model = b.build()
    result = eliminate(model)
    assert result.redundant_rows.tolist() == row.tolist()
    balance(model, result)


def test_contradiction_stays_visible():
    b = FlatBuilder()
    x = b.variable("x")
    b.equation(S[0], x)
    row = b.equation(S[0] - 5.0, x)
    result = eliminate(b.build())
    assert result.row_of.tolist() == row.tolist()
    assert result.model.families[0].kinds == ()


def test_shorted_component_cancels_in_its_junction():
    b = FlatBuilder()
    r = OnePorts(b, "r", 1)
    s = OnePorts(b, "s", 1)
    R = b.parameter("R", 2.0)
    b.equation(S[0] - S[1] * S[2], r.v, R, r.i, parameters=[1])
    b.equation(S[0] - S[1] * S[2], s.v, R, s.i, parameters=[1])
    b.equation(S[0] - S[1], r.p_v, r.n_v)
    b.equation(S[0] - S[1], r.p_v, s.p_v)
    b.junction(r.p_i, r.n_i, s.p_i)
    b.equation(S[0], s.n_v)
    model = b.build()
    result = eliminate(model)
    assert result.sign[s.i] == 0
    check_equivalence(model, result)


def test_start_attributes_are_merged():
    b = FlatBuilder()
    x = b.variable("x", minimum=-1.0, maximum=5.0)
    y = b.variable("y", start=3.0, fixed=True, minimum=-2.0, maximum=0.5)
    z = b.variable("z", start=7.0, select=StateSelect.PREFER, nominal=100.0)
    dx = b.der(x)
    b.equation(S[0] + S[1], x, y)
    b.equation(S[0] - S[1], x, z)
    b.equation(S[0] - t, dx)
    variables = eliminate(b.build()).model.variables
    assert variables.start[x] == -3.0
    assert variables.start_given[x]
    assert variables.fixed[x]
    assert variables.nominal[x] == 100.0
    assert (variables.minimum[x], variables.maximum[x]) == (-0.5, 2.0)
    assert variables.state_select[x] == StateSelect.PREFER
    del z


def test_conflicting_fixed_starts_name_both():
    b = FlatBuilder()
    x = b.variable("mass.s", start=1.0, fixed=True)
    y = b.variable("spring.s", start=2.0, fixed=True)
    b.der(x)
    b.equation(S[0] - S[1], x, y)
    with pytest.raises(AcausalError) as caught:
        eliminate(b.build())
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "I001"
    assert "mass.s" in diagnostic.message
    assert "spring.s" in diagnostic.message


def test_fixed_start_of_a_zero():
    b = FlatBuilder()
    x = b.variable("x", start=1.0, fixed=True)
    b.equation(S[0], x)
    with pytest.raises(AcausalError, match="I002"):
        eliminate(b.build())


def test_ladder_comes_down_to_states():
    sections = 4
    model = ladder(sections, named=True)
    result = eliminate(model)
    names = set(name_of(model, np.flatnonzero(result.active)))
    states = {f"{x}[{k}]" for x in ("L.i", "C.v") for k in range(sections)}
    assert names == states | {f"der({x})" for x in states}
    check_equivalence(model, result)
    balance(model, result)
    without = eliminate(model, explicit_locals=False)
    assert not without.definitions
    check_equivalence(model, without)
    balance(model, without)


def test_templates_do_not_grow_with_the_model():
    small, large = eliminate(ladder(5)), eliminate(ladder(50))
    assert len(small.model.families) == len(large.model.families)
    assert len(small.definitions) == len(large.definitions)


def test_large_families():
    n = 100_000
    result = eliminate(ladder(n))
    assert result.model.n_rows == 2 * n
    assert result.active.sum() == 4 * n
    counts = row_counts(result.model.families, result.model.n_rows)
    assert counts.min() >= 1


def test_chain_of_one_family_keeps_its_templates():
    """x[k] = x[k-1] + u[k]*u[k]: nothing is put into each other a thousand times."""
    n = 1000
    b = FlatBuilder(named=False)
    x, u = b.variables("x", n), b.variables("u", n)
    b.equation(S[0] - S[1] - S[2] * S[2], x[1:], x[:-1], u[1:])
    b.equation(S[0] - t, x[:1])
    b.equation(S[0] * S[1] - 3 * t - 1, x, u)
    model = b.build()
    result = eliminate(model)
    assert len(result.model.families) < 12
    check_equivalence(model, result)


def test_fixed_variables_and_states_stay():
    b = FlatBuilder()
    x = b.variable("x", start=1.0, fixed=True)
    y = b.variable("y", select=StateSelect.PREFER)
    z = b.variable("z")
    b.equation(S[0] - S[1] * S[2], x, y, z)
    b.equation(S[0] - call("sin", S[1]), y, z)
    b.equation(S[0] - call("exp", S[1] + S[2]) + t, z, x, y)
    result = eliminate(b.build())
    assert result.active[[x, y]].all()


def test_initial_equations_and_assertions_follow():
    b = FlatBuilder()
    x, y, z = b.variable("x"), b.variable("y"), b.variable("z")
    dx = b.der(x)
    b.equation(S[0] + S[1], y, x)
    b.equation(S[0] - 2 * S[1], z, x)
    b.equation(S[0] - t, dx)
    b.initial(S[0] + S[1] - 4, y, z)
    b.assertion(S[0] * S[1], y, z, message="too large")
    result = eliminate(b.build())
    (family,) = result.model.initial
    assert family.operands.tolist() == [[x]]
    assert to_text(family.template) == "0 - 4"
    (assertion,) = result.model.assertions
    assert assertion.message == "too large"
    assert set(assertion.family.operands.ravel().tolist()) == {x}
    assert not result.active[z]


def test_output_of_a_velocity_goes_out_when_the_acceleration_is_in_use():
    b = FlatBuilder()
    x, v, a, energy = (b.variable(n) for n in ("x", "v", "a", "energy"))
    b.equation(S[0] - S[1], v, b.der(x))
    b.equation(S[0] - S[1], a, b.der(v))
    b.equation(S[0] - S[1] * S[1], energy, v)
    b.equation(S[0] + call("sin", S[1]), a, x)
    model = b.build()
    result = eliminate(model)
    assert not result.active[energy]
    assert result.model.n_rows == 1
    assert result.active[[x, v]].all()
    check_equivalence(model, result)


def test_derivative_in_one_output_only_keeps_its_row():
    """i = C*der(v), v = sin(t): without the row nobody would look for der(v)."""
    b = FlatBuilder()
    v, i = b.variable("v"), b.variable("i")
    dv = b.der(v)
    b.equation(S[0] - 3 * S[1], i, dv)
    b.equation(S[0] - call("sin", t), v)
    model = b.build()
    result = eliminate(model)
    assert result.model.n_rows == 2
    assert result.model.derivative[v] == dv
    check_equivalence(model, result)


def test_expensive_definitions_are_not_repeated_often():
    b = FlatBuilder()
    y = b.variable("y")
    e = b.variable("e")
    x = b.variables("x", 10)
    dy = b.der(y)
    b.equation(S[0] - call("exp", S[1]) * call("sin", S[1]), e, y)
    b.equation(S[0] * S[0] - S[1] * S[1], x, e)
    b.equation(S[0] - t, dy)
    model = b.build()
    result = eliminate(model)
    assert result.active[e]
    check_equivalence(model, result)


def test_division_by_parameters():
    values = [1.0, 2.0, 0.0, 3.0]
    b = FlatBuilder()
    i, u = b.variables("i", 4), b.variables("u", 4)
    R = b.parameter("R", values)
    b.equation(S[0] * S[1] - call("sin", S[2]), R, i, u, parameters=[0])
    b.equation(S[0] * S[0] * S[1] - 1 - t, u, i)
    model = b.build()
    plain = eliminate(model)
    assert plain.active.all()
    divided = eliminate(model, divide_by_parameters=True)
    assert divided.active[i].tolist() == [False, False, True, False]
    check_equivalence(model, divided)
    assert divisors_hold(divided, model.parameters)
    assert not divisors_hold(divided, np.zeros(4))
    assert divisors_hold(plain, np.zeros(4))


@st.composite
def networks(draw):
    """A connected graph of conductors, resistors, capacitors, inductors and sources."""
    nodes = draw(st.integers(2, 6))
    branches = [(k, draw(st.integers(0, k - 1))) for k in range(1, nodes)]
    extra = draw(st.lists(st.tuples(st.integers(0, nodes - 1), st.integers(0, nodes - 1))))
    branches += extra[:6]
    kinds = draw(st.lists(st.sampled_from("GRCLVID"), min_size=len(branches)))
    return nodes, list(zip(branches, kinds, strict=False))


# A chain of resistors in which one definition of a batch could refer to another one.
CHAIN = "G10 G20 G30 G40 R52 G00 R12 R15 R31"


@given(networks(), st.booleans(), st.booleans(), st.integers(0, 100))
@example((6, [((int(b[1]), int(b[2])), b[0]) for b in CHAIN.split()]), True, False, 0)
@settings(max_examples=150, deadline=None)
def test_any_network_keeps_its_solutions(network, explicit, divide, seed):
    nodes, branches = network
    b = FlatBuilder()
    ends: list[list[tuple[int, int]]] = [[] for _ in range(nodes)]
    for number, ((p, n), kind) in enumerate(branches):
        part = OnePorts(b, f"{kind}{number}", 1)
        value = b.parameter(f"{kind}{number}.value", 1.0 + number)
        law = {
            "G": (S[0] - S[1] * S[2], part.i, value, part.v),
            "R": (S[0] - S[1] * S[2], part.v, value, part.i),
            "V": (S[0] - S[1] * t, part.v, value),
            "I": (S[0] + S[1], part.i, value),
            "D": (S[0] - S[1] * (call("exp", S[2] / 1e6) - 1), part.i, value, part.v),
        }
        if kind in law:
            b.equation(*law[kind], parameters=[1])
        elif kind == "C":
            b.equation(S[0] - S[1] * S[2], part.i, value, b.der(part.v), parameters=[1])
        else:
            b.equation(S[0] - S[1] * S[2], part.v, value, b.der(part.i), parameters=[1])
        ends[p].append((part.p_v, part.p_i))
        ends[n].append((part.n_v, part.n_i))
    ground_v, ground_i = b.variable("ground.v"), b.variable("ground.i")
    ends[0].append((ground_v, ground_i))
    b.equation(S[0], ground_v)
    for node in ends:
        for (first, _), (second, _) in itertools.pairwise(node):
            b.equation(S[0] - S[1], first, second)
        b.junction(*[through for _, through in node])
    model = b.build()
    result = eliminate(model, explicit_locals=explicit, divide_by_parameters=divide)
    check_equivalence(model, result, seed)
    balance(model, result)


def test_a_small_difference_of_large_terms_is_no_definition() -> None:
    # b from the first row would be (h - 3 a)/1e-13: nothing but round-off. It stays an unknown
    # that the second row determines.
    compiled = compile_text("""
model M
  Real a, b, h, s;
equation
  a = 1 + time;
  h = 3*a + 1e-13*b;
  s = b + a;
  s*s*s + s = 10*h/3;
end M;
""")
    result = compiled.simulate(stop_time=1.0)
    a = 1 + result.times
    s = np.array([np.roots([1, 0, 1, -10 * x]).real[np.isreal(np.roots([1, 0, 1, -10 * x]))][0]
                  for x in a])  # fmt: skip
    assert result["b"].values == pytest.approx(s - a, rel=1e-5)
