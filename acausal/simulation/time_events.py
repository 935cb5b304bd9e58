"""Times at which a model jumps, known beforehand: relations and steps in time and parameters alone.

A source such as ``if time < startTime then 0 else height`` jumps at a time that does not depend on
the solution. The integrator must not step across it. The jumps of an expression are found from the
inside out: between the jumps of its parts it is smooth, so a relation changes there where
the difference of its sides does, which is bracketed on a few points and refined by bisection.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from acausal.expressions import build
from acausal.expressions.evaluate import evaluate
from acausal.expressions.linearity import split_linear
from acausal.expressions.nodes import RELATIONS, Expr, slot
from acausal.expressions.traverse import postorder, slots
from acausal.flattening.model import EquationFamily, Operand

Times = NDArray[np.float64]

#: Functions that jump, and by what their argument is to be divided to count the jumps.
_STEPS = ("floor", "ceil", "integer", "mod", "rem", "div")
#: Points at which a smooth piece is looked at for a change of sign.
_SAMPLES = 9
#: Above this many distinct members a family is left to the integrator's step control.
_MOST_MEMBERS = 5000
#: A signal that jumps more often than this is left to the step control, too.
_MOST_EVENTS = 2_000_000


@dataclass
class TimeSignals:
    """Variables that are functions of time and parameters alone.

    Attributes:
        parameters: Values of the parameters.
        definitions: Family and member that define a variable.
        representative: Who stands for each variable.
        sign: With which sign.
    """

    parameters: NDArray[np.float64]
    definitions: dict[int, tuple[EquationFamily, int]]
    representative: NDArray[np.int64]
    sign: NDArray[np.int8]
    _known: dict[int, bool] = field(default_factory=dict)

    def is_known(self, variable: int) -> bool:
        """Tell whether a variable depends on time and parameters alone."""
        variable = int(self.representative[variable])
        if variable not in self._known:
            self._known[variable] = False
            found = self.definitions.get(variable)
            if found is not None:
                family, member = found
                self._known[variable] = all(
                    family.kinds[k] == Operand.PARAMETER
                    or self.is_known(int(family.operands[k, member]))
                    for k in (int(key) for key in slots(family.template))  # type: ignore[call-overload]
                )
        return self._known[variable]

    def values(self, family: EquationFamily, member: int, expr: Expr, times: Times) -> Times:
        """Return a part of a family's template for one member at all times."""

        def operand(key: object) -> Times:
            assert isinstance(key, int)
            scalar = int(family.operands[key, member])
            if family.kinds[key] == Operand.PARAMETER:
                return np.asarray(self.parameters[scalar])
            inside, other = self.definitions[int(self.representative[scalar])]
            value = self.values(inside, other, inside.template, times)
            return value * float(self.sign[scalar])

        return np.broadcast_to(evaluate(expr, operand, times), times.shape)

    def jumps(
        self, family: EquationFamily, member: int, expr: Expr, start: float, stop: float
    ) -> list[float]:
        """Return the times in ``(start, stop)`` at which an expression jumps, sorted."""
        found: set[float] = set()
        for part in postorder(expr):
            if part.op == "slot":
                key = part.value
                assert isinstance(key, int)
                if family.kinds[key] == Operand.VARIABLE:
                    variable = int(self.representative[family.operands[key, member]])
                    inside, other = self.definitions[variable]
                    found |= set(self.jumps(inside, other, inside.template, start, stop))
            elif part.op in RELATIONS or (part.op == "call" and part.value in _STEPS):
                found |= set(self._crossings(family, member, part, sorted(found), start, stop))
        return sorted(found)

    def _crossings(
        self, family: EquationFamily, member: int, part: Expr, inner: list[float],
        start: float, stop: float,
    ) -> list[float]:  # fmt: skip
        def side(times: Times) -> Times:
            first = self.values(family, member, part.args[0], times)
            if part.op in RELATIONS:
                return first - self.values(family, member, part.args[1], times)
            if len(part.args) == 2:
                return first / self.values(family, member, part.args[1], times)
            return first

        result: list[float] = []
        bounds = [start, *(t for t in inner if start < t < stop), stop]
        for a, b in pairwise(bounds):
            width = b - a
            if width <= 0 or not np.isfinite(width):
                continue
            times = np.linspace(a, b, _SAMPLES)
            times[0], times[-1] = a + 1e-12 * width, b - 1e-12 * width
            g = side(times)
            if not np.isfinite(g).all():
                continue
            result += _level_times(side, times, g, part.op in RELATIONS)
            if len(result) > _MOST_EVENTS:
                return []
        return result


