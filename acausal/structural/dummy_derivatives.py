"""Dummy derivatives: which variables are states.

Statement (Mattsson and Soederlind 1993, doi 10.1137/0914043): a row differentiated ``c`` times
stands in the system in ``c + 1`` forms, so for each of the ``c`` differentiations one derivative
has to become a *dummy*, an algebraic unknown of its own. At level ``k = 1, 2, ...`` the rows with
``c >= k`` need as many bases, whose derivatives of order ``d - k + 1`` become dummies, and the
square Jacobian of these rows with respect to these bases (the numbers are the same at every level)
must be well conditioned. The bases of level ``k + 1`` are among those of level ``k``. A base of
*depth* ``h`` is in levels ``1 .. h``; then its orders below ``d - h`` are states.

Choice: the deepest level, that of positions, chooses first; see
:mod:`acausal.structural.column_choice`. A base at level ``k`` loses the states of order
``d - k`` and above, so its rank there is the strongest ``stateSelect`` wish among them: the highest
one above ``default``, else the lowest.

Complexity: connected blocks are independent; blocks of the same shape are worked on together, in
``O(m^2 n)`` each; blocks above ``DENSE_BLOCK`` entries by sparse elimination.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from acausal.connections.components import connected_components
from acausal.flattening.model import Ids, StateSelect
from acausal.structural.column_choice import (
    IMPOSSIBLE,
    choose_columns,
    improve_columns,
    perturbed,
)
from acausal.structural.graphs import Mask, stable_order
from acausal.structural.highest_jacobian import HighestEntries
from acausal.structural.incidence import Chains
from acausal.structural.lasting_choice import determinant_varies
from acausal.structural.pantelides import Offsets
from acausal.structural.sparse_choice import choose_columns_sparse

Values = NDArray[np.float64]

#: Other states are chosen when that multiplies a determinant by more than this factor.
TAU: Final = 5.0
#: Entries of a block, counted densely, from which on it is treated as sparse.
DENSE_BLOCK: Final = 2_000_000
#: The same for blocks that are mostly empty.
SPARSE_BLOCK: Final = 100_000
#: Entries of all blocks that are worked on together.
_BATCH: Final = 4_000_000


@dataclass(frozen=True)
class Shape:
    """Blocks with equally many rows per level and equally many columns.

    Attributes:
        levels: ``c`` of the rows, descending, shape ``(m,)``.
        rows: Rows of the blocks, ``c`` descending, shape ``(b, m)``.
        bases: Their bases, ascending, shape ``(b, n)``.
        entries: Their entries in :class:`HighestEntries`.
        block: Number within this shape, row and column of each of those entries,
            shape ``(3, len(entries))``.
        ranks: Ranks by level and base, shape ``(b, L, n)``.
        sparse: Whether it is one large block, treated as sparse.
    """

    levels: Ids
    rows: Ids
    bases: Ids
    entries: Ids
    block: Ids
    ranks: Ids
    sparse: bool

    @property
    def has_choice(self) -> bool:
        """Whether different bases could be chosen, judged by the numbers of rows and bases."""
        n = self.bases.shape[1]
        return bool((self.levels < self.levels.max()).any()) or self.levels.shape[0] < n

    def matrices(self, values: Values) -> Values:
        """Return the row-scaled dense matrices of the blocks, shape ``(b, m, n)``."""
        b, m = self.rows.shape
        result = np.zeros((b, m, self.bases.shape[1]))
        number, row, column = self.block
        result[number, row, column] = perturbed(
            values[self.entries], number * m + row, column, b * m
        )
        return result


@dataclass(frozen=True)
class Alternatives:
    """Where other states could be chosen at run time.

    Attributes:
        entries: Where the Jacobian is needed to judge it.
        shapes: All blocks, by shape.
        monitored: For each shape which of its blocks have a choice that can become a bad one,
            shape ``(b,)``. A choice whose Jacobian is constant stays as good as it is.
        nominal: Nominal value of the variable of each entry, which scales columns.
        wishes: :class:`StateSelect` of each id.
    """

    entries: HighestEntries
    shapes: tuple[Shape, ...]
    monitored: tuple[Mask, ...]
    nominal: Values
    wishes: Ids

    @property
    def any(self) -> bool:
        """Whether anything has to be monitored at all."""
        return any(bool(mask.any()) for mask in self.monitored)

    @property
    def n_blocks(self) -> int:
        """Number of blocks to monitor."""
        return sum(int(mask.sum()) for mask in self.monitored)


@dataclass(frozen=True)
class StateSelection:
    """The states and the dummy derivatives.

    Attributes:
        chains: All variables, those of the differentiated system.
        d: Order of the highest derivative of each base, shape ``(n_bases,)``.
        depth: How many derivatives of each base are dummy, from the highest down.
        is_state: Which ids are states: their derivative is in the system and no dummy.
        is_dummy: Which ids are dummy derivatives.
        dummy_in_spite: States wished ``always`` that had to become dependent, ascending ids.
        state_in_spite: States wished ``never``, ascending ids.
        alternatives: Where there is a choice.
    """

    chains: Chains
    d: Ids
    depth: Ids
    is_state: Mask
    is_dummy: Mask
    dummy_in_spite: Ids
    state_in_spite: Ids
    alternatives: Alternatives

    @property
    def is_active(self) -> Mask:
        """Which ids are unknowns of the reduced system.

        Ids that are derivatives of a higher order than any row has are not.
        """
        base = self.chains.base
        active: Mask = base >= 0
        active[active] = self.chains.order[active] <= self.d[base[active]]
        return active

    @property
    def states(self) -> Ids:
        """Ids of the states, ascending."""
        return np.flatnonzero(self.is_state)

    @property
    def dummies(self) -> Ids:
        """Ids of the dummy derivatives, ascending."""
        return np.flatnonzero(self.is_dummy)


def select_states(
    chains: Chains,
    offsets: Offsets,
    entries: HighestEntries,
    values: Values,
    state_select: NDArray[np.int8],
    nominal: Values | None = None,
    constant: Mask | None = None,
    tau: float = TAU,
) -> StateSelection:
    """Choose the states.

    Args:
        chains: The variables of the differentiated system.
        offsets: The offsets.
        entries: Positions of the Jacobian.
        values: Its entries; zeros and NaN are allowed.
        state_select: :class:`StateSelect` of each id, shape ``(n_variables,)``; may be
            shorter, further ids have the default.
        nominal: Magnitude of each id, shape ``(n_variables,)`` or shorter; 1 if None.
        constant: Which entries never change; none, if None.
        tau: Factor of the determinant from which on other states are better.

    Returns:
        The selection.
    """
    n = chains.n_variables
    wishes = np.full(n, int(StateSelect.DEFAULT), np.int64)
    wishes[: state_select.shape[0]] = state_select
    scale = np.ones(n)
    if nominal is not None:
        scale[: nominal.shape[0]] = nominal
    if constant is None:
        constant = np.zeros(entries.rows.shape[0], np.bool_)
    shapes = _shapes(entries, offsets, _ranks(chains, offsets, wishes))
    nominal_of_entry = scale[entries.variables]
    values = values * nominal_of_entry
    depth = np.zeros(chains.n_bases, np.int64)
    for shape in shapes:
        for part in batches(shape):
            depth[part.bases] = choose_depths(part, values, tau)
    monitored = tuple(_changing(shape, constant, values, depth) for shape in shapes)
    alternatives = Alternatives(entries, shapes, monitored, nominal_of_entry, wishes)
    return selection_of(chains, offsets.d, depth, alternatives)


def choose_depths(shape: Shape, values: Values, tau: float) -> Ids:
    """Return the depths of the bases of all blocks of a shape, shape ``(b, n)``."""
    if not shape.has_choice:
        return np.full(shape.bases.shape, shape.levels[0])
    if shape.sparse:
        return sparse_depths(shape, values)[None]
    matrices = shape.matrices(values)
    depth = choose_columns(matrices, shape.levels, shape.ranks)
    return improve_columns(matrices, shape.levels, shape.ranks, depth, tau)[0]


def sparse_depths(shape: Shape, values: Values) -> Ids:
    """Return the depths of the bases of one large block, shape ``(n,)``."""
    _, row, column = shape.block
    m, n = shape.rows.shape[1], shape.bases.shape[1]
    scaled = perturbed(values[shape.entries], row, column, m)
    return choose_columns_sparse(row, column, scaled, (m, n), shape.levels, shape.ranks[0])


def selection_of(chains: Chains, d: Ids, depth: Ids, alternatives: Alternatives) -> StateSelection:
    """Turn depths into roles of variables."""
    wishes = alternatives.wishes
    unknown = chains.base >= 0
    base = np.where(unknown, chains.base, 0)
    if chains.n_bases:
        lowest_dummy = (d - depth)[base]
        is_state = unknown & (chains.order < lowest_dummy)
        is_dummy = unknown & (chains.order > lowest_dummy) & (chains.order <= d[base])
        # With no state left in its chain, a variable of order 0 is algebraic, but no dummy.
        was_state = unknown & (chains.order < d[base])
    else:
        is_state = is_dummy = was_state = np.zeros(chains.n_variables, np.bool_)
    return StateSelection(
        chains,
        d,
        depth,
        is_state,
        is_dummy,
        np.flatnonzero(was_state & ~is_state & (wishes == StateSelect.ALWAYS)),
        np.flatnonzero(is_state & (wishes == StateSelect.NEVER)),
        alternatives,
    )


def batches(shape: Shape) -> tuple[Shape, ...]:
    """Cut a shape into parts that fit into memory when stored densely."""
    b = shape.rows.shape[0]
    step = max(1, _BATCH // shape.bases.shape[1] ** 2)
    if b <= step or shape.sparse:
        return (shape,)
    places = np.arange(b)
    return tuple(
        select_blocks(shape, (places >= first) & (places < first + step))
        for first in range(0, b, step)
    )


def select_blocks(shape: Shape, wanted: Mask) -> Shape:
    """Return the shape of some of the blocks.

    Args:
        shape: The shape.
        wanted: Which blocks stay, shape ``(b,)``.
    """
    if wanted.all():
        return shape
    inside = wanted[shape.block[0]]
    block = shape.block[:, inside]
    block[0] = (np.cumsum(wanted) - 1)[block[0]]
    return replace(
        shape,
        rows=shape.rows[wanted],
        bases=shape.bases[wanted],
        ranks=shape.ranks[wanted],
        entries=shape.entries[inside],
        block=block,
    )


def _ranks(chains: Chains, offsets: Offsets, wishes: Ids) -> Ids:
    """Return the rank of every base at level ``k + 1``, shape ``(L, n_bases)``."""
    d = offsets.d
    n_levels = int(offsets.c.max(initial=0))
    bases = np.arange(chains.n_bases)
    highest = np.full(chains.n_bases, int(StateSelect.DEFAULT))
    lowest = highest.copy()
    ranks = np.empty((n_levels, chains.n_bases), np.int64)
    for k in range(n_levels):
        ids = chains.ids(bases, d - k - 1)
        here = wishes[ids]
        highest = np.where(ids >= 0, np.maximum(highest, here), highest)
        lowest = np.where(ids >= 0, np.minimum(lowest, here), lowest)
        wish = np.where(highest > StateSelect.DEFAULT, highest, lowest)
        ranks[k] = np.where(ids >= 0, wish, IMPOSSIBLE)
    return ranks


def _shapes(entries: HighestEntries, offsets: Offsets, ranks: Ids) -> tuple[Shape, ...]:
    """Split the differentiated rows into connected blocks and sort these by shape."""
    rows, row_of_entry = np.unique(entries.rows, return_inverse=True)
    bases, base_of_entry = np.unique(entries.bases, return_inverse=True)
    m, n = rows.shape[0], bases.shape[0]
    if m == 0:
        return ()
    count, label = connected_components(row_of_entry, m + base_of_entry, m + n)
    row_block, base_block = label[:m], label[m:]
    c = offsets.c[rows]
    # Rows by block, within a block by descending c, then by number; bases by block.
    row_order = stable_order(row_block * (int(c.max()) + 1) + (c.max() - c))
    base_order = stable_order(base_block)
    row_first, base_first = _pointer(row_block, count), _pointer(base_block, count)
    row_place, base_place = np.empty(m, np.int64), np.empty(n, np.int64)
    row_place[row_order] = np.arange(m) - row_first[row_block[row_order]]
    base_place[base_order] = np.arange(n) - base_first[base_block[base_order]]
    per_level = [np.bincount(row_block[c >= k], minlength=count) for k in range(1, c.max() + 1)]
    nnz = np.bincount(row_block[row_of_entry], minlength=count)
    signatures = np.stack([np.diff(base_first), *per_level], axis=1)
    cells = signatures[:, 0] * signatures[:, 1]
    sparse = (cells > DENSE_BLOCK) | ((cells > SPARSE_BLOCK) & (20 * nnz < cells))
    # Large blocks are alone in their shape.
    alone = np.where(sparse, np.arange(count) + 1, 0)
    _, kind = np.unique(np.column_stack([signatures, alone]), axis=0, return_inverse=True)
    kind = kind.reshape(-1)
    entry_kind = kind[row_block[row_of_entry]]
    blocks_by_kind, entries_by_kind = stable_order(kind), stable_order(entry_kind)
    n_kinds = int(kind.max()) + 1
    block_first, entry_first = _pointer(kind, n_kinds), _pointer(entry_kind, n_kinds)
    shapes = []
    for number in range(n_kinds):
        blocks = blocks_by_kind[block_first[number] : block_first[number + 1]]
        inside = entries_by_kind[entry_first[number] : entry_first[number + 1]]
        of_entry = np.searchsorted(blocks, row_block[row_of_entry[inside]])
        order = stable_order(of_entry)
        inside, of_entry = inside[order], of_entry[order]
        width, height = signatures[blocks[0], :2].tolist()
        block_rows = row_order[row_first[blocks][:, None] + np.arange(height)]
        block_bases = bases[base_order[base_first[blocks][:, None] + np.arange(width)]]
        places = np.stack(
            [of_entry, row_place[row_of_entry[inside]], base_place[base_of_entry[inside]]]
        )
        levels = c[block_rows[0]]
        shapes.append(
            Shape(
                levels,
                rows[block_rows],
                block_bases,
                inside,
                places,
                np.moveaxis(ranks[: int(levels[0]), block_bases], 0, 1),
                bool(sparse[blocks[0]]),
            )
        )
    return tuple(shapes)


def _pointer(label: Ids, count: int) -> Ids:
    pointer = np.zeros(count + 1, np.int64)
    np.cumsum(np.bincount(label, minlength=count), out=pointer[1:])
    return pointer


def _changing(shape: Shape, constant: Mask, values: Values, depth: Ids) -> Mask:
    """Return which blocks have a choice that can become a bad one."""
    if not shape.has_choice:
        return np.zeros(shape.rows.shape[0], np.bool_)
    own = constant[shape.entries]
    present = ~(own & (values[shape.entries] == 0.0))
    return determinant_varies(
        shape.block[:, present], shape.levels, depth[shape.bases], own[present]
    )
