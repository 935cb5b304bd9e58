"""Overdetermined records in cuts, such as orientations (Modelica 3.6, section 9.4).

A 3-D orientation is three numbers' worth of information in twelve variables. Equating all of them
along a loop of bodies would state more than is true, and a free body has to find its orientation
itself. Models therefore say how orientations hang together: ``Connections.branch(a.R, b.R)`` where
a component turns one into the other, ``Connections.root(a.R)`` where one is given,
``Connections.potentialRoot(a.R, priority)`` where one can be. What follows from it for a whole
model is found in :mod:`acausal.connections.spanning`; a class asks for it by
``Connections.isRoot(a.R)`` and ``Connections.rooted(a.R)``. The answers come back as structural
values of the instances.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from acausal.diagnostics import Span, fail
from acausal.expressions.nodes import Expr, slot
from acausal.instantiation.bindings import over_elements
from acausal.instantiation.connects import Cut, cut_named
from acausal.instantiation.sinks import Sink
from acausal.instantiation.template import (
    Ask,
    BranchDecl,
    Domain,
    NodeRef,
    RootDecl,
    Template,
)
from acausal.instantiation.values import Index, Value, constants, number
from acausal.instantiation.vectorised_calls import call_function
from acausal.modeling.classes import ClassDef
from acausal.syntax import tree

if TYPE_CHECKING:
    from acausal.instantiation.environment import ClassEnvironment

#: Name of the function that says when two such records mean the same.
CONSTRAINT = "equalityConstraint"
PREFIX = "Connections"


@dataclass(frozen=True)
class _Node:
    """An overdetermined record, or an array of them, as named in a model."""

    cut: Cut
    record: str

    def at(self, index: Index) -> NodeRef:
        return NodeRef(self.cut.at(index), self.record)


def constraint_of(record: Template) -> ClassDef | None:
    """Return the ``equalityConstraint`` of a record class, None if it has none."""
    if record.definition.kind != "record":
        return None
    found = record.definition.find(CONSTRAINT)
    return found if isinstance(found, ClassDef) and found.kind == "function" else None


def record_size(record: Template) -> int:
    """Return the number of variables in a record."""
    own = sum(v.size for v in record.variables.values())
    return own + sum(c.size * record_size(c.template) for c in record.children.values())


def residues(record: Template, span: Span) -> list[Expr]:
    """Return what vanishes where two records mean the same.

    The variables of the first record are slots 0, 1, ... in the order of :func:`record_ids`'
    columns, those of the second follow.

    Raises:
        AcausalError: For mistakes in ``equalityConstraint``.
    """
    from acausal.instantiation.environment import ClassEnvironment

    function = constraint_of(record)
    assert function is not None
    call = tree.Call(span, tree.Reference(span, (tree.NamePart(span, CONSTRAINT),)))
    first = _record_value(record, 0)
    second = _record_value(record, record_size(record))
    outside = ClassEnvironment(None, function, None, 1)
    results = call_function(function, call, [first, second], {}, outside, 1)
    return results[0].elements()


def excess(record: Template, span: Span) -> int:
    """Return how many variables of a record are more than what it says."""
    return record_size(record) - len(residues(record, span))


def excess_rows(template: Template) -> int:
    """Return how many equations a class brings beyond those of its physics.

    A cut with an overdetermined record counts as if the record had no excess; each branch and
    each root sets all variables of a record.
    """
    rows = 0
    for child in template.children.values():
        if child.template.is_connector:
            for part in child.template.children.values():
                if constraint_of(part.template) is not None:
                    rows -= child.size * part.size * excess(part.template, template.span)
    for branch in template.branches:
        rows += branch.domain.length * excess(_record_at(template, branch.tail), branch.span)
    for root in template.roots:
        ask = Ask("isRoot", root.node)
        if root.priority is None or template.answers.get(ask.text, False):
            rows += root.domain.length * excess(_record_at(template, root.node), root.span)
    return rows


def _record_at(template: Template, node: NodeRef) -> Template:
    where = template.outers[node.cut.outer] if node.cut.outer else template
    for step in node.cut.path:
        where = where.children[step.name].template
    return where.children[node.record].template


def _record_value(record: Template, first: int) -> Value:
    """Return a record of slots that are numbered from ``first``."""
    fields: dict[str, Value] = {}
    for name, declared in record.variables.items():
        fields[name] = _slots(declared.shape, first)
        first += declared.size
    for name, child in record.children.items():
        fields[name] = _record_value(child.template, first)
        first += record_size(child.template)
    return Value("record", (), lambda _: next(iter(fields.values())).expr, None, None, fields)


def _slots(shape: tuple[int, ...], first: int) -> Value:
    from acausal.instantiation.values import listed

    size = int(np.prod(shape, dtype=np.int64))
    return listed([slot(first + k) for k in range(size)], shape)


def add_connections_call(
    call: tree.Call, domain: Domain, env: ClassEnvironment, sink: Sink
) -> None:
    """Add ``Connections.branch``, ``root`` or ``potentialRoot`` to a class.

    Raises:
        AcausalError: ``C106`` for other names or arguments, ``C105`` under a condition that can
            change.
    """
    operator = _operator(call)
    if sink.conditional or sink.when or sink.initial:
        fail("C105", f"{call.function} belongs to the structure of the model", call.span,
             help="write it in the equation section, under no condition or one of "
             "structural parameters")  # fmt: skip
    wanted = {"branch": 2, "root": 1, "potentialRoot": 1}.get(operator)
    if wanted is None:
        _refuse(call)
    arguments = call.arguments
    priority: int | None = 0 if operator == "potentialRoot" else None
    if operator == "potentialRoot":
        given = [n.value for n in call.named if n.name == "priority"] + [*arguments[1:2]]
        if given:
            priority = _priority(given[0], env)
        arguments = arguments[:1]
    if len(arguments) != wanted:
        _refuse(call)
    nodes = [_node(a, call, env) for a in arguments]
    if any(n is None for n in nodes):
        return
    known = [n for n in nodes if n is not None]
    if len(known) == 2 and known[0].cut.shape != known[1].cut.shape:
        _refuse(call)

    def emit(index: Index, domain_: Domain) -> None:
        ends = [n.at(index) for n in known]
        if len(ends) == 2:
            sink.branches.append(BranchDecl(ends[0], ends[1], domain_, call.span))
        else:
            sink.roots.append(RootDecl(ends[0], priority, domain_, call.span))

    over_elements(known[0].cut.shape, emit, domain)


def ask_connections(call: tree.Call, env: ClassEnvironment) -> Value:
    """Return the value of ``Connections.isRoot(a.R)`` or ``Connections.rooted(a.R)``.

    Before the whole model is known, no record is a root and all are nearer to it than the other
    end of their branch.

    Raises:
        AcausalError: ``C106`` for other names or arguments.
    """
    operator = _operator(call)
    if operator not in ("isRoot", "rooted") or len(call.arguments) != 1 or call.named:
        _refuse(call)
    node = _node(call.arguments[0], call, env)
    if node is None:
        return number(0.0, "Boolean", None)
    builder = env.builder
    assert builder is not None
    if node.cut.shape:
        _refuse(call)
    ask = Ask(operator, node.at(()))
    builder.template.asks.setdefault(ask.text, ask)
    answer = builder.environment.values.get((ask.text,))
    holds = operator == "rooted" if answer is None else bool(answer.expr.value)
    builder.template.answers[ask.text] = holds
    return number(float(holds), "Boolean", None)


def _operator(call: tree.Call) -> str:
    parts = call.function.parts
    return parts[1].name if len(parts) == 2 else ""


def _refuse(call: tree.Call) -> NoReturn:
    fail("C106", f"{call.function} cannot be used like this", call.span,
         help="write Connections.branch(a.R, b.R), root(a.R), potentialRoot(a.R, priority), "
         "isRoot(a.R) or rooted(a.R) for a record R of a cut a")  # fmt: skip


def _priority(expression: tree.Expression, env: ClassEnvironment) -> int:
    from acausal.instantiation.expressions import elaborate

    numbers = constants(elaborate(expression, env))
    if numbers is None or numbers.shape:
        fail("T103", "the priority of a root must be known before the simulation",
             expression.span, help="write a whole number")  # fmt: skip
    return int(numbers)


def _node(argument: tree.Expression, call: tree.Call, env: ClassEnvironment) -> _Node | None:
    if env.builder is None or not isinstance(argument, tree.Reference) or len(argument.parts) < 2:
        _refuse(call)
    parts = argument.parts
    where = tree.Reference(argument.span, parts[:-1], argument.absolute)
    cut = cut_named(where, env)
    if cut is None:
        return None
    record = cut.template.children.get(parts[-1].name)
    if record is None or record.shape or constraint_of(record.template) is None:
        fail("C106", f"{argument} is not an overdetermined record", argument.span,
             help=f"name a record of a cut whose class has a function {CONSTRAINT}")  # fmt: skip
    return _Node(cut, parts[-1].name)
