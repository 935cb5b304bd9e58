"""The Jacobian of the differentiated rows with respect to their highest derivatives.

Statement (Griewank's lemma, see Pryce 2001, doi 10.1023/A:1021998624799): the partial derivative
of ``d^k f / dt^k`` with respect to ``x^(sigma + k)`` is that of ``f`` with respect to
``x^(sigma)``. So one set of numbers, taken from the original rows, serves every level of
differentiation. State selection needs it for rows with ``c > 0``, at the entries with
``sigma + c = d``.

Complexity: ``O(operands)``, symbolic work once per template.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.expressions.differentiate import partials
from acausal.expressions.evaluate import evaluate
from acausal.expressions.nodes import TIME, ZERO, slot
from acausal.expressions.traverse import depends_on, slots
from acausal.flattening.model import EquationFamily, Ids, Operand
from acausal.structural.differentiate import DifferentiatedSystem
from acausal.structural.graphs import Mask
from acausal.structural.incidence import Chains, Signature
from acausal.structural.pantelides import Offsets

Values = NDArray[np.float64]


@dataclass(frozen=True)
class HighestEntries:
    """Positions in the Jacobian, ascending by row and base.

    Attributes:
        rows: Original row, with ``c > 0``, shape ``(entries,)``.
        bases: Base whose highest derivative it is.
        system_rows: The same row, differentiated ``c`` times, in the differentiated system.
        variables: Id of that highest derivative. The entry is the derivative of ``system_rows``
            with respect to ``variables``.
    """

    rows: Ids
    bases: Ids
    system_rows: Ids
    variables: Ids


def highest_entries(
    signature: Signature, offsets: Offsets, system: DifferentiatedSystem
) -> HighestEntries:
    """Return where the Jacobian of the differentiated rows may be non-zero."""
    c, d = offsets.c, offsets.d
    rows, bases = signature.rows, signature.bases
    wanted = (c[rows] > 0) & (signature.orders + c[rows] == d[bases])
    rows, bases = rows[wanted], bases[wanted]
    return HighestEntries(
        rows, bases, system.rows_of(rows, c[rows]), system.chains.ids(bases, d[bases])
    )


def highest_jacobian(
    families: Sequence[EquationFamily],
    chains: Chains,
    offsets: Offsets,
    entries: HighestEntries,
    values: Values,
    parameters: Values,
    time: float = 0.0,
    first_held: int | None = None,
) -> tuple[Values, Mask]:
    """Evaluate the entries with NumPy.

    Args:
        families: The original families.
        chains: The original variables.
        offsets: The offsets.
        entries: Where to evaluate.
        values: Values of the original variables, shape ``(n,)``.
        parameters: Values of the parameters, shape ``(p,)``.
        time: Time, s.
        first_held: Parameters from here on change at events; None if none do.

    Returns:
        The entries' values (NaN where undefined), and which of them never change.
    """
    result = np.zeros(entries.rows.shape[0])
    constant = np.ones(entries.rows.shape[0], np.bool_)
    if not result.shape[0]:
        return result, constant
    n_bases = chains.n_bases
    keys = entries.rows * n_bases + entries.bases
    for family in families:
        differentiated = np.flatnonzero(offsets.c[family.rows] > 0)
        if not differentiated.shape[0]:
            continue
        rows = family.rows[differentiated]
        wanted = {}
        for place, kind in enumerate(family.kinds):
            if kind != Operand.VARIABLE:
                continue
            ids = family.operands[place, differentiated]
            bases = chains.base[ids]
            highest = (bases >= 0) & (chains.order[ids] + offsets.c[rows] == offsets.d[bases])
            if highest.any():
                wanted[slot(place)] = np.flatnonzero(highest), bases[highest]
        by_slot = partials(family.template, wanted)
        for node, (members, bases) in wanted.items():
            partial = by_slot[node]
            if partial is ZERO:
                continue
            columns = family.operands[:, differentiated[members]]

            def operand(
                place: object, columns: Ids = columns, family: EquationFamily = family
            ) -> Values:
                assert isinstance(place, int)
                if family.kinds[place] == Operand.VARIABLE:
                    return np.asarray(values[columns[place]])
                return np.asarray(parameters[columns[place]])

            at = np.searchsorted(keys, rows[members] * n_bases + bases)
            np.add.at(result, at, evaluate(partial, operand, time))
            varies = depends_on(partial, TIME) or any(
                isinstance(key, int)
                and (
                    family.kinds[key] == Operand.VARIABLE
                    or (first_held is not None and bool((columns[key] >= first_held).any()))
                )
                for key in slots(partial)
            )
            if varies:
                constant[at] = False
    return result, constant
