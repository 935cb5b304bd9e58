"""Flattening of ``extends``: one list of elements with the modifications that reach each of them.

Modelica 3.6, chapter 7. A modification is kept as a path below its element and a value, so that
``c(C = 1, v(start = 0))`` becomes ``C = 1`` and ``v.start = 0`` of element ``c``; of two
modifications of the same path the outer one wins.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TypeVar

from acausal.diagnostics import Label, Span, fail
from acausal.diagnostics.suggest import nearest
from acausal.modeling.classes import Builtin, ClassDef, lookup
from acausal.syntax import tree
from acausal.syntax.class_formatter import component_text
from acausal.syntax.formatter import format_expression


@dataclass(frozen=True)
class Modification:
    """``path = value`` below an element.

    Attributes:
        path: Names below the element; empty for the element's own binding.
        value: The expression, to be read in class ``owner``.
        owner: The class in which the modification is written.
        each: Written with ``each``.
        final: Written with ``final``.
        span: Where it is written.
    """

    path: tuple[str, ...]
    value: tree.Expression
    owner: ClassDef
    each: bool
    final: bool
    span: Span


@dataclass(frozen=True)
class Element:
    """A component of a class after flattening of ``extends``.

    Attributes:
        declaration: The declaration.
        owner: The class that declares it: the scope of its type and dimensions.
        modifications: What modifies it, outermost first, its own declaration last.
    """

    declaration: tree.ComponentDeclaration
    owner: ClassDef
    modifications: tuple[Modification, ...]

    @property
    def name(self) -> str:
        """The component's name."""
        return self.declaration.name

    def has(self, prefix: str) -> bool:
        """Tell whether the declaration has the prefix."""
        return prefix in self.declaration.prefixes


@dataclass(frozen=True)
class Merged:
    """A class with everything it inherits.

    Attributes:
        definition: The class.
        elements: Components by name, inherited ones first.
        equations, initial_equations: Equations with the class each is written in.
        algorithms, initial_algorithms: Statement lists likewise.
    """

    definition: ClassDef
    elements: dict[str, Element]
    equations: tuple[tuple[tree.Equation, ClassDef], ...]
    initial_equations: tuple[tuple[tree.Equation, ClassDef], ...]
    algorithms: tuple[tuple[tuple[tree.Statement, ...], ClassDef], ...]
    initial_algorithms: tuple[tuple[tuple[tree.Statement, ...], ClassDef], ...]


@dataclass(frozen=True)
class PrimitiveType:
    """``Real``, ``Integer``, ``Boolean``, ``String`` or an enumeration, with its attributes.

    Attributes:
        base: Name of the predefined type, or ``enumeration``.
        enumeration: The class of an enumeration.
        modifications: Attribute settings, outermost first.
        dimensions: Array dimensions of the type with the class they are written in.
        connector: True for ``connector RealInput = input Real``.
        causality: ``input``, ``output`` or empty.
        name: The name the user gave the type.
    """

    base: str
    enumeration: ClassDef | None
    modifications: tuple[Modification, ...]
    dimensions: tuple[tuple[tree.Expression, ClassDef], ...]
    connector: bool
    causality: str
    name: str


def modifications(modifiers: tuple[tree.Modifier, ...], owner: ClassDef) -> list[Modification]:
    """Return nested modifiers as a flat list, in source order.

    Raises:
        AcausalError: ``N108`` for ``redeclare``, ``N105`` for one name modified twice.
    """
    result: list[Modification] = []
    stack: list[tuple[tree.Modifier, tuple[str, ...], bool, bool]] = [
        (m, (), False, False) for m in reversed(modifiers)
    ]
    seen: dict[tuple[str, ...], Span] = {}
    while stack:
        modifier, prefix, each, final = stack.pop()
        if modifier.redeclaration is not None:
            fail(
                "N108",
                "redeclare is not supported",
                modifier.span,
                help="declare the component with the class you want, or extend the class",
            )
        path = prefix + modifier.name
        each, final = each or modifier.each, final or modifier.final
        if modifier.value is not None:
            if path in seen:
                fail(
                    "N105",
                    f"{'.'.join(path)} is set twice",
                    modifier.span,
                    labels=[Label(seen[path], "first here")],
                    help="remove one of the two",
                )
            seen[path] = modifier.span
            result.append(Modification(path, modifier.value, owner, each, final, modifier.span))
        stack += [(m, path, each, final) for m in reversed(modifier.nested)]
    return result


