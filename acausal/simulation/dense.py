"""The integrator's own polynomials of a whole run, and every variable at any time from them.

A piece is an accepted step, or the part of one up to an event. Its polynomials give the
differential unknowns; the algebraic ones and the derivatives are then made to solve the equations,
and everything else is computed, all as at stored points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from acausal.assembly.observe import Held, Observer
from acausal.assembly.problem import DAEProblem
from acausal.codegen.driver import NativeProblem
from acausal.simulation.trajectories import Trajectories
from acausal.solvers.consistent_point import ConsistentPoint
from acausal.solvers.step_polynomial import StepPolynomial

Array = NDArray[np.float64]

#: Numbers of coefficients that are gathered at a time.
TOGETHER = 4_000_000


@dataclass(frozen=True)
class Pieces:
    """Pieces in a row that share an observer.

    Attributes:
        observer: Computes variables.
        system: The equations that algebraic unknowns have to solve; None if there are no
            such unknowns, or if the equations look back to delayed values.
        begin, end: Where each piece is used, seconds, shape ``(m,)``.
        reference, step: Origin and scale of its polynomial, seconds, shape ``(m,)``.
        terms: Coefficients of ``y``, rising powers, shape ``(m, 6, n)``.
        slopes: Coefficients of ``y'``, likewise.
        held: Held values at both ends, shape ``(2, m, h)``; None if there are none.
    """

    observer: Observer
    system: NativeProblem[DAEProblem] | None
    begin: Array
    end: Array
    reference: Array
    step: Array
    terms: Array
    slopes: Array
    held: Array | None

    def values(self, ids: Sequence[int], times: Array, which: NDArray[np.int64]) -> Array:
        """Return variables at times, each in its piece, shape ``(nt, len(ids))``."""
        result = np.empty((len(times), len(ids)))
        chunk = max(1, TOGETHER // max(1, self.terms[0].size))
        for first in range(0, len(times), chunk):
            rows = slice(first, first + chunk)
            result[rows] = self._values(ids, times[rows], which[rows])
        return result

    def _values(self, ids: Sequence[int], times: Array, which: NDArray[np.int64]) -> Array:
        inside = np.clip(times, self.begin[which], self.end[which])
        s = ((inside - self.reference[which]) / self.step[which])[:, None]
        y, yp = _horner(self.terms[which], s), _horner(self.slopes[which], s)
        held = None
        if self.held is not None:
            # Discrete values are the same at both ends; what is delayed moves between them.
            length = self.end[which] - self.begin[which]
            part = ((inside - self.begin[which]) / length)[:, None]
            low, high = self.held[0, which], self.held[1, which]
            values = np.where(low == high, low, low + part * (high - low))
            held = Held(values, np.arange(len(times)))
        if self.system is not None:
            self._settle(self.system, inside, y, yp, held, inside == self.reference[which])
        return self.observer.values(ids, times, y, yp, held)

    @cached_property
    def _point(self) -> ConsistentPoint:
        assert self.system is not None
        return ConsistentPoint(self.system)

    def _settle(
        self,
        system: NativeProblem[DAEProblem],
        times: Array,
        y: Array,
        yp: Array,
        held: Held | None,
        solved: NDArray[np.bool_],
    ) -> None:
        """Let points solve the equations; those at the end of a step do already."""
        w, layout = system.problem.w, self.observer.layout
        first = layout.parameters + self.observer.first_held
        w[layout.parameters : layout.observables] = self.observer.parameters
        for k in np.flatnonzero(~solved).tolist():
            if held is not None:
                w[first : layout.observables] = held.values[k]
            # Where it does not converge the polynomial stands, as in the run.
            self._point.solve(float(times[k]), y[k], yp[k])


@dataclass
class DenseRecord:
    """Collects pieces while a run goes on."""

    pieces: list[Pieces] = field(default_factory=list)
    _observer: Observer | None = None
    _system: NativeProblem[DAEProblem] | None = None
    _spans: list[tuple[float, float, float, float]] = field(default_factory=list)
    _terms: list[Array] = field(default_factory=list)
    _slopes: list[Array] = field(default_factory=list)
    _held: list[tuple[Array, Array]] = field(default_factory=list)

    def add(
        self,
        observer: Observer,
        system: NativeProblem[DAEProblem] | None,
        begin: float,
        end: float,
        polynomial: StepPolynomial,
        held: tuple[Array, Array] | None,
    ) -> None:
        """Add a piece.

        Args:
            observer: Computes variables.
            system: See :class:`Pieces`.
            begin: Seconds.
            end: Seconds, after ``begin``.
            polynomial: Of the step.
            held: Held values at both ends, if there are any; copied already.
        """
        if observer is not self._observer:
            self.flush()
            self._observer, self._system = observer, system
        terms, slopes = polynomial.terms, polynomial.slopes
        if slopes is None:
            slopes = terms[1:] * (np.arange(1.0, len(terms)) / polynomial.step)[:, None]
        self._spans.append((begin, end, polynomial.end, polynomial.step))
        self._terms.append(terms)
        self._slopes.append(slopes)
        if held is not None:
            self._held.append(held)

    def flush(self) -> None:
        """Make arrays of what has come so far."""
        if self._observer is None or not self._spans:
            return
        spans = np.array(self._spans)
        held = None
        if self._held:
            held = np.array([[low for low, _ in self._held], [high for _, high in self._held]])
        self.pieces.append(
            Pieces(
                self._observer, self._system, spans[:, 0], spans[:, 1], spans[:, 2], spans[:, 3],
                _padded(self._terms), _padded(self._slopes), held,
            )
        )  # fmt: skip
        for stored in (self._spans, self._terms, self._slopes, self._held):
            stored.clear()


@dataclass(frozen=True)
class DenseRun:
    """A :class:`acausal.results.result.Dense` over the pieces of a run.

    Attributes:
        trajectories: Names of the variables, and the stored points.
        pieces: In order of time.
    """

    trajectories: Trajectories
    pieces: Sequence[Pieces]

    def at(self, paths: Sequence[str], times: Array, before: bool) -> Array:
        """Return variables at any times, see the protocol."""
        ids = [self.trajectories.id_of(path) for path in paths]
        result = np.empty((len(times), len(ids)))
        first = np.concatenate([p.begin for p in self.pieces])
        owner = np.repeat(np.arange(len(self.pieces)), [len(p.begin) for p in self.pieces])
        start = np.concatenate([[0], np.cumsum([len(p.begin) for p in self.pieces])])
        number = np.searchsorted(first, times, "left" if before else "right") - 1
        number = np.clip(number, 0, len(first) - 1)
        for k, pieces in enumerate(self.pieces):
            mine = owner[number] == k
            if mine.any():
                result[mine] = pieces.values(ids, times[mine], number[mine] - start[k])
        # What an event at the very start or end makes of it is in no piece, but stored.
        edge = times <= self.pieces[0].begin[0] if before else times >= self.pieces[-1].end[-1]
        if edge.any():
            result[edge] = self.trajectories.values_of(ids)[0 if before else -1]
        return result


def _horner(terms: Array, s: Array) -> Array:
    """Return polynomials, ``terms`` of shape ``(nt, degree + 1, n)``, at ``s`` ``(nt, 1)``."""
    result: Array = terms[:, -1].copy()
    for k in range(terms.shape[1] - 2, -1, -1):
        result *= s
        result += terms[:, k]
    return result


def _padded(parts: Sequence[Array]) -> Array:
    most = max(len(part) for part in parts)
    result = np.zeros((len(parts), most, parts[0].shape[1]))
    for row, part in zip(result, parts, strict=True):
        row[: len(part)] = part
    return result
