"""Parts of models and references to what is inside them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NoReturn, cast

import numpy as np

from acausal.compose.kinds import Kind, Member
from acausal.compose.mistakes import unknown_name
from acausal.compose.places import here
from acausal.compose.symbols import Literal, Operation, Scope, Symbolic, operand
from acausal.diagnostics import Label, Span, fail
from acausal.syntax import tree

#: One subscript for each dimension that is given.
Subscripts = tuple[Symbolic, ...]
#: Names below a part with their subscripts; the first stands for the part itself, without a name.
Steps = tuple[tuple[str, Subscripts], ...]


class Part(Symbolic):
    """Something that is declared in a class: a component, parameter or variable.

    A part belongs to nobody until it is assigned to a model, and then to that model alone.
    """

    __slots__ = ("_about", "_inner", "_modifiers", "_name", "_owner", "_shape", "_span")

    _name: str
    _owner: Any
    _span: Span
    _shape: tuple[Any, ...]
    _modifiers: tuple[Any, ...]
    _inner: bool | None
    _about: str

    def __new__(cls, *args: Any, **options: Any) -> Any:
        """Note the place; users' classes may forget to call our constructor."""
        self = object.__new__(cls)
        _set_name(self, "")
        _set_owner(self, None)
        _set_span(self, here())
        _set_shape(self, ())
        _set_modifiers(self, ())
        _set_inner(self, None)
        _set_about(self, "")
        return self

    def __set_name__(self, owner: type, name: str) -> None:
        adopt(self, owner, name)

    def __get__(self, instance: Any, owner: type | None = None) -> Any:
        """Return the part of an instance, where the part is declared in a class."""
        if instance is None:
            return self
        return Ref(instance, single_step(self._name), self._member)

    @property
    def _kind(self) -> Kind:
        raise NotImplementedError

    @property
    def _role(self) -> str:
        return ""

    @property
    def _member(self) -> Member:
        sizes = (s if isinstance(s, int) else None for s in self._shape)
        return Member(self._kind, tuple(sizes), self._role)

    @property
    def _ndim(self) -> int:
        return len(self._shape)

    def _tree(self, scope: Scope, span: Span) -> tree.Expression:
        return part_reference(self, scope, span)

    def __getitem__(self, index: Any) -> Ref:
        member = self._member
        given, dimensions = subscripts(index, member.dimensions, self)
        return Ref(self, (("", given),), Member(member.kind, dimensions, member.role))

    def __len__(self) -> int:
        return length(self, self._member.dimensions)

    def __iter__(self) -> Iterator[Any]:
        return elements(self, self._member.dimensions)


_set_name = cast(Any, Part.__dict__["_name"]).__set__
_set_owner = cast(Any, Part.__dict__["_owner"]).__set__
_set_span = cast(Any, Part.__dict__["_span"]).__set__
_set_shape = cast(Any, Part.__dict__["_shape"]).__set__
_set_modifiers = cast(Any, Part.__dict__["_modifiers"]).__set__
_set_inner = cast(Any, Part.__dict__["_inner"]).__set__
_set_about = cast(Any, Part.__dict__["_about"]).__set__


def describe(part: Part, shape: tuple[Any, ...], inner: bool | None, about: str) -> None:
    """Set what the constructor of a part is given besides its modifiers."""
    if shape:
        _set_shape(part, shape)
    if inner is not None:
        _set_inner(part, inner)
    if about:
        _set_about(part, about)


def modify(part: Part, modifiers: tuple[Any, ...]) -> None:
    """Set the modifiers of a part."""
    _set_modifiers(part, modifiers)


def adopt(part: Part, owner: Any, name: str) -> None:
    """Give a part to an owner.

    Raises:
        AcausalError: ``N153`` if it has one already.
    """
    if part._owner is not None:
        where = f"{owner_name(part._owner)}.{part._name}"
        fail("N153", f"this part is already {where}", here(),
             labels=[Label(part._span, "made here")],
             help="make another one for every name")  # fmt: skip
    _set_name(part, name)
    _set_owner(part, owner)


def owner_name(owner: Any) -> str:
    """Return how an owner is called in messages."""
    if isinstance(owner, type):
        return owner.__name__
    return str(owner._title)


