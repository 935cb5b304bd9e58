"""Islands without a reference: potentials of which only differences appear anywhere.

An indicator vector that is 1 on the across variables of an island and 0 elsewhere is a null vector
of the system if every equation sees only differences inside the island. Islands are components of
the graph in which potentials are joined that stand in one equation; the sum of partial
derivatives over the potentials of each row tells whether it fixes a level. O(entries).
"""

from __future__ import annotations

import numpy as np

from acausal.connections.components import connected_components
from acausal.diagnostics import fail
from acausal.expressions.differentiate import partials
from acausal.expressions.evaluate import evaluate
from acausal.expressions.nodes import Expr, slot
from acausal.flattening.flatten import Flattened
from acausal.flattening.model import EquationFamily, Ids, Operand

#: Names for the missing reference, by unit of the across variable.
_REFERENCES = {"V": "a Ground", "m": "a Fixed", "rad": "a Fixed", "K": "a FixedTemperature"}


def refuse_floating(flattened: Flattened) -> None:
    """Refuse a model with an island that has no reference.

    Raises:
        AcausalError: ``S103``.
    """
    model = flattened.model
    potential = _potentials(flattened)
    if not potential.any():
        return
    ids_of = np.flatnonzero(potential)
    n = len(ids_of)
    number = np.full(len(potential), n, np.int32)
    number[ids_of] = np.arange(n)
    tails, heads = [np.zeros(0, np.int32)], [np.zeros(0, np.int32)]
    grounded_rows: list[Ids] = []
    for family in model.families:
        where = [
            k
            for k, kind in enumerate(family.kinds)
            if kind == Operand.VARIABLE and potential[family.operands[k]].any()
        ]
        if not where:
            continue
        # Nodes are numbered among the potentials; whatever else there is has the number n.
        ids = number[family.operands[where]]
        inside = ids < n
        first = ids.min(axis=0)
        for row, member in zip(ids, inside, strict=True):
            tails.append(first[member])
            heads.append(row[member])
        level = np.abs(_levels(family, where, inside)) > 1e-9
        grounded_rows.append(first[level & (first < n)])
    count, label = connected_components(np.concatenate(tails), np.concatenate(heads), n)
    grounded = np.zeros(count, np.bool_)
    for nodes in grounded_rows:
        grounded[label[nodes]] = True
    floating = ~grounded[label]
    if floating.any():
        _explain(flattened, ids_of[floating & (label == label[floating.argmax()])])


def _potentials(flattened: Flattened) -> np.ndarray:
    """Mark across variables of cuts that also have through variables and are not differentiated."""
    model = flattened.model
    result = np.zeros(model.variables.count, np.bool_)
    junctions = flattened.junctions
    for number, interface in enumerate(junctions.interfaces):
        if not any(through for _, _, through in interface.leaves):
            continue
        own = junctions.interface == number
        for (_, _, through), ids in zip(interface.leaves, interface.ids, strict=True):
            if not through:
                result[ids[own].reshape(-1)] = True
    result &= model.derivative < 0
    return result


def _levels(family: EquationFamily, where: list[int], inside: np.ndarray) -> np.ndarray:
    """Return the sum of partial derivatives over the potentials of each member."""
    slots_ = [slot(k) for k in where]
    gradient: dict[Expr, Expr] = partials(family.template, slots_)
    values = 0.7 + 0.6 * np.modf(np.arange(1, len(family.kinds) + 1) * 0.6180339887498949)[0]
    total = np.zeros(family.count)
    for s, member in zip(slots_, inside, strict=True):
        number = evaluate(gradient[s], values.__getitem__, 0.37)
        total += np.where(member, float(number), 0.0)
    return np.where(np.isfinite(total), total, 1.0)


def _explain(flattened: Flattened, ids: Ids) -> None:
    names = flattened.model.names
    paths = [names.variable(int(i)) for i in ids[:4]]
    cuts = [p.rpartition(".")[0] or p for p in paths]
    unit = names.unit(int(ids[0]))
    reference = _REFERENCES.get(unit, "a component that fixes the level")
    fail(
        "S103",
        f"nothing fixes the level of {paths[0].rpartition('.')[2]} at {', '.join(cuts)}"
        + (f" and {len(ids) - 4} more cuts" if len(ids) > 4 else ""),
        names.declaration(int(ids[0])),
        notes=["only differences between these cuts appear in the equations"],
        help=f"connect {reference} to one of them",
    )
