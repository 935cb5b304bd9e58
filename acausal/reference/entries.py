"""What the reference says about one class, as plain data."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from acausal.modeling.classes import Builtin, ClassDef
from acausal.modeling.listing import Declared, declared, unit_of
from acausal.reference.equations import Limit, Line, equation_lines, limits, statement_lines
from acausal.syntax import tree
from acausal.syntax.formatter import format_class, format_expression


@dataclass(frozen=True, slots=True)
class Item:
    """One component of a class as a row of a table.

    Attributes:
        name: Its name, with array dimensions.
        type_name: Its type as it is written.
        type_class: The class behind the name, for a link.
        unit: Unit text.
        default: Value as it is written.
        description: What the author says.
        origin: The class that declares it; None for the class itself.
        structural: It decides sizes or structure and is fixed when the model is compiled.
        condition: The condition under which it exists.
        flow: ``across``, ``through``, ``input`` or ``output``.
    """

    name: str
    type_name: str
    type_class: ClassDef | None
    unit: str
    default: str
    description: str
    origin: ClassDef | None
    structural: bool = False
    condition: str = ""
    flow: str = ""


@dataclass(frozen=True, slots=True)
class Laws:
    """Equations of a class or of one of its bases."""

    origin: ClassDef | None
    lines: tuple[Line, ...]
    initial: tuple[Line, ...]


@dataclass(frozen=True, slots=True)
class ClassEntry:
    """A class as the reference shows it.

    Attributes:
        definition: The class.
        bases: Classes that it extends.
        ports, parameters, variables, parts, constants: Its public components by sort.
        laws: Own equations first, then those of the bases.
        limits: What its asserts demand.
        literals: Names and descriptions of an enumeration.
        unit: Unit of a type.
        code: The text of a function.
    """

    definition: ClassDef
    bases: tuple[ClassDef | Builtin, ...]
    ports: tuple[Item, ...]
    parameters: tuple[Item, ...]
    variables: tuple[Item, ...]
    parts: tuple[Item, ...]
    constants: tuple[Item, ...]
    laws: tuple[Laws, ...]
    limits: tuple[Limit, ...]
    literals: tuple[tuple[str, str], ...] = ()
    unit: str = ""
    code: str = ""


def class_entry(definition: ClassDef) -> ClassEntry:
    """Return what there is to say about a class.

    Raises:
        AcausalError: If a base class or the class of a component is not found.
    """
    sorts: dict[str, list[Item]] = {
        s: [] for s in ("port", "parameter", "variable", "part", "constant")
    }
    names = set()
    for found in declared(definition):
        names.add(found.component.name)
        if found.component.public and found.fixed_by is None:
            sort, item = _item(found, definition)
            if sort in sorts:
                sorts[sort].append(item)
    laws, asserts = _laws(definition, names)
    function = definition.kind == "function"
    return ClassEntry(
        definition=definition,
        bases=tuple(b for b, _ in definition.bases),
        ports=tuple(sorts["port"]),
        parameters=tuple(sorts["parameter"]),
        variables=tuple(sorts["variable"]),
        parts=tuple(sorts["part"]),
        constants=tuple(sorts["constant"]),
        laws=() if function else laws,
        limits=asserts,
        literals=definition.tree.enumeration or (),
        unit=_unit(definition),
        code=_code(definition) if function else "",
    )


def _item(found: Declared, definition: ClassDef) -> tuple[str, Item]:
    component, type_class = found.component, found.type_class
    prefixes = component.prefixes
    unit, simple = unit_of(component, type_class)
    flow = next((f for f in ("across", "through", "input", "output") if f in prefixes), "")
    dimensions = ", ".join(format_expression(d) for d in component.dimensions)
    kind = _base_type(type_class)
    own_class = type_class if isinstance(type_class, ClassDef) else None
    if "final" in prefixes:
        sort = "hidden"
    elif "constant" in prefixes:
        sort = "constant"
    elif "parameter" in prefixes:
        sort = "parameter"
    elif own_class is not None and own_class.kind == "connector":
        sort = "port"
    elif simple or (own_class is not None and own_class.kind == "record"):
        sort = "variable"
    else:
        sort = "part"
    value = found.value
    colon = any(isinstance(d, tree.Colon) for d in component.dimensions)
    return sort, Item(
        name=component.name + (f"[{dimensions}]" if dimensions else ""),
        type_name=str(component.type_name),
        type_class=own_class,
        unit=unit,
        default="" if value is None else format_expression(value),
        description=component.description,
        origin=found.owner if found.owner is not definition else None,
        structural=sort == "parameter" and (colon or kind not in ("Real", "")),
        condition="" if component.condition is None else format_expression(component.condition),
        flow=flow,
    )


def _base_type(type_class: object) -> str:
    """Return the predefined type behind a type; empty for records and models."""
    for _ in range(100):
        if isinstance(type_class, Builtin):
            return type_class.name
        if not isinstance(type_class, ClassDef):
            return ""
        if type_class.tree.enumeration is not None:
            return "enumeration"
        if len(type_class.bases) != 1 or type_class.kind not in ("type", "connector"):
            return ""
        type_class = type_class.bases[0][0]
    return ""


def _laws(definition: ClassDef, names: Iterable[str]) -> tuple[tuple[Laws, ...], tuple[Limit, ...]]:
    """Return equations and asserts of the class, then of its bases, each base once."""
    found: list[Laws] = []
    asserts: list[Limit] = []
    known = frozenset(names)
    seen: list[ClassDef] = []
    for ancestor in definition.ancestors():
        if any(ancestor is other for other in seen):
            continue
        seen.append(ancestor)
        text = ancestor.tree
        lines = equation_lines(text.equations, known)
        for section in text.algorithms:
            lines += statement_lines(section, known)
        initial = equation_lines(text.initial_equations, known)
        for section in text.initial_algorithms:
            initial += statement_lines(section, known)
        if lines or initial:
            origin = None if ancestor is definition else ancestor
            found.append(Laws(origin, tuple(lines), tuple(initial)))
        asserts += limits(text.equations, known)
    return tuple(found), tuple(asserts)


def _unit(definition: ClassDef) -> str:
    if definition.kind not in ("type", "connector"):
        return ""
    span = definition.span
    reference = tree.Reference(span, (tree.NamePart(span, definition.name),))
    return unit_of(tree.ComponentDeclaration(span, "", reference), definition)[0]


def _code(definition: ClassDef) -> str:
    return format_class(definition.tree).rstrip("\n")
