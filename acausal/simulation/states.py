"""Which variables are states, now and whenever the choice becomes badly conditioned.

The Jacobian of the constraints with respect to their highest derivatives decides (see
:mod:`acausal.structural.dummy_derivatives`); it is evaluated by the kernels of the model, with
index arrays of its own.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Diagnostic, Severity
from acausal.flattening.model import Ids
from acausal.initialization.problem import AlgebraicProblem, StartEquations, algebraic_problem
from acausal.initialization.problem import start_equations as make_equations
from acausal.simulation.system import System
from acausal.structural.dummy_derivatives import StateSelection, select_states
from acausal.structural.highest_jacobian import highest_jacobian
from acausal.structural.reselection import reselect

Array = NDArray[np.float64]

#: Other states are chosen during the run when that multiplies a determinant by this factor.
CHANGE_ABOVE = 2.0
#: And by this one when the integrator has failed and anything better may help.
CHANGE_IN_NEED = 1.5


class StateSelector:
    """Chooses states and keeps the choice good."""

    def __init__(self, system: System) -> None:
        self.system = system
        self.selection: StateSelection | None = None

    @property
    def has_alternatives(self) -> bool:
        """True if the choice has to be watched during the run."""
        return self.selection is not None and self.selection.alternatives.any

    @property
    def columns(self) -> int:
        """Number of columns of the largest block that is watched."""
        if self.selection is None:
            return 0
        return max((s.bases.shape[1] for s in self.selection.alternatives.shapes), default=0)

    @property
    def _original(self) -> tuple[int, ...]:
        orders = self.system.differentiated.orders
        return tuple(k for k, order in enumerate(orders) if order == 0)

    def first(self, values: Array, time: float) -> Ids:
        """Return the states for values of all ids, ascending."""
        system = self.system
        chains = system.derivative
        if not system.offsets.c.any():
            return np.flatnonzero((chains >= 0) & system.active)
        families = [system.differentiated.families[k] for k in self._original]
        jacobian, constant = highest_jacobian(
            families, system.differentiated.chains, system.offsets, system.entries, values,
            system.parameters, time,
            None if system.hybrid is None else system.hybrid.first,
        )  # fmt: skip
        # Not scaled by nominal values: they say how much a variable changes in its usual place
        # (0.1 mm in a shaft); in a mechanism (a telescope next to its dead centre) they mislead.
        self.selection = select_states(
            system.differentiated.chains, system.offsets, system.entries, jacobian,
            system.variables.state_select, None, constant,
        )  # fmt: skip
        return self.selection.states

    def hold(self, parameters: Array) -> None:
        """Take other parameters and held values."""
        if not self.has_alternatives:
            return
        equations = self._problem[0]
        layout = equations.layout
        equations.w[layout.first_parameter : layout.last] = parameters

    def better(self, values: Array, time: float, force: bool = False) -> Ids | None:
        """Return better states if there are such, else None.

        Args:
            values: Values of all ids.
            time: Seconds.
            force: Change for a small gain, too.
        """
        if self.selection is None or not self.has_alternatives:
            return None
        found = reselect(
            self.selection, self._jacobian(values, time),
            tau=CHANGE_IN_NEED if force else CHANGE_ABOVE,
        )  # fmt: skip
        if found is None:
            return None
        self.selection = found
        return found.states

    @cached_property
    def _problem(self) -> tuple[StartEquations, AlgebraicProblem, Ids]:
        """Equations, problem, and where each wanted entry stands in its Jacobian."""
        system = self.system
        entries, chains = system.entries, system.differentiated.chains
        orders = system.offsets.d[entries.bases] - system.offsets.c[entries.rows]
        ids = chains.ids(entries.bases, orders)
        equations = make_equations(system.start_system(np.zeros(0, np.int64)), with_initial=False)
        rows, columns = np.unique(entries.rows), np.unique(ids)
        problem = algebraic_problem(equations, rows, columns)
        m = len(rows)
        keys = np.repeat(np.arange(problem.n), np.diff(problem.indptr)) * m + problem.indices
        wanted = np.searchsorted(columns, ids) * m + np.searchsorted(rows, entries.rows)
        order = np.argsort(keys)
        places = order[np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)]
        return equations, problem, np.where(keys[places] == wanted, places, -1)

    def _jacobian(self, values: Array, time: float) -> Array:
        equations, problem, places = self._problem
        equations.set_values(values, time)
        found = problem.jacobian(problem.get())
        return np.where(places >= 0, found[places], 0.0)

    def warnings(self) -> tuple[Diagnostic, ...]:
        """Return warnings about wishes that could not be granted."""
        if self.selection is None:
            return ()
        names = self.system.names
        result = []
        for ids, wish in (
            (self.selection.dummy_in_spite, "always"),
            (self.selection.state_in_spite, "never"),
        ):
            declared = [int(i) for i in ids if i < self.system.differentiated.n_original]
            if declared:
                paths = ", ".join(names.variable(i) for i in declared[:5])
                result.append(
                    Diagnostic(
                        "S110",
                        f"stateSelect = StateSelect.{wish} could not be granted for {paths}",
                        names.declaration(declared[0]),
                        help="constraints decide otherwise; use prefer or avoid",
                        severity=Severity.WARNING,
                    )
                )
        return tuple(result)
