"""The syntax tree: frozen records, a source span on every node.

Nothing here has meaning yet: names are not looked up, units are still text. The parser makes
these nodes, the Python front end makes the same ones, and the formatter prints them back.
"""

from __future__ import annotations

from dataclasses import dataclass

from acausal.diagnostics.span import Span


@dataclass(frozen=True, slots=True)
class Node:
    """Base of all nodes.

    Attributes:
        span: Where the node stands in the source.
    """

    span: Span

    def __deepcopy__(self, memo: object) -> Node:
        # Nodes never change.
        return self


# --- expressions -------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Expression(Node):
    """Base of all expressions."""


@dataclass(frozen=True, slots=True)
class NumberLiteral(Expression):
    """A number, e.g. ``10``, ``1e-3`` or ``10[kOhm]``; ``unit`` is the text in brackets.

    ``integer`` tells whether it was written without point and exponent.
    """

    value: float
    integer: bool = False
    unit: str | None = None


@dataclass(frozen=True, slots=True)
class StringLiteral(Expression):
    """A string, escapes resolved."""

    value: str


@dataclass(frozen=True, slots=True)
class BooleanLiteral(Expression):
    """``true`` or ``false``."""

    value: bool


@dataclass(frozen=True, slots=True)
class NamePart(Node):
    """One part of a dotted name, with its subscripts."""

    name: str
    subscripts: tuple[Expression, ...] = ()


@dataclass(frozen=True, slots=True)
class Reference(Expression):
    """A component reference or class name: ``a.b[1].c``; ``absolute`` for a leading dot."""

    parts: tuple[NamePart, ...]
    absolute: bool = False

    def __str__(self) -> str:
        return "." * self.absolute + ".".join(
            p.name + "[…]" * bool(p.subscripts) for p in self.parts
        )


@dataclass(frozen=True, slots=True)
class Unary(Expression):
    """``-x``, ``+x``, ``not x``, and elementwise ``.-``, ``.+``; ``operator`` as written."""

    operator: str
    operand: Expression


@dataclass(frozen=True, slots=True)
class Binary(Expression):
    """``+ - * / ^``, ``.+ .- .* ./ .^``, ``< <= > >= == <>``, ``and``, ``or``."""

    operator: str
    left: Expression
    right: Expression


@dataclass(frozen=True, slots=True)
class IfExpression(Expression):
    """``if c1 then e1 elseif c2 then e2 else e3``."""

    branches: tuple[tuple[Expression, Expression], ...]
    otherwise: Expression


@dataclass(frozen=True, slots=True)
class ForIndex(Node):
    """``i in range``; ``range`` is None where the range is to be deduced."""

    name: str
    range: Expression | None


@dataclass(frozen=True, slots=True)
class NamedArgument(Node):
    """``name = value`` in a function call."""

    name: str
    value: Expression


@dataclass(frozen=True, slots=True)
class Call(Expression):
    """A function call, also ``der(x)``, ``sum(e for i in r)`` (then ``indices`` is not empty)."""

    function: Reference
    arguments: tuple[Expression, ...] = ()
    named: tuple[NamedArgument, ...] = ()
    indices: tuple[ForIndex, ...] = ()


@dataclass(frozen=True, slots=True)
class RangeExpression(Expression):
    """``start:stop`` or ``start:step:stop``."""

    start: Expression
    step: Expression | None
    stop: Expression


@dataclass(frozen=True, slots=True)
class ArrayLiteral(Expression):
    """``{a, b, c}``."""

    elements: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class NumberArray(Expression):
    """``{{1.0, 2.0}, {3.0, 4.0}}`` as a block of numbers; Python makes it, the parser does not.

    Attributes:
        data: The numbers, doubles in row-major order.
        shape: The array's dimensions.
        integer: Whether they are whole numbers by type.
        unit: Unit of each number.
    """

    data: bytes
    shape: tuple[int, ...]
    integer: bool = False
    unit: str | None = None


@dataclass(frozen=True, slots=True)
class ArrayComprehension(Expression):
    """``{e for i in r}``."""

    element: Expression
    indices: tuple[ForIndex, ...]


@dataclass(frozen=True, slots=True)
class MatrixLiteral(Expression):
    """``[a, b; c, d]``: rows of expressions, concatenated."""

    rows: tuple[tuple[Expression, ...], ...]


@dataclass(frozen=True, slots=True)
class Colon(Expression):
    """``:`` as a subscript, or as an array dimension to be deduced."""


@dataclass(frozen=True, slots=True)
class End(Expression):
    """``end`` inside a subscript."""


@dataclass(frozen=True, slots=True)
class TupleExpression(Expression):
    """``(a, b)``: the left side of ``(a, b) = f(x)``; an omitted place is None."""

    elements: tuple[Expression | None, ...]


# --- modifiers ---------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Modifier(Node):
    """One argument of a class modification: ``[each] [final] name[.sub](nested) = value``.

    ``name`` may be dotted. ``redeclaration`` holds the new component or class of a ``redeclare``.
    """

    name: tuple[str, ...]
    value: Expression | None = None
    nested: tuple[Modifier, ...] = ()
    each: bool = False
    final: bool = False
    redeclaration: ComponentDeclaration | ClassDefinition | None = None


# --- equations and statements ------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Equation(Node):
    """Base of all equations; ``description`` is the string after it."""

    description: str


@dataclass(frozen=True, slots=True)
class SimpleEquation(Equation):
    """``left = right``."""

    left: Expression
    right: Expression


@dataclass(frozen=True, slots=True)
class ConnectEquation(Equation):
    """``connect(a, b, ...)``: two or more cuts."""

    cuts: tuple[Reference, ...]


