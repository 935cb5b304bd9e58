"""The ``experiment`` annotation."""

from __future__ import annotations

from acausal.diagnostics import fail
from acausal.flattening.model import Experiment
from acausal.instantiation.environment import ClassEnvironment
from acausal.instantiation.expressions import constant_number
from acausal.modeling.classes import ClassDef
from acausal.syntax import tree

_FIELDS = {
    "StartTime": "start_time",
    "StopTime": "stop_time",
    "Tolerance": "tolerance",
    "Interval": "interval",
}


def experiment_of(definition: ClassDef) -> Experiment:
    """Return what a class, or the nearest base that has it, says about its simulation.

    Raises:
        AcausalError: ``T103`` for a value that is no number, ``T136`` for an impossible one.
    """
    for ancestor in definition.ancestors():
        annotation = ancestor.tree.annotation
        for argument in annotation.arguments if annotation is not None else ():
            if argument.name == ("experiment",):
                return _read(argument, ancestor)
    return Experiment()


def _read(argument: tree.Modifier, owner: ClassDef) -> Experiment:
    values: dict[str, float] = {}
    env = ClassEnvironment(None, owner)
    for field in argument.nested:
        if len(field.name) == 1 and field.name[0] in _FIELDS and field.value is not None:
            name = field.name[0]
            values[_FIELDS[name]] = constant_number(field.value, env, name)
            if name in ("Tolerance", "Interval") and values[_FIELDS[name]] <= 0:
                fail("T136", f"{name} must be above 0", field.span, help="e.g. Tolerance = 1e-6")
    result = Experiment(**values)
    if result.stop_time is not None and result.stop_time <= result.start_time:
        fail("T136", "StopTime must be after StartTime", argument.span,
             help="set StopTime in seconds")  # fmt: skip
    return result
