"""Native kernels against the interpreter of the same code and against the reference semantics."""

from __future__ import annotations

import logging
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from acausal.codegen import kernels
from acausal.codegen.interpreter import interpret
from acausal.codegen.ir import KernelCode
from acausal.codegen.kernels import compile_kernels, template_code, template_key
from acausal.expressions.build import add, call, div, if_, mul, neg, power, relation, sub
from acausal.expressions.differentiate import partial
from acausal.expressions.evaluate import evaluate
from acausal.expressions.nodes import FUNCTIONS, ONE, TIME, ZERO, Expr, const, node, slot
from tests.expressions.strategies import expressions

S = [slot(number) for number in range(8)]
TWO = const(2.0)


@pytest.fixture(autouse=True, scope="module")
def _own_cache(tmp_path_factory: pytest.TempPathFactory):
    previous = os.environ.get("ACAUSAL_CACHE")
    os.environ["ACAUSAL_CACHE"] = str(tmp_path_factory.mktemp("cache"))
    yield
    if previous is None:
        del os.environ["ACAUSAL_CACHE"]
    else:
        os.environ["ACAUSAL_CACHE"] = previous


def members(m: int, count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Return a work vector and random operands of ``count`` members."""
    rng = np.random.default_rng(seed)
    w = rng.uniform(-2.0, 2.0, 40)
    w[0], w[1] = 0.0, 0.7
    return w, rng.integers(0, w.size, (m, count)).astype(np.int32)


def run(template: Expr, wanted: tuple[int, ...], count: int = 7, seed: int = 0):
    """Return kernel, reference residual and partials, native residual and partials."""
    kernel = compile_kernels([(template, wanted)])[0]
    w, index = members(kernel.m, count, seed)
    target = np.arange(count, dtype=np.int32)[::-1].copy()
    entry = np.arange(kernel.q * count, dtype=np.int32).reshape(kernel.q, count)
    residual, jacobian = np.zeros(count), np.zeros(kernel.q * count)
    kernel.evaluate_residual(w, index, target, residual)
    kernel.evaluate_jacobian(w, index, entry, jacobian)
    code = template_code(template, wanted)
    assert code.variable_slots == kernel.variable_slots
    expected_residual, expected_jacobian = np.zeros(count), np.zeros(kernel.q * count)
    interpret(code.residual, w, index, target, expected_residual)
    interpret(code.jacobian, w, index, entry, expected_jacobian)
    np.testing.assert_allclose(residual, expected_residual, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(jacobian, expected_jacobian, rtol=1e-12, atol=1e-12)
    return kernel, w[index], residual[target], jacobian.reshape(kernel.q, count)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(expressions(), st.integers(0, 5))
def test_native_code_equals_interpreter_and_reference(template: Expr, seed: int):
    kernel, operands, residual, jacobian = run(template, (0, 1, 2), seed=seed)
    count = residual.size

    def reference(expr: Expr) -> np.ndarray:
        return np.broadcast_to(evaluate(expr, lambda k: operands[k], 0.7), count)

    np.testing.assert_allclose(residual, reference(template), rtol=1e-12, atol=1e-12)
    for row, number in zip(jacobian, kernel.variable_slots, strict=True):
        expected = reference(partial(template, slot(number)))
        np.testing.assert_allclose(row, expected, rtol=1e-10, atol=1e-10)


def test_partials_equal_complex_step():
    x, y, z = S[:3]
    template = add(
        mul(call("exp", div(sub(x, y), const(0.7))), call("sin", mul(y, z))),
        div(power(x, const(3.0)), add(const(5.0), mul(z, z))),
    )
    kernel, operands, _, jacobian = run(template, (0, 1, 2))
    code = template_code(template, ())
    count = operands.shape[1]
    step = 1e-30
    for j in range(3):
        w = np.concatenate([[0.0, 0.7], operands.ravel()]).astype(np.complex128)
        w[2 + j * count : 2 + (j + 1) * count] += 1j * step
        index = 2 + np.arange(3 * count, dtype=np.int32).reshape(3, count)
        out = np.zeros(count, dtype=np.complex128)
        interpret(code.residual, w, index, np.arange(count, dtype=np.int32), out)
        np.testing.assert_allclose(jacobian[j], out.imag / step, rtol=1e-12)
    assert kernel.variable_slots == (0, 1, 2)


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_every_function(name: str):
    arguments = [mul(const(0.45), slot(number)) for number in range(FUNCTIONS[name])]
    if name in ("log", "log10", "sqrt"):
        arguments = [add(power(S[0], TWO), const(0.1))]
    template = call(name, *arguments)
    _, operands, residual, _ = run(template, (0, 1)[: FUNCTIONS[name]], count=50)
    expected = evaluate(template, lambda k: operands[k])
    np.testing.assert_allclose(residual, expected, rtol=1e-14, atol=1e-300)


@pytest.mark.parametrize("exponent", [-3.0, -2.0, -1.5, -0.5, 0.5, 1.5, 2.0, 3.0, 7.0, 32.0])
def test_small_powers_need_no_library(exponent: float):
    template = power(add(ONE, mul(S[0], S[0])), const(exponent))
    _, operands, residual, _ = run(template, (0,))
    np.testing.assert_allclose(residual, (1 + operands[0] ** 2) ** exponent, rtol=1e-13)
    assert "math" not in operations(template_code(template, (0,)).jacobian)


def operations(code: KernelCode) -> list[str]:
    return [item.op for item in code.body]


def test_value_and_derivative_share_the_exponential():
    diode = mul(S[2], sub(call("exp", div(sub(S[0], S[1]), const(0.025))), ONE))
    code = template_code(diode, (0, 1, 2)).jacobian
    assert operations(code).count("math") == 1
    root = call("sqrt", add(power(S[0], TWO), power(S[1], TWO)))
    assert operations(template_code(root, (0, 1)).jacobian).count("sqrt") == 1


def test_division_by_a_power_of_two_is_a_multiplication():
    assert "div" not in operations(template_code(div(S[0], const(8.0)), ()).residual)
    assert "div" in operations(template_code(div(S[0], const(10.0)), ()).residual)


def test_what_no_member_changes_is_computed_once():
    source = sub(S[0], mul(S[1], call("sin", mul(const(314.0), TIME))))
    code = template_code(source, (0,)).residual
    assert "math" in [item.op for item in code.prologue]
    assert "math" not in operations(code)
    run(source, (0, 1))


def test_structurally_zero_partials_are_left_out():
    template = sub(sub(S[0], S[1]), mul(S[2], call("floor", S[3])))
    kernel = compile_kernels([(template, (3, 1, 0))])[0]
    assert kernel.variable_slots == (1, 0)
    assert kernel.jacobian_operands == ()
    assert not kernel.jacobian_reads_time
    by_resistance = compile_kernels([(template, (2,))])[0]
    assert by_resistance.variable_slots == (2,)
    assert by_resistance.jacobian_operands == (3,)
    assert by_resistance.key != kernel.key


# Branches -----------------------------------------------------------------------------------


def exponential_with_linear_continuation() -> Expr:
    limit = const(1.0)
    steep = call("exp", S[0])
    straight = mul(call("exp", limit), add(ONE, sub(S[0], limit)))
    return if_(relation("lt", S[0], limit), mul(S[1], steep), mul(S[2], straight))


def test_costly_sides_become_branches_shared_with_the_derivative():
    code = template_code(exponential_with_linear_continuation(), (0, 1, 2)).jacobian
    assert operations(code).count("if") == 1
    assert operations(code).count("merge") == 2  # by S[2]: no library call
    inside = operations(code)[operations(code).index("if") : operations(code).index("end")]
    assert "math" in inside
    run(exponential_with_linear_continuation(), (0, 1, 2), count=100)


def test_cheap_sides_stay_selects():
    template = if_(relation("gt", S[0], ZERO), mul(S[0], S[1]), neg(S[0]))
    assert "if" not in operations(template_code(template, (0,)).residual)


def test_nested_and_entangled_branches():
    positive, other = relation("gt", S[0], ZERO), relation("gt", S[1], ZERO)
    sine, cosine = call("sin", S[2]), call("cos", S[3])
    inner = if_(other, sine, mul(call("tan", S[2]), S[0]))
    first = if_(positive, mul(inner, cosine), call("exp", S[3]))
    second = if_(other, add(first, cosine), call("exp", mul(S[3], TWO)))
    third = if_(positive, mul(second, call("atan", first)), inner)
    template = add(mul(first, second), mul(third, inner))
    kernel, operands, residual, _ = run(template, (0, 1, 2, 3), count=200)
    np.testing.assert_allclose(
        residual, evaluate(template, lambda k: operands[k]), rtol=1e-12, atol=1e-12
    )
    assert kernel.variable_slots == (0, 2, 3)
    assert operations(template_code(template, ()).residual).count("if") >= 2


@pytest.mark.parametrize("seed", range(12))
def test_random_branches_with_shared_parts(seed: int):
    rng = np.random.default_rng(seed)
    conditions = [relation("gt", S[0], ZERO), relation("lt", S[1], S[0])]
    nodes: list[Expr] = S[:4]
    for _ in range(40):
        a, b = (nodes[i] for i in rng.integers(max(0, len(nodes) - 12), len(nodes), 2))
        kind = rng.integers(0, 5)
        if kind == 0:
            nodes.append(call("sin", add(a, b)))
        elif kind == 1:
            nodes.append(mul(const(0.5), sub(a, b)))
        elif kind == 2:
            nodes.append(call("tanh", mul(a, b)))
        else:
            nodes.append(if_(conditions[int(rng.integers(0, 2))], a, b))
    total: Expr = ZERO
    for item in nodes[-6:]:
        total = add(total, item)
    run(total, (0, 1, 2, 3), count=60, seed=seed)


def test_deep_chain_of_conditions():
    template: Expr = call("exp", S[0])
    for number in range(300):
        condition = relation("lt", S[0], const(number / 100.0 - 2.0))
        template = if_(condition, call("sin", mul(const(number + 2.0), S[0])), template)
    run(template, (0,), count=300)


def test_side_not_taken_does_no_harm():
    template = if_(relation("gt", S[0], ZERO), call("log", S[0]), div(ONE, ZERO))
    _, operands, residual, _ = run(template, (0,), count=40)
    positive = operands[0] > 0
    np.testing.assert_allclose(residual[positive], np.log(operands[0][positive]))
    assert np.all(np.isinf(residual[~positive]))


def test_nan_comes_through_min_max_and_sign():
    kernel = compile_kernels([(node("call", (S[0], S[1]), name), ()) for name in ("min", "max")])
    w = np.array([0.0, 0.0, np.nan, 1.0])
    index = np.array([[2, 3], [3, 2]], dtype=np.int32)
    for item in kernel:
        out = np.zeros(2)
        item.evaluate_residual(w, index, np.arange(2, dtype=np.int32), out)
        assert np.all(np.isnan(out))


# Signature ----------------------------------------------------------------------------------


def test_residual_adds_and_value_stores():
    kernel = compile_kernels([(mul(S[0], S[1]), (0,))])[0]
    w, index = np.array([0.0, 0.0, 3.0, 5.0, 7.0]), np.array([[2, 3], [3, 4]], dtype=np.int32)
    out = np.array([100.0, 1.0])
    kernel.evaluate_residual(w, index, np.array([0, 0], dtype=np.int32), out)
    np.testing.assert_array_equal(out, [150.0, 1.0])
    out = np.array([np.nan, np.nan])
    kernel.evaluate_value(w, index, np.array([1, 0], dtype=np.int32), out)
    np.testing.assert_array_equal(out, [35.0, 15.0])
    kernel.evaluate_value(w, index[:, :0].copy(), np.zeros(0, dtype=np.int32), out)
    np.testing.assert_array_equal(out, [35.0, 15.0])


def test_wrong_arrays_are_refused():
    kernel = compile_kernels([(mul(S[0], S[1]), (0,))])[0]
    w, index, target = np.zeros(4), np.zeros((2, 3), dtype=np.int32), np.zeros(3, dtype=np.int32)
    with pytest.raises(ValueError, match="operands"):
        kernel.evaluate_residual(w, index[:1], target, np.zeros(1))
    with pytest.raises(ValueError, match="contiguous"):
        kernel.evaluate_residual(w, np.asfortranarray(index), target, np.zeros(1))
    with pytest.raises(ValueError, match="contiguous"):
        kernel.evaluate_residual(w, index, target.astype(np.int64), np.zeros(1))


def test_constant_and_slotless_templates():
    kernel, _, residual, _ = run(const(4.0), (), count=3)
    assert (kernel.m, kernel.q) == (0, 0)
    np.testing.assert_array_equal(residual, 4.0)
    run(TIME, (), count=3)
    assert compile_kernels([(S[1], (0, 5))])[0].m == 6


def test_a_million_members():
    count = 1_000_000
    kernel = compile_kernels([(sub(S[0], mul(const(3.0), S[1])), (0, 1))])[0]
    w = np.arange(2.0 * count + 2.0)
    index = (2 + np.arange(2 * count, dtype=np.int32)).reshape(2, count)
    out = np.zeros(count)
    kernel.evaluate_residual(w, index, np.arange(count, dtype=np.int32), out)
    np.testing.assert_array_equal(out, w[index[0]] - 3.0 * w[index[1]])


@pytest.mark.parametrize("operations_wanted", [2000, 6000])
def test_big_templates(operations_wanted: int):
    rng = np.random.default_rng(3)
    nodes: list[Expr] = [*S]
    while len(nodes) < operations_wanted:
        a, b = (nodes[i] for i in rng.integers(max(0, len(nodes) - 50), len(nodes), 2))
        kind = rng.integers(0, 8)
        made = call("sin", a) if kind == 0 else mul(a, call("tanh", b)) if kind < 3 else sub(a, b)
        nodes.append(mul(const(0.5), made))
    total: Expr = ZERO
    for item in nodes[-50:]:
        total = add(total, item)
    run(total, (0,) if operations_wanted > 5000 else (0, 1, 2), count=3)


def test_long_sums_have_cheap_gradients():
    total = ZERO
    for number in range(1000):
        total = add(total, mul(slot(2 * number), slot(2 * number + 1)))
    kernel = compile_kernels([(call("sqrt", total), tuple(range(2000)))])[0]
    assert kernel.q == 2000
    assert len(template_code(call("sqrt", total), range(2000)).jacobian.body) < 12_000


# Cache --------------------------------------------------------------------------------------

_PROGRAM = """
import logging, sys
import numpy as np
logging.basicConfig(level=logging.DEBUG, stream=sys.stderr, format="%(name)s %(message)s")
from acausal.codegen.kernels import compile_kernels
from acausal.expressions.build import call, mul, sub
from acausal.expressions.nodes import slot
x, y = slot(0), slot(1)
kernels = compile_kernels([(sub(call("exp", x), y), (0, 1)), (mul(x, y), (0, 1))])
out = np.zeros(1)
w = np.array([0.0, 0.0, 2.0, 3.0])
for kernel in kernels:
    kernel.evaluate_residual(w, np.array([[2], [3]], np.int32), np.zeros(1, np.int32), out)
print(float(out[0]))
"""


def _program(cache: Path) -> tuple[float, str]:
    environment = {**os.environ, "ACAUSAL_CACHE": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", _PROGRAM],
        env=environment, capture_output=True, text=True, check=True,
        cwd=Path(__file__).parents[2],
    )  # fmt: skip
    return float(done.stdout), done.stderr


def test_second_process_compiles_nothing(tmp_path: Path):
    value, log = _program(tmp_path)
    assert "2 compiled, 0 cached" in log
    again, log = _program(tmp_path)
    assert "0 compiled, 2 cached" in log
    assert value == again == pytest.approx(np.exp(2.0) - 3.0 + 6.0, rel=1e-15)


def test_damaged_entry_is_rebuilt(tmp_path: Path):
    value, _ = _program(tmp_path)
    entries = sorted((tmp_path / "kernel").iterdir())
    assert len(entries) == 2
    content = bytearray(entries[0].read_bytes())
    content[len(content) // 2] ^= 0xFF
    entries[0].write_bytes(content)
    again, log = _program(tmp_path)
    assert "1 compiled, 1 cached" in log
    assert again == value
    _, log = _program(tmp_path)
    assert "0 compiled, 2 cached" in log


def test_loaded_kernels_are_not_loaded_again(caplog: pytest.LogCaptureFixture):
    pair = (sub(S[0], mul(const(17.0), S[1])), (0, 1))
    first = compile_kernels([pair, pair])
    with caplog.at_level(logging.DEBUG, logger=kernels.__name__):
        again = compile_kernels([pair])
    assert not caplog.records
    assert first[0] is first[1] is again[0]


def test_pickled_kernel_is_the_kernel():
    kernel = compile_kernels([(sub(S[0], mul(const(19.0), S[1])), (1, 0))])[0]
    assert pickle.loads(pickle.dumps(kernel)) is kernel


def test_key_depends_on_content():
    keys = {
        template_key(template, slots)
        for template in (S[0], neg(S[0]), add(S[0], const(0.0)), add(S[0], const(1.0)), S[1])
        for slots in ((), (0,), (0, 1), (1, 0))
    }
    assert len(keys) == 16  # x + 0 is x
    assert template_key(S[0], (0,)) == template_key(slot(0), (0,))
