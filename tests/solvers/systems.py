"""Hand-made problems of index 1 with known solutions, as callback systems."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import CFUNCTYPE, c_double, c_int, c_void_p
from dataclasses import dataclass

import numpy as np

RESIDUAL = CFUNCTYPE(c_int, c_double, c_void_p, c_void_p, c_void_p, c_void_p)
JACOBIAN = CFUNCTYPE(c_int, c_double, c_double, c_void_p, c_void_p, c_void_p, c_void_p)


@dataclass(frozen=True)
class Pattern:
    """The part of a DAEProblem that integrators read."""

    n: int
    indptr: np.ndarray
    indices: np.ndarray
    differential: np.ndarray
    nominal: np.ndarray

    @property
    def nnz(self) -> int:
        return len(self.indices)


class CallbackSystem:
    """A NativeSystem whose C functions are Python callbacks.

    Args:
        f: ``f(t, y, yp) -> residual``.
        dy: ``dy(t, y, yp) -> dF/dy``, dense.
        dyp: likewise dF/dy'.
        differential: Mask of the unknowns with a derivative.
        mask: Pattern of the Jacobian, dense; everything if None.
    """

    def __init__(
        self,
        f: Callable,
        dy: Callable,
        dyp: Callable,
        differential: list[bool],
        mask: np.ndarray | None = None,
        nominal: np.ndarray | None = None,
    ) -> None:
        n = len(differential)
        mask = np.ones((n, n), bool) if mask is None else np.asarray(mask, bool)
        columns, rows = np.nonzero(mask.T)
        indptr = np.concatenate([[0], np.cumsum(mask.sum(axis=0))]).astype(np.int64)
        self.problem = Pattern(
            n,
            indptr,
            rows.astype(np.int32),
            np.array(differential),
            np.ones(n) if nominal is None else nominal,
        )
        self.f, self.dy, self.dyp = f, dy, dyp
        self.rows, self.columns = rows, columns
        self.table_address = self.root_count = self.roots_address = 0
        self.restart_jacobian_address = 0
        self.calls = 0

        def view(address: int, size: int) -> np.ndarray:
            return np.frombuffer((c_double * size).from_address(address))

        def residual(t: float, y: int, yp: int, out: int, _: int) -> int:
            self.calls += 1
            view(out, n)[:] = self.f(t, view(y, n), view(yp, n))
            return 0 if np.isfinite(view(out, n)).all() else 1

        def jacobian(t: float, cj: float, y: int, yp: int, out: int, _: int) -> int:
            y_, yp_ = view(y, n), view(yp, n)
            dense = np.asarray(self.dy(t, y_, yp_)) + cj * np.asarray(self.dyp(t, y_, yp_))
            view(out, len(rows))[:] = dense[rows, columns]
            return 0

        self._residual, self._jacobian = RESIDUAL(residual), JACOBIAN(jacobian)
        self.residual_address = ctypes.cast(self._residual, c_void_p).value
        self.jacobian_address = ctypes.cast(self._jacobian, c_void_p).value

    def residual(self, t: float, y: np.ndarray, yp: np.ndarray, out: np.ndarray) -> None:
        out[:] = self.f(t, y, yp)

    def jacobian_values(
        self, t: float, cj: float, y: np.ndarray, yp: np.ndarray, out: np.ndarray
    ) -> None:
        self._partials = tuple(
            np.asarray(part(t, y, yp), float)[self.rows, self.columns]
            for part in (self.dy, self.dyp)
        )
        out[:] = self._partials[0] + cj * self._partials[1]

    def partial_values(self) -> tuple[np.ndarray, np.ndarray]:
        return self._partials


def oscillator(omega: float = 2.0, damping: float = 0.0) -> CallbackSystem:
    """x' = v, v' = -omega^2 x - damping v, and an algebraic e = energy."""

    def f(t, y, yp):
        x, v, e = y
        return [
            yp[0] - v,
            yp[1] + omega**2 * x + damping * v,
            e - 0.5 * v**2 - 0.5 * omega**2 * x**2,
        ]

    def dy(t, y, yp):
        x, v, _ = y
        return [[0, -1, 0], [omega**2, damping, 0], [-(omega**2) * x, -v, 1]]

    def dyp(t, y, yp):
        return [[1, 0, 0], [0, 1, 0], [0, 0, 0]]

    return CallbackSystem(f, dy, dyp, [True, True, False])


def rlc(R: float = 1.0, L: float = 0.5, C: float = 0.1, V: float = 2.0) -> CallbackSystem:
    """Series circuit: y = [i, v_c, v_l, v_r] with a constant source."""

    def f(t, y, yp):
        i, vc, vl, vr = y
        return [L * yp[0] - vl, C * yp[1] - i, vr - R * i, V - vr - vl - vc]

    dy = [[0, 0, -1, 0], [-1, 0, 0, 0], [-R, 0, 0, 1], [0, -1, -1, -1]]
    dyp = [[L, 0, 0, 0], [0, C, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]
    mask = (np.array(dy) != 0) | (np.array(dyp) != 0)
    return CallbackSystem(f, lambda *_: dy, lambda *_: dyp, [True, True, False, False], mask)


def rlc_exact(t: np.ndarray, R=1.0, L=0.5, C=0.1, V=2.0) -> np.ndarray:
    """Capacitor voltage from rest."""
    a, w0 = R / (2 * L), 1 / np.sqrt(L * C)
    w = np.sqrt(w0**2 - a**2)
    return V * (1 - np.exp(-a * t) * (np.cos(w * t) + a / w * np.sin(w * t)))


def robertson() -> CallbackSystem:
    """Robertson's kinetics with the conservation law as algebraic equation."""

    def f(t, y, yp):
        a, b, c = y
        return [
            yp[0] + 0.04 * a - 1e4 * b * c,
            yp[1] - 0.04 * a + 1e4 * b * c + 3e7 * b**2,
            a + b + c - 1,
        ]

    def dy(t, y, yp):
        _, b, c = y
        return [[0.04, -1e4 * c, -1e4 * b], [-0.04, 1e4 * c + 6e7 * b, 1e4 * b], [1, 1, 1]]

    return CallbackSystem(
        f,
        dy,
        lambda *_: [[1, 0, 0], [0, 1, 0], [0, 0, 0]],
        [True, True, False],
        nominal=np.array([1.0, 1e-4, 1.0]),
    )