@dataclass(frozen=True, slots=True)
class ForEquation(Equation):
    """``for i in r loop ... end for``."""

    indices: tuple[ForIndex, ...]
    body: tuple[Equation, ...]


@dataclass(frozen=True, slots=True)
class IfEquation(Equation):
    """``if c then ... elseif ... else ... end if``."""

    branches: tuple[tuple[Expression, tuple[Equation, ...]], ...]
    otherwise: tuple[Equation, ...]


@dataclass(frozen=True, slots=True)
class WhenEquation(Equation):
    """``when c then ... elsewhen ... end when``."""

    branches: tuple[tuple[Expression, tuple[Equation, ...]], ...]


@dataclass(frozen=True, slots=True)
class CallEquation(Equation):
    """A call used as an equation: ``assert(...)``, ``reinit(x, e)``, ``terminate(...)``."""

    call: Call


@dataclass(frozen=True, slots=True)
class Statement(Node):
    """Base of the statements of an algorithm."""

    description: str


@dataclass(frozen=True, slots=True)
class Assignment(Statement):
    """``target := value``."""

    target: Reference | TupleExpression
    value: Expression


@dataclass(frozen=True, slots=True)
class ForStatement(Statement):
    """``for i in r loop ... end for``."""

    indices: tuple[ForIndex, ...]
    body: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class WhileStatement(Statement):
    """``while c loop ... end while``."""

    condition: Expression
    body: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class IfStatement(Statement):
    """``if c then ... end if``."""

    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class WhenStatement(Statement):
    """``when c then ... end when``."""

    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]


@dataclass(frozen=True, slots=True)
class CallStatement(Statement):
    """A call used as a statement."""

    call: Call


@dataclass(frozen=True, slots=True)
class ReturnStatement(Statement):
    """``return``."""


@dataclass(frozen=True, slots=True)
class BreakStatement(Statement):
    """``break``."""


# --- classes -----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Annotation(Node):
    """``annotation(...)``: kept as modifiers, of which only ``experiment`` is used."""

    arguments: tuple[Modifier, ...]


@dataclass(frozen=True, slots=True)
class ComponentDeclaration(Node):
    """One declared component: one name, even where a clause declares several.

    Attributes:
        name: The component's name.
        type_name: The class it is an instance of.
        dimensions: Array dimensions, those of the type clause after those of the name.
        modifiers: The class modification.
        value: The declaration equation or binding.
        condition: ``if ...`` of a conditional component.
        prefixes: Of ``parameter constant discrete flow across through stream input output
            inner outer final replaceable redeclare``, as written, in order. ``flow`` is read
            as ``through``.
        public: False in a ``protected`` section.
        description: The description string.
        annotation: The annotation, if any.
    """

    name: str
    type_name: Reference
    dimensions: tuple[Expression, ...] = ()
    modifiers: tuple[Modifier, ...] = ()
    value: Expression | None = None
    condition: Expression | None = None
    prefixes: tuple[str, ...] = ()
    public: bool = True
    description: str = ""
    annotation: Annotation | None = None


@dataclass(frozen=True, slots=True)
class ExtendsClause(Node):
    """``extends Base(modifiers)``."""

    base: Reference
    modifiers: tuple[Modifier, ...] = ()
    public: bool = True


@dataclass(frozen=True, slots=True)
class ImportClause(Node):
    """``import a.b.C;`` ``import X = a.b.C;`` ``import a.b.*;`` ``import a.b.{C, D};``.

    Attributes:
        path: The package or class, as name parts.
        alias: The new name of a renaming import.
        wildcard: True for ``.*``.
        names: The names in braces.
    """

    path: tuple[str, ...]
    alias: str | None = None
    wildcard: bool = False
    names: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class ClassDefinition(Node):
    """A class of any kind.

    Attributes:
        kind: ``package connector model block record type function class``.
        name: The class's own name.
        partial: True for ``partial``.
        prefixes: ``encapsulated final replaceable expandable operator pure impure inner outer``.
        description: The description string.
        imports, extends, components, classes: The elements by sort, each in source order.
        equations, initial_equations: The equation sections, joined.
        algorithms, initial_algorithms: One tuple of statements for each section.
        alias: For a short class ``type T = Base[dims](modifiers)``: the base.
        alias_dimensions, alias_modifiers: What stands behind it. ``alias_prefixes`` before it.
        enumeration: The literals with their descriptions of ``type E = enumeration(...)``.
        external: True for a function with an ``external`` body.
        annotation: The class annotation.
    """

    kind: str
    name: str
    partial: bool = False
    prefixes: tuple[str, ...] = ()
    description: str = ""
    imports: tuple[ImportClause, ...] = ()
    extends: tuple[ExtendsClause, ...] = ()
    components: tuple[ComponentDeclaration, ...] = ()
    classes: tuple[ClassDefinition, ...] = ()
    equations: tuple[Equation, ...] = ()
    initial_equations: tuple[Equation, ...] = ()
    algorithms: tuple[tuple[Statement, ...], ...] = ()
    initial_algorithms: tuple[tuple[Statement, ...], ...] = ()
    alias: Reference | None = None
    alias_dimensions: tuple[Expression, ...] = ()
    alias_modifiers: tuple[Modifier, ...] = ()
    alias_prefixes: tuple[str, ...] = ()
    enumeration: tuple[tuple[str, str], ...] | None = None
    external: bool = False
    annotation: Annotation | None = None


@dataclass(frozen=True, slots=True)
class File(Node):
    """One source file.

    Attributes:
        within: The package of a leading ``within a.b;``.
        imports: Imports at the top of the file, seen by every class in it.
        classes: The classes.
    """

    within: tuple[str, ...] = ()
    imports: tuple[ImportClause, ...] = ()
    classes: tuple[ClassDefinition, ...] = ()
