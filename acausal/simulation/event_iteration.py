"""What happens in one instant: the discrete and the continuous equations are brought into step.

Modelica 3.6, appendix B: with the values before the event frozen, all equations hold together,
discrete and continuous. Their solution is sought by turns: relations from the continuous values,
discrete variables from the relations, continuous values from both, until nothing changes. Then
what is discrete becomes "before the event", and if that changes anything, the same again.

Turns need not settle where relations depend on each other through the continuous equations, as in
circuits of ideal diodes. Then relations change one at a time, the first wrong one first, which ends
for every linear complementarity problem with a P-matrix (K. G. Murty, "Note on a Bard-type scheme
for solving the complementarity problem", Opsearch 11, 1974). If that goes round in circles as well,
all combinations of the relations in the circle are tried, nearest ones first.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import AcausalError
from acausal.flattening.model import Ids
from acausal.simulation.accumulation import Accumulation
from acausal.simulation.contacts import Contacts
from acausal.simulation.event_kernels import EventKernels
from acausal.simulation.native_settlement import NativeSettlement, Outcome
from acausal.simulation.not_finite import is_partial
from acausal.solvers.consistent_point import NativePoint

Array = NDArray[np.float64]

#: Turns without a settlement before relations change one at a time.
TURNS = 30
#: Changes of single relations.
SINGLE_TURNS = 2000
#: Relations of which all combinations are tried.
COMBINED = 12
#: Rounds of "becomes before the event" before the iteration is called endless.
ROUNDS = 200


class Continuous(Protocol):
    """The continuous equations at one instant."""

    def solve(self, time: float) -> None:
        """Make the values in the work vector satisfy all equations for what is held.

        Raises:
            AcausalError: If there are none.
        """

    def reinit(self, acting: Ids, values: Array, time: float) -> None:
        """Give continuous variables new values, see ``Hybrid.reinits``."""

    def glances(self, time: float, step: float, look: Callable[[], Array]) -> list[Array] | None:
        """Return what a function is now and after one and two steps; None if it cannot be told."""


#: Codes of initial conditions that contradict each other or are too few.
CONDITIONS = {"I010", "I011"}


class EndlessError(Exception):
    """The event iteration does not settle.

    Attributes:
        places: Held positions that change again and again, ascending.
        unsolvable: The relations and the continuous equations contradict in every combination;
            otherwise discrete variables go round in circles.
        cause: Why the continuous equations could not be solved last, if they could not.
        through: Bodies would go through what they have met: its relations stay as they are.
        not_finite: A discrete variable would get a value that is no number; nothing else counts.
    """

    def __init__(
        self,
        places: Ids,
        unsolvable: bool,
        cause: AcausalError | None = None,
        *,
        not_finite: bool = False,
        through: bool = False,
    ) -> None:
        super().__init__()
        self.places = places
        self.unsolvable = unsolvable
        self.cause = cause
        self.not_finite = not_finite
        self.through = through


class EventIteration:
    """Settles everything at one instant.

    Attributes:
        kernels: The discrete equations.
        accumulation: Watches impacts.
        contacts: Watches what makes reinits act.
        rested: Reinits whose bodies have come to rest during the last settlement.
        terminated: Number of a termination that has acted, else -1.
        violated: Members of assertions in whens that did not hold, shape of ``kernels.holds``.
        solved: Continuous values were found anew during the last settlement.
    """

    def __init__(
        self, kernels: EventKernels, accumulation: Accumulation, contacts: Contacts
    ) -> None:
        self.kernels = kernels
        self.accumulation = accumulation
        self.contacts = contacts
        self.rested: Ids = np.zeros(0, np.int64)
        hybrid = kernels.hybrid
        self._n = hybrid.n_discrete
        self._relevant = np.flatnonzero(hybrid.relevant)
        self._partial = any(is_partial(f.template) for f in hybrid.assignments)
        # what equations read of the held values, at the last solution
        self._known: Array = np.zeros(len(self._relevant))
        self._native: NativeSettlement | None = None
        self.prepared = False
        self.solved = False
        self.terminated = -1
        self.violated: NDArray[np.bool_] = np.zeros(len(kernels.holds), np.bool_)

    def _solve(self, continuous: Continuous, time: float) -> None:
        continuous.solve(time)
        self._known[:] = self.kernels.held[self._relevant]
        self.solved = True

    def prepare(
        self, point: NativePoint | None, y: tuple[Array, Array], shown: tuple[Array, Array]
    ) -> None:
        """Use native code from now on where that is possible.

        Args:
            point: Solves the continuous equations.
            y: Unknowns and derivatives that the continuous equations have found.
            shown: Where the discrete equations see them.
        """
        self.prepared = True
        kernels = self.kernels
        if point is None or len(kernels.terminates) or len(kernels.holds):
            return
        rests = kernels.hybrid.rests
        none = np.zeros(0, np.int64)
        places = (none, none) if rests is None else (rests.at_rest, rests.supported)
        self._native = NativeSettlement(
            kernels, self._relevant, self._known, places, point, y, shown
        )

    def first(self, continuous: Continuous, time: float) -> None:
        """Settle the first instant: relations as they are, no when fires but those of initial."""
        kernels, hybrid = self.kernels, self.kernels.hybrid
        held = kernels.held
        held[hybrid.initial_flag] = 1.0
        kernels.assign_initial_pre()
        # The first solution is sought for the relations and discrete values that belong to the
        # start values; what was found may say otherwise.
        self.as_they_are()
        try:
            self._solve(continuous, time)
        except AcausalError as error:
            # The start values may lie in a mode in which there is no solution.
            try:
                self._combined(continuous, time, True, np.zeros(0, np.int64), error)
            except EndlessError:
                if error.diagnostics[0].code in CONDITIONS:
                    raise error from None
                raise
        kernels.assign_initial_pre()  # may say: as the continuous values are
        self.as_they_are()
        self._rounds(continuous, time, once=hybrid.initial_flag, initial=True)
        self._end_of_event()

    def as_they_are(self) -> None:
        """Hold everything at what the continuous values say, without hysteresis."""
        kernels = self.kernels
        kernels.remember_limits()
        # As if all conditions had been true before: nothing fires but what initial() fires. The
        # first round ends this, its conditions become those before the second one.
        kernels.held[self._n + kernels.hybrid.conditions] = 1.0
        if kernels.delays is not None:
            kernels.delays.begin()
        for _ in range(2):  # relations may stand inside of relations
            kernels.look(exact=True)
            kernels.follow()
            kernels.assign(initial=True)

    def at(
        self,
        continuous: Continuous,
        time: float,
        relations: Array | None,
        samples: Ids,
        once: int = -1,
        *,
        anew: bool = False,
    ) -> None:
        """Settle an event.

        Args:
            continuous: The continuous equations.
            time: When, seconds.
            relations: What the relations are held at to begin with, if roots were found.
            samples: Held positions of the samples whose time it is.
            once: Held position of what is true in the first round only, -1 for nothing.
            anew: Something that the equations read has changed already.
        """
        kernels = self.kernels
        self.solved = False
        self.rested = self.rested[:0]
        self._known[:] = np.nan if anew else kernels.held[self._relevant]
        kernels.remember_limits()
        kernels.leave()
        if relations is not None:  # those whose root was found were near zero
            kernels.states.left[relations != kernels.relation_values()] = 0.0
        if len(samples):
            kernels.held[samples] = 1.0
        if relations is not None:
            kernels.hold_relations(relations)
        self._rounds(continuous, time, once=once)
        if len(samples):
            kernels.held[samples] = 0.0
            self._end_of_event()

    def last(self, continuous: Continuous, time: float) -> None:
        """Settle the last instant: whens of ``terminal()`` fire."""
        kernels = self.kernels
        flag = kernels.hybrid.terminal_flag
        kernels.held[flag] = 1.0
        self.at(continuous, time, None, np.zeros(0, np.int64), once=flag)

    def _end_of_event(self) -> None:
        """Let what is true during an event only become false, without anything firing."""
        held, n = self.kernels.held, self._n
        self.kernels.assign()
        held[n : 2 * n] = held[:n]

    def _rounds(
        self, continuous: Continuous, time: float, *, once: int = -1, initial: bool = False
    ) -> None:
        held, n = self.kernels.held, self._n
        if self._native is not None and once < 0 and self._has_settled(continuous, time):
            return
        for round_ in range(ROUNDS):
            self._settle(continuous, time, initial and round_ == 0)
            self._note()
            acted = self._reinit(continuous, time)
            if once >= 0:  # initial() or terminal(): what they fire fires once
                acted |= held[once] != 0.0
                held[once] = 0.0
            if not acted and held[n : 2 * n].tobytes() == held[:n].tobytes():
                return
            if self._partial and not np.isfinite(held[:n]).all():
                raise EndlessError(np.flatnonzero(~np.isfinite(held[:n])), False, not_finite=True)
            before = held[n : 2 * n].copy()
            held[n : 2 * n] = held[:n]
            self.kernels.remember_limits()
        held[n : 2 * n] = before  # for the message
        raise EndlessError(np.flatnonzero(before != held[:n]), False)

    def _has_settled(self, continuous: Continuous, time: float) -> bool:
        """Let native code do the rounds; return False where something unusual is left to do."""
        native, held, n = self._native, self.kernels.held, self._n
        assert native is not None
        for _ in range(ROUNDS):
            outcome = native.settle(time)
            self.solved |= native.solved
            if outcome != Outcome.REINIT:
                return outcome == Outcome.SETTLED
            self._reinit(continuous, time)
            if self._partial and not np.isfinite(held[:n]).all():
                return False
            held[n : 2 * n] = held[:n]
            self.kernels.remember_limits()
        return False

    def _note(self) -> None:
        """Take note of what whens say in this round besides setting variables."""
        number = self.kernels.evaluate_terminations()
        if number >= 0:
            self.terminated = number
        if not self.kernels.evaluate_assertions():
            self.violated |= self.kernels.holds == 0.0

    # --- one round: values before the event frozen -----------------------------------------

    def _settle(self, continuous: Continuous, time: float, initial: bool) -> None:
        """Take turns until nothing changes."""
        seen: set[bytes] = set()
        for _ in range(TURNS):
            changed = self._turn(initial, None)
            now = self.kernels.held[self._relevant].tobytes()
            if now != self._known.tobytes():
                if now in seen:
                    break
                seen.add(now)
                try:
                    self._solve(continuous, time)
                except AcausalError:
                    break
            elif not changed:
                return
        self._one_at_a_time(continuous, time, initial)

    def _turn(self, initial: bool, only: int | None) -> bool:
        """Evaluate relations and discrete equations; return whether anything changed.

        Args:
            initial: With the initial equations.
            only: Change at most this many relations, the first ones.
        """
        kernels, n = self.kernels, self._n
        changed = kernels.look()
        if changed:
            if only is not None:
                states = kernels.states
                keep = np.flatnonzero(states.wanted != states.held)[only:]
                states.wanted[keep] = states.held[keep]
            kernels.follow()
        changed |= self.accumulation.end_rests(kernels)
        discrete = kernels.held[:n]
        before = discrete.tobytes()
        kernels.assign(initial=initial)
        return changed or before != discrete.tobytes()

    def _reinit(self, continuous: Continuous, time: float) -> bool:
        """Let reinits act, once everything else has settled; return whether any did.

        What fired them has fired: relations that the new values contradict change in the next
        round, in which the present values are those before it.
        """
        kernels = self.kernels
        if not kernels.evaluate_reinits():
            return False
        acting = np.flatnonzero(kernels.fires)
        values = kernels.reinit_values
        ending = self.accumulation.ending(acting, values, time)
        if len(ending):
            self._come_to_rest(continuous, acting, ending, time)
            return True
        before = kernels.values_of(kernels.hybrid.reinits.states[acting])
        continuous.reinit(acting, values, time)
        self._solve(continuous, time)
        stuck, relations = self.contacts.stuck(
            acting, before, time, kernels, lambda step, look: continuous.glances(time, step, look)
        )
        if not len(stuck):
            return True
        if not self.accumulation.are_calm(stuck, before[np.isin(acting, stuck)], kernels):
            raise EndlessError(kernels.states.relations.place[relations], False, through=True)
        self._come_to_rest(continuous, acting, stuck, time)
        return True

    def _come_to_rest(self, continuous: Continuous, acting: Ids, ending: Ids, time: float) -> None:
        values = self.kernels.reinit_values.copy()
        values[ending] = 0.0
        continuous.reinit(acting, values, time)
        self.accumulation.begin_rest(ending, self.kernels)
        self._solve(continuous, time)
        self.accumulation.orient(ending, self.kernels)
        self.rested = ending

    def _one_at_a_time(self, continuous: Continuous, time: float, initial: bool) -> None:
        """Change the first wrong relation, solve, and again."""
        seen: set[bytes] = set()
        kernels, n = self.kernels, self._n
        start = kernels.held.copy()
        states: list[Array] = []
        cause: AcausalError | None = None
        for _ in range(SINGLE_TURNS):
            try:
                self._solve(continuous, time)
                if not self._turn(initial, 1):
                    return
            except AcausalError as error:
                cause = error
                break
            relations = kernels.relation_values()
            key = relations.tobytes() + kernels.held[:n].tobytes()
            if key in seen:
                break
            seen.add(key)
            states.append(relations)
        moving = np.zeros(len(kernels.relation_values()), np.bool_)
        for other in states:
            moving |= other != states[-1]
        kernels.held[:] = start
        self._combined(continuous, time, initial, np.flatnonzero(moving), cause)

    def _combined(
        self, continuous: Continuous, time: float, initial: bool, moving: Ids,
        cause: AcausalError | None,
    ) -> None:  # fmt: skip
        """Try all combinations of some relations that are true or false."""
        kernels = self.kernels
        every = np.flatnonzero(kernels.states.relations.kind < 2)
        if len(every) <= COMBINED:
            # The solution may need one that did not move.
            moving = np.concatenate([moving, np.setdiff1d(every, moving)])
        if 0 < len(moving) <= COMBINED:
            start = kernels.held.copy()
            base = kernels.relation_values()
            for size in range(len(moving) + 1):
                for chosen in combinations(moving.tolist(), size):
                    kernels.held[:] = start
                    trial = base.copy()
                    flip = list(chosen)
                    trial[flip] = 1.0 - trial[flip]
                    kernels.hold_relations(trial)
                    kernels.assign(initial=initial)
                    try:
                        self._solve(continuous, time)
                    except AcausalError as error:
                        cause = error
                        continue
                    if not self._turn(initial, None):
                        return
            kernels.held[:] = start
        places = kernels.states.relations.place[moving]
        raise EndlessError(np.sort(places), True, cause)
