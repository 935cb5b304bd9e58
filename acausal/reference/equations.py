"""Equations and algorithms as lines of mathematics, with words where blocks begin and end."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from acausal.reference.latex import latex_expression
from acausal.syntax import tree
from acausal.syntax.formatter import format_expression


@dataclass(frozen=True, slots=True)
class Line:
    """One line of a listing of equations.

    Attributes:
        depth: How deep it is nested in blocks.
        latex: LaTeX mathematics; empty if it is words or code only.
        words: Words in front of it, such as ``when``.
        code: Text in the notation of the language behind it (connections).
        description: What the author says about it.
    """

    depth: int
    latex: str = ""
    words: str = ""
    code: str = ""
    description: str = ""


@dataclass(frozen=True, slots=True)
class Limit:
    """An ``assert``: the condition that must hold, and what is said if it does not."""

    latex: str
    message: str
    warning: bool


def equation_lines(
    equations: Sequence[tree.Equation], components: Collection[str] | None = None
) -> list[Line]:
    """Return equations as lines; asserts are left out (:func:`limits`)."""
    return list(_equations(equations, components, 0))


def statement_lines(
    statements: Sequence[tree.Statement], components: Collection[str] | None = None
) -> list[Line]:
    """Return the statements of an algorithm as lines."""
    return list(_statements(statements, components, 0))


def limits(
    equations: Sequence[tree.Equation], components: Collection[str] | None = None
) -> list[Limit]:
    """Return the asserts among equations, those inside of blocks too."""
    found: list[Limit] = []
    for equation in equations:
        match equation:
            case tree.CallEquation() if str(equation.call.function) == "assert":
                found += _limit(equation.call, components)
            case tree.IfEquation() | tree.WhenEquation():
                for _, body in equation.branches:
                    found += limits(body, components)
                if isinstance(equation, tree.IfEquation):
                    found += limits(equation.otherwise, components)
            case tree.ForEquation():
                found += limits(equation.body, components)
    return found


def _limit(call: tree.Call, components: Collection[str] | None) -> list[Limit]:
    arguments = list(call.arguments)
    named = {a.name: a.value for a in call.named}
    condition = arguments[0] if arguments else named.get("condition")
    message = arguments[1] if len(arguments) > 1 else named.get("message")
    level = arguments[2] if len(arguments) > 2 else named.get("level")
    if condition is None:
        return []
    if isinstance(message, tree.StringLiteral):
        text = message.value
    else:
        text = "" if message is None else format_expression(message)
    warning = level is not None and format_expression(level).endswith("warning")
    return [Limit(latex_expression(condition, components), text, warning)]


def _is_assert(equation: tree.Equation) -> bool:
    return isinstance(equation, tree.CallEquation) and str(equation.call.function) == "assert"


def _equations(
    equations: Sequence[tree.Equation], known: Collection[str] | None, depth: int
) -> Iterator[Line]:
    for equation in equations:
        about = equation.description
        match equation:
            case _ if _is_assert(equation):
                pass
            case tree.SimpleEquation():
                left = latex_expression(equation.left, known, side=True)
                right = latex_expression(equation.right, known, side=True)
                yield Line(depth, f"{left} = {right}", description=about)
            case tree.ConnectEquation():
                cuts = ", ".join(format_expression(c) for c in equation.cuts)
                yield Line(depth, code=f"connect({cuts})", description=about)
            case tree.ForEquation():
                yield Line(depth, _ranges(equation.indices, known), "for", description=about)
                yield from _equations(equation.body, known, depth + 1)
            case tree.IfEquation():
                for number, (condition, body) in enumerate(equation.branches):
                    inside = list(_equations(body, known, depth + 1))
                    if inside or number:
                        words = "else if" if number else "if"
                        yield Line(depth, latex_expression(condition, known), words)
                        yield from inside
                inside = list(_equations(equation.otherwise, known, depth + 1))
                if inside:
                    yield Line(depth, words="else")
                    yield from inside
            case tree.WhenEquation():
                for number, (condition, body) in enumerate(equation.branches):
                    words = "else when" if number else "when"
                    yield Line(depth, latex_expression(condition, known), words)
                    yield from _equations(body, known, depth + 1)
            case tree.CallEquation():
                yield _called(equation.call, known, depth, about)


def _called(
    call: tree.Call, known: Collection[str] | None, depth: int, description: str = ""
) -> Line:
    if str(call.function) == "reinit" and len(call.arguments) == 2:
        target, value = (latex_expression(a, known) for a in call.arguments)
        return Line(depth, rf"{target} \leftarrow {value}", description=description)
    if any(isinstance(a, tree.StringLiteral) for a in call.arguments):
        return Line(depth, code=format_expression(call), description=description)
    return Line(depth, latex_expression(call, known), description=description)


def _ranges(indices: Sequence[tree.ForIndex], known: Collection[str] | None) -> str:
    texts = []
    for index in indices:
        name = latex_expression(_name(index), known)
        if index.range is None:
            texts.append(name)
        else:
            texts.append(f"{name} = {latex_expression(index.range, known)}")
    return r",\; ".join(texts)


def _name(index: tree.ForIndex) -> tree.Reference:
    return tree.Reference(index.span, (tree.NamePart(index.span, index.name),))


def _statements(
    statements: Sequence[tree.Statement], known: Collection[str] | None, depth: int
) -> Iterator[Line]:
    for statement in statements:
        match statement:
            case tree.Assignment():
                target = latex_expression(statement.target, known)
                value = latex_expression(statement.value, known)
                yield Line(depth, f"{target} := {value}", description=statement.description)
            case tree.ForStatement():
                yield Line(depth, _ranges(statement.indices, known), "for")
                yield from _statements(statement.body, known, depth + 1)
            case tree.WhileStatement():
                yield Line(depth, latex_expression(statement.condition, known), "while")
                yield from _statements(statement.body, known, depth + 1)
            case tree.IfStatement() | tree.WhenStatement():
                word = "if" if isinstance(statement, tree.IfStatement) else "when"
                for number, (condition, body) in enumerate(statement.branches):
                    words = f"else {word}" if number else word
                    yield Line(depth, latex_expression(condition, known), words)
                    yield from _statements(body, known, depth + 1)
                if isinstance(statement, tree.IfStatement) and statement.otherwise:
                    yield Line(depth, words="else")
                    yield from _statements(statement.otherwise, known, depth + 1)
            case tree.CallStatement():
                yield _called(statement.call, known, depth, statement.description)
            case tree.ReturnStatement():
                yield Line(depth, words="return")
            case tree.BreakStatement():
                yield Line(depth, words="leave the loop")
