"""Consistent values at the start and after an event."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Diagnostic
from acausal.flattening.model import Ids
from acausal.initialization.start import consistent_restart, initialize
from acausal.simulation.states import StateSelector
from acausal.simulation.system import System

Array = NDArray[np.float64]


def start_values(
    system: System, selector: StateSelector, time: float
) -> tuple[Ids, Array, tuple[Diagnostic, ...]]:
    """Find the states and consistent values of all ids at the start.

    The states are chosen at the start guesses first, since which start values count depends on
    them, and looked at again at the consistent values.

    Returns:
        States, values of shape ``(N,)``, and warnings.

    Raises:
        AcausalError: ``I0xx`` if there is no consistent start.
    """
    guess = system.variables.start
    states = selector.first(guess, time)
    start = initialize(system.start_system(states), time)
    better = selector.better(start.values, time)
    return (states if better is None else better), start.values, start.warnings


def restart_values(system: System, states: Ids, values: Array, time: float) -> Array:
    """Return consistent values with the states as they are.

    Raises:
        AcausalError: ``I0xx`` if there are none.
    """
    return consistent_restart(system.start_system(states), values, time, states)
