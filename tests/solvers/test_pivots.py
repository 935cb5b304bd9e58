"""A sparse factorisation with kept pivots, one of which becomes zero beyond a kink."""

from __future__ import annotations

import numpy as np
import pytest
from systems import CallbackSystem

from acausal.solvers import consistent_point
from acausal.solvers.consistent_point import ConsistentPoint
from acausal.solvers.protocol import Options, Status, create


def kinked() -> CallbackSystem:
    """x' = 1 and [c 1; 1 -2] z = b with c = max(0, 1 - 2x): z is (1 + x, 2), det = -2c - 1."""

    def c(x: float) -> float:
        return max(0.0, 1.0 - 2.0 * x)

    def f(t, y, yp):
        x, z1, z2 = y
        return [yp[0] - 1.0, c(x) * z1 + z2 - c(x) * (1.0 + x) - 2.0, z1 - 2.0 * z2 - x + 3.0]

    def dy(t, y, yp):
        x, z1, _ = y
        slope = -2.0 if c(x) > 0.0 else 0.0
        return [[0, 0, 0], [slope * (z1 - 1.0 - x) - c(x), c(x), 1.0], [-1.0, 1.0, -2.0]]

    def dyp(t, y, yp):
        return np.diag([1.0, 0.0, 0.0])

    return CallbackSystem(f, dy, dyp, [True, False, False])


def test_a_pivot_that_becomes_zero_is_replaced() -> None:
    options = Options(relative_tolerance=1e-6, absolute_tolerance=1e-9, linear_solver="sparse")
    integrator = create(
        "ida", kinked(), 0.0, np.array([0.0, 1.0, 2.0]), np.array([1.0, 0.0, 0.0]), options
    )
    times = np.linspace(0.0, 1.0, 11)
    y, yp = np.zeros((11, 3)), np.zeros((11, 3))
    result = integrator.run(times, y, yp)
    assert result.status is Status.REACHED
    assert y == pytest.approx(np.column_stack([times, 1 + times, np.full(11, 2.0)]), abs=1e-5)
    assert integrator.statistics.convergence_failures <= 2


def test_a_consistent_point_beyond_the_kink(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(consistent_point, "DENSE_LIMIT", 0)
    point = ConsistentPoint(kinked())
    for x in (0.1, 0.9, 0.2):
        y, yp = np.array([x, 0.0, 0.0]), np.zeros(3)
        assert point.solve(0.0, y, yp) >= 0
        assert y == pytest.approx([x, 1 + x, 2])
