"""The native driver: residual, Jacobian and roots of whole problems."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csc_matrix

from acausal.assembly.problem import DAEProblem, KernelCall, RootProblem
from acausal.codegen.driver import NativeProblem
from acausal.codegen.kernels import compile_kernels
from acausal.expressions.build import call, div, mul, power, sub
from acausal.expressions.nodes import TIME, ZERO, Expr, const, slot

S = [slot(number) for number in range(4)]


@pytest.fixture(autouse=True, scope="module")
def _own_cache(tmp_path_factory: pytest.TempPathFactory):
    patch = pytest.MonkeyPatch()
    patch.setenv("ACAUSAL_CACHE", str(tmp_path_factory.mktemp("cache")))
    yield
    patch.undo()


def assemble(
    n: int, parameters: np.ndarray, families: list[tuple[Expr, np.ndarray, np.ndarray]]
) -> DAEProblem:
    """Build a problem from (template, operand positions in w ``(m, count)``, rows)."""
    kernels = compile_kernels([(t, tuple(range(len(index)))) for t, index, _ in families])
    rows, columns = [], []
    for kernel, (_, index, target) in zip(kernels, families, strict=True):
        for j in kernel.variable_slots:
            unknown = (index[j] >= 2) & (index[j] < 2 + 2 * n)
            rows.append(target[unknown])
            columns.append((index[j][unknown] - 2) % n)
    cells = np.concatenate([np.zeros(0), *rows]), np.concatenate([np.zeros(0), *columns])
    pattern = csc_matrix((np.ones(cells[0].size), cells), shape=(n, n))
    pattern.sort_indices()
    nnz = pattern.nnz
    position = csc_matrix((np.arange(nnz), pattern.indices, pattern.indptr), shape=(n, n)).toarray()
    calls = []
    for kernel, (_, index, target) in zip(kernels, families, strict=True):
        entry = np.full((kernel.q, target.size), 2 * nnz, dtype=np.int32)
        for number, j in enumerate(kernel.variable_slots):
            unknown = (index[j] >= 2) & (index[j] < 2 + 2 * n)
            column = index[j][unknown] - 2
            entry[number, unknown] = position[target[unknown], column % n] + nnz * (column >= n)
        index = np.ascontiguousarray(index, dtype=np.int32)
        calls.append(KernelCall(kernel, index, target.astype(np.int32), entry))
    return DAEProblem(
        n, tuple(calls), np.concatenate([np.zeros(2 + 2 * n), parameters]),
        pattern.indptr.astype(np.int64), pattern.indices.astype(np.int32),
        np.ones(n, dtype=bool), np.ones(n),
    )  # fmt: skip


def chain(n: int) -> DAEProblem:
    """c x_k' = (x_{k-1} - 2 x_k + x_{k+1})/r - x_k^3 + sin(t): RC chain with a nonlinear leak."""
    k = np.arange(n)
    x, xp = 2 + k, 2 + n + k
    left, right = np.where(k > 0, x - 1, 0), np.where(k < n - 1, x + 1, 0)
    c, r = 2 + 2 * n + k, np.full(n, 2 + 3 * n)
    parameters = np.concatenate([np.linspace(1.0, 2.0, n), [0.5]])
    conduct = div(sub(S[0], S[1]), S[2])
    return assemble(
        n, parameters,
        [
            (mul(S[0], S[1]), np.array([c, xp]), k),
            (conduct, np.array([x, left, r]), k),
            (conduct, np.array([x, right, r]), k),
            (sub(power(S[0], const(3.0)), call("sin", TIME)), np.array([x]), k),
        ],
    )  # fmt: skip


def chain_reference(n: int, t: float, x: np.ndarray, xp: np.ndarray, c: np.ndarray, r: float):
    """Return residual, dF/dy and dF/dy' of the chain, written directly."""
    wide = np.concatenate([[0.0], x, [0.0]])
    residual = c * xp + (2 * x - wide[:-2] - wide[2:]) / r + x**3 - np.sin(t)
    matrix = (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)) / r + np.diag(3 * x**2)
    return residual, matrix, np.diag(c)


@pytest.mark.parametrize("n", [1, 2, 7, 100])
def test_residual_and_jacobian_of_a_chain(n: int):
    problem = chain(n)
    native = NativeProblem(problem)
    rng = np.random.default_rng(n)
    for t, cj in ((0.0, 1.0), (0.3, 250.0)):
        x, xp = rng.normal(size=n), rng.normal(size=n)
        c, r = problem.w[problem.parameter_position :][:n], problem.w[-1]
        residual, matrix, mass = chain_reference(n, t, x, xp, c, r)
        out, values = np.full(n, np.nan), np.full(problem.nnz, np.nan)
        assert native.residual(t, x, xp, out) == 0
        np.testing.assert_allclose(out, residual, rtol=1e-13, atol=1e-13)
        assert native.jacobian_values(t, cj, x, xp, values) == 0
        full = csc_matrix((values, problem.indices, problem.indptr), shape=(n, n)).toarray()
        np.testing.assert_allclose(full, matrix + cj * mass, rtol=1e-13, atol=1e-13)
        by_y, by_yp = native.partial_values()
        np.testing.assert_allclose(by_y + cj * by_yp, values, rtol=1e-13)
    assert (native.residual_evaluations, native.jacobian_evaluations) == (2, 2)
    np.testing.assert_array_equal(problem.w[:2], [0.0, 0.3])


