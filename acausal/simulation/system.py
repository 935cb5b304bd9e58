"""All that a simulation needs of a compiled model: arrays and templates, nothing symbolic to do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.flattening.model import (
    Assertion,
    EquationFamily,
    Experiment,
    Hybrid,
    Ids,
    Names,
    Variables,
)
from acausal.initialization.system import StartSystem
from acausal.structural.differentiate import DifferentiatedSystem
from acausal.structural.highest_jacobian import HighestEntries
from acausal.structural.pantelides import Offsets


@dataclass(frozen=True)
class System:
    """A model after index reduction.

    Attributes:
        name, description: Of the model.
        names: Paths of variables and parameters.
        experiment: What the model says about its simulation.
        variables: Attributes of all ids, those of index reduction included.
        differentiated: Rows, derivatives of rows, chains of derivatives.
        offsets: How often rows and variables are differentiated.
        entries: Jacobian entries that decide about states.
        active: Which ids are unknowns, shape ``(N,)``.
        initial: Families of the initial equations.
        n_initial: Number of initial rows.
        assertions: Conditions to watch.
        parameters: Values, shape ``(p,)``.
        representative: Who stands for each id, shape ``(N,)``.
        sign: How: 1, -1, or 0 for a known zero.
        definitions: Families that define eliminated variables, in order of evaluation.
        index: Structural differentiation index.
        hybrid: What happens at events; None where nothing does.
    """

    name: str
    description: str
    names: Names
    experiment: Experiment
    variables: Variables
    differentiated: DifferentiatedSystem
    offsets: Offsets
    entries: HighestEntries
    active: NDArray[np.bool_]
    initial: tuple[EquationFamily, ...]
    n_initial: int
    assertions: tuple[Assertion, ...]
    parameters: NDArray[np.float64]
    representative: Ids
    sign: NDArray[np.int8]
    definitions: tuple[EquationFamily, ...]
    index: int
    hybrid: Hybrid | None = None

    @property
    def derivative(self) -> Ids:
        """Id of each variable's derivative or -1, shape ``(N,)``."""
        return self.differentiated.chains.derivative

    def start_system(self, states: Ids) -> StartSystem:
        """Return the equations of the first instant.

        Args:
            states: Ids of the states, in order of preference.
        """
        return StartSystem(
            self.differentiated.families,
            self.differentiated.n_rows,
            self.initial,
            self.n_initial,
            self.variables,
            self.derivative,
            states,
            self.parameters,
            self.names,
            self.definitions,
        )
