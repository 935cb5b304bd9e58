"""The discrete equations on one work vector: kernels, index arrays, and views of held values.

The same class serves the first instant, where every id has a position of its own, and the run,
where positions are those of the layout. Whoever owns the work vector keeps time and continuous
values in it up to date.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from acausal.assembly.problem import KernelCall, RootProblem
from acausal.codegen.kernels import Kernel, compile_kernels
from acausal.codegen.sequence import NativeSequence
from acausal.expressions.nodes import slot
from acausal.flattening.model import Assertion, EquationFamily, Hybrid, Ids, Operand
from acausal.memory import Remembered
from acausal.simulation import relation_rules
from acausal.simulation.delays import Delays
from acausal.simulation.relation_rules import (
    OPERANDS,
    Rule,
    rules_of_next_times,
    rules_of_roots,
    rules_of_wanted,
)
from acausal.simulation.relations import Relations, RelationStates, room_for

Array = NDArray[np.float64]
Call = tuple[Kernel, NDArray[np.int32], NDArray[np.int32]]
_T = TypeVar("_T")

#: Models of up to so many variables keep index arrays for the next run.
SHARED_UP_TO = 10_000
#: Index arrays by hybrid part and positions.
_shared: Remembered[dict[str, Any]] = Remembered()


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
        assertions: Numbers of the assertions that stand in whens.
        holds: Whether their members hold, 1 or 0, one after the other.
        delays: Delayed values, None if there are none.
    """

    def __init__(
        self,
        hybrid: Hybrid,
        relations: Relations,
        w: Array,
        position: Ids,
        parameters: int,
        assertions: Sequence[Assertion] = (),
    ) -> None:
        """Build the index arrays.

        Args:
            hybrid: What happens at events.
            relations: Its relations.
            w: Work vector; its last :func:`~acausal.simulation.relations.room_for` numbers are
                for the relations.
            position: Position of each variable in it, shape ``(N,)``.
            parameters: Position of the first parameter.
            assertions: Conditions of the model; those inside of whens are looked at here.
        """
        self.hybrid = hybrid
        self.w = w
        self._position = position
        self._parameters = parameters
        self.first = parameters + hybrid.first
        self.held: Array = w[self.first : self.first + len(hybrid.start)]
        self.states = RelationStates(relations, w, len(w) - room_for(relations))
        # Runs of a sweep differ in nothing but numbers: they share their index arrays.
        key = (position.tobytes(), parameters, len(w))
        small = len(position) <= SHARED_UP_TO
        self._made: dict[str, Any] = _shared.get(hybrid, key, dict) if small else {}
        self._assignments = self._sequence("assignments", hybrid.assignments, self.first, w)
        self._initial = (
            self._assignments
            if hybrid.initial is hybrid.assignments
            else self._sequence("initial", hybrid.initial, self.first, w)
        )
        self._initial_pre = self._sequence("initial pre", hybrid.initial_pre, self.first, w)
        self._limits = self._sequence("limits", hybrid.limits, self.first, w)
        n = hybrid.reinits.count
        self.fires: Array = np.zeros(n)
        self.reinit_values: Array = np.zeros(n)
        self._fires = self._sequence("fires", hybrid.reinits.fires, 0, self.fires)
        self._values = self._sequence("values", hybrid.reinits.values, 0, self.reinit_values)
        total = sum(t.family.count for t in hybrid.terminations)
        self.terminates: Array = np.zeros(total)
        families = [t.family for t in hybrid.terminations]
        self._terminates = self._sequence("terminates", families, None, self.terminates)
        self.assertions = assertions_in_whens(hybrid, assertions)
        inside = [assertions[k].family for k in self.assertions]
        self.holds: Array = np.ones(sum(f.count for f in inside))
        self._asserted = self._sequence(f"asserted {self.assertions}", inside, None, self.holds)
        self.delays: Delays | None = None
        if len(hybrid.delay_places):
            self.delays = Delays(
                hybrid, w, self.first, self._calls(hybrid.delays, 0),
                self._calls(hybrid.delay_times, 0),
            )  # fmt: skip
        self._build_relations(relations)

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

    def _once(self, name: str, make: Callable[[], _T]) -> _T:
        """Return what belongs to these positions, made by the first who needs it."""
        if name not in self._made:
            self._made[name] = make()
        found: _T = self._made[name]
        return found

    def _sequence(
        self, name: str, families: Iterable[EquationFamily], first: int | None, out: Array
    ) -> NativeSequence:
        calls = self._once(name, lambda: self._calls(list(families), first))
        return NativeSequence(calls, self.w, out)

    def _build_relations(self, relations: Relations) -> None:
        """Make the sequences that evaluate relations and apply the rules to them."""
        leave, update, exactly, hold, prepare = (
            NativeSequence(calls, self.w, self.w)
            for calls in self._once("relations", lambda: self._relation_calls(relations))
        )
        self._leave, self._update, self._update_exactly = leave, update, exactly
        self._hold_wanted, self._prepare = hold, prepare
        self.states.next[:] = np.inf

    def _relation_calls(self, relations: Relations) -> tuple[list[Call], ...]:
        """Return the calls of leaving, updating (both ways), holding and preparing."""
        states = self.states
        places, place = states.places, relations.place
        n = relations.count
        every = np.arange(n)
        differences = [
            (kernel, index, target + np.int32(places.of("g")))
            for kernel, index, target in self._calls(relations.families, None)
        ]
        slopes: list[Call] = []
        first = 0
        for family, slope in zip(relations.families, relations.slopes, strict=True):
            if slope is not None:
                part = EquationFamily(slope, family.kinds, family.operands, family.rows)
                (kernel, index, target) = self._calls([part], None)[0]
                slopes.append((kernel, index, target + np.int32(places.of("slope") + first)))
            first += family.count
        largest = self._rules([Rule(relation_rules.largest(), every)], "largest")
        copy = compile_kernels([(slot(0), ())])[0]
        held = (self.first + place).astype(np.int32)
        own = (places.of("held") + every).astype(np.int32)
        new = (places.of("wanted") + every).astype(np.int32)
        left = (places.of("left") + every).astype(np.int32)
        gather = [(copy, np.ascontiguousarray(held[None, :]), own)] if n else []
        scatter = [(copy, np.ascontiguousarray(new[None, :]), held)] if n else []
        now = np.arange(places.of("g"), places.of("g") + n, dtype=np.int32)
        leave = [(copy, np.ascontiguousarray(now[None, :]), left)] if n else []
        look = [*differences, *slopes, *largest, *gather]
        wanted = self._rules(rules_of_wanted(relations, exact=False), "wanted")
        exact = self._rules(rules_of_wanted(relations, exact=True), "wanted")
        times = self._rules(rules_of_next_times(relations), "next")
        roots = rules_of_roots(relations)
        shifts = self._rules([s for s, _ in roots], "shift", relations.root_relation)
        directions = self._rules([d for _, d in roots], "direction", relations.root_relation)
        return (
            [*differences, *leave], [*look, *wanted], [*look, *exact], scatter,
            [*look, *times, *shifts, *directions],
        )  # fmt: skip

    def _rules(self, rules: Sequence[Rule], name: str, relation: Ids | None = None) -> list[Call]:
        """Return kernel calls that apply rules and store what they give."""
        places = self.states.places
        first = {
            "shift": places.shift, "direction": places.shift + places.r,
        }.get(name) if name in ("shift", "direction") else places.of(name)  # fmt: skip
        assert first is not None
        kernels = compile_kernels([(rule.template, ()) for rule in rules])
        calls: list[Call] = []
        for rule, kernel in zip(rules, kernels, strict=True):
            members = rule.members if relation is None else relation[rule.members]
            index = np.stack([places.of(operand) + members for operand in OPERANDS])
            target = (first + rule.members).astype(np.int32)
            calls.append((kernel, np.ascontiguousarray(index[: kernel.m], np.int32), target))
        return calls

    def root_problem(self) -> RootProblem | None:
        """Return the root functions of the relations that the solver has to watch."""
        n = len(self.states.relations.root_relation)
        if not n:
            return None
        return RootProblem(n, self._once("roots", self._root_calls), np.zeros(n))

    def _root_calls(self) -> tuple[KernelCall, ...]:
        relations = self.states.relations
        n = len(relations.root_relation)
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
        return tuple(calls)

    # --- evaluation ------------------------------------------------------------------------

    def addresses(self) -> tuple[int, int, int, int, int]:
        """Return the arguments of the sequences update, follow, assign, limits, fires."""
        parts = (self._update, self._hold_wanted, self._assignments, self._limits, self._fires)
        update, follow, assign, limits, fires = (part.argument for part in parts)
        return update, follow, assign, limits, fires

    def leave(self) -> None:
        """Remember the differences of the relations as those before the event."""
        self._leave.run()

    def values_of(self, ids: Ids) -> Array:
        """Return the present values of variables, shape of ``ids``."""
        found: Array = self.w[self._position[ids]]
        return found

    def look(self, *, exact: bool = False) -> bool:
        """Evaluate the relations; return whether any should be held at another value.

        Args:
            exact: Without hysteresis, for the first instant.
        """
        (self._update_exactly if exact else self._update).run()
        states = self.states
        return states.wanted.tobytes() != states.held.tobytes()

    def follow(self) -> None:
        """Hold the relations at what they should be held at."""
        self._hold_wanted.run()

    def prepare(self) -> None:
        """Evaluate the relations, their next times, and what the solver has to watch."""
        self._prepare.run()

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

    def evaluate_assertions(self) -> bool:
        """Evaluate the assertions that stand in whens; return whether all hold."""
        if not len(self.holds):
            return True
        self._asserted.run()
        return bool(self.holds.all())


def assertions_in_whens(hybrid: Hybrid, assertions: Sequence[Assertion]) -> list[int]:
    """Return the numbers of the assertions that read the condition of a when."""
    if not len(hybrid.conditions):
        return []
    conditions = hybrid.first + hybrid.conditions
    return [
        number
        for number, assertion in enumerate(assertions)
        if any(
            kind == Operand.PARAMETER and bool(np.isin(ids, conditions).any())
            for kind, ids in zip(assertion.family.kinds, assertion.family.operands, strict=True)
        )
    ]
