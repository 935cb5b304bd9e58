"""Choose well-conditioned columns of wide matrices, level by level.

Statement: a matrix ``A`` of ``m`` rows and ``n >= m`` columns is given, whose rows have levels
``1 .. L``. Wanted is a *depth* for each column, such that for every level ``k`` the columns of
depth ``>= k`` are as many as the rows of level ``>= k``, and these rows and columns make a
well-conditioned square matrix ``B_k``. Columns have a rank per level; those of lower rank are
taken as long as the pivots allow it.

Algorithm: Gaussian elimination with complete pivoting, from the deepest level on; each pivot's
column gets the level as its depth. Then, as in Gu and Eisenstat's strong rank-revealing
factorisation (1996, doi 10.1137/0917055), columns exchange their depths as long as that multiplies
the determinants by more than a factor ``tau``; this bounds the entries of ``B_k^-1 N_k``, and it
ends, because determinants cannot grow for ever.

Complexity: ``O(m^2 n)`` per matrix; matrices of the same shape are worked on together.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from acausal.structural.graphs import Ints, Mask

Floats = NDArray[np.float64]

#: Pivots below this are refused as long as columns of a higher rank are left, by rank 1 .. 5
#: (never, avoid, default, prefer, always a state). Rows have norm 1.
PIVOT_TOLERANCE: Final = (0.0, 1e-6, 1e-3, 1e-3, 1e-6, 0.0)
#: Rank of a column that cannot have a depth of this level.
IMPOSSIBLE: Final = 6
#: Number of entries of a single matrix from which on LAPACK chooses, where it can.
LARGE: Final = 50_000
#: A column of higher rank takes the place of one of lower rank only for such a gain.
RANK_THRESHOLD: Final = 1e3
#: The same where a variable is never, or always, to be a state.
STRICT_THRESHOLD: Final = 1e6
#: Relative size of what is added to every entry, so that rows that vanish at a point, and rows
#: that are dependent there, still get columns that their structure allows.
PERTURBATION: Final = 1e-9


def perturbed(values: Floats, rows: Ints, columns: Ints, n_rows: int) -> Floats:
    """Scale the entries of a sparse matrix by rows and make it generically regular.

    Args:
        values: Entries; those that are not finite count as 1, and those of zero rows, too.
        rows: Their rows.
        columns: Their columns.
        n_rows: Number of rows.

    Returns:
        The entries with a largest one of about 1 in each row, and small reproducible additions.
    """
    values = np.where(np.isfinite(values), values, 1.0)
    largest = np.zeros(n_rows)
    np.maximum.at(largest, rows, np.abs(values))
    vanishes = largest[rows] == 0
    values, scale = np.where(vanishes, 1.0, values), np.where(vanishes, 1.0, largest[rows])
    # A fixed pseudo-random number in 0.5 .. 1.5 per entry (multiplicative hashing).
    mixed = (rows * 2654435761 + columns * 40503 + 12345) % 4294967291 * 48271 % 2147483647
    return values / scale + PERTURBATION * (0.5 + mixed / 2147483647.0)


def choose_columns(matrices: Floats, levels: Ints, ranks: Ints) -> Ints:
    """Choose the depths of columns by elimination.

    Args:
        matrices: Row-scaled matrices, shape ``(b, m, n)``.
        levels: Level of each row, descending, shape ``(m,)``.
        ranks: Rank of each column at level ``k + 1``, shape ``(b, L, n)``: 1 to 5, or
            ``IMPOSSIBLE``.

    Returns:
        Depths, shape ``(b, n)``.
    """
    b, m, n = matrices.shape
    if b == 1 and m * n > LARGE and bool((np.ptp(ranks, axis=2) == 0).all()):
        return _choose_by_orthogonalisation(matrices[0], levels)[None]
    rest = matrices.copy()
    depth = np.zeros((b, n), np.int64)
    free_row = np.ones((b, m), np.bool_)
    # Of equal columns the later declared one becomes dependent.
    bias = 1.0 + 1e-3 * np.arange(n) / max(n - 1, 1)
    for level in range(int(levels.max(initial=0)), 0, -1):
        active = levels >= level
        present = np.unique(ranks[:, level - 1])
        present = present[present < IMPOSSIBLE]
        for rank in present.tolist():
            last = rank == present[-1]
            tolerance = 0.0 if last else PIVOT_TOLERANCE[rank]
            allowed = ranks[:, level - 1] <= rank
            todo = np.flatnonzero((free_row & active).any(axis=1))
            while todo.shape[0]:
                usable = (free_row[todo] & active)[:, :, None]
                usable = usable & (allowed[todo] & (depth[todo] == 0))[:, None, :]
                size = np.where(usable, np.abs(rest[todo]) * bias, -1.0).reshape(todo.shape[0], -1)
                best = size.argmax(axis=1)
                found = size[np.arange(todo.shape[0]), best]
                # At the end a row without any entry still needs a column.
                good = found >= 0.0 if last else found > tolerance
                todo, best = todo[good], best[good]
                row, column = best // n, best % n
                _eliminate(rest, todo, row, column)
                free_row[todo, row] = False
                depth[todo, column] = level
                todo = todo[(free_row[todo] & active).any(axis=1)]
    return depth


def _choose_by_orthogonalisation(matrix: Floats, levels: Ints) -> Ints:
    """Choose columns of equal rank of one large matrix; LAPACK does the work.

    Per level, QR factorisation with column pivoting (Businger and Golub 1965,
    doi 10.1007/BF01436084) of what the rows of deeper levels leave.
    """
    from scipy.linalg import qr

    n = matrix.shape[1]
    depth = np.zeros(n, np.int64)
    done = 0
    for level in range(int(levels[0]), 0, -1):
        size = int(np.count_nonzero(levels >= level))
        if size == done:
            continue
        chosen, others = np.flatnonzero(depth > 0), np.flatnonzero(depth == 0)
        rest = matrix[done:size, others]
        if done:
            solved = np.linalg.solve(matrix[:done, chosen], matrix[:done, others])
            rest = rest - matrix[done:size, chosen] @ solved
        pivots = qr(rest, mode="r", pivoting=True)[1]
        depth[others[pivots[: size - done]]] = level
        done = size
    return depth


def _eliminate(rest: Floats, which: Ints, row: Ints, column: Ints) -> None:
    pivot_rows = rest[which, row]
    pivot = pivot_rows[np.arange(which.shape[0]), column]
    pivot = np.where(pivot == 0.0, 1.0, pivot)
    factors = rest[which, :, column] / pivot[:, None]
    factors[np.arange(which.shape[0]), row] = 0.0
    if rest.shape[0] == which.shape[0]:
        rest -= factors[:, :, None] * pivot_rows[:, None, :]
    else:
        rest[which] -= factors[:, :, None] * pivot_rows[:, None, :]


def exchange_gains(matrices: Floats, levels: Ints, depth: Ints) -> tuple[Floats, Ints]:
    """Return by how much exchanging the depths of two columns multiplies the determinants.

    Args:
        matrices: Row-scaled matrices, shape ``(b, m, n)``.
        levels: Level of each row, descending, shape ``(m,)``.
        depth: Depths, shape ``(b, n)``.

    Returns:
        Logarithms of the factors ``[b, q, p]`` if ``p`` takes the larger depth of ``q``, as the
        mean over the levels involved, minus infinity where ``p`` is not less deep; and the
        order of columns in which ``q`` and ``p`` count, shape ``(b, n)``, deepest first.
    """
    b, _, n = matrices.shape
    order = np.argsort(-depth, axis=1, kind="stable")
    turned = np.take_along_axis(matrices, order[:, None, :], axis=2)
    gains = np.zeros((b, n, n))
    involved = np.zeros((n, n))
    sizes, multiplicity = np.unique(
        [np.count_nonzero(levels >= k) for k in range(1, int(levels.max(initial=0)) + 1)],
        return_counts=True,
    )
    for k, times in zip(sizes.tolist(), multiplicity.tolist(), strict=True):
        if k == n:
            continue
        square, others = turned[:, :k, :k], turned[:, :k, k:]
        try:
            table = np.linalg.solve(square, others)
        except np.linalg.LinAlgError:
            table = np.linalg.pinv(square) @ others
        with np.errstate(divide="ignore"):
            gains[:, :k, k:] += times * np.log(np.abs(table))
        involved[:k, k:] += times
    gains /= np.maximum(involved, 1.0)
    gains[:, involved == 0] = -np.inf
    return gains, order


def improve_columns(
    matrices: Floats, levels: Ints, ranks: Ints, depth: Ints, tau: float
) -> tuple[Ints, Mask]:
    """Exchange depths of columns until no exchange gains more than a factor ``tau``.

    Args:
        matrices: Row-scaled matrices, shape ``(b, m, n)``.
        levels: Level of each row, descending, shape ``(m,)``.
        ranks: Rank of each column at level ``k + 1``, shape ``(b, L, n)``.
        depth: Depths, shape ``(b, n)``.
        tau: Least factor, > 1. Giving up a column of higher rank takes ``RANK_THRESHOLD``.

    Returns:
        New depths, and which matrices have changed.
    """
    b, m, n = matrices.shape
    depth = depth.copy()
    changed = np.zeros(b, np.bool_)
    todo = np.arange(b)
    for _ in range(4 * m + 4):
        gains, order = exchange_gains(matrices[todo], levels, depth[todo])
        gains -= _thresholds(ranks[todo], depth[todo], order, tau)
        flat = gains.reshape(todo.shape[0], -1)
        best = flat.argmax(axis=1)
        wins = flat[np.arange(todo.shape[0]), best] > 0.0
        if not wins.any():
            break
        todo, best, order = todo[wins], best[wins], order[wins]
        within = np.arange(todo.shape[0])
        q, p = order[within, best // n], order[within, best % n]
        depth[todo, q], depth[todo, p] = depth[todo, p], depth[todo, q]
        changed[todo] = True
    return depth, changed


def _thresholds(ranks: Ints, depth: Ints, order: Ints, tau: float) -> Floats:
    """Return the logarithm of the least gain for each exchange of ``exchange_gains``."""
    b, n = depth.shape
    if bool((ranks == ranks.flat[0]).all()):
        return np.full((1, 1, 1), np.log(tau))
    turned = np.take_along_axis(depth, order, axis=1)
    rises = np.zeros((b, n, n), np.int64)
    strict = np.zeros((b, n, n), np.bool_)
    for k in range(1, ranks.shape[1] + 1):
        rank = np.take_along_axis(ranks[:, k - 1], order, axis=1)
        here = (turned >= k)[:, :, None] & (turned < k)[:, None, :]
        rise = np.where(here, rank[:, None, :] - rank[:, :, None], 0)
        rises = np.maximum(rises, rise)
        extreme = (rank[:, None, :] == 5) | (rank[:, :, None] == 1)
        strict |= (rise > 0) & extreme
    levels = np.where(strict, STRICT_THRESHOLD, np.where(rises > 0, RANK_THRESHOLD, tau))
    return np.log(levels)
