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
    """What a slot of an equation family refers to.

    The last three stand in the flat model as it is collected; :mod:`acausal.events` turns them,
    and the discrete variables, into held values, which are parameters that change at events.
    """

    VARIABLE = 0
    PARAMETER = 1
    PRE = 2  #: a variable's value before the event, by the id of the variable
    SIGNAL = 3  #: see :class:`Signals`
    PRE_SIGNAL = 4


class Base(IntEnum):
    """Type of a variable."""

    REAL = 0
    INTEGER = 1
    BOOLEAN = 2
    ENUMERATION = 3


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
class Termination:
    """``terminate(message)``: families whose template tells when (1 or 0)."""

    family: EquationFamily
    message: str


@dataclass(frozen=True)
class SignalFamily:
    """Signals of one kind that share their templates.

    Attributes:
        kind: ``condition``, ``sample`` or ``delay``.
        operands: A family for each operand of the declaration, member by member the same
            signals; ``rows`` holds the signals' ids.
    """

    kind: str
    operands: tuple[EquationFamily, ...]


@dataclass(frozen=True)
class ReinitFamily:
    """Reinits of the same template as they are collected, member by member.

    Attributes:
        value: The new value; ``rows`` holds the ids of the variables.
        fires: The condition, 1 or 0; ``rows`` as in ``value``.
        impulse: Id of the through variable that carries the impulse, or -1, shape ``(count,)``.
    """

    value: EquationFamily
    fires: EquationFamily
    impulse: Ids


@dataclass(frozen=True)
class Discrete:
    """The discrete part of a model as it is collected, before :mod:`acausal.events`.

    Attributes:
        base: :class:`Base` of each variable, shape ``(n,)``.
        discrete: Variables that only change at events, shape ``(n,)``.
        n_signals: Number of signals; 0 is true at the first instant, 1 after the last one.
        signals: What makes the others.
        assignments: ``rows`` holds the target variables, the template is the value.
        equalities: ``x - y = 0`` between discrete variables, one of which the other defines.
        initial: Assignments of the first instant; ``rows`` holds variables.
        initial_pre: The same for values before it.
        reinits, terminations: What else happens at events.
    """

    base: NDArray[np.int8]
    discrete: NDArray[np.bool_]
    n_signals: int
    signals: tuple[SignalFamily, ...]
    assignments: tuple[EquationFamily, ...]
    equalities: tuple[EquationFamily, ...]
    initial: tuple[EquationFamily, ...]
    initial_pre: tuple[EquationFamily, ...]
    reinits: tuple[ReinitFamily, ...]
    terminations: tuple[Termination, ...]


@dataclass(frozen=True)
class RelationFamily:
    """Relations that are frozen between events.

    Attributes:
        family: The difference of the two sides ``g``; ``rows`` holds held positions.
        kind: ``gt`` (held is 1 where ``g > 0``), ``ge`` (``g >= 0``) or ``floor`` (held is
            the largest whole number that is not above ``g``).
    """

    family: EquationFamily
    kind: str


@dataclass(frozen=True)
class Reinits:
    """All reinits ``r`` of a model, in the order in which they are written.

    The elimination keeps the variables that are named here and says who stands for them: reinit
    ``k`` gives the variable ``states[k]`` the value ``signs[k] * values[k]``.

    Attributes:
        states: Id of the variable that each acts on, shape ``(r,)``.
        signs: 1 or -1; 0 if the variable is always zero, shape ``(r,)``.
        impulses: Id of the through variable that carries the impulse, or -1, shape ``(r,)``.
        impulse_signs: The named through variable is this times that of ``impulses``: 1, -1, or 0
            if it is always zero, shape ``(r,)``.
        values: Families of the new value, ``rows`` holds numbers of reinits; each has one member.
        fires: Families of the condition, 1 or 0, likewise.
        wanted: The variables as the model names them, for messages, shape ``(r,)``.
    """

    states: Ids
    signs: NDArray[np.int8]
    impulses: Ids
    impulse_signs: NDArray[np.int8]
    values: tuple[EquationFamily, ...]
    fires: tuple[EquationFamily, ...]
    wanted: Ids

    @property
    def count(self) -> int:
        """Number of reinits."""
        return int(self.states.shape[0])


