"""Assertions of the model, checked at the stored points."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Diagnostic, Severity
from acausal.expressions.evaluate import evaluate
from acausal.flattening.model import Assertion, Ids, Operand
from acausal.simulation.system import System
from acausal.simulation.trajectories import Segment

Array = NDArray[np.float64]

#: More numbers than this are not looked at together.
_LARGEST = 20_000_000


def violations(system: System, segments: list[Segment], warned: set[int]) -> list[Diagnostic]:
    """Return a diagnostic for every assertion that does not hold somewhere, first time given.

    Args:
        system: The model.
        segments: Stored points; those that keep only chosen variables were looked at before.
        warned: Numbers of assertions that were reported already; extended.
    """
    found: list[Diagnostic] = []
    for number, assertion in enumerate(system.assertions):
        for segment in segments:
            if number in warned or segment.chosen is not None:
                continue
            diagnostic = _violation(system, assertion, segment)
            if diagnostic is not None:
                warned.add(number)
                found.append(diagnostic)
    return found


def _parameters(system: System, segment: Segment, ids: Ids) -> Array:
    """Return parameters, held values among them, shape ``(nt or 1, len(ids))``."""
    values: Array = system.parameters[ids][None, :]
    if segment.held is None or system.hybrid is None:
        return values
    held = ids >= system.hybrid.first
    if held.any():
        values = np.repeat(values, len(segment.times), axis=0)
        places = ids[held] - system.hybrid.first
        values[:, held] = segment.held.values[:, places][segment.held.which]
    return values


def _violation(system: System, assertion: Assertion, segment: Segment) -> Diagnostic | None:
    family = assertion.family
    if family.count * len(segment.times) * max(1, len(family.kinds)) > _LARGEST:
        return None
    values: dict[int, Array] = {}
    for k, kind in enumerate(family.kinds):
        ids = family.operands[k]
        if kind == Operand.VARIABLE:
            values[k] = segment.observer.values(
                ids.tolist(), segment.times, segment.y, segment.yp, segment.held
            )
        else:
            values[k] = _parameters(system, segment, ids)

    def operand(key: Hashable) -> Array:
        assert isinstance(key, int)
        return values[key]

    shape = (len(segment.times), family.count)
    holds = np.broadcast_to(evaluate(family.template, operand, segment.times[:, None]), shape)
    # What cannot be evaluated is reported by the integrator, not here.
    broken = holds == 0.0
    if not broken.any():
        return None
    when = int(broken.any(axis=1).argmax())
    member = int(broken[when].argmax())
    shown = [
        f"{system.names.variable(int(family.operands[k, member]))} = {v[when, member]:.6g}"
        for k, v in values.items()
        if family.kinds[k] == Operand.VARIABLE
    ]
    return violation_at(system, assertion, member, float(segment.times[when]), shown)


def violation_at(
    system: System, assertion: Assertion, member: int, time: float, shown: Sequence[str] = ()
) -> Diagnostic:
    """Return the diagnostic of an assertion that does not hold.

    Args:
        system: The model.
        assertion: What should hold.
        member: For which member of its family.
        time: When, seconds.
        shown: Values of the variables involved, as texts.
    """
    origin = next(o for o in assertion.family.origins if o.first <= member < o.first + o.count)
    path = system.names.instance_path(origin.group, int(origin.instances[member - origin.first]))
    return Diagnostic(
        "R021" if assertion.warning else "R020",
        f"{assertion.message} (at t = {time:.6g} s" + (f" in {path})" if path else ")"),
        origin.span,
        f"{origin.text} does not hold",
        notes=(", ".join(shown[:6]),) if shown else (),
        help="check the parameters, or the limits in which the component is valid",
        severity=Severity.WARNING if assertion.warning else Severity.ERROR,
    )
