"""Roles as positions: where each variable stands in the work vector.

Let ``x, x', x'', ...`` be the members of a chain of derivatives. A member is a *state* if its
derivative is not dummy. States and algebraic unknowns (dummy derivatives among them) stand in
``y``; the derivative of a state is an entry of ``y'`` and needs no place of its own, unless it is a
state itself: then it stands in ``y``, too, and a row ``y'[x] - y[x'] = 0`` couples the two.

Counting: with ``N`` ids, ``R`` rows, ``S = N - R`` states and ``C`` couplings, ``y`` has
``N - (S - C) = R + C`` entries, as many as there are rows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.assembly.problem import Y_POSITION, ZERO_POSITION
from acausal.flattening.model import Ids


@dataclass(frozen=True)
class Layout:
    """Positions of variables and parameters in ``w = [0, t, y, y', parameters, observables]``.

    Attributes:
        n: Number of unknowns ``y``.
        position: Position of each variable, -1 for one that has none, shape ``(N,)``.
        y_ids: Variable of each entry of ``y``, shape ``(n,)``.
        states: Ids of the states, ascending.
        derivatives: Ids of their derivatives, shape of ``states``.
        couplings: Indices into ``states`` of those whose derivative is a state, too.
        n_parameters: Number of parameters.
    """

    n: int
    position: Ids
    y_ids: Ids
    states: Ids
    derivatives: Ids
    couplings: Ids
    n_parameters: int

    @property
    def parameters(self) -> int:
        """Position of the first parameter."""
        return Y_POSITION + 2 * self.n

    @property
    def observables(self) -> int:
        """Position behind the last parameter."""
        return self.parameters + self.n_parameters


def lay_out(
    active: NDArray[np.bool_], derivative: Ids, is_state: NDArray[np.bool_], n_parameters: int
) -> Layout:
    """Give every unknown its position.

    Args:
        active: Unknowns of the reduced system, derivatives included, shape ``(N,)``.
        derivative: Id of each variable's derivative or -1, shape ``(N,)``.
        is_state: Which of them are states, shape ``(N,)``.
        n_parameters: Number of parameters.
    """
    states = np.flatnonzero(is_state)
    derivatives = derivative[states]
    in_y = active.copy()
    in_y[derivatives] = is_state[derivatives]
    y_ids = np.flatnonzero(in_y)
    n = len(y_ids)
    position = np.full(len(active), -1, np.int64)
    position[y_ids] = Y_POSITION + np.arange(n)
    only_prime = ~is_state[derivatives]
    position[derivatives[only_prime]] = position[states[only_prime]] + n
    assert ZERO_POSITION == 0
    return Layout(
        n,
        position,
        y_ids,
        states,
        derivatives,
        np.flatnonzero(is_state[derivatives]),
        n_parameters,
    )


def values_of(
    layout: Layout, y: NDArray[np.float64], yp: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the values of all ids, shape ``(N,)``; zero for those that are no unknowns."""
    values = np.zeros(len(layout.position))
    values[layout.derivatives] = yp[layout.position[layout.states] - Y_POSITION]
    values[layout.y_ids] = y
    return values


def unknowns_of(
    layout: Layout, values: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return ``y`` and ``y'``, each of shape ``(n,)``, for values of all ids."""
    yp = np.zeros(layout.n)
    yp[layout.position[layout.states] - Y_POSITION] = values[layout.derivatives]
    return np.ascontiguousarray(values[layout.y_ids]), yp
