"""How often each row must be differentiated.

Statement (Pantelides 1988, doi 10.1137/0909014; Pryce 2001, doi 10.1023/A:1021998624799): find
the smallest offsets ``c[i] >= 0`` of rows and ``d[j]`` of bases with ``d[j] - c[i] >= sigma[i, j]``
everywhere and equality on a perfect matching. Row ``i`` is then differentiated ``c[i]`` times, and
``d[j]`` is the order of the highest derivative of base ``j``.

Algorithm: with the current ``c``, let ``d[j]`` be the greatest ``sigma[i, j] + c[i]`` and look at
the entries where it is attained. If they have a perfect matching, stop. Otherwise the rows of the
overdetermined part get ``c + 1``. Pantelides treats one unmatched row after the other; all minimal
singular subsets together are that part, and no row of it can keep its ``c`` in the smallest
solution: such a row would have to be matched, in the solution's own graph, to a column that no
row differentiated further touches, and alternating paths from the unmatched rows never lead there.
So the result is the same, and the rounds are as many as the largest offset.

It ends exactly if the system with all orders taken together has a perfect matching. That is tested
first; if there is none, the system is singular, and the answer is a :class:`Singularity`.

Complexity: one matching per round.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from acausal.structural.dulmage_mendelsohn import (
    Decomposition,
    dulmage_mendelsohn,
    overdetermined_part,
)
from acausal.structural.graphs import Ints, Mask
from acausal.structural.incidence import Signature
from acausal.structural.matching import (
    Matching,
    matching_of_edges,
    maximum_matching,
    restrict_matching,
)


@dataclass(frozen=True)
class Offsets:
    """The result of index reduction.

    Attributes:
        c: Number of differentiations of each row, shape ``(n,)``.
        d: Order of the highest derivative of each base, shape ``(n,)``.
        matching: Perfect matching of rows and bases on the entries with
            ``sigma + c[i] == d[j]``.
        rounds: How many times the differentiated set grew.
    """

    c: Ints
    d: Ints
    matching: Matching
    rounds: int

    @property
    def degrees_of_freedom(self) -> int:
        """Number of initial values that can be chosen: ``sum(d) - sum(c)``."""
        return int(self.d.sum() - self.c.sum())


@dataclass(frozen=True)
class Singularity:
    """A system without a perfect matching, whatever is differentiated.

    Attributes:
        signature: The system.
        matching: A maximum matching over all its entries.
        parts: Its decomposition: too many rows in one part, too few in another.
    """

    signature: Signature
    matching: Matching
    parts: Decomposition


def pantelides(signature: Signature, least: Ints | None = None) -> Offsets | Singularity:
    """Find the smallest offsets.

    Args:
        signature: The signature matrix; it should be square.
        least: Order up to which each base has to be found at least, shape ``(n_bases,)``: a
            derivative that is wanted though it stands in no row (the output of an acceleration
            sensor) is determined by differentiating the rows of its base. 0 if None.

    Returns:
        The offsets, or what is singular.
    """
    n_rows, n_bases = signature.n_rows, signature.n_bases
    c = np.zeros(n_rows, np.int64)
    matching: Matching | None = None
    rounds = 0
    while True:
        d, tight = _highest(signature, c, least)
        rows, bases = signature.rows[tight], signature.bases[tight]
        pointer = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=n_rows))])
        if matching is not None:
            matching = restrict_matching(matching, pointer, bases)
        matching = maximum_matching(pointer, bases, n_bases, matching)
        if matching.is_perfect:
            return Offsets(c, d, matching, rounds)
        if rounds == 0:
            whole = maximum_matching(signature.pointer, signature.bases, n_bases, matching)
            if not whole.is_perfect:
                return singularity(signature, whole)
        over, _ = overdetermined_part(pointer, bases, matching)
        c = c + over
        rounds += 1


def _highest(signature: Signature, c: Ints, least: Ints | None) -> tuple[Ints, Mask]:
    """Return ``d`` for given ``c``, and where it is attained."""
    order = signature.orders + c[signature.rows]
    d = np.zeros(signature.n_bases, np.int64) if least is None else least.copy()
    np.maximum.at(d, signature.bases, order)
    return d, order == d[signature.bases]


def singularity(signature: Signature, matching: Matching | None = None) -> Singularity:
    """Decompose a system over all its entries, whether or not it is singular."""
    if matching is None:
        matching = matching_of_edges(
            signature.rows, signature.bases, signature.n_rows, signature.n_bases
        )
    parts = dulmage_mendelsohn(signature.pointer, signature.bases, matching)
    return Singularity(signature, matching, parts)


def differentiation_index(offsets: Offsets) -> int:
    """Return the structural differentiation index.

    It is the greatest ``c``, plus one if some unknown is purely algebraic (``d = 0``), as its
    equation would have to be differentiated once more to get an explicit equation for its
    derivative (Pryce 2001).
    """
    if offsets.c.shape[0] == 0:
        return 0
    return int(offsets.c.max()) + int((offsets.d == 0).any())
