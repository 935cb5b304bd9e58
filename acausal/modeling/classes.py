"""Class definitions with their scopes, and name lookup (Modelica 3.6, chapter 5).

A scope answers for a simple name; :func:`lookup` walks outwards and then down a dotted name.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, TypeAlias

from acausal.diagnostics import Label, Span, fail
from acausal.diagnostics.suggest import nearest
from acausal.syntax import tree

BUILTIN_TYPES = ("Real", "Integer", "Boolean", "String", "StateSelect")


@dataclass(frozen=True, eq=False)
class Builtin:
    """A predefined type: ``Real``, ``Integer``, ``Boolean``, ``String``, ``StateSelect``."""

    name: str

    @property
    def full_name(self) -> str:
        """The name itself."""
        return self.name


@dataclass(frozen=True, eq=False)
class Constant:
    """A component found by class lookup: a constant of a package or of an enclosing class."""

    owner: ClassDef
    declaration: tree.ComponentDeclaration


class Scope(Protocol):
    """Anything that has members and stands in something else."""

    @property
    def full_name(self) -> str:
        """Dotted name, empty for the root."""

    @property
    def parent(self) -> Scope | None:
        """The enclosing scope."""

    def find(self, name: str) -> Found | None:
        """Return what ``name`` means here, without looking outwards."""

    def names(self) -> list[str]:
        """Names for suggestions."""


#: What a name can mean.
Found: TypeAlias = "ClassDef | Builtin | Constant | Scope"


class ClassDef:
    """A class definition in its scope.

    Attributes:
        tree: The syntax.
        parent: The enclosing scope.
    """

    def __init__(self, definition: tree.ClassDefinition, parent: Scope | None) -> None:
        self.tree = definition
        self._parent = parent
        self._searching = False
        #: What names of types mean in it: models of many components ask for few again and again.
        self.known_types: dict[tuple[str, ...], ClassDef | Builtin] = {}

    def __repr__(self) -> str:
        return f"ClassDef({self.full_name})"

    def __deepcopy__(self, memo: object) -> ClassDef:
        # A copy would be another class.
        return self

    @property
    def name(self) -> str:
        """The simple name."""
        return self.tree.name

    @property
    def kind(self) -> str:
        """``model``, ``connector``, ..."""
        return self.tree.kind

    @property
    def span(self) -> Span:
        """Where it stands."""
        return self.tree.span

    @property
    def parent(self) -> Scope | None:
        """The enclosing scope."""
        return self._parent

    @cached_property
    def full_name(self) -> str:
        """Dotted name from the root package."""
        outer = self._parent.full_name if self._parent is not None else ""
        return f"{outer}.{self.tree.name}" if outer else self.tree.name

    @cached_property
    def classes(self) -> dict[str, ClassDef]:
        """Classes declared directly in this one."""
        return {c.name: ClassDef(c, self) for c in self.tree.classes}

    @cached_property
    def declarations(self) -> dict[str, tree.ComponentDeclaration]:
        """Components declared directly in this class."""
        return {c.name: c for c in self.tree.components}

    @cached_property
    def bases(self) -> tuple[tuple[ClassDef | Builtin, tree.ExtendsClause], ...]:
        """Base classes with their clauses; a short class extends what it is another name of.

        Raises:
            AcausalError: ``N104`` when a class extends itself through others.
        """
        clauses = list(self.tree.extends)
        if self.tree.alias is not None:
            alias = self.tree.alias
            clauses.append(tree.ExtendsClause(alias.span, alias, self.tree.alias_modifiers))
        found: list[tuple[ClassDef | Builtin, tree.ExtendsClause]] = []
        if self._searching:
            fail(
                "N104",
                f"{self.full_name} extends itself",
                clauses[0].span if clauses else self.span,
                label="the chain of extends comes back to the class it started from",
                help="remove one extends clause of the cycle",
            )
        self._searching = True
        try:
            for clause in clauses:
                base = lookup(self._parent or self, clause.base, skip_components=True, start=self)
                if isinstance(base, (ClassDef, Builtin)):
                    if isinstance(base, ClassDef):
                        _ = base.bases
                    found.append((base, clause))
                else:
                    fail(
                        "N101",
                        f"{clause.base} is not a class that can be extended",
                        clause.span,
                        help="extend a model, block, connector, record or type",
                    )
        finally:
            self._searching = False
        return tuple(found)

    def ancestors(self) -> Iterator[ClassDef]:
        """This class and all its base classes, bases of later clauses last."""
        yield self
        for base, _ in self.bases:
            if isinstance(base, ClassDef):
                yield from base.ancestors()

    def find(self, name: str) -> Found | None:
        """Return the meaning of ``name`` in this class: own, inherited, then imported."""
        found = self.member(name)
        return found if found is not None else find_import(self.tree.imports, name, self)

    def member(self, name: str) -> ClassDef | Constant | None:
        """Return the own or inherited class or component called ``name``."""
        if name in self.classes:
            return self.classes[name]
        if name in self.declarations:
            return Constant(self, self.declarations[name])
        if self._searching:
            return None
        for base, _ in self.bases:
            if isinstance(base, ClassDef):
                found = base.member(name)
                if isinstance(found, Constant):
                    return Constant(self, found.declaration)  # as modified by this class
                if found is not None:
                    return found
        return None

    def names(self) -> list[str]:
        """Names of own and inherited classes and components, for suggestions."""
        result: list[str] = []
        for c in self.ancestors() if not self._searching else [self]:
            result += [*c.classes, *c.declarations]
        for clause in self.tree.imports:
            result += imported_names(clause, self)
        return result


class FileScope:
    """The top of one file: its imports, in front of the package it belongs to."""

    def __init__(self, imports: tuple[tree.ImportClause, ...], parent: Scope) -> None:
        self.imports = imports
        self._parent = parent
        self.classes: dict[str, ClassDef] = {}

    @property
    def full_name(self) -> str:
        """The package's name: a file adds none."""
        return self._parent.full_name

    @property
    def parent(self) -> Scope | None:
        """The package."""
        return self._parent

    def find(self, name: str) -> Found | None:
        """Return a class of the file or an imported one."""
        if name in self.classes:
            return self.classes[name]
        return find_import(self.imports, name, self)

    def names(self) -> list[str]:
        """Names seen at the top of the file."""
        result = list(self.classes)
        for clause in self.imports:
            result += imported_names(clause, self)
        return result


