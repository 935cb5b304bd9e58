"""The native driver: residual, Jacobian and SUNDIALS callbacks of whole problems."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest
from scipy.sparse import csc_matrix

from acausal.assembly.problem import DAEProblem, KernelCall
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


# SUNDIALS callbacks, with stand-ins for the accessor functions of the library ------------------

_ACCESSOR = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p)
_JACOBIAN_FUNCTION = ctypes.CFUNCTYPE(
    ctypes.c_int, ctypes.c_double, ctypes.c_double, *[ctypes.c_void_p] * 8
)
_RESIDUAL_FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double, *[ctypes.c_void_p] * 4)


def _accessor(field: int):
    """Return a function that reads a pointer from a record of pointers."""
    return _ACCESSOR(lambda record: ctypes.cast(record, ctypes.POINTER(ctypes.c_void_p))[field])


def _address(function: object) -> int:
    return ctypes.cast(function, ctypes.c_void_p).value


def _record(*arrays: np.ndarray) -> np.ndarray:
    return np.array([array.ctypes.data for array in arrays], dtype=np.int64)


@pytest.mark.parametrize("bits", [32, 64])
def test_ida_callbacks(bits: int):
    n = 6
    problem = chain(n)
    native = NativeProblem(problem)
    kind = np.dtype(f"int{bits}")
    data, pointers, indices = _accessor(0), _accessor(1), _accessor(2)
    native.bind_sundials(*map(_address, (data, data, pointers, indices)), index_bits=bits)
    rng = np.random.default_rng(0)
    y, yp, r = rng.normal(size=n), rng.normal(size=n), np.zeros(n)
    vectors = [_record(array) for array in (y, yp, r)]
    arguments = [vector.ctypes.data for vector in vectors]
    residual = _RESIDUAL_FUNCTION(native.ida_residual_address)
    assert residual(0.4, *arguments, native.table_address) == 0
    c, resistance = problem.w[problem.parameter_position :][:n], problem.w[-1]
    expected, matrix, mass = chain_reference(n, 0.4, y, yp, c, resistance)
    np.testing.assert_allclose(r, expected, rtol=1e-13)

    values = np.zeros(problem.nnz)
    written = np.zeros(n + 1, dtype=kind), np.zeros(problem.nnz, dtype=kind)
    sparse = _record(values, *written)
    jacobian = _JACOBIAN_FUNCTION(native.ida_jacobian_sparse_address)
    tail = (native.table_address, None, None, None)
    assert jacobian(0.4, 30.0, *arguments, sparse.ctypes.data, *tail) == 0
    full = csc_matrix((values, written[1], written[0]), shape=(n, n)).toarray()
    np.testing.assert_allclose(full, matrix + 30.0 * mass, rtol=1e-13)

    columns = np.zeros((n, n))
    dense = _record(columns)
    jacobian = _JACOBIAN_FUNCTION(native.ida_jacobian_dense_address)
    assert jacobian(0.4, 30.0, *arguments, dense.ctypes.data, *tail) == 0
    np.testing.assert_allclose(columns.T, matrix + 30.0 * mass, rtol=1e-13)
    native.request_stop()
    assert residual(0.4, *arguments, native.table_address) == -1
    assert jacobian(0.4, 30.0, *arguments, dense.ctypes.data, *tail) == -1
