"""What changes from round to round of the elimination, and its numbering.

After the first merge of aliases most variables and rows are gone. The rounds that follow work on
those that are left, numbered anew, so that they cost what is left and not what there was.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acausal.elimination.carried import carried
from acausal.elimination.families import row_counts, used_variables, variable_slots
from acausal.elimination.rewriting import split_duplicates
from acausal.elimination.signed_components import Signs
from acausal.flattening.members import merge_families, renumbered
from acausal.flattening.model import EquationFamily, FlatModel, Ids, Variables

Group = tuple[EquationFamily, ...]
Numbers = Ids | NDArray[np.int32]


@dataclass(frozen=True)
class System:
    """A model under elimination.

    Attributes:
        families: Families of the rows.
        others: Families that follow but make no row, see :mod:`acausal.elimination.carried`.
        definitions: Definitions by batch, in order of evaluation; ``rows`` holds variables.
        divisors: What definitions divide by.
        variables: Attributes.
        derivative: Derivative of each representative, or -1.
        representative: Who stands for each variable; itself if None.
        sign: 1, -1, or 0 for a known zero.
        defined: Variables that have a definition.
        removed: Rows that were used up.
        redundant: Rows that say nothing new.
        ids: Number of each variable in the model; its own if None.
        rows: Number of each row in the model; its own if None.
    """

    families: Group
    others: tuple[Group, ...]
    definitions: tuple[Group, ...]
    divisors: Group
    variables: Variables
    derivative: Ids
    representative: Ids | None
    sign: Signs
    defined: NDArray[np.bool_]
    removed: NDArray[np.bool_]
    redundant: tuple[Ids, ...]
    ids: Ids | None
    rows: Ids | None

    @property
    def n_variables(self) -> int:
        """Number of variables."""
        return int(self.sign.shape[0])

    @property
    def n_rows(self) -> int:
        """Number of rows."""
        return int(self.removed.shape[0])


def whole_model(model: FlatModel) -> System:
    """Return a model before anything is eliminated."""
    n = model.variables.count

    def tidy(families: Sequence[EquationFamily]) -> Group:
        parts: list[EquationFamily] = []
        for family in families:
            parts += split_duplicates(renumbered(family, family.template))
        return merge_families(parts)

    families = tidy(model.families)
    removed = np.zeros(model.n_rows, dtype=np.bool_)
    if model.hybrid is not None:
        # Rows between discrete variables became assignments.
        removed = row_counts(families, model.n_rows) == 0
    return System(
        families,
        carried(model),
        (),
        (),
        model.variables,
        model.derivative,
        None,
        np.ones(n, dtype=np.int8),
        np.zeros(n, dtype=np.bool_),
        removed,
        (),
        None,
        None,
    )


def unsupported_derivatives(derivative: Ids, used: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the derivatives that only their own use keeps in the system.

    A derivative of which a higher derivative is in use is there anyway.

    Args:
        derivative: Derivative of each variable, or -1.
        used: Which variables stand in a row.
    """
    mothers = np.flatnonzero(derivative >= 0)
    daughters = derivative[mothers]
    supported = np.zeros(derivative.shape[0], dtype=np.bool_)
    while True:
        new = mothers[(used[daughters] | supported[daughters]) & ~supported[mothers]]
        if new.shape[0] == 0:
            break
        supported[new] = True
    result = np.zeros_like(supported)
    result[daughters] = True
    return result & ~supported


def _mapped(
    families: Group, variable: Numbers, row: Numbers | None, kind: type[np.signedinteger[Any]]
) -> Group:
    """Return families with variables, and rows if they are any, numbered by other numbers."""
    result: list[EquationFamily] = []
    for family in families:
        operands = np.empty(family.operands.shape, dtype=kind)
        variables = set(variable_slots(family))
        for j in range(operands.shape[0]):
            old = family.operands[j]
            operands[j] = variable[old] if j in variables else old
        rows = family.rows if row is None else row[family.rows].astype(kind, copy=False)
        result.append(replace(family, operands=operands, rows=rows))
    return tuple(result)


