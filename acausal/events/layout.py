"""Where held values stand: discrete variables, conditions, what was before, everything else.

Equal discrete variables share one place; the classes are found by union-find over the equalities.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.connections.components import connected_components
from acausal.flattening.model import Discrete, EquationFamily, Ids, Operand
from acausal.flattening.signals import INITIAL_ID, TERMINAL_ID


@dataclass(frozen=True)
class Layout:
    """Held positions, see :class:`acausal.flattening.model.Hybrid`.

    Attributes:
        first: Parameter id of held value 0.
        n_classes: Number of classes of equal discrete variables.
        n_discrete: Classes and conditions.
        place: Position of the value of each variable, or -1, shape ``(n,)``.
        signal: Position of each signal, shape ``(n_signals,)``.
        pre_signal: Position of its value before the event.
        conditions, samples, delays: Signals by kind.
        limit: Position of each continuous variable's value before the event, or -1.
        limit_variables: The variables that have one.
        count: Number of positions that are taken.
    """

    first: int
    n_classes: int
    n_discrete: int
    place: Ids
    signal: Ids
    pre_signal: Ids
    conditions: Ids
    samples: Ids
    delays: Ids
    limit: Ids
    limit_variables: Ids
    count: int


def layout_of(
    discrete: Discrete,
    equalities: Sequence[EquationFamily],
    families: Iterable[EquationFamily],
    first: int,
) -> Layout:
    """Give everything that is held a position, relations excepted.

    Args:
        discrete: The discrete part.
        equalities: ``x - y = 0`` between discrete variables.
        families: All families, to see which continuous variables are asked for before events.
        first: Number of parameters.
    """
    n = len(discrete.discrete)
    ids = np.flatnonzero(discrete.discrete)
    number = np.full(n, -1, np.int64)
    number[ids] = np.arange(len(ids))
    nothing = np.zeros((2, 0), np.int64)
    pairs = np.concatenate([nothing, *(number[f.operands] for f in equalities)], axis=1)
    assert (pairs >= 0).all(), "an equality of discrete variables has a continuous one"
    n_classes, label = connected_components(pairs[0], pairs[1], len(ids))
    place = np.full(n, -1, np.int64)
    place[ids] = label

    conditions, samples, delays = (
        np.concatenate(
            [np.zeros(0, np.int64)]
            + [s.operands[0].rows for s in discrete.signals if s.kind == kind]
        )
        for kind in ("condition", "sample", "delay")
    )
    n_discrete = n_classes + len(conditions)
    before = np.zeros(n, np.bool_)
    for family in families:
        for kind, row in zip(family.kinds, family.operands, strict=True):
            if kind == Operand.PRE:
                before[row] = True
    limit_variables = np.flatnonzero(before & ~discrete.discrete)

    signal = np.full(discrete.n_signals, -1, np.int64)
    signal[conditions] = n_classes + np.arange(len(conditions))
    count = 2 * n_discrete
    # One place stays false: the values before the event of samples and of the two flags.
    false = count
    count += 1
    for chosen in (np.array([INITIAL_ID, TERMINAL_ID]), samples, delays):
        signal[chosen] = count + np.arange(len(chosen))
        count += len(chosen)
    pre_signal = np.full(discrete.n_signals, false)
    pre_signal[conditions] = signal[conditions] + n_discrete
    limit = np.full(n, -1, np.int64)
    limit[limit_variables] = count + np.arange(len(limit_variables))
    count += len(limit_variables)
    return Layout(
        first, n_classes, n_discrete, place, signal, pre_signal, conditions, samples, delays,
        limit, limit_variables, count,
    )  # fmt: skip


def start_values(
    layout: Layout, start: NDArray[np.float64], given: NDArray[np.bool_], targets: Ids
) -> NDArray[np.float64]:
    """Return the start values of the discrete variables and conditions, shape ``(n_discrete,)``.

    Of equal variables the one that an equation gives its value speaks for all, if it has a start
    value; then any other that has one.

    Args:
        layout: Positions.
        start: Start values of the variables.
        given: Where the user wrote them.
        targets: Variables that an equation gives their value.
    """
    result = np.zeros(layout.n_discrete)
    ids = np.flatnonzero(layout.place >= 0)
    # The last one wins, the lowest ids come last.
    for chosen in (ids, targets, ids[given[ids]], targets[given[targets]]):
        result[layout.place[chosen[::-1]]] = start[chosen[::-1]]
    return result
