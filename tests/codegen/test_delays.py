"""Histories of delayed values."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicHermiteSpline

from acausal.assembly.problem import KernelCall
from acausal.codegen.delays import DelayTable
from acausal.codegen.kernels import compile_kernels
from acausal.expressions.build import add, mul
from acausal.expressions.nodes import TIME, const, slot


def table(*maxima: float) -> DelayTable:
    """Return a table that writes to w[2], w[3], .."""
    count = len(maxima)
    return DelayTable(2 + np.arange(count, dtype=np.int32), np.array(maxima))


def value(delays: DelayTable, t: float) -> np.ndarray:
    w = np.full(2 + delays.count, -99.0)
    delays.evaluate(t, w)
    return w[2:]


@given(seed=st.integers(0, 10_000), size=st.integers(2, 200))
@settings(max_examples=40, deadline=None)
def test_hermite_polynomials(seed: int, size: int):
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.01, 1.0, size))
    values, slopes = rng.normal(size=(2, size, 2))
    delays = table(1e3, 2e3)
    for row in zip(times, values, slopes, strict=True):
        delays.append(*row)
    known = CubicHermiteSpline(times, values, slopes)
    for s in [*rng.uniform(times[0], times[-1], 10), times[0], times[-1]]:
        expected = known(s)[0], known(s)[1]
        np.testing.assert_allclose(value(delays, s + 1e3)[0], expected[0], rtol=1e-8, atol=1e-9)
        np.testing.assert_allclose(value(delays, s + 2e3)[1], expected[1], rtol=1e-8, atol=1e-9)


def test_ends():
    delays = table(1.0)
    np.testing.assert_array_equal(value(delays, 5.0), [-99.0])  # nothing known: left alone
    delays.append(2.0, np.array([7.0]), np.array([3.0]))
    assert value(delays, 2.5)[0] == 7.0  # constant before
    assert value(delays, 3.5)[0] == 7.0 + 3.0 * 0.5  # straight after
    delays.append(3.0, np.array([9.0]), np.array([0.0]))
    assert value(delays, 2.5)[0] == 7.0
    with pytest.raises(ValueError, match="before the last"):
        delays.append(2.9, np.array([0.0]))
    assert (len(delays), delays.last_time) == (2, 3.0)
    delays.clear()
    assert len(delays) == 0


def test_both_sides_of_a_jump():
    delays = table(0.1)
    for t, v in ((0.0, 1.0), (0.3, 1.0), (0.3, 5.0), (0.6, 5.0)):
        delays.append(t, np.array([v]), np.zeros(1))
    assert value(delays, 0.3 + 0.1)[0] == pytest.approx(1.0)  # however it is rounded
    assert value(delays, 0.4 - 1e-9)[0] == pytest.approx(1.0)
    assert value(delays, 0.4 + 1e-9)[0] == pytest.approx(5.0)
    assert not delays.right
    delays.right = True
    assert value(delays, 0.3 + 0.1)[0] == pytest.approx(5.0)


def test_long_histories_are_forgotten():
    delays = table(0.5, 1.0)
    for k in range(20_000):
        t = 0.01 * k
        delays.append(t, np.array([t, -2.0 * t]), np.array([1.0, -2.0]))
        if k > 200:
            np.testing.assert_allclose(value(delays, t), [t - 0.5, -2.0 * (t - 1.0)], rtol=1e-9)
    assert len(delays) < 500
    assert delays._times.size <= 512


def test_estimated_slopes_are_exact_for_parabolas():
    """Also on each side of a kink, and at the ends."""
    rng = np.random.default_rng(2)
    left, right = np.sort(rng.uniform(0.0, 1.0, 6)), np.sort(rng.uniform(1.0, 2.0, 6))
    delays = table(10.0)
    for t in (*left, 1.0):
        delays.append(t, np.array([3.0 * t**2 - t]))
    for t in (1.0, *right):
        delays.append(t, np.array([5.0 - t**2]))
    for s in rng.uniform(left[0], 1.0, 20):
        assert value(delays, s + 10.0)[0] == pytest.approx(3.0 * s**2 - s)
    for s in rng.uniform(1.0, right[-1], 20):
        assert value(delays, s + 10.0)[0] == pytest.approx(5.0 - s**2)


def test_delays_from_kernels():
    """Delays 0.5 + 0.1 t and 2 w[5]."""
    first, second = compile_kernels(
        [(add(const(0.5), mul(const(0.1), TIME)), ()), (mul(const(2.0), slot(0)), ())]
    )
    none = np.zeros((0, 1), np.int32)
    calls = [
        KernelCall(first, np.zeros((0, 1), np.int32), np.array([0], np.int32), none),
        KernelCall(second, np.array([[5]], np.int32), np.array([1], np.int32), none),
    ]
    delays = DelayTable(np.array([2, 3], np.int32), np.array([5.0, 5.0]), calls)
    for t in (0.0, 10.0):
        delays.append(t, np.array([t, 100.0 * t]), np.array([1.0, 100.0]))
    w = np.array([0.0, 6.0, 0.0, 0.0, 0.0, 1.25])
    delays.evaluate(6.0, w)
    np.testing.assert_allclose(w[2:4], [6.0 - 1.1, 100.0 * 3.5])
    np.testing.assert_allclose(delays.delays, [1.1, 2.5])
    with pytest.raises(ValueError, match="exactly one"):
        DelayTable(np.array([2, 3], np.int32), np.array([5.0, 5.0]), calls[:1])
