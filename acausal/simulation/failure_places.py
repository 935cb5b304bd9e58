"""Where a failed integration stood: the line, and the values of what is concerned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from acausal.diagnostics import Diagnostic, Span
from acausal.flattening.model import Operand
from acausal.initialization.texts import origin_of
from acausal.simulation.labels import SystemLabels
from acausal.simulation.run import Run
from acausal.solvers.failures import IntegrationError

#: Values in one message.
MOST = 8


def told(run: Run) -> tuple[Diagnostic, ...]:
    """Return the diagnostics of a run's failure, none if it has not failed.

    Those of an integrator get the line of the first equation concerned, or of the declaration of
    the first variable, and the values at the last good point.
    """
    error = run.failure
    if error is None:
        return ()
    if not isinstance(error, IntegrationError) or run.current is None or run.integrator is None:
        return error.diagnostics
    layout, failure = run.current.layout, error.failure
    labels = SystemLabels(run.system, layout)
    concerned = [int(layout.y_ids[k]) for k in failure.unknowns]
    span: Span | None = None
    for row in failure.rows:
        place, variables = _row(run, row)
        span = span or place
        concerned += variables
    if span is None and concerned and concerned[0] < len(run.system.representative):
        span = run.system.names.declaration(concerned[0])
    values = run.values()
    shown = dict.fromkeys(f"{labels.name(v)} = {values[v]:.6g}" for v in concerned)
    note = f"values at {run.integrator.t:.9g} s: {', '.join(list(shown)[:MOST])}"
    first, *others = error.diagnostics
    notes = (*first.notes, note) if shown else first.notes
    return (replace(first, span=first.span or span, notes=notes), *others)


def _row(run: Run, row: int) -> tuple[Span | None, list[int]]:
    """Return where a row is written, and its variables."""
    for family in run.system.differentiated.families:
        for member in np.flatnonzero(family.rows == row)[:1].tolist():
            origin = origin_of(family, member)
            variables = [
                int(ids[member])
                for kind, ids in zip(family.kinds, family.operands, strict=True)
                if kind == Operand.VARIABLE
            ]
            return (origin.span if origin else None), variables
    return None, []
