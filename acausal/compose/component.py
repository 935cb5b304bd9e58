"""Components in Python: instances of classes of the library, and classes written in Python."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, ClassVar, NoReturn, cast

from acausal.compose.declarations import Declaration, shape_of
from acausal.compose.equations import equations_of
from acausal.compose.kinds import Kind, PythonKind, TextKind, text_kind
from acausal.compose.mistakes import unknown_name
from acausal.compose.modifiers import Pending, modifier
from acausal.compose.names import RESERVED, check_name
from acausal.compose.parts import Part, Ref, adopt, describe, modify, no_member, single_step
from acausal.compose.places import here
from acausal.compose.symbols import Equality, Invocation, Literal, Operation, Symbolic
from acausal.diagnostics import Label, Span, fail
from acausal.memory import settle
from acausal.modeling.classes import ClassDef
from acausal.syntax.tree import Modifier

#: After so many parts or connections the garbage collector is told that they are here to stay.
_MANY = 2000

#: A connection: its cuts and its place.
Connection = tuple[tuple[Any, ...], Span]


class ComponentType(type):
    """The class of component classes: collects what is declared in the class body."""

    #: The class of the library, if this is one.
    _definition: ClassDef | None
    #: What is known about it.
    _text_kind: TextKind | None
    #: Classes of the library that it extends.
    _text_bases: tuple[ClassDef, ...]
    #: Parts declared in the class body and in those of its Python bases.
    _declared: dict[str, Part]
    #: Values for parameters of the library classes it extends, with their places.
    _overrides: dict[str, tuple[Any, Span]]
    #: Whether every instance may have parts of its own (``build`` or ``__init__``).
    _dynamic: bool
    _restriction: str

    def __new__(
        mcs, name: str, bases: tuple[type, ...], namespace: dict[str, Any], **modifiers: Any
    ) -> Any:
        """Make a class."""
        span = here()
        foundation = namespace.get("__module__", "").startswith("acausal.compose.")
        if not foundation and "_definition" not in namespace:
            for key, value in namespace.items():
                if isinstance(value, Part):
                    check_name(key, span)
        cls = super().__new__(mcs, name, bases, namespace)
        declared: dict[str, Part] = {}
        text_bases: dict[ClassDef, None] = {}
        overrides: dict[str, tuple[Any, Span]] = {}
        dynamic = False
        for base in reversed(cls.__mro__[1:]):
            if isinstance(base, ComponentType):
                own = base.__dict__
                declared |= {n: p for n, p in base._declared.items() if p._owner is base}
                text_bases |= dict.fromkeys(base._text_bases)
                overrides |= base._overrides
                dynamic = dynamic or own.get("_dynamic", False)
        if namespace.get("_definition") is not None:
            text_bases = {namespace["_definition"]: None}
            cls._text_kind = text_kind(namespace["_definition"])
        else:
            cls._definition = cls._text_kind = None
        cls._text_bases = tuple(text_bases)
        cls._dynamic = dynamic or (
            not foundation and ("build" in namespace or "__init__" in namespace)
        )
        for key, value in [*namespace.items(), *modifiers.items()]:
            if isinstance(value, Part):
                declared[key] = value
            elif key[0] != "_" and not foundation:
                before = declared.get(key)
                if isinstance(before, Declaration):
                    twin = before._copy(value)
                    adopt(twin, cls, key)
                    declared[key] = twin
                    type.__setattr__(cls, key, twin)
                elif key in modifiers or any(
                    text_kind(b).member(key) is not None for b in cls._text_bases
                ):
                    overrides[key] = (value, span)
                    if key in namespace:
                        delattr(cls, key)
        cls._declared = declared
        cls._overrides = overrides
        for key, (_, where) in overrides.items():
            if key in modifiers:
                _check_inherited(cls, key, where)
        return cls

    def __init__(cls, name: str, bases: Any, namespace: Any, **modifiers: Any) -> None:
        super().__init__(name, bases, namespace)

    def __setattr__(cls, name: str, value: Any) -> None:
        if isinstance(value, Part):
            fail("N154", f"{cls.__name__}.{name} cannot be added to a class", here(),
                 help="write it in the class body, or assign it to an instance")  # fmt: skip
        super().__setattr__(name, value)


def _check_inherited(cls: ComponentType, name: str, span: Span) -> None:
    """Refuse a value for something that no library class above has.

    Raises:
        UnknownNameError: ``N103``.
    """
    if any(text_kind(base).member(name) is not None for base in cls._text_bases):
        return
    known = [n for b in cls._text_bases for n in text_kind(b).names()]
    unknown_name("N103", f"{cls.__name__} has nothing called {name}", span, name, known,
                 "its bases have no such parameter")  # fmt: skip


class _LazySignature:
    """The signature of a component class, made when somebody asks."""

    def __get__(self, instance: Any, owner: Any = None) -> inspect.Signature:
        from acausal.compose.documentation import signature_of

        return signature_of(owner)


class Component(Part, metaclass=ComponentType):
    """A component. Classes of the library are subclasses; your own are written as this one's.

    A subclass declares cuts, components, parameters and variables in its body, and states
    its equations in :meth:`equations`. If the parts depend on plain Python values, it makes them in
    ``build(self, ...)``: the arguments of ``build`` are arguments of the class. All other keyword
    arguments are values for parameters, or modifiers of parts (see :func:`acausal.mod`).

    Args:
        shape: Sizes of an array of components: ``100``, ``(3, 4)``, or a parameter.
        inner: Whether it is the one that ``outer`` components of its name mean; by itself if
            another component of the model asks for it.
        description: What it is there for.
        modifiers: Values by the name of a parameter or part. For an array, one value is each
            component's, an array of values gives every component its own.

    Example:
        >>> import acausal as ac
        >>> from acausal.library import electrical as el
        >>> class Diode(ac.Component):
        ...     p = el.Pin(); n = el.Pin()
        ...     saturation = ac.Parameter(1e-12, unit="A")
        ...     def equations(self):
        ...         v = self.p.v - self.n.v
        ...         yield self.p.i == self.saturation*(ac.exp(v/0.025) - 1)
        ...         yield self.n.i == -self.p.i
        >>> d = Diode(saturation=1e-14)
    """

    __slots__ = ("_connections", "_equations", "_frozen", "_initials", "_parts", "_passed")

    _definition: ClassVar[ClassDef | None] = None
    _text_kind: ClassVar[TextKind | None] = None
    _text_bases: ClassVar[tuple[ClassDef, ...]] = ()
    _declared: ClassVar[dict[str, Part]] = {}
    _overrides: ClassVar[dict[str, tuple[Any, Span]]] = {}
    _dynamic: ClassVar[bool] = False
    _restriction: ClassVar[str] = "model"
    __signature__ = _LazySignature()

    _parts: dict[str, Part] | None
    _connections: list[Connection] | None
    _equations: list[tuple[Any, str]] | None
    _initials: list[tuple[Any, str]] | None
    #: Where the model was compiled; None while it can be changed.
    _frozen: Span | None
    #: Arguments that build has got, for documentation.
    _passed: Any

    def __new__(cls, *args: Any, **options: Any) -> Any:
        """Prepare an instance; the place is that of the call."""
        self = Part.__new__(cls)
        _set_parts(self, None)
        _set_connections(self, None)
        _set_equations(self, None)
        _set_initials(self, None)
        _set_frozen(self, None)
        return self

    def __init__(
        self,
        *positional: Any,
        shape: Any = (),
        inner: bool | None = None,
        description: str = "",
        **modifiers: Any,
    ) -> None:
        cls = type(self)
        if positional:
            fail("N158", f"{cls.__name__} takes what it is given by name", self._span,
                 help=f"write {cls.__name__}(name=value); "
                 f"its signature is {cls.__name__}{cls.__signature__}")  # fmt: skip
        if cls._dynamic:
            self._build(modifiers)
        if shape != ():
            describe(self, shape_of(shape, self), inner, description)
        elif inner is not None or description:
            describe(self, (), inner, description)
        definition = cls._definition
        if definition is not None and definition.tree.partial:
            fail("N111", f"{definition.full_name} is partial", self._span,
                 label="a partial class has no complete equations",
                 help="use a class that extends it, or extend it: "
                 f"class Mine({cls.__name__}): ...")  # fmt: skip
        if modifiers:
            span, array = self._span, len(self._shape)
            kind = self._kind
            if cls._dynamic:
                self._check_names(kind, modifiers)
            modify(
                self,
                tuple([modifier(kind, n, v, array, span) for n, v in modifiers.items()]),
            )

    def _build(self, modifiers: dict[str, Any]) -> None:
        build: Callable[..., None] | None = getattr(type(self), "build", None)
        if build is None:
            return
        parameters = inspect.signature(build).parameters
        if any(p.kind is p.VAR_KEYWORD for p in parameters.values()):
            given = dict(modifiers)
        else:
            given = {n: v for n, v in modifiers.items() if n in parameters}
        for name in given:
            del modifiers[name]
        missing = [
            n
            for n, p in list(parameters.items())[1:]
            if p.default is p.empty and n not in given and p.kind not in (p.VAR_KEYWORD,)
        ]
        if missing:
            fail("N157", f"{type(self).__name__} needs a value for {', '.join(missing)}",
                 self._span, help=f"write {type(self).__name__}({missing[0]}=...)")  # fmt: skip
        build(self, **given)

    def _check_names(self, kind: Kind, modifiers: dict[str, Any]) -> None:
        """Refuse arguments that neither ``build`` nor a part is called by."""
        build: Any = getattr(type(self), "build", None)
        own = [] if build is None else list(inspect.signature(build).parameters)[1:]
        for name in modifiers:
            if kind.member(name.removesuffix("_")) is None and kind.member(name) is None:
                known = [*own, *kind.names()]
                unknown_name("N103", f"{kind.title} has nothing called {name}", self._span, name,
                             known, f"it has {', '.join(known)}")  # fmt: skip

    # --- what is inside ------------------------------------------------------------------

    @property
    def _kind(self) -> Kind:
        cls = type(self)
        if cls._text_kind is not None:
            return cls._text_kind
        return PythonKind(cls, self._parts, self._class_title)

    @property
    def _title(self) -> str:
        return self._name or type(self).__name__

    @property
    def _class_title(self) -> str:
        return type(self).__name__

    def __getattr__(self, name: str) -> Any:
        parts = self._parts if name != "_parts" else None
        if parts is not None:
            part = parts.get(name)
            if part is not None:
                if self._shape:
                    above = len(self._shape)
                    return Ref(self, (("", ()), (name, ())), part._member, above)
                return part
        if name[0] == "_":
            raise AttributeError(name)
        kind = self._kind
        member = kind.member(name)
        if member is None:
            no_member(kind, name)
        return Ref(self, single_step(name), member, len(self._shape))

    def __setattr__(self, name: str, value: Any) -> None:
        if isinstance(value, Part) and name[0] != "_":
            self._assign(name, value)
        elif name[0] == "_":
            object.__setattr__(self, name, value)
        else:
            self._set(name, value)

    def __delattr__(self, name: str) -> None:
        self._changeable()
        fail("N154", f"{name} cannot be taken away", here(),
             help="leave it out with a Python if where the model is made")  # fmt: skip

    def _assign(self, name: str, part: Part) -> None:
        parts = self._parts
        if parts is None:
            definition = type(self)._definition
            if definition is not None:
                fail("N154", f"{self._title} cannot get parts of its own", here(),
                     label=f"it is of class {definition.full_name}",
                     help=f"extend its class: class Mine({type(self).__name__}): ...")  # fmt: skip
            parts = {}
            _set_parts(self, parts)
        if self._frozen is not None or self._owner is not None:
            self._changeable()
        if name in parts or name in type(self)._declared:
            before = parts[name] if name in parts else type(self)._declared[name]
            fail("N105", f"{owner_title(self)} already has a part called {name}", here(),
                 labels=[Label(before._span, "first here")],
                 help="take another name; in a notebook, make the model in one cell")  # fmt: skip
        if (
            name in RESERVED
            or not (name.isidentifier() and name.isascii())
            or hasattr(type(self), name)
        ):
            check_name(name, here(), type(self))
        if any(text_kind(b).member(name) is not None for b in type(self)._text_bases):
            base = type(self)._text_bases[0].full_name
            fail("N105", f"{name} is inherited from {base}", here(), help="rename it")  # fmt: skip
        if part is self or (isinstance(part, Component) and part._frozen is not None):
            fail("N156", f"{owner_title(part)} was compiled by itself", here(),
                 labels=[Label(part._frozen, "compiled here")] if part._frozen else [],
                 help="make another one as a component, for example with .copy()")  # fmt: skip
        adopt(part, self, name)
        parts[name] = part
        if not len(parts) % _MANY:
            settle()

    def _set(self, name: str, value: Any) -> None:
        """Set a parameter of a component after it was made, or a plain attribute of a class."""
        self._changeable()
        part = (self._parts or {}).get(name)
        if isinstance(part, Declaration):
            part._value = part._copy(value)._value
            return
        kind = self._kind
        if kind.member(name) is not None:
            span = here()
            made = modifier(kind, name, value, len(self._shape), span)
            modify(self, (*(m for m in self._modifiers if modifier_name(m) != name), made))
            return
        if type(self).__module__.startswith("acausal."):
            definition = type(self)._definition
            if definition is None:
                fail("N154", f"{value!r} is no part of a model", here(),
                     help=f"write ac.Parameter({value!r}) for a parameter; keep other values in "
                     "variables of your own")  # fmt: skip
            parameters = [n for n in kind.names() if (m := kind.member(n)) is not None and m.role]
            unknown_name("N103", f"{kind.title} has nothing called {name}", here(), name,
                         kind.names(), f"its parameters are {', '.join(parameters)}")  # fmt: skip
        object.__setattr__(self, name, value)

    def _changeable(self) -> None:
        where: Any = self
        if id(self) in _being_defined:
            return
        while where is not None and not isinstance(where, type):
            frozen = getattr(where, "_frozen", None)
            if frozen is not None:
                fail("N156", f"{where._title} was compiled and cannot be changed", here(),
                     labels=[Label(frozen, "compiled here")],
                     help="change it before; other parameters need no other model: "
                     "compile(parameters=...); a copy() can be changed")  # fmt: skip
            where = where._owner

    def __dir__(self) -> list[str]:
        methods = [n for n in object.__dir__(self) if not n.startswith("_")]
        return sorted({*methods, *self._kind.names()})

    def _constructor(self) -> Symbolic:
        """Return the component as a value: a record."""
        definition = type(self)._definition
        if definition is None or definition.kind != "record":
            return self
        named = []
        for m in self._modifiers:
            value = m.value
            if isinstance(m, Modifier) and m.value is not None:
                value = Literal(m.value)
            if value is not None:
                named.append((modifier_name(m), value))
        return Invocation(definition, (), self._span, named)

    # --- building -------------------------------------------------------------------------

    def add(self, name: str, part: Any) -> Any:
        """Add a part under a name that is made by a program; return the part.

        Args:
            name: An identifier.
            part: What would be assigned.

        Example:
            >>> import acausal as ac
            >>> from acausal.library import electrical as el
            >>> circuit = ac.Model("circuit")
            >>> resistors = [circuit.add(f"r{k}", el.Resistor(R=10*k)) for k in range(1, 4)]
        """
        if not isinstance(part, Part):
            fail("N154", f"{part!r} is no part of a model", here(),
                 help="add a component, parameter or variable")  # fmt: skip
        self._assign(name, part)
        return part

    def connect(self, *cuts: Any) -> None:
        """Connect cuts: across variables are equal, through variables add up to zero.

        Args:
            cuts: Two or more cuts or arrays of cuts of this model; arrays are connected element
                by element.

        Raises:
            AcausalError: ``C101`` for what is no cut and for unlike cuts, ``P012`` for fewer
                than two.
        """
        if self._frozen is not None or self._owner is not None:
            self._changeable()
        span = here()
        if len(cuts) < 2:
            fail("P012", "connect needs at least two cuts", span,
                 help="write connect(a, b), or connect(*cuts) for a list")  # fmt: skip
        first = cuts[0]
        if not isinstance(first, Ref | Component):
            _no_cut(first, span)
        kind = first._kind
        if not kind.is_connector:
            _no_cut(first, span)
        for other in cuts[1:]:
            if not isinstance(other, Ref | Component):
                _no_cut(other, span)
            own = other._kind
            if own is not kind and (kind, own) not in _alike:
                if not other._kind.is_connector:
                    _no_cut(other, span)
                check_alike(first, other, span)
        if self._connections is None:
            _set_connections(self, [])
        connections = self._connections
        connections.append((cuts, span))  # type: ignore[union-attr]
        if not len(connections) % _MANY:  # type: ignore[arg-type]
            settle()

    def equation(self, *equations: Any, description: str = "") -> None:
        """State equations.

        Args:
            equations: ``left == right``, ``ac.when(...)``, ``ac.if_then(...)``,
                ``ac.assert_(...)``, or lists of them.
            description: A remark that goes with them.

        Raises:
            AcausalError: ``B110`` for what is no equation.
        """
        self._changeable()
        found = [(e, description) for e in equations_of(equations, here())]
        if self._equations is None:
            _set_equations(self, [])
        self._equations += found  # type: ignore[operator]

    def initial(self, *equations: Any, description: str = "") -> None:
        """State equations for the first instant only, see :meth:`equation`."""
        self._changeable()
        found = [(e, description) for e in equations_of(equations, here())]
        if self._initials is None:
            _set_initials(self, [])
        self._initials += found  # type: ignore[operator]

    def equations(self) -> Iterable[Any] | None:
        """Return or yield the equations; overridden by components written in Python."""
        return ()

    def initial_equations(self) -> Iterable[Any] | None:
        """Return or yield equations for the first instant; overridden like :meth:`equations`."""
        return ()

    def __deepcopy__(self, memo: dict[int, Any]) -> Any:
        from acausal.compose.copying import copied

        return copied(self, memo)


_set_parts = cast(Any, Component.__dict__["_parts"]).__set__
_set_connections = cast(Any, Component.__dict__["_connections"]).__set__
_set_equations = cast(Any, Component.__dict__["_equations"]).__set__
_set_initials = cast(Any, Component.__dict__["_initials"]).__set__
_set_frozen = cast(Any, Component.__dict__["_frozen"]).__set__


class Connector(Component):
    """A cut written in Python: declare ``ac.Across`` and ``ac.Through`` variables in its body.

    Example:
        >>> import acausal as ac
        >>> class Flange(ac.Connector):
        ...     s = ac.Across("m", "position")
        ...     f = ac.Through("N", "force into the component")
    """

    __slots__ = ()
    _restriction = "connector"


#: Components whose equations are being asked for; what they add is taken back.
_being_defined: set[int] = set()


@contextmanager
def asked(part: Component) -> Iterator[None]:
    """Let ``equations`` add parts and connections, as ``build`` does, and take them back.

    A definition is made whenever a model is compiled or written as text; it must not change it.
    """
    parts = None if part._parts is None else dict(part._parts)
    lists = [
        None if x is None else list(x) for x in (part._connections, part._equations, part._initials)
    ]
    before = id(part) in _being_defined
    _being_defined.add(id(part))
    try:
        yield
    finally:
        if not before:
            _being_defined.discard(id(part))
        _set_parts(part, parts)
        _set_connections(part, lists[0])
        _set_equations(part, lists[1])
        _set_initials(part, lists[2])


def freeze(model: Component, span: Span) -> None:
    """Make a model unchangeable."""
    _set_frozen(model, span)


def modifier_name(modifier: Modifier | Pending) -> str:
    """Return the name of the member that is modified."""
    return modifier.name if isinstance(modifier, Pending) else modifier.name[0]


def owner_title(part: Any) -> str:
    """Return how a part is called in messages."""
    return str(getattr(part, "_title", "") or part._name)


def _no_cut(what: Any, span: Span) -> NoReturn:
    if isinstance(what, Operation | Equality) or not isinstance(what, Symbolic):
        from acausal.compose.numbers import _article

        text = repr(what) if isinstance(what, Symbolic) else _article(what)
        fail("C101", f"{text} is no cut", span,
             help="name cuts, such as circuit.r.p; write connect(*cuts) for a list")  # fmt: skip
    kind = cast(Any, what)._kind
    if kind.primitive:
        fail("C101", f"{what!r} is a variable, not a cut", span,
             help="write an equation between variables; connect joins cuts")  # fmt: skip
    cuts = [n for n in kind.names() if (m := kind.member(n)) is not None and m.kind.is_connector]
    fail("C101", f"{what!r} is a component, not a cut", span, label=f"a {kind.title}",
         help=f"name one of its cuts: {', '.join(cuts) or 'it has none'}")  # fmt: skip


#: Pairs of classes of cuts that fit together.
_alike: set[tuple[Kind, Kind]] = set()


def check_alike(first: Any, other: Any, span: Span) -> None:
    """Refuse to connect unlike cuts.

    Raises:
        AcausalError: ``C101``.
    """
    one, two = first._kind, other._kind
    if (one, two) in _alike:
        return
    a, b = one.signature(), two.signature()
    if a != b:
        fail("C101", f"{first!r} and {other!r} are unlike cuts", span,
             label=f"a {one.title} cannot be connected to a {two.title}",
             notes=[_contents(one.title, a), _contents(two.title, b)],
             help="connect cuts of one field; a transducer couples two fields")  # fmt: skip
    if not isinstance(one, PythonKind) and not isinstance(two, PythonKind):
        _alike.add((one, two))


def _contents(title: str, signature: Any) -> str:
    names = [".".join(path) + " (through)" * through for path, (through, _) in signature.items()]
    return f"{title} has {', '.join(names)}" if names != [""] else f"{title} is a signal"
