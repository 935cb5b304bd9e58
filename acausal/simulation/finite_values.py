"""Values at an event that are no numbers: found, and said in the words of the model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import AcausalError
from acausal.elimination.recover import family_values
from acausal.flattening.model import EquationFamily, Ids, Operand
from acausal.simulation.continuous_values import RunValues
from acausal.simulation.not_finite import HELP, is_partial, not_finite
from acausal.simulation.system import System

Array = NDArray[np.float64]

#: Combinations of held values for which computed variables are known to be finite.
KNOWN = 1000


class FiniteValues:
    """Looks after an event whether the variables are finite that are computed when asked for."""

    def __init__(self, system: System, shown: Ids) -> None:
        """Prepare.

        Args:
            system: The model.
            shown: Held positions that computed variables read.
        """
        self._system = system
        self._shown = shown
        hybrid = system.hybrid
        assert hybrid is not None
        self._computed = any(
            is_partial(family.template) and _reads(family, hybrid.first)
            for family in system.definitions
        )
        self._known: set[bytes] = set()

    def check(self, held: Array, run: RunValues, time: float) -> None:
        """Check the values after an event.

        Args:
            held: Held values, shape ``(h,)``.
            run: Continuous values.
            time: Seconds.

        Raises:
            AcausalError: ``I030``, naming the operation.
        """
        if self._computed and (now := held[self._shown].tobytes()) not in self._known:
            if len(self._known) < KNOWN:
                self._known.add(now)
            self._check_computed(run.values(), run.parameters, time)

    def _check_computed(self, values: Array, parameters: Array, time: float) -> None:
        result = values.copy()
        for family in self._system.definitions:
            result[family.rows] = 0.0
        for family in self._system.definitions:
            found = family_values(family, result, parameters, time)
            if not np.isfinite(found).all():
                not_finite(self._system, [family], result, parameters, time)
            np.add.at(result, family.rows, found)


def _reads(family: EquationFamily, first: int) -> bool:
    return any(
        kind == Operand.PARAMETER and bool((ids >= first).any())
        for kind, ids in zip(family.kinds, family.operands, strict=True)
    )


def at_event(error: AcausalError) -> AcausalError:
    """Return an error of the continuous equations with advice that fits an event."""
    return AcausalError(
        [replace(d, help=HELP) if d.code == "I030" else d for d in error.diagnostics]
    )
