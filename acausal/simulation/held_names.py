"""Names of held values, which stand among the parameters."""

from __future__ import annotations

import numpy as np

from acausal.flattening.model import EquationFamily, Hybrid, Names
from acausal.flattening.names import NumberingNames
from acausal.initialization.texts import substituted
from acausal.instantiation.numbering import Numbering

_SIGNS = {"gt": "{} > 0", "ge": "{} >= 0", "floor": "floor({})"}


class HeldNames(NumberingNames):
    """The names of a model with events: held values have those of what they are held for."""

    def __init__(self, numbering: Numbering, hybrid: Hybrid) -> None:
        super().__init__(numbering)
        self._hybrid = hybrid

    def parameter(self, parameter: int) -> str:
        """Return the path of a scalar parameter, or what is held at this place."""
        hybrid = self._hybrid
        place = parameter - hybrid.first
        if place < 0:
            return super().parameter(parameter)
        n = hybrid.n_discrete
        if place < n:
            return self._discrete(place)
        if place < 2 * n:
            return f"pre({self._discrete(place - n)})"
        for relation in hybrid.relations:
            if (found := _member(relation.family, place)) is not None:
                text = substituted(relation.family, found, relation.family.template, self)
                return f"({_SIGNS[relation.kind].format(text)})"
        for family in hybrid.limits:
            if (found := _member(family, place)) is not None:
                return f"pre({substituted(family, found, family.template, self)})"
        if place in hybrid.sample_places:
            return "(a sample)"
        where = np.flatnonzero(hybrid.delay_places == place)
        for family in hybrid.delays:
            if len(where) and (found := _member(family, int(where[0]))) is not None:
                return f"delay({substituted(family, found, family.template, self)})"
        return "(a held value)"

    def _discrete(self, place: int) -> str:
        variables = np.flatnonzero(self._hybrid.place == place)
        return self.variable(int(variables[0])) if len(variables) else "(the condition of a when)"


def _member(family: EquationFamily, row: int) -> int | None:
    members = np.flatnonzero(family.rows == row)
    return int(members[0]) if len(members) else None


def names_of(names: Names, numbering: Numbering, hybrid: Hybrid | None) -> Names:
    """Return the names of a model, with those of its held values."""
    return names if hybrid is None else HeldNames(numbering, hybrid)
