"""What the stages have made of a model, as text or as mathematics."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from acausal.diagnostics import AcausalError
from acausal.elimination.eliminate import Elimination
from acausal.flattening.flatten import Flattened
from acausal.flattening.model import Ids
from acausal.inspection.blocks import show_blocks
from acausal.inspection.connect import show_connect
from acausal.inspection.eliminate import show_eliminate
from acausal.inspection.flatten import show_flatten
from acausal.inspection.instantiate import show_instantiate
from acausal.inspection.latex_report import (
    document,
    latex_eliminate,
    latex_flatten,
    latex_structure,
)
from acausal.inspection.parse import show_parse
from acausal.inspection.structure import show_structure
from acausal.modeling.classes import ClassDef
from acausal.simulation.states import StateSelector
from acausal.simulation.system import System

STAGES = ("parse", "instantiate", "connect", "flatten", "eliminate", "structure", "blocks")


class Compilation(Protocol):
    """What each stage has made; None where the compilation did not come so far."""

    @property
    def definition(self) -> ClassDef | None:
        """The class."""

    @property
    def flattened(self) -> Flattened | None:
        """The flat model."""

    @property
    def elimination(self) -> Elimination | None:
        """What was taken out."""

    @property
    def system(self) -> System | None:
        """The system after index reduction."""


def inspect(stages: Compilation, stage: str = "all", latex: bool = False) -> str:
    """Return what a stage has made of a model.

    Args:
        stages: The compilation.
        stage: One of :data:`STAGES`, or ``all``.
        latex: Return a LaTeX document with the equations of the stage; stages without equations
            give a comment.

    Raises:
        ValueError: If there is no such stage.
    """
    if stage != "all" and stage not in STAGES:
        raise ValueError(f"no stage {stage!r}; the stages are {', '.join(STAGES)}, all")
    wanted = STAGES if stage == "all" else (stage,)
    name = stages.definition.full_name if stages.definition is not None else ""
    if latex:
        body = [line for one in wanted for line in _latex(stages, one, alone=len(wanted) == 1)]
        return "\n".join(document(name, body)) + "\n"
    parts: list[str] = []
    for one in wanted:
        title = f"{one}: {name}"
        parts.append("\n".join([title, "=" * len(title), *_text(stages, one)]))
    return "\n\n".join(parts) + "\n"


def reached(stages: Compilation, stage: str) -> bool:
    """Tell whether a compilation came to a stage; ``all`` needs the last one."""
    if stage == "parse":
        return stages.definition is not None
    if stage in ("instantiate", "connect", "flatten"):
        return stages.flattened is not None
    if stage == "eliminate":
        return stages.flattened is not None and stages.elimination is not None
    return stages.system is not None


def _text(stages: Compilation, stage: str) -> list[str]:
    definition, flattened = stages.definition, stages.flattened
    elimination, system = stages.elimination, stages.system
    if not reached(stages, stage):
        return [f"the compilation did not come to stage {stage}"]
    if stage == "parse":
        assert definition is not None
        return show_parse(definition)
    assert flattened is not None
    if stage == "instantiate":
        return show_instantiate(flattened)
    if stage == "connect":
        return show_connect(flattened)
    if stage == "flatten":
        return show_flatten(flattened)
    assert elimination is not None
    if stage == "eliminate":
        return show_eliminate(flattened, elimination)
    assert system is not None
    if stage == "structure":
        return show_structure(flattened, elimination, system)
    return show_blocks(flattened, elimination, system)


def _latex(stages: Compilation, stage: str, alone: bool) -> list[str]:
    flattened, elimination, system = stages.flattened, stages.elimination, stages.system
    if stage == "flatten" and flattened is not None:
        return latex_flatten(flattened)
    if stage == "eliminate" and flattened is not None and elimination is not None:
        return latex_eliminate(flattened, elimination)
    if stage == "structure" and flattened and elimination and system:
        return latex_structure(flattened, elimination, system, states_of(system))
    return [f"% stage {stage} has no equations of its own"] if alone else []


def states_of(system: System) -> Ids | None:
    """Return the states chosen at the start, None if they cannot be told before a run."""
    try:
        return StateSelector(system).first(
            np.array(system.variables.start), system.experiment.start_time
        )
    except AcausalError:
        return None
