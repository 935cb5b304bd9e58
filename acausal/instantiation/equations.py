"""Equation sections of a class to declarations over domains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from acausal.diagnostics import Span, fail
from acausal.expressions import build
from acausal.expressions.nodes import ZERO, Expr, const, slot
from acausal.instantiation.algorithms import add_algorithm
from acausal.instantiation.arrays import require_shape
from acausal.instantiation.assertions import assertion, terminate_message
from acausal.instantiation.bindings import over_elements
from acausal.instantiation.connects import add_connect
from acausal.instantiation.discrete import (
    assignment,
    check_whole,
    definition,
    is_discrete_equation,
    sets_held,
)
from acausal.instantiation.domain import has_loops, only_loops, over, split_by_indices
from acausal.instantiation.environment import ClassEnvironment
from acausal.instantiation.expressions import elaborate, elaborate_condition, iteration
from acausal.instantiation.overdetermined import PREFIX, add_connections_call
from acausal.instantiation.sinks import Sink, joined
from acausal.instantiation.template import (
    INITIAL,
    DiscreteDecl,
    Domain,
    EquationDecl,
    LoopIndex,
    Signal,
)
from acausal.instantiation.unit_algebra import added
from acausal.instantiation.values import (
    LITERAL,
    Index,
    NeedsUnroll,
    Value,
    constants,
    scalar,
)
from acausal.instantiation.whens import (
    add_reinit,
    add_terminate,
    add_when,
    check_set_once,
    held_names,
)
from acausal.syntax import tree
from acausal.syntax.formatter import format_equation

if TYPE_CHECKING:
    from acausal.instantiation.elaborate import TemplateBuilder

#: A for loop that cannot stay a loop is written out up to this many passes.
LONGEST_UNROLL = 10_000


def elaborate_sections(builder: TemplateBuilder) -> None:
    """Elaborate all equations and algorithms of a class into its template."""
    template, merged = builder.template, builder.merged
    sink = Sink(False)
    everywhere = Domain()
    scope = builder.scope(merged.definition)
    for equation, owner in merged.equations:
        if owner is not scope.owner:
            scope = builder.scope(owner)
        _add(equation, everywhere, scope, sink)
    for statements, owner in merged.algorithms:
        add_algorithm(statements, builder.scope(owner), sink)
    template.equations += sink.equations
    template.connects += sink.connects
    template.asserts += sink.asserts
    template.discrete += [part for d in sink.discrete for part in _split(d)]
    template.reinits += sink.reinits
    template.terminates += sink.terminates
    template.branches += sink.branches
    template.roots += sink.roots
    check_set_once(template.discrete)
    start = Sink(True, held=held_names(template.discrete))
    for equation, owner in merged.initial_equations:
        _add(equation, Domain(), builder.scope(owner), start)
    for statements, owner in merged.initial_algorithms:
        add_algorithm(statements, builder.scope(owner), start)
    template.initial_equations += start.equations
    template.initial_discrete += [part for d in start.discrete for part in _split(d)]
    first = slot(Signal(INITIAL))
    template.asserts += [
        replace(a, condition=build.or_(build.not_(first), a.condition)) for a in start.asserts
    ]


def _split(declaration: DiscreteDecl) -> list[DiscreteDecl]:
    """Split an assignment where a condition on loop indices selects between values."""
    return [
        replace(declaration, value=value, domain=domain)
        for domain, value in split_by_indices(declaration.domain, declaration.value)
    ]


def _add(equation: tree.Equation, domain: Domain, env: ClassEnvironment, sink: Sink) -> None:
    env = env if domain is env.domain else env.inside(domain)
    if isinstance(equation, tree.SimpleEquation):
        _simple(equation, domain, env, sink)
    elif isinstance(equation, tree.ConnectEquation):
        add_connect(equation, domain, env, sink)
    elif isinstance(equation, tree.ForEquation):
        _for(equation.indices, equation.body, domain, env, sink)
    elif isinstance(equation, tree.IfEquation):
        _if(list(equation.branches), equation.otherwise, domain, env, sink, equation.span)
    elif isinstance(equation, tree.WhenEquation):
        add_when(equation, domain, env, sink, _add)
    else:
        assert isinstance(equation, tree.CallEquation)
        _call(equation, domain, env, sink)


def _simple(
    equation: tree.SimpleEquation, domain: Domain, env: ClassEnvironment, sink: Sink
) -> None:
    if isinstance(equation.left, tree.TupleExpression):
        _tuple(equation, domain, env, sink)
        return
    left, right = elaborate(equation.left, env), elaborate(equation.right, env)
    _equate(equation, left, right, domain, env, sink)


def _tuple(
    equation: tree.SimpleEquation, domain: Domain, env: ClassEnvironment, sink: Sink
) -> None:
    assert isinstance(equation.left, tree.TupleExpression)
    if not isinstance(equation.right, tree.Call):
        fail("T131", "a list of variables can only be set by a function", equation.span,
             help="write one equation for each")  # fmt: skip
    results = env.call_all(equation.right, env)
    targets = equation.left.elements
    if len(targets) > len(results):
        fail("T131", f"{equation.right.function} gives {len(results)} values, not {len(targets)}",
             equation.span, help="remove variables on the left")  # fmt: skip
    for target, value in zip(targets, results, strict=False):
        if target is not None:
            _equate(equation, elaborate(target, env), value, domain, env, sink)


def _equate(
    equation: tree.SimpleEquation,
    left: Value,
    right: Value,
    domain: Domain,
    env: ClassEnvironment,
    sink: Sink,
) -> None:
    if left.fields is not None or right.fields is not None:
        if left.fields is None or right.fields is None or set(left.fields) != set(right.fields):
            fail("T132", "the two sides are not records of the same fields", equation.span,
                 help="compare field by field")  # fmt: skip
        for name, part in left.fields.items():
            _equate(equation, part, right.fields[name], domain, env, sink)
        return
    require_shape(right, left.shape, "the two sides differ in size", equation.span)
    added(left.unit, right.unit, "the two sides are in", "U102", equation.span,
          equation.left.span, equation.right.span)  # fmt: skip
    text = format_equation(equation)
    owner = env.owner.full_name
    discrete = is_discrete_equation(left, right, equation)

    def emit(index: Index, domain_: Domain) -> None:
        one, other = left.get(index), right.get(index)
        if sink.when:
            sink.discrete.append(
                assignment(one, other, left, right, domain_, equation, text, owner)
            )
            return
        if discrete or (sink.initial and sets_held(one, other, sink.held)):
            own = definition(one, other, discrete, domain_, equation, text, owner, sink)
            if own is not None:
                sink.discrete.append(own)
            return
        check_whole(one, other, left, right, equation)
        residual = build.sub(one, other)
        if residual.op == "const":
            _trivial(residual, equation.span)
        _keep(sink, EquationDecl(residual, domain_, equation.span, text, owner))

    over_elements(left.shape, emit, domain)


def _trivial(residual: Expr, span: Span) -> None:
    if residual is ZERO:
        fail("B103", "this equation says nothing: both sides are the same", span,
             help="remove it")  # fmt: skip
    fail("B104", "this equation can never hold: both sides are different numbers", span,
         help="an unknown is missing in it")  # fmt: skip


def _keep(sink: Sink, declaration: EquationDecl) -> None:
    """Store an equation, split where a condition on loop indices selects between forms."""
    for domain, residual in split_by_indices(declaration.domain, declaration.residual):
        sink.equations.append(replace(declaration, residual=residual, domain=domain))


# --- loops and conditions ----------------------------------------------------------------


def _for(
    loops: Sequence[tree.ForIndex],
    body: tuple[tree.Equation, ...],
    domain: Domain,
    env: ClassEnvironment,
    sink: Sink,
) -> None:
    if not loops:
        for equation in body:
            _add(equation, domain, env, sink)
        return
    values = iteration(loops[0], env)
    if values.size > 50_000_000:
        fail("T122", f"a loop of {values.size} passes is too long", loops[0].span,
             help="check its range")  # fmt: skip
    numbers = constants(values)
    if numbers is None:
        if any(has_loops(e) for e in values.elements()):
            raise NeedsUnroll
        fail("T103", "the range of a loop must be known before the simulation", loops[0].span,
             help="use Integer parameters and constants here")  # fmt: skip
    if not len(numbers):
        return
    name = f"{loops[0].name}#{len(domain.names)}"
    index = scalar(slot(LoopIndex(name)), values.type, LITERAL, values.enumeration)
    attempt = sink.below()
    assert env.builder is not None
    declared = len(env.builder.template.signals)
    try:
        inner = env.with_locals({loops[0].name: index})
        _for(loops[1:], body, domain.product(name, numbers), inner, attempt)
    except NeedsUnroll:
        if len(numbers) > LONGEST_UNROLL:
            fail("T129", f"this loop has {len(numbers)} passes and cannot be written out",
                 loops[0].span,
                 help="subscript declared arrays by the loop index, "
                 "not array literals")  # fmt: skip
        attempt = sink.below()
        env.builder.forget_signals(declared)
        for number_ in numbers:
            value = scalar(const(float(number_)), values.type, LITERAL, values.enumeration)
            _for(loops[1:], body, domain, env.with_locals({loops[0].name: value}), attempt)
    sink.take(attempt)


def _if(
    branches: list[tuple[tree.Expression, tuple[tree.Equation, ...]]],
    otherwise: tuple[tree.Equation, ...],
    domain: Domain,
    env: ClassEnvironment,
    sink: Sink,
    span: Span,
) -> None:
    if not branches:
        for equation in otherwise:
            _add(equation, domain, env, sink)
        return
    condition, body = branches[0]
    c = elaborate_condition(condition, env).expr
    if c.op == "const":
        if c is not ZERO:
            for equation in body:
                _add(equation, domain, env, sink)
        else:
            _if(branches[1:], otherwise, domain, env, sink, span)
        return
    if only_loops(c):
        # Inside a branch the subscripts must be valid only where the condition holds.
        holds = over(domain, c) != 0.0
        if holds.any():
            for equation in body:
                _add(equation, domain.where(holds), env, sink)
        if not holds.all():
            _if(branches[1:], otherwise, domain.where(~holds), env, sink, span)
        return
    _both(c, branches, otherwise, domain, env, sink, span)


def _both(
    c: Expr,
    branches: list[tuple[tree.Expression, tuple[tree.Equation, ...]]],
    otherwise: tuple[tree.Equation, ...],
    domain: Domain,
    env: ClassEnvironment,
    sink: Sink,
    span: Span,
) -> None:
    first, second = sink.below(conditional=True), sink.below(conditional=True)
    for equation in branches[0][1]:
        _add(equation, domain, env, first)
    _if(branches[1:], otherwise, domain, env, second, span)
    joined(c, first, second, sink, span, lambda e: _keep(sink, e))


# --- calls -------------------------------------------------------------------------------


def _call(equation: tree.CallEquation, domain: Domain, env: ClassEnvironment, sink: Sink) -> None:
    name = str(equation.call.function)
    if name == "reinit":
        add_reinit(equation, domain, env, sink)
    elif name == "terminate":
        add_terminate(equation, terminate_message(equation.call, env), domain, sink)
    elif name == "assert":
        own = assertion(equation.call, env, domain)
        if own is not None:
            sink.asserts.append(own)
    elif name.startswith(f"{PREFIX}."):
        add_connections_call(equation.call, domain, env, sink)
    else:
        env.call(equation.call)
        fail("T133", f"{name} is not an equation", equation.span,
             help="write left = right")  # fmt: skip
