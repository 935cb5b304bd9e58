"""From the stages of the compiler to the system that the simulation gets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from acausal.elimination.eliminate import Elimination
from acausal.flattening.flatten import Flattened
from acausal.initialization.system import extended
from acausal.simulation.system import System
from acausal.structural.differentiate import DifferentiatedSystem
from acausal.structural.highest_jacobian import highest_entries
from acausal.structural.incidence import Signature
from acausal.structural.pantelides import Offsets, differentiation_index


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
    if hybrid is not None:
        hybrid = replace(hybrid, place=np.concatenate([hybrid.place, np.full(len(new), -1)]))
    return System(
        model.name,
        model.description,
        flattened.model.names,
        model.experiment,
        extended(model.variables, n),
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