def test_changed_parameters_are_seen_by_the_constant_part():
    problem = chain(5)
    native = NativeProblem(problem)
    x, xp, values = np.ones(5), np.zeros(5), np.zeros(problem.nnz)
    native.jacobian_values(0.0, 1.0, x, xp, values)
    before = values.copy()
    problem.w[-1] = 0.25
    problem.w[problem.parameter_position] = 7.0
    native.jacobian_values(0.0, 1.0, x, xp, values)
    _, matrix, mass = chain_reference(
        5, 0.0, x, xp, problem.w[problem.parameter_position :][:5], 0.25
    )
    full = csc_matrix((values, problem.indices, problem.indptr), shape=(5, 5)).toarray()
    np.testing.assert_allclose(full, matrix + mass, rtol=1e-14)
    assert not np.allclose(before, values)


def test_a_value_that_is_not_finite_is_recoverable():
    for bad, n in ((np.inf, 9), (np.nan, 3)):
        problem = chain(n)
        native = NativeProblem(problem)
        out = np.zeros(n)
        for position in (0, n - 1):
            x = np.zeros(n)
            x[position] = bad
            assert native.residual(0.0, x, np.zeros(n), out) == 1
        assert native.residual(0.0, np.zeros(n), np.zeros(n), out) == 0
    tiny = assemble(1, np.zeros(0), [(call("log", S[0]), np.array([[2]]), np.array([0]))])
    assert NativeProblem(tiny).residual(0.0, np.array([-1.0]), np.zeros(1), np.zeros(1)) == 1


def test_stop_flag():
    native = NativeProblem(chain(3))
    y, out = np.zeros(3), np.zeros(3)
    native.request_stop()
    assert native.residual(0.0, y, y, out) == -1
    assert native.jacobian_values(0.0, 1.0, y, y, np.zeros(native.problem.nnz)) == -1
    assert native.residual_evaluations == 0
    native.request_stop(False)
    assert native.residual(0.0, y, y, out) == 0


def test_state_may_be_given_as_the_work_vector_itself():
    problem = chain(4)
    native = NativeProblem(problem)
    problem.w[2:10] = np.arange(8.0)
    out = np.zeros(4)
    assert native.residual(0.0, problem.w[2:6], problem.w[6:10], out) == 0
    np.testing.assert_array_equal(problem.w[2:10], np.arange(8.0))


def test_wrong_arrays_are_refused():
    problem = chain(4)
    native = NativeProblem(problem)
    with pytest.raises(ValueError, match="expected"):
        native.residual(0.0, np.zeros(3), np.zeros(4), np.zeros(4))
    with pytest.raises(ValueError, match="expected"):
        native.jacobian_values(0.0, 1.0, np.zeros(4), np.zeros(4), np.zeros(4))
    problem.calls[0].index[0, 0] = problem.w.size
    with pytest.raises(ValueError, match="outside"):
        NativeProblem(problem)


def test_problem_without_kernels():
    problem = assemble(2, np.zeros(0), [])
    native = NativeProblem(problem)
    out = np.ones(2)
    assert native.residual(0.0, np.zeros(2), np.zeros(2), out) == 0
    np.testing.assert_array_equal(out, 0.0)
    assert ZERO.value == 0.0


# Root functions -------------------------------------------------------------------------------


def with_roots(problem: DAEProblem, shift: np.ndarray) -> DAEProblem:
    """Add ``y_k - 0.5`` for every unknown, numbered backwards, and last ``t - y'_0``."""
    n = problem.n
    level, clock = compile_kernels([(sub(S[0], const(0.5)), ()), (sub(TIME, S[0]), ())])
    none = np.zeros((0, n), np.int32)
    calls = (
        KernelCall(
            level,
            (2 + np.arange(n, dtype=np.int32))[None],
            np.arange(n, dtype=np.int32)[::-1].copy(),
            none,
        ),
        KernelCall(clock, np.array([[2 + n]], np.int32), np.array([n], np.int32), none[:, :1]),
    )
    return replace(problem, roots=RootProblem(n + 1, calls, shift))


def test_roots_are_values_plus_shifts():
    n = 5
    shift = np.linspace(0.0, 1.0, n + 1)
    native = NativeProblem(with_roots(chain(n), shift))
    assert native.root_count == n + 1
    y, yp, out = np.arange(n) * 0.3, np.arange(n) + 2.0, np.full(n + 1, 7.0)
    assert native.roots(0.25, y, yp, out) == 0
    np.testing.assert_allclose(out, np.append((y - 0.5)[::-1], 0.25 - 2.0) + shift, rtol=1e-15)
    shift[2] += 10.0
    before = out.copy()
    native.roots(0.25, y, yp, out)
    np.testing.assert_allclose(out - before, [0, 0, 10, 0, 0, 0], atol=1e-14)


def test_roots_tell_that_they_are_not_finite():
    native = NativeProblem(with_roots(chain(3), np.zeros(4)))
    y, yp, out = np.array([0.0, np.nan, 1.0]), np.zeros(3), np.zeros(4)
    assert native.roots(0.0, y, yp, out) == 1
    np.testing.assert_array_equal(np.isfinite(out), [True, False, True, True])


def test_every_root_needs_one_kernel():
    problem = with_roots(chain(3), np.zeros(4))
    problem.roots.calls[1].target[0] = 2
    with pytest.raises(ValueError, match="exactly one"):
        NativeProblem(problem)
    with pytest.raises(ValueError, match="shift"):
        NativeProblem(with_roots(chain(3), np.zeros(3)))
