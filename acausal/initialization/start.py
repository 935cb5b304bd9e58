"""Consistent initial values, and consistent values after an event."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Diagnostic
from acausal.elimination.recover import family_values
from acausal.flattening.model import EquationFamily, Ids, Operand
from acausal.initialization.blocks import solve_blocks
from acausal.initialization.conditions import Conditions, choose_conditions
from acausal.initialization.homotopy import model_homotopy, newton_homotopy
from acausal.initialization.messages import (
    condition_text,
    default_starts,
    fail_block,
    fail_conflict,
    fail_free,
    fail_large,
    fail_not_finite,
)
from acausal.initialization.newton import solve
from acausal.initialization.pivoting import LARGEST, well_conditioned
from acausal.initialization.problem import (
    AlgebraicProblem,
    StartEquations,
    algebraic_problem,
    has_homotopy,
    start_equations,
)
from acausal.initialization.robust import effort
from acausal.initialization.system import StartSystem
from acausal.initialization.texts import LIST, failure_of, member_text, row_text

Array = NDArray[np.float64]

#: Largest number of unknowns that is tried block by block when Newton's method fails.
BLOCKWISE = 20_000
#: How far a condition that is not needed may be from holding, relative to its terms.
REDUNDANT = 1e-6


@dataclass(frozen=True)
class StartStatistics:
    """How a start was found.

    Attributes:
        unknowns: Number of unknowns solved for.
        iterations: Newton steps.
        method: ``Newton``, ``model homotopy``, ``blocks`` or ``Newton homotopy``.
        blocks: Number of blocks, 0 if it was solved as a whole.
    """

    unknowns: int
    iterations: int
    method: str
    blocks: int


@dataclass(frozen=True)
class Start:
    """A consistent start.

    Attributes:
        values: Value of every id, shape ``(n_ids,)``; ids in no row keep their start value.
        pinned: Ids that start at their start value.
        chosen: Those of them that are not ``fixed``, taken to make the start unique.
        notes: What was decided, in sentences.
        warnings: What the user should look at.
        statistics: How it was found.
    """

    values: Array
    pinned: Ids
    chosen: Ids
    notes: tuple[str, ...]
    warnings: tuple[Diagnostic, ...]
    statistics: StartStatistics


def initialize(system: StartSystem, time: float = 0.0) -> Start:
    """Find values of all unknowns that satisfy all equations and initial conditions.

    Args:
        system: The equations, their derivatives, and the initial conditions.
        time: Start time in s.

    Raises:
        AcausalError: I010 contradicting conditions, I011 too few, I020 no solution found, I021
            singular equations, I030 an equation cannot be evaluated.
    """
    equations = start_equations(system)
    conditions = choose_conditions(system)
    if conditions.free.shape[0]:
        fail_free(system, conditions)
    equations.set_values(system.variables.start, time)
    statistics, regular = _solve(equations, conditions, system.variables.start, time, final=False)
    regular = regular and not _hardly_determined(equations, conditions)
    if statistics is None or not regular:
        better = well_conditioned(equations, conditions) if conditions.chosen.size else None
        if better is not None:
            conditions = choose_conditions(system, preferred=better)
            equations.set_values(system.variables.start, time)
            statistics, _ = _solve(equations, conditions, system.variables.start, time)
        elif statistics is None:
            statistics, _ = _solve(equations, conditions, system.variables.start, time)
    assert statistics is not None
    violated = _violated(equations, conditions)
    if violated:
        fail_conflict(equations, conditions, violated)
    values = equations.values()
    _check_definitions(system, values, time)
    notes, warnings = _remarks(system, conditions)
    return Start(values, conditions.pinned, conditions.chosen, notes, warnings, statistics)


def _check_definitions(system: StartSystem, values: Array, time: float) -> None:
    """Report an eliminated variable that has no finite value at the start."""
    if not system.definitions:
        return
    result = values.copy()
    for family in system.definitions:
        result[family.rows] = 0.0
    for family in system.definitions:
        np.add.at(result, family.rows, family_values(family, result, system.parameters, time))
    if all(np.isfinite(result[family.rows]).all() for family in system.definitions):
        return
    for family in system.definitions:

        def slot_values(key: object, family: EquationFamily = family) -> Array:
            assert isinstance(key, int)
            known = family.kinds[key] == Operand.PARAMETER
            table = system.parameters if known else result
            chosen: Array = table[family.operands[key]]
            return chosen

        members = np.arange(family.count)
        failure = failure_of(family, members, members, slot_values, time, system.names)
        if failure is not None:
            text, span = member_text(family, failure.member, system.names)
            fail_not_finite(system, failure, text, span, f"at t = {time:g} s")


def _solve(
    equations: StartEquations,
    conditions: Conditions,
    guess: Array,
    time: float,
    *,
    final: bool = True,
) -> tuple[StartStatistics | None, bool]:
    """Solve by Newton, then by the model's homotopy, then by blocks.

    Returns:
        Statistics, None without success; and whether the solution is regular. The work vector
        holds the solution, or the guess.
    """
    problem = algebraic_problem(equations, conditions.rows, conditions.unknowns)
    result = solve(problem, problem.get())
    if result.converged:
        problem.put(result.x)
        if result.regular:
            return StartStatistics(problem.n, result.iterations, "Newton", 0), True
    if any(has_homotopy(family.template) for family in equations.families):
        found = _by_model_homotopy(equations, conditions, guess, time)
        if found is not None:
            return found, True
    if problem.n > BLOCKWISE:
        if result.converged:
            return StartStatistics(problem.n, result.iterations, "Newton", 0), False
        equations.set_values(guess, time)
        path = newton_homotopy(problem, problem.get(), effort(problem.n))
        problem.put(path.result.x)
        if path.arrived:
            return StartStatistics(problem.n, path.steps, "Newton homotopy", 0), True
        if final:
            worst = problem.rows[np.argsort(-result.error, kind="stable")[:LIST]]
            fail_large(equations, result.outcome, worst, f"at t = {time:g} s")
        equations.set_values(guess, time)
        return None, False
    equations.set_values(guess, time)
    solution = solve_blocks(equations, conditions)
    if solution.failed is None:
        method = ", ".join(["blocks", *solution.methods])
        iterations = solution.iterations
        return StartStatistics(problem.n, iterations, method, solution.count), solution.regular
    if final:
        if conditions.surplus_fixed.size or conditions.surplus_rows.size:
            texts = [condition_text(equations.system, v) for v in conditions.conflict_ids.tolist()]
            fail_conflict(equations, conditions, texts)
        fail_block(equations, solution, f"at t = {time:g} s")
    equations.set_values(guess, time)
    return None, False


def _by_model_homotopy(
    equations: StartEquations, conditions: Conditions, guess: Array, time: float
) -> StartStatistics | None:
    """Solve along the homotopy operators of the model."""
    moving = start_equations(equations.system, with_homotopy=True)
    moving.set_values(guess, time)
    problem = algebraic_problem(moving, conditions.rows, conditions.unknowns)
    path = model_homotopy(problem, problem.get(), moving.set_lambda)
    if not path.arrived:
        return None
    equations.w[problem.positions] = path.result.x
    return StartStatistics(problem.n, path.steps, "model homotopy", 0)


def _violated(equations: StartEquations, conditions: Conditions) -> list[str]:
    """Return the surplus conditions that the solution does not satisfy, in words."""
    system = equations.system
    violated: list[str] = []
    ids = conditions.surplus_fixed
    if ids.shape[0]:
        values, start = equations.values()[ids], system.variables.start[ids]
        size = np.maximum(np.maximum(np.abs(start), np.abs(values)), system.variables.nominal[ids])
        for k in np.flatnonzero(~(np.abs(values - start) <= REDUNDANT * size)).tolist():
            words = condition_text(system, int(ids[k]))
            violated.append(f"{words} but the others give {values[k]:g}")
    if conditions.surplus_rows.shape[0]:
        used = np.flatnonzero(equations.layout.position >= 0)
        problem = algebraic_problem(equations, conditions.surplus_rows, used)
        x = problem.get()
        residual = np.abs(problem.residual(x))
        size = _row_sizes(problem, x)
        for k in np.flatnonzero(~(residual <= REDUNDANT * size)).tolist():
            words, _ = row_text(equations, int(problem.rows[k]))
            violated.append(f"{words} is not satisfied")
    return violated


def _hardly_determined(equations: StartEquations, conditions: Conditions) -> bool:
    """Return whether a row hardly depends on its unknowns, but on what was chosen to be known."""
    if conditions.chosen.shape[0] == 0 or conditions.rows.shape[0] > LARGEST:
        return False
    used = np.flatnonzero(equations.layout.position >= 0)
    everything = algebraic_problem(equations, conditions.rows, used)
    unknown = algebraic_problem(equations, conditions.rows, conditions.unknowns)
    sizes = _row_sizes(everything, everything.get())
    return bool((_row_sizes(unknown, unknown.get()) < REDUNDANT * sizes).any())


def _row_sizes(problem: AlgebraicProblem, x: Array) -> Array:
    """Return the magnitude of the terms of each row."""
    data = np.abs(problem.jacobian(x))
    scale = np.maximum(problem.scale, np.abs(x))
    size = np.zeros(problem.n_rows)
    np.maximum.at(size, problem.indices, data * np.repeat(scale, np.diff(problem.indptr)))
    return size


def _remarks(
    system: StartSystem, conditions: Conditions
) -> tuple[tuple[str, ...], tuple[Diagnostic, ...]]:
    """Return notes and warnings about conditions that were chosen."""
    given = system.variables.start_given[conditions.chosen]
    notes: list[str] = []
    written, silent = conditions.chosen[given], conditions.chosen[~given]
    if written.shape[0]:
        texts = [condition_text(system, v) for v in written[: LIST + 1].tolist()]
        more = f" and {written.shape[0] - LIST} more" if written.shape[0] > LIST else ""
        notes.append(f"start values taken as initial conditions: {', '.join(texts[:LIST])}{more}")
    warnings = (default_starts(system, silent),) if silent.shape[0] else ()
    return tuple(notes), warnings


@dataclass(frozen=True)
class Restart:
    """Equations prepared for consistent restarts with the same states.

    Attributes:
        equations: The model's rows.
        conditions: Which rows are solved for which unknowns.
        problem: The square system.
    """

    equations: StartEquations
    conditions: Conditions
    problem: AlgebraicProblem

    def solve(self, values: Array, time: float) -> Array:
        """Return values of all ids that satisfy all equations, the states unchanged.

        Args:
            values: Present values of all ids, shape ``(n_ids,)``: the states' values, and
                guesses for the rest.
            time: Time in s.

        Raises:
            AcausalError: I020, I021, I030 as in :func:`initialize`.
        """
        self.equations.set_values(values, time)
        result = solve(self.problem, self.problem.get())
        if result.converged:
            self.problem.put(result.x)
        else:
            self.equations.set_values(values, time)
            _solve(self.equations, self.conditions, values, time)
        used = self.equations.layout.position >= 0
        found = values.copy()
        found[used] = self.equations.w[self.equations.layout.position[used]]
        return found


def prepare_restart(system: StartSystem, states: Ids) -> Restart:
    """Return a restart that keeps the values of the given states.

    Raises:
        AcausalError: I011 if the states do not determine the rest.
    """
    equations = start_equations(system, with_initial=False)
    conditions = choose_conditions(system, pins=np.sort(states))
    if conditions.free.shape[0]:
        fail_free(system, conditions)
    problem = algebraic_problem(equations, conditions.rows, conditions.unknowns)
    return Restart(equations, conditions, problem)


def consistent_restart(system: StartSystem, values: Array, time: float, states: Ids) -> Array:
    """Return values of all ids consistent with given states (see :class:`Restart`)."""
    return prepare_restart(system, states).solve(values, time)


__all__ = [
    "Restart",
    "Start",
    "StartStatistics",
    "consistent_restart",
    "initialize",
    "prepare_restart",
]
