"""Operations at an event that have no finite result, in the words of the model."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import fail
from acausal.expressions.build import number_of
from acausal.expressions.nodes import Expr
from acausal.expressions.traverse import postorder
from acausal.flattening.model import EquationFamily, Operand
from acausal.initialization.texts import failure_of, member_text
from acausal.simulation.system import System

Array = NDArray[np.float64]

#: Functions that are not defined everywhere.
PARTIAL = ("asin", "acos", "exp", "log", "log10", "sqrt", "sinh", "cosh", "mod", "rem", "div")
HELP = "at this event the values jump: let an if decide what holds where this cannot be evaluated"


def is_partial(expr: Expr) -> bool:
    """Tell whether an expression is not defined for all values of its slots."""
    return any(
        (e.op == "div" and (e.args[1].op != "const" or e.args[1].value == 0.0))
        or (e.op == "const" and not math.isfinite(number_of(e)))
        or e.op == "pow"
        or (e.op == "call" and e.value in PARTIAL)
        for e in postorder(expr)
    )


def not_finite(
    system: System, families: Iterable[EquationFamily], values: Array, parameters: Array,
    time: float,
) -> None:  # fmt: skip
    """Report the first operation of some families whose result is not finite.

    Raises:
        AcausalError: ``I030``; nothing is raised if all results are finite.
    """
    for family in families:

        def slot_values(key: object, family: EquationFamily = family) -> Array:
            assert isinstance(key, int)
            table = parameters if family.kinds[key] == Operand.PARAMETER else values
            chosen: Array = table[family.operands[key]]
            return chosen

        members = np.arange(family.count)
        failure = failure_of(family, members, members, slot_values, time, system.names)
        if failure is None or not (failure.variables or failure.parameters):
            continue  # what was not finite before has been reported then
        text, span = member_text(family, failure.member, system.names)
        names = system.names
        known = [f"{names.variable(v)} = {values[v]:.6g}" for v in failure.variables]
        known += [f"{names.parameter(p)} = {parameters[p]:.6g}" for p in failure.parameters]
        fail("I030", f"{failure.words} at t = {time:.9g} s", span, label=text,
             notes=["values: " + ", ".join(known)], help=HELP)  # fmt: skip


def refuse_discrete(
    system: System, held: Array, values: Array, parameters: Array, time: float
) -> None:
    """Report a discrete variable that is not finite.

    Args:
        system: The model.
        held: Held values, shape ``(h,)``.
        values: Values of all ids.
        parameters: Parameters and held values.
        time: Seconds.

    Raises:
        AcausalError: ``I030``.
    """
    hybrid = system.hybrid
    assert hybrid is not None
    bad = np.flatnonzero(~np.isfinite(held[: hybrid.n_discrete]))
    if not len(bad):
        return
    not_finite(system, hybrid.assignments, values, parameters, time)
    for family in hybrid.assignments:  # a division of constants, say
        members = np.flatnonzero(family.rows == bad[0])
        if len(members):
            text, span = member_text(family, int(members[0]), system.names)
            fail("I030", f"a discrete variable is {held[bad[0]]:g} at t = {time:.9g} s", span,
                 label=text, help=HELP)  # fmt: skip
