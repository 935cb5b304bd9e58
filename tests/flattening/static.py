"""A flat model solved at one instant by the plainest means, to see what its equations say.

Nothing of elimination, index reduction or code generation is used: residuals are evaluated family
by family, the Jacobian by differences. States stay at their start values, their derivatives are
unknowns.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from acausal.diagnostics import AcausalError
from acausal.expressions.evaluate import evaluate
from acausal.flattening.flatten import Flattened, flatten
from acausal.flattening.model import EquationFamily, Operand
from acausal.instantiation.instantiate import instantiate
from acausal.modeling.load import choose_model, load_text


def flat(
    text: str, model: str | None = None, given: Mapping[str, float] | None = None
) -> Flattened:
    """Return the flat model of a text."""
    classes, _ = load_text(text)
    definition = choose_model(classes, model, "the text")
    templates, left = instantiate(definition, dict(given or {}))
    return flatten(templates, left)


def parameters(
    text: str, model: str | None = None, given: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Return the values of all parameters by path."""
    flattened = flat(text, model, given)
    names, values = flattened.model.names, flattened.model.parameters
    return {names.parameter(k): float(values[k]) for k in range(flattened.numbering.n_parameters)}


def family_values(family: EquationFamily, values, parameters, time: float = 0.0) -> np.ndarray:
    tables = {Operand.VARIABLE: values, Operand.PARAMETER: parameters}
    found = evaluate(family.template, lambda k: tables[family.kinds[k]][family.operands[k]], time)
    return np.broadcast_to(found, (family.count,))


def residuals(flattened: Flattened, values: np.ndarray, time: float = 0.0) -> np.ndarray:
    """Return all rows for values of all variables."""
    model = flattened.model
    rows = np.zeros(model.n_rows)
    for family in model.families:
        np.add.at(rows, family.rows, family_values(family, values, model.parameters, time))
    return rows


def solve(
    text: str,
    model: str | None = None,
    given: Mapping[str, float] | None = None,
    time: float = 0.0,
    states: Mapping[str, float] | None = None,
) -> dict[str, float]:
    """Return the values of all variables, derivatives included, by path.

    Args:
        text: The model.
        model: Its name.
        given: Parameters by path.
        time: Seconds.
        states: Values of states that do not stand at their start value.
    """
    return solve_flat(flat(text, model, given), time, states)


def solve_flat(
    flattened: Flattened, time: float = 0.0, states: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Return the values of all variables of a flat model, see :func:`solve`."""
    flat_model = flattened.model
    n = flat_model.variables.count
    names = flat_model.names
    values = flat_model.variables.start.copy()
    for path, value in (states or {}).items():
        ((_, variable),) = names.find_variables(path)
        values[variable] = value
    unknown = np.flatnonzero(flat_model.derivative < 0)
    assert len(unknown) == flat_model.n_rows, (len(unknown), flat_model.n_rows)
    for _ in range(50):
        here = residuals(flattened, values, time)
        if np.abs(here).max(initial=0.0) < 1e-10:
            break
        jacobian = np.empty((len(here), len(unknown)))
        for column, variable in enumerate(unknown):
            moved = values.copy()
            step = 1e-6 * max(1.0, abs(values[variable]))
            moved[variable] += step
            jacobian[:, column] = (residuals(flattened, moved, time) - here) / step
        values[unknown] -= np.linalg.solve(jacobian, here)
    else:
        raise AssertionError("Newton's method did not converge")
    return {names.variable(k): float(values[k]) for k in range(n)}


def refused(text: str, model: str | None = None, given: Mapping[str, float] | None = None):
    """Return the message with which a model is refused."""
    with pytest.raises(AcausalError) as caught:
        flat(text, model, given)
    found = caught.value.diagnostics[0]
    assert found.help
    return found
