"""What happens at events, as a section of the flat model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from acausal.expressions import build
from acausal.expressions.nodes import ZERO, slot
from acausal.flattening.model import EquationFamily, Hybrid, Ids, Operand, RelationFamily
from acausal.inspection.equations import EquationForms
from acausal.inspection.lists import columns, counted, indented, quantity, shortened
from acausal.inspection.operands import Names

_LINES = 20


def hybrid_counts(hybrid: Hybrid) -> str:
    """Return how much there is of everything that makes events, in words."""
    n_whens = len(hybrid.conditions)
    parts = [
        (counted(hybrid.n_discrete - n_whens, "discrete variable"), hybrid.n_discrete - n_whens),
        (counted(n_relations(hybrid), "relation"), n_relations(hybrid)),
        (counted(n_whens, "when condition"), n_whens),
        (counted(len(hybrid.sample_places), "sample"), len(hybrid.sample_places)),
        (counted(len(hybrid.delay_places), "delay"), len(hybrid.delay_places)),
        (counted(hybrid.reinits.count, "reinit"), hybrid.reinits.count),
    ]
    return ", ".join(text for text, number in parts if number)


def n_relations(hybrid: Hybrid) -> int:
    """Return the number of relations that are watched."""
    return sum(r.family.count for r in hybrid.relations)


def show_hybrid(hybrid: Hybrid, names: Names) -> list[str]:
    """Return relations, discrete equations and reinits, forms with index ranges."""
    sections = [
        ("relations, held between events", [_relation(r, hybrid) for r in hybrid.relations]),
        ("discrete equations, in order of evaluation",
         [_held(f, hybrid.first + f.rows) for f in hybrid.assignments]),
        ("instead, at the start", [] if hybrid.initial is hybrid.assignments
         else [_held(f, hybrid.first + f.rows) for f in hybrid.initial]),
        ("before the start",
         [_held(f, hybrid.first + f.rows) for f in hybrid.initial_pre]),
        ("delayed", [_held(f, hybrid.first + hybrid.delay_places[f.rows])
                     for f in hybrid.delays]),
        ("reinit", [_value(f, hybrid.reinits.states[f.rows], Operand.VARIABLE)
                    for f in hybrid.reinits.values]),
        ("where this is true",
         [_value(f, hybrid.reinits.states[f.rows], Operand.VARIABLE)
          for f in hybrid.reinits.fires]),
    ]  # fmt: skip
    lines = ["", f"events: {hybrid_counts(hybrid)}"]
    for title, families in sections:
        if families:
            lines += ["", title, *indented(_forms(families, names))]
    if len(hybrid.sample_places):
        texts = [
            f"sample[{k + 1}]: from {quantity(hybrid.sample_start[k : k + 1], 's')} "
            f"every {quantity(hybrid.sample_interval[k : k + 1], 's')}"
            for k in range(min(len(hybrid.sample_places), _LINES))
        ]
        lines += ["", "samples", *indented(shortened(len(texts), texts.__getitem__, "samples"))]
    return lines


def _relation(relation: RelationFamily, hybrid: Hybrid) -> EquationFamily:
    g = relation.family.template
    value = build.call("floor", g) if relation.kind == "floor" else None
    if value is None:
        left, right = (g.args[0], g.args[1]) if g.op == "sub" else (g, ZERO)
        value = build.relation(relation.kind, left, right)
    family = relation.family
    shown = EquationFamily(value, family.kinds, family.operands, family.rows, family.origins)
    return _held(shown, hybrid.first + family.rows)


def _held(family: EquationFamily, targets: Ids) -> EquationFamily:
    return _value(family, targets, Operand.PARAMETER)


def _value(family: EquationFamily, targets: Ids, kind: Operand) -> EquationFamily:
    """Return ``target = value`` as a family of equations.

    The body of a when is under ``noEvent`` as a whole, which nobody wrote.
    """
    value = family.template
    if value.op == "noevent":
        value = value.args[0]
    return EquationFamily(
        build.sub(slot(len(family.kinds)), value),
        (*family.kinds, kind),
        np.concatenate([family.operands, targets[None, :]]),
        family.rows,
        family.origins,
    )


def _forms(families: Sequence[EquationFamily], names: Names) -> list[str]:
    numbered: list[EquationFamily] = []
    begin = 0
    for f in families:
        rows = begin + np.arange(f.count)
        numbered.append(EquationFamily(f.template, f.kinds, f.operands, rows, f.origins))
        begin += f.count
    forms = EquationForms(numbered, names)
    rows_ = [
        (form.text(), form.source())
        for form in (forms.form(k) for k in range(min(forms.count, _LINES)))
    ]
    lines = columns(rows_, 76)
    if forms.count > _LINES:
        lines.append(f"... {forms.count - _LINES} more forms")
    return lines
