"""Class templates: what the compiler knows about a class, once for all its instances."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import prod
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import AcausalError, Span
from acausal.expressions.nodes import Expr

if TYPE_CHECKING:
    from acausal.instantiation.values import Value
    from acausal.modeling.classes import ClassDef


@dataclass(frozen=True, slots=True)
class Step:
    """One step down a path: a component and its subscripts (from 1), one for each dimension."""

    name: str
    index: tuple[Expr, ...] = ()


@dataclass(frozen=True, slots=True)
class Ref:
    """The payload of a slot inside a class: a scalar variable or parameter seen from an instance.

    Attributes:
        path: Components to go down to, from the instance.
        name: The variable or parameter there; empty for a primitive connector.
        index: Its subscripts, from 1, as expressions over loop indices.
        parameter: True for a parameter.
        order: How often it is differentiated with respect to time.
        outer: Name of an ``inner`` component that the path starts from instead.
        pre: The value before the present event instead of the value now.
    """

    path: tuple[Step, ...]
    name: str
    index: tuple[Expr, ...] = ()
    parameter: bool = False
    order: int = 0
    outer: str = ""
    pre: bool = False


@dataclass(frozen=True, slots=True)
class Signal:
    """The payload of a slot that stands for a value which the event handling makes.

    It has one element for each instance and each pass of the loops around its declaration. A use
    inside narrower loops means the element with the same values of the loop indices.

    Attributes:
        number: Index into ``Template.signals``, or :data:`INITIAL` or :data:`TERMINAL`.
        pre: The value before the present event instead of the value now.
    """

    number: int
    pre: bool = False


#: Numbers of the signals that are true during the first and after the last instant.
INITIAL, TERMINAL = -1, -2


@dataclass(frozen=True, slots=True)
class Unset:
    """The payload of a slot that stands for a variable which an algorithm has not set so far.

    It is there only while the algorithm is executed symbolically.
    """

    ref: Ref


@dataclass(frozen=True, slots=True)
class LoopIndex:
    """The payload of a slot that stands for a loop index; its values are in the domain."""

    name: str


@dataclass(frozen=True, slots=True)
class TableEntry:
    """The payload of a slot that stands for an entry of a constant array.

    Attributes:
        data: The array's bytes (float64, row-major) and ``shape`` its shape.
        index: Subscripts from 1 as expressions over loop indices.
    """

    data: bytes
    shape: tuple[int, ...]
    index: tuple[Expr, ...]

    def array(self) -> NDArray[np.float64]:
        """Return the constant array."""
        return np.frombuffer(self.data, np.float64).reshape(self.shape)


_NO_LOOPS: NDArray[np.float64] = np.zeros((0, 1))
_NO_LOOPS.flags.writeable = False


@dataclass(frozen=True)
class Domain:
    """The values of the loop indices of an equation, a row for each pass of the loops.

    Attributes:
        names: The loop indices.
        values: Their values, shape ``(len(names), length)``.
        length: Number of passes; 1 without loops.
    """

    names: tuple[str, ...] = ()
    values: NDArray[np.float64] = field(default_factory=lambda: _NO_LOOPS)

    @property
    def length(self) -> int:
        """Number of passes."""
        return int(self.values.shape[1])

    def product(self, name: str, values: NDArray[np.float64]) -> Domain:
        """Return the domain with one more, innermost loop."""
        repeated = np.repeat(self.values, len(values), axis=1)
        tiled = np.tile(values, self.length)
        return Domain((*self.names, name), np.vstack([repeated, tiled[None, :]]))

    def where(self, mask: NDArray[np.bool_]) -> Domain:
        """Return the passes for which ``mask`` is true."""
        return Domain(self.names, self.values[:, mask])


@dataclass(frozen=True)
class VariableDecl:
    """A real variable (or parameter) of a class.

    Attributes:
        name: Its name; empty in a primitive connector.
        shape: Array dimensions.
        unit: Unit text, empty if none.
        description: Description string.
        through: True for a through variable of a connector.
        causality: ``input``, ``output`` or empty.
        span: The declaration.
        public: Not declared ``protected``.
        type_name: Name of the declared type.
        base: ``Real``, ``Integer``, ``Boolean`` or ``enumeration``.
        literals: Names of an enumeration's values, the first of which is number 1.
        discrete: Declared ``discrete``, or of a base that only changes at events.
    """

    name: str
    shape: tuple[int, ...]
    unit: str
    description: str
    through: bool
    causality: str
    span: Span
    public: bool
    type_name: str
    base: str = "Real"
    literals: tuple[str, ...] = ()
    discrete: bool = False

    @property
    def size(self) -> int:
        """Number of scalars in one instance."""
        return prod(self.shape)


@dataclass(frozen=True)
class Child:
    """A component of a class that is itself composite.

    Attributes:
        name: Its name.
        shape: Array dimensions.
        template: Its class template.
        span: The declaration.
        inner: Declared ``inner``.
        description: Description string.
        public: Not declared ``protected``.
    """

    name: str
    shape: tuple[int, ...]
    template: Template
    span: Span
    inner: bool
    description: str
    public: bool

    @property
    def size(self) -> int:
        """Number of components in one instance of the class."""
        return prod(self.shape)


@dataclass(frozen=True)
class EquationDecl:
    """``residual = 0`` for every pass of the domain and every instance.

    Attributes:
        residual: Left minus right side over slots with :class:`Ref`, :class:`LoopIndex` or
            :class:`TableEntry` payload.
        domain: Loops around it.
        span: The equation.
        text: The equation as a person would write it.
        owner: Name of the class it is written in.
    """

    residual: Expr
    domain: Domain
    span: Span
    text: str
    owner: str


@dataclass(frozen=True)
class BindingDecl:
    """A value for a parameter, or for an attribute of a variable, set at this level.

    Attributes:
        target: What is set.
        attribute: ``value``, ``start``, ``fixed``, ``min``, ``max``, ``nominal`` or
            ``stateSelect``.
        value: Expression over parameters.
        domain: Loops that run over the elements of an array target.
        span: Where it is written.
        weak: Part of a type, not of a declaration: says nothing about the user's intentions.
    """

    target: Ref
    attribute: str
    value: Expr
    domain: Domain
    span: Span
    weak: bool = False


@dataclass(frozen=True)
class CutRef:
    """A cut named in a connect equation: a path whose last step is a connector.

    ``inner_face`` is true when the cut belongs to the class that contains the connect equation,
    which then sees it from inside.
    """

    path: tuple[Step, ...]
    outer: str
    inner_face: bool


@dataclass(frozen=True)
class ConnectDecl:
    """``connect(a, b, ...)`` for every pass of the domain and every instance."""

    cuts: tuple[CutRef, ...]
    domain: Domain
    span: Span


@dataclass(frozen=True)
class NodeRef:
    """An overdetermined record in a cut, such as the orientation of a frame."""

    cut: CutRef
    record: str

    @property
    def text(self) -> str:
        """As a person would write it, with constant subscripts."""
        names = [self.cut.outer] if self.cut.outer else []
        for step in self.cut.path:
            subscripts = ",".join(f"{e.value:g}" if e.op == "const" else "…" for e in step.index)
            names.append(f"{step.name}[{subscripts}]" if subscripts else step.name)
        return ".".join([*names, self.record])


@dataclass(frozen=True)
class Ask:
    """``Connections.isRoot`` or ``Connections.rooted`` of a node, as a class asks for it."""

    operator: str
    node: NodeRef

    @property
    def text(self) -> str:
        """The call; also the name under which the answer comes back."""
        return f"Connections.{self.operator}({self.node.text})"


@dataclass(frozen=True)
class BranchDecl:
    """``Connections.branch(tail, head)`` for every pass of the domain and every instance."""

    tail: NodeRef
    head: NodeRef
    domain: Domain
    span: Span


@dataclass(frozen=True)
class RootDecl:
    """``Connections.root(node)``, or ``potentialRoot`` if there is a priority."""

    node: NodeRef
    priority: int | None
    domain: Domain
    span: Span


@dataclass(frozen=True)
class AssertDecl:
    """``assert(condition, message)`` for every pass of the domain and every instance."""

    condition: Expr
    domain: Domain
    message: str
    warning: bool
    span: Span
    text: str


@dataclass(frozen=True)
class SignalDecl:
    """What stands behind a :class:`Signal`, for every pass of the domain and every instance.

    Attributes:
        kind: ``condition`` (of a when; evaluated like a Boolean variable), ``sample`` or
            ``delay``.
        operands: The condition; start and interval over parameters; or the delayed expression,
            the delay and the largest delay.
        domain: Loops around it.
        span: Where it is written.
        text: As a person would write it.
    """

    kind: str
    operands: tuple[Expr, ...]
    domain: Domain
    span: Span
    text: str


@dataclass(frozen=True)
class DiscreteDecl:
    """``target := value`` at events, for every pass of the domain and every instance.

    A when is no part of it: its equations have the value
    ``if fires then ... else pre(target)``, where ``fires`` is ``c and not pre(c)`` with the
    signal ``c`` of the condition.

    Attributes:
        target: Slot of a variable (:class:`Ref`).
        value: What it becomes.
        domain, span, text, owner: As in :class:`EquationDecl`.
        held: It stands in a when, so that the target is discrete, whatever its type.
        symmetric: Both sides are single variables, either may be the target.
    """

    target: Expr
    value: Expr
    domain: Domain
    span: Span
    text: str
    owner: str
    held: bool = False
    symmetric: bool = False


@dataclass(frozen=True)
class ReinitDecl:
    """``reinit(state, value)`` where ``fires`` becomes true; ``impulse``: see the manual.

    Attributes:
        state: Slot of a Real variable.
        value: Its new value.
        fires: True in the instant in which it acts.
        impulse: Slot of the through variable that carries the impulse, or None.
        domain, span, text: As in :class:`EquationDecl`.
    """

    state: Expr
    value: Expr
    fires: Expr
    impulse: Expr | None
    domain: Domain
    span: Span
    text: str


@dataclass(frozen=True)
class TerminateDecl:
    """``terminate(message)`` where ``fires`` becomes true."""

    fires: Expr
    message: str
    domain: Domain
    span: Span
    text: str


@dataclass(eq=False)
class Template:
    """A class with fixed structural parameters; built by ``elaborate``, then left alone.

    Attributes:
        number: Number in order of creation, owners of components after their components.
        definition: The class.
        variables, parameters: Real variables and parameters by name, in declaration order.
        structural: Constants and structural parameters by name.
        children: Components by name, in declaration order.
        absent: Conditional components that are switched off.
        unfit_defaults: Parameters whose default has another size than they, with the error to
            raise if an instance needs it.
        outers: Names of ``outer`` components that instances use.
        outer_values: Names of ``outer`` variables and parameters, with the class that declares
            them ``inner``.
        inner_values: Names of ``inner`` variables and parameters.
        bound: Paths of variables whose value is set where the class is used.
        enumerations: Classes of the enumerations among the variables, by variable.
        discrete: Equations of variables that change at events only.
        initial_discrete: The same for the first instant: ``pre(b) = ...`` has a target with
            ``pre``, ``b = ...`` one without.
        signals: Conditions of whens, samples, delays.
        reinits, terminates: What else happens at events.
        branches, roots: How overdetermined records of cuts hang together.
        alike: Numbers of the templates that this cut has been found to fit.
        asks, answers: What the class wants to know about that, and what it was told.
    """

    number: int
    definition: ClassDef
    variables: dict[str, VariableDecl] = field(default_factory=dict)
    parameters: dict[str, VariableDecl] = field(default_factory=dict)
    structural: dict[str, Value] = field(default_factory=dict)
    children: dict[str, Child] = field(default_factory=dict)
    absent: set[str] = field(default_factory=set)
    outers: dict[str, Template] = field(default_factory=dict)
    outer_values: dict[str, Template] = field(default_factory=dict)
    inner_values: set[str] = field(default_factory=set)
    bound: frozenset[tuple[str, ...]] = frozenset()
    enumerations: dict[str, ClassDef] = field(default_factory=dict)
    equations: list[EquationDecl] = field(default_factory=list)
    initial_equations: list[EquationDecl] = field(default_factory=list)
    bindings: list[BindingDecl] = field(default_factory=list)
    connects: list[ConnectDecl] = field(default_factory=list)
    asserts: list[AssertDecl] = field(default_factory=list)
    discrete: list[DiscreteDecl] = field(default_factory=list)
    initial_discrete: list[DiscreteDecl] = field(default_factory=list)
    signals: list[SignalDecl] = field(default_factory=list)
    reinits: list[ReinitDecl] = field(default_factory=list)
    terminates: list[TerminateDecl] = field(default_factory=list)
    branches: list[BranchDecl] = field(default_factory=list)
    roots: list[RootDecl] = field(default_factory=list)
    asks: dict[str, Ask] = field(default_factory=dict)
    answers: dict[str, bool] = field(default_factory=dict)
    alike: set[int] = field(default_factory=set)
    primitive_connector: bool = False
    unfit_defaults: dict[str, AcausalError] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Full name of the class."""
        return self.definition.full_name

    @property
    def span(self) -> Span:
        """Where the class is declared."""
        return self.definition.span

    @property
    def is_connector(self) -> bool:
        """True for a cut."""
        return self.primitive_connector or self.definition.kind == "connector"

    def __getstate__(self) -> dict[str, object]:
        """Return what paths are made of; the rest has done its work when a model is stored."""
        kept = ("number", "variables", "parameters", "children", "primitive_connector")
        return {name: getattr(self, name) for name in kept}
