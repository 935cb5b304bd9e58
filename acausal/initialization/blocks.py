"""The start block by block, in the order of the block lower triangular form.

Slower than one Newton method for everything (a Python loop over blocks), but each block starts
from values that are right already, and a failure has the names of few equations and unknowns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.flattening.model import Ids
from acausal.initialization.conditions import Conditions, incidence
from acausal.initialization.problem import (
    AlgebraicProblem,
    StartEquations,
    assembled,
)
from acausal.initialization.robust import Attempt, solve_robustly
from acausal.structural.blocks import block_triangular_form
from acausal.structural.matching import Matching

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BlockSolution:
    """The outcome; the work vector holds the values found.

    Attributes:
        failed: The attempt at the block that failed, None if all are solved.
        problem: That block's equations.
        guess: Where it started.
        count: Number of blocks.
        largest: Unknowns of the largest one.
        iterations: Newton steps in all blocks.
        regular: The Jacobians of all blocks are regular at the solution.
        methods: Methods other than plain Newton that were needed.
    """

    failed: Attempt | None
    problem: AlgebraicProblem | None
    guess: Array | None
    count: int
    largest: int
    iterations: int
    regular: bool
    methods: tuple[str, ...]


@dataclass(frozen=True)
class _Members:
    """Members of families by global row."""

    pointer: Ids
    family: Ids
    member: Ids


def _members(equations: StartEquations) -> _Members:
    rows = [family.rows for family in equations.families]
    joined = np.concatenate(rows)
    order = np.argsort(joined, kind="stable")
    family = np.repeat(np.arange(len(rows)), [r.shape[0] for r in rows])
    member = np.concatenate([np.arange(r.shape[0]) for r in rows])
    pointer = np.zeros(equations.total_rows + 1, dtype=np.int64)
    np.cumsum(np.bincount(joined, minlength=equations.total_rows), out=pointer[1:])
    return _Members(pointer, family[order], member[order])


def solve_blocks(equations: StartEquations, conditions: Conditions) -> BlockSolution:
    """Solve block after block from the values in the work vector.

    Args:
        equations: All rows; the work vector holds pinned values and guesses.
        conditions: Rows, unknowns and how they are matched.
    """
    n = conditions.rows.shape[0]
    total, n_ids = equations.total_rows, equations.system.n_ids
    local_row = np.full(total, n, dtype=np.int32)
    local_row[conditions.rows] = np.arange(n, dtype=np.int32)
    column = np.full(n_ids, -1, dtype=np.int32)
    column[conditions.unknowns] = np.arange(n, dtype=np.int32)
    rows, ids = incidence(equations.system)
    inside = rows < total
    rows, ids = rows[inside], ids[inside]
    inside = (local_row[rows] < n) & (column[ids] >= 0)
    rows, ids = local_row[rows[inside]].astype(np.int64), column[ids[inside]].astype(np.int64)
    order = np.argsort(rows, kind="stable")
    pointer = np.zeros(n + 1, dtype=np.int64)
    np.cumsum(np.bincount(rows, minlength=n), out=pointer[1:])
    diagonal = np.arange(n)
    blocks = block_triangular_form(pointer, ids[order], Matching(diagonal, diagonal))
    members = _members(equations)
    row_of = np.full(total, n, dtype=np.int32)
    column_of = np.full(n_ids, -1, dtype=np.int32)
    given = equations.system.variables.start_given
    iterations, regular = 0, True
    methods: dict[str, None] = {}
    largest = int(blocks.sizes.max(initial=0))
    for number in range(blocks.count):
        here = blocks.rows[blocks.pointer[number] : blocks.pointer[number + 1]]
        block_rows = conditions.rows[here]
        block_ids = conditions.unknowns[
            blocks.columns[blocks.pointer[number] : blocks.pointer[number + 1]]
        ]
        size = here.shape[0]
        row_of[block_rows] = np.arange(size, dtype=np.int32)
        column_of[block_ids] = np.arange(size, dtype=np.int32)
        spans = [np.arange(members.pointer[r], members.pointer[r + 1]) for r in block_rows]
        span = np.concatenate(spans)
        families = members.family[span]
        chosen = [
            (int(f), np.sort(members.member[span[families == f]])) for f in np.unique(families)
        ]
        problem = assembled(equations, chosen, row_of, column_of, block_rows, block_ids)
        row_of[block_rows] = n
        column_of[block_ids] = -1
        guess = problem.get()
        attempt = solve_robustly(problem, guess, ~given[block_ids])
        iterations += attempt.result.iterations
        if not attempt.result.converged:
            problem.put(guess)
            return BlockSolution(
                attempt, problem, guess, blocks.count, largest, iterations, False, tuple(methods)
            )
        problem.put(attempt.result.x)
        regular = regular and attempt.result.regular
        if attempt.method != "Newton":
            methods[attempt.method] = None
    return BlockSolution(
        None, None, None, blocks.count, largest, iterations, regular, tuple(methods)
    )
