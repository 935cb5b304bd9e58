"""Consistent values at the start, discrete ones included."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from acausal.assembly.problem import TIME_POSITION
from acausal.diagnostics import AcausalError, Diagnostic, fail
from acausal.flattening.model import Ids
from acausal.initialization.guesses import guided_guesses
from acausal.initialization.start import Start, initialize, prepare_restart
from acausal.initialization.system import StartSystem
from acausal.results.snapshot import Snapshot
from acausal.simulation.accumulation import Accumulation
from acausal.simulation.contacts import Contacts
from acausal.simulation.continuous_values import VALUES, StartValues, start_vector
from acausal.simulation.delays import refuse_zero_delays
from acausal.simulation.event_iteration import EndlessError, EventIteration
from acausal.simulation.event_kernels import EventKernels
from acausal.simulation.event_messages import endless
from acausal.simulation.not_finite import refuse_discrete
from acausal.simulation.relations import Relations, relations_of, room_for
from acausal.simulation.states import StateSelector
from acausal.simulation.system import System

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Begin:
    """Where a run begins.

    Attributes:
        states: Ids of the states.
        values: Values of all ids, shape ``(N,)``.
        parameters: Parameters and held values, shape ``(p,)``.
        relations: The relations, None in a model without events.
        warnings: What the user should look at.
    """

    states: Ids
    values: Array
    parameters: Array
    relations: Relations | None
    warnings: tuple[Diagnostic, ...]


def start_values(system: System, selector: StateSelector, time: float) -> Begin:
    """Find the states and consistent values of everything at the start.

    The states are chosen at the start guesses first, since which start values count depends on
    them, and looked at again at the consistent values.

    Raises:
        AcausalError: ``I0xx`` if there is no consistent start, ``E0xx`` if the discrete
            equations do not settle.
    """
    states = selector.first(system.variables.start, time)
    if system.hybrid is None:
        start = _continuous_start(system.start_system(states), time)
        better = selector.better(start.values, time)
        found = states if better is None else better
        return Begin(found, start.values, system.parameters, None, start.warnings)
    refuse_zero_delays(system.hybrid, system.names)
    relations = relations_of(system.hybrid)
    w = start_vector(system, room_for(relations), time)
    w[TIME_POSITION] = time
    n = len(system.active)
    kernels = EventKernels(system.hybrid, relations, w, VALUES + np.arange(n), VALUES + n)
    iteration = EventIteration(
        kernels, Accumulation(system.hybrid, 1.0), Contacts(system.hybrid, time, 1e-6)
    )
    iteration.as_they_are()
    held = w[VALUES + n : VALUES + n + len(system.parameters)].copy()
    guesses = guided_guesses(replace(system.start_system(states), parameters=held), time)
    w[VALUES : VALUES + n] = guesses
    guided = replace(system, variables=replace(system.variables, start=guesses))
    values = StartValues(guided, states, w)
    try:
        iteration.first(values, time)
    except EndlessError as reason:
        raise endless(system, kernels, reason, values.values, time) from None
    parameters = values.parameters.copy()
    refuse_discrete(system, parameters[system.hybrid.first :], values.values, parameters, time)
    selector.hold(parameters)
    better = selector.better(values.values, time)
    found = states if better is None else better
    return Begin(found, values.values.copy(), parameters, relations, values.warnings)


def resumed_values(system: System, selector: StateSelector, snapshot: Snapshot) -> Begin:
    """Return consistent values where an earlier run stood.

    With other parameters the states stay and everything else is found anew.

    Raises:
        AcausalError: ``R012`` if it was a run of another model, ``I0xx`` if the values of the
            states are impossible with the parameters.
    """
    n, p = len(system.active), len(system.parameters)
    if len(snapshot.values) != n or len(snapshot.parameters) != p:
        fail("R012", f"the snapshot of {snapshot.model_name} does not fit {system.name}",
             help="continue a run of the same model, structural parameters included")  # fmt: skip
    states = selector.first(snapshot.values, snapshot.time)
    first_held = p if system.hybrid is None else system.hybrid.first
    parameters = snapshot.parameters.copy()
    parameters[:first_held] = system.parameters[:first_held]
    selector.hold(parameters)
    values = snapshot.values
    if not np.array_equal(parameters, snapshot.parameters):
        equations = replace(system.start_system(snapshot.states), parameters=parameters)
        values = prepare_restart(equations, snapshot.states).solve(values, snapshot.time)
    relations = None if system.hybrid is None else relations_of(system.hybrid)
    return Begin(states, values.copy(), parameters, relations, ())


def _continuous_start(equations: StartSystem, time: float) -> Start:
    """Initialise from guesses that written starts of eliminated variables lead, or without."""
    guesses = guided_guesses(equations, time, only_eliminated=True)
    if guesses is not equations.variables.start:
        guided = replace(equations, variables=replace(equations.variables, start=guesses))
        with contextlib.suppress(AcausalError):
            return initialize(guided, time)
    return initialize(equations, time)
