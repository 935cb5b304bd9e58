"""Inputs that nobody gives a value, as the reason why equations are missing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import fail
from acausal.flattening.flatten import Flattened
from acausal.flattening.model import EquationFamily, FlatModel, Ids, Operand, RowKind
from acausal.instantiation.numbering import Numbering
from acausal.instantiation.places import variable_places


def refuse_open_inputs(flattened: Flattened) -> None:
    """Refuse a model that has too few equations because inputs are left open.

    An input is open if its cut is connected to nothing and no equation outside of the class that
    declares it refers to it.

    Raises:
        AcausalError: ``B101``, at the component the input belongs to.
    """
    numbering, model = flattened.numbering, flattened.model
    n_equations = model.n_rows + _discrete_equations(model)
    if n_equations >= numbering.n_declared:
        return
    junctions = flattened.junctions
    owner = _owners(numbering)
    faces = np.bincount(junctions.junction, minlength=1)
    for interface in junctions.interfaces:
        for ids in interface.ids:
            cuts = np.flatnonzero(ids[:, 0] >= 0) if ids.size else np.zeros(0, np.int64)
            owner[ids[cuts[faces[junctions.junction[2 * cuts]] > 1]].reshape(-1)] = -1
    families = model.families
    if model.discrete is not None:
        families = (*families, *model.discrete.assignments, *model.discrete.equalities)
        _drop_assigned(model.discrete.assignments, owner)
    owner[_used_outside(families, owner)] = -1
    found = np.flatnonzero(owner >= 0)
    if not len(found):
        return
    place = variable_places(numbering, found[:1])[0]
    path, name = place.paths()[0], place.steps[0][0]
    root = numbering.groups[-1].template
    declared = root.children[name] if name in root.children else root.variables[name]
    others = f", {len(found)} open inputs" if len(found) > 1 else ""
    fail(
        "B101",
        f"nothing gives the input {path} a value",
        declared.span,
        label="an input of this component is open" if "." in path else "this input is open",
        notes=[f"{n_equations} equations for {numbering.n_declared} unknowns{others}"],
        help="connect a source to it, or give it a value where the component is declared",
    )


def _discrete_equations(model: FlatModel) -> int:
    """Return the number of equations of variables that only change at events."""
    if model.discrete is None:
        return 0
    targets = [f.rows for f in model.discrete.assignments]
    equal = sum(f.count for f in model.discrete.equalities)
    return equal + (len(np.unique(np.concatenate(targets))) if targets else 0)


def _drop_assigned(assignments: Sequence[EquationFamily], owner: Ids) -> None:
    """Forget the inputs that another class than the declaring one assigns."""
    for family in assignments:
        for origin in family.origins:
            ids = family.rows[origin.first : origin.first + origin.count]
            owner[ids[(owner[ids] >= 0) & (owner[ids] != origin.group)]] = -1


def _owners(numbering: Numbering) -> Ids:
    """Return the group of the class that declares each input, -1 for other variables."""
    owner = np.full(numbering.n_variables, -1, np.int64)
    for variable in numbering.variables:
        if variable.order or variable.declaration.causality != "input":
            continue
        group = numbering.groups[variable.group]
        if not group.template.primitive_connector:
            owner[variable.first : variable.first + variable.count] = variable.group
            continue
        for block in group.blocks:
            first = variable.first + block.first
            count = numbering.groups[block.owner].count * block.size
            owner[first : first + count] = block.owner
    return owner


def _used_outside(families: Sequence[EquationFamily], owner: Ids) -> NDArray[np.bool_]:
    """Tell which inputs stand in equations of other classes than the one that declares them."""
    used = np.zeros(len(owner), np.bool_)
    for family in families:
        for origin in family.origins:
            if origin.kind != RowKind.DECLARED:
                continue
            members = slice(origin.first, origin.first + origin.count)
            for kind, row in zip(family.kinds, family.operands, strict=True):
                if kind == Operand.VARIABLE:
                    ids = row[members]
                    used[ids[(owner[ids] >= 0) & (owner[ids] != origin.group)]] = True
    return used