def _root(scope: Scope) -> Scope:
    while scope.parent is not None:
        scope = scope.parent
    return scope


def _global(scope: Scope, name: str) -> Found | None:
    """Return a top-level class or package: of the file the text stands in, or of the library."""
    where: Scope | None = scope
    while where is not None:
        if isinstance(where, FileScope) and not where.full_name and name in where.classes:
            return where.classes[name]
        where = where.parent
    return _member(_root(scope), name)


def _import_target(clause: tree.ImportClause, path: tuple[str, ...], scope: Scope) -> Found:
    found: Found | None = _root(scope)
    done: list[str] = []
    for part in path:
        inner = _member(found, part) if done else _global(scope, part)
        if inner is None:
            where = ".".join(done)
            fail(
                "N107",
                f"there is no {'package' if not done else 'name'} {part!r}"
                + (f" in {where}" if done else " to import from"),
                clause.span,
                notes=_near(part, found),
                help="acausal list shows what the library contains",
            )
        found = inner
        done.append(part)
    assert found is not None
    return found


def find_import(imports: tuple[tree.ImportClause, ...], name: str, scope: Scope) -> Found | None:
    """Return what an import clause makes of ``name``: qualified imports before wildcards."""
    for clause in imports:
        if clause.wildcard:
            continue
        if clause.names:
            if name in clause.names:
                return _import_target(clause, (*clause.path, name), scope)
        elif name == (clause.alias or clause.path[-1]):
            return _import_target(clause, clause.path, scope)
    several: list[tuple[tree.ImportClause, Found]] = []
    for clause in imports:
        if clause.wildcard:
            found = _member(_import_target(clause, clause.path, scope), name)
            if found is not None and all(found is not other for _, other in several):
                several.append((clause, found))
    if len(several) > 1 and not isinstance(several[0][1], Constant):
        raise AmbiguousName(name, several)
    return several[0][1] if several else None


