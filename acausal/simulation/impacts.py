"""Impacts: new velocities of bodies that constraints tie to each other.

An impact lasts so short that positions do not move while velocities jump. Integrated over it,
only what becomes infinite counts: accelerations, whose integral is the jump of a velocity, and
forces, whose integral is an impulse. Finite forces drop out. The equations that contain them, each
differentiated as often as index reduction asks for, are linear in them with the Jacobian
``J = dF/dz`` by the highest derivatives ``z``, so that with an impulse ``p`` from outside

    J Z = b p,      Z the jumps of velocities and the impulses in joints.

``reinit(v, value)`` prescribes one jump, ``Z[v'] = value - v``; the impulse ``p`` follows from
it, and with it all other jumps. Every constraint holds afterwards, since its second derivative is
among the rows of ``J``. Several reinits at one instant have an impulse each.

Where does the impulse act?

1. Where the model names the through variable that carries it, ``reinit(v, value, f)``: in the
   equation that says what ``f`` is otherwise.
2. Where one balance of momentum contains ``v'`` (``m*der(v) = ...``): in this balance.
3. Elsewhere ``v`` is a relative coordinate (the angle of a joint), and the impulse is the one
   conjugate to it. Then Gauss's principle of least constraint holds: of all jumps that satisfy
   the constraints, the one with the least kinetic energy ``1/2 sum(m_i Z_i^2)`` is taken
   (Glocker, "Set-Valued Force Laws", Springer 2001, chapter 8). It takes the masses from the
   balances of momentum, which have to be written in units of force.

A variable that no constraint ties to others gets its value, and nothing else changes (Modelica 3.6,
section 8.3.6).
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from acausal.assembly.problem import Y_POSITION
from acausal.diagnostics import fail
from acausal.flattening.model import Ids
from acausal.initialization.linear import dense_matrix, factorise
from acausal.initialization.problem import (
    AlgebraicProblem,
    StartEquations,
    algebraic_problem,
    start_equations,
)
from acausal.simulation.continuous_values import RunValues, reinit_span, set_states
from acausal.simulation.system import System

Array = NDArray[np.float64]

#: A response smaller than this share of the largest one is none.
NOTHING = 1e-11
#: Mechanisms with more unknowns need the impulse to be named: the search is dense.
LARGEST = 3000


class Impacts:
    """Gives variables new values, see the module; called by :class:`RunValues`."""

    def __init__(self, system: System) -> None:
        self._system = system
        chains = system.differentiated.chains
        tied = np.zeros(chains.n_bases + 1, np.bool_)
        tied[system.entries.bases] = True
        self._tied = tied

    @cached_property
    def _problem(self) -> tuple[StartEquations, AlgebraicProblem]:
        """The highest derivatives of all rows and of all variables."""
        system = self._system
        differentiated, offsets = system.differentiated, system.offsets
        chains = differentiated.chains
        rows = differentiated.rows_of(np.arange(len(offsets.c)), offsets.c)
        ids = chains.ids(np.arange(chains.n_bases), offsets.d)
        equations = start_equations(system.start_system(np.zeros(0, np.int64)), with_initial=False)
        return equations, algebraic_problem(equations, rows, ids)

    def __call__(self, run: RunValues, acting: Ids, values: Array, time: float) -> None:
        """Give variables new values.

        Args:
            run: Values right before; right after on return. Algebraic values and derivatives
                are those before the event.
            acting: Numbers of the reinits that act.
            values: New values of all reinits.
            time: Seconds.

        Raises:
            AcausalError: ``E040`` for a variable that is no state, ``E041`` where constraints
                fix a velocity or it is not known which equation takes the impulse.
        """
        system = self._system
        hybrid = system.hybrid
        assert hybrid is not None
        chains, d = system.differentiated.chains, system.offsets.d
        targets = hybrid.reinits.states[acting]
        base = chains.base[targets]
        velocity = self._tied[base] & (base >= 0)
        velocity &= chains.order[targets] == d[base] - 1
        plain = acting[~velocity]
        if len(plain):
            set_states(run, hybrid, plain, values, time)
        if velocity.any():
            self._impact(run, acting[velocity], base[velocity], values, time)

    def _impact(self, run: RunValues, acting: Ids, bases: Ids, values: Array, time: float) -> None:
        system = self._system
        hybrid = system.hybrid
        assert hybrid is not None
        reinits = hybrid.reinits
        chains, d = system.differentiated.chains, system.offsets.d
        equations, problem = self._problem
        parameters = run.w[run.layout.parameters : run.layout.observables]
        equations.w[equations.layout.first_parameter : equations.layout.last] = parameters
        present = run.values()
        equations.set_values(present, time)
        data = problem.jacobian(problem.get())
        factors = factorise(problem.indptr, problem.indices, data, np.ones(problem.n))
        columns: list[Array] = []
        for k, base in zip(acting.tolist(), bases.tolist(), strict=True):
            response = self._response(k, base, problem, data, factors.solve)
            if response is None:
                name = system.names.variable(int(reinits.wanted[k]))
                fail("E041", f"it is not known which impulse makes {name} jump",
                     reinit_span(system, k),
                     notes=[f"t = {time:.9g} s: constraints fix {name}, or no balance of momentum "
                            "contains its derivative"],
                     help="name the through variable that carries the impulse: "
                          "reinit(v, value, f)")  # fmt: skip
            columns.append(response)
        responses = np.stack(columns, axis=1)
        jump = reinits.signs[acting] * values[acting] - present[reinits.states[acting]]
        together = responses[bases]
        impulses = np.linalg.lstsq(together, jump, rcond=None)[0]
        if np.abs(together @ impulses - jump).max() > 1e-8 * max(np.abs(jump).max(), 1e-300):
            last = int(acting[-1])
            name = system.names.variable(int(reinits.wanted[last]))
            wanted = [
                f"{system.names.variable(int(reinits.wanted[k]))} = {values[k]:.6g}"
                for k in acting.tolist()
            ]
            fail("E041", f"reinit of {name} contradicts another reinit of the same instant",
                 reinit_span(system, last),
                 notes=[f"t = {time:.9g} s; wanted: {', '.join(wanted)}"],
                 help="constraints let only one of the velocities be prescribed: "
                      "put both into one when, the second one under elsewhen")  # fmt: skip
        jumps = responses @ impulses
        moving = np.flatnonzero(d > 0)
        present[chains.ids(moving, d[moving] - 1)] += jumps[moving]
        place = run.layout.position[run.states] - Y_POSITION
        run.y[place] = present[run.states]

    def _response(
        self, k: int, base: int, problem: AlgebraicProblem, data: Array, solve: object
    ) -> Array | None:
        """Return the jumps of all highest derivatives for one unit of impulse, or None."""
        assert callable(solve)
        system = self._system
        assert system.hybrid is not None
        impulse = int(system.hybrid.reinits.impulses[k])
        rows = self._balances(problem, data, base)
        if impulse >= 0:
            rows = self._own_row(problem, data, int(system.differentiated.chains.base[impulse]))
        if len(rows) == 1:
            unit = np.zeros(problem.n)
            unit[rows[0]] = 1.0
            response: Array = solve(unit)
            if abs(response[base]) > NOTHING * np.abs(response).max():
                return response
        return self._least_constraint(problem, data, base, solve) if impulse < 0 else None

    def _column(self, problem: AlgebraicProblem, data: Array, base: int) -> Ids:
        part = slice(int(problem.indptr[base]), int(problem.indptr[base + 1]))
        found: Ids = problem.indices[part][data[part] != 0.0].astype(np.int64)
        return found

    def _balances(self, problem: AlgebraicProblem, data: Array, base: int) -> Ids:
        """Return the rows that contain a derivative and are no constraint."""
        rows = self._column(problem, data, base)
        found: Ids = rows[self._system.offsets.c[rows] == 0]
        return found

    def _own_row(self, problem: AlgebraicProblem, data: Array, base: int) -> Ids:
        """Return the rows in which nothing but this variable can become infinite."""
        rows = self._column(problem, data, base)
        entries = np.bincount(problem.indices[data != 0.0], minlength=problem.n_rows)
        found: Ids = rows[entries[rows] == 1]
        return found

    def _least_constraint(
        self, problem: AlgebraicProblem, data: Array, base: int, solve: object
    ) -> Array | None:
        """Return the jumps of least kinetic energy with a unit jump of one velocity."""
        assert callable(solve)
        c, d = self._system.offsets.c, self._system.offsets.d
        n = problem.n
        if n > LARGEST:
            return None
        jacobian = dense_matrix(problem.indptr, problem.indices, data, n)
        moving = np.flatnonzero(d > 0)
        mass = np.zeros(n)
        for row in np.flatnonzero(c == 0).tolist():
            inside = moving[jacobian[row, moving] != 0.0]
            if not len(inside):
                continue
            unit = np.zeros(n)
            unit[row] = 1.0
            response = solve(unit)
            if np.abs(response[moving]).max() <= NOTHING * np.abs(response).max():
                continue  # an equation that only says what an acceleration is
            if len(inside) > 1:
                return None
            mass[inside[0]] += abs(jacobian[row, inside[0]])
        constraints = jacobian[np.ix_(c > 0, moving)]
        wanted = np.zeros((1, len(moving)))
        wanted[0, np.searchsorted(moving, base)] = 1.0
        conditions = np.vstack([constraints, wanted])
        m, r = len(moving), len(conditions)
        matrix = np.zeros((m + r, m + r))
        matrix[np.arange(m), np.arange(m)] = mass[moving]
        matrix[:m, m:] = conditions.T
        matrix[m:, :m] = conditions
        right = np.zeros(m + r)
        right[-1] = 1.0
        solution = np.linalg.lstsq(matrix, right, rcond=1e-12)[0]
        if np.abs(matrix @ solution - right).max() > 1e-8:
            return None
        response = np.zeros(n)
        response[moving] = solution[:m]
        return response
