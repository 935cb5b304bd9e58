"""Equation sections of a class to equations, connections and assertions over domains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from acausal.diagnostics import Label, Span, fail
from acausal.expressions import build
from acausal.expressions.nodes import ZERO, Expr, const, slot
from acausal.instantiation.arrays import require_shape, shape_text
from acausal.instantiation.bindings import over_elements
from acausal.instantiation.domain import has_loops, only_loops, over, split_by_indices
from acausal.instantiation.environment import ClassEnvironment
from acausal.instantiation.expressions import elaborate, elaborate_condition, iteration
from acausal.instantiation.subscripts import axis
from acausal.instantiation.template import (
    AssertDecl,
    ConnectDecl,
    CutRef,
    Domain,
    EquationDecl,
    LoopIndex,
    Step,
    Template,
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
from acausal.syntax import tree
from acausal.syntax.formatter import format_equation, format_expression

if TYPE_CHECKING:
    from acausal.instantiation.elaborate import TemplateBuilder

#: A for loop that cannot stay a loop is written out up to this many passes.
LONGEST_UNROLL = 10_000


@dataclass
class _Sink:
    """Where elaborated equations go; sections collect into one and commit it when complete."""

    initial: bool
    equations: list[EquationDecl] = field(default_factory=list)
    connects: list[ConnectDecl] = field(default_factory=list)
    asserts: list[AssertDecl] = field(default_factory=list)

    def take(self, other: _Sink) -> None:
        self.equations += other.equations
        self.connects += other.connects
        self.asserts += other.asserts


def elaborate_sections(builder: TemplateBuilder) -> None:
    """Elaborate all equations of a class into its template."""
    template, merged = builder.template, builder.merged
    sink, start = _Sink(False), _Sink(True)
    for equation, owner in merged.equations:
        _add(equation, Domain(), builder.scope(owner), sink)
    for equation, owner in merged.initial_equations:
        _add(equation, Domain(), builder.scope(owner), start)
    for statements, _ in (*merged.algorithms, *merged.initial_algorithms):
        if statements:
            fail("E003", "algorithm sections in models are not supported in this version",
                 statements[0].span,
                 help="write equations, or put the algorithm into a function")  # fmt: skip
    template.equations += sink.equations
    template.connects += sink.connects
    template.asserts += sink.asserts
    template.initial_equations += start.equations


def _add(equation: tree.Equation, domain: Domain, env: ClassEnvironment, sink: _Sink) -> None:
    if isinstance(equation, tree.SimpleEquation):
        _simple(equation, domain, env, sink)
    elif isinstance(equation, tree.ConnectEquation):
        _connect(equation, domain, env, sink)
    elif isinstance(equation, tree.ForEquation):
        _for(equation.indices, equation.body, domain, env, sink)
    elif isinstance(equation, tree.IfEquation):
        _if(list(equation.branches), equation.otherwise, domain, env, sink, equation.span)
    elif isinstance(equation, tree.CallEquation):
        _call(equation, domain, env, sink)
    else:
        fail("E001", "when is not supported in this version", equation.span,
             help="this version simulates continuous models")  # fmt: skip


def _simple(
    equation: tree.SimpleEquation, domain: Domain, env: ClassEnvironment, sink: _Sink
) -> None:
    if isinstance(equation.left, tree.TupleExpression):
        _tuple(equation, domain, env, sink)
        return
    left, right = elaborate(equation.left, env), elaborate(equation.right, env)
    _equate(equation, left, right, domain, env, sink)


def _tuple(
    equation: tree.SimpleEquation, domain: Domain, env: ClassEnvironment, sink: _Sink
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
    sink: _Sink,
) -> None:
    if left.fields is not None or right.fields is not None:
        if left.fields is None or right.fields is None or set(left.fields) != set(right.fields):
            fail("T132", "the two sides are not records of the same fields", equation.span,
                 help="compare field by field")  # fmt: skip
        for name, part in left.fields.items():
            _equate(equation, part, right.fields[name], domain, env, sink)
        return
    for value, side in ((left, equation.left), (right, equation.right)):
        if value.type not in ("Real", "Integer"):
            fail("T101", f"an equation needs numbers, not {value.type}", side.span,
                 help="Boolean and enumeration equations are not supported")  # fmt: skip
    require_shape(right, left.shape, "the two sides differ in size", equation.span)
    added(left.unit, right.unit, "the two sides are in", "U102", equation.span,
          equation.left.span, equation.right.span)  # fmt: skip
    text = format_equation(equation)

    def emit(index: Index, domain_: Domain) -> None:
        residual = build.sub(left.get(index), right.get(index))
        if residual.op == "const":
            _trivial(residual, equation.span)
        _keep(sink, EquationDecl(residual, domain_, equation.span, text, env.owner.full_name))

    over_elements(left.shape, emit, domain)


def _trivial(residual: Expr, span: Span) -> None:
    if residual is ZERO:
        fail("B103", "this equation says nothing: both sides are the same", span,
             help="remove it")  # fmt: skip
    fail("B104", "this equation can never hold: both sides are different numbers", span,
         help="an unknown is missing in it")  # fmt: skip


def _keep(sink: _Sink, declaration: EquationDecl) -> None:
    """Store an equation, split where a condition on loop indices selects between forms."""
    for domain, residual in split_by_indices(declaration.domain, declaration.residual):
        sink.equations.append(replace(declaration, residual=residual, domain=domain))


# --- loops and conditions ----------------------------------------------------------------


def _for(
    loops: Sequence[tree.ForIndex],
    body: tuple[tree.Equation, ...],
    domain: Domain,
    env: ClassEnvironment,
    sink: _Sink,
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
    index = scalar(slot(LoopIndex(name)), values.type, LITERAL)
    attempt = _Sink(sink.initial)
    try:
        inner = env.with_locals({loops[0].name: index})
        _for(loops[1:], body, domain.product(name, numbers), inner, attempt)
    except NeedsUnroll:
        if len(numbers) > LONGEST_UNROLL:
            fail("T129", f"this loop has {len(numbers)} passes and cannot be written out",
                 loops[0].span,
                 help="subscript declared arrays by the loop index, "
                 "not array literals")  # fmt: skip
        attempt = _Sink(sink.initial)
        for number_ in numbers:
            value = scalar(const(float(number_)), values.type, LITERAL)
            _for(loops[1:], body, domain, env.with_locals({loops[0].name: value}), attempt)
    sink.take(attempt)


def _if(
    branches: list[tuple[tree.Expression, tuple[tree.Equation, ...]]],
    otherwise: tuple[tree.Equation, ...],
    domain: Domain,
    env: ClassEnvironment,
    sink: _Sink,
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
    sink: _Sink,
    span: Span,
) -> None:
    first, second = _Sink(sink.initial), _Sink(sink.initial)
    for equation in branches[0][1]:
        _add(equation, domain, env, first)
    _if(branches[1:], otherwise, domain, env, second, span)
    if first.connects or second.connects:
        fail("C105", "connect stands under a condition that can change", span,
             help="use a Boolean parameter in the condition")  # fmt: skip
    rows = [sum(e.domain.length for e in s.equations) for s in (first, second)]
    same = len(first.equations) == len(second.equations) and all(
        a.domain.names == b.domain.names and a.domain.length == b.domain.length
        for a, b in zip(first.equations, second.equations, strict=False)
    )
    if not same:
        fail("B105", f"the branches of this if have {rows[0]} and {rows[1]} equations", span,
             label="a condition that can change must choose between equally many equations",
             help="give every branch the same number of equations")  # fmt: skip
    for a, b in zip(first.equations, second.equations, strict=True):
        _keep(sink, replace(a, residual=build.if_(c, a.residual, b.residual),
                            text=f"if … then {a.text} else {b.text}"))  # fmt: skip


# --- assert ------------------------------------------------------------------------------


def _call(equation: tree.CallEquation, domain: Domain, env: ClassEnvironment, sink: _Sink) -> None:
    name = str(equation.call.function)
    if name != "assert":
        if name.startswith("Connections"):
            return
        env.call(equation.call)
        fail("T133", f"{name} is not an equation", equation.span,
             help="write left = right")  # fmt: skip
    call = equation.call
    named = {n.name: n.value for n in call.named}
    arguments = list(call.arguments)
    for missing in ("condition", "message", "level")[len(arguments) :]:
        if missing in named:
            arguments.append(named[missing])
    if len(arguments) not in (2, 3):
        fail("T120", "assert takes a condition, a message and a level", equation.span,
             help='write assert(x > 0, "x must be positive")')  # fmt: skip
    condition = elaborate_condition(arguments[0], env)
    message = arguments[1]
    text = _message(message)
    warning = len(arguments) == 3 and format_expression(arguments[2]).endswith("warning")
    if condition.expr.op == "const" and condition.expr is not ZERO:
        return
    sink.asserts.append(
        AssertDecl(
            condition.expr, domain, text, warning, equation.span, format_expression(arguments[0])
        )
    )


def _message(expression: tree.Expression) -> str:
    """Return the fixed part of a message; what String(x) would put in is left out."""
    if isinstance(expression, tree.StringLiteral):
        return expression.value
    if isinstance(expression, tree.Binary):
        return _message(expression.left) + _message(expression.right)
    return "…"


# --- connect -----------------------------------------------------------------------------


@dataclass(frozen=True)
class _Cut:
    """A cut or an array of cuts named in a connect equation."""

    steps: tuple[tuple[str, tuple[Value, ...]], ...]
    template: Template
    outer: str
    inner_face: bool
    shape: tuple[int, ...]
    span: Span

    def at(self, index: Index) -> CutRef:
        free = iter(index)
        path = tuple(
            Step(n, tuple(a.get((next(free),)) if a.shape else a.expr for a in axes))
            for n, axes in self.steps
        )
        return CutRef(path, self.outer, self.inner_face)


def _connect(
    equation: tree.ConnectEquation, domain: Domain, env: ClassEnvironment, sink: _Sink
) -> None:
    if sink.initial:
        fail("C104", "connect does not belong into initial equations", equation.span,
             help="move it to the equation section")  # fmt: skip
    found = [_cut(reference, env) for reference in equation.cuts]
    cuts = [c for c in found if c is not None]
    if len(cuts) < 2:
        return
    first = cuts[0]
    for other in cuts[1:]:
        if other.shape != first.shape:
            fail("C102", f"connecting {shape_text(first.shape)} with {shape_text(other.shape)}",
                 equation.span,
                 labels=[Label(first.span, shape_text(first.shape)),
                         Label(other.span, shape_text(other.shape))],
                 help="connect arrays of the same size, "
                 "or pick elements by subscripts")  # fmt: skip
        check_alike(first.template, other.template, equation.span, first.span, other.span)

    def emit(index: Index, domain_: Domain) -> None:
        sink.connects.append(ConnectDecl(tuple(c.at(index) for c in cuts), domain_, equation.span))

    over_elements(first.shape, emit, domain)


def _cut(reference: tree.Reference, env: ClassEnvironment) -> _Cut | None:
    builder = env.builder
    assert builder is not None
    first = reference.parts[0].name
    if first not in builder.merged.elements:
        env.unknown(reference)
    builder.declare(first)
    template = builder.template
    outer = ""
    inner_face = False
    steps: list[tuple[str, tuple[Value, ...]]] = []
    for k, part in enumerate(reference.parts):
        if k == 0 and part.name in template.outers and part.name not in template.children:
            outer, template = part.name, template.outers[part.name]
            continue
        if part.name in template.absent:
            return None
        if part.name not in template.children:
            _not_a_cut(reference, k, template)
        child = template.children[part.name]
        if k and template.is_connector:
            fail("C103", f"{reference} is inside a connector", part.span,
                 help="connect the connector as a whole")  # fmt: skip
        if len(part.subscripts) > len(child.shape):
            fail("T113", f"{part.name} has {len(child.shape)} dimensions", part.span,
                 help="use fewer subscripts")  # fmt: skip
        given = (*part.subscripts, *[None] * (len(child.shape) - len(part.subscripts)))
        axes = tuple(axis(s, n, env) for s, n in zip(given, child.shape, strict=True))
        steps.append((part.name, axes))
        inner_face = k == 0 and child.template.is_connector
        template = child.template
    if not template.is_connector:
        fail("C101", f"{reference} is a component, not a cut", reference.span,
             label=f"a {template.name}",
             help="name one of its cuts: "
             + (", ".join(n for n, c in template.children.items() if c.template.is_connector)
                or "it has none"))  # fmt: skip
    shape = tuple(a.size for _, axes in steps for a in axes if a.shape)
    return _Cut(tuple(steps), template, outer, inner_face, shape, reference.span)


def _not_a_cut(reference: tree.Reference, k: int, template: Template) -> None:
    from acausal.diagnostics.suggest import nearest

    name = reference.parts[k].name
    known = [n for n, c in template.children.items()]
    if name in template.variables or name in template.parameters or name in template.structural:
        fail("C101", f"{reference} is a variable, not a cut", reference.parts[k].span,
             help="write an equation between variables; connect joins cuts")  # fmt: skip
    close = nearest(name, known)
    fail("N102", f"{template.name} has nothing called {name}", reference.parts[k].span,
         label="this name is not declared there",
         notes=[f"did you mean {' or '.join(close)}?"] if close else [],
         help=f"write {close[0]}, if that is what you mean" if close
         else f"acausal list {template.name} shows what it has")  # fmt: skip


def cut_leaves(
    template: Template, prefix: tuple[str, ...] = ()
) -> list[tuple[tuple[str, ...], int, bool, str]]:
    """Return the variables of a cut: path, number of scalars, through or not, unit."""
    result = [((*prefix, v.name), v.size, v.through, v.unit) for v in template.variables.values()]
    for name, child in template.children.items():
        for path, size, through, unit in cut_leaves(child.template, (*prefix, name)):
            result.append((path, size * child.size, through, unit))
    return result


def check_alike(a: Template, b: Template, span: Span, first: Span, second: Span) -> None:
    """Refuse to join unlike cuts.

    Raises:
        AcausalError: ``C101`` if their variables differ, ``U107`` if their units do.
    """
    if a is b:
        return
    mine = {path: (size, through) for path, size, through, _ in cut_leaves(a)}
    other = {path: (size, through) for path, size, through, _ in cut_leaves(b)}
    labels = [Label(first, f"a {a.name}"), Label(second, f"a {b.name}")]
    if mine != other:
        fail("C101", f"a {a.name} cannot be connected to a {b.name}", span,
             label="the two cuts have different variables", labels=labels,
             help="connect cuts of one field; a transducer couples two fields")  # fmt: skip
    units = dict.fromkeys(mine, "")
    for path, _, _, unit in cut_leaves(a):
        units[path] = unit
    from acausal.units.unit import parse_unit

    for path, _, _, unit in cut_leaves(b):
        if unit and units[path] and parse_unit(unit).dimension != parse_unit(units[path]).dimension:
            fail("U107", f"connecting {units[path]} with {unit}", span, labels=labels,
                 label="the two cuts have different units",
                 help="put a converter between them")  # fmt: skip