def compacted(system: System) -> System:
    """Return the system of the variables and rows that are left, numbered anew.

    Variables without any use stay out; what is derived from a variable stays with it. The new
    numbers have 32 bits: the rounds move much memory and compute little.
    """
    standing = (*system.families, *(f for g in system.others for f in g))
    used = used_variables(standing, system.n_variables)
    mothers = np.flatnonzero(system.derivative >= 0)
    while True:
        new = mothers[used[mothers] != used[system.derivative[mothers]]]
        if new.shape[0] == 0:
            break
        used[new] = True
        used[system.derivative[new]] = True
    ids = np.flatnonzero(used)
    number = np.full(system.n_variables, -1, dtype=np.int32)
    number[ids] = np.arange(ids.shape[0], dtype=np.int32)
    present = row_counts(system.families, system.n_rows) > 0
    rows = np.flatnonzero(present)
    row = np.cumsum(present, dtype=np.int32) - np.int32(1)
    derivative = system.derivative[ids]
    derivative[derivative >= 0] = number[derivative[derivative >= 0]]
    v = system.variables
    return System(
        _mapped(system.families, number, row, np.int32),
        tuple(_mapped(group, number, None, np.int32) for group in system.others),
        (),
        (),
        Variables(
            v.start[ids],
            v.start_given[ids],
            v.fixed[ids],
            v.nominal[ids],
            v.minimum[ids],
            v.maximum[ids],
            v.state_select[ids],
        ),
        derivative,
        None,
        np.ones(ids.shape[0], dtype=np.int8),
        np.zeros(ids.shape[0], dtype=np.bool_),
        np.zeros(rows.shape[0], dtype=np.bool_),
        (),
        ids,
        rows,
    )


def expanded(small: System, whole: System, model: FlatModel) -> System:
    """Return a system in the numbers of the model.

    Args:
        small: What became of ``compacted(whole)``.
        whole: The system before it was numbered anew. Its arrays are used up.
        model: The model, whose arrays stay as they are.
    """
    ids, rows = small.ids, small.rows
    assert ids is not None
    assert rows is not None
    removed, defined = whole.removed, whole.defined
    removed[rows] = small.removed
    defined[ids] = small.defined
    derivative = whole.derivative
    if derivative is model.derivative:
        derivative = derivative.copy()
    derivative[ids] = -1
    mothers = np.flatnonzero(small.derivative >= 0)
    derivative[ids[mothers]] = ids[small.derivative[mothers]]
    representative, sign = _composed(small, whole, ids)

    def scattered(name: str) -> NDArray[np.generic]:
        result: NDArray[np.generic] = getattr(whole.variables, name)
        after = getattr(small.variables, name)
        changed = np.flatnonzero(result[ids] != after)
        if changed.shape[0]:
            if result is getattr(model.variables, name):
                result = result.copy()
            result[ids[changed]] = after[changed]
        return result

    names = ("start", "start_given", "fixed", "nominal", "minimum", "maximum", "state_select")
    return System(
        _mapped(small.families, ids, rows, np.int64),
        tuple(_mapped(group, ids, None, np.int64) for group in small.others),
        tuple(_mapped(group, ids, ids, np.int64) for group in small.definitions),
        _mapped(small.divisors, ids, ids, np.int64),
        replace(whole.variables, **{name: scattered(name) for name in names}),  # type: ignore[arg-type]
        derivative,
        representative,
        sign,
        defined,
        removed,
        (*whole.redundant, *(rows[part] for part in small.redundant)),
        whole.ids,
        whole.rows,
    )


def _composed(small: System, whole: System, ids: Ids) -> tuple[Ids, Signs]:
    """Return representatives and signs after both stages."""
    before = whole.representative
    representative = np.arange(whole.n_variables) if before is None else before
    if small.representative is None:
        return representative, whole.sign
    changed = np.flatnonzero((small.representative != np.arange(ids.shape[0])) | (small.sign != 1))
    moved = np.zeros(whole.n_variables, dtype=np.bool_)
    moved[ids[changed]] = True
    members = np.flatnonzero(moved[representative])
    heads = np.searchsorted(ids, representative[members])
    sign = whole.sign
    representative[members] = ids[small.representative[heads]]
    sign[members] *= small.sign[heads]
    return representative, sign