@dataclass(frozen=True)
class Rests:
    """Reinits that may end in rest: while ``at_rest`` holds 1, the derivative is zero.

    Attributes:
        reinits: Numbers of the reinits, shape ``(k,)``.
        accelerations: Ids of the derivatives of their variables, shape ``(k,)``.
        at_rest: Held positions of the flags, shape ``(k,)``.
        sign: Held positions of the sign with which the support acts, shape ``(k,)``.
        supported: Held positions of the relations ``support > 0``, shape ``(k,)``.
    """

    reinits: Ids
    accelerations: Ids
    at_rest: Ids
    sign: Ids
    supported: Ids


@dataclass(frozen=True)
class Hybrid:
    """What happens at events. Held values are the last parameters: ``first + position``.

    Layout of the held values: the values of the ``n_discrete`` discrete variables and
    conditions, their values before the event, then everything else in any order.

    Every family here has operands of the sorts VARIABLE (after the elimination: active
    variables only) and PARAMETER.

    Attributes:
        first: Parameter id of held value 0.
        start: Held values to begin with, shape ``(h,)``; values and pre values of discrete
            variables are their start values, everything else is 0.
        n_discrete: Number of discrete variables and conditions; the value before the event of
            the one at ``k`` is at ``n_discrete + k``.
        place: Held position of the value of each variable, or -1, shape ``(n,)``; variables that
            are equal share one. In the system: of all ids, shape ``(N,)``.
        conditions: Held positions below ``n_discrete`` that are conditions of whens.
        relations: Relations on time and continuous variables; one inside another comes first.
        assignments: In order of evaluation; ``rows`` holds held positions below ``n_discrete``,
            each of them once.
        initial: All assignments of the first instant, in order of evaluation: initial equations
            instead of the others with the same targets. The same tuple as ``assignments`` in a
            model without initial equations of discrete variables.
        initial_pre: Values before the first instant that initial equations ``pre(b) = ...``
            give, instead of those in ``start``; ``rows`` holds held positions from
            ``n_discrete``.
        initial_flag, terminal_flag: Held positions.
        sample_places: Held positions of the samples, shape ``(s,)``.
        sample_start: First time of each, seconds, shape ``(s,)``.
        sample_interval: Seconds between, shape ``(s,)``.
        limits: Values of continuous variables whose value before the event is asked for;
            ``rows`` holds the held positions that receive it.
        delay_places: Held positions of delayed values, shape ``(d,)``.
        delays: Families of the delayed expression, ``rows`` index into ``delay_places``.
        delay_times: Families of the delay, likewise.
        delay_maxima: Largest delay of each, seconds, shape ``(d,)``.
        reinits: New values of continuous variables.
        terminations: Conditions that end the simulation.
        relevant: Held values that the continuous equations read, shape ``(h,)``.
        rests: Where bodies can come to rest; see :mod:`acausal.elimination.rests`.
        timing: Parameters that the times of samples and the largest delays depend on.
    """

    first: int
    start: NDArray[np.float64]
    n_discrete: int
    place: Ids
    conditions: Ids
    relations: tuple[RelationFamily, ...]
    assignments: tuple[EquationFamily, ...]
    initial: tuple[EquationFamily, ...]
    initial_pre: tuple[EquationFamily, ...]
    initial_flag: int
    terminal_flag: int
    sample_places: Ids
    sample_start: NDArray[np.float64]
    sample_interval: NDArray[np.float64]
    limits: tuple[EquationFamily, ...]
    delay_places: Ids
    delays: tuple[EquationFamily, ...]
    delay_times: tuple[EquationFamily, ...]
    delay_maxima: NDArray[np.float64]
    reinits: Reinits
    terminations: tuple[Termination, ...]
    relevant: NDArray[np.bool_]
    rests: Rests | None = None
    timing: Ids = field(default_factory=lambda: np.zeros(0, np.int64))

    @property
    def count(self) -> int:
        """Number of held values."""
        return int(self.start.shape[0])


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
        discrete: The discrete part as collected; None once it is :attr:`hybrid`.
        hybrid: What happens at events; None where nothing does.
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
    discrete: Discrete | None = None
    hybrid: Hybrid | None = None
