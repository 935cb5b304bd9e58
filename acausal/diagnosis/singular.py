"""Structurally singular systems: which equations are too many, which unknowns are left over."""

from __future__ import annotations

import numpy as np

from acausal.diagnostics import AcausalError, Diagnostic, Label
from acausal.elimination.eliminate import Elimination
from acausal.elimination.families import row_counts
from acausal.flattening.flatten import Flattened
from acausal.flattening.model import FlatModel, Ids, Operand, RowKind
from acausal.structural.incidence import Chains
from acausal.structural.pantelides import Singularity
from acausal.structural.singularity import singular_subsets

_MOST = 6


def describe_rows(flattened: Flattened, rows: Ids) -> list[tuple[str, Label | None]]:
    """Return what rows say, with the places to mend: ``a: v = V``.

    Args:
        flattened: The model.
        rows: Row numbers of the flat model.
    """
    model = flattened.model
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
                    result[place] = (text, place_of(flattened, path, label))
    return result


def unbalanced(flattened: Flattened) -> AcausalError | None:
    """Return the error for a model whose equations and unknowns differ in number."""
    model = flattened.model
    unknowns, n_rows = flattened.numbering.n_declared, model.n_rows
    if model.hybrid is not None:
        # Discrete variables have been found to have one equation each.
        unknowns -= int((model.hybrid.place >= 0).sum())
        n_rows = int(np.count_nonzero(row_counts(model.families, n_rows)))
    if n_rows == unknowns:
        return None
    few = n_rows < unknowns
    return AcausalError(
        [
            Diagnostic(
                "B101" if few else "B102",
                f"{model.name} has {n_rows} equations for {unknowns} unknowns",
                flattened.numbering.groups[-1].template.span,
                notes=(f"{abs(n_rows - unknowns)} too {'few' if few else 'many'}, "
                       "junctions counted",),
                help=(
                    "add the missing equations" if few else "remove the equations that are too many"
                ),
            )
        ]
    )  # fmt: skip


def place_of(flattened: Flattened, path: str, label: Label | None) -> Label | None:
    """Return the place to mend: where the user's model declares the component.

    Args:
        flattened: The model.
        path: Path of the instance; empty for the model itself.
        label: The equation's own place.
    """
    first = path.split(".")[0].split("[")[0]
    child = flattened.numbering.groups[-1].template.children.get(first)
    if child is None or label is None:
        return label
    return Label(child.span, label.text)


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
    for subset in singular_subsets(singularity):
        if len(subset.rows) > len(subset.bases) and not over:
            if not len(subset.bases):
                # Everything in it was eliminated: it repeats what a definition says.
                rows, over_ids = _repeating(
                    model, elimination, int(elimination.row_of[subset.rows[0]])
                )
                over = describe_rows(flattened, rows)
                continue
            over = describe_rows(flattened, elimination.row_of[subset.rows[:_MOST]])
            over_ids = [int(chains.heads[b]) for b in subset.bases]
        elif len(subset.bases) > len(subset.rows):
            left += [model.names.variable(int(chains.heads[b])) for b in subset.bases[:_MOST]]
    if len(elimination.redundant_rows) and not over:
        rows, over_ids = _repeating(model, elimination, int(elimination.redundant_rows[0]))
        over = describe_rows(flattened, rows)
    if left:
        notes.append(f"nothing determines {_few(left)}")
    if balance is not None:
        notes.append(
            f"in total {model.n_rows} equations for {flattened.numbering.n_declared} unknowns, "
            "junctions counted"
        )
    labels = [label for _, label in over if label is not None]
    notes += [text for text, label in over if label is None and text]
    if over:
        fixed = _few([model.names.variable(i) for i in over_ids])
        many = balance is not None and model.n_rows > flattened.numbering.n_declared
        return AcausalError(
            [
                Diagnostic(
                    "B102" if many else "S101",
                    f"{len(over)} equations for {fixed}: one is too many" if fixed
                    else "these equations hold without any unknown, or never",
                    labels[0].span if labels else None,
                    labels[0].text if labels else "",
                    tuple(labels[1:]),
                    tuple(notes),
                    _advice(flattened, elimination, over_ids),
                )
            ]
        )  # fmt: skip
    return AcausalError(
        [
            Diagnostic(
                "B101" if balance is not None else "S102",
                f"nothing determines {_few(left)}",
                model.names.declaration(int(chains.heads[singularity_base(singularity)])),
                notes=tuple(notes[1:]),
                help="add an equation for it, or connect the cut it belongs to",
            )
        ]
    )


def _few(paths: list[str]) -> str:
    unique = list(dict.fromkeys(paths))
    more = f" and {len(unique) - _MOST} more" if len(unique) > _MOST else ""
    return ", ".join(unique[:_MOST]) + more


def _repeating(model: FlatModel, elimination: Elimination, row: int) -> tuple[Ids, list[int]]:
    """Return the rows that speak of the same variables as one row, and these variables."""
    of_row: dict[int, set[int]] = {}
    for family in model.families:
        variables = [k for k, kind in enumerate(family.kinds) if kind == Operand.VARIABLE]
        if not variables:
            continue
        for member in np.flatnonzero(family.rows == row).tolist():
            ids = elimination.representative[family.operands[variables, member]]
            of_row.setdefault(row, set()).update(ids.tolist())
    wanted = np.array(sorted(of_row.get(row, set())), np.int64)
    inside = np.ones(model.n_rows, np.bool_)
    met = np.zeros(model.n_rows, np.int64)
    junction = np.zeros(model.n_rows, np.bool_)
    for family in model.families:
        for origin in family.origins:
            if origin.kind != RowKind.DECLARED:
                junction[family.rows[origin.first : origin.first + origin.count]] = True
        for k, kind in enumerate(family.kinds):
            if kind == Operand.VARIABLE:
                known = np.isin(elimination.representative[family.operands[k]], wanted)
                zero = elimination.sign[family.operands[k]] == 0
                np.logical_and.at(inside, family.rows, known | zero)
                np.add.at(met, family.rows, known & ~zero)
    # An alias of a single variable with itself says nothing about its value.
    says = met == 1 if len(wanted) == 1 else met > 0
    same = np.flatnonzero(inside & says & ~junction)
    rows = np.unique(np.append(same[same != row][: _MOST - 1], row))
    return rows, [int(i) for i in wanted]


def singularity_base(singularity: Singularity) -> int:
    """Return the first base that nothing determines."""
    for subset in singular_subsets(singularity):
        if len(subset.bases) > len(subset.rows):
            return int(subset.bases[0])
    return 0


def _advice(flattened: Flattened, elimination: Elimination, ids: list[int]) -> str:
    """Return advice by whether an across or a through variable is fixed twice."""
    junctions = flattened.junctions
    across = through = signal = False
    names = {int(elimination.representative[i]) for i in ids}
    for number, interface in enumerate(junctions.interfaces):
        own = junctions.interface == number
        for (_, _, flow), leaf in zip(interface.leaves, interface.ids, strict=True):
            met = bool(np.isin(elimination.representative[leaf[own]], list(names)).any())
            if not any(f for _, _, f in interface.leaves):
                signal = signal or bool(met)
            else:
                across, through = across or (met and not flow), through or (met and flow)
    if signal and not (across or through):
        return "an input can have one source only: remove a connection, or add the signals"
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
