"""All integrators follow the same trajectories, which are known in closed form."""

import warnings

import numpy as np
import pytest
from native_problems import oscillators, pendulum
from scipy.special import ellipj, ellipk
from systems import oscillator, rlc, rlc_exact, robertson, stiff_linear, stiff_linear_exact

from acausal.solvers.protocol import Options, Status, create
from acausal.solvers.sundials import binding, locate


def trajectory(name, problem, times, y, yp, **options):
    integrator = create(name, problem, times[0], np.array(y), np.array(yp), Options(**options))
    n = len(y)
    out_y, out_yp = np.full((len(times), n), np.nan), np.full((len(times), n), np.nan)
    result = integrator.run(times, out_y, out_yp)
    assert result.status is Status.REACHED, result.failure
    assert result.rows == len(times)
    assert integrator.t == times[-1]
    np.testing.assert_allclose(integrator.y, out_y[-1], rtol=1e-12, atol=1e-12)
    integrator.close()
    return out_y, out_yp


@pytest.mark.parametrize("linear_solver", ["dense", "sparse"])
def test_rlc(solver, linear_solver):
    times = np.linspace(0, 5, 101)
    y, yp = trajectory(
        solver, rlc(), times, [0, 0, 2, 0], [4, 0, 0, 0], linear_solver=linear_solver
    )
    np.testing.assert_allclose(y[:, 1], rlc_exact(times), atol=1e-4)
    np.testing.assert_allclose(y[:, 0], y[:, 3], atol=5e-6)  # R = 1
    np.testing.assert_allclose(y[:, 1:].sum(axis=1), 2.0, atol=5e-6)  # mesh
    np.testing.assert_allclose(0.1 * yp[:, 1], y[:, 0], atol=1e-3)  # C v' = i


def test_oscillator_from_real_kernels(solver):
    times = np.linspace(0, 10, 57)
    y, yp = trajectory(
        solver, oscillators(2, 2.0), times, [1, 1, 0, 0, -4, -4], [0, 0, -4, -4, 0, 0],
        relative_tolerance=1e-8, absolute_tolerance=1e-8,
    )  # fmt: skip
    np.testing.assert_allclose(y[:, 0], np.cos(2 * times), atol=1e-5)
    np.testing.assert_allclose(y[:, 3], -2 * np.sin(2 * times), atol=2e-5)
    np.testing.assert_allclose(yp[:, 2], -4 * np.cos(2 * times), atol=2e-4)


def test_pendulum_of_large_amplitude(solver):
    """sin(angle/2) = k sn(K - omega t), k = sin(amplitude/2)."""
    amplitude, omega = 2.5, np.sqrt(9.81)
    k = np.sin(amplitude / 2)
    times = np.linspace(0, 6, 61)
    a = -9.81 * np.sin(amplitude)
    y, _ = trajectory(
        solver, pendulum(), times, [amplitude, 0, a], [0, a, 0],
        relative_tolerance=1e-9, absolute_tolerance=1e-9,
    )  # fmt: skip
    sn = ellipj(ellipk(k**2) - omega * times, k**2)[0]
    np.testing.assert_allclose(y[:, 0], 2 * np.arcsin(k * sn), atol=1e-5)


def test_robertson(solver):
    """Reference values of the Test Set for IVP Solvers at 0.4, 40, 4e5 (rounded)."""
    times = np.array([0.0, 0.4, 40.0, 4e5])
    y, _ = trajectory(
        solver, robertson(), times, [1, 0, 0], [-0.04, 0.04, 0],
        relative_tolerance=1e-7, absolute_tolerance=1e-9,
    )  # fmt: skip
    expected = [
        [9.85172114e-1, 3.38639538e-5, 1.47940221e-2],
        [7.15827069e-1, 9.18553477e-6, 2.84163746e-1],
        [4.93828895e-3, 1.98500000e-8, 9.95061691e-1],
    ]
    np.testing.assert_allclose(y[1:3], expected[:2], rtol=2e-5)
    np.testing.assert_allclose(y[3], expected[2], rtol=1e-3)


@pytest.mark.parametrize("linear_solver", ["dense", "sparse"])
def test_stiff_linear(solver, linear_solver):
    """Rates from 1 to 1e6; banded in odes-ida."""
    system = stiff_linear(40)
    times = np.linspace(0, 3, 31)
    y0, yp0 = np.zeros(40), np.zeros(40)
    yp0[:20] = system.rates
    y, _ = trajectory(solver, system, times, y0, yp0, linear_solver=linear_solver)
    exact = stiff_linear_exact(system.rates, times)
    np.testing.assert_allclose(y[:, :20], exact, atol=2e-5)
    np.testing.assert_allclose(y[:, 21:40], exact[:, 1:] + exact[:, :-1], atol=4e-5)


def test_energy_is_algebraic(solver):
    times = np.linspace(0, 3, 7)
    y, _ = trajectory(solver, oscillator(2.0, 0.5), times, [1, 0, 2], [0, -4, 0])
    np.testing.assert_allclose(y[:, 2], 0.5 * y[:, 1] ** 2 + 2 * y[:, 0] ** 2, rtol=3e-6)
    assert (np.diff(y[:, 2]) < 0).all()


@pytest.mark.parametrize("source", [location.source for location in locate.locations()])
@pytest.mark.parametrize("linear_solver", ["dense", "sparse"])
def test_every_sundials_gives_the_same(source, linear_solver, monkeypatch):
    monkeypatch.setenv(locate.VARIABLE, source)
    binding.bind.cache_clear()
    locate.load.cache_clear()
    try:
        times = np.linspace(0, 5, 11)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            y, _ = trajectory(
                "ida", rlc(), times, [0, 0, 2, 0], [4, 0, 0, 0], linear_solver=linear_solver
            )
        np.testing.assert_allclose(y[:, 1], rlc_exact(times), atol=1e-4)
    finally:
        binding.bind.cache_clear()
        locate.load.cache_clear()


def test_source_that_stands_still_at_the_start(solver):
    """A fast sine must not be stepped over, however long the simulation."""
    from systems import CallbackSystem

    omega = 2 * np.pi * 1e3
    system = CallbackSystem(
        lambda t, y, yp: [yp[0] - omega * np.sin(omega * t), y[1] - y[0]],
        lambda *_: [[0, 0], [-1, 1]],
        lambda *_: [[1, 0], [0, 0]],
        [True, False],
    )
    integrator = create(solver, system, 0.0, np.zeros(2), np.zeros(2))
    while integrator.t < 2e-3:
        assert integrator.step(20.0).status is Status.STEPPED
    exact = 1 - np.cos(omega * integrator.t)
    np.testing.assert_allclose(integrator.y, [exact, exact], atol=1e-3)
    assert integrator.t < 3e-3
