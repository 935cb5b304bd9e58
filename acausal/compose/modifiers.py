"""Keyword arguments become modifiers: values, nested modifiers, arrays for arrays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NoReturn

from acausal.compose.kinds import ATTRIBUTES, Kind, Member
from acausal.compose.mistakes import unknown_name
from acausal.compose.symbols import GlobalName, Literal, Scope, Symbolic
from acausal.diagnostics import Span, fail
from acausal.syntax import tree
from acausal.syntax.tree import BooleanLiteral, Modifier, NumberLiteral, StringLiteral


class Nested:
    """Modifiers of what is inside, perhaps with a value: what :func:`mod` returns."""

    __slots__ = ("items", "value")

    def __init__(self, value: Any, items: Mapping[str, Any]) -> None:
        self.value = value
        self.items = dict(items)


def mod(value: Any = None, /, **modifiers: Any) -> Nested:
    """Return nested modifiers, with or without a value.

    Args:
        value: The value of a parameter or variable; None to leave it as it is.
        modifiers: Attributes of a variable (``start``, ``fixed``, ``min``, ``max``, ``nominal``,
            ``stateSelect``, ``unit``) or parameters and variables of a component.

    Example:
        >>> from acausal.library import electrical as el
        >>> capacitor = el.Capacitor(C=1e-6, v=mod(start=5, fixed=True))
    """
    return Nested(value, modifiers)


class Pending:
    """A modifier whose value refers to other parts; it becomes syntax with its model."""

    __slots__ = ("each", "name", "nested", "span", "value")

    def __init__(
        self,
        span: Span,
        name: str,
        value: Symbolic | None,
        nested: tuple[Modifier | Pending, ...],
        each: bool,
    ) -> None:
        self.span = span
        self.name = name
        self.value = value
        self.nested = nested
        self.each = each

    def modifier(self, scope: Scope) -> Modifier:
        """Return the syntax."""
        return Modifier(
            self.span,
            (self.name,),
            None if self.value is None else self.value._tree(scope, self.span),
            tuple(m.modifier(scope) if isinstance(m, Pending) else m for m in self.nested),
            self.each,
        )


def modifier(kind: Kind, name: str, value: Any, array: int, span: Span) -> Modifier | Pending:
    """Return a keyword argument as a modifier.

    Args:
        kind: The class that is modified.
        name: Name of a member; Python's reserved words have a ``_`` behind them.
        value: What it is given.
        array: Array dimensions of the components that are modified.
        span: The place.

    Raises:
        AcausalError: ``N103`` for an unknown name, and for all mistakes in values.
    """
    usual = type(value) is float or type(value) is int or type(value) is bool
    if usual:
        known = _known.get((id(span), name, type(value), value or repr(value), array))
        if known is not None and known[0] is span and known[1] is kind:
            return known[2]
    made = _modifier(kind, name, value, array, span)
    if usual and len(_known) < _MOST_KNOWN and isinstance(made, Modifier):
        _known[id(span), name, type(value), value or repr(value), array] = (span, kind, made)
    return made


#: Modifiers by place, name and number: loops make the same ones again and again.
_known: dict[tuple[Any, ...], tuple[Span, Kind, Modifier]] = {}
_MOST_KNOWN = 5000


def _modifier(kind: Kind, name: str, value: Any, array: int, span: Span) -> Modifier | Pending:
    member = kind.member(name)
    if member is None:
        if name.endswith("_") and kind.member(name[:-1]) is not None:
            return modifier(kind, name[:-1], value, array, span)
        _unknown(kind, name, span)
    # The usual case, first: a number for a scalar parameter.
    if type(value) is float and not array and value - value == 0.0:
        return Modifier(span, (name,), NumberLiteral(span, value))
    return _member_modifier(member, name, value, array, span)


def _unknown(kind: Kind, name: str, span: Span) -> NoReturn:
    parameters = [n for n in kind.names() if (m := kind.member(n)) is not None and m.role]
    unknown_name(
        "N103", f"{kind.title} has nothing called {name}", span, name, kind.names(),
        f"its parameters are {', '.join(parameters[:12])}" if parameters
        else f"{kind.title} has no parameters",
    )  # fmt: skip


def _member_modifier(
    member: Member, name: str, value: Any, array: int, span: Span
) -> Modifier | Pending:
    if isinstance(value, dict):
        value = Nested(None, value)
    if isinstance(value, Nested):
        depth = array + len(member.dimensions)
        nested = tuple(
            _attribute(member, name, key, inside, depth, span)
            if member.kind.primitive
            else modifier(member.kind, key, inside, depth, span)
            for key, inside in value.items.items()
        )
        own = None if value.value is None else value_of(member, value.value, span)
        return _made(span, name, own, nested, array, len(member.dimensions))
    own = value_of(member, value, span)
    return _made(span, name, own, (), array, len(member.dimensions))


def _attribute(
    member: Member, owner: str, name: str, value: Any, depth: int, span: Span
) -> Modifier | Pending:
    name = {"state_select": "stateSelect", "display_unit": "displayUnit"}.get(name, name)
    if name not in ATTRIBUTES:
        unknown_name("N103", f"{owner} has no attribute {name}", span, name, ATTRIBUTES,
                     f"a variable has {', '.join(ATTRIBUTES)}")  # fmt: skip
    usual = type(value) is float or type(value) is int or type(value) is bool
    if usual:
        known = _known.get((id(span), owner, name, type(value), value or repr(value), depth))
        if known is not None and known[0] is span and known[1] is member.kind:
            return known[2]
    made = attribute_modifier(name, value, depth, span, member)
    if usual and len(_known) < _MOST_KNOWN and isinstance(made, Modifier):
        _known[id(span), owner, name, type(value), value or repr(value), depth] = (
            span,
            member.kind,
            made,
        )
    return made


def attribute_modifier(
    name: str, value: Any, depth: int, span: Span, member: Member | None = None
) -> Modifier | Pending:
    """Return ``start``, ``fixed``, ... of a variable as a modifier."""
    if name in ("unit", "displayUnit", "quantity"):
        if not isinstance(value, str):
            fail("U104", f"{value!r} is not a unit", span, help='write it as a text: "N.m/rad"')
        if name == "unit" and value:
            from acausal.compose.numbers import check_unit

            check_unit(value, span)
        return Modifier(span, (name,), StringLiteral(span, value), (), depth > 0)
    if name == "stateSelect" and isinstance(value, str):
        own: Symbolic = GlobalName(("StateSelect", value))
    else:
        own = value_of(member, value, span)
    return _made(span, name, own, (), depth, 0)


def _made(
    span: Span,
    name: str,
    value: Symbolic | None,
    nested: tuple[Modifier | Pending, ...],
    array: int,
    own: int,
) -> Modifier | Pending:
    """Return a modifier; one value for an array of components is each component's value."""
    each = bool(array) and (value is None or value._ndim <= own)
    each = each and value is not None
    fixed = value is None or isinstance(value, Literal)
    if fixed and all(isinstance(m, Modifier) for m in nested):
        node = None if value is None else value._node  # type: ignore[attr-defined]
        return Modifier(span, (name,), node, nested, each)  # type: ignore[arg-type]
    return Pending(span, name, value, nested, each)


def value_of(member: Member | None, value: Any, span: Span) -> Symbolic:
    """Return a value for a member: texts are texts where a text is wanted, else expressions.

    Raises:
        AcausalError: ``T152``, ``T153``, ``T154``, ``U104``.
    """
    base = "" if member is None else member.kind.primitive
    if base == "String":
        if isinstance(value, str):
            return Literal(StringLiteral(span, value))
        if isinstance(value, list | tuple) and all(isinstance(v, str) for v in value):
            texts = tuple(StringLiteral(span, v) for v in value)
            return Literal(tree.ArrayLiteral(span, texts), 1)
    if base == "Boolean" and isinstance(value, bool):
        return Literal(BooleanLiteral(span, value))
    if isinstance(value, Symbolic):
        from acausal.compose.component import Component

        return value._constructor() if isinstance(value, Component) else value
    if isinstance(value, int) and not isinstance(value, bool) and base == "Real":
        return Literal(NumberLiteral(span, float(value), True))
    from acausal.compose.numbers import symbolic_value

    return symbolic_value(value, span)
