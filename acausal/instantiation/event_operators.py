"""Operators of hybrid systems (Modelica 3.6, section 3.7.5): ``pre``, ``sample``, ``delay``, ..."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from acausal.diagnostics import fail
from acausal.expressions import build
from acausal.expressions.nodes import Expr, slot
from acausal.expressions.traverse import postorder
from acausal.instantiation import unit_algebra as units
from acausal.instantiation.arrays import mapped, require_shape
from acausal.instantiation.builtins import arguments
from acausal.instantiation.expressions import SECOND, Environment, elaborate_real
from acausal.instantiation.template import INITIAL, TERMINAL, Ref, Signal, Unset
from acausal.instantiation.values import Index, Value, scalar
from acausal.syntax import tree
from acausal.syntax.formatter import format_expression

Handler = Callable[[tree.Call, Environment], Value]


def find_event_operator(name: str) -> Handler | None:
    """Return the handler of an operator that has to do with events, or None."""
    return _handlers.get(name)


def event_operator_names() -> list[str]:
    """Return the names of the operators that give a value."""
    return [n for n in _handlers if n not in (*_EQUATIONS, *_UNSUPPORTED)]


def lone(expr: Expr) -> Ref | None:
    """Return the variable that an expression consists of, or None if it is more than that."""
    ref = expr.value
    if expr.op != "slot" or not isinstance(ref, Ref) or ref.parameter or ref.order or ref.pre:
        return None
    return ref


def before(expr: Expr) -> Expr:
    """Return the value of a single variable before the event."""
    ref = expr.value
    assert isinstance(ref, Ref)
    return slot(replace(ref, pre=True))


def is_fixed(expr: Expr) -> bool:
    """Tell whether an expression depends on parameters and loop indices only."""
    for part in postorder(expr):
        if part.op == "time" or isinstance(part.value, (Signal, Unset)):
            return False
        if isinstance(part.value, Ref) and not part.value.parameter:
            return False
    return True


def _variable(e: tree.Call, env: Environment) -> Value:
    """Return the variable that is the argument of ``pre``, ``edge`` or ``change``."""
    (argument,) = arguments(e, 1)
    name = str(e.function)
    if isinstance(argument, tree.Reference) and str(argument) != "time":
        value = env.stored(argument)
        if value.fields is None and value.type != "String":
            return value
    fail("E007", f"{name} needs a variable, not {format_expression(argument)}", argument.span,
         help=f"declare a variable, say what it is in an equation, use {name} of it")  # fmt: skip


def _previous(e: tree.Call, value: Value) -> Value:
    def get(expr: Expr) -> Expr:
        if lone(expr) is not None:
            return before(expr)
        if is_fixed(expr):
            return expr
        fail("E007", f"{e.function} needs a variable, not {format_expression(e.arguments[0])}",
             e.span, help="name a variable of the model")  # fmt: skip

    return replace(mapped(get, value.type, value.unit, value), enumeration=value.enumeration)


def _pre(e: tree.Call, env: Environment) -> Value:
    return _previous(e, _variable(e, env))


def _edge(e: tree.Call, env: Environment) -> Value:
    variable = _variable(e, env)
    if variable.type != "Boolean":
        fail("T102", f"edge needs a Boolean variable, not {variable.type}", e.arguments[0].span,
             help="use change for other types")  # fmt: skip
    now = env.reference(_reference(e))
    return mapped(lambda a, b: build.and_(a, build.not_(b)), "Boolean", None, now,
                  _previous(e, variable))  # fmt: skip


def _change(e: tree.Call, env: Environment) -> Value:
    previous = _previous(e, _variable(e, env))
    now = env.reference(_reference(e))
    return mapped(lambda a, b: build.relation("ne", a, b), "Boolean", None, now, previous)


def _reference(e: tree.Call) -> tree.Reference:
    argument = e.arguments[0]
    assert isinstance(argument, tree.Reference)
    return argument


def _initial(e: tree.Call, env: Environment) -> Value:
    arguments(e, 0)
    env.events(e)
    number = INITIAL if str(e.function) == "initial" else TERMINAL
    return scalar(slot(Signal(number)), "Boolean")


def _fixed(e: tree.Call, argument: tree.Expression, what: str, env: Environment) -> Expr:
    """Return a time that is known before the simulation starts.

    Raises:
        AcausalError: ``E011``.
    """
    value = elaborate_real(argument, env)
    require_shape(value, (), f"{what} of {e.function}", argument.span)
    units.added(value.unit, SECOND, f"{what} of {e.function} is a time, not", "U106",
                e.span, argument.span, e.span)  # fmt: skip
    if not is_fixed(value.expr):
        fail("E011", f"{what} of {e.function} must be known before the simulation",
             argument.span, label="this depends on something that changes",
             help="use parameters and constants here")  # fmt: skip
    return value.expr


def _sample(e: tree.Call, env: Environment) -> Value:
    first, interval = arguments(e, 2)
    start = _fixed(e, first, "the start", env)
    step = _fixed(e, interval, "the interval", env)
    if step.op == "const" and build.number_of(step) <= 0.0:
        fail("E011", "the interval of sample must be above 0", interval.span,
             help="give the time between two samples in seconds")  # fmt: skip
    return scalar(env.signal("sample", (start, step), e), "Boolean")


def _delay(e: tree.Call, env: Environment) -> Value:
    parts = arguments(e, 2, 3)
    value = elaborate_real(parts[0], env)
    if len(parts) == 2:
        time = most = _fixed(e, parts[1], "the delay", env)
    else:
        most = _fixed(e, parts[2], "the largest delay", env)
        given = elaborate_real(parts[1], env)
        require_shape(given, (), "the delay", parts[1].span)
        units.added(given.unit, SECOND, "the delay is a time, not", "U106",
                    e.span, parts[1].span, e.span)  # fmt: skip
        time = given.expr
    for part, number in ((parts[1], time), (parts[-1], most)):
        if number.op == "const" and build.number_of(number) < 0.0:
            fail("E011", "a delay cannot be negative", part.span, help="give a time above 0")

    def get(index: Index) -> Expr:
        expr = value.get(index)
        return expr if is_fixed(expr) else env.signal("delay", (expr, time, most), e)

    if not value.shape:
        return scalar(get(()), "Real", value.unit)
    return Value("Real", value.shape, get, value.unit)


def _equation_only(e: tree.Call, env: Environment) -> Value:
    fail("E008", f"{e.function} is no value", e.span,
         help=f"write {e.function}(...) as an equation of its own")  # fmt: skip


def _unsupported(e: tree.Call, env: Environment) -> Value:
    if str(e.function) == "String":
        fail("E001", "String has no meaning here", e.span,
             help="texts are put together in messages of assert and terminate only")  # fmt: skip
    fail("E001", f"{e.function} is not supported in this version", e.span,
         help="express it with other operators")  # fmt: skip


_EQUATIONS = ("reinit", "terminate", "assert")
_UNSUPPORTED = (
    "cardinality", "spatialDistribution", "inStream", "actualStream", "String", "getInstanceName",
)  # fmt: skip
_handlers: dict[str, Handler] = {
    "pre": _pre, "edge": _edge, "change": _change, "initial": _initial, "terminal": _initial,
    "sample": _sample, "delay": _delay,
    **dict.fromkeys(_EQUATIONS, _equation_only), **dict.fromkeys(_UNSUPPORTED, _unsupported),
}  # fmt: skip
