"""Consistent restarts: differential unknowns are kept, everything else follows."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from native_problems import build, oscillators, pendulum
from systems import oscillator

from acausal.codegen.driver import NativeProblem
from acausal.expressions.build import add, call, div, mul, sub
from acausal.expressions.nodes import const, slot
from acausal.solvers import consistent_point
from acausal.solvers.consistent_point import ConsistentPoint
from acausal.solvers.protocol import create

A, B, C = slot(0), slot(1), slot(2)
one = np.array


def residual(native: NativeProblem, t: float, y: np.ndarray, yp: np.ndarray) -> np.ndarray:
    out = np.zeros(native.problem.n)
    assert native.residual(t, y, yp, out) == 0
    return out


@pytest.mark.parametrize("limit", [60, 0])
def test_linear_system(limit: int, monkeypatch: pytest.MonkeyPatch):
    """Native dense LU, and the sparse solver of large systems."""
    monkeypatch.setattr(consistent_point, "DENSE_LIMIT", limit)
    problem = oscillators(5, omega=3.0)
    rng = np.random.default_rng(1)
    y, yp = rng.normal(size=15), rng.normal(size=15)
    before = y.copy()
    count = ConsistentPoint(NativeProblem(problem)).solve(0.0, y, yp)
    assert 1 <= count <= 3
    np.testing.assert_array_equal(y[:10], before[:10])
    np.testing.assert_allclose(y[10:], -9.0 * y[:5], rtol=1e-14)
    np.testing.assert_allclose(yp[:5], y[5:10], rtol=1e-14)
    np.testing.assert_allclose(yp[5:10], y[10:], rtol=1e-14)


@given(seed=st.integers(0, 1000), size=st.integers(1, 12))
@settings(max_examples=30, deadline=None)
def test_random_linear_systems(seed: int, size: int):
    """M z = b(x) with random regular M, all z algebraic, rows and columns badly scaled."""
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(size, size)) + 0.1 * np.eye(size)
    matrix *= 10.0 ** rng.uniform(-6, 6, size=(size, 1))
    matrix *= 10.0 ** rng.uniform(-3, 3, size=(1, size))
    right = matrix @ rng.normal(size=size)
    n, first = size, 2 + 2 * size
    rows, columns = np.divmod(np.arange(size * size), size)
    problem = build(
        np.zeros(n, bool),
        [*matrix.ravel(), *right],
        [
            (mul(A, B), [first + np.arange(size * size), 2 + columns], rows),
            (sub(const(0.0), A), [first + size * size + np.arange(size)], np.arange(size)),
        ],
    )
    y, yp = np.zeros(n), np.zeros(n)
    assert ConsistentPoint(NativeProblem(problem)).solve(0.0, y, yp) >= 1
    scale = np.abs(matrix) @ np.abs(y)
    assert np.all(np.abs(matrix @ y - right) <= 1e-12 * (scale + np.abs(right)))


def test_nonlinear_equation(solver):
    """z + exp(z) = 3 + x, x' = -z."""
    problem = build(
        one([True, False]),
        [],
        [
            (add(A, B), [one([4]), one([3])], one([0])),
            (sub(add(A, call("exp", A)), add(B, const(3.0))), [one([3]), one([2])], one([1])),
        ],
    )
    integrator = create(solver, problem, 0.0, one([0.0, 0.7920599684]), one([-0.79206, 0.0]))
    y, yp = one([2.0, 0.0]), one([9.0, 77.0])
    assert 4 <= integrator.consistent(1.0, y, yp) <= 12
    assert y[0] == 2.0
    assert y[1] + np.exp(y[1]) == pytest.approx(5.0, rel=1e-14)
    assert yp[0] == pytest.approx(-y[1], rel=1e-14)


def test_callback_system():
    system = oscillator(omega=2.0)
    y, yp = one([1.0, 0.5, 0.0]), np.zeros(3)
    assert ConsistentPoint(system).solve(0.0, y, yp) >= 1
    np.testing.assert_allclose(y, [1.0, 0.5, 0.125 + 2.0])
    np.testing.assert_allclose(yp[:2], [0.5, -4.0])


@pytest.mark.parametrize("limit", [60, 0])
def test_failures_leave_the_values(limit: int, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(consistent_point, "DENSE_LIMIT", limit)
    singular = build(
        one([False, False]),
        [1.0],
        [(add(A, B), [one([2, 2]), one([3, 3])], one([0, 1]))],
    )
    no_solution = build(one([False]), [1.0], [(add(mul(A, A), B), [one([2]), one([4])], one([0]))])
    pole = build(one([False]), [1.0], [(div(B, A), [one([2]), one([4])], one([0]))])
    for problem in (singular, no_solution, pole):
        y, yp = np.full(problem.n, 0.3), np.zeros(problem.n)
        if problem is pole:
            y[:] = 0.0
        before = y.copy()
        assert ConsistentPoint(NativeProblem(problem)).solve(0.0, y, yp) == -1
        np.testing.assert_array_equal(y, before)


def test_roundoff_of_large_terms_is_no_failure():
    """A derivative that is the small difference of large currents: C v' = i1 - i2."""
    problem = build(
        one([True, False, False]),
        [1e-6, 1e3, 1e3 * (1.0 + 1e-15)],
        [
            (
                sub(mul(slot(0), slot(1)), sub(slot(2), slot(3))),
                [one([8]), one([5]), one([3]), one([4])],
                one([0]),
            ),
            (sub(A, B), [one([3, 4]), one([9, 10])], one([1, 2])),
        ],
    )
    y, yp = np.zeros(3), np.zeros(3)
    assert ConsistentPoint(NativeProblem(problem)).solve(0.0, y, yp) >= 0
    np.testing.assert_allclose(y[1:], 1e3)


def test_pendulum_has_its_acceleration(solver):
    y = one([0.5, 1.0, -9.81 * np.sin(0.5)])
    integrator = create(solver, pendulum(), 0.0, y, one([1.0, y[2], 0.0]))
    kicked, yp = one([0.5, -2.0, 0.0]), np.zeros(3)
    assert integrator.consistent(0.0, kicked, yp) >= 0
    np.testing.assert_allclose(kicked, [0.5, -2.0, -9.81 * np.sin(0.5)])
    np.testing.assert_allclose(yp[:2], [-2.0, kicked[2]])