def _own_elements(definition: ClassDef, elements: dict[str, Element]) -> None:
    for declaration in definition.tree.components:
        own = modifications(declaration.modifiers, definition)
        if declaration.value is not None:
            final = "final" in declaration.prefixes
            own.append(
                Modification(
                    (), declaration.value, definition, False, final, declaration.value.span
                )
            )
        before = elements.get(declaration.name)
        if before is not None:
            if before.owner is definition:
                fail(
                    "N105",
                    f"{declaration.name} is declared twice",
                    declaration.span,
                    labels=[Label(before.declaration.span, "first here")],
                    help="rename one of the two",
                )
            if component_text(before.declaration) != component_text(declaration):
                fail(
                    "N105",
                    f"{declaration.name} is already declared in {before.owner.full_name}",
                    declaration.span,
                    labels=[Label(before.declaration.span, "inherited from here")],
                    help="give it another name, or modify the inherited one in the extends clause",
                )
            continue
        elements[declaration.name] = Element(declaration, definition, tuple(own))


@lru_cache(maxsize=4096)
def merge(definition: ClassDef) -> Merged:
    """Return a class with everything it inherits.

    Raises:
        AcausalError: ``N103`` for a modifier that meets no component, ``N109`` for one that meets
            a final value, ``N105`` for names declared twice.
    """
    elements: dict[str, Element] = {}
    equations: list[tuple[tree.Equation, ClassDef]] = []
    initial: list[tuple[tree.Equation, ClassDef]] = []
    algorithms: list[tuple[tuple[tree.Statement, ...], ClassDef]] = []
    initial_algorithms: list[tuple[tuple[tree.Statement, ...], ClassDef]] = []
    for base, clause in definition.bases:
        if isinstance(base, Builtin):
            continue
        inherited = merge(base)
        changes = modifications(clause.modifiers, definition)
        merged = apply(inherited.elements, changes, base)
        for name, element in merged.items():
            _inherit(element, elements, clause)
            elements.setdefault(name, element)
        # What comes over two ways from one class is there once.
        equations += _new(inherited.equations, equations)
        initial += _new(inherited.initial_equations, initial)
        algorithms += _new(inherited.algorithms, algorithms)
        initial_algorithms += _new(inherited.initial_algorithms, initial_algorithms)
    _own_elements(definition, elements)
    equations += [(e, definition) for e in definition.tree.equations]
    initial += [(e, definition) for e in definition.tree.initial_equations]
    algorithms += [(a, definition) for a in definition.tree.algorithms]
    initial_algorithms += [(a, definition) for a in definition.tree.initial_algorithms]
    return Merged(
        definition,
        elements,
        tuple(equations),
        tuple(initial),
        tuple(algorithms),
        tuple(initial_algorithms),
    )


def _inherit(element: Element, elements: dict[str, Element], clause: tree.ExtendsClause) -> None:
    """Refuse to inherit a component that is there already and is not the same.

    Raises:
        AcausalError: ``N105``.
    """
    before = elements.get(element.name)
    if before is None or _written(before) == _written(element):
        return
    fail(
        "N105",
        f"{element.name} is inherited twice, and not as the same",
        clause.span,
        labels=[
            Label(before.declaration.span, "inherited from here"),
            Label(element.declaration.span, "and from here"),
        ],
        help="extend only one of the two classes, or rename one of the components",
    )


def _written(element: Element) -> tuple[object, ...]:
    """Return what a component is like, wherever it is written."""
    return (
        component_text(element.declaration),
        *((m.path, format_expression(m.value), m.each, m.final) for m in element.modifications),
    )


