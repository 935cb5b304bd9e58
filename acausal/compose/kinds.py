"""What is known about classes in Python: their members, and what these are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

from acausal.instantiation.merge import Element, PrimitiveType, merge, primitive_type, type_of
from acausal.modeling.classes import Builtin, ClassDef
from acausal.syntax import tree

if TYPE_CHECKING:
    from acausal.compose.parts import Part

#: What can be set on a variable besides its value.
ATTRIBUTES = ("start", "fixed", "min", "max", "nominal", "stateSelect", "unit", "displayUnit",
              "quantity")  # fmt: skip

#: Path of a variable in a cut -> whether it is a through variable, and its base type.
Signature = dict[tuple[str, ...], tuple[bool, str]]


@dataclass(frozen=True, slots=True, eq=False)
class Member:
    """A component of a class.

    Attributes:
        kind: What it is.
        dimensions: Array dimensions; None for one that is not known in Python.
        role: ``parameter``, ``constant``, or empty.
    """

    kind: Kind
    dimensions: tuple[int | None, ...] = ()
    role: str = ""


class Kind(Protocol):
    """A class of the language, wherever it is written."""

    @property
    def title(self) -> str:
        """Its name in messages."""

    @property
    def primitive(self) -> str:
        """``Real``, ``Integer``, ...; empty for a class with members."""

    @property
    def is_connector(self) -> bool:
        """Whether it is a cut."""

    def member(self, name: str) -> Member | None:
        """Return a member by name."""

    def names(self) -> list[str]:
        """Return the names of all members."""

    def signature(self) -> Signature:
        """Return what the cut carries."""


class TextKind:
    """A class or predefined type of the language."""

    def __init__(self, definition: ClassDef | Builtin) -> None:
        self.definition = definition
        self._members: dict[str, Member] = {}
        self._signature: Signature | None = None

    def __deepcopy__(self, memo: object) -> TextKind:
        return self

    @property
    def title(self) -> str:
        """Full name."""
        return self.definition.full_name

    @cached_property
    def type(self) -> PrimitiveType | None:
        """The predefined type it is another name of."""
        return primitive_type(self.definition)

    @cached_property
    def primitive(self) -> str:
        """Name of the predefined type."""
        return "" if self.type is None else self.type.base

    @cached_property
    def is_connector(self) -> bool:
        """Whether it is a cut."""
        if isinstance(self.definition, Builtin):
            return False
        return self.definition.kind == "connector"

    @cached_property
    def elements(self) -> dict[str, Element]:
        """All components, inherited ones first."""
        if isinstance(self.definition, Builtin) or self.type is not None:
            return {}
        return merge(self.definition).elements

    def member(self, name: str) -> Member | None:
        """Return a member by name."""
        found = self._members.get(name)
        if found is None:
            element = self.elements.get(name)
            if element is None:
                return None
            kind = text_kind(type_of(element))
            dimensions: list[int | None] = [_size(d) for d in element.declaration.dimensions]
            if kind.type is not None:
                dimensions += [_size(d) for d, _ in kind.type.dimensions]
            role = next((r for r in ("parameter", "constant") if element.has(r)), "")
            found = self._members[name] = Member(kind, tuple(dimensions), role)
        return found

    def names(self) -> list[str]:
        """Return the names of all members that are not protected."""
        return [n for n, e in self.elements.items() if e.declaration.public]

    def signature(self) -> Signature:
        """Return what the cut carries."""
        if self._signature is None:
            found: Signature = {}
            if self.primitive:
                found[()] = (False, self.primitive)
            for name, element in self.elements.items():
                member = self.member(name)
                if member is None or member.role:
                    continue
                through = element.has("through") or element.has("flow")
                for path, (inside, base) in member.kind.signature().items():
                    found[(name, *path)] = (through or inside, base)
            self._signature = found
        return self._signature


def _size(dimension: tree.Expression) -> int | None:
    if isinstance(dimension, tree.NumberLiteral) and dimension.integer:
        return int(dimension.value)
    return None


_kinds: dict[ClassDef | Builtin, TextKind] = {}


def text_kind(definition: ClassDef | Builtin) -> TextKind:
    """Return what is known about a class of the language; always the same object."""
    found = _kinds.get(definition)
    if found is None:
        found = _kinds[definition] = TextKind(definition)
    return found


class PythonKind:
    """A class that is written in Python, or one instance with parts of its own."""

    primitive = ""

    def __init__(self, cls: Any, parts: dict[str, Part] | None, title: str) -> None:
        self._class = cls
        self._parts = parts
        self._title = title

    @property
    def title(self) -> str:
        """Name of the Python class or model."""
        return self._title

    @property
    def is_connector(self) -> bool:
        """Whether it is a cut."""
        return bool(self._class._restriction == "connector")

    def member(self, name: str) -> Member | None:
        """Return a member by name: own, declared in the class, or inherited."""
        part = self._parts.get(name) if self._parts else None
        if part is None:
            part = self._class._declared.get(name)
        if part is not None:
            return part._member
        for base in self._class._text_bases:
            found = text_kind(base).member(name)
            if found is not None:
                return found
        return None

    def names(self) -> list[str]:
        """Return the names of all members."""
        result = [n for b in self._class._text_bases for n in text_kind(b).names()]
        return list(dict.fromkeys([*result, *self._class._declared, *(self._parts or ())]))

    def signature(self) -> Signature:
        """Return what the cut carries."""
        found: Signature = {}
        for base in self._class._text_bases:
            found |= text_kind(base).signature()
        for name, part in {**self._class._declared, **(self._parts or {})}.items():
            if part._member.role:
                continue
            through = getattr(part, "_through", False)
            for path, (inside, base_type) in part._member.kind.signature().items():
                found[(name, *path)] = (through or inside, base_type)
        return found
