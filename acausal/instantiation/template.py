"""Class templates: what the compiler knows about a class, once for all its instances."""

from __future__ import annotations

from dataclasses import dataclass, field
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
    """

    path: tuple[Step, ...]
    name: str
    index: tuple[Expr, ...] = ()
    parameter: bool = False
    order: int = 0
    outer: str = ""


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


@dataclass(frozen=True)
class Domain:
    """The values of the loop indices of an equation, a row for each pass of the loops.

    Attributes:
        names: The loop indices.
        values: Their values, shape ``(len(names), length)``.
        length: Number of passes; 1 without loops.
    """

    names: tuple[str, ...] = ()
    values: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 1)))

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

    @property
    def size(self) -> int:
        """Number of scalars in one instance."""
        return int(np.prod(self.shape, dtype=np.int64))


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
        return int(np.prod(self.shape, dtype=np.int64))


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
class AssertDecl:
    """``assert(condition, message)`` for every pass of the domain and every instance."""

    condition: Expr
    domain: Domain
    message: str
    warning: bool
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
    equations: list[EquationDecl] = field(default_factory=list)
    initial_equations: list[EquationDecl] = field(default_factory=list)
    bindings: list[BindingDecl] = field(default_factory=list)
    connects: list[ConnectDecl] = field(default_factory=list)
    asserts: list[AssertDecl] = field(default_factory=list)
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
