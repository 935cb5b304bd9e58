"""Choices of dummy derivatives that stay good for ever.

Statement: the states of a block can become a bad choice only if the determinant of the constraints
with respect to the dummies, ``B_k`` of level ``k``, can come to zero. In block triangular form the
determinant is the product of those of the diagonal blocks, whatever stands beside them; so where
all entries of the diagonal blocks are constant, the choice is as good at every point as it is now.
Joint coordinates of trees of bodies are chosen like this: every further position is explicit in
earlier ones, however many sines and cosines it takes.

Complexity: one matching and one block triangular form per level, for all blocks at once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from acausal.flattening.model import Ids
from acausal.structural.blocks import block_triangular_form
from acausal.structural.graphs import Mask, adjacency
from acausal.structural.matching import maximum_matching


def determinant_varies(block: Ids, levels: Ids, depth: Ids, constant: Mask) -> Mask:
    """Tell for which blocks a determinant of the chosen columns can change.

    Args:
        block: Block, row and column of each entry that is not always zero, ``(3, entries)``.
        levels: Level of each row of a block, shape ``(m,)``.
        depth: Depth of each column of each block, shape ``(b, n)``.
        constant: Which entries never change, shape ``(entries,)``.

    Returns:
        Mask of shape ``(b,)``.
    """
    b, n = depth.shape
    m = levels.shape[0]
    number, row, column = block
    varies = np.zeros(b, np.bool_)
    depths: NDArray[np.int64] = depth[number, column]
    for level in range(1, int(levels.max(initial=0)) + 1):
        inside = (levels[row] >= level) & (depths >= level)
        row_number = np.cumsum(np.tile(levels >= level, b)) - 1
        column_number = np.cumsum(depth.reshape(-1) >= level) - 1
        size = int(row_number[-1]) + 1
        tails = row_number[number[inside] * m + row[inside]]
        heads = column_number[number[inside] * n + column[inside]]
        pointer, columns = adjacency(tails, heads, size)
        matching = maximum_matching(pointer, columns, int(column_number[-1]) + 1)
        if not matching.is_perfect:
            varies[:] = True
            return varies
        form = block_triangular_form(pointer, columns, matching)
        diagonal = form.block_of_row[tails] == form.block_of_column[heads]
        varies[number[inside][diagonal & ~constant[inside]]] = True
    return varies
