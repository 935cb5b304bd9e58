"""The flat model: families of variables, parameters and equations as index arrays.

Scalar variables have ids ``0 .. n-1``. A derivative is a variable of its own; ``derivative``
tells which. Scalar parameters are numbered apart, ``0 .. p-1``. Operands of an equation family
are ids of either sort, told apart by ``kinds``, so that a template never knows what role an
operand plays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Diagnostic, Span
from acausal.expressions.nodes import Expr

Ids = NDArray[np.int64]


class Operand(IntEnum):
    """What a slot of an equation family refers to."""

    VARIABLE = 0
    PARAMETER = 1


class StateSelect(IntEnum):
    """Priority as a state, in the order of the language's enumeration."""

    NEVER = 1
    AVOID = 2
    DEFAULT = 3
    PREFER = 4
    ALWAYS = 5


class RowKind(IntEnum):
    """Where a row comes from."""

    DECLARED = 0
    JUNCTION = 1
    UNCONNECTED = 2
    INITIAL = 3


@dataclass(frozen=True)
class Origin:
    """Where a run of consecutive members of a family comes from.

    Attributes:
        first: First member of the family, counted from 0.
        count: Number of members.
        kind: Sort of row.
        span: The equation in the source; None for junctions.
        text: The equation as a person would write it, in the words of its class.
        class_name: Full name of the class that declares it.
        instances: Index of the instance of that class for every member, shape ``(count,)``;
            :meth:`Names.instance_path` turns it into a path.
        group: Number of the group (class with all its instances) those indices refer to.
    """

    first: int
    count: int
    kind: RowKind
    span: Span | None
    text: str
    class_name: str
    group: int
    instances: Ids


@dataclass(frozen=True)
class EquationFamily:
    """One template and all its instances: ``residual[target[k]] += f(operands[:, k])``.

    Attributes:
        template: Residual (or one contribution to a row) over ``slot(0) .. slot(m-1)``.
        kinds: Operand sort of each slot, length ``m``.
        operands: Ids, shape ``(m, count)``.
        rows: Row that each member adds to, shape ``(count,)``. Junction rows get several.
        origins: Runs of members, in order, covering all of them.
    """

    template: Expr
    kinds: tuple[Operand, ...]
    operands: Ids
    rows: Ids
    origins: tuple[Origin, ...] = ()

    @property
    def count(self) -> int:
        """Number of members."""
        return int(self.operands.shape[1])


@dataclass(frozen=True)
class Variables:
    """Attributes of the scalar variables, each of shape ``(n,)``.

    Attributes:
        start: Start or guess value, SI.
        start_given: The start value was written by the user (not the type's default).
        fixed: The start value is an initial condition.
        nominal: Magnitude for scaling, > 0.
        minimum, maximum: Bounds.
        state_select: :class:`StateSelect` values.
    """

    start: NDArray[np.float64]
    start_given: NDArray[np.bool_]
    fixed: NDArray[np.bool_]
    nominal: NDArray[np.float64]
    minimum: NDArray[np.float64]
    maximum: NDArray[np.float64]
    state_select: NDArray[np.int8]

    @property
    def count(self) -> int:
        """Number of scalar variables."""
        return int(self.start.shape[0])


@dataclass(frozen=True)
class Experiment:
    """The ``experiment`` annotation, seconds; None where it says nothing."""

    start_time: float = 0.0
    stop_time: float | None = None
    tolerance: float | None = None
    interval: float | None = None


class Names(Protocol):
    """Paths of scalar variables, made when asked for and never before."""

    def variable(self, variable: int) -> str:
        """Return the path of a scalar variable, e.g. ``line.section[3].r.v`` or ``der(x)``."""

    def parameter(self, parameter: int) -> str:
        """Return the path of a scalar parameter."""

    def find_variables(self, pattern: str) -> list[tuple[str, int]]:
        """Return (path, id) of all variables matching ``pattern`` (``*`` and ``[*]`` allowed)."""

    def find_parameters(self, pattern: str) -> list[tuple[str, int]]:
        """Return (path, id) of all parameters matching ``pattern``."""

    def unit(self, variable: int) -> str:
        """Return the unit text of a variable, empty if it has none."""

    def parameter_unit(self, parameter: int) -> str:
        """Return the unit text of a parameter."""

    def description(self, variable: int) -> str:
        """Return the description string of a variable."""

    def declaration(self, variable: int) -> Span | None:
        """Return where the variable is declared."""

    def instance_path(self, group: int, instance: int) -> str:
        """Return the path of an instance, empty for the model itself."""

    def all_variables(self) -> Sequence[str]:
        """Return the paths of all declared variables, in id order, ``der(...)`` left out."""

    def suggestions(self, path: str) -> list[str]:
        """Return the nearest paths to a misspelt one, best first."""


@dataclass(frozen=True)
class Assertion:
    """``assert(condition, message)``: families whose template is the condition (1 or 0)."""

    family: EquationFamily
    message: str
    warning: bool


@dataclass(frozen=True)
class FlatModel:
    """One flat differential-algebraic system.

    Attributes:
        name: The model's name.
        description: Its description string.
        variables: Attributes of the scalar variables.
        derivative: Id of the time derivative of each variable, or -1, shape ``(n,)``.
        parameters: Values of the scalar parameters, SI, shape ``(p,)``.
        families: Equation families.
        n_rows: Number of rows.
        initial: Families of the initial equations, with their own row numbers.
        n_initial: Number of initial rows.
        assertions: Conditions to watch.
        names: Paths, units, descriptions.
        experiment: What the model says about its simulation.
        warnings: What was noticed and is no error.
    """

    name: str
    description: str
    variables: Variables
    derivative: Ids
    parameters: NDArray[np.float64]
    families: tuple[EquationFamily, ...]
    n_rows: int
    initial: tuple[EquationFamily, ...]
    n_initial: int
    assertions: tuple[Assertion, ...]
    names: Names
    experiment: Experiment = field(default_factory=Experiment)
    warnings: tuple[Diagnostic, ...] = ()
