"""Events in the words of the model: for the list of events and for messages."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import AcausalError, Diagnostic, Span
from acausal.flattening.model import EquationFamily, Ids, Operand
from acausal.initialization.texts import member_text
from acausal.simulation.event_kernels import EventKernels
from acausal.simulation.system import System

Array = NDArray[np.float64]

#: Variables and relations named in one message.
_MOST = 6


class EventTexts:
    """Texts of relations and of discrete variables, made when asked for."""

    def __init__(self, system: System, kernels: EventKernels) -> None:
        self._system = system
        self._relations = kernels.states.relations
        self._hybrid = kernels.hybrid
        self._held = kernels.held
        self._known: dict[int, tuple[str, Span | None]] = {}

    def relation(self, number: int) -> tuple[str, Span | None]:
        """Return component and text of a relation, and where it is written."""
        if number not in self._known:
            family, member = self._relations.find(number)
            self._known[number] = member_text(family, member, self._system.names)
        return self._known[number]

    def place(self, place: int) -> tuple[str, Span | None]:
        """Return the text of whatever is held at a position."""
        hybrid = self._system.hybrid
        assert hybrid is not None
        found = np.flatnonzero(self._relations.place == place)
        if len(found):
            return self.relation(int(found[0]))
        own = np.flatnonzero(hybrid.place == place)
        if len(own):
            variable = int(own[0])
            names = self._system.names
            return names.variable(variable), names.declaration(variable)
        for family in hybrid.assignments:
            members = np.flatnonzero(family.rows == place)
            if len(members):
                return member_text(family, int(members[0]), self._system.names)
        return "a held value", None

    def values(self, places: Ids, values: Array) -> tuple[str, ...]:
        """Return notes with the values of discrete variables, and of those in relations.

        Args:
            places: Held positions.
            values: Values of all ids.
        """
        lines: list[str] = []
        names = self._system.names
        declared = len(self._system.representative)
        for place in places.tolist()[:_MOST]:
            found = np.flatnonzero(self._relations.place == place)
            if not len(found):
                own = np.flatnonzero(self._hybrid.place == place)
                if len(own):
                    now, before = self._held[place], self._held[self._hybrid.n_discrete + place]
                    lines.append(f"{names.variable(int(own[0]))} = {now:.6g}, before {before:.6g}")
                continue
            family, member = self._relations.find(int(found[0]))
            for variable in _variables(family, member)[:_MOST]:
                if variable < declared:
                    lines.append(f"{names.variable(variable)} = {values[variable]:.6g}")
        return tuple(dict.fromkeys(lines))

    def error(
        self, code: str, message: str, places: Ids, values: Array, help_: str,
        notes: tuple[str, ...] = (),
    ) -> AcausalError:  # fmt: skip
        """Return an error that names what is held at some positions."""
        texts = [self.place(place) for place in places.tolist()[:_MOST]]
        span = next((span for _, span in texts if span is not None), None)
        words = dict.fromkeys(f"{text}{f' (line {s.line})' if s else ''}" for text, s in texts)
        more = f"and {len(places) - _MOST} more" if len(places) > _MOST else ""
        shown = self.values(places, values)
        all_notes = [
            *(["involved: " + "; ".join((*words, *([more] if more else [])))] if words else []),
            *(["values: " + ", ".join(shown)] if shown else []),
            *notes,
        ]
        return AcausalError([Diagnostic(code, message, span, notes=tuple(all_notes), help=help_)])


def _variables(family: EquationFamily, member: int) -> list[int]:
    return [
        int(family.operands[k, member])
        for k, kind in enumerate(family.kinds)
        if kind == Operand.VARIABLE
    ]