def stiff_linear(n: int = 40, fastest: float = 1e6) -> CallbackSystem:
    """n/2 decays y_k' = -rate_k (y_k - cos t) with rates to ``fastest``, and a sum of each two.

    Tridiagonal apart from the algebraic unknowns, so that it has a band after reordering.
    """
    half = n // 2
    rates = np.logspace(0, np.log10(fastest), half)
    dy = np.zeros((n, n))
    dyp = np.zeros((n, n))
    for k in range(half):
        dyp[k, k] = 1.0
        dy[k, k] = rates[k]
        dy[half + k, half + k] = 1.0
        dy[half + k, k] = -1.0
        if k > 0:
            dy[half + k, k - 1] = -1.0
    mask = (dy != 0) | (dyp != 0)

    def f(t, y, yp):
        forcing = np.concatenate([-rates * np.cos(t), np.zeros(half)])
        return dyp @ yp + dy @ y + forcing

    differential = [True] * half + [False] * half
    system = CallbackSystem(f, lambda *_: dy, lambda *_: dyp, differential, mask)
    system.rates = rates
    return system


def stiff_linear_exact(rates: np.ndarray, t: np.ndarray) -> np.ndarray:
    """States of :func:`stiff_linear` from 0: shape (len(t), len(rates))."""
    t = np.asarray(t)[:, None]
    forced = (rates**2 * np.cos(t) + rates * np.sin(t)) / (1 + rates**2)
    return forced - rates**2 / (1 + rates**2) * np.exp(-rates * t)
