"""What has to hold at the first instant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.elimination.families import variable_slots
from acausal.flattening.model import EquationFamily, Ids, Names, Variables

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class StartSystem:
    """All equations at one instant, differentiated ones included.

    Every order of derivative of a variable is an unknown of its own, with an id of its own.

    Attributes:
        families: Families of the model's rows and of their derivatives.
        n_rows: Number of these rows.
        initial: Families of the initial equations, with their own row numbers.
        n_initial: Number of initial rows.
        variables: Attributes by id, shape ``(n,)``.
        derivative: Id of the derivative of each id, or -1, shape ``(n,)``.
        states: States by default, in order of preference; as many as there are degrees of
            freedom.
        parameters: Values, shape ``(p,)``.
        names: Paths for messages.
        definitions: Families of eliminated variables, in the order of evaluation; they are
            looked at once the start is found, for values that are not finite.
    """

    families: tuple[EquationFamily, ...]
    n_rows: int
    initial: tuple[EquationFamily, ...]
    n_initial: int
    variables: Variables
    derivative: Ids
    states: Ids
    parameters: NDArray[np.float64]
    names: Names
    definitions: tuple[EquationFamily, ...] = ()

    @property
    def n_ids(self) -> int:
        """Number of ids."""
        return self.variables.count

    def used(self) -> Mask:
        """Return which ids stand in a row, or a derivative of theirs does, shape ``(n,)``."""
        mask = np.zeros(self.n_ids, dtype=np.bool_)
        for family in (*self.families, *self.initial):
            mask[family.operands[variable_slots(family)].ravel()] = True
        mothers = np.flatnonzero(self.derivative >= 0)
        while True:
            new = mothers[mask[self.derivative[mothers]] & ~mask[mothers]]
            if new.shape[0] == 0:
                return mask
            mask[new] = True


def extended(variables: Variables, n: int) -> Variables:
    """Return attributes for ``n`` ids; the new ones start at 0, nominal 1, unbounded."""
    more = n - variables.count
    if more <= 0:
        return variables
    return Variables(
        np.concatenate([variables.start, np.zeros(more)]),
        np.concatenate([variables.start_given, np.zeros(more, dtype=np.bool_)]),
        np.concatenate([variables.fixed, np.zeros(more, dtype=np.bool_)]),
        np.concatenate([variables.nominal, np.ones(more)]),
        np.concatenate([variables.minimum, np.full(more, -np.inf)]),
        np.concatenate([variables.maximum, np.full(more, np.inf)]),
        np.concatenate([variables.state_select, np.full(more, 3, dtype=np.int8)]),
    )
