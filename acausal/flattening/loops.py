"""Rows where a loop of bodies is closed: what is left of a connect equation that was taken out."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from acausal.connections.junctions import Junctions, leaf_ids
from acausal.connections.spanning import SpanningForest
from acausal.flattening.families import FamilyBuilder
from acausal.flattening.model import Ids, Origin, RowKind
from acausal.instantiation.numbering import Numbering
from acausal.instantiation.overdetermined import residues
from acausal.instantiation.template import Template


def loop_rows(
    builder: FamilyBuilder,
    numbering: Numbering,
    junctions: Junctions,
    forest: SpanningForest,
    n_rows: int,
) -> int:
    """Add the rows of ``equalityConstraint``; return the new number of rows."""
    record, cut = np.divmod(forest.broken, junctions.count)
    groups = np.concatenate([record[:, :1], junctions.group[cut]], axis=1)
    for kind in np.unique(groups, axis=0).tolist():
        own = np.flatnonzero((groups == kind).all(axis=1))
        name = forest.records[kind[0]]
        template = numbering.groups[kind[1]].template
        part = template.children[name].template
        sides = [
            record_ids(numbering, numbering.groups[group].template, name)[
                junctions.instance[cut[own, side]]
            ]
            for side, group in enumerate(kind[1:])
        ]
        operands = np.concatenate(sides, axis=1).T
        wanted = residues(part, template.span)
        for k, residue in enumerate(wanted):
            rows = n_rows + np.arange(len(own)) * len(wanted) + k
            builder.add_filled(
                residue, operands, rows,
                cut_origins(junctions, cut[own, 0], RowKind.JUNCTION,
                            f"{name} is the same where the loop is closed"),
            )  # fmt: skip
        n_rows += len(own) * len(wanted)
    return n_rows


def record_ids(numbering: Numbering, template: Template, name: str) -> Ids:
    """Return the variable ids of a record of a cut, shape ``(instances, variables)``."""
    found: list[Ids] = []
    work: list[tuple[Template, tuple[str, ...]]] = [(template.children[name].template, (name,))]
    while work:
        record, path = work.pop(0)
        found += [leaf_ids(numbering, template, (*path, v)) for v in record.variables]
        work = [(c.template, (*path, n)) for n, c in record.children.items()] + work
    return np.concatenate(found, axis=1)


def cut_origins(junctions: Junctions, cuts: Ids, kind: RowKind, text: str) -> tuple[Origin, ...]:
    """Return origins for runs of cuts of one group."""
    groups = junctions.group[cuts]
    change = np.flatnonzero(np.diff(groups)) + 1
    bounds = [0, *change.tolist(), len(cuts)]
    return tuple(
        Origin(a, b - a, kind, None, text, "", int(groups[a]), junctions.instance[cuts[a:b]])
        for a, b in pairwise(bounds)
    )
