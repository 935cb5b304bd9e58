"""Derivatives whose coefficient is zero: ``i = C*der(v)`` with ``C = 0`` makes ``v`` no state.

Parameters are known when a model is compiled. A derivative that all rows multiply by zero would be
taken for the derivative of a state, and the system would be singular wherever it is solved for it.
So such a derivative is taken out of the rows, member by member, and what depended on it becomes
algebraic. A coefficient may be a variable that is zero for the same reason (``c = C*f(v)`` in
``c*der(v)``), and so may what is derived (``i = der(q)``, ``q = C*v``): rows that define those and
fold to ``c = 0`` are folded.

Nothing else is simplified: a product of a zero parameter with any other unknown stays in the
structure, since values of parameters should decide about it only where they must.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Diagnostic, Severity
from acausal.elimination.alias_rows import bare_coefficient
from acausal.elimination.families import Tally, row_counts, used_variables, variable_slots
from acausal.elimination.linear_form import tidied
from acausal.elimination.working import System, unsupported_derivatives
from acausal.expressions.differentiate import partial
from acausal.expressions.evaluate import evaluate
from acausal.expressions.nodes import TIME, ZERO, Expr, slot
from acausal.expressions.traverse import postorder, substitute
from acausal.flattening.members import merge_families, partition, renumbered, take_members
from acausal.flattening.model import EquationFamily, FlatModel, Names, Operand

Mask = NDArray[np.bool_]

#: Names in a message.
LIST = 3


def without_vanishing_derivatives(system: System, model: FlatModel) -> System:
    """Return the system without derivatives that parameters with the value zero multiply.

    The rows of variables that become zero stay; they are found as rows of known zeros.

    Args:
        system: Variables are numbered as in the model, aliases are merged.
        model: The model.
    """
    zeros = _Zeros(model)
    derivatives = np.zeros(system.n_variables, np.bool_)
    derivatives[system.derivative[system.derivative >= 0]] = True
    if not derivatives.any():
        return system
    suspects = system.derivative >= 0
    families: list[EquationFamily] = []
    for family in system.families:
        families += zeros.without_derivatives(family, derivatives, suspects)
    if zeros.present:
        counts = row_counts(families, system.n_rows)
        families = [part for family in families for part in zeros.bare(family, suspects, counts)]
    if not zeros.changed:
        return system
    return replace(system, families=merge_families(families))


class _Zeros:
    """Parameters that are zero, put into templates.

    Attributes:
        present: Some parameter is zero.
        changed: Some family was changed.
    """

    def __init__(self, model: FlatModel) -> None:
        self._values = model.parameters
        self._first_held = len(model.parameters) if model.hybrid is None else model.hybrid.first
        self._zero = self._values == 0.0
        self._zero[self._first_held :] = False
        self.present = bool(self._zero.any())
        self.changed = False

    def without_derivatives(
        self, family: EquationFamily, derivatives: Mask, suspects: Mask
    ) -> list[EquationFamily]:
        """Return the parts of a family, each without the derivatives that vanish in it.

        Args:
            family: Any family.
            derivatives: Which variables are derivatives.
            suspects: Receives the variables that coefficients of derivatives depend on.
        """
        parts = [family]
        # Slots are numbered anew where one vanishes, so the parts are searched from the start.
        finished: list[EquationFamily] = []
        while parts:
            part = parts.pop(0)
            split = self._split(part, derivatives, suspects)
            if split is None:
                finished.append(part)
            else:
                parts = split + parts
                self.changed = True
        return finished

    def _split(
        self, family: EquationFamily, derivatives: Mask, suspects: Mask
    ) -> list[EquationFamily] | None:
        """Take one derivative out of the members in which it vanishes; None if there are none."""
        for j in variable_slots(family):
            concerned = derivatives[family.operands[j]]
            if not concerned.any():
                continue
            coefficient, used, plain = _coefficient(family.template, j)
            known = [k for k in used if family.kinds[k] == Operand.PARAMETER]
            unknown = [k for k in used if family.kinds[k] == Operand.VARIABLE]
            if known:
                gone = concerned & self._vanishing(family, coefficient, known, plain, not unknown)
                if gone.any():
                    rest = np.flatnonzero(~gone)
                    taken = take_members(family, np.flatnonzero(gone))
                    template = tidied(substitute(family.template, {slot(j): ZERO}))
                    parts = [renumbered(taken, template)]
                    return [*parts, take_members(family, rest)] if len(rest) else parts
            for k in unknown:
                suspects[family.operands[k][concerned]] = True
        return None

    def _vanishing(
        self,
        family: EquationFamily,
        coefficient: Expr,
        known: Sequence[int],
        plain: bool,
        constant: bool,
    ) -> Mask:
        """Tell in which members a coefficient is zero, whatever its variables are."""
        if plain and constant:
            ids = family.operands[list(known)]
            values = {k: self._values[row] for k, row in zip(known, ids, strict=True)}
            zero: Mask = (evaluate(coefficient, values) == 0.0) & (ids < self._first_held).all(0)
            return zero
        gone = np.zeros(family.count, np.bool_)
        for members, mapping in self._patterns(family, known):
            gone[members] = substitute(coefficient, mapping) is ZERO
        return gone

    def _patterns(
        self, family: EquationFamily, slots: Sequence[int]
    ) -> list[tuple[NDArray[np.int64], dict[Expr, Expr]]]:
        """Return members with the same zeros among their parameters, and these zeros."""
        keys = {k: self._zero[family.operands[k]] for k in slots}
        keys = {k: zero for k, zero in keys.items() if zero.any()}
        if not keys:
            return []
        groups = partition([zero.astype(np.int64) for zero in keys.values()], [2] * len(keys))
        found = [
            (members, {slot(k): ZERO for k, zero in keys.items() if zero[members[0]]})
            for members in groups
        ]
        return [(members, mapping) for members, mapping in found if mapping]

    def bare(self, family: EquationFamily, suspects: Mask, counts: Tally) -> list[EquationFamily]:
        """Return the parts of a family, those rows folded that say that a suspect is zero."""
        slots = [k for k, kind in enumerate(family.kinds) if kind == Operand.PARAMETER]
        if not slots:
            return [family]
        rest = np.ones(family.count, np.bool_)
        parts: list[EquationFamily] = []
        for members, mapping in self._patterns(family, slots):
            chosen = members[counts[family.rows[members]] == 1]
            template = tidied(substitute(family.template, mapping))
            if not len(chosen) or template is family.template:
                continue
            part = renumbered(take_members(family, chosen), template)
            if bare_coefficient(part) is None:
                continue
            which = suspects[part.operands[0]]
            if which.any():
                rest[chosen[which]] = False
                parts.append(take_members(part, np.flatnonzero(which)))
                self.changed = True
        if not parts:
            return [family]
        left = np.flatnonzero(rest)
        return [*parts, take_members(family, left)] if len(left) else parts


@lru_cache(maxsize=4096)
def _coefficient(template: Expr, key: int) -> tuple[Expr, tuple[int, ...], bool]:
    """Return the derivative by a slot, the slots in it, and whether slots are all it needs."""
    coefficient = partial(template, slot(key))
    nodes = postorder(coefficient)
    used = tuple(int(e.value) for e in nodes if e.op == "slot")  # type: ignore[call-overload]
    return coefficient, used, not any(e is TIME or e.op == "homotopy" for e in nodes)


def freed_starts(
    before: System, after: System, names: Names
) -> tuple[System, tuple[Diagnostic, ...]]:
    """Take back fixed start values of variables that are no states because of zero parameters.

    Args:
        before: The system with all derivatives.
        after: The same system without those that vanish.
        names: Names of the variables.

    Returns:
        The system, and a warning (I102) if a start value was taken back.
    """
    if after is before:
        return after, ()
    supported = _derived(before)
    supported &= ~_derived(after)
    variables = after.variables
    freed = np.flatnonzero(supported & variables.fixed & (after.sign != 0))
    is_derivative = np.zeros(after.n_variables, np.bool_)
    is_derivative[after.derivative[after.derivative >= 0]] = True
    freed = freed[~is_derivative[freed]]
    if after.representative is not None:  # its derivative is that of another one now
        freed = freed[after.representative[freed] == freed]
    if not len(freed):
        return after, ()
    fixed = variables.fixed.copy()
    fixed[freed] = False
    texts = [names.variable(v) for v in freed[:LIST].tolist()]
    more = f" and {len(freed) - LIST} more" if len(freed) > LIST else ""
    first = texts[0]
    warning = Diagnostic(
        "I102",
        f"a start value cannot be prescribed for {', '.join(texts)}{more}",
        names.declaration(int(freed[0])),
        notes=(f"wherever der({first}) stands it is multiplied by a parameter that is zero, so "
               f"{first} follows from the other equations at all times",),
        help=f"remove fixed = true, or give the factor of der({first}) another value than zero",
        severity=Severity.WARNING,
    )  # fmt: skip
    return replace(after, variables=replace(variables, fixed=fixed)), (warning,)


def _derived(system: System) -> Mask:
    """Tell which variables have a derivative that is in use."""
    used = used_variables(system.families, system.n_variables)
    idle = unsupported_derivatives(system.derivative, used) & ~used
    mothers = np.flatnonzero(system.derivative >= 0)
    result = np.zeros(system.n_variables, np.bool_)
    result[mothers[~idle[system.derivative[mothers]]]] = True
    return result
