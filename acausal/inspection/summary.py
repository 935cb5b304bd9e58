"""The answer of ``acausal check``: that a model is complete, and how large it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from acausal.diagnostics import Diagnostic
from acausal.inspection.hybrid import hybrid_counts
from acausal.inspection.lists import counted
from acausal.inspection.written_index import written_index

if TYPE_CHECKING:
    from acausal.inspection.inspect import Compilation


@dataclass(frozen=True)
class Summary:
    """Counts of a compiled model.

    Attributes:
        name, description: Of the model.
        classes: Classes in use, connectors and records included.
        components: Component instances, cuts not counted.
        cuts: Cuts.
        junctions: Junctions of two cuts or more.
        variables: Scalar variables, derivatives not counted.
        parameters: Scalar parameters.
        equations: Scalar equations, those of junctions included.
        families: Equation families.
        remaining: Equations left after elimination.
        differentiated: Equations that had to be differentiated.
        states: States.
        index: Structural differentiation index of the equations as they are written.
        events: Discrete variables, relations, conditions of whens, ... in words; empty if there
            are none.
        warnings: What was noticed and is no error.
    """

    name: str
    description: str
    classes: int
    components: int
    cuts: int
    junctions: int
    variables: int
    parameters: int
    equations: int
    families: int
    remaining: int
    differentiated: int
    states: int
    index: int
    events: str
    warnings: tuple[Diagnostic, ...]

    def __str__(self) -> str:
        """Return the counts in words, warnings below."""
        about = f' "{self.description}"' if self.description else ""
        classes = counted(self.classes, "class", "classes")
        families = counted(self.families, "family", "families")
        lines = [
            f"{self.name}{about}: complete",
            f"  {counted(self.components, 'component')} of {classes}",
            f"  {counted(self.cuts, 'cut')} at {counted(self.junctions, 'junction')}",
            f"  {counted(self.variables, 'variable')}, {counted(self.parameters, 'parameter')}",
            f"  {counted(self.equations, 'equation')} in {families}",
            f"  {counted(self.remaining, 'equation')} after elimination, "
            f"{self.differentiated} of them differentiated",
            f"  {counted(self.states, 'state')}, differentiation index {self.index}",
        ]
        if self.events:
            lines.append(f"  {self.events}")
        if self.warnings:
            from acausal.diagnostics.render import render

            lines += ["", render(self.warnings, color=False).rstrip("\n")]
        return "\n".join(lines)


def summary(stages: Compilation) -> Summary:
    """Return the counts of a compilation that went through."""
    flattened, elimination, system = stages.flattened, stages.elimination, stages.system
    assert flattened is not None
    assert elimination is not None
    assert system is not None
    numbering, junctions = flattened.numbering, flattened.junctions
    used = [g for g in numbering.groups[:-1] if g.count]
    inside = [
        g.count
        for g in used
        if not g.template.is_connector and g.template.definition.kind != "record"
    ]
    whole = np.flatnonzero(junctions.interface >= 0)
    faces = np.stack([2 * whole, 2 * whole + 1]).reshape(-1)
    members = np.bincount(junctions.junction[faces], minlength=1)
    return Summary(
        flattened.model.name,
        flattened.model.description,
        len(used) + 1,
        sum(inside),
        len(whole),
        int((members > 1).sum()),
        numbering.n_declared,
        numbering.n_parameters,
        flattened.model.n_rows,
        len(flattened.model.families),
        elimination.model.n_rows,
        int((system.offsets.c > 0).sum()),
        system.offsets.degrees_of_freedom,
        written_index(flattened, system),
        "" if system.hybrid is None else hybrid_counts(system.hybrid),
        elimination.model.warnings,
    )
