"""Other parameters and start values for a compiled model, without compiling it again.

Parameters are numbers in one array, start values in another. What is computed from changed ones is
computed again, step by step in the order of the compiler; kernels, index arrays and the reduced
structure stay. Only a few values decide about the structure: structural parameters, zeros among the
others (a capacitance of zero makes no state), times of samples, nominal values and bounds that
depend on parameters. For these :class:`StructureChanges` is raised, and the model is compiled anew.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Diagnostic, fail
from acausal.elimination.attributes import merged_attributes
from acausal.expressions.evaluate import evaluate
from acausal.flattening.families import FamilyBuilder, LiteralPool
from acausal.flattening.flatten import Flattened, given_ids
from acausal.flattening.model import Variables
from acausal.flattening.names import NumberingNames
from acausal.flattening.parameters import Step, attribute_values, parameter_values
from acausal.instantiation.numbering import Numbering
from acausal.simulation.system import System

Array = NDArray[np.float64]

#: Attributes that are only read while compiling.
_STRUCTURAL = (("nominal", 1.0), ("min", -np.inf), ("max", np.inf), ("fixed", 0.0))


class StructureChanges(Exception):  # noqa: N818 - not an error, a request
    """The values decide about the structure: the model has to be compiled with them."""


class ChangedValues:
    """Makes systems with other parameters and start values out of a compiled one.

    Example:
        >>> changed = ChangedValues(flattened, system)
        >>> other = changed.system({"r.R": 200.0}, {"c.v": 1.0})
    """

    def __init__(self, flattened: Flattened, system: System) -> None:
        self._variables = flattened.model.variables
        self._system = system
        numbering = flattened.numbering
        self._names = NumberingNames(numbering)
        builder = FamilyBuilder(numbering, LiteralPool(numbering.n_parameters))
        self._steps: list[Step] = []
        ignored: list[Diagnostic] = []
        self._given = given_ids(self._names, flattened.given)
        own = parameter_values(numbering, builder, self._names, self._given, ignored, self._steps)
        self._starts: list[Step] = []
        self._start, _ = attribute_values(numbering, builder, own, "start", 0.0, steps=self._starts)
        self._others = self._structural_steps(numbering, builder, own)
        self._n = len(own)
        # Literals of the steps stand behind the declared parameters, in an order of their own.
        self._every = np.concatenate([own, *builder.literals.values])

    def _structural_steps(
        self, numbering: Numbering, builder: FamilyBuilder, own: Array
    ) -> list[Step]:
        steps: list[Step] = []
        for name, default in _STRUCTURAL:
            attribute_values(numbering, builder, own, name, default, steps=steps)
        return steps

    @property
    def of(self) -> System:
        """The system that was compiled."""
        return self._system

    def system(
        self, parameters: Mapping[str, float], start: Mapping[str, float] | None = None
    ) -> System:
        """Return the system with other values.

        Args:
            parameters: Values by path or pattern, SI units.
            start: Fixed start values of variables by path, SI units.

        Raises:
            AcausalError: ``N119`` and ``N901`` for unknown names, ``I012`` for a start value of
                a variable that is computed from others.
            StructureChanges: If the values decide about the structure.
        """
        if not all(self._names.find_parameters(path) for path in parameters):
            raise StructureChanges  # a structural parameter, or none: the compiler knows
        values = self._values(given_ids(self._names, dict(parameters)))
        changed = np.flatnonzero(values[: self._n] != self._every[: self._n])
        system = self._system
        if len(changed):
            self._check_structure(values, changed)
            every = system.parameters.copy()
            every[: self._n] = values[: self._n]
            system = replace(system, parameters=every)
            if self._starts:
                system = self._restarted(system, values)
        return self._started(system, start) if start else system

    def _values(self, given: Mapping[int, float]) -> Array:
        values = self._every.copy()
        if not given:
            return values
        ids = np.array(list(given), np.int64)
        values[ids] = list(given.values())
        held = np.zeros(len(values), np.bool_)
        held[ids] = True
        for step in self._steps:
            free = ~held[step.targets]
            if not len(step.operands) or not free.any():
                continue
            result = np.broadcast_to(_evaluated(step, values), step.targets.shape)
            values[step.targets[free]] = result[free]
        bad = np.flatnonzero(np.isnan(values[: self._n]) & ~np.isnan(self._every[: self._n]))
        if len(bad):
            name = self._names.parameter(int(bad[0]))
            fail("I010", f"the value of {name} is not a number",
                 self._names.parameter_declaration(int(bad[0])),
                 help="check for 0/0 or a root of a negative number")  # fmt: skip
        return values

    def _check_structure(self, values: Array, changed: NDArray[np.int64]) -> None:
        zeros = (values[changed] == 0.0) != (self._every[changed] == 0.0)
        hybrid = self._system.hybrid
        timed = hybrid is not None and np.isin(changed, hybrid.timing).any()
        if zeros.any() or timed:
            raise StructureChanges
        for step in self._others:
            if not np.array_equal(_evaluated(step, values), _evaluated(step, self._every)):
                raise StructureChanges

    def _restarted(self, system: System, values: Array) -> System:
        """Return the system with start values that depend on parameters."""
        start = self._start.copy()
        for step in self._starts:
            start[step.targets] = _evaluated(step, values)
        moved = np.flatnonzero(start != self._start)
        if not len(moved):
            return system
        n = len(start)
        flat = replace(self._variables, start=start)
        representative, sign = system.representative[:n], system.sign[:n]
        merged = merged_attributes(flat, representative, sign, self._names, None)
        every = system.variables.start.copy()
        every[moved] = start[moved]
        heads = representative[moved]
        every[heads] = merged.start[heads]
        system = replace(system, variables=replace(system.variables, start=every))
        return self._held(system, moved, start)

    def _held(self, system: System, moved: NDArray[np.int64], start: Array) -> System:
        """Return the system with start values of discrete variables."""
        hybrid = system.hybrid
        if hybrid is None:
            return system
        place = hybrid.place[moved]
        discrete = place >= 0
        if not discrete.any():
            return system
        held = hybrid.start.copy()
        held[place[discrete]] = held[hybrid.n_discrete + place[discrete]] = start[moved[discrete]]
        parameters = system.parameters.copy()
        parameters[hybrid.first :] = held
        return replace(system, parameters=parameters, hybrid=replace(hybrid, start=held))

    def _started(self, system: System, start: Mapping[str, float]) -> System:
        """Return the system with fixed start values of variables."""
        variables = system.variables
        value, given = variables.start.copy(), variables.start_given.copy()
        fixed = variables.fixed.copy()
        for path, number in start.items():
            found = self._names.find_variables(path)
            if not found:
                close = self._names.suggestions(path)
                fail("N901", f"there is no variable {path}",
                     notes=[f"did you mean {' or '.join(close)}?"] if close else [],
                     help="acausal inspect shows the variables of a model")  # fmt: skip
            for name, variable in found:
                if system.hybrid is not None and system.hybrid.place[variable] >= 0:
                    moved = np.array([variable])
                    at = np.full(variable + 1, float(number))
                    system = self._held(system, moved, at)
                    continue
                head = int(system.representative[variable])
                if system.sign[variable] == 0 or not system.active[head]:
                    self._not_a_start(name, variable)
                value[head] = float(number) * float(system.sign[variable])
                given[head] = fixed[head] = True
        merged: Variables = replace(variables, start=value, start_given=given, fixed=fixed)
        return replace(system, variables=merged)

    def _not_a_start(self, name: str, variable: int) -> None:
        fail("I012", f"{name} is computed from other variables and cannot start anywhere",
             self._names.declaration(variable),
             help="give start values to states; acausal inspect --stage structure shows "
             "them")  # fmt: skip


def _evaluated(step: Step, values: Array) -> Array:
    operands: dict[object, Array] = {k: values[row] for k, row in enumerate(step.operands)}
    return np.asarray(evaluate(step.template, operands))
