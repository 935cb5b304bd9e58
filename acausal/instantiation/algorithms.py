"""Algorithm sections of models (Modelica 3.6, section 11.1): one equation for each variable set.

A section is executed symbolically. What a variable holds at its end, as an expression, is its
equation. A variable that is read before it is set has the value before the event if it changes at
events only, and its start value otherwise; both are put in when all is known, for only then it is
clear which variables the section sets, and which of them it sets in whens only.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NoReturn

from acausal.diagnostics import Span, fail
from acausal.expressions import build
from acausal.expressions.nodes import ONE, ZERO, Expr, const, slot
from acausal.expressions.traverse import slot_nodes, substitute, substitute_all
from acausal.instantiation import unit_algebra as units
from acausal.instantiation.arrays import LONGEST_REDUCTION, require_shape
from acausal.instantiation.assertions import assertion, terminate_message
from acausal.instantiation.discrete import check_assignable
from acausal.instantiation.environment import ClassEnvironment
from acausal.instantiation.event_operators import before, lone
from acausal.instantiation.expressions import elaborate
from acausal.instantiation.merge import primitive_type, type_of
from acausal.instantiation.references import declaration_of, follow
from acausal.instantiation.sinks import Sink, name_of
from acausal.instantiation.statements import Break, choose, run
from acausal.instantiation.subscripts import subscripted
from acausal.instantiation.template import (
    AssertDecl,
    DiscreteDecl,
    Domain,
    EquationDecl,
    Ref,
    TerminateDecl,
    Unset,
)
from acausal.instantiation.values import Index, Value, indices
from acausal.instantiation.whens import fires
from acausal.syntax import tree
from acausal.syntax.formatter import format_expression


@dataclass
class _Where:
    """Where a variable is set: the last statement, and whether whens alone do it."""

    statement: tree.Assignment
    held: bool
    discrete: bool


@dataclass
class ModelMemory:
    """The variables of a model while one of its algorithms runs.

    Attributes:
        outside: Environment of the class the algorithm is written in.
        initial: The algorithm is an initial one.
        hidden: Values of loop indices.
        now: Present value of every variable set so far, by its slot.
        where: Where each variable is set, in order.
        guards: Conditions of the branches around the present statement.
    """

    outside: ClassEnvironment
    initial: bool
    hidden: dict[str, Value] = field(default_factory=dict)
    now: dict[Expr, Expr] = field(default_factory=dict)
    where: dict[Expr, _Where] = field(default_factory=dict)
    guards: list[Expr] = field(default_factory=list)
    asserts: list[AssertDecl] = field(default_factory=list)
    terminates: list[TerminateDecl] = field(default_factory=list)
    in_when: bool = False

    # --- reading -------------------------------------------------------------------------

    def reference(self, reference: tree.Reference) -> Value:
        """Return the present value of a variable, or a constant."""
        first = reference.parts[0]
        if first.name in self.hidden and not reference.absolute:
            return subscripted(self.hidden[first.name], first.subscripts, self, reference.span)
        if not self._of_model(reference):
            return self.outside.constant(reference)
        return _present(self.stored(reference), dict(self.now))

    def _of_model(self, reference: tree.Reference) -> bool:
        builder = self.outside.builder
        assert builder is not None
        return not reference.absolute and reference.parts[0].name in builder.merged.elements

    def stored(self, reference: tree.Reference) -> Value:
        """Return the variable that a reference names."""
        builder = self.outside.builder
        assert builder is not None
        if reference.parts[0].name in self.hidden or not self._of_model(reference):
            return self.reference(reference)
        return follow(builder, reference, self)

    def call(self, call: tree.Call) -> Value:
        """Return the value of a function call."""
        return self.outside.call_in(call, self)

    def results(self, call: tree.Call) -> list[Value]:
        """Return all outputs of a function call."""
        return self.outside.call_all(call, self)

    def signal(self, kind: str, operands: tuple[Expr, ...], source: tree.Expression) -> Expr:
        """Return the slot of a signal."""
        return self.outside.signal(kind, operands, source)

    def events(self, call: tree.Call) -> None:
        """Allow the operators of hybrid systems."""

    def is_discrete(self, ref: Ref) -> bool:
        """Tell whether a variable is declared to change at events only."""
        return self.outside.is_discrete(ref)

    def component_shape(self, reference: tree.Reference) -> tuple[int, ...] | None:
        """Return the array dimensions of a component; None if the name means a value."""
        return self.outside.component_shape(reference)

    def with_locals(self, values: dict[str, Value]) -> ModelMemory:
        """Return the environment with loop indices that hide other names."""
        return replace(self, hidden={**self.hidden, **values})

    # --- writing -------------------------------------------------------------------------

    def assign(self, target: tree.Reference, value: Value, statement: tree.Assignment) -> None:
        """Give a variable, or some of its elements, a value.

        Raises:
            AcausalError: ``T126`` for what cannot be set, ``T101`` and ``T104`` for a value of
                another type or size.
        """
        if target.parts[0].name in self.hidden or not self._of_model(target):
            _not_assignable(target, "it is no variable of this class")
        *path, last = target.parts
        whole = self.stored(replace(target, parts=(*path, replace(last, subscripts=()))))
        self._store(whole, target, last.subscripts, value, statement)

    def _store(
        self, whole: Value, target: tree.Reference, subscripts: tuple[tree.Expression, ...],
        value: Value, statement: tree.Assignment,
    ) -> None:  # fmt: skip
        if whole.fields is not None:
            if value.fields is None or set(value.fields) != set(whole.fields) or subscripts:
                fail("T132", f"{target} and its value are not records of the same fields",
                     statement.span, help="assign field by field")  # fmt: skip
            for name, part in whole.fields.items():
                self._store(part, target, (), value.fields[name], statement)
            return
        check_assignable(whole, value, str(target), statement.span)
        units.added(whole.unit, value.unit, f"{target} is given", "U106", statement.span,
                    target.span, statement.value.span)  # fmt: skip
        if whole.size > LONGEST_REDUCTION:
            fail("T107", f"{target} has {whole.size} elements, which is too many for an algorithm",
                 statement.span, help="set it by an equation")  # fmt: skip
        slots = whole.elements()
        every = [const(float(k)) for k in range(len(slots))]
        place = dict(zip(indices(whole.shape), every, strict=True))
        places = Value("Integer", whole.shape, lambda index: place[index])
        chosen = subscripted(places, subscripts, self, target.span)
        require_shape(value, chosen.shape, f"{target} has another size", statement.span)
        for position, element in zip(chosen.elements(), value.elements(), strict=True):
            if position.op == "const":
                self._set(slots[int(build.number_of(position))], element, target, statement)
                continue
            for one in slots:
                kept = self._where_chosen(whole, one, element, subscripts, target)
                self._set(one, kept, target, statement)

    def _where_chosen(
        self, whole: Value, one: Expr, element: Expr, subscripts: tuple[tree.Expression, ...],
        target: tree.Reference,
    ) -> Expr:  # fmt: skip
        """Return what an element of an array becomes if a changing subscript may mean it."""
        kept = _read(one, self.now)
        own = replace(whole, get=lambda index: element if whole.get(index) is one else kept)
        return subscripted(own, subscripts, self, target.span).expr

    def _set(
        self, one: Expr, value: Expr, target: tree.Reference, statement: tree.Assignment
    ) -> None:
        builder = self.outside.builder
        assert builder is not None
        ref = lone(one)
        if ref is None:
            _not_assignable(target, "it is no variable, or a parameter or constant")
        declaration = declaration_of(builder.template, ref)
        if declaration.causality == "input" and not ref.path:
            _not_assignable(target, "it is an input")
        before_ = self.where.get(one)
        held = self.in_when and (before_ is None or before_.held)
        self.where[one] = _Where(statement, held, declaration.discrete)
        self.now[one] = value

    # --- branches ------------------------------------------------------------------------

    def snapshot(self) -> dict[Expr, Expr]:
        """Return the values of all variables."""
        return dict(self.now)

    def restore(self, state: dict[Expr, Expr]) -> None:
        """Go back to earlier values."""
        self.now = dict(state)

    def enter(self, condition: Expr) -> None:
        """Begin a branch that is taken where a condition holds."""
        self.guards.append(condition)

    def leave(self) -> None:
        """End the branch entered last."""
        self.guards.pop()

    def join(self, condition: Expr, holds: dict[Expr, Expr], span: Span) -> None:
        """Choose between the values of a branch and the present ones, those of the other."""
        for one in (*holds, *(k for k in self.now if k not in holds)):
            first, second = _read(one, holds), _read(one, self.now)
            self.now[one] = build.if_(condition, first, second)

    def when(self, statement: tree.WhenStatement) -> None:
        """Execute a when with its elsewhen branches.

        Raises:
            AcausalError: ``E008`` inside another when, a branch or an initial algorithm.
        """
        if self.initial or self.in_when or self.guards:
            where = "an if whose condition can change"
            if self.initial or self.in_when:
                where = "another when" if self.in_when else "an initial algorithm"
            fail("E008", f"a when cannot stand in {where}", statement.span,
                 help="move it out, and join the conditions with and")  # fmt: skip
        self.in_when = True
        self._branch(list(statement.branches))
        self.in_when = False

    def _branch(self, branches: list[tuple[tree.Expression, tuple[tree.Statement, ...]]]) -> None:
        if not branches:
            return
        condition, body = branches[0]
        instant = fires(condition, self)
        choose(instant, body, lambda: self._branch(branches[1:]), self, condition.span)

    # --- calls ---------------------------------------------------------------------------

    def invoke(self, statement: tree.CallStatement) -> None:
        """Execute ``assert``, ``terminate``, or a function whose results nobody wants.

        Raises:
            AcausalError: ``E008`` for a ``terminate`` without a condition, ``E010`` for reinit.
        """
        call = statement.call
        name = str(call.function)
        guard = ONE
        for condition in self.guards:
            guard = build.and_(guard, condition)
        if name == "assert":
            own = assertion(call, self, Domain())
            if own is not None:
                condition = build.or_(build.not_(guard), own.condition)
                self.asserts.append(replace(own, condition=condition))
        elif name == "terminate":
            if guard is ONE or self.initial:
                fail("E008", "terminate needs a condition", statement.span,
                     help='write when x > 1 then terminate("..."); end when;')  # fmt: skip
            text = format_expression(call)
            self.terminates.append(
                TerminateDecl(guard, terminate_message(call, self), Domain(), statement.span, text)
            )
        elif name == "reinit":
            fail("E010", "reinit stands in an algorithm", statement.span,
                 help="write it in a when of the equation section")  # fmt: skip
        else:
            self.results(call)

    def give_back(self, statement: tree.ReturnStatement) -> None:
        """Refuse ``return``."""
        fail("T112", "return belongs into functions", statement.span,
             help="use if to leave out what follows")  # fmt: skip


def _read(one: Expr, now: dict[Expr, Expr]) -> Expr:
    """Return the present value of a variable."""
    known = now.get(one)
    ref = one.value
    assert isinstance(ref, Ref)
    return slot(Unset(ref)) if known is None else known


def _present(value: Value, now: dict[Expr, Expr]) -> Value:
    """Return the present value of a reference to variables."""
    if value.fields is not None:
        return replace(value, fields={n: _present(v, now) for n, v in value.fields.items()})
    if value.type == "String" or value.numbers is not None:
        return value

    def get(index: Index) -> Expr:
        expr = value.get(index)
        variables = {one: _read(one, now) for one in slot_nodes(expr) if lone(one) is not None}
        return substitute(expr, variables)

    return replace(value, get=get)


def _not_assignable(target: tree.Reference, why: str) -> NoReturn:
    fail("T126", f"{target} cannot be assigned here", target.span, label=why,
         help="assign variables of the class that its algorithm computes")  # fmt: skip


def add_algorithm(
    statements: tuple[tree.Statement, ...], env: ClassEnvironment, sink: Sink
) -> None:
    """Add the equations of an algorithm section.

    Raises:
        AcausalError: For what cannot be executed symbolically, and for mistakes in the statements.
    """
    builder = env.builder
    assert builder is not None
    memory = ModelMemory(env, sink.initial)
    # Conditions are about values in the middle of the section: they are nobody else's.
    known, builder.signal_numbers = builder.signal_numbers, {}
    first = len(builder.template.signals)
    try:
        run(statements, memory)
    except Break:
        fail("T112", "break stands outside of a loop", statements[0].span,
             help="use it in a for or while loop")  # fmt: skip
    finally:
        builder.signal_numbers = known

    def settled(expr: Expr) -> Expr:
        """Put in what variables are where the algorithm reads them before it sets them."""
        earlier: dict[Expr, Expr] = {}
        for part in slot_nodes(expr):
            if isinstance(part.value, Unset):
                one = slot(part.value.ref)
                where = memory.where.get(one)
                earlier[part] = one if where is None else _value_before(one, where, sink, env)
        return substitute(substitute(expr, earlier), variables)

    # What a discrete variable has become needs to be worked out once only.
    variables: dict[Expr, Expr] = {}
    final = {one: settled(memory.now[one]) for one in memory.where}
    for one, where in memory.where.items():
        if _is_discrete(one, where, sink) and final[one].args and not sink.initial:
            variables.setdefault(final[one], one)
    for k in range(first, len(builder.template.signals)):
        declared = builder.template.signals[k]
        operands = tuple(settled(o) for o in declared.operands)
        builder.template.signals[k] = replace(declared, operands=operands)
    sink.asserts += [replace(a, condition=settled(a.condition)) for a in memory.asserts]
    sink.terminates += [replace(t, fires=settled(t.fires)) for t in memory.terminates]
    for one, where in memory.where.items():
        value = final[one]
        if variables.get(value) is one:  # not as itself
            value = build.rebuild(value, substitute_all(value.args, variables))
        else:
            value = substitute(value, variables)
        _equation(one, value, where, env, sink)


def _is_discrete(one: Expr, where: _Where, sink: Sink) -> bool:
    assert isinstance(one.value, Ref)
    return where.held or where.discrete or name_of(one.value) in sink.held


def _equation(one: Expr, value: Expr, where: _Where, env: ClassEnvironment, sink: Sink) -> None:
    span, owner = where.statement.span, env.owner.full_name
    text = f"{_target_text(where.statement)} := {format_expression(where.statement.value)}"
    if _is_discrete(one, where, sink):
        sink.discrete.append(DiscreteDecl(one, value, Domain(), span, text, owner, held=where.held))
        return
    residual = build.sub(one, value)
    sink.equations.append(EquationDecl(residual, Domain(), span, text, owner))


def _target_text(statement: tree.Assignment) -> str:
    target = statement.target
    if isinstance(target, tree.Reference):
        return format_expression(target)
    inside = ", ".join("" if e is None else format_expression(e) for e in target.elements)
    return f"({inside})"


def _value_before(one: Expr, where: _Where, sink: Sink, env: ClassEnvironment) -> Expr:
    """Return what a variable is where the algorithm reads it before it sets it."""
    if _is_discrete(one, where, sink):
        return before(one)
    return _start_value(one, where.statement, env)


def _start_value(one: Expr, statement: tree.Assignment, env: ClassEnvironment) -> Expr:
    builder, ref = env.builder, one.value
    assert builder is not None and isinstance(ref, Ref)
    if ref.path or ref.outer:
        return ZERO
    element = builder.merged.elements[ref.name]
    kind = primitive_type(type_of(element))
    inherited = kind.modifications if kind is not None else ()
    for changes, weak in ((element.modifications, False), (inherited, True)):
        for change in changes:
            if change.path == ("start",):
                place = (
                    ClassEnvironment(None, change.owner) if weak else builder.scope(change.owner)
                )
                value = elaborate(change.value, place)
                index: Index = ref.index[len(ref.index) - len(value.shape) :]
                return value.get(index)
    return ZERO
