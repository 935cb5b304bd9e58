"""Choose other states while a simulation runs.

Statement: states chosen at one point may be a bad choice at another; a pendulum whose state is
``x`` cannot pass the horizontal. With ``B`` the Jacobian of a level's rows with respect to the
chosen dummies and ``N`` that with respect to the others, an entry of ``B^-1 N`` is the factor by
which exchanging the two variables multiplies ``det B``. As long as all of them are below ``tau``
the choice stays; otherwise variables are exchanged, the largest factor first, as in the pivoting
of a simplex method.

Complexity: one dense solution per block and level; large sparse blocks are chosen anew by
elimination and compared by their determinants.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from acausal.flattening.model import Ids
from acausal.structural.column_choice import exchange_gains, improve_columns, perturbed
from acausal.structural.dummy_derivatives import (
    TAU,
    Shape,
    StateSelection,
    Values,
    batches,
    select_blocks,
    selection_of,
    sparse_depths,
)


def reselect(selection: StateSelection, values: Values, tau: float = TAU) -> StateSelection | None:
    """Choose other states if that conditions the dummy derivatives clearly better.

    Args:
        selection: The present choice.
        values: The Jacobian at the positions ``selection.alternatives.entries``; only those of
            monitored blocks are looked at.
        tau: Factor of a determinant from which on an exchange is worth it.

    Returns:
        The new choice, or None if the present one stays.
    """
    alternatives = selection.alternatives
    values = values * alternatives.nominal
    depth = selection.depth.copy()
    for shape, monitored in zip(alternatives.shapes, alternatives.monitored, strict=True):
        if not monitored.any():
            continue
        for part in batches(select_blocks(shape, monitored)):
            depth[part.bases] = _better_depths(part, values, depth[part.bases], tau)
    if np.array_equal(depth, selection.depth):
        return None
    return selection_of(selection.chains, selection.d, depth, alternatives)


def largest_gain(selection: StateSelection, values: Values) -> float:
    """Return the largest factor by which one exchange would multiply a determinant.

    It measures how good the present choice is: 1 or less is the best there is. Blocks treated as
    sparse are left out.
    """
    alternatives = selection.alternatives
    values = values * alternatives.nominal
    largest = -np.inf
    for shape, monitored in zip(alternatives.shapes, alternatives.monitored, strict=True):
        if shape.sparse or not monitored.any():
            continue
        for part in batches(select_blocks(shape, monitored)):
            matrices = part.matrices(values)
            gains, _ = exchange_gains(matrices, part.levels, selection.depth[part.bases])
            largest = max(largest, float(gains.max()))
    return float(np.exp(largest))


def _better_depths(shape: Shape, values: Values, depth: Ids, tau: float) -> Ids:
    if not shape.sparse:
        matrices = shape.matrices(values)
        return improve_columns(matrices, shape.levels, shape.ranks, depth, tau)[0]
    other = sparse_depths(shape, values)[None]
    gain = _log_determinant(shape, values, other[0]) - _log_determinant(shape, values, depth[0])
    return other if gain > np.log(tau) else depth


def _log_determinant(shape: Shape, values: Values, depth: Ids) -> float:
    """Return the sum over levels of the logarithm of the determinant of one sparse block."""
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import splu

    _, row, column = shape.block
    scaled = perturbed(values[shape.entries], row, column, shape.rows.shape[1])
    total = 0.0
    for level in range(1, int(shape.levels[0]) + 1):
        chosen = depth >= level
        size = int(np.count_nonzero(shape.levels >= level))
        inside = (row < size) & chosen[column]
        place = np.cumsum(chosen) - 1
        matrix: Any = csc_array(
            (scaled[inside], (row[inside], place[column[inside]])), shape=(size, size)
        )
        try:
            diagonal = splu(matrix).U.diagonal()
        except RuntimeError:  # exactly singular
            return -np.inf
        total += float(np.log(np.abs(diagonal)).sum())
    return total
