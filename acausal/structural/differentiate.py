"""Differentiate rows with respect to time, one template at a time.

Statement: row ``i`` is differentiated ``c[i]`` times. All members of an equation family share one
template, so its total time derivative (chain rule) is formed once; which members are differentiated
is a choice of columns of the operand array, and the ids of the derivatives of its operands are one
lookup. A row that gathers several contributions is differentiated by differentiating all of them,
as the sum is linear.

Complexity: symbolic work per template and order, integer work ``O(operands)`` per order.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from acausal.expressions.differentiate import time_derivative
from acausal.expressions.nodes import ZERO, Expr, slot
from acausal.expressions.traverse import slots, substitute
from acausal.flattening.model import EquationFamily, Ids, Operand, Origin
from acausal.structural.graphs import Mask
from acausal.structural.incidence import Chains


@dataclass(frozen=True)
class DifferentiatedSystem:
    """The system with its differentiated rows.

    Rows of order 0 keep their numbers; behind them come the first derivatives, ascending by row,
    then the second ones, and so on. New variables have numbers behind the old ones.

    Attributes:
        families: The original families in their order, then those of the new rows. ``origins``
            of new families tell where the original members come from.
        orders: How often each family is differentiated, as long as ``families``.
        n_rows: Number of all rows.
        source: Original row of each row, shape ``(n_rows,)``.
        order: How often it is differentiated, shape ``(n_rows,)``.
        chains: All variables; ``chains.base`` and ``chains.order`` name the new ones.
        n_original: Number of variables before.
        vanished: Rows of order > 0 without any contribution, because a derivative is zero
            wherever it exists (``floor(x) = 1``); ascending.
    """

    families: tuple[EquationFamily, ...]
    orders: tuple[int, ...]
    n_rows: int
    source: Ids
    order: Ids
    chains: Chains
    n_original: int
    vanished: Ids

    @property
    def derivative(self) -> Ids:
        """Id of the time derivative of each variable or -1, shape ``(n_variables,)``."""
        return self.chains.derivative

    def rows_of(self, source: Ids, order: Ids) -> Ids:
        """Return the row that is row ``source`` differentiated ``order`` times."""
        # Rows ascend by (order, source).
        n = int(self.source.max(initial=0)) + 1
        found: Ids = np.searchsorted(self.order * n + self.source, order * n + source)
        return found


def differentiate(
    families: tuple[EquationFamily, ...], n_rows: int, chains: Chains, c: Ids, d: Ids
) -> DifferentiatedSystem:
    """Add the derivatives of rows that index reduction asks for.

    Args:
        families: The original families.
        n_rows: Number of original rows.
        chains: The original variables.
        c: How often each row is differentiated, shape ``(n_rows,)``.
        d: Order of the highest derivative of each base, shape ``(n_bases,)``.

    Returns:
        The larger system.
    """
    wider = chains.extend(d)
    source, order = [np.arange(n_rows)], [np.zeros(n_rows, np.int64)]
    all_families, orders = list(families), [0] * len(families)
    current = list(families)
    number = np.arange(n_rows)  # row of each original row in its current order
    filled = np.zeros(n_rows, np.bool_)
    vanished: list[Ids] = []
    total = n_rows
    for times in range(1, int(c.max(initial=0)) + 1):
        rows = np.flatnonzero(c >= times)
        previous = np.full(total, -1, np.int64)
        previous[number[number >= 0]] = np.flatnonzero(number >= 0)
        number = np.full(n_rows, -1, np.int64)
        number[rows] = total + np.arange(rows.shape[0])
        source.append(rows)
        order.append(np.full(rows.shape[0], times, np.int64))
        following = []
        filled = np.zeros(n_rows, np.bool_)
        for family in current:
            original = previous[family.rows]
            wanted = number[original] >= 0
            if not wanted.any():
                continue
            part = select_members(family, wanted)
            new = _differentiate_family(part, wider, number[original[wanted]])
            if new is not None:
                following.append(new)
                filled[original[wanted]] = True
        vanished.append(number[rows[~filled[rows]]])
        all_families += following
        orders += [times] * len(following)
        current = following
        total += rows.shape[0]
    return DifferentiatedSystem(
        tuple(all_families),
        tuple(orders),
        total,
        np.concatenate(source),
        np.concatenate(order),
        wider,
        chains.n_variables,
        np.concatenate(vanished) if vanished else np.zeros(0, np.int64),
    )


def select_members(family: EquationFamily, wanted: Mask) -> EquationFamily:
    """Return the family of some of the members.

    Args:
        family: The family.
        wanted: Which members stay, shape ``(count,)``.
    """
    if wanted.all():
        return family
    members = np.flatnonzero(wanted)
    origins: list[Origin] = []
    first = 0
    for origin in family.origins:
        inside = wanted[origin.first : origin.first + origin.count]
        count = int(inside.sum())
        if count:
            instances = origin.instances[inside]
            origins.append(replace(origin, first=first, count=count, instances=instances))
            first += count
    return replace(
        family,
        operands=np.ascontiguousarray(family.operands[:, members]),
        rows=family.rows[members],
        origins=tuple(origins),
    )


def _differentiate_family(
    family: EquationFamily, chains: Chains, rows: Ids
) -> EquationFamily | None:
    """Return the derivative of a family, None if it is zero."""
    m = len(family.kinds)

    def derivative_of(node: Expr) -> Expr:
        place = node.value
        assert isinstance(place, int)
        return slot(m + place) if family.kinds[place] == Operand.VARIABLE else ZERO

    template = time_derivative(family.template, derivative_of)
    if template is ZERO:
        return None
    used = sorted(int(str(key)) for key in slots(template))
    template = substitute(template, {slot(old): slot(new) for new, old in enumerate(used)})
    operands = np.empty((len(used), family.count), np.int64)
    kinds = []
    for new, old in enumerate(used):
        ids = family.operands[old % m]
        if old >= m:
            ids = chains.derivative[ids]
            if bool((ids < 0).any()):
                raise ValueError("a row is differentiated more often than its variables")
        operands[new] = ids
        kinds.append(family.kinds[old % m])
    return replace(family, template=template, kinds=tuple(kinds), operands=operands, rows=rows)