class Ref(Symbolic):
    """Something inside a part: ``circuit.r.p.v``, ``chain.link[:-1].tip``."""

    __slots__ = ("_above", "_member", "_root", "_steps")

    def __init__(self, root: Part, steps: Steps, member: Member, above: int = 0) -> None:
        _set_root(self, root)
        _set_steps(self, steps)
        _set_member(self, member)
        _set_above(self, above)

    _root: Part
    _steps: Steps
    _member: Member
    #: Dimensions that arrays further up leave.
    _above: int

    @property
    def _kind(self) -> Kind:
        return self._member.kind

    @property
    def _ndim(self) -> int:
        return self._above + len(self._member.dimensions)

    def __getattr__(self, name: str) -> Any:
        if name[0] == "_":
            raise AttributeError(name)
        member = self._member.kind.member(name)
        if member is None:
            no_member(self._member.kind, name)
        return Ref(self._root, (*self._steps, (name, ())), member, self._ndim)

    def __setattr__(self, name: str, value: Any) -> None:
        if name[0] == "_":
            object.__setattr__(self, name, value)
            return
        fail("N154", f"{name} of {self!r} cannot be set here", here(),
             help="give modifiers where the component is made, for example "
             "Component(part=dict(name=value))")  # fmt: skip

    def __getitem__(self, index: Any) -> Ref:
        given, dimensions = subscripts(index, self._member.dimensions, self)
        name, before = self._steps[-1]
        if before:
            fail("T113", f"{self!r} has subscripts already", here(),
                 help="give all subscripts at once: x[1, 2]")  # fmt: skip
        member = Member(self._member.kind, dimensions, self._member.role)
        return Ref(self._root, (*self._steps[:-1], (name, given)), member, self._above)

    def __len__(self) -> int:
        return length(self, self._member.dimensions)

    def __iter__(self) -> Iterator[Any]:
        return elements(self, self._member.dimensions)

    def __dir__(self) -> list[str]:
        return sorted(self._member.kind.names())

    def _tree(self, scope: Scope, span: Span) -> tree.Expression:
        return reference(self, scope, span)


_set_root = cast(Any, Ref.__dict__["_root"]).__set__
_set_steps = cast(Any, Ref.__dict__["_steps"]).__set__
_set_member = cast(Any, Ref.__dict__["_member"]).__set__
_set_above = cast(Any, Ref.__dict__["_above"]).__set__


def single_step(name: str) -> Steps:
    """Return the step to a member; shared, as models made by programs have many of few names."""
    found = _single_steps.get(name)
    if found is None:
        found = _single_steps[name] = ((name, ()),)
    return found


_single_steps: dict[str, Steps] = {}


def no_member(kind: Kind, name: str) -> NoReturn:
    """Refuse the name of a member that a class does not have.

    Raises:
        UnknownNameError: Always; ``N102``.
    """
    known = kind.names()
    unknown_name(
        "N102", f"{kind.title} has nothing called {name}", here(), name, known,
        f"it has {', '.join(known[:12])}" if known else "it has no parts",
    )  # fmt: skip


# --- references as syntax -----------------------------------------------------------------


def part_reference(part: Part, scope: Scope, span: Span) -> tree.Reference:
    """Return the name of a part in the class that syntax is made for."""
    return tree.Reference(span, tuple(tree.NamePart(span, name) for name in scope.path(part, span)))


def reference(ref: Ref, scope: Scope, span: Span) -> tree.Reference:
    """Return a reference as syntax."""
    parts = [tree.NamePart(span, name) for name in scope.path(ref._root, span)]
    for name, given in ref._steps:
        found = tuple(s._tree(scope, span) for s in given) if given else ()
        if name:
            parts.append(tree.NamePart(span, name, found))
        elif given:
            parts[-1] = tree.NamePart(span, parts[-1].name, found)
    return tree.Reference(span, tuple(parts))


# --- subscripts ---------------------------------------------------------------------------


class _Everything(Symbolic):
    """``:``."""

    __slots__ = ()

    @property
    def _ndim(self) -> int:
        return 1

    def _tree(self, scope: Scope, span: Span) -> tree.Expression:
        return tree.Colon(span)


class _Range(Symbolic):
    """``first:step:last``; None for the ends of the array."""

    __slots__ = ("_first", "_last", "_step")

    def __init__(self, first: Symbolic, step: Symbolic | None, last: Symbolic) -> None:
        self._first = first
        self._step = step
        self._last = last

    @property
    def _ndim(self) -> int:
        return 1

    def _tree(self, scope: Scope, span: Span) -> tree.Expression:
        return tree.RangeExpression(
            span,
            self._first._tree(scope, span),
            None if self._step is None else self._step._tree(scope, span),
            self._last._tree(scope, span),
        )


class _End(Symbolic):
    """``end``."""

    __slots__ = ()

    def _tree(self, scope: Scope, span: Span) -> tree.Expression:
        return tree.End(span)


_EVERYTHING = _Everything()


def subscripts(
    index: Any, dimensions: tuple[int | None, ...], what: Symbolic
) -> tuple[Subscripts, tuple[int | None, ...]]:
    """Return Python's subscripts, from 0, as those of the language, and the dimensions left.

    Raises:
        AcausalError: ``T113`` for too many subscripts, ``T114`` for one outside of the array,
            ``T115`` for one that is no whole number.
    """
    span = here()
    given = index if isinstance(index, tuple) else (index,)
    if Ellipsis in [g for g in given if not isinstance(g, Symbolic | np.ndarray)]:
        at = next(k for k, g in enumerate(given) if g is Ellipsis)
        missing = len(dimensions) - len(given) + 1
        given = (*given[:at], *[slice(None)] * missing, *given[at + 1 :])
    if len(given) > len(dimensions):
        text = f"{len(dimensions)} dimensions" if dimensions else "no dimensions"
        fail("T113", f"{what!r} has {text}, {len(given)} subscripts are given", span,
             help="give at most one subscript for each dimension; "
             "shape= makes an array of components")  # fmt: skip
    result: list[Symbolic] = []
    left: list[int | None] = []
    for one, size in zip(given, dimensions, strict=False):
        subscript, remaining = _subscript(one, size, what, span)
        result.append(subscript)
        left += remaining
    return tuple(result), (*left, *dimensions[len(given) :])


