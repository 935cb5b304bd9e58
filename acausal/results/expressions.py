"""Expressions of variables: the language itself, read against what a run has stored.

The parser, the rules of arrays and functions, and the unit check are those of models; only names
mean something else: variables and parameters of a result.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING, NoReturn

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import AcausalError, fail
from acausal.expressions.differentiate import time_derivative
from acausal.expressions.evaluate import evaluate_all
from acausal.expressions.nodes import Expr, slot
from acausal.expressions.traverse import slots
from acausal.instantiation import unit_algebra
from acausal.instantiation.arrays import mapped
from acausal.instantiation.builtins import arguments
from acausal.instantiation.environment import ClassEnvironment
from acausal.instantiation.event_operators import find_event_operator
from acausal.instantiation.expressions import elaborate, elaborate_real
from acausal.instantiation.subscripts import subscripted
from acausal.instantiation.values import (
    NeedsUnroll,
    UnitOf,
    Value,
    number,
    scalar,
)
from acausal.modeling.classes import ClassDef
from acausal.modeling.library import standard_library
from acausal.results.arithmetic import known_unit
from acausal.results.patterns import compile_pattern, matching
from acausal.results.trajectory import Trajectory
from acausal.syntax import tree
from acausal.syntax.formatter import format_expression
from acausal.syntax.parser import parse_expression
from acausal.units import format_dimension, to_si

if TYPE_CHECKING:
    from acausal.instantiation.template import Ref
    from acausal.results.result import Result

Array = NDArray[np.float64]

#: ``[*]`` of the patterns is ``[:]`` of the language.
_STAR = re.compile(r"(?<=[\[,])(\s*)\*(?=\s*[\],])")
_PART = re.compile(r"([^.\[\]]+)(?:\[([^\]]*)\])?(?:\.|$)")
_SOURCE = "<expression>"
#: More elements of an array than this are hardly meant.
MOST_ELEMENTS = 100_000


def evaluate(result: Result, text: str) -> Trajectory | dict[str, Trajectory]:
    """Return an expression over time; an array as a dictionary of its elements.

    Raises:
        AcausalError: ``N901`` for an unknown name, ``T1xx`` and ``U1xx`` for types, sizes and
            units that do not fit, ``P0xx`` for what cannot be read.
    """
    value = _value(result, text)
    if value.size > MOST_ELEMENTS:
        fail("T109", f"{text} has {value.size} elements", help="choose some of them")
    if not value.shape:
        return _trajectories(result, [text], [value.expr], value.unit)[0]
    places = np.ndindex(*value.shape)
    names = [f"{_bracketed(text)}[{','.join(str(i + 1) for i in place)}]" for place in places]
    found = _trajectories(result, names, value.elements(), value.unit)
    return {x.path: x for x in found}


def chosen(result: Result, texts: Sequence[str]) -> list[Trajectory]:
    """Return the trajectories that patterns and expressions name, each once, in order.

    What can be read as a path or a pattern is one, if it matches; anything else is an expression.

    Raises:
        AcausalError: As :func:`evaluate`.
    """
    found: dict[str, Trajectory] = {}
    for text in texts:
        if text == "time" or result.variables.find(text) or not is_expression(text):
            found.update(result.select(text))
            continue
        value = evaluate(result, text)
        found.update({value.path: value} if isinstance(value, Trajectory) else value)
    return list(found.values())


def paths_within(text: str, find: Callable[[str], Sequence[str]]) -> list[str]:
    """Return the patterns of the variables that an expression needs, derivatives included.

    Args:
        text: The expression.
        find: Tells which variables match a pattern.

    Raises:
        AcausalError: If it cannot be read.
    """
    found: dict[str, None] = {}
    stack: list[tuple[object, int]] = [(_parsed(text), 0)]
    while stack:
        item, order = stack.pop()
        if isinstance(item, tree.Reference):
            pattern = ".".join(_pattern_of(part) for part in item.parts)
            wanted = "der(" * order + pattern + ")" * order
            if find(wanted):
                found[wanted] = None
            if order and find(pattern):
                found[pattern] = None
        if isinstance(item, tree.Call):
            inside = order + (str(item.function) == "der")
            stack += [(x, inside) for x in item.arguments]
            stack += [(x, order) for x in (*item.named, *item.indices)]
        elif isinstance(item, tree.Node):
            stack += [(getattr(item, name), order) for name in item.__dataclass_fields__]
        elif isinstance(item, tuple):
            stack += [(x, order) for x in item]
    return list(found)[::-1]


def is_expression(text: str) -> bool:
    """Tell whether a text can only be meant as an expression, not as a path or pattern."""
    stripped = text.strip()
    while stripped.startswith("der(") and stripped.endswith(")"):
        stripped = stripped[4:-1]
    if not re.search(r"[-+/^()<>={}\s]|\d\*|\*\d|\w\*\w|\d\[[^\d:*?]", stripped):
        return False
    return compile_pattern(stripped) is None or bool(re.search(r"[-+/^()<>={}\s*]", stripped))


# --- reading


@lru_cache(maxsize=256)
def _parsed(text: str) -> tree.Expression:
    return parse_expression(_STAR.sub(r"\1:", text), _SOURCE)


def _value(result: Result, text: str) -> Value:
    try:
        expression = _parsed(text)
        value = elaborate(expression, _Names(result, {}))
        if value.type in ("String", "record"):
            kind = "a text" if value.type == "String" else "a record"
            fail("T101", f"{text} is {kind}, not a number", expression.span,
                 help="name one of its numbers")  # fmt: skip
        return value
    except NeedsUnroll:
        fail("T103", f"a subscript in {text} is not a constant number",
             help="subscripts of variables are whole numbers or ranges")  # fmt: skip
    except AcausalError as error:
        note = f"in the expression {text}"
        raise AcausalError(
            [replace(d, notes=(*d.notes, note)) for d in error.diagnostics]
        ) from None


def _trajectories(
    result: Result, names: Sequence[str], exprs: Sequence[Expr], unit: UnitOf
) -> list[Trajectory]:
    values = _numbers(result, exprs, result.times, result.variables.values)
    common = format_dimension(unit) if isinstance(unit, tuple) else ""
    found = []
    for name, expr, own in zip(names, exprs, values, strict=True):
        text, description = common, ""
        if expr.op == "slot":  # a variable by itself keeps the unit it is declared with
            declared = result.variables.unit(str(expr.value))
            known = known_unit(declared)
            if known is not None and (known.factor, known.offset, known.dimension) == (1, 0, unit):
                text = declared
                description = result.variables.description(str(expr.value))
        curve = None if result.dense is None else partial(_curve, result, expr)
        found.append(Trajectory(name, result.times, own, text, description, curve))
    return found


def _curve(result: Result, expr: Expr, times: Array, before: bool) -> Array:
    dense = result.dense
    assert dense is not None
    paths = [str(s) for s in sorted({str(x) for x in slots(expr)})]
    table = dense.at(paths, times, before)
    columns = dict(zip(paths, table.T, strict=True))
    return _numbers(result, [expr], times, columns.__getitem__)[0]


def _numbers(
    result: Result, exprs: Sequence[Expr], times: Array, lookup: Callable[[str], Array]
) -> list[Array]:
    """Return the values of expressions, SI units, each of shape ``(nt,)``."""

    def values(key: Hashable) -> Array:
        path = str(key)
        unit = known_unit(result.variables.unit(path))
        own = lookup(path)
        return own if unit is None or (unit.factor == 1.0 and not unit.offset) else to_si(own, unit)

    found = evaluate_all(tuple(exprs), values, times)
    return [np.broadcast_to(x, times.shape) for x in found]


# --- names


class _Names:
    """The variables and parameters of a result as an environment of the language."""

    def __init__(self, result: Result, locals_: dict[str, Value]) -> None:
        self._result = result
        self._locals = locals_

    def with_locals(self, values: dict[str, Value]) -> _Names:
        return _Names(self._result, {**self._locals, **values})

    def reference(self, reference: tree.Reference) -> Value:
        first = reference.parts[0]
        if len(reference.parts) == 1 and first.name in self._locals:
            return subscripted(self._locals[first.name], first.subscripts, self, reference.span)
        pattern = ".".join(_pattern_of(part) for part in reference.parts)
        variables = self._result.variables
        paths = variables.find(pattern)
        if paths:
            return self._picked(reference, paths, slot)
        parameters = self._result.parameters
        paths = [pattern] if pattern in parameters else matching(pattern, parameters)
        if paths:
            return self._picked(reference, paths, lambda p: number(parameters[p]).expr, False)
        try:
            return _library().constant(reference)
        except AcausalError:
            self._unknown(reference)

    def _picked(
        self,
        reference: tree.Reference,
        paths: Sequence[str],
        element: Callable[[str], Expr],
        variable: bool = True,
    ) -> Value:
        """Return the variables of these paths as a scalar or an array, subscripts applied."""
        unit_text = self._result.variables.unit(paths[0])
        if not variable:
            unit_text = self._result.parameter_units.get(paths[0], "")
        known = known_unit(unit_text)
        unit = None if known is None else known.dimension
        free, positions = _grid(reference, paths)
        if not free:
            return scalar(element(paths[0]), "Real", unit)
        shape = tuple(int(n) for n in positions.max(axis=0))
        table = dict(zip(map(tuple, positions.tolist()), paths, strict=True))
        if len(table) != int(np.prod(shape)):
            fail("T105", f"{reference} is no rectangular array here", reference.span,
                 help="name the elements by their subscripts")  # fmt: skip

        def get(index: tuple[Expr, ...]) -> Expr:
            if any(x.op != "const" for x in index):
                raise NeedsUnroll
            return element(table[tuple(int(float(str(x.value))) for x in index)])

        whole = Value("Real", shape, get, unit)
        if all(s is None or isinstance(s, tree.Colon) for s in free):
            return whole
        every = tuple(tree.Colon(reference.span) if s is None else s for s in free)
        return subscripted(whole, every, self, reference.span)

    def _unknown(self, reference: tree.Reference) -> NoReturn:
        path = format_expression(reference)
        close = self._result.variables.suggestions(path)[:3]
        fail("N901", f"there is no variable, parameter or constant {path}", reference.span,
             label="this name is not known here",
             notes=[f"did you mean {' or '.join(close)}?"] if close else [],
             help=f"write {close[0]}, if that is what you mean" if close
             else "result.find() lists the variables")  # fmt: skip

    def call(self, call: tree.Call) -> Value:
        if str(call.function) == "der":
            return self._derivative(call)
        if find_event_operator(str(call.function)) is not None:
            self.events(call)
        return _library().call_in(call, self)

    def _derivative(self, call: tree.Call) -> Value:
        (argument,) = arguments(call, 1)
        value = elaborate_real(argument, self)
        variables = self._result.variables

        def rate(operand: Expr) -> Expr:
            path = f"der({operand.value})"
            try:
                variables.values(path)
            except KeyError:
                fail("N901", f"the result has no {path}", call.span,
                     notes=["derivatives are known of states, and of what was kept or written"],
                     help=f"keep {path} with the variables of the run")  # fmt: skip
            return slot(path)

        unit = unit_algebra.per_second(value.unit)
        return mapped(lambda x: time_derivative(x, rate), "Real", unit, value)

    def stored(self, reference: tree.Reference) -> Value:
        return self.reference(reference)

    def signal(self, kind: str, operands: tuple[Expr, ...], source: tree.Expression) -> Expr:
        fail("E008", f"{format_expression(source)} has no meaning in a result", source.span,
             help="a result has no events of its own; see result.events")  # fmt: skip

    def events(self, call: tree.Call) -> None:
        fail("E008", f"{call.function} has no meaning in a result", call.span,
             help="a result has no events of its own; see result.events")  # fmt: skip

    def is_discrete(self, ref: Ref) -> bool:
        return False

    def component_shape(self, reference: tree.Reference) -> tuple[int, ...] | None:
        return None


@lru_cache(maxsize=1)
def _library() -> ClassEnvironment:
    """Return the environment of the component library: its constants and functions."""
    span = _parsed("0").span
    return ClassEnvironment(
        None, ClassDef(tree.ClassDefinition(span, "model", "result"), standard_library())
    )


def _pattern_of(part: tree.NamePart) -> str:
    if not part.subscripts:
        return part.name
    texts = [_fixed(s) or "*" for s in part.subscripts]
    return f"{part.name}[{','.join(texts)}]"


def _fixed(subscript: tree.Expression) -> str:
    """Return the text of a subscript that is a whole number, else nothing."""
    if isinstance(subscript, tree.NumberLiteral) and subscript.integer:
        return str(int(subscript.value))
    return ""


def _grid(
    reference: tree.Reference, paths: Sequence[str]
) -> tuple[list[tree.Expression | None], NDArray[np.int64]]:
    """Return the free subscripts of a reference, and those of each path, ``(paths, free)``.

    A subscript is free if it is not a plain number; None where it was left out.
    """
    own = [[s.split(",") if s else [] for _, s in _PART.findall(path)] for path in paths]
    free: list[tree.Expression | None] = []
    columns: list[list[int]] = []
    if len(own[0]) != len(reference.parts):
        return [], np.zeros((len(paths), 0), np.int64)
    for k, part in enumerate(reference.parts):
        for place in range(len(own[0][k])):
            given = part.subscripts[place] if place < len(part.subscripts) else None
            if given is not None and _fixed(given):
                continue
            free.append(given)
            columns.append([int(subscripts[k][place]) for subscripts in own])
    if not columns:
        return [], np.zeros((len(paths), 0), np.int64)
    return free, np.array(columns, np.int64).T


def _bracketed(text: str) -> str:
    return text if re.fullmatch(r"[\w.]+", text) else f"({text})"
