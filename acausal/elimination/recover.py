"""Values of the eliminated variables from those of the active ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from acausal.elimination.eliminate import Elimination
from acausal.elimination.locals import TINY
from acausal.expressions.evaluate import evaluate
from acausal.flattening.model import EquationFamily, Operand


def family_values(
    family: EquationFamily,
    values: NDArray[np.float64],
    parameters: NDArray[np.float64],
    time: float = 0.0,
) -> NDArray[np.float64]:
    """Return the value of a family's template for every member, shape ``(count,)``.

    Args:
        family: The family.
        values: Values of all variables, shape ``(n,)``.
        parameters: Values of all parameters, shape ``(p,)``.
        time: Time in s.
    """

    def slot_values(key: object) -> NDArray[np.float64]:
        assert isinstance(key, int)
        table = parameters if family.kinds[key] == Operand.PARAMETER else values
        chosen: NDArray[np.float64] = table[family.operands[key]]
        return chosen

    return np.broadcast_to(evaluate(family.template, slot_values, time), (family.count,))


def recovered(
    elimination: Elimination,
    values: NDArray[np.float64],
    time: float = 0.0,
    parameters: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """Return the values of all variables.

    A derivative that nothing uses is unknown and keeps the value it has in ``values``.

    Args:
        elimination: What was eliminated.
        values: Values of the active variables at their ids, shape ``(n,)``.
        time: Time in s.
        parameters: Parameter values, those of the model by default.
    """
    if parameters is None:
        parameters = elimination.model.parameters
    result = values.copy()
    for family in elimination.definitions:
        result[family.rows] = 0.0
    for family in elimination.definitions:
        np.add.at(result, family.rows, family_values(family, result, parameters, time))
    sign = elimination.sign
    return np.where(sign == 0, 0.0, result[elimination.representative] * sign)


def divisors_hold(elimination: Elimination, parameters: NDArray[np.float64]) -> bool:
    """Return whether the elimination is valid for other parameter values.

    False if a definition would divide by zero; the model then has to be eliminated anew.
    """
    nothing = np.zeros(0)
    return all(
        bool((np.abs(family_values(family, nothing, parameters)) > TINY).all())
        for family in elimination.divisors
    )
