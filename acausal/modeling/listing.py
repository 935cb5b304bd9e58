"""The library in words: packages with their classes, classes with what a user may set."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from acausal.diagnostics import fail
from acausal.diagnostics.suggest import nearest
from acausal.modeling.classes import Builtin, ClassDef, find_name
from acausal.modeling.library import FolderPackage, Root, standard_library
from acausal.modeling.load import library_class
from acausal.syntax import tree
from acausal.syntax.formatter import format_expression


@dataclass(frozen=True, slots=True)
class Entry:
    """One component of a class, its own or inherited.

    Attributes:
        name: Its name, with array dimensions.
        type_name: Its class as written.
        kind: ``cut``, ``parameter``, ``constant``, ``variable`` or ``component``.
        unit: Unit text, empty if it has none.
        default: Value as written, empty if it has none.
        description: Its description string.
        owner: Full name of the class that declares it.
    """

    name: str
    type_name: str
    kind: str
    unit: str
    default: str
    description: str
    owner: str


def describe(name: str = "", *, deep: bool = False, root: Root | None = None) -> str:
    """Return the contents of the library, a package or a class as text.

    Args:
        name: Dotted name; empty for the whole library.
        deep: Show the classes of sub-packages too.
        root: The library; the standard one if None.

    Raises:
        AcausalError: ``N150`` if there is no such package or class.
    """
    root = root or standard_library()
    found = library_class(name, root)
    if isinstance(found, (Root, FolderPackage)):
        return _package(found, deep)
    if isinstance(found, ClassDef):
        is_folder = found.kind == "package" and bool(found.classes)
        return _package(found, deep) if is_folder else _class(found)
    close = _close(name, root)
    fail(
        "N150",
        f"the library has no package or class {name}",
        notes=[f"did you mean {' or '.join(close)}?"] if close else [],
        help=f"acausal list {close[0]}" if close else "acausal list shows the packages",
    )


def entries(definition: ClassDef) -> list[Entry]:
    """Return the public components of a class, inherited ones first.

    Constants are left out, but for those of a package.

    Raises:
        AcausalError: If a base class is not found.
    """
    return list(_entries(definition))


@dataclass(frozen=True, slots=True)
class Declared:
    """A component of a class as it is declared, with what is known about it there.

    Attributes:
        component: The declaration.
        owner: The class that declares it.
        type_class: Its class; None if there is none of the name.
        value: Its value, perhaps set by a class that extends the owner; None without one.
        fixed_by: The class whose ``extends`` makes the value final; None if it can be set.
    """

    component: tree.ComponentDeclaration
    owner: ClassDef
    type_class: object
    value: tree.Expression | None
    fixed_by: ClassDef | None = None


def declared(definition: ClassDef) -> Iterator[Declared]:
    """Yield all components of a class, inherited ones first, each name once.

    Raises:
        AcausalError: If a base class is not found.
    """
    seen: set[str] = set()
    for found in _declared(definition, {}, {}):
        if found.component.name not in seen:
            seen.add(found.component.name)
            yield found


def _declared(
    definition: ClassDef, given: dict[str, tree.Expression], final: dict[str, ClassDef]
) -> Iterator[Declared]:
    """Yield as :func:`declared`; ``given`` and ``final`` hold what derived classes set."""
    for base, clause in definition.bases:
        if isinstance(base, ClassDef):
            set_here = [m for m in clause.modifiers if len(m.name) == 1 and m.value is not None]
            values = {m.name[0]: m.value for m in set_here if m.value is not None}
            fixed = {m.name[0]: definition for m in set_here if m.final}
            yield from _declared(base, {**values, **given}, {**fixed, **final})
    for component in definition.tree.components:
        yield Declared(
            component,
            definition,
            find_name(definition, component.type_name, skip_components=True),
            given.get(component.name, component.value),
            final.get(component.name),
        )


def _entries(definition: ClassDef) -> Iterator[Entry]:
    """Yield the public components that a user may set or read, inherited ones first."""
    for found in declared(definition):
        component, type_class, owner = found.component, found.type_class, found.owner
        prefixes = component.prefixes
        constant = "constant" in prefixes
        if not component.public or "final" in prefixes or found.fixed_by is not None:
            continue
        if constant and owner.kind != "package":
            continue
        unit, simple = unit_of(component, type_class)
        kind = "component"
        if constant:
            kind = "constant"
        elif "parameter" in prefixes:
            kind = "parameter"
        elif isinstance(type_class, ClassDef) and type_class.kind == "connector":
            kind = "cut"
        elif simple:
            kind = "variable"
        dimensions = ", ".join(format_expression(d) for d in component.dimensions)
        yield Entry(
            name=component.name + (f"[{dimensions}]" if dimensions else ""),
            type_name=str(component.type_name),
            kind=kind,
            unit=unit,
            default="" if found.value is None else format_expression(found.value),
            description=component.description,
            owner=owner.full_name,
        )


def unit_of(component: tree.ComponentDeclaration, type_class: object) -> tuple[str, bool]:
    """Return the unit that a declaration or its type gives, and whether the type is a number."""
    unit = _given_unit(component.modifiers)
    seen = 0
    while isinstance(type_class, ClassDef) and seen < 100:
        seen += 1
        unit = unit or _given_unit(type_class.tree.alias_modifiers)
        if type_class.tree.enumeration is not None:
            return "", True
        bases = type_class.bases
        if type_class.kind not in ("type", "connector") or len(bases) != 1:
            return unit, False
        type_class = bases[0][0]
    return unit, isinstance(type_class, Builtin)


def _given_unit(modifiers: tuple[tree.Modifier, ...]) -> str:
    for modifier in modifiers:
        if modifier.name == ("unit",) and isinstance(modifier.value, tree.StringLiteral):
            return modifier.value.value
    return ""


def _package(package: Root | FolderPackage | ClassDef, deep: bool) -> str:
    lines: list[str] = []
    pending: list[Root | FolderPackage | ClassDef] = [package]
    while pending:
        here = pending.pop()
        inner = _packages(here)
        classes = [] if isinstance(here, Root) else list(here.classes.values())
        classes = [c for c in classes if c.kind != "package"]
        if here.full_name and (classes or inner):
            lines += ["", here.full_name] if lines else [here.full_name]
        if not deep or isinstance(here, Root):
            rows = [(p.full_name, "package", _contents(p)) for p in inner]
            lines += _table(rows)
        lines += _table([(c.name, _kind(c), c.tree.description) for c in classes])
        if deep:
            pending += reversed(inner)
    return "\n".join(lines) if lines else f"{package.full_name} is empty"


def _packages(package: Root | FolderPackage | ClassDef) -> list[FolderPackage | ClassDef]:
    if isinstance(package, ClassDef):
        return [c for c in package.classes.values() if c.kind == "package"]
    if isinstance(package, Root):
        found: list[object] = [package.find(name) for name in dict.fromkeys(package.names())]
        return [p for p in found if isinstance(p, (FolderPackage, ClassDef))]
    classes = [c for c in package.classes.values() if c.kind == "package"]
    return [*package.packages.values(), *classes]


def _contents(package: FolderPackage | ClassDef) -> str:
    names = [p.full_name.rpartition(".")[2] for p in _packages(package)]
    classes = len(package.classes)
    said = [f"{classes} class{'es' * (classes > 1)}"] if classes else []
    if isinstance(package, ClassDef):
        said = [package.tree.description] if package.tree.description else []
    if names:
        said.append(f"packages {', '.join(names)}")
    return "; ".join(said)


def _kind(definition: ClassDef) -> str:
    return f"partial {definition.kind}" if definition.tree.partial else definition.kind


def _class(definition: ClassDef) -> str:
    about = f" - {definition.tree.description}" if definition.tree.description else ""
    lines = [f"{_kind(definition)} {definition.full_name}{about}"]
    bases = [b.full_name for b, _ in definition.bases]
    if bases:
        lines.append(f"extends {', '.join(bases)}")
    if definition.tree.enumeration is not None:
        lines += ["", "values", *_table(list(definition.tree.enumeration))]
        return "\n".join(lines)
    unit = _given_unit(definition.tree.alias_modifiers)
    if unit:
        lines.append(f"unit {unit}")
    found = entries(definition)
    for kind, title in (
        ("cut", "cuts"),
        ("parameter", "parameters"),
        ("constant", "constants"),
        ("variable", "variables"),
        ("component", "components"),
    ):
        rows: list[tuple[str, ...]] = [
            (e.name, e.type_name, e.default, f"[{e.unit}]" if e.unit else "", e.description)
            if kind in ("parameter", "constant")
            else (e.name, e.type_name, f"[{e.unit}]" if e.unit else "", e.description)
            for e in found
            if e.kind == kind
        ]
        if rows:
            lines += ["", title, *_table(rows)]
    if definition.classes:
        inner = [(c.name, _kind(c), c.tree.description) for c in definition.classes.values()]
        lines += ["", "classes", *_table(inner)]
    return "\n".join(lines)


def _table(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Align columns; a column that is empty everywhere is left out."""
    if not rows:
        return []
    kept = [k for k in range(len(rows[0])) if any(row[k] for row in rows)]
    widths = [min(40, max(len(row[k]) for row in rows)) for k in kept]
    return [
        "  " + "  ".join(row[k].ljust(w) for k, w in zip(kept, widths, strict=True)).rstrip()
        for row in rows
    ]


def _close(name: str, root: Root) -> list[str]:
    """Return full names like ``name``: a misspelt last part, or the right name elsewhere."""
    outer, _, last = name.rpartition(".")
    package = library_class(outer, root)
    if isinstance(package, (Root, FolderPackage, ClassDef)):
        names = [*package.packages] if isinstance(package, Root) else list(package.names())
        found = nearest(last, names)
        if found:
            return [f"{outer}.{n}" if outer else n for n in found]
    everywhere: dict[str, list[str]] = {}
    pending: list[FolderPackage] = list(root.packages.values())
    while pending:
        here = pending.pop(0)
        pending += here.packages.values()
        for inner in (*here.packages, *here.classes):
            everywhere.setdefault(inner, []).append(f"{here.full_name}.{inner}")
    if last in everywhere:
        return everywhere[last][:3]
    return [full for n in nearest(last, everywhere) for full in everywhere[n]][:3]
