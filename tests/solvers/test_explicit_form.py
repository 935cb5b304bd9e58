"""The explicit form and the band ordering."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csc_matrix, random_array
from systems import CallbackSystem, Pattern

from acausal.diagnostics import AcausalError
from acausal.solvers import explicit_form
from acausal.solvers.explicit_form import ExplicitForm
from acausal.solvers.failures import IntegrationError, Reason
from acausal.solvers.odes_ida import band_ordering
from acausal.solvers.protocol import NumberLabels


def form_of(system, y, yp):
    return ExplicitForm(system, 0.0, np.array(y), np.array(yp), 1e-6, 1e-6, NumberLabels())


def nonlinear():
    """2 x' + z = sin x, z + z^3 = x + u', u' = -z - u."""
    return CallbackSystem(
        lambda t, y, yp: [
            2 * yp[0] + y[2] - np.sin(y[0]),
            y[2] + y[2] ** 3 - y[0] - yp[1],
            yp[1] + y[2] + y[1],
        ],
        lambda t, y, yp: [[-np.cos(y[0]), 0, 1], [-1, 0, 1 + 3 * y[2] ** 2], [0, 1, 1]],
        lambda *_: [[2, 0, 0], [0, -1, 0], [0, 1, 0]],
        [True, True, False],
    )


def test_derivatives_solve_the_equations():
    system = nonlinear()
    form = form_of(system, [0, 0, 0], [0, 0, 0])
    for x in ([0.0, 0.0], [1.0, -2.0], [3.0, 5.0], [-4.0, 0.1]):
        y, yp = form.point(0.0, np.array(x))
        np.testing.assert_array_equal(y[:2], x)
        np.testing.assert_allclose(system.f(0.0, y, yp), 0, atol=1e-8)


def test_jacobian_equals_differences():
    form = form_of(nonlinear(), [0, 0, 0], [0, 0, 0])
    x = np.array([1.0, -2.0])
    jacobian = form.jacobian(0.0, x)
    for k in range(2):
        h = np.zeros(2)
        h[k] = 1e-5
        difference = (form.derivative(0.0, x + h) - form.derivative(0.0, x - h)) / 2e-5
        np.testing.assert_allclose(jacobian[:, k], difference, atol=1e-6)


def test_sparse_equals_dense():
    """Above the limit of dense linear algebra: a ring of 200 masses with algebraic forces."""
    m = 200
    spring = np.eye(m) - np.roll(np.eye(m), 1, axis=1)

    def make():
        zero, eye = np.zeros((m, m)), np.eye(m)
        dy = np.block([[zero, zero], [-spring, eye]])
        dy[:m, m:] = -spring.T
        dyp = np.block([[eye, zero], [zero, zero]])
        return CallbackSystem(
            lambda t, y, yp: dyp @ yp + dy @ y,
            lambda *_: dy,
            lambda *_: dyp,
            [True] * m + [False] * m,
            (dy != 0) | (dyp != 0),
        )

    form = form_of(make(), np.zeros(2 * m), np.zeros(2 * m))
    x = np.linspace(-1, 1, m) ** 3
    np.testing.assert_allclose(form.derivative(0.0, x), spring.T @ spring @ x, atol=1e-9)
    np.testing.assert_allclose(form.jacobian(0.0, x), spring.T @ spring, atol=1e-9)


def test_higher_index_is_refused():
    """x' = z, x = sin t: z is not determined by F_v."""
    system = CallbackSystem(
        lambda t, y, yp: [yp[0] - y[1], y[0] - np.sin(t)],
        lambda *_: [[0, -1], [1, 0]],
        lambda *_: [[1, 0], [0, 0]],
        [True, False],
    )
    with pytest.raises(IntegrationError) as caught:
        form_of(system, [0, 1], [1, 0]).point(0.0, np.array([0.0]))
    assert caught.value.failure.reason is Reason.SINGULAR


def test_too_many_states(monkeypatch):
    monkeypatch.setattr(explicit_form, "LARGEST_MATRIX", 5)
    with pytest.raises(AcausalError) as caught:
        form_of(nonlinear(), [0, 0, 0], [0, 0, 0]).jacobian(0.0, np.zeros(2))
    assert caught.value.diagnostics[0].code == "R117"


def test_no_solution():
    system = CallbackSystem(
        lambda t, y, yp: [yp[0] - y[1], y[1] ** 2 + 1 + y[0] ** 2],
        lambda t, y, yp: [[0, -1], [2 * y[0], 2 * y[1]]],
        lambda *_: [[1, 0], [0, 0]],
        [True, False],
    )
    with pytest.raises(IntegrationError) as caught:
        form_of(system, [0.0, 1.0], [1, 0]).point(0.0, np.array([0.3]))
    assert caught.value.failure.reason in (Reason.EXPLICIT_FORM, Reason.SINGULAR)


def pattern_of(matrix):
    matrix = csc_matrix(matrix)
    matrix.sort_indices()
    n = matrix.shape[0]
    return Pattern(n, matrix.indptr.astype(np.int64), matrix.indices, np.ones(n, bool), np.ones(n))


@settings(max_examples=40, deadline=None)
@given(st.integers(1, 30), st.integers(0, 2**32 - 1), st.floats(0.0, 0.3))
def test_band_contains_every_entry(n, seed, density):
    rng = np.random.default_rng(seed)
    noise = random_array((n, n), density=density, rng=rng, format="csr").toarray()
    matrix = (noise + np.eye(n)[rng.permutation(n)])[:, rng.permutation(n)]
    unknowns, rows, lower, upper = band_ordering(pattern_of(matrix))
    assert sorted(unknowns) == sorted(rows) == list(range(n))
    ordered = matrix[rows][:, unknowns]
    i, j = np.nonzero(ordered)
    assert (np.diag(ordered) != 0).all()
    assert (i - j).max() == lower
    assert (j - i).max() == upper


def test_shuffled_ladder_has_a_narrow_band():
    n = 400
    rng = np.random.default_rng(1)
    tridiagonal = np.eye(n) + np.eye(n, k=1) + np.eye(n, k=-1)
    order = rng.permutation(n)
    matrix = tridiagonal[order][:, order]
    *_, lower, upper = band_ordering(pattern_of(matrix))
    assert lower + upper <= 6