def _subscript(
    index: Any, size: int | None, what: Symbolic, span: Span
) -> tuple[Symbolic, list[int | None]]:
    if isinstance(index, slice):
        return _slice(index, size, what, span)
    if isinstance(index, Symbolic):
        return _plus(index, 1, span), []
    if isinstance(index, list | np.ndarray | range | tuple):
        positions = np.asarray(index)
        if positions.dtype == bool:
            positions = np.flatnonzero(positions)
        if positions.dtype.kind not in "iu" or positions.ndim != 1:
            _no_integer(index, span)
        if size is not None:
            for position in positions:
                _inside(int(position), size, what, span)
            positions = np.where(positions < 0, positions + size, positions)
        return operand(positions + 1, span), [len(positions)]
    try:
        position = int(np.asarray(index).item()) if not isinstance(index, bool) else None
    except (TypeError, ValueError):
        position = None
    if position is None or position != index:
        _no_integer(index, span)
    return _position(position, size, what, span), []


def _no_integer(index: Any, span: Span) -> None:
    fail("T115", f"{index!r} is no subscript", span,
         help="use whole numbers from 0, slices, or lists of whole numbers")  # fmt: skip


def _inside(position: int, size: int, what: Symbolic, span: Span) -> None:
    if not -size <= position < size:
        fail("T114", f"subscript {position} of {what!r} is outside 0..{size - 1}", span,
             help=f"the array has {size} elements; subscripts in Python count from 0")  # fmt: skip


def _position(position: int, size: int | None, what: Symbolic, span: Span) -> Symbolic:
    if size is not None:
        _inside(position, size, what, span)
        position = position + size if position < 0 else position
    if position >= 0:
        return Literal(tree.NumberLiteral(span, float(position + 1), True))
    return _plus(_End(), position + 1, span)


def _plus(value: Symbolic, number: int, span: Span) -> Symbolic:
    if not number:
        return value
    text = Literal(tree.NumberLiteral(span, float(abs(number)), True))
    return Operation("+" if number > 0 else "-", (value, text), span)


def _slice(
    index: slice, size: int | None, what: Symbolic, span: Span
) -> tuple[Symbolic, list[int | None]]:
    if index.start is None and index.stop is None and index.step is None:
        return _EVERYTHING, [size]
    for bound in (index.start, index.stop, index.step):
        if bound is not None and not isinstance(bound, int | np.integer | Symbolic):
            _no_integer(bound, span)
    symbolic = isinstance(index.start, Symbolic) or isinstance(index.stop, Symbolic)
    if size is not None and not symbolic:
        chosen = range(*index.indices(size))
        first, last = chosen.start + 1, chosen.start + len(chosen)
        if chosen.step != 1:
            last = chosen.start + 1 + (len(chosen) - 1) * chosen.step
        if not chosen:
            first, last = 1, 0
        step = operand(chosen.step, span) if chosen.step != 1 and chosen else None
        return _Range(operand(first, span), step, operand(last, span)), [len(chosen)]
    if index.step is not None and not (isinstance(index.step, int) and index.step > 0):
        fail("T125", f"the size of {what!r} is not known in Python", span,
             label="only slices that go forwards are possible",
             help="give the size as a number")  # fmt: skip
    start = 0 if index.start is None else index.start
    first_ = _bound(start, 1, span)
    last_: Symbolic = _End() if index.stop is None else _bound(index.stop, 0, span)
    step = operand(index.step, span) if index.step not in (None, 1) else None
    return _Range(first_, step, last_), [None]


def _bound(value: Any, shift: int, span: Span) -> Symbolic:
    if isinstance(value, Symbolic):
        return _plus(value, shift, span)
    if value >= 0:
        return operand(int(value) + shift, span)
    return _plus(_End(), int(value) + shift, span)


def length(what: Symbolic, dimensions: tuple[int | None, ...]) -> int:
    """Return the number of elements along the first dimension.

    Raises:
        AcausalError: ``T113`` if it is no array, ``T125`` if the size is not known in Python.
    """
    if not dimensions:
        fail("T113", f"{what!r} is no array", here(),
             help="shape= makes an array of components")  # fmt: skip
    if dimensions[0] is None:
        fail("T125", f"the size of {what!r} is not known in Python", here(),
             help="equate whole arrays, or give the size as a number")  # fmt: skip
    return dimensions[0]


def elements(what: Any, dimensions: tuple[int | None, ...]) -> Iterator[Any]:
    """Return an iterator over the elements along the first dimension."""
    count = length(what, dimensions)
    return (what[k] for k in range(count))