_Section = TypeVar("_Section")


def _new(
    inherited: Sequence[tuple[_Section, ClassDef]], known: Sequence[tuple[_Section, ClassDef]]
) -> list[tuple[_Section, ClassDef]]:
    seen = {(id(section), id(owner)) for section, owner in known}
    return [entry for entry in inherited if (id(entry[0]), id(entry[1])) not in seen]


def apply(
    elements: dict[str, Element], changes: list[Modification], modified: ClassDef
) -> dict[str, Element]:
    """Return elements with modifications put in front of what they already have."""
    result = dict(elements)
    by_name: dict[str, list[Modification]] = {}
    for change in changes:
        if change.path[0] not in elements:
            unknown_modifier(change, modified)
        by_name.setdefault(change.path[0], []).append(replace(change, path=change.path[1:]))
    for name, own in by_name.items():
        element = result[name]
        for change in own:
            check_final(change, element.modifications)
        result[name] = replace(element, modifications=(*own, *element.modifications))
    return result


def check_final(change: Modification, earlier: tuple[Modification, ...]) -> None:
    """Refuse a modification of something that was set ``final``."""
    for other in earlier:
        if other.final and other.path == change.path:
            fail(
                "N109",
                "this value is final and cannot be changed",
                change.span,
                labels=[Label(other.span, "made final here")],
                help="remove the modifier",
            )


def unknown_modifier(change: Modification, modified: ClassDef) -> None:
    """Refuse a modifier whose name is no component of the modified class."""
    name = change.path[0]
    close = nearest(name, list(merge(modified).elements))
    fail(
        "N103",
        f"{modified.full_name} has nothing called {name}",
        change.span,
        label="this modifier meets nothing",
        notes=[f"did you mean {' or '.join(close)}?"] if close else [],
        help=f"acausal list {modified.full_name} shows its parameters and variables",
    )


@lru_cache(maxsize=4096)
def primitive_type(definition: ClassDef | Builtin) -> PrimitiveType | None:
    """Return the predefined type a class is another name of, or None for a composite class."""
    if isinstance(definition, Builtin):
        # The literals of StateSelect are numbers in the order of the enumeration.
        name = "Integer" if definition.name == "StateSelect" else definition.name
        return PrimitiveType(name, None, (), (), False, "", definition.name)
    if definition.tree.enumeration is not None:
        return PrimitiveType("enumeration", definition, (), (), False, "", definition.name)
    for base, clause in definition.bases:
        below = primitive_type(base)
        if below is not None:
            causality = next(
                (p for p in definition.tree.alias_prefixes if p in ("input", "output")),
                below.causality,
            )
            return PrimitiveType(
                below.base,
                below.enumeration,
                (*modifications(clause.modifiers, definition), *below.modifications),
                (
                    *((d, definition) for d in definition.tree.alias_dimensions),
                    *below.dimensions,
                ),
                definition.kind == "connector" or below.connector,
                causality,
                definition.name,
            )
    return None


def type_of(element: Element) -> ClassDef | Builtin:
    """Return the class of an element.

    Raises:
        AcausalError: ``N101`` if there is none, ``N110`` if the name means something else.
    """
    declaration = element.declaration
    known = element.owner.known_types
    names = tuple([p.name for p in declaration.type_name.parts])
    if declaration.type_name.absolute:
        names = ("", *names)
    if names in known:
        return known[names]
    found = lookup(element.owner, declaration.type_name, skip_components=True)
    if not isinstance(found, (ClassDef, Builtin)):
        fail(
            "N110",
            f"{declaration.type_name} is a package, not a class",
            declaration.type_name.span,
            help="name a class in it",
        )
    if isinstance(found, ClassDef) and found.kind in ("package", "function"):
        fail(
            "N110",
            f"{declaration.type_name} is a {found.kind}, not a class of components",
            declaration.type_name.span,
            help="name a model, block, connector, record or type",
        )
    known[names] = found
    return found
