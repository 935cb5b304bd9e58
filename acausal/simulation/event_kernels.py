"""The discrete equations on one work vector: kernels, index arrays, and views of held values.

The same class serves the first instant, where every id has a position of its own, and the run,
where positions are those of the layout. Whoever owns the work vector keeps time and continuous
values in it up to date.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from acausal.assembly.problem import KernelCall, RootProblem
from acausal.codegen.kernels import Kernel, compile_kernels
from acausal.codegen.sequence import NativeSequence
from acausal.flattening.model import EquationFamily, Hybrid, Ids, Operand
from acausal.simulation.relations import Relations, RelationStates

Array = NDArray[np.float64]
Call = tuple[Kernel, NDArray[np.int32], NDArray[np.int32]]


class EventKernels:
    """Everything discrete, ready to be evaluated on a work vector.

    Attributes:
        hybrid: What happens at events.
        w: The work vector.
        held: View of the held values in it, shape ``(h,)``.
        states: The relations and how they stand.
        fires: Which reinits act, 1 or 0.
        reinit_values: Their new values.
        terminates: Which terminations act, 1 or 0.
    """

    def __init__(
        self, hybrid: Hybrid, relations: Relations, w: Array, position: Ids, parameters: int
    ) -> None:
        """Build the index arrays.

        Args:
            hybrid: What happens at events.
            relations: Its relations.
            w: Work vector.
            position: Position of each variable in it, shape ``(N,)``.
            parameters: Position of the first parameter.
        """
        self.hybrid = hybrid
        self.w = w
        self._position = position
        self._parameters = parameters
        self.first = parameters + hybrid.first
        self.held: Array = w[self.first : self.first + len(hybrid.start)]
        self.states = RelationStates(relations)
        self._relations = self._sequence(relations.families, None, self.states.g)
        self._assignments = self._sequence(hybrid.assignments, self.first, w)
        self._initial = (
            self._assignments
            if hybrid.initial is hybrid.assignments
            else self._sequence(hybrid.initial, self.first, w)
        )
        self._initial_pre = self._sequence(hybrid.initial_pre, self.first, w)
        self._limits = self._sequence(hybrid.limits, self.first, w)
        n = hybrid.reinits.count
        self.fires: Array = np.zeros(n)
        self.reinit_values: Array = np.zeros(n)
        self._fires = self._sequence(hybrid.reinits.fires, 0, self.fires)
        self._values = self._sequence(hybrid.reinits.values, 0, self.reinit_values)
        total = sum(t.family.count for t in hybrid.terminations)
        self.terminates: Array = np.zeros(total)
        families = [t.family for t in hybrid.terminations]
        self._terminates = self._sequence(families, None, self.terminates)
        self._slopes = self._slope_sequence(relations)

    def _index(self, family: EquationFamily) -> NDArray[np.int32]:
        index = np.empty(family.operands.shape, np.int32)
        for k, kind in enumerate(family.kinds):
            ids = family.operands[k]
            index[k] = self._position[ids] if kind == Operand.VARIABLE else self._parameters + ids
        return index

    def _calls(self, families: Sequence[EquationFamily], first: int | None) -> list[Call]:
        """Return kernel calls that store at ``first + rows``, or one after the other."""
        kernels = compile_kernels([(f.template, ()) for f in families])
        calls: list[Call] = []
        done = 0
        for family, kernel in zip(families, kernels, strict=True):
            target = done + np.arange(family.count) if first is None else first + family.rows
            done += family.count
            index = np.ascontiguousarray(self._index(family)[: kernel.m])
            calls.append((kernel, index, target.astype(np.int32)))
        return calls

    def _sequence(
        self, families: Iterable[EquationFamily], first: int | None, out: Array
    ) -> NativeSequence:
        return NativeSequence(self._calls(list(families), first), self.w, out)

    def _slope_sequence(self, relations: Relations) -> NativeSequence | None:
        parts: list[EquationFamily] = []
        targets: list[NDArray[np.int32]] = []
        first = 0
        for family, slope in zip(relations.families, relations.slopes, strict=True):
            if slope is not None:
                parts.append(EquationFamily(slope, family.kinds, family.operands, family.rows))
                targets.append((first + np.arange(family.count)).astype(np.int32))
            first += family.count
        if not parts:
            return None
        calls = [
            (kernel, index, target)
            for (kernel, index, _), target in zip(self._calls(parts, None), targets, strict=True)
        ]
        return NativeSequence(calls, self.w, self.states.slope)

    def root_problem(self) -> RootProblem | None:
        """Return the root functions of the relations that the solver has to watch."""
        relations = self.states.relations
        n = len(relations.root_relation)
        if not n:
            return None
        roots = np.full((2, relations.count), -1, np.int64)
        roots[relations.root_side, relations.root_relation] = np.arange(n)
        calls: list[KernelCall] = []
        first = 0
        nothing = np.zeros((0, 0), np.int32)
        for kernel, index, _ in self._calls(relations.families, None):
            count = index.shape[1]
            for side in (0, 1):
                target = roots[side, first : first + count]
                if count and target[0] >= 0:
                    calls.append(KernelCall(kernel, index, target.astype(np.int32), nothing))
            first += count
        return RootProblem(n, tuple(calls), np.zeros(n))

    # --- evaluation ------------------------------------------------------------------------

    def evaluate_relations(self) -> None:
        """Evaluate the differences ``g`` and the coefficients of time."""
        self._relations.run()
        if self._slopes is not None:
            self._slopes.run()

    def relation_values(self) -> Array:
        """Return what the relations are held at, a copy, shape ``(n,)``."""
        values: Array = self.held[self.states.relations.place]
        return values

    def hold_relations(self, values: Array) -> None:
        """Hold the relations at other values."""
        self.held[self.states.relations.place] = values

    def assign(self, *, initial: bool = False) -> None:
        """Evaluate the discrete equations in order."""
        (self._initial if initial else self._assignments).run()

    def assign_initial_pre(self) -> None:
        """Evaluate the initial equations of values before the first instant."""
        self._initial_pre.run()

    def remember_limits(self) -> None:
        """Take the present values of continuous variables as those before the event."""
        self._limits.run()

    def evaluate_reinits(self) -> bool:
        """Evaluate which reinits act, and their values; return whether any does."""
        if not len(self.fires):
            return False
        self._fires.run()
        if not self.fires.any():
            return False
        self._values.run()
        return True

    def evaluate_terminations(self) -> int:
        """Return the number of the first termination that acts, -1 if none does."""
        if not len(self.terminates):
            return -1
        self._terminates.run()
        acting = np.flatnonzero(self.terminates)
        return int(acting[0]) if len(acting) else -1
