"""Start values that were written lead the guesses of the unknowns nobody wrote one for.

Where a start has several solutions, as that of a flip-flop, the start values choose one. Newton's
method begins at the guesses of all unknowns, though, and what stands at a default may outweigh what
was written: the first modes of limits and diodes are then those of the default. So the unknowns
without a start value of their own are brought into agreement with the others first, as well as the
equations allow (one step of Gauss and Newton with the written values held, rows scaled). Start
values of eliminated variables count by their definitions.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from acausal.elimination.families import variable_slots
from acausal.elimination.recover import family_values
from acausal.expressions.build import neg
from acausal.expressions.nodes import slot
from acausal.flattening.members import take_members
from acausal.flattening.model import EquationFamily, Ids, Operand
from acausal.initialization.conditions import choose_conditions
from acausal.initialization.problem import algebraic_problem, start_equations
from acausal.initialization.system import StartSystem

Array = NDArray[np.float64]
Families = tuple[EquationFamily, ...]

#: Written values of unknowns are held exactly; those of eliminated variables hold nearly so.
DEFINITION_WEIGHT = 1e3


def guided_guesses(system: StartSystem, time: float, *, only_eliminated: bool = False) -> Array:
    """Return the start values of all ids with better guesses for the unknowns, shape ``(n_ids,)``.

    The given array comes back if no start value but zero is written for what is sought, if there
    is nothing to improve, or if the equations cannot be evaluated at the guesses.

    Args:
        system: The equations of the start.
        time: Start time in s.
        only_eliminated: Do nothing where no eliminated variable has a written start value:
            Newton's method begins at those of unknowns anyway.
    """
    variables = system.variables
    written = variables.start_given & ~variables.fixed & (variables.start != 0.0)
    if not written.any():
        return variables.start
    families, defined = _definitions(system, written)
    if only_eliminated and not defined.shape[0]:
        return variables.start
    conditions = choose_conditions(system)
    unknowns = conditions.unknowns
    given = variables.start_given[unknowns]
    if given.all() or not (written[unknowns].any() or defined.shape[0]):
        return variables.start
    # The definitions are rows like the others here, before the initial ones.
    n, k = system.n_rows, defined.shape[0]
    rows = np.where(conditions.rows < n, conditions.rows, conditions.rows + k)
    rows = np.concatenate([rows, n + np.arange(k)])
    system = replace(system, families=(*system.families, *families), n_rows=n + k)
    equations = start_equations(system)
    equations.set_values(_with_definitions(system, families[:-1], defined, time), time)
    sought = np.concatenate([unknowns[~given], defined[~variables.start_given[defined]]])
    problem = algebraic_problem(equations, rows, sought)
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
    weight[(problem.rows >= n) & (problem.rows < n + k)] *= DEFINITION_WEIGHT
    matrix = csc_array((scaled, problem.indices, problem.indptr), shape=(problem.n_rows, problem.n))
    step = lsqr(diags_array(weight) @ matrix, -weight * residual)[0] * problem.scale
    if not np.isfinite(step).all():
        return variables.start
    guess = variables.start.copy()
    better = np.clip(x + step, problem.minimum, problem.maximum)
    own = unknowns.shape[0] - int(given.sum())  # eliminated variables follow
    guess[problem.ids[:own]] = better[:own]
    return guess


def _with_definitions(system: StartSystem, families: Families, defined: Ids, time: float) -> Array:
    """Return the start values, those nobody wrote of eliminated variables computed.

    Args:
        system: The equations with those of eliminated variables.
        families: Contributions to the definitions, in order of evaluation.
        defined: The eliminated variables, in the order of their rows, the last ones but initial.
        time: Start time in s.
    """
    values = system.variables.start.copy()
    silent = ~system.variables.start_given
    values[defined[silent[defined]]] = 0.0
    first = system.n_rows - defined.shape[0]
    for family in families:
        ids = defined[family.rows - first]
        mine = silent[ids]
        terms = family_values(family, values, system.parameters, time)
        np.add.at(values, ids[mine], terms[mine])
    return values


def _definitions(system: StartSystem, written: NDArray[np.bool_]) -> tuple[Families, Ids]:
    """Return definitions that written start values of eliminated variables depend on, as rows.

    Args:
        system: The equations of the start.
        written: Whose start values count.

    Returns:
        Families of rows ``0 = f - x``, numbered behind those of the system, and the eliminated
        variables ``x``, ascending.
    """
    needed = np.zeros(system.n_ids, np.bool_)
    for family in system.definitions:
        needed[family.rows] = written[family.rows]
    if not needed.any():
        return (), np.zeros(0, np.int64)
    parts: list[EquationFamily] = []
    for family in reversed(system.definitions):
        members = np.flatnonzero(needed[family.rows])
        if members.shape[0]:
            part = take_members(family, members)
            needed[part.operands[variable_slots(part)].ravel()] = True
            parts.append(part)
    defined = np.unique(np.concatenate([part.rows for part in parts]))
    row = np.full(system.n_ids, -1, np.int64)
    row[defined] = system.n_rows + np.arange(defined.shape[0])
    families = [replace(part, rows=row[part.rows]) for part in reversed(parts)]
    own = EquationFamily(neg(slot(0)), (Operand.VARIABLE,), defined[None, :], row[defined])
    return (*families, own), defined
