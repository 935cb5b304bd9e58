"""Choice of conditions by numbers, where structure alone chooses badly.

A pendulum that starts horizontally can be pinned by its height, not by its distance: the structure
is the same, the Jacobian singular. The directions that the equations leave free are the null space
of their Jacobian; rank-revealing QR with column pivoting (Businger and Golub 1965, doi
10.1007/BF01436084) picks the coordinates that tell these directions apart best.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from acausal.flattening.model import Ids
from acausal.initialization.conditions import Conditions
from acausal.initialization.linear import dense_matrix
from acausal.initialization.problem import StartEquations, algebraic_problem

Array = NDArray[np.float64]

#: Largest number of unknowns for which the dense decomposition is made.
LARGEST = 1500
#: Weights of conditions: start of a state given, of another differentiated variable given, of a
#: state by default, of another differentiated variable.
WEIGHTS = (1.0, 0.5, 0.1, 0.05)


def well_conditioned(equations: StartEquations, conditions: Conditions) -> Ids | None:
    """Return ids whose start values make the system regular at the present point.

    Args:
        equations: All rows; the work vector holds the point.
        conditions: The conditions chosen so far.

    Returns:
        As many ids as conditions were free to choose, ascending, or None if there is no better
        choice, or none to be made.
    """
    wanted = conditions.chosen.shape[0]
    system = equations.system
    ids = np.sort(np.concatenate([conditions.unknowns, conditions.chosen]))
    if wanted == 0 or ids.shape[0] > LARGEST:
        return None
    from scipy.linalg import qr

    problem = algebraic_problem(equations, conditions.rows, ids)
    data = problem.jacobian(problem.get())
    if not np.isfinite(data).all():
        return None
    scale = np.maximum(problem.scale, np.abs(problem.get()))
    matrix = dense_matrix(problem.indptr, problem.indices, data, problem.n_rows) * scale
    size = np.abs(matrix).max(axis=1, initial=0.0)
    matrix /= np.where(size > 0.0, size, 1.0)[:, None]
    _, values, directions = np.linalg.svd(matrix)
    rank = int((values > 1e-9 * values.max(initial=1.0)).sum())
    null = directions[rank:]
    weight = np.zeros(system.n_ids)
    variables = system.variables
    differentiated = system.derivative >= 0
    is_state = np.zeros(system.n_ids, dtype=np.bool_)
    is_state[system.states] = True
    weight[differentiated] = WEIGHTS[3]
    weight[is_state] = WEIGHTS[2]
    weight[differentiated & variables.start_given] = WEIGHTS[1]
    weight[is_state & variables.start_given] = WEIGHTS[0]
    candidates = np.flatnonzero(weight[ids] > 0.0)
    if candidates.shape[0] < wanted or null.shape[0] < wanted:
        return None
    _, _, order = qr(null[:, candidates] * weight[ids[candidates]], pivoting=True, mode="economic")
    chosen: Ids = np.sort(ids[candidates[order[:wanted]]])
    return None if np.array_equal(chosen, conditions.chosen) else chosen
