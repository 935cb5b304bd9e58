"""From the stages of the compiler to the system that the simulation gets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from acausal.elimination.eliminate import Elimination
from acausal.flattening.flatten import Flattened
from acausal.initialization.system import extended
from acausal.simulation.held_names import names_of
from acausal.simulation.system import System
from acausal.structural.differentiate import DifferentiatedSystem
from acausal.structural.highest_jacobian import highest_entries
from acausal.structural.incidence import Chains, Signature
from acausal.structural.pantelides import Offsets, differentiation_index

Array = NDArray[np.float64]

#: Round-off in ``x`` makes noise in its derivative, which is larger by one over the step size.
#: An unknown that is a derivative must not be asked for more digits than it can have.
DERIVATIVE_NOMINAL = 1e3


def _nominal(nominal: Array, chains: Chains) -> Array:
    """Return magnitudes in which derivatives are at least a multiple of what they derive from."""
    result = nominal.copy()
    mothers = np.flatnonzero(chains.derivative >= 0)
    for order in range(int(chains.order.max(initial=0))):
        own = mothers[chains.order[mothers] == order]
        below = nominal[own] if order == 0 else result[own] / DERIVATIVE_NOMINAL
        result[chains.derivative[own]] = np.maximum(
            nominal[chains.derivative[own]], DERIVATIVE_NOMINAL * below
        )
    return result


def build_system(
    flattened: Flattened,
    elimination: Elimination,
    differentiated: DifferentiatedSystem,
    offsets: Offsets,
    signature: Signature,
) -> System:
    """Return the system of a model after index reduction."""
    model = elimination.model
    chains = differentiated.chains
    n = chains.n_variables
    active = np.zeros(n, np.bool_)
    unknown = chains.members[chains.order[chains.members] <= offsets.d[chains.base[chains.members]]]
    active[unknown] = True
    new = np.arange(model.variables.count, n)
    hybrid = model.hybrid
    variables = extended(model.variables, n)
    variables = replace(variables, nominal=_nominal(variables.nominal, chains))
    if hybrid is not None:
        hybrid = replace(hybrid, place=np.concatenate([hybrid.place, np.full(len(new), -1)]))
    return System(
        model.name,
        model.description,
        names_of(flattened.model.names, flattened.numbering, hybrid),
        model.experiment,
        variables,
        differentiated,
        offsets,
        highest_entries(signature, offsets, differentiated),
        active,
        model.initial,
        model.n_initial,
        model.assertions,
        model.parameters,
        np.concatenate([elimination.representative, new]),
        np.concatenate([elimination.sign, np.ones(len(new), np.int8)]),
        elimination.definitions,
        differentiation_index(offsets),
        hybrid,
    )
