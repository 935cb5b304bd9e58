"""The continuous equations at one instant: at the start, and at events of a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from acausal.assembly.layout import Layout, unknowns_of, values_of
from acausal.assembly.problem import TIME_POSITION, Y_POSITION
from acausal.diagnostics import Diagnostic, Span, fail
from acausal.flattening.model import Hybrid, Ids
from acausal.initialization.start import Restart, Start, initialize, prepare_restart
from acausal.initialization.texts import member_text
from acausal.simulation.not_finite import not_finite
from acausal.simulation.system import System
from acausal.solvers.protocol import Integrator

Array = NDArray[np.float64]

#: The first position of the values of ids in the work vector of the first instant.
VALUES = 2
#: Least distance of a difference in time, as a share of the time.
LEAST_INSTANT = 1e-11


def start_vector(system: System, more: int, time: float) -> Array:
    """Return the work vector ``[0, t, values of all ids, parameters, ...]`` of the first instant.

    Args:
        system: The model.
        more: So many zeros follow.
        time: Seconds.
    """
    w: Array = np.concatenate([
        [0.0, time], system.variables.start, system.parameters, np.zeros(more),
    ])  # fmt: skip
    return w


class StartValues:
    """The first instant: all unknowns are sought, from the start values.

    Attributes:
        start: The last solution.
        parameters: Parameters and held values, a view of the work vector.
    """

    def __init__(self, system: System, states: Ids, w: Array) -> None:
        self._system = system
        self._start_system = system.start_system(states)
        self._w = w
        self._n = len(system.active)
        first = VALUES + self._n
        self.parameters: Array = w[first : first + len(system.parameters)]
        self._solved_for: Array | None = None
        self.start: Start | None = None

    @property
    def values(self) -> Array:
        """Values of all ids, a view, shape ``(N,)``."""
        return self._w[VALUES : VALUES + self._n]

    def solve(self, time: float) -> None:
        """Initialise, for what is held now."""
        parameters = self.parameters
        if self._solved_for is not None and np.array_equal(parameters, self._solved_for):
            return
        held = parameters.copy()
        self._solved_for = None
        self.start = initialize(replace(self._start_system, parameters=held), time)
        self._solved_for = held
        self._w[TIME_POSITION] = time
        self.values[:] = self.start.values

    def reinit(self, acting: Ids, values: Array, time: float) -> None:
        """Give states their new values; everything else follows from the states."""
        hybrid = self._system.hybrid
        assert hybrid is not None and self.start is not None
        found = self.values.copy()
        for k in acting.tolist():
            found[hybrid.reinits.states[k]] = hybrid.reinits.signs[k] * values[k]
        states = np.sort(self._start_system.states)
        restart = prepare_restart(
            replace(self._start_system, parameters=self.parameters.copy()), states
        )
        self.values[:] = restart.solve(found, time)
        self._solved_for = self.parameters.copy()

    def glances(self, time: float, step: float, look: Callable[[], Array]) -> list[Array] | None:
        """Nothing moves yet."""
        return None

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """What the user should look at."""
        return () if self.start is None else self.start.warnings


class RunValues:
    """An event of a run: the states stay, everything else is sought again.

    Attributes:
        y, yp: Values right after the event, each of shape ``(n,)``.
    """

    def __init__(
        self,
        system: System,
        layout: Layout,
        states: Ids,
        w: Array,
        integrator: Callable[[], Integrator],
        impact: Callable[[RunValues, Ids, Array, float], None],
    ) -> None:
        """Prepare.

        Args:
            system: The model.
            layout: Positions.
            states: Ids of the states.
            w: Work vector of the problem.
            integrator: Returns the integrator of the problem.
            impact: Gives variables new values that constraints tie to others.
        """
        self.system = system
        self.layout = layout
        self.states = states
        self.w = w
        self.y: Array = np.zeros(layout.n)
        self.yp: Array = np.zeros(layout.n)
        self._in_w_y = w[Y_POSITION : Y_POSITION + layout.n]
        self._in_w_yp = w[Y_POSITION + layout.n : Y_POSITION + 2 * layout.n]
        self._integrator = integrator
        self._impact = impact
        self._restart: Restart | None = None

    def take(self, time: float, y: Array, yp: Array) -> None:
        """Begin with the values at the end of the integration."""
        self.y[:] = y
        self.yp[:] = yp
        self.w[TIME_POSITION] = time
        self.show()

    @property
    def shown(self) -> tuple[Array, Array]:
        """Where the kernels see the values."""
        return self._in_w_y, self._in_w_yp

    def show(self) -> None:
        """Let the kernels see the values."""
        self._in_w_y[:] = self.y
        self._in_w_yp[:] = self.yp

    def solve(self, time: float) -> None:
        """Find algebraic values and derivatives for what is held now, the states unchanged."""
        if self._integrator().consistent(time, self.y, self.yp) < 0:
            self.solve_robustly(time)
        self.show()

    def find_slopes(self, time: float, instant: float) -> None:
        """Find the derivatives of the unknowns of a model without states.

        They predict the first step. A current that commutates between two diodes rises by all it
        has within nanoseconds; without its slope no first step is short enough. Where there are
        states, they alone control the step.

        Args:
            time: Seconds.
            instant: Distance over which a difference is taken, seconds.
        """
        if len(self.layout.states):
            return
        step = max(instant, LEAST_INSTANT * abs(time))
        ahead = self.y.copy()
        if self._integrator().consistent(time + step, ahead, np.zeros_like(ahead)) >= 0:
            self.yp[:] = (ahead - self.y) / step
        self.w[TIME_POSITION] = time
        self.show()

    def glances(self, time: float, step: float, look: Callable[[], Array]) -> list[Array] | None:
        """Return what a function of the work vector is now and after one and two steps.

        The states go on with their derivatives, everything else is solved for.

        Args:
            time: Seconds.
            step: Seconds.
            look: The function.
        """
        y, yp = self.y.copy(), self.yp.copy()
        rates = np.isin(self.layout.y_ids, self.layout.states)
        found = [look()]
        for k in (1, 2):
            y += np.where(rates, step * yp, 0.0)
            if self._integrator().consistent(time + k * step, y, yp) < 0:
                found.clear()
                break
            self.w[TIME_POSITION] = time + k * step
            self._in_w_y[:], self._in_w_yp[:] = y, yp
            found.append(look())
        self.w[TIME_POSITION] = time
        self.show()
        look()
        return found or None

    def solve_robustly(self, time: float) -> None:
        """The same with damping, homotopy and block by block."""
        if self._restart is None:
            self._restart = prepare_restart(self.system.start_system(self.states), self.states)
        equations = self._restart.equations
        first, last = equations.layout.first_parameter, equations.layout.last
        equations.w[first:last] = self.parameters
        self.set_values(self._restart.solve(self.values(), time))

    @property
    def parameters(self) -> Array:
        """Parameters and held values, a view of the work vector."""
        parameters: Array = self.w[self.layout.parameters : self.layout.observables]
        return parameters

    def values(self) -> Array:
        """Return the values of all ids, shape ``(N,)``."""
        return values_of(self.layout, self.y, self.yp)

    def set_values(self, values: Array) -> None:
        """Set the values of all ids."""
        self.y[:], self.yp[:] = unknowns_of(self.layout, values)

    def reinit(self, acting: Ids, values: Array, time: float) -> None:
        """Give variables their new values.

        Raises:
            AcausalError: ``I030`` if one of them is not finite, see also :mod:`.impacts`.
        """
        if not np.isfinite(values[acting]).all():
            assert self.system.hybrid is not None
            families = self.system.hybrid.reinits.values
            mine = [f for f in families if np.isin(f.rows, acting).all()]
            not_finite(self.system, mine, self.values(), self.parameters, time)
        self._impact(self, acting, values, time)
        self.show()


def set_states(run: RunValues, hybrid: Hybrid, acting: Ids, values: Array, time: float) -> None:
    """Give states new values and leave all other states as they are.

    Raises:
        AcausalError: ``E040`` for a variable that is no state, ``E041`` for two values at once.
    """
    reinits, names = hybrid.reinits, run.system.names
    new: dict[int, float] = {}
    for k in acting.tolist():
        variable, wanted = int(reinits.states[k]), int(reinits.wanted[k])
        place = int(run.layout.position[variable]) - Y_POSITION
        value = reinits.signs[k] * values[k]
        if not 0 <= place < run.layout.n or variable not in run.states:
            name = names.variable(wanted)
            present = "" if place < 0 else f", {name} = {run.w[Y_POSITION + place]:.6g}"
            fail("E040", f"reinit of {name}, which is no state", reinit_span(run.system, k),
                 label="its value follows from other variables",
                 notes=[f"t = {time:.9g} s{present}; wanted: {name} = {values[k]:.6g}"],
                 help="reinit a variable whose derivative stands in an equation")  # fmt: skip
        if new.setdefault(variable, value) != value:
            name = names.variable(wanted)
            fail("E041", f"{name} gets two values by reinits at once", reinit_span(run.system, k),
                 notes=[f"t = {time:.9g} s: {new[variable]:.6g} and {value:.6g}"],
                 help="put both into one when, the second one under elsewhen")  # fmt: skip
        run.y[place] = value


def reinit_span(system: System, number: int) -> Span | None:
    """Return where a reinit is written."""
    assert system.hybrid is not None
    for family in system.hybrid.reinits.values:
        members = np.flatnonzero(family.rows == number)
        if len(members):
            return member_text(family, int(members[0]), system.names)[1]
    return None