def _level_times(side: object, times: Times, g: Times, relation: bool) -> list[float]:
    """Return where a smooth function crosses zero, or any whole number."""
    assert callable(side)
    result: list[float] = []
    for a, b, ga, gb in zip(times[:-1], times[1:], g[:-1], g[1:], strict=True):
        low, high = (ga, gb) if ga <= gb else (gb, ga)
        if relation:
            levels = np.array([0.0]) if low < 0.0 <= high or low <= 0.0 < high else np.zeros(0)
        else:
            levels = np.arange(np.floor(low) + 1.0, np.floor(high) + 1.0)
        if not len(levels) or len(levels) > _MOST_EVENTS:
            continue
        left, right = np.full(len(levels), a), np.full(len(levels), b)
        rising = gb > ga
        for _ in range(200):
            middle = 0.5 * (left + right)
            if ((middle <= left) | (middle >= right)).all():
                break
            above = (side(middle) >= levels) == rising
            right = np.where(above, middle, right)
            left = np.where(above, left, middle)
        result += right.tolist()
    return result


def jump_parts(template: Expr) -> list[Expr]:
    """Return the relations and stepping functions of a template outside of ``noEvent``."""
    hidden: set[Expr] = set()
    parts = postorder(template)
    for part in parts:
        if part.op == "noevent":
            hidden |= set(postorder(part))
    return [
        p
        for p in parts
        if p not in hidden and (p.op in RELATIONS or (p.op == "call" and p.value in _STEPS))
    ]


def _explicit_rows(
    families: Sequence[EquationFamily], table: dict[int, tuple[EquationFamily, int]]
) -> None:
    """Add what rows such as ``t - mod(time, period) = 0`` say of one variable."""
    for family in families:
        variables = [k for k, kind in enumerate(family.kinds) if kind == Operand.VARIABLE]
        if not variables or len(variables) > 4 or family.count > _MOST_MEMBERS:
            continue
        for k in variables:
            split = split_linear(family.template, slot(k))
            if split is None or split[0].op != "const" or split[0].value == 0.0:
                continue
            template = build.neg(build.div(split[1], split[0]))
            solved = replace(family, template=template)
            for member, variable in enumerate(family.operands[k].tolist()):
                table.setdefault(variable, (solved, member))


def time_events(
    families: Sequence[EquationFamily],
    definitions: Sequence[EquationFamily],
    parameters: NDArray[np.float64],
    representative: NDArray[np.int64],
    sign: NDArray[np.int8],
    start: float,
    stop: float,
) -> Times:
    """Return the times in ``(start, stop)`` at which the model jumps by itself, sorted.

    Args:
        families: The equations.
        definitions: Definitions of eliminated variables.
        parameters: Parameter values.
        representative: Who stands for each variable.
        sign: With which sign.
        start: Start time, seconds.
        stop: Stop time, seconds.
    """
    interesting = [(f, p) for f in (*families, *definitions) if (p := jump_parts(f.template))]
    if not interesting:
        return np.zeros(0)
    table: dict[int, tuple[EquationFamily, int]] = {}
    twice: set[int] = set()
    for family in definitions:
        for member, variable in enumerate(family.rows.tolist()):
            if variable in table:
                twice.add(variable)
            table[variable] = (family, member)
    for variable in twice:
        del table[variable]
    _explicit_rows(families, table)
    signals = TimeSignals(parameters, table, representative, sign)
    found: set[float] = set()
    for family, parts in interesting:
        for part in parts:
            keys = [int(k) for k in slots(part)]  # type: ignore[call-overload]
            columns = np.zeros((len(keys), family.count))
            for row, k in enumerate(keys):
                ids = family.operands[k]
                if family.kinds[k] == Operand.PARAMETER:
                    columns[row] = parameters[ids]
                else:
                    columns[row] = ids
            _, first = np.unique(columns, axis=1, return_index=True)
            if len(first) > _MOST_MEMBERS:
                continue
            for member in sorted(first.tolist()):
                variables = [k for k in keys if family.kinds[k] == Operand.VARIABLE]
                if all(signals.is_known(int(family.operands[k, member])) for k in variables):
                    found |= set(signals.jumps(family, member, part, start, stop))
    return np.array(sorted(found))
