"""Parameters, constants and variables that are declared in Python."""

from __future__ import annotations

from typing import Any

from acausal.compose.kinds import Kind, text_kind
from acausal.compose.modifiers import Pending, attribute_modifier, value_of
from acausal.compose.parts import Part, describe, modify
from acausal.compose.symbols import Scope, Symbolic
from acausal.diagnostics import fail
from acausal.modeling.classes import BUILTIN_TYPES, Builtin, ClassDef, _builtins
from acausal.syntax import tree

_PYTHON_TYPES: dict[Any, str] = {float: "Real", int: "Integer", bool: "Boolean", str: "String"}


class Declaration(Part):
    """A parameter, constant or variable; see :class:`Parameter` and :class:`Variable`."""

    __slots__ = ("_through", "_type", "_value")

    _type: ClassDef | Builtin
    _value: Symbolic | None
    #: A through variable of a connector.
    _through: bool

    @property
    def _prefixes(self) -> tuple[str, ...]:
        return ()

    def __init__(
        self,
        value: Any = None,
        unit: str = "",
        description: str = "",
        type: Any = None,  # noqa: A002 - what it is
        shape: Any = (),
        **attributes: Any,
    ) -> None:
        self._type = type_named(type, value, self)
        self._through = False
        sizes = shape_of(shape, self)
        describe(self, sizes, None, description)
        depth = len(sizes)
        if unit:
            attributes = {"unit": unit, **attributes}
        names = {"state_select": "stateSelect", "display_unit": "displayUnit"}
        known = ("start", "fixed", "min", "max", "nominal", "stateSelect", "unit", "displayUnit",
                 "quantity")  # fmt: skip
        made = []
        member = self._member
        for name, given in attributes.items():
            if given is None:
                continue
            attribute = names.get(name, name)
            if attribute not in known:
                from acausal.compose.mistakes import unknown_name

                unknown_name("N103", f"a variable has no attribute {name}", self._span, name,
                             [*known, *names], f"it has {', '.join(known)}")  # fmt: skip
            wanted = None if attribute == "fixed" else member
            made.append(attribute_modifier(attribute, given, depth, self._span, wanted))
        modify(self, tuple(made))
        self._value = None if value is None else value_of(member, value, self._span)

    @property
    def _kind(self) -> Kind:
        return text_kind(self._type)

    def _copy(self, value: Any) -> Declaration:
        """Return the same declaration with another value, for another class."""
        twin: Declaration = type(self).__new__(type(self))
        twin._type, twin._through = self._type, self._through
        describe(twin, self._shape, self._inner, self._about)
        modify(twin, self._modifiers)
        twin._value = value_of(twin._member, value, twin._span)
        return twin

    def _declaration(self, scope: Scope) -> tree.ComponentDeclaration:
        span = self._span
        base = self._type
        name = (
            tree.Reference(span, (tree.NamePart(span, base.name),))
            if isinstance(base, Builtin)
            else scope.class_reference(base, span)
        )
        value = None
        if self._value is not None:
            value = self._value._tree(scope, span)
            if self._shape and self._value._ndim == 0:
                sizes = tuple(size_tree(s, scope, self) for s in self._shape)
                fill = tree.Reference(span, (tree.NamePart(span, "fill"),))
                value = tree.Call(span, fill, (value, *sizes))
        modifiers = (m.modifier(scope) if isinstance(m, Pending) else m for m in self._modifiers)
        return tree.ComponentDeclaration(
            span,
            self._name,
            name,
            tuple(size_tree(s, scope, self) for s in self._shape),
            tuple(modifiers),
            value,
            None,
            self._prefixes,
            True,
            self._about,
        )


class Parameter(Declaration):
    """A value that does not change during a simulation.

    Args:
        value: A number in SI units, a text with a unit (``"10[kOhm]"``), a quantity of pint, an
            array, an expression of other parameters, ``True``/``False``, a member of an
            enumeration. Without one, whoever uses the class has to give it.
        unit: Unit, such as ``"N.m/rad"``; values with another one are refused.
        description: What it means.
        type: ``float``, ``int``, ``bool``, ``str``, a type of the library (``si.Mass``) or an
            enumeration; from the value if it is not given. An ``int`` alone is taken as Real.
        shape: Sizes of an array: a number, a parameter, or a tuple of them.
        attributes: ``min``, ``max``, ``nominal``, ``start``, ``fixed``.

    Integer, Boolean and enumeration parameters decide the structure and are fixed when the model
    is compiled.

    Example:
        >>> import acausal as ac
        >>> circuit = ac.Model("circuit")
        >>> circuit.R = ac.Parameter(100, unit="Ohm", description="load")
    """

    __slots__ = ()

    @property
    def _role(self) -> str:
        return "parameter"

    @property
    def _prefixes(self) -> tuple[str, ...]:
        return ("parameter",)


