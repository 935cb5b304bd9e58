"""Statements of algorithms, executed symbolically.

An assignment replaces the expression of a name, a loop over a constant range is unrolled, an
``if`` on an unknown condition runs both branches and joins what they assigned. What comes out are
expressions like any others, which can be differentiated and share common parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeVar

from acausal.diagnostics import Span, fail
from acausal.expressions import build
from acausal.expressions.nodes import ZERO, Expr
from acausal.instantiation.arrays import LONGEST_REDUCTION
from acausal.instantiation.expressions import Environment, elaborate, elaborate_condition, passes
from acausal.instantiation.values import Value
from acausal.syntax import tree

State = TypeVar("State")


class Break(Exception):  # noqa: N818 - control flow of the interpreted program
    """``break``."""


class Return(Exception):  # noqa: N818 - control flow of the interpreted program
    """``return``."""


class Memory(Environment, Protocol[State]):
    """What an algorithm reads and writes: the variables of a function or of a model.

    Attributes:
        hidden: Values of loop indices, which hide other names.
    """

    hidden: dict[str, Value]

    def assign(self, target: tree.Reference, value: Value, statement: tree.Assignment) -> None:
        """Give a variable, or some of its elements, a value."""

    def results(self, call: tree.Call) -> list[Value]:
        """Return all outputs of a function call."""

    def snapshot(self) -> State:
        """Return the values of all variables."""

    def restore(self, state: State) -> None:
        """Go back to earlier values."""

    def enter(self, condition: Expr) -> None:
        """Begin a branch that is taken where a condition holds."""

    def leave(self) -> None:
        """End the branch entered last."""

    def join(self, condition: Expr, holds: State, span: Span) -> None:
        """Choose between the values of a branch and the present ones, those of the other."""

    def invoke(self, statement: tree.CallStatement) -> None:
        """Execute a call without result."""

    def when(self, statement: tree.WhenStatement) -> None:
        """Execute a when with its elsewhen branches."""

    def give_back(self, statement: tree.ReturnStatement) -> None:
        """Execute ``return``."""


def run(statements: Sequence[tree.Statement], memory: Memory[State]) -> None:
    """Execute statements.

    Raises:
        AcausalError: ``T127`` and ``T128`` if the course depends on what is not known.
        Break, Return: Through the loop or function they end.
    """
    for statement in statements:
        if isinstance(statement, tree.Assignment):
            _assign(statement, memory)
        elif isinstance(statement, tree.IfStatement):
            _branch(list(statement.branches), statement.otherwise, memory)
        elif isinstance(statement, tree.ForStatement):
            _loop(statement, memory)
        elif isinstance(statement, tree.WhileStatement):
            _while(statement, memory)
        elif isinstance(statement, tree.BreakStatement):
            raise Break
        elif isinstance(statement, tree.ReturnStatement):
            memory.give_back(statement)
        elif isinstance(statement, tree.CallStatement):
            memory.invoke(statement)
        else:
            assert isinstance(statement, tree.WhenStatement)
            memory.when(statement)


def _assign(statement: tree.Assignment, memory: Memory[State]) -> None:
    if isinstance(statement.target, tree.TupleExpression):
        assert isinstance(statement.value, tree.Call)
        results = memory.results(statement.value)
        targets = statement.target.elements
        if len(targets) > len(results):
            fail("T131", f"{statement.value.function} gives {len(results)} values, "
                 f"not {len(targets)}", statement.span,
                 help="remove variables on the left")  # fmt: skip
        for target, value in zip(targets, results, strict=False):
            if isinstance(target, tree.Reference):
                memory.assign(target, value, statement)
        return
    memory.assign(statement.target, elaborate(statement.value, memory), statement)


def _branch(
    branches: list[tuple[tree.Expression, tuple[tree.Statement, ...]]],
    otherwise: tuple[tree.Statement, ...],
    memory: Memory[State],
) -> None:
    if not branches:
        run(otherwise, memory)
        return
    condition, body = branches[0]
    c = elaborate_condition(condition, memory).expr
    if c is ZERO:
        _branch(branches[1:], otherwise, memory)
    elif c.op == "const":
        run(body, memory)
    else:
        choose(c, body, lambda: _branch(branches[1:], otherwise, memory), memory, condition.span)


class _Otherwise(Protocol):
    def __call__(self) -> None: ...


def choose(
    c: Expr,
    body: tuple[tree.Statement, ...],
    otherwise: _Otherwise,
    memory: Memory[State],
    span: Span,
) -> None:
    """Execute statements where a condition holds and something else where not; join the results.

    Raises:
        AcausalError: ``T127`` if one of the two leaves a loop or function.
    """
    before = memory.snapshot()
    try:
        memory.enter(c)
        run(body, memory)
        memory.leave()
        holds = memory.snapshot()
        memory.restore(before)
        memory.enter(build.not_(c))
        otherwise()
        memory.leave()
    except (Break, Return):
        fail("T127", "return or break under a condition that is not known", span,
             help="assign the result in both branches instead")  # fmt: skip
    memory.join(c, holds, span)


def _loop(statement: tree.ForStatement, memory: Memory[State]) -> None:
    hidden = memory.hidden
    try:
        for own in passes(statement.indices, memory, statement.span):
            memory.hidden = {**hidden, **own}
            run(statement.body, memory)
    except Break:
        pass
    finally:
        memory.hidden = hidden


def _while(statement: tree.WhileStatement, memory: Memory[State]) -> None:
    for _ in range(LONGEST_REDUCTION):
        condition = elaborate_condition(statement.condition, memory).expr
        if condition.op != "const":
            fail("T128", "the end of this while loop depends on a variable",
                 statement.condition.span,
                 help="use a for loop with a constant range, and if expressions in it")  # fmt: skip
        if condition is ZERO:
            return
        try:
            run(statement.body, memory)
        except Break:
            return
    fail("T128", f"this while loop has not ended after {LONGEST_REDUCTION} passes",
         statement.span, help="check its condition")  # fmt: skip
