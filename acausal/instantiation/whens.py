"""When equations to assignments, reinits and terminations (Modelica 3.6, section 8.3.5)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from acausal.diagnostics import fail
from acausal.expressions import build
from acausal.expressions.nodes import ONE, ZERO, Expr, slot
from acausal.instantiation.arrays import require_shape
from acausal.instantiation.bindings import over_elements
from acausal.instantiation.domain import over
from acausal.instantiation.environment import ClassEnvironment
from acausal.instantiation.event_operators import before, lone
from acausal.instantiation.expressions import Environment, elaborate, elaborate_real
from acausal.instantiation.references import declaration_of
from acausal.instantiation.sinks import Name, Sink, aligned, name_of, set_twice, take_guarded
from acausal.instantiation.template import (
    INITIAL,
    TERMINAL,
    DiscreteDecl,
    Domain,
    Ref,
    ReinitDecl,
    Signal,
    TerminateDecl,
)
from acausal.instantiation.unit_algebra import added
from acausal.instantiation.values import Index
from acausal.syntax import tree
from acausal.syntax.formatter import format_expression

AddEquation = Callable[[tree.Equation, Domain, ClassEnvironment, Sink], None]


def fires(condition: tree.Expression, env: Environment) -> Expr:
    """Return the expression that is true in the instant in which a condition becomes true.

    A vector fires when one of its elements becomes true.

    Raises:
        AcausalError: ``T102`` if it is not Boolean.
    """
    value = elaborate(condition, env)
    if value.type != "Boolean" or len(value.shape) > 1:
        fail("T102", "the condition of a when must be true or false", condition.span,
             help="write a comparison, such as x > 0, or several in braces")  # fmt: skip
    result = ZERO
    for c in value.elements():
        result = build.or_(result, _edge(c, condition, env))
    return result


def _edge(c: Expr, condition: tree.Expression, env: Environment) -> Expr:
    if c.op == "const":
        return ZERO  # it never becomes true
    if isinstance(c.value, Signal) and c.value.number in (INITIAL, TERMINAL):
        return c
    now = env.signal("condition", (c,), condition)
    assert isinstance(now.value, Signal)
    return build.and_(now, build.not_(slot(replace(now.value, pre=True))))


def add_when(
    equation: tree.WhenEquation, domain: Domain, env: ClassEnvironment, sink: Sink, add: AddEquation
) -> None:
    """Add a when equation with its elsewhen branches.

    Raises:
        AcausalError: ``E006`` and ``E009`` for what the branches set, ``E008`` where a when cannot
            stand.
    """
    if sink.initial or sink.when or sink.conditional:
        where = "another when" if sink.when else "an if whose condition can change"
        if sink.initial:
            where = "initial equations"
        fail("E008", f"a when cannot stand in {where}", equation.span,
             help="use when initial() among the equations" if sink.initial
             else "move it out, and join the conditions with and")  # fmt: skip
    instants: list[Expr] = []
    bodies: list[Sink] = []
    earlier = ZERO
    for condition, body in equation.branches:
        instant = fires(condition, env)
        inside = sink.below(when=True)
        for part in body:
            add(part, domain, env, inside)
        if inside.connects:
            fail("C105", "connect stands in a when", inside.connects[0].span,
                 help="connections do not change during the simulation")  # fmt: skip
        take_guarded(sink, inside, build.and_(instant, build.not_(earlier)))
        earlier = build.or_(earlier, instant)
        instants.append(instant)
        bodies.append(inside)
    for own, branches in aligned(bodies, equation.span, "when"):
        value = before(own.target)
        for instant, branch in zip(reversed(instants), reversed(branches), strict=True):
            value = build.if_(instant, branch.value, value)
        sink.discrete.append(replace(own, value=value))


def add_reinit(
    equation: tree.CallEquation, domain: Domain, env: ClassEnvironment, sink: Sink
) -> None:
    """Add ``reinit(x, e)`` or ``reinit(v, e, f)``; the when around it says when it acts.

    Raises:
        AcausalError: ``E010`` outside of a when, or for something else than a continuous variable.
    """
    call = equation.call
    if not sink.when:
        fail("E010", "reinit stands outside of a when", equation.span,
             help="write when x < 0 then reinit(x, 0); end when;")  # fmt: skip
    if call.named or len(call.arguments) not in (2, 3):
        fail("T120", "reinit takes a variable, its new value, and perhaps a through variable",
             equation.span, help="write reinit(x, 0)")  # fmt: skip
    what, new = call.arguments[:2]
    state, value = elaborate(what, env), elaborate_real(new, env)
    require_shape(value, state.shape, "reinit", equation.span)
    added(state.unit, value.unit, "reinit of a variable in", "U102", equation.span,
          what.span, new.span)  # fmt: skip
    impulse = elaborate(call.arguments[2], env) if len(call.arguments) == 3 else None
    if impulse is not None:
        require_shape(impulse, state.shape, "reinit", equation.span)
    text = f"reinit({', '.join(format_expression(a) for a in call.arguments)})"

    def emit(index: Index, passes: Domain) -> None:
        one = _continuous(state.get(index), state.type, what, env)
        other: Expr | None = None
        if impulse is not None:
            source = call.arguments[2]
            other = _continuous(impulse.get(index), impulse.type, source, env)
            ref = other.value
            assert isinstance(ref, Ref) and env.builder is not None
            if not declaration_of(env.builder.template, ref).through:
                fail("E010", f"{format_expression(source)} is no through variable", source.span,
                     help="name the through variable of a cut that carries the "
                     "impulse")  # fmt: skip
        sink.reinits.append(
            ReinitDecl(one, value.get(index), ONE, other, passes, equation.span, text)
        )

    over_elements(state.shape, emit, domain)


def _continuous(expr: Expr, type_: str, source: tree.Expression, env: ClassEnvironment) -> Expr:
    ref = lone(expr)
    if ref is None or type_ != "Real" or env.is_discrete(ref):
        fail("E010", f"{format_expression(source)} is no continuous variable", source.span,
             label="reinit gives a new value to a variable that is differentiated",
             help="discrete variables are set by an equation in the when: b = ...")  # fmt: skip
    return expr


def add_terminate(equation: tree.CallEquation, message: str, domain: Domain, sink: Sink) -> None:
    """Add ``terminate(message)``.

    Raises:
        AcausalError: ``E008`` if nothing says when.
    """
    if not (sink.when or sink.conditional) or sink.initial:
        fail("E008", "terminate needs a condition", equation.span,
             help='write when x > 1 then terminate("..."); end when;')  # fmt: skip
    text = format_expression(equation.call)
    sink.terminates.append(TerminateDecl(ONE, message, domain, equation.span, text))


def held_names(declarations: list[DiscreteDecl]) -> frozenset[Name]:
    """Return the variables that whens set."""
    return frozenset(
        name_of(d.target.value) for d in declarations if d.held and isinstance(d.target.value, Ref)
    )


def check_set_once(declarations: list[DiscreteDecl]) -> None:
    """Refuse two whens of a class that set the same variable.

    Raises:
        AcausalError: ``E006``.
    """
    by_name: dict[Name, list[DiscreteDecl]] = {}
    for d in declarations:
        if d.held:
            assert isinstance(d.target.value, Ref)
            by_name.setdefault(name_of(d.target.value), []).append(d)
    for group in by_name.values():
        if len(group) == 1 and group[0].domain.length == 1:
            continue
        places = np.concatenate([_subscripts(d) for d in group], axis=1)
        owner = np.repeat(np.arange(len(group)), [d.domain.length for d in group])
        _, first, inverse = np.unique(places, axis=1, return_index=True, return_inverse=True)
        again = np.flatnonzero(first[np.asarray(inverse).reshape(-1)] != np.arange(len(owner)))
        if len(again):
            one = int(first[np.asarray(inverse).reshape(-1)[again[0]]])
            set_twice(group[owner[one]], group[owner[again[0]]])


def _subscripts(declaration: DiscreteDecl) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    ref = declaration.target.value
    assert isinstance(ref, Ref)
    every = [*(i for step in ref.path for i in step.index), *ref.index]
    rows = [over(declaration.domain, i) for i in every]
    rows.append(np.zeros(declaration.domain.length))
    return np.stack(rows)
