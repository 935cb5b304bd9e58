"""Getting on where the equations are singular at one point of the motion.

Across: a linkage that lies flat for an instant has two ways to go on, and no step that ends next to
that position can be solved for. Its motion carries it over: from a point well before, positions and
velocities are extrapolated to as far behind, and corrected to the nearest solution.

Jumps, where a branch of the algebraic equations ends:

The output of an operational amplifier with positive feedback stays where it is until the equations
have no solution near by any more: two solutions meet in a fold and vanish (a singular point of
the algebraic part, Rabier and Rheinboldt 2002, section "impasse points"). The physical system jumps
to another solution, faster than the model resolves, while the states do not move. So the algebraic
part is solved again, a little behind the fold, from wherever a solution can be found; the
integration goes on from there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import AcausalError
from acausal.flattening.model import Ids
from acausal.initialization.start import Restart, prepare_restart
from acausal.results.result import Event
from acausal.simulation.run import Run
from acausal.solvers.failures import IntegrationError, Reason

Array = NDArray[np.float64]

#: How far behind the last good point the states are looked at, as shares of the run.
AHEAD = (1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6)
#: How much of its way the correction of the extrapolated motion may be.
CORRECTION = 0.02
#: An algebraic unknown has jumped if it changes by so many of its magnitude.
JUMP = 1e-3
#: Guesses for the algebraic unknowns, as multiples of what they are.
GUESSES = (1.0, 0.0, -1.0, 0.5, 2.0)
_REASONS = (Reason.CONVERGENCE, Reason.SINGULAR, Reason.ERROR_TEST)


def _extrapolated(values: Array, derivative: Ids, way: float) -> Array:
    """Return the Taylor polynomials of all variables that have derivatives."""
    result = values.copy()
    for variable in np.flatnonzero(derivative >= 0).tolist():
        factor, higher = 1.0, int(derivative[variable])
        for k in range(1, 4):
            factor *= way / k
            result[variable] += factor * values[higher]
            higher = int(derivative[higher])
            if higher < 0:
                break
    return result


def _solution(restart: Restart, values: Array, algebraic: Ids, time: float) -> Array | None:
    """Solve the algebraic equations from several guesses."""
    for factor in GUESSES:
        guess = values.copy()
        guess[algebraic] *= factor
        try:
            return restart.solve(guess, time)
        except AcausalError:
            continue
    return None


class Folds:
    """Gets a run over the ends of branches."""

    def __init__(self, run: Run, start: float) -> None:
        self._run = run
        self._span = run.stop - start
        self._last = self._carried = -np.inf

    def overcome(self) -> bool:
        """Get on where the integration has failed; return whether that was possible."""
        return self._carry_over() or self._leap()

    def _carry_over(self) -> bool:
        """Carry a motion over a singular position."""
        run = self._run
        failure = run.failure
        if not isinstance(failure, IntegrationError) or failure.failure.reason not in _REASONS:
            return False
        if run.integrator is None or run.current is None or not run.selector.has_alternatives:
            return False
        time = run.integrator.t
        before = next((s for s in reversed(run.snapshots) if s[0] < time - run.spacing), None)
        if before is None or before[0] <= self._carried:
            return False
        system, chains = run.system, run.system.differentiated.chains
        begin, values = before
        way = 2.0 * (time - begin)
        moved = _extrapolated(values, chains.derivative, way)
        run.selector.hold(run.current.parameters)
        states = run.selector.better(moved, begin + way, force=True)
        states = run.current.states if states is None else states
        start = replace(system.start_system(states), parameters=run.current.parameters.copy())
        try:
            found = prepare_restart(start, states).solve(moved, begin + way)
        except AcausalError:
            return False
        position = (chains.base >= 0) & (chains.order == 0)
        position[position] &= system.offsets.d[chains.base[position]] > 1
        going = np.abs(moved[position] - values[position])
        off = np.abs(found[position] - moved[position])
        if not len(going) or off.max() > CORRECTION * going.max():
            return False
        self._carried = time
        run.recover()
        run.begin(begin + way, found, states)
        run.record_here()
        run.events.append(Event(time, "carried over a singular position"))
        return True

    def _leap(self) -> bool:
        """Jump to another branch where the integration has failed; return whether it did."""
        run = self._run
        failure = run.failure
        if not isinstance(failure, IntegrationError) or failure.failure.reason not in _REASONS:
            return False
        if run.integrator is None or run.current is None:
            return False
        time = run.integrator.t
        if time - self._last < AHEAD[0] * self._span:
            return False
        layout = run.current.layout
        algebraic = layout.y_ids[~run.current.native.problem.differential]
        if not len(algebraic) or run.selector.has_alternatives:
            return False
        values, states = run.values(), run.current.states
        slopes = values[layout.derivatives]
        parameters = run.current.parameters.copy()
        system = replace(run.system.start_system(states), parameters=parameters)
        restart = prepare_restart(system, states)
        nominal = run.system.variables.nominal[algebraic]
        for share in AHEAD:
            ahead = share * self._span
            moved = values.copy()
            moved[layout.states] += ahead * slopes
            found = _solution(restart, moved, algebraic, time + ahead)
            if found is None:
                continue
            old, new = values[algebraic], found[algebraic]
            change = np.abs(new - old) / np.maximum.reduce([np.abs(old), np.abs(new), nominal])
            if not np.isfinite(found).all() or change.max() < JUMP:
                continue
            self._last = time
            run.record_here()
            run.recover()
            run.begin(time + ahead, found, states)
            run.record_here()
            name = run.system.names.variable(int(algebraic[int(np.argmax(change))]))
            run.events.append(Event(time, f"jump of {name} to another solution"))
            return True
        return False
