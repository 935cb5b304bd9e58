"""From objects in Python to class definitions, the same ones that the parser makes of text."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

from acausal.compose.component import Component, ComponentType, asked
from acausal.compose.declarations import Declaration, size_tree
from acausal.compose.equations import equations_of
from acausal.compose.kinds import text_kind
from acausal.compose.modifiers import Pending, modifier
from acausal.compose.parts import Part, describe, owner_name, part_reference, reference
from acausal.compose.parts import Ref as Reference
from acausal.compose.symbols import Literal
from acausal.diagnostics import Label, Span, fail
from acausal.instantiation.merge import merge, primitive_type, type_of
from acausal.modeling.classes import Builtin, ClassDef, FileScope
from acausal.modeling.library import Root, standard_library
from acausal.syntax import tree
from acausal.syntax.formatter import format_class, format_file


@lru_cache(maxsize=1)
def shared_library() -> Root:
    """Return the library that all Python models of a process use."""
    return standard_library()


def model_definition(model: Component) -> ClassDef:
    """Return a model as a class definition in its scope.

    Raises:
        AcausalError: For parts that cannot be written where they are used.
    """
    return Assembly(model).result


def model_text(model: Component) -> str:
    """Return a model and the classes it uses as text."""
    assembly = Assembly(model)
    imports: list[tree.ImportClause] = []
    classes: list[tree.ClassDefinition] = []
    for file_imports, definition in assembly.foreign_trees():
        imports += [i for i in file_imports if i not in imports]
        if definition not in classes:
            classes.append(definition)
    classes += assembly.trees
    return format_file(tree.File(model._span, (), tuple(imports), tuple(classes)))


class Assembly:
    """The classes of one model, under names that are each other's neighbours."""

    def __init__(self, model: Component) -> None:
        root = shared_library()
        self.scope = FileScope((), root)
        self.root = root
        self.trees: list[tree.ClassDefinition] = []
        self._by_class: dict[type, str] = {}
        self._by_text: dict[str, tuple[str, dict[str, tree.Expression | None]]] = {}
        self._foreign: dict[str, ClassDef] = {}
        self._references: dict[tuple[Any, Span], tree.Reference] = {}
        self._outers: dict[ClassDef | Builtin, frozenset[str]] = {}
        self._taken = {*root.names(), model._title}
        definition = self.define(model, model._title)
        self.result = self.add(definition)

    def add(self, definition: tree.ClassDefinition) -> ClassDef:
        """Put a class into the scope."""
        found = ClassDef(definition, self.scope)
        self.scope.classes[definition.name] = found
        self.trees.append(definition)
        return found

    # --- names of classes -----------------------------------------------------------------

    def class_reference(self, what: Any, span: Span) -> tree.Reference:
        """Return the name of a class of the library, of a file, or of Python."""
        key = (what, span)
        found = self._references.get(key)
        if found is None:
            name = self._class_name(what, span)
            parts = tuple(tree.NamePart(span, n) for n in name.split("."))
            found = self._references[key] = tree.Reference(span, parts)
        return found

    def _class_name(self, what: Any, span: Span) -> str:
        if isinstance(what, Builtin):
            return what.name
        if isinstance(what, ClassDef):
            outermost = what
            while isinstance(outermost.parent, ClassDef):
                outermost = outermost.parent
            if isinstance(outermost.parent, FileScope) and not outermost.parent.full_name:
                self._take_foreign(outermost, span)
            return what.full_name
        assert isinstance(what, type)
        return self._static(what, span)

    def _take_foreign(self, definition: ClassDef, span: Span) -> None:
        """Make a class of a file known in the scope.

        Raises:
            AcausalError: ``N105`` if two classes of one name are used.
        """
        name = definition.name
        before = self.scope.classes.get(name)
        if before is definition:
            return
        if before is not None:
            fail("N105", f"two classes are called {name}", span,
                 labels=[Label(before.span, "one here"), Label(definition.span, "one here")],
                 help="rename one of them")  # fmt: skip
        self.scope.classes[name] = definition
        self._foreign[name] = definition
        self._taken.add(name)

    def foreign_trees(
        self,
    ) -> Iterator[tuple[tuple[tree.ImportClause, ...], tree.ClassDefinition]]:
        """Yield the imports and classes of all files that classes were loaded from."""
        seen: list[FileScope] = []
        for definition in self._foreign.values():
            scope = definition.parent
            assert isinstance(scope, FileScope)
            if scope not in seen:
                seen.append(scope)
                for inside in scope.classes.values():
                    yield scope.imports, inside.tree

    def _fresh(self, name: str) -> str:
        """Return a class name that is not taken."""
        found, count = name, 1
        while found in self._taken:
            count += 1
            found = f"{name}_{count}"
        self._taken.add(found)
        return found

    # --- classes of Python ----------------------------------------------------------------

    def _static(self, cls: Any, span: Span) -> str:
        """Return the name of a Python class whose instances are all alike."""
        found = self._by_class.get(cls)
        if found is None:
            found = self._by_class[cls] = self._fresh(cls.__name__)
            instance = Component.__new__(cls)
            self.add(self.define(instance, found))
        return found

    def class_of(self, part: Component) -> tuple[tree.Reference, tuple[tree.Modifier, ...]]:
        """Return the class of a component, and modifiers that make it like the component."""
        cls = type(part)
        span = part._span
        if cls._definition is not None:
            return self.class_reference(cls._definition, span), ()
        plain = part._parts is None and part._connections is None and part._equations is None
        stated = cls.equations is not Component.equations
        written = bool(cls._declared or cls._text_bases or stated)
        if not cls._dynamic and plain and part._initials is None and written:
            return self.class_reference(cls, span), ()
        return self._own_class(part)

    def _own_class(self, part: Component) -> tuple[tree.Reference, tuple[tree.Modifier, ...]]:
        """Return the class of a component with parts of its own; equal ones share it."""
        span = part._span
        with _alone(part):
            definition = self.define(part, "x")
        values: dict[str, tree.Expression | None] = {}
        open_: list[tree.ComponentDeclaration] = []
        for declared in definition.components:
            if "parameter" in declared.prefixes and isinstance(
                declared.value, tree.NumberLiteral | tree.NumberArray
            ):
                values[declared.name] = declared.value
                declared = _replaced(declared, value=None)
            open_.append(declared)
        key = f"{_class_title(part)}\n"
        key += format_class(_replaced(definition, components=tuple(open_)))
        known = self._by_text.get(key)
        if known is None:
            name = self._fresh(_class_title(part))
            self._by_text[key] = (name, values)
            self.add(_replaced(definition, name=name))
            changes: tuple[tree.Modifier, ...] = ()
        else:
            name, defaults = known
            array = bool(part._shape)
            changes = tuple(
                tree.Modifier(span, (n,), v, (), array)
                for n, v in values.items()
                if v is not None and not _same(v, defaults[n])
            )
        return tree.Reference(span, (tree.NamePart(span, name),)), changes

    # --- definitions ----------------------------------------------------------------------

    def define(self, part: Component, name: str) -> tree.ClassDefinition:
        """Return the class of one component."""
        return _Definition(self, part).make(name)

    def outers(self, definition: ClassDef | Builtin) -> frozenset[str]:
        """Return the names of ``outer`` components that a class needs from outside."""
        found = self._outers.get(definition)
        if found is not None:
            return found
        if isinstance(definition, Builtin) or primitive_type(definition) is not None:
            return frozenset()
        self._outers[definition] = frozenset()
        needed: set[str] = set()
        own: set[str] = set()
        for name, element in merge(definition).elements.items():
            if element.has("inner"):
                own.add(name)
            if element.has("outer"):
                needed.add(name)
            else:
                needed |= self.outers(type_of(element))
        found = self._outers[definition] = frozenset(needed - own)
        return found


