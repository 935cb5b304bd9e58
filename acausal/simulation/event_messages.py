"""Errors of events: iterations that do not end, chattering."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import AcausalError
from acausal.flattening.model import Ids
from acausal.simulation.event_iteration import EndlessError
from acausal.simulation.event_kernels import EventKernels
from acausal.simulation.event_texts import EventTexts
from acausal.simulation.not_finite import refuse_discrete
from acausal.simulation.system import System

Array = NDArray[np.float64]


def endless(
    system: System, kernels: EventKernels, reason: EndlessError, values: Array, time: float,
    *, running: bool = False,
) -> AcausalError:  # fmt: skip
    """Return the error of an event iteration that does not settle.

    Args:
        system: The model.
        kernels: Its discrete equations.
        reason: What happened.
        values: Values of all ids.
        time: Seconds.
        running: It is not the first instant, at which the start values may be to blame.
    """
    hybrid = kernels.hybrid
    if reason.not_finite:
        first = kernels.first - hybrid.first
        parameters = kernels.w[first : kernels.first + hybrid.count]
        try:
            refuse_discrete(system, kernels.held, values, parameters, time)
        except AcausalError as error:
            return error
    texts = EventTexts(system, kernels)
    if reason.through:
        return texts.error(
            "E045",
            f"impacts follow each other without end at t = {time:.9g} s, and what has met would go "
            "through each other",
            reason.places,
            values,
            "reinit cannot hold bodies together that go on moving: use an elastic contact "
            "(mechanical.translational.ElastoGap), or an equation for the time in which they "
            "stay together",
        )
    cause = reason.cause.diagnostics[0] if reason.cause is not None else None
    if cause is not None and (not running or cause.code == "I030"):
        return AcausalError([cause])
    if reason.unsolvable:
        found = texts.error(
            "E042",
            f"no combination of relations satisfies the equations at t = {time:.9g} s",
            reason.places,
            values,
            "the equations of this mode contradict: check for switches in series or ideal "
            "sources in parallel, or give ideal elements a small resistance or conductance",
            () if cause is None else (f"last attempt: {cause.message}", *cause.notes),
        )
        if cause is None or cause.span is None:
            return found
        return AcausalError(
            [replace(d, span=cause.span, label=cause.label) for d in found.diagnostics]
        )
    return texts.error(
        "E043",
        f"the event at t = {time:.9g} s does not end: discrete variables change each other "
        "without settling",
        reason.places,
        values,
        "put pre(...) around one of them, or let it change only when a condition becomes true",
    )


def chattering(
    system: System, kernels: EventKernels, places: Ids, values: Array, time: float, count: int,
    span: float,
) -> AcausalError:  # fmt: skip
    """Return the error of relations that change again and again."""
    return EventTexts(system, kernels).error(
        "E044",
        f"a relation changes again and again at t = {time:.9g} s ({count} times in {span:.2g} s)",
        places,
        values,
        "the solution slides along the relation: the equations push back to it from both "
        "sides. Put noEvent(...) around the relation with a steep but continuous law instead "
        "of the jump, give it a hysteresis, or use a friction component, which can stick",
    )