class AmbiguousName(Exception):  # noqa: N818 - becomes a diagnostic where the name is used
    """Two wildcard imports give one name different meanings."""

    def __init__(self, name: str, found: list[tuple[tree.ImportClause, Found]]) -> None:
        super().__init__(name)
        self.name = name
        self.found = found


def imported_names(clause: tree.ImportClause, scope: Scope) -> list[str]:
    """Return the names an import clause makes visible, for suggestions."""
    if clause.wildcard:
        target = _import_target(clause, clause.path, scope)
        return [] if isinstance(target, (Builtin, Constant)) else target.names()
    return list(clause.names) or [clause.alias or clause.path[-1]]


def _member(found: Found | None, name: str) -> Found | None:
    if isinstance(found, ClassDef):
        return found.member(name)
    if found is None or isinstance(found, (Builtin, Constant)):
        return None
    return found.find(name)


def _near(name: str, scope: Found | None) -> list[str]:
    if scope is None or isinstance(scope, (Builtin, Constant)):
        return []
    close = nearest(name, scope.names())
    return [f"did you mean {' or '.join(close)}?"] if close else []


def lookup(
    scope: Scope,
    reference: tree.Reference,
    *,
    skip_components: bool = False,
    start: ClassDef | None = None,
) -> Found:
    """Return the class, package or constant a dotted name means.

    Args:
        scope: Where the name is written.
        reference: The name; subscripts are ignored.
        skip_components: Ignore components with the name of the first part (types are sought).
        start: A class whose own nested classes and imports are seen first, though not its
            inherited ones (for its extends clauses).

    Raises:
        AcausalError: ``N101`` if there is no such name.
    """
    found = find_name(scope, reference, skip_components=skip_components, start=start)
    if found is None:
        first = reference.parts[0].name
        candidates: list[str] = []
        where: Scope | None = scope
        while where is not None:
            candidates += where.names()
            where = where.parent
        name = str(reference)
        close = nearest(first, candidates) if len(reference.parts) == 1 else []
        if len(reference.parts) > 1:
            outer = find_name(
                scope,
                tree.Reference(reference.span, reference.parts[:-1], reference.absolute),
            )
            if outer is not None and not isinstance(outer, (Builtin, Constant)):
                close = nearest(reference.parts[-1].name, outer.names())
        fail(
            "N101",
            f"there is no class {name}",
            reference.span,
            label="not found here or in anything imported",
            notes=[f"did you mean {' or '.join(close)}?"] if close else [],
            help=(
                f"write {close[0]}, if that is what you mean"
                if close
                else "declare it, or import the package it is in; acausal list shows the library"
            ),
        )
    return found


def find_name(
    scope: Scope,
    reference: tree.Reference,
    *,
    skip_components: bool = False,
    start: ClassDef | None = None,
) -> Found | None:
    """Like :func:`lookup`, but return None when there is no such name.

    Raises:
        AcausalError: ``N121`` if two wildcard imports give it different meanings.
    """
    try:
        return _find_name(scope, reference, skip_components, start)
    except AmbiguousName as ambiguous:
        names = [getattr(f, "full_name", ambiguous.name) for _, f in ambiguous.found]
        fail(
            "N121",
            f"{ambiguous.name} may be {' or '.join(names)}",
            reference.span,
            label="two imports give this name",
            labels=[Label(clause.span, "imported from here") for clause, _ in ambiguous.found],
            help=f"write {names[0]}, or import {names[0]}",
        )


def _find_name(
    scope: Scope, reference: tree.Reference, skip_components: bool, start: ClassDef | None
) -> Found | None:
    first = reference.parts[0].name
    if len(reference.parts) == 1 and first in BUILTIN_TYPES:
        return _builtins[first]
    found: Found | None = None
    if start is not None:
        found = start.classes.get(first) or find_import(start.tree.imports, first, start)
    where: Scope | None = scope
    if reference.absolute:
        found, where = _global(scope, first), None
    while found is None and where is not None:
        found = where.find(first)
        if skip_components and isinstance(found, Constant):
            found = None
        where = where.parent
    for part in reference.parts[1:]:
        found = _member(found, part.name)
    return found


_builtins = {name: Builtin(name) for name in BUILTIN_TYPES}
