"""Start values that were written lead the guesses of the unknowns nobody wrote one for.

Where a start has several solutions, as that of a flip-flop, the start values choose one. Newton's
method begins at the guesses of all unknowns, though, and what stands at a default may outweigh what
was written: the first modes of limits and diodes are then those of the default. So the unknowns
without a start value of their own are brought into agreement with the others first, as well as the
equations allow (one step of Gauss and Newton with the written values held, rows scaled).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from acausal.initialization.conditions import choose_conditions
from acausal.initialization.problem import algebraic_problem, start_equations
from acausal.initialization.system import StartSystem

Array = NDArray[np.float64]


def guided_guesses(system: StartSystem, time: float) -> Array:
    """Return the start values of all ids with better guesses for the unknowns, shape ``(n_ids,)``.

    The given array comes back if no written start value but zero belongs to an unknown, if there
    is nothing to improve, or if the equations cannot be evaluated at the guesses.

    Args:
        system: The equations of the start.
        time: Start time in s.
    """
    variables = system.variables
    if not (variables.start_given & ~variables.fixed & (variables.start != 0.0)).any():
        return variables.start
    conditions = choose_conditions(system)
    unknowns = conditions.unknowns
    given = variables.start_given[unknowns]
    if not (given & (variables.start[unknowns] != 0.0)).any() or given.all():
        return variables.start
    equations = start_equations(system)
    equations.set_values(variables.start, time)
    problem = algebraic_problem(equations, conditions.rows, unknowns[~given])
    x = problem.get()
    residual = problem.residual(x)
    data = problem.jacobian(x)
    if not (np.isfinite(residual).all() and np.isfinite(data).all()):
        return variables.start
    from scipy.sparse import csc_array, diags_array
    from scipy.sparse.linalg import lsqr

    scaled = data * np.repeat(problem.scale, np.diff(problem.indptr))
    size = np.zeros(problem.n_rows)
    np.maximum.at(size, problem.indices, np.abs(scaled))
    weight = np.where(size > 0.0, 1.0 / np.where(size > 0.0, size, 1.0), 0.0)
    matrix = csc_array(
        (scaled, problem.indices, problem.indptr), shape=(problem.n_rows, problem.n)
    )
    step = lsqr(diags_array(weight) @ matrix, -weight * residual)[0] * problem.scale
    if not np.isfinite(step).all():
        return variables.start
    guess = variables.start.copy()
    guess[problem.ids] = np.clip(x + step, problem.minimum, problem.maximum)
    return guess
