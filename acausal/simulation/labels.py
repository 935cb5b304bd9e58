"""Names of unknowns and rows for messages of the integrator."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from acausal.assembly.layout import Layout
from acausal.flattening.model import RowKind
from acausal.simulation.system import System


@dataclass(frozen=True)
class SystemLabels:
    """Implements :class:`acausal.solvers.protocol.Labels` for a model."""

    system: System
    layout: Layout

    def unknown(self, index: int) -> str:
        """Return the path of the unknown ``y[index]``."""
        return self.name(int(self.layout.y_ids[index]))

    def name(self, variable: int) -> str:
        """Return the path of an id; derivatives from index reduction are der(...)."""
        known = self.system.variables.count
        if variable < min(known, len(self.system.representative)):
            try:
                return self.system.names.variable(variable)
            except (IndexError, ZeroDivisionError):
                pass
        before = np.flatnonzero(self.system.derivative == variable)
        return f"der({self.name(int(before[0]))})" if len(before) else f"#{variable}"

    def row(self, index: int) -> str:
        """Return the equation of row ``index`` in the user's words."""
        for family in self.system.differentiated.families:
            for member in np.flatnonzero(family.rows == index).tolist():
                for origin in family.origins:
                    if origin.first <= member < origin.first + origin.count:
                        instance = int(origin.instances[member - origin.first])
                        path = self.system.names.instance_path(origin.group, instance)
                        if origin.kind == RowKind.JUNCTION:
                            return f"{origin.text} ({path})"
                        where = f" (line {origin.span.line})" if origin.span else ""
                        return f"{path}: {origin.text}{where}" if path else origin.text + where
        return "the derivative of a state"
