"""Values of all variables from ``y`` and ``y'``: aliases, known zeros, eliminated definitions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from acausal.assembly.layout import Layout
from acausal.assembly.problem import TIME_POSITION, Y_POSITION
from acausal.codegen.kernels import Kernel, compile_kernels
from acausal.expressions.evaluate import evaluate
from acausal.flattening.model import EquationFamily, Ids, Operand

#: Up to so many numbers all points in time are computed at once, with NumPy; above, one by one
#: with the kernels.
_TOGETHER = 4_000_000


@dataclass(frozen=True)
class Held:
    """Held values of several points in time.

    Attributes:
        values: The values that occur, shape ``(k, h)``.
        which: The row of each point, shape ``(nt,)``.
    """

    values: NDArray[np.float64]
    which: Ids


@dataclass(frozen=True)
class Observer:
    """Computes eliminated variables.

    Attributes:
        layout: Where the unknowns are.
        representative: Who stands for each variable, shape ``(n,)``.
        sign: 1, -1 or 0, shape ``(n,)``.
        definitions: Families that define eliminated variables, in order of evaluation.
        parameters: Values of the parameters.
        first_held: Number of parameters that never change; the others are held values.
        held_place: Held position of each variable that only changes at events, -1 for others,
            shape ``(n,)``; None if there are none.
    """

    layout: Layout
    representative: Ids
    sign: NDArray[np.int8]
    definitions: tuple[EquationFamily, ...]
    parameters: NDArray[np.float64]
    first_held: int = -1
    held_place: Ids | None = None

    @cached_property
    def places(self) -> Ids:
        """Position of every representative in the extended work vector, -1 if it has none."""
        place = self.layout.position.copy()
        if self.definitions:
            defined = np.unique(np.concatenate([f.rows for f in self.definitions]))
            place[defined] = self.layout.observables + np.arange(len(defined))
        if self.held_place is not None:
            held = np.flatnonzero(self.held_place >= 0)
            place[held] = self.layout.parameters + self.first_held + self.held_place[held]
        return place

    @cached_property
    def _size(self) -> int:
        return max(self.layout.observables, int(self.places.max(initial=-1)) + 1)

    @cached_property
    def _calls(self) -> list[tuple[Kernel, NDArray[np.int32], NDArray[np.int32]]]:
        kernels = compile_kernels([(f.template, ()) for f in self.definitions])
        calls = []
        for family, kernel in zip(self.definitions, kernels, strict=True):
            calls.append((kernel, self._index(family), self.places[family.rows].astype(np.int32)))
        return calls

    def needs_definitions(self, variable: int) -> bool:
        """Tell whether a variable has to be computed."""
        place = self.places[self.representative[variable]]
        return bool(self.sign[variable]) and place >= self.layout.observables

    def _all_points(
        self,
        times: NDArray[np.float64],
        y: NDArray[np.float64],
        yp: NDArray[np.float64],
        held: Held | None,
    ) -> NDArray[np.float64]:
        """Return the extended work vectors of all points, shape ``(nt, size)``."""
        n = self.layout.n
        w = np.zeros((len(times), self._size))
        w[:, TIME_POSITION] = times
        w[:, Y_POSITION : Y_POSITION + n] = y
        w[:, Y_POSITION + n : Y_POSITION + 2 * n] = yp
        w[:, self.layout.parameters : self.layout.observables] = self.parameters
        if held is not None:
            first = self.layout.parameters + self.first_held
            w[:, first : self.layout.observables] = held.values[held.which]
        for family in self.definitions:
            index = self._index(family)

            def operand(key: object, index: NDArray[np.int32] = index) -> NDArray[np.float64]:
                assert isinstance(key, int)
                return w[:, index[key]]

            values = evaluate(family.template, operand, times[:, None])
            # The transposed view: members of a family may share a place.
            np.add.at(w.T, self.places[family.rows], values.T)
        return w

    def _index(self, family: EquationFamily) -> NDArray[np.int32]:
        index = np.zeros(family.operands.shape, np.int32)
        for k, kind in enumerate(family.kinds):
            ids = family.operands[k]
            if kind == Operand.VARIABLE:
                index[k] = self.places[ids]
            else:
                index[k] = self.layout.parameters + ids
        return index

    def _compute(self, w: NDArray[np.float64]) -> None:
        for kernel, index, target in self._calls:
            kernel.evaluate_residual(w, index, target, w)

    def values(
        self,
        variables: Sequence[int],
        times: NDArray[np.float64],
        y: NDArray[np.float64],
        yp: NDArray[np.float64],
        held: Held | None = None,
    ) -> NDArray[np.float64]:
        """Return trajectories of variables, shape ``(nt, len(variables))``.

        Args:
            variables: Ids.
            times: Shape ``(nt,)``.
            y: Unknowns, shape ``(nt, n)``.
            yp: Derivatives, shape ``(nt, n)``.
            held: Held values; None if there are none.
        """
        ids = np.asarray(variables, np.int64)
        place = self.places[self.representative[ids]]
        sign = self.sign[ids].astype(np.float64)
        place = np.where(sign == 0, 0, place)
        n = self.layout.n
        result = np.zeros((len(times), len(ids)))
        if (place >= self.layout.observables).any():
            if len(times) * self._size <= _TOGETHER:
                return self._all_points(times, y, yp, held)[:, place] * sign
            # Point by point: a work vector of a large model does not fit as often as there are
            # points in time.
            w = np.zeros(self._size)
            w[self.layout.parameters : self.layout.observables] = self.parameters
            first = self.layout.parameters + self.first_held
            for k, t in enumerate(times):
                if held is not None:
                    w[first : self.layout.observables] = held.values[held.which[k]]
                w[self.layout.observables :] = 0.0
                w[TIME_POSITION] = t
                w[Y_POSITION : Y_POSITION + n] = y[k]
                w[Y_POSITION + n : Y_POSITION + 2 * n] = yp[k]
                self._compute(w)
                result[k] = w[place]
        else:
            first = self.layout.parameters + self.first_held
            for column, p in enumerate(place):
                if held is not None and p >= first:
                    result[:, column] = held.values[held.which, p - first]
                elif p >= Y_POSITION + n:
                    result[:, column] = yp[:, p - Y_POSITION - n]
                elif p >= Y_POSITION:
                    result[:, column] = y[:, p - Y_POSITION]
        return result * sign
