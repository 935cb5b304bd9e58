"""Classes of the language as Python objects: component classes, types, enumerations, functions."""

from __future__ import annotations

from typing import Any

import numpy as np

from acausal.compose.component import Component, ComponentType, Connector
from acausal.compose.declarations import Variable
from acausal.compose.documentation import describe_class
from acausal.compose.kinds import text_kind
from acausal.compose.mistakes import unknown_name
from acausal.compose.places import here
from acausal.compose.symbols import GlobalName, Invocation, Scope, Symbolic, operand
from acausal.diagnostics import Span, fail
from acausal.modeling.classes import ClassDef
from acausal.modeling.classes import Constant as ClassConstant
from acausal.syntax import tree

_made: dict[ClassDef, Any] = {}


def python_object(found: Any, module: str) -> Any:
    """Return a class or constant of the language as Python sees it; always the same object.

    Args:
        found: The class definition or constant.
        module: Name of the module it appears in.
    """
    if isinstance(found, ClassConstant):
        return PackageConstant(found)
    known = _made.get(found)
    if known is None:
        known = _made[found] = _object(found, module)
    return known


def _object(definition: ClassDef, module: str) -> Any:
    if definition.kind == "package":
        from acausal.compose.packages import ClassPackage

        return ClassPackage(definition, module)
    if definition.kind == "function":
        return TextFunction(definition)
    if definition.tree.enumeration is not None:
        return Enumeration(definition)
    if text_kind(definition).primitive and definition.kind != "connector":
        inner = text_kind(definition).type
        if inner is not None and inner.enumeration is not None:
            return python_object(inner.enumeration, module)
        return TextType(definition)
    bases = (Connector,) if definition.kind == "connector" else (Component,)
    return ComponentType(
        definition.name,
        bases,
        {
            "__slots__": (),
            "__module__": module,
            "__qualname__": definition.name,
            "__doc__": describe_class(definition),
            "_definition": definition,
            "_restriction": definition.kind,
        },
    )


class _Described:
    """Something of the language with a description."""

    def __init__(self, definition: ClassDef) -> None:
        self._definition = definition
        self.__name__ = definition.name
        self.__doc__ = describe_class(definition)

    def __repr__(self) -> str:
        return f"<{self._definition.kind} {self._definition.full_name}>"


class TextType(_Described):
    """A type such as ``si.Mass``: for ``ac.Variable(type=si.Mass)``, or called, a variable."""

    def __call__(self, value: Any = None, **options: Any) -> Variable:
        """Return a variable of the type, see :class:`acausal.Variable`."""
        return Variable(value, type=self, **options)


class Enumeration(_Described):
    """An enumeration; its members are attributes."""

    def __getattr__(self, name: str) -> Symbolic:
        if name[0] == "_":
            raise AttributeError(name)
        names = [n for n, _ in self._definition.tree.enumeration or ()]
        if name not in names:
            unknown_name("N102", f"{self.__name__} has no value {name}", here(), name, names,
                         f"its values are {', '.join(names)}")  # fmt: skip
        return GlobalName((name,), self._definition)

    def __dir__(self) -> list[str]:
        return [n for n, _ in self._definition.tree.enumeration or ()]


class TextFunction(_Described):
    """A function of the library; called, it makes an expression."""

    def __call__(self, *arguments: Any, **named: Any) -> Symbolic:
        """Return a call of the function."""
        span = here()
        outputs = [c for c in self._definition.tree.components if "output" in c.prefixes]
        dimensions = len(outputs[0].dimensions) if outputs else 0
        return Invocation(
            self._definition,
            tuple(operand(a, span) for a in arguments),
            span,
            [(n, operand(v, span)) for n, v in named.items()],
            dimensions,
        )


class PackageConstant(Symbolic):
    """A constant of a package, such as ``constants.pi``; ``float`` gives its number."""

    __slots__ = ("_found",)

    def __init__(self, found: ClassConstant) -> None:
        self._found = found

    def _tree(self, scope: Scope, span: Span) -> tree.Expression:
        home = scope.class_reference(self._found.owner, span)
        name = tree.NamePart(span, self._found.declaration.name)
        return tree.Reference(span, (*home.parts, name), home.absolute)

    def __float__(self) -> float:
        from acausal.instantiation.elaborate import constant_of_class
        from acausal.instantiation.values import constants

        numbers = constants(constant_of_class(self._found, 0))
        if numbers is None or np.ndim(numbers):
            fail("T151", f"{self!r} is no single number", here(), help="use it in an expression")
        return float(numbers)