class Constant(Declaration):
    """A value that never changes, see :class:`Parameter`."""

    __slots__ = ()

    @property
    def _role(self) -> str:
        return "constant"

    @property
    def _prefixes(self) -> tuple[str, ...]:
        return ("constant",)


class Variable(Declaration):
    """An unknown of the model.

    Args:
        value: An expression that it always equals; None if equations determine it.
        unit: Unit, such as ``"m/s2"``.
        description: What it means.
        type: ``float``, ``int``, ``bool``, a type of the library or an enumeration.
        shape: Sizes of an array: a number, a parameter, or a tuple of them.
        attributes: ``start``, ``fixed``, ``min``, ``max``, ``nominal``, ``state_select``
            (``"never"``, ``"avoid"``, ``"default"``, ``"prefer"``, ``"always"``).

    Example:
        >>> import acausal as ac
        >>> x = ac.Variable(unit="m", start=1, fixed=True)
    """

    __slots__ = ()


class Discrete(Variable):
    """A Real variable that changes at events only, set by ``ac.when``; see :class:`Variable`."""

    __slots__ = ()

    @property
    def _prefixes(self) -> tuple[str, ...]:
        return ("discrete",)


class Through(Variable):
    """A variable of a connector whose values add up to zero at a junction."""

    __slots__ = ()

    def __init__(self, unit: str = "", description: str = "", **options: Any) -> None:
        super().__init__(None, unit, description, **options)
        self._through = True

    @property
    def _prefixes(self) -> tuple[str, ...]:
        return ("through",)


class Across(Variable):
    """A variable of a connector that is equal at a junction."""

    __slots__ = ()

    def __init__(self, unit: str = "", description: str = "", **options: Any) -> None:
        super().__init__(None, unit, description, **options)

    @property
    def _prefixes(self) -> tuple[str, ...]:
        return ("across",)


def type_named(given: Any, value: Any, part: Part) -> ClassDef | Builtin:
    """Return the type that is meant, from the value if none is named.

    Raises:
        AcausalError: ``T155`` for what is no type.
    """
    definition = getattr(given, "_definition", given)
    if isinstance(definition, ClassDef | Builtin):
        if text_kind(definition).primitive:
            return definition
    elif given in _PYTHON_TYPES:
        return _builtins[_PYTHON_TYPES[given]]
    elif isinstance(given, str) and given in BUILTIN_TYPES:
        return _builtins[given]
    elif given is None:
        enumeration = getattr(value, "_home", None)
        if isinstance(enumeration, ClassDef):
            return enumeration
        if isinstance(value, bool):
            return _builtins["Boolean"]
        if isinstance(value, str) and not _is_number(value):
            return _builtins["String"]
        return _builtins["Real"]
    fail("T155", f"{given!r} is no type of a variable", part._span,
         help="use float, int, bool, str, a type such as si.Mass, or an enumeration")  # fmt: skip


def _is_number(text: str) -> bool:
    from acausal.compose.numbers import _NUMBER, _WITH_UNIT

    return bool(_NUMBER.match(text) or _WITH_UNIT.match(text))


def shape_of(shape: Any, part: Part) -> tuple[Any, ...]:
    """Return array sizes as a tuple of integers and expressions.

    Raises:
        AcausalError: ``T122`` for what is no size.
    """
    given = shape if isinstance(shape, tuple | list) else (shape,)
    result: list[Any] = []
    for size in given:
        if isinstance(size, Symbolic):
            result.append(size)
            continue
        try:
            whole = -1 if isinstance(size, bool) else int(size)
            good = whole >= 0 and whole == size
        except (TypeError, ValueError):
            good = False
        if not good:
            fail("T122", f"{size!r} is no size of an array", part._span,
                 help="a shape is a whole number, or a tuple of them: shape=(2, 3)")  # fmt: skip
        result.append(whole)
    return tuple(result)


def size_tree(size: Any, scope: Scope, part: Part) -> tree.Expression:
    """Return one array size as syntax."""
    if isinstance(size, int):
        return tree.NumberLiteral(part._span, float(size), True)
    return size._tree(scope, part._span)  # type: ignore[no-any-return]
