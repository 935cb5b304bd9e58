"""A model after the events pass, its held values computed by the plainest means."""

from __future__ import annotations

import numpy as np
import pytest

from acausal.diagnostics import AcausalError
from acausal.events.lowering import lower_events
from acausal.expressions.evaluate import evaluate
from acausal.flattening.flatten import flatten
from acausal.flattening.model import EquationFamily, FlatModel, Hybrid, Operand
from acausal.instantiation.instantiate import instantiate
from acausal.modeling.load import choose_model, load_text


def lowered(text: str) -> FlatModel:
    """Return the flat model of a text after the events pass."""
    classes, _ = load_text(text)
    templates, left = instantiate(choose_model(classes, None, "the text"), {})
    return lower_events(flatten(templates, left).model)


def hybrid_of(model: FlatModel) -> Hybrid:
    assert model.hybrid is not None
    assert model.discrete is None
    return model.hybrid


def refused(text: str):
    """Return the message with which the events pass refuses a model."""
    with pytest.raises(AcausalError) as caught:
        lowered(text)
    found = caught.value.diagnostics[0]
    assert found.help
    return found


def values_of(
    family: EquationFamily, variables: np.ndarray, parameters: np.ndarray, time: float
) -> np.ndarray:
    assert set(family.kinds) <= {Operand.VARIABLE, Operand.PARAMETER}
    tables = {Operand.VARIABLE: variables, Operand.PARAMETER: parameters}
    found = evaluate(family.template, lambda k: tables[family.kinds[k]][family.operands[k]], time)
    return np.broadcast_to(found, (family.count,))


class State:
    """Values of a lowered model that one can set and look at by path."""

    def __init__(self, model: FlatModel) -> None:
        self.model = model
        self.hybrid = hybrid_of(model)
        self.variables = model.variables.start.copy()
        self.parameters = model.parameters.copy()

    def held(self, place: int) -> float:
        return float(self.parameters[self.hybrid.first + place])

    def find(self, path: str) -> int:
        ((_, variable),) = self.model.names.find_variables(path)
        return variable

    def place(self, path: str) -> int:
        return int(self.hybrid.place[self.find(path)])

    def __getitem__(self, path: str) -> float:
        place = self.place(path)
        return float(self.variables[self.find(path)]) if place < 0 else self.held(place)

    def __setitem__(self, path: str, value: float) -> None:
        self.variables[self.find(path)] = value

    def settle(self, time: float = 0.0) -> None:
        """Evaluate relations and assignments once, in order: no iteration is needed for that."""
        h = self.hybrid
        decide = {"gt": lambda g: g > 0, "ge": lambda g: g >= 0, "floor": np.floor}
        for r in h.relations:
            g = values_of(r.family, self.variables, self.parameters, time)
            self.parameters[h.first + r.family.rows] = decide[r.kind](g)
        for family in h.assignments:
            new = values_of(family, self.variables, self.parameters, time)
            self.parameters[h.first + family.rows] = new

    def forget(self) -> None:
        """Let the values before the event be the present ones."""
        h = self.hybrid
        now = slice(h.first, h.first + h.n_discrete)
        self.parameters[h.first + h.n_discrete : h.first + 2 * h.n_discrete] = self.parameters[now]

    def residuals(self, time: float = 0.0) -> np.ndarray:
        rows = np.zeros(self.model.n_rows)
        for family in self.model.families:
            found = values_of(family, self.variables, self.parameters, time)
            np.add.at(rows, family.rows, found)
        return rows
