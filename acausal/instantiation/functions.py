"""User functions, executed symbolically where they are called."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from acausal.diagnostics import Span, fail
from acausal.diagnostics.suggest import nearest
from acausal.expressions import build
from acausal.expressions.nodes import ZERO, Expr, const
from acausal.instantiation import unit_algebra as units
from acausal.instantiation.arrays import LONGEST_REDUCTION, require_shape
from acausal.instantiation.expressions import constant_number, elaborate
from acausal.instantiation.merge import Element, merge, primitive_type, type_of
from acausal.instantiation.statements import Return, run
from acausal.instantiation.subscripts import subscripted
from acausal.instantiation.template import Ref
from acausal.instantiation.values import UnitOf, Value, constants, indices, position
from acausal.modeling.classes import ClassDef
from acausal.syntax import tree
from acausal.units.unit import UnitError, parse_unit

if TYPE_CHECKING:
    from acausal.instantiation.environment import ClassEnvironment

#: Calls nested deeper than this are taken for an endless recursion.
DEEPEST_CALL = 100


@dataclass
class _Local:
    """A variable of the function: its elements, last subscript fastest; None if unassigned."""

    type: str
    shape: tuple[int, ...]
    elements: list[Expr | None]
    unit: UnitOf
    value: Value | None = None
    enumeration: ClassDef | None = None

    def copy(self) -> _Local:
        return replace(self, elements=list(self.elements))


@dataclass
class FunctionEnvironment:
    """Names inside a function: its own variables first, then the classes around it."""

    outside: ClassEnvironment
    function: ClassDef
    locals: dict[str, _Local]
    hidden: dict[str, Value] = field(default_factory=dict)

    def reference(self, reference: tree.Reference) -> Value:
        """Return the value of a local variable or of a constant."""
        first = reference.parts[0]
        if first.name in self.hidden:
            return self.hidden[first.name]
        if first.name in self.locals and not reference.absolute:
            value = self.read(first.name, reference)
            value = subscripted(value, first.subscripts, self, reference.span)
            for part in reference.parts[1:]:
                value = _field(value, part, reference)
                value = subscripted(value, part.subscripts, self, reference.span)
            return value
        return self.outside.constant(reference)

    def read(self, name: str, reference: tree.Reference) -> Value:
        """Return the value a local variable has now."""
        local = self.locals[name]
        if local.value is not None:
            return local.value
        elements = list(local.elements)

        def get(index: tuple[Expr, ...]) -> Expr:
            found = elements[position(index, local.shape)]
            if found is None:
                fail("T123", f"{name} is used before it has a value", reference.span,
                     help=f"assign {name} first")  # fmt: skip
            return found

        if not local.shape:
            get(())
        return Value(local.type, local.shape, get, local.unit, enumeration=local.enumeration)

    def call(self, call: tree.Call) -> Value:
        """Return the value of a call."""
        return self.outside.call_in(call, self)

    def stored(self, reference: tree.Reference) -> Value:
        """Refuse ``pre``, ``edge`` and ``change``: functions have no events."""
        fail("E008", "functions have no events", reference.span,
             help="use it in a model")  # fmt: skip

    def signal(self, kind: str, operands: tuple[Expr, ...], source: tree.Expression) -> Expr:
        """Refuse ``sample`` and ``delay``: functions have no events."""
        fail("E008", "functions have no events", source.span,
             help="use it in a model")  # fmt: skip

    def events(self, call: tree.Call) -> None:
        """Refuse an operator of hybrid systems: functions have no events."""
        fail("E008", "functions have no events", call.span, help="use it in a model")

    def is_discrete(self, ref: Ref) -> bool:
        """Return False: functions have no variables of the model."""
        return False

    def assign(self, target: tree.Reference, value: Value, statement: tree.Assignment) -> None:
        """Give a variable of the function a value."""
        _store(target, value, self, statement.span)

    def results(self, call: tree.Call) -> list[Value]:
        """Return all outputs of a function call."""
        return self.outside.call_all(call, self)

    def snapshot(self) -> dict[str, _Local]:
        """Return the values of all variables."""
        return {n: v.copy() for n, v in self.locals.items()}

    def restore(self, state: dict[str, _Local]) -> None:
        """Go back to earlier values."""
        self.locals = {n: v.copy() for n, v in state.items()}

    def enter(self, condition: Expr) -> None:
        """Begin a branch."""

    def leave(self) -> None:
        """End a branch."""

    def join(self, condition: Expr, holds: dict[str, _Local], span: Span) -> None:
        """Choose between the values of a branch and the present ones, those of the other."""
        for name, local in self.locals.items():
            first = holds[name]
            if first.value is not local.value and "record" in (first.type, local.type):
                fail("T127", f"{name} is a record assigned under an unknown condition", span,
                     help="assign its fields with if expressions")  # fmt: skip
            if local.type != "record":
                changed = first.elements != local.elements
                local.elements = [
                    a
                    if a is b
                    else (None if a is None or b is None else build.if_(condition, a, b))
                    for a, b in zip(first.elements, local.elements, strict=True)
                ]
                if changed:
                    local.value = None

    def invoke(self, statement: tree.CallStatement) -> None:
        """Execute a call without result; assertions of functions are not watched."""
        if str(statement.call.function) != "assert":
            self.call(statement.call)

    def when(self, statement: tree.WhenStatement) -> None:
        """Refuse a when."""
        fail("E008", "when is not allowed in a function", statement.span,
             help="functions have no events")  # fmt: skip

    def give_back(self, statement: tree.ReturnStatement) -> None:
        """Execute ``return``."""
        raise Return

    def component_shape(self, reference: tree.Reference) -> tuple[int, ...] | None:
        """Return None: a function has values only."""
        return None

    def with_locals(self, values: dict[str, Value]) -> FunctionEnvironment:
        """Return the environment with loop indices that hide other names."""
        return FunctionEnvironment(
            self.outside, self.function, self.locals, {**self.hidden, **values}
        )


def _field(value: Value, part: tree.NamePart, reference: tree.Reference) -> Value:
    if value.fields is None or part.name not in value.fields:
        names = list(value.fields or {})
        fail("N102", f"there is no {part.name} in {reference.parts[0].name}", reference.span,
             notes=[f"it has {', '.join(names)}"] if names else [],
             help="name one of its fields")  # fmt: skip
    return value.fields[part.name]


def inline(
    function: ClassDef, call: tree.Call, given: list[Value], named: dict[str, Value],
    outside: ClassEnvironment, depth: int,
) -> list[Value]:  # fmt: skip
    """Return the outputs of a call, in order.

    Args:
        function: The function.
        call: The call, for messages.
        given: Positional arguments.
        named: Named arguments.
        outside: Environment for constants and functions, with the function as scope.
        depth: How deep calls are nested.

    Raises:
        AcausalError: ``T12x`` for wrong arguments and for algorithms that cannot be unrolled.
    """
    if depth > DEEPEST_CALL:
        fail("N106", f"{function.full_name} calls itself without end", call.span,
             help="give the recursion an end that is known before the simulation")  # fmt: skip
    merged = merge(function)
    if function.tree.external:
        fail("T124", f"{function.full_name} is an external function", call.span,
             help="write its body as an algorithm")  # fmt: skip
    env = FunctionEnvironment(outside, function, {})
    inputs = [e for e in merged.elements.values() if e.has("input")]
    outputs = [e for e in merged.elements.values() if e.has("output")]
    if len(given) > len(inputs):
        fail("T120", f"{function.name} takes {len(inputs)} arguments, not {len(given)}",
             call.span, help=f"its inputs are {', '.join(e.name for e in inputs)}")  # fmt: skip
    arguments = {e.name: v for e, v in zip(inputs, given, strict=False)}
    for name, value in named.items():
        if name not in {e.name for e in inputs} or name in arguments:
            close = nearest(name, [e.name for e in inputs])
            fail("T120", f"{function.name} has no input {name} left to set", call.span,
                 notes=[f"did you mean {' or '.join(close)}?"] if close else [],
                 help=f"its inputs are {', '.join(e.name for e in inputs)}")  # fmt: skip
        arguments[name] = value
    for element in merged.elements.values():
        _declare(element, env, arguments.get(element.name), call)
    try:
        for statements, owner in merged.algorithms:
            env.outside = outside.in_class(owner)
            run(statements, env)
    except Return:
        pass
    return [env.read(e.name, tree.Reference(call.span, (tree.NamePart(call.span, e.name),)))
            for e in outputs]  # fmt: skip


def _declare(
    element: Element, env: FunctionEnvironment, argument: Value | None, call: tree.Call
) -> None:
    kind = primitive_type(type_of(element))
    binding = next((m.value for m in element.modifications if not m.path), None)
    value = argument
    if value is None and binding is not None:
        value = elaborate(binding, env)
    if value is None and element.has("input"):
        fail("T120", f"{env.function.name} needs a value for {element.name}", call.span,
             help="give all inputs that have no default")  # fmt: skip
    if kind is None or kind.base == "String":
        env.locals[element.name] = _Local("record", (), [], None, value)
        return
    unit: UnitOf = None
    for m in (*element.modifications, *kind.modifications):
        if m.path == ("unit",) and isinstance(m.value, tree.StringLiteral):
            try:
                unit = parse_unit(m.value.value).dimension if m.value.value else None
            except UnitError as error:
                fail("U104", f"{m.value.value} is not a unit", m.span, notes=[str(error)],
                     help="units are written as in N.m/rad, m/s2, kOhm")  # fmt: skip
            break
    given = element.declaration.dimensions
    dimensions = (*given, *(d for d, _ in kind.dimensions))
    shape: list[int] = []
    for k, d in enumerate(dimensions):
        if isinstance(d, tree.Colon):
            if value is None or len(value.shape) != len(dimensions):
                fail("T125", f"the size of {element.name} is not known", element.declaration.span,
                     help="give it a size, or pass an array with as many dimensions")  # fmt: skip
            shape.append(value.shape[k])
        else:
            shape.append(int(constant_number(d, env, "an array size")))
    size = tuple(shape)
    local = _Local(kind.base, size, [None] * len(indices(size)), unit, enumeration=kind.enumeration)
    env.locals[element.name] = local
    if value is not None:
        require_shape(value, size, f"the value of {element.name}", call.span)
        local.unit = units.added(
            value.unit, unit, f"{element.name} of {env.function.name} is given", "U106",
            call.span, call.span, element.declaration.span,
        )  # fmt: skip
        if constants_only(value):
            local.value = value
        local.elements = list(value.elements())
        if kind.base != value.type and kind.base == "Real":
            local.value = None


def constants_only(value: Value) -> bool:
    """Tell whether all elements are constant, without unrolling long arrays."""
    return value.size <= LONGEST_REDUCTION and constants(value) is not None


def _store(target: tree.Reference, value: Value, env: FunctionEnvironment, span: Span) -> None:
    name = target.parts[0].name
    local = env.locals.get(name)
    if local is None or (len(target.parts) > 1 and local.type != "record"):
        fail("T126", f"{target} cannot be assigned here", span,
             help="assign the function's own variables")  # fmt: skip
    if env_input(env, name):
        fail("T126", f"{name} is an input and cannot be assigned", span,
             help="use a protected variable")  # fmt: skip
    if local.type == "record":
        local.value = _with_field(local.value, target.parts[1:], value, target)
        return
    local.value = None
    units.added(local.unit, value.unit, f"{name} is given", "U106", span, span, span)
    subscripts = target.parts[0].subscripts
    if not subscripts:
        require_shape(value, local.shape, f"{name} has another size", span)
        local.elements = list(value.elements())
        return
    places = Value("Integer", local.shape, lambda i: const(float(position(i, local.shape))), None)
    chosen = subscripted(places, subscripts, env, span)
    require_shape(value, chosen.shape, f"{target} has another size", span)
    for place, element in zip(chosen.elements(), value.elements(), strict=True):
        local.elements[int(build.number_of(place))] = element


def _with_field(
    record: Value | None, path: tuple[tree.NamePart, ...], value: Value, target: tree.Reference
) -> Value:
    """Return a record with one field set; without a path, the value itself."""
    if not path:
        return value
    if any(part.subscripts for part in path):
        fail("T126", f"{target} cannot be assigned here", target.span,
             help="assign the field as a whole")  # fmt: skip
    fields = dict(record.fields or {}) if record is not None else {}
    name = path[0].name
    fields[name] = _with_field(fields.get(name), path[1:], value, target)
    return Value("record", (), lambda _: ZERO, None, None, fields)


def env_input(env: FunctionEnvironment, name: str) -> bool:
    """Tell whether a name is an input of the function."""
    element = merge(env.function).elements.get(name)
    return element is not None and element.has("input")
