"""Structurally singular systems: which equations are too many, which unknowns are left over."""

from __future__ import annotations

import numpy as np

from acausal.diagnostics import AcausalError, Diagnostic, Label
from acausal.elimination.eliminate import Elimination
from acausal.flattening.flatten import Flattened
from acausal.flattening.model import FlatModel, Ids, RowKind
from acausal.structural.incidence import Chains
from acausal.structural.pantelides import Singularity
from acausal.structural.singularity import singular_subsets

_MOST = 6


def describe_rows(model: FlatModel, rows: Ids) -> list[tuple[str, Label | None]]:
    """Return what rows say, with their places: ``a: v = V``.

    Args:
        model: The flat model.
        rows: Row numbers of the flat model.
    """
    wanted = {int(r): k for k, r in enumerate(rows)}
    result: list[tuple[str, Label | None]] = [("", None)] * len(wanted)
    for family in model.families:
        for member in np.flatnonzero(np.isin(family.rows, rows)).tolist():
            place = wanted[int(family.rows[member])]
            for origin in family.origins:
                if origin.first <= member < origin.first + origin.count:
                    instance = int(origin.instances[member - origin.first])
                    path = model.names.instance_path(origin.group, instance)
                    if origin.kind in (RowKind.JUNCTION, RowKind.UNCONNECTED):
                        before = result[place][0]
                        text = f"{before}, {path}" if before else f"{origin.text}: {path}"
                    else:
                        text = f"{path}: {origin.text}" if path else origin.text
                    label = Label(origin.span, text) if origin.span is not None else None
                    result[place] = (text, label)
    return result


def unbalanced(flattened: Flattened) -> AcausalError | None:
    """Return the error for a model whose equations and unknowns differ in number."""
    model = flattened.model
    unknowns = flattened.numbering.n_declared
    if model.n_rows == unknowns:
        return None
    few = model.n_rows < unknowns
    return AcausalError(
        [
            Diagnostic(
                "B101" if few else "B102",
                f"{model.name} has {model.n_rows} equations for {unknowns} unknowns",
                flattened.numbering.groups[-1].template.span,
                notes=(f"{abs(model.n_rows - unknowns)} too {'few' if few else 'many'}, "
                       "junctions counted",),
                help="add the missing equations" if few else "remove the equations that are too many",
            )
        ]
    )  # fmt: skip


def explain_singularity(
    flattened: Flattened, elimination: Elimination, chains: Chains, singularity: Singularity
) -> AcausalError:
    """Return the error for a structurally singular system.

    Codes: ``S101`` too many equations for some unknowns, ``S102`` unknowns that nothing
    determines; ``B101`` and ``B102`` if the numbers differ in total.
    """
    model = flattened.model
    notes: list[str] = []
    balance = unbalanced(flattened)
    over: list[tuple[str, Label | None]] = []
    over_ids: list[int] = []
    left: list[str] = []
    rows_total = unknowns_total = 0
    for subset in singular_subsets(singularity):
        if len(subset.rows) > len(subset.bases) and not over:
            over = describe_rows(model, elimination.row_of[subset.rows[:_MOST]])
            over_ids = [int(chains.heads[b]) for b in subset.bases]
            rows_total, unknowns_total = len(subset.rows), len(subset.bases)
        elif len(subset.bases) > len(subset.rows):
            left += [model.names.variable(int(chains.heads[b])) for b in subset.bases[:_MOST]]
    if len(elimination.redundant_rows) and not over:
        over = describe_rows(model, elimination.redundant_rows[:_MOST])
        rows_total = len(elimination.redundant_rows)
    if left:
        notes.append(f"nothing determines {', '.join(dict.fromkeys(left))}")
    if balance is not None:
        notes.append(f"in total {model.n_rows} equations for "
                     f"{flattened.numbering.n_declared} unknowns")  # fmt: skip
    fixed = [model.names.variable(i) for i in over_ids[:_MOST]]
    labels = [label for _, label in over if label is not None]
    junctions = [text for text, label in over if label is None and text]
    notes += junctions
    if over:
        message = (
            f"{rows_total} equations determine "
            + (f"only {unknowns_total} unknown{'s' * (unknowns_total != 1)}: {', '.join(fixed)}"
               if fixed else "nothing new")
        )  # fmt: skip
        return AcausalError(
            [
                Diagnostic(
                    "S101" if balance is None else "B102" if model.n_rows > flattened.numbering.n_declared else "S101",
                    message,
                    labels[0].span if labels else None,
                    labels[0].text if labels else "",
                    tuple(labels[1:]),
                    tuple(notes),
                    _advice(flattened, elimination, over_ids),
                )
            ]
        )  # fmt: skip
    few = balance is not None
    return AcausalError(
        [
            Diagnostic(
                "B101" if few else "S102",
                f"nothing determines {', '.join(dict.fromkeys(left))}",
                model.names.declaration(int(chains.heads[singularity_base(singularity)])),
                notes=tuple(notes[1:]),
                help="add an equation for it, or connect the cut it belongs to",
            )
        ]
    )


def singularity_base(singularity: Singularity) -> int:
    """Return the first base that nothing determines."""
    for subset in singular_subsets(singularity):
        if len(subset.bases) > len(subset.rows):
            return int(subset.bases[0])
    return 0


def _advice(flattened: Flattened, elimination: Elimination, ids: list[int]) -> str:
    """Return advice by whether an across or a through variable is fixed twice."""
    junctions = flattened.junctions
    across = through = False
    names = {int(elimination.representative[i]) for i in ids}
    for number, interface in enumerate(junctions.interfaces):
        own = junctions.interface == number
        for (_, _, flow), leaf in zip(interface.leaves, interface.ids, strict=True):
            met = np.isin(elimination.representative[leaf[own]], list(names)).any()
            across, through = across or (met and not flow), through or (met and flow)
    if across and not through:
        return (
            "two components in parallel fix the same across variable: put a resistance in series "
            "with one of them, or remove one"
        )
    if through and not across:
        return (
            "two components in series fix the same through variable: put a resistance in parallel "
            "to one of them, or remove one"
        )
    return "remove one of these equations, or make one of its parameters an unknown"
