"""Roots and consistent restarts for integrators that step in Python."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from acausal.solvers.consistent_point import ConsistentPoint, NativePoint
from acausal.solvers.native_step import ROOT_WIDTH, SECANTS, TURNS
from acausal.solvers.system import NativeSystem

Array = NDArray[np.float64]
_UNIT_ROUNDOFF = float(np.finfo(float).eps)


class Moving(Protocol):
    """What the search needs of an integrator."""

    y: Array
    yp: Array

    def go_to(self, t: float) -> None:
        """Set ``t``, ``y`` and ``yp`` to a time inside the last step."""


class Watch:
    """The root functions of a system, and their wanted directions.

    Attributes:
        count: Number of root functions.
        found: As ``Integrator.roots_found``.
        directions: As given to ``Integrator.set_root_directions``.
    """

    def __init__(self, system: NativeSystem) -> None:
        """Look for roots of both directions."""
        self._system = system
        self.count = system.root_count
        self.found = np.zeros(self.count, np.int32)
        self.directions = np.zeros(self.count, np.int32)

    def use(self, system: NativeSystem) -> None:
        """Take the root functions of another system; directions stay if their number does."""
        self._system = system
        if system.root_count != self.count:
            self.__init__(system)  # type: ignore[misc]

    def values(self, t: float, y: Array, yp: Array) -> Array:
        """Return the root functions at a point."""
        out = np.zeros(self.count)
        self._system.roots(t, np.ascontiguousarray(y), np.ascontiguousarray(yp), out)
        return out

    def crossings(self, low: Array, high: Array) -> NDArray[np.int32]:
        """Return +1 or -1 where a function has changed its sign in a wanted direction."""
        finite = np.isfinite(low) & np.isfinite(high)
        rising = finite & (low < 0.0) & (high >= 0.0) & (self.directions >= 0)
        falling = finite & (low > 0.0) & (high <= 0.0) & (self.directions <= 0)
        return rising.astype(np.int32) - falling.astype(np.int32)

    def _leftmost(self, low: Array, high: Array) -> int:
        """Return the number of the crossing function with the leftmost secant root, or -1."""
        crossed = np.flatnonzero(self.crossings(low, high))
        if crossed.size == 0:
            return -1
        share = np.abs(high[crossed] / (high[crossed] - low[crossed]))
        return int(crossed[np.argmax(share)])

    def search(self, integrator: Moving, t_low: float, low: Array, t_high: float) -> bool:
        """Look for the first root of a step, as the native function ``search``.

        Args:
            integrator: Stands at ``t_high``; is moved to the root if there is one.
            t_low: Left end, seconds.
            low: Values there.
            t_high: Right end, seconds.
        """
        high = self.values(t_high, integrator.y, integrator.yp)
        best = self._leftmost(low, high)
        if best < 0:
            return False
        a, b = t_low, t_high
        width = (abs(a) + abs(b) + (b - a)) * 0.5 * ROOT_WIDTH * _UNIT_ROUNDOFF
        weight, side, there = 1.0, 0, True
        for turn in range(TURNS):
            if b - a <= width or high[best] == 0.0:
                break
            t = float(b - (b - a) * high[best] / (high[best] - weight * low[best]))
            if turn > SECANTS:
                t = a + 0.5 * (b - a)
            inward = (0.1 if b - a > 5.0 * width else 0.5 * width / (b - a)) * (b - a)
            if not t - a >= 0.5 * width:
                t = a + inward
            if not b - t >= 0.5 * width:
                t = b - inward
            integrator.go_to(t)
            middle = self.values(t, integrator.y, integrator.yp)
            left, right = self._leftmost(low, middle), self._leftmost(middle, high)
            there = left >= 0
            if left >= 0:
                b, high, best = t, middle, left
                weight = 0.5 * weight if side == 1 else 1.0
                side = 1
            elif right >= 0:
                a, low, best = t, middle, right
                weight = 2.0 * weight if side == 2 else 1.0
                side = 2
            else:  # not finite in between
                break
        if not there:
            integrator.go_to(b)
        self.found[:] = self.crossings(low, high)
        return True


class Watching:
    """The part of the protocol that has to do with events, for a class with ``_system``."""

    _system: NativeSystem
    _watch: Watch
    _consistent_point: ConsistentPoint | None = None

    @property
    def watches(self) -> bool:
        """Whether there are root functions."""
        return self._watch.count > 0

    @property
    def roots_found(self) -> NDArray[np.int32]:
        """Which functions changed their sign; see the protocol."""
        return self._watch.found

    def set_root_directions(self, directions: NDArray[np.int32]) -> None:
        """Look for rising or falling roots; see the protocol."""
        self._watch.directions[:] = directions

    def consistent(self, t: float, y: Array, yp: Array) -> int:
        """Solve for algebraic unknowns and derivatives; see the protocol."""
        if self._consistent_point is None:
            self._consistent_point = ConsistentPoint(self._system)
        return self._consistent_point.solve(t, y, yp)

    def native_point(self) -> NativePoint | None:
        """Return how native code does the same; see the protocol."""
        if self._consistent_point is None:
            self._consistent_point = ConsistentPoint(self._system)
        return self._consistent_point.native
