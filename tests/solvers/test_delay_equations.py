"""Delay differential equations by integrators that know nothing of delays."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from native_problems import build

from acausal.codegen.delays import DelayTable
from acausal.expressions.build import add, mul, sub
from acausal.expressions.nodes import const, slot
from acausal.solvers.protocol import Options, Status, create

A, B = slot(0), slot(1)
one = np.array


def method_of_steps(t: float) -> float:
    """Solution of y'(t) = -y(t - 1), y = 1 before 0: sum of (-1)^k (t - k + 1)^k / k!."""
    last = math.floor(t) + 1
    return sum((-1.0) ** k * (t - k + 1.0) ** k / math.factorial(k) for k in range(last + 1))


@pytest.mark.parametrize("known_slopes", [True, False])
def test_against_the_method_of_steps(solver, known_slopes):
    delays = DelayTable(one([4], np.int32), one([1.0]))
    problem = replace(
        build(one([True]), [1.0], [(add(A, B), [one([3]), one([4])], one([0]))]), delays=delays
    )
    options = Options(relative_tolerance=1e-9, absolute_tolerance=1e-11, max_step=0.05)
    y, yp = one([1.0]), one([-1.0])
    delays.append(0.0, y, np.zeros(1))
    delays.append(0.0, y, yp if known_slopes else None)
    integrator = create(solver, problem, 0.0, y, yp, options)
    for end in (1.0, 2.0, 3.0, 4.0, 5.0):
        # The derivatives of the solution jump at these times.
        status = Status.STEPPED
        while status is not Status.REACHED:
            result = integrator.step(end)
            assert result.status is not Status.FAILED, result.failure
            status = result.status
            slopes = integrator.yp if known_slopes else None
            delays.append(integrator.t, integrator.y, slopes)
        assert integrator.y[0] == pytest.approx(method_of_steps(end), abs=3e-7)
        y, yp = integrator.y.copy(), integrator.yp.copy()
        delays.right = True
        assert integrator.consistent(end, y, yp) >= 0
        delays.right = False
        delays.append(end, y, yp if known_slopes else None)
        integrator.restart(end, y, yp)


def test_a_jump_arrives_after_the_delay():
    """x' = u(t - 0.25) where u jumps from 0 to 1 at t = 0.1; x rises from t = 0.35 on."""
    delays = DelayTable(one([4], np.int32), one([0.25]))
    problem = replace(
        build(
            one([True]),
            [0.0],
            [(sub(A, mul(const(1.0), B)), [one([3]), one([4])], one([0]))],
        ),
        delays=delays,
    )
    for t, u in ((0.0, 0.0), (0.1, 0.0), (0.1, 1.0), (0.25, 1.0), (0.5, 1.0)):
        delays.append(t, one([u]), np.zeros(1))
    integrator = create("ida", problem, 0.0, np.zeros(1), np.zeros(1), Options(max_step=0.1))
    times, y = np.array([0.2, 0.35]), np.zeros((2, 1))
    assert integrator.run(times, y, np.zeros((2, 1))).status is Status.REACHED
    np.testing.assert_array_equal(y, 0.0)
    steps = integrator.statistics.error_test_failures
    start, slope = integrator.y.copy(), integrator.yp.copy()
    delays.right = True
    assert integrator.consistent(0.35, start, slope) >= 0
    delays.right = False
    assert slope[0] == 1.0
    integrator.restart(0.35, start, slope)
    assert integrator.run(np.array([0.6]), y[:1], np.zeros((1, 1))).status is Status.REACHED
    assert y[0, 0] == pytest.approx(0.25, rel=1e-9)
    assert integrator.statistics.error_test_failures == steps
