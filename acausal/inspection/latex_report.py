r"""The equations of a model as a LaTeX document, family by family with index ranges."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from acausal.elimination.eliminate import Elimination
from acausal.expressions.latex import latex_name
from acausal.flattening.flatten import Flattened
from acausal.flattening.model import Ids
from acausal.inspection.equations import EquationForms
from acausal.inspection.index_names import IndexNames
from acausal.inspection.lists import SHOWN, counted
from acausal.inspection.operands import Names
from acausal.inspection.written_index import index_text
from acausal.instantiation.places import Place, path_text
from acausal.simulation.system import System

_SPECIAL = str.maketrans({c: "\\" + c for c in "#$%&_{}"} | {"\\": r"\textbackslash{}"})


def document(title: str, body: Sequence[str]) -> list[str]:
    """Return a complete document."""
    return [
        r"\documentclass{article}",
        r"\usepackage{amsmath}",
        r"\allowdisplaybreaks",
        r"\begin{document}",
        rf"\title{{{title.translate(_SPECIAL)}}}",
        r"\date{}",
        r"\maketitle",
        *body,
        r"\end{document}",
    ]


def latex_flatten(flattened: Flattened) -> list[str]:
    """Return all equations as they were written and connected."""
    model = flattened.model
    names = Names(flattened.numbering, model)
    lines = [rf"\section*{{Equations ({model.n_rows})}}"]
    lines += _aligned(EquationForms(model.families, names), 4 * SHOWN)
    if model.initial:
        lines += [r"\section*{Initial equations}", *_aligned(EquationForms(model.initial, names))]
    return lines


def latex_eliminate(flattened: Flattened, elimination: Elimination) -> list[str]:
    """Return the definitions of what was taken out, and the equations that remain."""
    names = Names(flattened.numbering, flattened.model)
    lines: list[str] = []
    if elimination.definitions:
        lines += [
            r"\section*{Computed from others}",
            *_aligned(EquationForms(elimination.definitions, names, definitions=True), 4 * SHOWN),
        ]
    remaining = EquationForms(elimination.model.families, names)
    return [
        *lines,
        rf"\section*{{What remains ({elimination.model.n_rows})}}",
        *_aligned(remaining, 4 * SHOWN),
    ]


def latex_structure(
    flattened: Flattened, elimination: Elimination, system: System, states: Ids | None
) -> list[str]:
    """Return index, roles of the variables, and the differentiated equations."""
    differentiated, offsets = system.differentiated, system.offsets
    names = Names(flattened.numbering, flattened.model, differentiated.chains)
    declared = flattened.numbering.n_declared
    derivative = elimination.model.derivative
    differential = np.flatnonzero(elimination.active & (derivative >= 0))
    algebraic = np.flatnonzero(elimination.active[:declared] & (derivative[:declared] < 0))
    lines = [
        r"\section*{Structure}",
        f"{index_text(flattened, system).capitalize()}, "
        f"{counted(offsets.degrees_of_freedom, 'degree')} of freedom.",
        *_symbols("Differential variables", names.variables(differential[differential < declared])),
        *_symbols("Algebraic variables", names.variables(algebraic)),
    ]
    if states is not None:
        lines += _symbols("States", names.variables(states))
    if not offsets.c.any():
        return lines
    rows = np.flatnonzero(offsets.c > 0)
    families = differentiated.families
    for order in range(int(offsets.c.max()) + 1):
        own = [f for f, o in zip(families, differentiated.orders, strict=True) if o == order]
        chosen = rows if not order else np.flatnonzero(differentiated.order == order)
        title = ("Constraints", "First derivatives", "Second derivatives", "Third derivatives")
        head = title[order] if order < len(title) else f"Derivatives of order {order}"
        lines += [rf"\subsection*{{{head}}}", *_aligned(EquationForms(own, names, rows=chosen))]
    return lines


def _symbols(title: str, places: Sequence[Place]) -> list[str]:
    if not places:
        return []
    found = []
    for place in places[:SHOWN]:
        indices = IndexNames(len(place.members))
        path = path_text(place.steps, [indices.text(r) for r in place.subscripts], place.order)
        ranges = indices.latex_of_ranges()
        found.append(latex_name(path) + (rf"\;({ranges})" if ranges else ""))
    if len(places) > SHOWN:
        found.append(r"\dots")
    return [rf"\paragraph{{{title}}} \({', '.join(found)}\)"]


def _aligned(forms: EquationForms, most: int = SHOWN) -> list[str]:
    if not forms.count:
        return []
    shown = [forms.form(number).latex() for number in range(min(forms.count, most))]
    lines = [r"\begin{align*}"]
    lines += [f"  {text} \\\\" for text in shown[:-1]] + [f"  {shown[-1]}"]
    lines.append(r"\end{align*}")
    if forms.count > most:
        lines.append(f"and {forms.count - most} more forms of equations.")
    return lines
