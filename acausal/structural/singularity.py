"""Small subsets of a singular system, for messages.

Statement: let a row ``r`` be unmatched by a maximum matching. The rows that alternating paths from
``r`` reach, ``r`` among them, have one variable too few, and every proper subset of them has
enough: they are the fundamental circuit of ``r`` in the transversal matroid of the rows (Edmonds
and Fulkerson 1965). They are connected. For an unmatched variable the same holds with rows and
variables exchanged.

Complexity: linear in the size of a subset's search.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from acausal.structural.dulmage_mendelsohn import transpose
from acausal.structural.graphs import Ints, breadth_first_forest, gather
from acausal.structural.matching import Matching, alternating_graph
from acausal.structural.pantelides import Singularity


@dataclass(frozen=True)
class SingularSubset:
    """A smallest set of rows that is one too many for its variables, or the other way round.

    Attributes:
        overdetermined: More rows than variables, else more variables than rows.
        exposed: The row (or variable, as a base) without a partner.
        rows: Its rows, ascending.
        bases: Its variables, as bases, ascending. For an overdetermined subset all variables of
            its rows; for an underdetermined one its rows are all rows of its variables.
    """

    overdetermined: bool
    exposed: int
    rows: Ints
    bases: Ints


def singular_subsets(singularity: Singularity, limit: int = 8) -> tuple[SingularSubset, ...]:
    """Find the smallest subsets that explain why a system is singular.

    Args:
        singularity: What index reduction has found.
        limit: Number of subsets of each kind at most; further ones are most often repetitions.

    Returns:
        Overdetermined subsets, smallest first, then underdetermined ones, smallest first.
    """
    signature, matching = singularity.signature, singularity.matching
    pointer, bases = signature.pointer, signature.bases
    over = _circuits(pointer, bases, matching, limit)
    turned = Matching(matching.row_of_column, matching.column_of_row)
    column_pointer, rows = transpose(pointer, bases, signature.n_bases)
    under = _circuits(column_pointer, rows, turned, limit)
    return (
        *(SingularSubset(True, exposed, many, few) for exposed, many, few in over),
        *(SingularSubset(False, exposed, few, many) for exposed, many, few in under),
    )


def count_exposed(singularity: Singularity) -> tuple[int, int]:
    """Return the number of unmatched rows and of unmatched variables."""
    matching = singularity.matching
    return (
        int(np.count_nonzero(matching.column_of_row < 0)),
        int(np.count_nonzero(matching.row_of_column < 0)),
    )


def _circuits(
    pointer: Ints, columns: Ints, matching: Matching, limit: int
) -> list[tuple[int, Ints, Ints]]:
    n_rows = pointer.shape[0] - 1
    free = np.flatnonzero(matching.column_of_row < 0)[:limit]
    graph, head = alternating_graph(pointer, columns, matching.row_of_column)
    found = []
    for exposed in free:
        order, _ = breadth_first_forest(graph, head, exposed[None])
        rows = np.sort(order[order < n_rows])
        found.append((int(exposed), rows, np.unique(columns[gather(pointer, rows)])))
    return sorted(found, key=lambda item: (item[1].shape[0], item[0]))
