"""The differentiation index of the equations as they were written.

Elimination may lower the index of what has to be solved: a variable that an equation gives
explicitly is no unknown any more. What a textbook calls the index is that of the whole system.
"""

from __future__ import annotations

from acausal.flattening.flatten import Flattened
from acausal.simulation.system import System
from acausal.structural.incidence import chains_of, incidence_of
from acausal.structural.pantelides import Singularity, differentiation_index, pantelides


def written_index(flattened: Flattened, system: System) -> int:
    """Return the structural differentiation index of the flat model.

    It takes about as long as compiling the model. Where the flat model is structurally singular and
    only elimination shows that it is not (two terms cancel), the index after elimination is
    returned.
    """
    model = flattened.model
    chains = chains_of(model.derivative)
    offsets = pantelides(incidence_of(model.families, model.n_rows, chains).signature())
    return system.index if isinstance(offsets, Singularity) else differentiation_index(offsets)


def index_text(flattened: Flattened, system: System) -> str:
    """Return the index, and what elimination has left of it if that is less."""
    index = written_index(flattened, system)
    after = f" ({system.index} after elimination)" if system.index != index else ""
    return f"differentiation index {index}{after}"
