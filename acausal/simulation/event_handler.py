"""Events of a run: what the solver or the clock has found is settled, stored, and gone on from."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import AcausalError, Diagnostic
from acausal.flattening.model import Ids, Operand
from acausal.results.result import Ending, Event
from acausal.simulation.accumulation import Accumulation
from acausal.simulation.assertions import violation_at
from acausal.simulation.contacts import Contacts
from acausal.simulation.continuous_values import RunValues
from acausal.simulation.event_iteration import EndlessError, EventIteration
from acausal.simulation.event_kernels import EventKernels
from acausal.simulation.event_messages import chattering, endless
from acausal.simulation.event_texts import EventTexts
from acausal.simulation.finite_values import FiniteValues, at_event
from acausal.simulation.impacts import Impacts
from acausal.simulation.run import Assembled, Run
from acausal.simulation.schedule import Schedule
from acausal.simulation.system import System
from acausal.solvers.protocol import Integrator

Array = NDArray[np.float64]

#: So many state events within this share of the run are no motion any more.
CHATTERING = 200
CHATTERING_SHARE = 1e-6
#: Share of the run over which slopes are found by a difference.
INSTANT = 1e-10
#: So often one relation has changed among them.
OFTEN = 20
#: Changes of relations whose texts are kept.
KNOWN_TEXTS = 100


class EventHandler:
    """Handles the events of a run.

    Attributes:
        next_time: Time of the next event that is known beforehand, ``inf`` if there is none.
        warned: Numbers of the assertions in whens that were reported.
        remarks: Their warnings.
    """

    def __init__(self, run: Run, start: float) -> None:
        hybrid = run.system.hybrid
        assert hybrid is not None
        self._run = run
        self._hybrid = hybrid
        self._impacts = Impacts(run.system)
        self._accumulation = Accumulation(hybrid, run.tolerance)
        self._contacts = Contacts(hybrid, start, run.tolerance)
        self._schedule = Schedule(hybrid, start)
        self._tools: dict[int, tuple[EventIteration, RunValues]] = {}
        self._texts: EventTexts | None = None
        self._known_texts: dict[bytes, str] = {}
        self._recent: deque[tuple[float, bytes]] = deque(maxlen=CHATTERING)
        self._instant = INSTANT * (run.stop - start)
        self._shortest = CHATTERING_SHARE * (run.stop - start)
        self.next_time = np.inf
        self.warned: set[int] = set()
        self.remarks: list[Diagnostic] = []
        self._over = False
        self._shown = shown_places(run.system)
        self._finite = FiniteValues(run.system, self._shown)
        run.on_new_layout = self._new_layout

    @property
    def limit(self) -> float:
        """How far the integration may go at a time, seconds."""
        early = self._accumulation.early
        return early if self._run.time < early < self.next_time else self.next_time

    def _new_layout(self, assembled: Assembled) -> None:
        assert assembled.events is not None

        def integrator() -> Integrator:
            assert assembled.integrator is not None
            return assembled.integrator

        values = RunValues(
            self._run.system, assembled.layout, assembled.states, assembled.native.problem.w,
            integrator, self._impacts,
        )  # fmt: skip
        self._tools[id(assembled)] = (
            EventIteration(assembled.events, self._accumulation, self._contacts),
            values,
        )

    def _present(self) -> tuple[Assembled, EventKernels, EventIteration, RunValues, Integrator]:
        current = self._run.current
        assert current is not None and current.events is not None
        assert current.integrator is not None
        return current, current.events, *self._tools[id(current)], current.integrator

    def started(self) -> None:
        """Begin, the first instant being settled; samples at this time are a part of it."""
        run = self._run
        _, kernels, iteration, values, integrator = self._present()
        values.take(run.time, integrator.y, integrator.yp)
        due = self._schedule.due(run.time)
        if len(due):
            try:
                iteration.at(values, run.time, None, due)
            except EndlessError as reason:
                raise endless(run.system, kernels, reason, values.values(), run.time) from None
            if iteration.solved:
                run.begin_at(run.time, values.y, values.yp)
        if kernels.delays is not None:
            kernels.delays.table.append(run.time, kernels.delays.present())
        self._go_on(kernels, integrator)

    def memory(self) -> dict[str, Array]:
        """Return what relations, delays, samples and impacts remember at the present time."""
        _, kernels, _, _, _ = self._present()
        states = kernels.states
        found = {
            **self._schedule.memory(), **self._accumulation.memory(), **self._contacts.memory(),
            "g": states.g.copy(), "slope": states.slope.copy(), "largest": states.largest.copy(),
        }  # fmt: skip
        if kernels.delays is not None:
            history = kernels.delays.table.history()
            found |= dict(zip(("times", "delayed", "slopes"), history, strict=True))
        return found

    def resumed(self, memory: Mapping[str, Array], anew: bool) -> None:
        """Go on from a memory.

        Args:
            memory: Of the same model.
            anew: Parameters have changed: everything discrete is settled again.

        Raises:
            AcausalError: ``E0xx`` if it does not settle.
        """
        run = self._run
        _, kernels, iteration, values, integrator = self._present()
        states = kernels.states
        states.g[:], states.slope[:] = memory["g"], memory["slope"]
        states.largest[:] = memory["largest"]
        for part in (self._schedule, self._accumulation, self._contacts):
            part.recall(memory)
        if kernels.delays is not None:
            table = kernels.delays.table
            table.restore(memory["times"], memory["delayed"], memory["slopes"])
            kernels.delays.show(run.time)
        values.take(run.time, integrator.y, integrator.yp)
        if anew:
            try:
                iteration.at(values, run.time, None, np.zeros(0, np.int64), anew=True)
            except EndlessError as reason:
                raise endless(run.system, kernels, reason, values.values(), run.time) from None
            if iteration.solved:
                run.begin_at(run.time, values.y, values.yp)
        self._go_on(kernels, integrator)

    def leapt(self) -> None:
        """Go on behind a jump of the algebraic equations."""
        _, kernels, _, values, integrator = self._present()
        values.take(self._run.time, integrator.y, integrator.yp)
        self._go_on(kernels, integrator)

    def _watch(self, kernels: EventKernels, integrator: Integrator) -> None:
        """Tell the solver which root functions to look for, and in which direction."""
        roots = self._run.current.native.problem.roots if self._run.current else None
        if roots is None:
            return
        roots.shift[:] = kernels.states.shift
        integrator.set_root_directions(kernels.states.direction.astype(np.int32))

    def _go_on(self, kernels: EventKernels, integrator: Integrator) -> None:
        kernels.prepare()
        self._watch(kernels, integrator)
        self.next_time = self._schedule.next_time(kernels)
        self._run.recorder.hold(kernels.held)

    def handle(self, is_root: bool) -> bool:
        """Settle the event at the present time and go on; return False if the run is over.

        Args:
            is_root: The solver has found a root; otherwise it is an event in time.
        """
        run = self._run
        _, kernels, iteration, values, integrator = self._present()
        if not iteration.prepared:
            iteration.prepare(integrator.native_point(), (values.y, values.yp), values.shown)
        time = run.time
        values.take(time, integrator.y, integrator.yp)
        expected, jumped = self._delayed(kernels, time)
        before = kernels.relation_values()
        resting = self._resting(kernels)
        relations = None
        if is_root:
            relations = kernels.states.after_roots(before, integrator.roots_found)
            if self._is_chattering(time, integrator.roots_found, kernels, values):
                return False
        n = self._hybrid.n_discrete
        discrete = kernels.held[:n].tobytes()
        shown = kernels.held[self._shown].tobytes()
        try:
            iteration.at(values, time, relations, self._schedule.due(time), anew=jumped)
            self._finite.check(kernels.held, values, time)
        except EndlessError as reason:
            run.record_here()
            error = endless(run.system, kernels, reason, values.values(), time, running=True)
            run.fail(at_event(error))
            return False
        except AcausalError as error:
            run.record_here()
            run.fail(at_event(error))
            return False
        if len(iteration.violated) and iteration.violated.any():
            self._violate(kernels, iteration, time)
        if kernels.delays is not None and expected is not None:
            self._schedule.add_jumps(kernels.delays.jump(time, expected))
        quiet = iteration.terminated < 0 and not self._over
        if (
            quiet
            and not iteration.solved
            and discrete == kernels.held[:n].tobytes()
            and shown == kernels.held[self._shown].tobytes()
        ):
            # Only a relation has changed, and nothing depends on it now.
            if kernels.delays is not None:
                kernels.delays.table.right = False
            self._go_on(kernels, integrator)
            return True
        run.record_here()  # the integrator still stands before the event
        self._describe(kernels, time, before, relations)
        self._describe_rests(kernels, iteration, time, resting)
        if iteration.solved:
            self._restart(time, values)
            if kernels.delays is not None:
                kernels.delays.table.right = False
            _, kernels, _, _, integrator = self._present()
        self._go_on(kernels, integrator)
        run.record_here()
        if iteration.terminated >= 0:
            self._terminate(iteration.terminated, time)
            return False
        return not self._over

    def _delayed(self, kernels: EventKernels, time: float) -> tuple[Array | None, bool]:
        """Let an event see delayed values.

        Returns:
            The delayed expressions before it, and whether delayed values jump at this time.
        """
        delays = kernels.delays
        if delays is None:
            return None, False
        delays.show(time)
        self._run.recorder.hold(kernels.held)
        before = delays.present().copy()
        jumped = self._schedule.has_jump(time)
        delays.show(time, right=jumped)
        return before, jumped

    def _violate(self, kernels: EventKernels, iteration: EventIteration, time: float) -> None:
        """Report assertions in whens that do not hold; an error ends the run."""
        run = self._run
        first = 0
        for number in kernels.assertions:
            assertion = run.system.assertions[number]
            members = np.flatnonzero(iteration.violated[first : first + assertion.family.count])
            first += assertion.family.count
            if len(members) and number not in self.warned:
                self.warned.add(number)
                found = violation_at(run.system, assertion, int(members[0]), time)
                if assertion.warning:
                    self.remarks.append(found)
                else:
                    run.fail(AcausalError([found]))
                    self._over = True
        iteration.violated[:] = False

    def _restart(self, time: float, values: RunValues) -> None:
        run = self._run
        if run.selector.has_alternatives:
            run.selector.hold(values.w[values.layout.parameters : values.layout.observables])
            everything = values.values()
            states = run.selector.better(everything, time)
            if states is not None:
                run.begin(time, everything, states)
                run.reselections += 1
                self._present()[3].take(time, *self._point())
                return
        values.find_slopes(time, self._instant)
        run.begin_at(time, values.y, values.yp)

    def _point(self) -> tuple[Array, Array]:
        integrator = self._run.integrator
        assert integrator is not None
        return integrator.y, integrator.yp

    def _is_chattering(
        self, time: float, roots: NDArray[np.int32], kernels: EventKernels, values: RunValues
    ) -> bool:
        self._recent.append((time, roots.tobytes()))
        if len(self._recent) < CHATTERING:
            return False
        span = time - self._recent[0][0]
        if span > self._shortest:
            return False
        states = kernels.states.relations
        found = np.frombuffer(b"".join(r for _, r in self._recent), np.int32) != 0
        often = found.reshape(CHATTERING, -1).sum(axis=0)
        times = np.bincount(states.root_relation, often, minlength=states.count)
        if times.max(initial=0) < OFTEN:
            return False  # many things happen next to each other
        relations = np.flatnonzero(times >= OFTEN)
        places: Ids = states.place[relations]
        self._run.fail(
            chattering(
                self._run.system, kernels, places, values.values(), time, len(self._recent), span
            )
        )
        return True

    def _describe(
        self, kernels: EventKernels, time: float, before: Array, found: Array | None
    ) -> None:
        """Add to the list of events.

        Args:
            kernels: The discrete equations, after the event.
            time: Seconds.
            before: What the relations were held at before, shape ``(n,)``.
            found: The same with those changed whose root was found; they may have changed back.
        """
        after = kernels.relation_values()
        key = before.tobytes() + after.tobytes() + (b"" if found is None else found.tobytes())
        text = self._known_texts.get(key)
        if text is None:
            changed = (after != before) if found is None else (after != before) | (found != before)
            text = self._text(kernels, np.flatnonzero(changed))
            if len(self._known_texts) < KNOWN_TEXTS:
                self._known_texts[key] = text
        self._run.events.append(Event(time, text))

    def _resting(self, kernels: EventKernels) -> Array:
        rests = self._hybrid.rests
        return np.zeros(0) if rests is None else kernels.held[rests.at_rest]

    def _describe_rests(
        self, kernels: EventKernels, iteration: EventIteration, time: float, resting: Array
    ) -> None:
        """Add rests that begin and end to the list of events."""
        events, reinits = self._run.events, self._hybrid.reinits
        for reinit in iteration.rested.tolist():
            name = self._run.system.names.variable(int(reinits.wanted[reinit]))
            events.append(Event(time, f"impacts accumulate: {name} comes to rest"))
        rests, now = self._hybrid.rests, self._resting(kernels)
        if rests is None or resting.tobytes() == now.tobytes():
            return
        for k in np.flatnonzero(resting > now).tolist():
            name = self._run.system.names.variable(int(reinits.wanted[rests.reinits[k]]))
            events.append(Event(time, f"{name} leaves its rest"))

    def _text(self, kernels: EventKernels, changed: Ids) -> str:
        if not len(changed):
            return "time event"
        if self._texts is None:
            self._texts = EventTexts(self._run.system, kernels)
        text = self._texts.relation(int(changed[0]))[0]
        return text + (f" and {len(changed) - 1} more" if len(changed) > 1 else "")

    def _terminate(self, number: int, time: float) -> None:
        run = self._run
        for termination in self._hybrid.terminations:
            if number < termination.family.count:
                run.events.append(Event(time, f"terminated: {termination.message}"))
                break
            number -= termination.family.count
        run.ending = Ending.TERMINATED

    def finish(self) -> None:
        """Settle the last instant: ``terminal()`` is true."""
        run = self._run
        if run.ending is not Ending.COMPLETE:
            return
        _, kernels, iteration, values, integrator = self._present()
        held = kernels.held.copy()
        values.take(run.time, integrator.y, integrator.yp)
        try:
            iteration.last(values, run.time)
        except (EndlessError, AcausalError):
            return
        if not np.array_equal(held, kernels.held):
            run.begin_at(run.time, values.y, values.yp)
            run.recorder.hold(kernels.held)
            run.record_here()


def shown_places(system: System) -> Ids:
    """Return the held positions that variables read which are computed when asked for."""
    hybrid = system.hybrid
    assert hybrid is not None
    parts = [
        ids[ids >= hybrid.first] - hybrid.first
        for family in system.definitions
        for kind, ids in zip(family.kinds, family.operands, strict=True)
        if kind == Operand.PARAMETER
    ]
    return np.unique(np.concatenate([np.zeros(0, np.int64), *parts]))
