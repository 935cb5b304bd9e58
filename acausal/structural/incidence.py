"""Which variable, in which order of derivative, stands in which row.

Statement: every scalar variable is a member of a chain ``x, x', x'', ...``; base ``j`` is the
chain's head and the order its place. The *signature* ``sigma[i, j]`` is the highest order in which
base ``j`` stands in row ``i`` (Pryce 2001, doi 10.1023/A:1021998624799). It is all that index
reduction needs to know of the equations.

Complexity: ``O(e log e)`` for ``e`` operands, by sorting one integer key per operand.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.flattening.model import EquationFamily, Ids, Operand
from acausal.structural.graphs import compress


@dataclass(frozen=True)
class Chains:
    """Scalar variables as (base, order).

    Attributes:
        derivative: Id of the time derivative of each variable or -1, shape ``(n,)``.
        base: Base of each variable, -1 for ids that are no unknowns, shape ``(n,)``.
        order: Order of derivative of each variable, shape ``(n,)``.
        pointer: Where each base's members begin in ``members``, shape ``(n_bases + 1,)``.
        members: Ids by base, then by order.
    """

    derivative: Ids
    base: Ids
    order: Ids
    pointer: Ids
    members: Ids

    @property
    def n_variables(self) -> int:
        """Number of scalar variables, derivatives counted."""
        return int(self.derivative.shape[0])

    @property
    def n_bases(self) -> int:
        """Number of chains."""
        return int(self.pointer.shape[0]) - 1

    @property
    def highest(self) -> Ids:
        """Highest order of each base for which there is an id, shape ``(n_bases,)``."""
        return np.diff(self.pointer) - 1

    @property
    def heads(self) -> Ids:
        """Id of order 0 of each base, shape ``(n_bases,)``."""
        return self.members[self.pointer[:-1]]

    def ids(self, bases: Ids, orders: Ids) -> Ids:
        """Return the ids of (base, order) pairs, -1 where there is none."""
        exists = (orders >= 0) & (orders <= self.highest[bases])
        return np.where(exists, self.members[self.pointer[bases] + np.where(exists, orders, 0)], -1)

    def extend(self, highest: Ids) -> Chains:
        """Give every base ids up to an order.

        Args:
            highest: Wanted highest order of each base, shape ``(n_bases,)``; chains that are
                longer stay as they are.

        Returns:
            Chains with the new ids after the old ones, by base and then by order.
        """
        missing = np.maximum(highest - self.highest, 0)
        n_new = int(missing.sum())
        if n_new == 0:
            return self
        new = np.arange(self.n_variables, self.n_variables + n_new)
        new_base = np.repeat(np.arange(self.n_bases), missing)
        within = np.arange(n_new) - np.repeat(np.cumsum(missing) - missing, missing)
        new_order = np.repeat(self.highest + 1, missing) + within
        last = self.members[self.pointer[1:] - 1]
        before = np.where(within == 0, last[new_base], new - 1)
        derivative = np.concatenate([self.derivative, np.full(n_new, -1, np.int64)])
        derivative[before] = new
        base = np.concatenate([self.base, new_base])
        order = np.concatenate([self.order, new_order])
        return _chains(derivative, base, order, self.n_bases)


def _chains(derivative: Ids, base: Ids, order: Ids, n_bases: int) -> Chains:
    lengths = np.bincount(base[base >= 0], minlength=n_bases)
    pointer = np.zeros(n_bases + 1, np.int64)
    np.cumsum(lengths, out=pointer[1:])
    members = np.empty(int(pointer[-1]), np.int64)
    unknown = np.flatnonzero(base >= 0)
    members[pointer[base[unknown]] + order[unknown]] = unknown
    return Chains(derivative, base, order, pointer, members)


def chains_of(derivative: Ids, unknown: NDArray[np.bool_] | None = None) -> Chains:
    """Follow the chains of derivatives.

    Args:
        derivative: Id of the time derivative of each variable or -1, shape ``(n,)``.
        unknown: Which ids are unknowns of the system (eliminated ones are not), shape ``(n,)``;
            a chain counts as soon as one of its members does. All, if None.

    Returns:
        The chains; bases are numbered by the ids of their heads.

    Raises:
        ValueError: If two variables have the same derivative, or chains close to a ring; no
            model leads to this.
    """
    derivative = np.asarray(derivative, np.int64)
    n = derivative.shape[0]
    if unknown is None:
        unknown = np.ones(n, np.bool_)
    followed = derivative[derivative >= 0]
    is_derivative = np.zeros(n, np.bool_)
    is_derivative[followed] = True
    if int(is_derivative.sum()) != followed.shape[0]:
        raise ValueError("two variables share one derivative")
    heads = np.flatnonzero(~is_derivative)
    base, order = np.full(n, -1, np.int64), np.zeros(n, np.int64)
    chain = np.arange(heads.shape[0])
    counts = np.zeros(heads.shape[0], np.bool_)
    level, ids, reached = 0, heads, 0
    while ids.shape[0]:
        reached += ids.shape[0]
        base[ids], order[ids] = chain, level
        counts[chain[unknown[ids]]] = True
        ids = derivative[ids]
        chain, ids = chain[ids >= 0], ids[ids >= 0]
        level += 1
    if reached != n:
        raise ValueError("a variable is its own derivative")
    if not counts.all():
        number = np.where(counts, np.cumsum(counts) - 1, -1)
        base = number[base]
        order[base < 0] = 0
    return _chains(derivative, base, order, int(counts.sum()))


@dataclass(frozen=True)
class Incidence:
    """Sorted pairs of a row and a variable in it.

    Attributes:
        chains: The variables.
        n_rows: Number of rows.
        rows: Row of each entry, ascending, shape ``(entries,)``.
        bases: Base of each entry, ascending within a row.
        orders: Order of each entry, ascending within a row and base; entries are unique.
    """

    chains: Chains
    n_rows: int
    rows: Ids
    bases: Ids
    orders: Ids

    @property
    def ids(self) -> Ids:
        """Variable id of each entry, shape ``(entries,)``."""
        return self.chains.ids(self.bases, self.orders)

    def signature(self) -> Signature:
        """Return the highest order of every base in every row."""
        last = np.ones(self.rows.shape[0], np.bool_)
        same = (self.rows[1:] == self.rows[:-1]) & (self.bases[1:] == self.bases[:-1])
        last[:-1] = ~same
        rows = self.rows[last]
        pointer = compress(rows, self.n_rows)
        return Signature(
            self.n_rows, self.chains.n_bases, pointer, rows, self.bases[last], self.orders[last]
        )


@dataclass(frozen=True)
class Signature:
    """The sparse signature matrix ``sigma``.

    Attributes:
        n_rows: Number of rows.
        n_bases: Number of columns, that is of bases.
        pointer: Row pointers, shape ``(n_rows + 1,)``.
        rows: Row of each entry, ascending, shape ``(entries,)``.
        bases: Base of each entry, ascending within a row.
        orders: ``sigma`` of each entry, >= 0.
    """

    n_rows: int
    n_bases: int
    pointer: Ids
    rows: Ids
    bases: Ids
    orders: Ids


def incidence_of(families: Sequence[EquationFamily], n_rows: int, chains: Chains) -> Incidence:
    """Collect the incidence of equation families.

    Args:
        families: The families; every variable slot counts as a dependence.
        n_rows: Number of rows.
        chains: The variables.

    Returns:
        The incidence. Operands that are no unknowns are left out.
    """
    rows, ids = [], []
    for family in families:
        for slot, kind in enumerate(family.kinds):
            if kind == Operand.VARIABLE:
                rows.append(family.rows)
                ids.append(family.operands[slot])
    if not rows:
        empty = np.zeros(0, np.int64)
        return Incidence(chains, n_rows, empty, empty, empty)
    return incidence_of_pairs(np.concatenate(rows), np.concatenate(ids), n_rows, chains)


def incidence_of_pairs(rows: Ids, ids: Ids, n_rows: int, chains: Chains) -> Incidence:
    """Sort (row, variable id) pairs in any order, with repetitions, into an incidence."""
    rows, ids = np.asarray(rows, np.int64), np.asarray(ids, np.int64)
    bases, orders = chains.base[ids], chains.order[ids]
    unknown = bases >= 0
    if not unknown.all():
        rows, bases, orders = rows[unknown], bases[unknown], orders[unknown]
    order_bits = int(orders.max(initial=0)).bit_length()
    base_bits = max(chains.n_bases - 1, 0).bit_length()
    key = np.sort((rows << (base_bits + order_bits)) | (bases << order_bits) | orders)
    if key.shape[0]:
        key = key[np.concatenate([[True], key[1:] != key[:-1]])]
    return Incidence(
        chains,
        n_rows,
        key >> (base_bits + order_bits),
        (key >> order_bits) & ((1 << base_bits) - 1),
        key & ((1 << order_bits) - 1),
    )