class _Definition:
    """The scope of one class that is being written."""

    def __init__(self, assembly: Assembly, part: Component) -> None:
        self.assembly = assembly
        self.self = part
        self.cls: ComponentType = type(part)
        #: Parts of names, by place and name.
        self.name_parts: dict[tuple[int, str], tree.NamePart] = {}

    def class_reference(self, what: object, span: Span) -> tree.Reference:
        """Return the name of a class."""
        return self.assembly.class_reference(what, span)

    def path(self, part: Part, span: Span) -> list[str]:
        """Return the names that lead from here to a part.

        Raises:
            AcausalError: ``N155`` for a part of another model or of none.
        """
        here_ = self.self
        if part is here_:
            return []
        if part._owner is here_:
            return [part._name]
        names: list[str] = []
        where: Any = part
        while where is not here_:
            owner = where._owner
            if owner is None:
                self._stranger(part, where, span)
            names.append(where._name)
            if isinstance(owner, type):
                if self.cls._declared.get(where._name) is None or not issubclass(self.cls, owner):
                    self._stranger(part, where, span)
                break
            where = owner
        return names[::-1]

    def _stranger(self, part: Part, where: Any, span: Span) -> None:
        title = self.self._title
        labels = [Label(part._span, "made here")] if part._span != span else []
        if part._owner is None:
            fail("N155", f"{part._kind.title} is used in {title} and is no part of it", span,
                 labels=labels,
                 help=f"assign it to the model first: {title}.name = ...")  # fmt: skip
        outermost = where._owner if isinstance(where._owner, type) else where
        owner = owner_name(outermost)
        owner = "another model" if owner == title else owner
        fail("N155", f"{part!r} belongs to {owner}, not to {title}", span,
             labels=labels,
             help="use parts of this model only; a model is joined to others through "
             "cuts of its own")  # fmt: skip

    def make(self, name: str) -> tree.ClassDefinition:
        """Return the class."""
        with asked(self.self):
            return self._make(name)

    def _make(self, name: str) -> tree.ClassDefinition:
        part, cls, span = self.self, self.cls, self.self._span
        # Equations may add parts and connections, so they come first.
        equations = self._stated(part.equations(), span)
        initials = self._stated(part.initial_equations(), span)
        parts: dict[str, Part] = {**cls._declared, **(part._parts or {})}
        stated = [e._equation(self, text) for e, text in part._equations or ()]
        first = [e._equation(self, text) for e, text in part._initials or ()]
        components = self._components(parts)
        description = part._about if part._owner is None else ""
        if not description and cls.__module__.partition(".")[0] != "acausal":
            description = _first_line(cls.__dict__.get("__doc__"))
        return tree.ClassDefinition(
            span,
            cls._restriction,
            name,
            description=description,
            extends=tuple(self._extends(b) for b in cls._text_bases),
            components=tuple(components),
            equations=(*equations, *stated, *self._connects()),
            initial_equations=(*initials, *first),
            annotation=self._annotation(),
        )

    def _stated(self, given: Iterable[Any] | None, span: Span) -> list[tree.Equation]:
        if given is None:
            return []
        if not isinstance(given, Iterable):
            given = (given,)
        return [e._equation(self) for e in equations_of(given, span)]

    def _connects(self) -> list[tree.Equation]:
        result: list[tree.Equation] = []
        for cuts, span in self.self._connections or ():
            found = tuple([self._cut(c, span) for c in cuts])
            result.append(tree.ConnectEquation(span, "", found))
        return result

    def _cut(self, cut: Any, span: Span) -> tree.Reference:
        """Return a cut as syntax; the usual one, without subscripts, in a hurry."""
        if not isinstance(cut, Reference):
            return part_reference(cut, self, span)
        root, steps = cut._root, cut._steps
        if root._owner is not self.self or len(steps) != 1 or steps[0][1] or not steps[0][0]:
            return reference(cut, self, span)
        known, place = self.name_parts, id(span)
        found = []
        for name in (root._name, steps[0][0]):
            part = known.get((place, name))
            if part is None:
                part = known[place, name] = tree.NamePart(span, name)
            found.append(part)
        return tree.Reference(span, tuple(found))

    def _extends(self, base: ClassDef) -> tree.ExtendsClause:
        span = self.self._span
        kind = text_kind(base)
        changes = []
        for name, (value, where) in self.cls._overrides.items():
            if kind.member(name) is not None:
                made = modifier(kind, name, value, 0, where)
                changes.append(made.modifier(self) if isinstance(made, Pending) else made)
        return tree.ExtendsClause(span, self.class_reference(base, span), tuple(changes))

    def _components(self, parts: dict[str, Part]) -> list[tree.ComponentDeclaration]:
        result: list[tree.ComponentDeclaration] = []
        maybe_inner: dict[str, int] = {}
        used: dict[ClassDef | Builtin, None] = {}
        classes: dict[str, ClassDef] = self.assembly.scope.classes
        for name, part in parts.items():
            if isinstance(part, Declaration):
                result.append(part._declaration(self))
                continue
            assert isinstance(part, Component)
            span = part._span
            type_name, changes = self.assembly.class_of(part)
            used[type(part)._definition or classes[type_name.parts[0].name]] = None
            modifiers = part._modifiers
            for m in modifiers:
                if isinstance(m, Pending):
                    modifiers = tuple(
                        x.modifier(self) if isinstance(x, Pending) else x for x in modifiers
                    )
                    break
            if changes:
                set_already = {m.name[0] for m in modifiers}
                modifiers = (*(c for c in changes if c.name[0] not in set_already), *modifiers)
            if part._inner is None:
                maybe_inner[name] = len(result)
            result.append(
                tree.ComponentDeclaration(
                    span,
                    name,
                    type_name,
                    tuple([size_tree(s, self, part) for s in part._shape]) if part._shape else (),
                    modifiers,
                    None,
                    None,
                    ("inner",) if part._inner else (),
                    True,
                    part._about,
                )
            )
        # A component that another one asks for by its name is the one that is meant.
        for definition in used:
            for name in self.assembly.outers(definition):
                if name in maybe_inner and name not in self.assembly.outers(
                    self._definition_of(parts[name])
                ):
                    at = maybe_inner.pop(name)
                    result[at] = _replaced(result[at], prefixes=("inner",))
        return result

    def _definition_of(self, part: Part) -> ClassDef | Builtin:
        assert isinstance(part, Component)
        own = type(part)._definition
        if own is not None:
            return own
        name = self.assembly.class_of(part)[0].parts[0].name
        return self.assembly.scope.classes[name]

    def _annotation(self) -> tree.Annotation | None:
        given: dict[str, float] = getattr(self.self, "_experiment", {})
        if not given:
            return None
        span = self.self._span
        values = tuple(
            tree.Modifier(span, (name,), tree.NumberLiteral(span, value))
            for name, value in given.items()
        )
        return tree.Annotation(span, (tree.Modifier(span, ("experiment",), None, values),))


def _class_title(part: Component) -> str:
    return str(getattr(part, "_model_name", "") or type(part).__name__)


def _first_line(text: str | None) -> str:
    return (text or "").strip().split("\n")[0].rstrip(".")


@contextmanager
def _alone(part: Component) -> Iterator[None]:
    """Look at a component from inside, where it is no array."""
    shape = part._shape
    _without_shape(part)
    try:
        yield
    finally:
        describe(part, shape, None, "")


def _without_shape(part: Component) -> None:
    Part.__dict__["_shape"].__set__(part, ())


def _same(a: tree.Expression, b: tree.Expression | None) -> bool:
    if isinstance(a, tree.NumberLiteral) and isinstance(b, tree.NumberLiteral):
        return (a.value, a.unit) == (b.value, b.unit)
    if isinstance(a, tree.NumberArray) and isinstance(b, tree.NumberArray):
        return (a.data, a.shape, a.unit) == (b.data, b.shape, b.unit)
    return False


def _replaced(node: Any, **changes: Any) -> Any:
    from dataclasses import replace

    return replace(node, **changes)


__all__ = ["Assembly", "Literal", "model_definition", "model_text", "shared_library"]
