"""What a report says about a model before it is run: parameters, equations, structure."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

import numpy as np

from acausal.inspection.blocks import show_blocks
from acausal.inspection.equations import EquationForms
from acausal.inspection.flatten import assertion_line, place_text
from acausal.inspection.lists import counted
from acausal.inspection.operands import Names
from acausal.inspection.structure import show_structure
from acausal.reference.entries import class_entry
from acausal.reporting.html import Section, code, details, formula, laws, number, table, unit

if TYPE_CHECKING:
    from acausal.inspection.inspect import Compilation
    from acausal.inspection.summary import Summary
    from acausal.instantiation.template import Template

#: Rows of a table before the rest is counted only.
MOST_ROWS = 250
#: Equations of a model that is shown as a whole, and forms that are shown of a larger one.
MOST_FORMS = 60
#: Elements of an array that are listed one by one.
MOST_ELEMENTS = 6
#: Longest equation in LaTeX that a reader takes in.
LONGEST = 1500


def facts(summary: Summary) -> str:
    """Return the sizes of a model as a row of tiles."""
    tiles = [
        (summary.components, "components"),
        (summary.junctions, "junctions"),
        (summary.equations, "equations"),
        (summary.remaining, "after elimination"),
        (summary.states, "states"),
        (summary.index, "differentiation index"),
    ]
    shown = "".join(
        f"<div><b>{n:,}</b><span>{what}</span></div>".replace(",", "&#8239;") for n, what in tiles
    )
    return f'<div class="facts">{shown}</div>'


def parameters(stages: Compilation) -> Section:
    """Return the table of the parameters, component by component."""
    flattened = stages.flattened
    assert flattened is not None
    model, numbering = flattened.model, flattened.numbering
    places = Names(numbering, model).parameters_of(np.arange(numbering.n_parameters))
    located = []
    for place in places:
        path, ranges = place_text(place)
        owner, _, name = path.rpartition(".")
        located.append((_rank(stages, owner), owner, name, ranges, place))
    located.sort(key=lambda entry: entry[0])
    groups: dict[str, list[tuple[str, ...]]] = {}
    count = min(len(located), MOST_ROWS)
    for _, owner, name, ranges, place in located[:MOST_ROWS]:
        values = model.parameters[place.members]
        first = int(place.members[0])
        if ranges and 1 < len(values) <= MOST_ELEMENTS and not owner.endswith("]"):
            name, ranges = name.partition("[")[0], ""
            value = f"{{{', '.join(number(float(v)) for v in values)}}}"
        else:
            low, high = float(values.min()), float(values.max())
            value = number(low)
            if not (low == high or np.isnan(low)):
                value += f" … {number(high)}"
        about = _parameter_about(stages, owner, name)
        groups.setdefault(owner, []).append(
            (code(name), value, unit(model.names.parameter_unit(first)),
             escape(ranges), about)
        )  # fmt: skip
    rows: list[tuple[str, ...]] = []
    for owner, own in groups.items():
        if owner:
            rows.append((_owner(stages, owner),))
        rows += own
    body = table(("", "value", "unit", "", ""), rows, "tn-t-")
    if len(places) > count:
        body += f'<p class="note">and {counted(len(places) - count, "more parameter")}.</p>'
    return Section("parameters", "Parameters", body)


def _place(stages: Compilation, path: str) -> tuple[Template | None, str]:
    """Return the class of a component and the description of its declaration."""
    flattened = stages.flattened
    assert flattened is not None
    template: Template | None = flattened.numbering.groups[-1].template
    about = ""
    for step in path.split(".") if path else ():
        child = None if template is None else template.children.get(step.partition("[")[0])
        template = None if child is None else child.template
        about = "" if child is None else child.description
    return template, about


def _rank(stages: Compilation, path: str) -> tuple[int, ...]:
    """Return where a component stands in the order of declarations."""
    flattened = stages.flattened
    assert flattened is not None
    template: Template | None = flattened.numbering.groups[-1].template
    rank = []
    for step in path.split(".") if path else ():
        name = step.partition("[")[0]
        order = [] if template is None else list(template.children)
        rank.append(order.index(name) if name in order else len(order))
        template = (
            None if template is None or name not in order else template.children[name].template
        )
    return tuple(rank)


def _parameter_about(stages: Compilation, owner: str, name: str) -> str:
    template, _ = _place(stages, owner)
    declaration = None if template is None else template.parameters.get(name.partition("[")[0])
    return "" if declaration is None else escape(declaration.description)


def _owner(stages: Compilation, path: str) -> str:
    """Return the title of a group: the component, its class."""
    template, about = _place(stages, path)
    shown = code(path)
    if template is not None:
        shown += f"<span>{escape(template.definition.full_name)}</span>"
        shown += f"<span>{escape(about)}</span>" if about else ""
    return shown


def equations(stages: Compilation) -> Section:
    """Return the laws of all classes in use, and what is left to be solved."""
    flattened, elimination = stages.flattened, stages.elimination
    assert flattened is not None
    assert elimination is not None
    groups = flattened.numbering.groups
    used: dict[str, tuple[Template, int]] = {}
    for group in reversed(groups):
        template = group.template
        definition = template.definition
        if not group.count or template.is_connector or definition.kind == "record":
            continue
        name = definition.full_name
        count = used[name][1] if name in used else 0
        used[name] = used[name][0] if name in used else template, count + group.count
    boxes = [_class_laws(template, count) for template, count in used.values()]
    by_class = "".join(b for b in boxes if b)
    names = Names(flattened.numbering, flattened.model)
    remaining = EquationForms(elimination.model.families, names)
    body = f"{by_class}<h3>What remains to be solved <span>{elimination.model.n_rows} equations"
    body += " after elimination</span></h3>" + _forms(remaining)
    if elimination.definitions:
        given = EquationForms(elimination.definitions, names, definitions=True)
        body += details("Computed from others", _forms(given))
    return Section("equations", "Equations", body)


def _class_laws(template: Template, count: int) -> str:
    entry = class_entry(template.definition)
    lines = [line for part in entry.laws for line in part.lines if not line.code]
    initial = [line for part in entry.laws for line in part.initial if not line.code]
    if not lines and not initial:
        return ""
    times = f" · {counted(count, 'instance')}" if count > 1 else ""
    full = template.definition.full_name
    about = escape(template.definition.tree.description)
    title = f"<h3>{escape(full)} <span>{about}{times}</span></h3>"
    start = f'<p class="note">at the start</p>{laws(initial)}' if initial else ""
    shown = laws(lines[:40]) if lines else ""
    if len(lines) > 40:
        shown += f'<p class="note">and {len(lines) - 40} more lines.</p>'
    return f'<div class="class">{title}{shown}{start}</div>'


def _forms(forms: EquationForms) -> str:
    if not forms.count:
        return '<p class="note">Nothing: everything is given explicitly.</p>'
    rows = []
    skipped = max(0, forms.count - MOST_FORMS)
    for k in range(min(forms.count, MOST_FORMS)):
        latex = forms.form(k).latex().replace("&=", "=")
        if len(latex) > LONGEST:
            skipped += 1
            continue
        rows.append(f"<div>{formula(latex)}</div>")
    more = f'<p class="note">and {counted(skipped, "longer or further form")}.</p>' * (skipped > 0)
    return f'<div class="laws">{"".join(rows)}</div>{more}'


def structure(stages: Compilation, summary: Summary) -> Section:
    """Return index, differentiated equations and blocks."""
    flattened, elimination, system = stages.flattened, stages.elimination, stages.system
    assert flattened is not None
    assert elimination is not None
    assert system is not None
    rows = [
        ("Classes in use", str(summary.classes)),
        ("Cuts", str(summary.cuts)),
        ("Variables", str(summary.variables)),
        ("Parameters", str(summary.parameters)),
        ("Equations", f"{summary.equations} in {counted(summary.families, 'family', 'families')}"),
        ("After elimination", str(summary.remaining)),
        ("Differentiated", str(summary.differentiated)),
        ("Degrees of freedom", str(summary.states)),
        ("Differentiation index", str(summary.index)),
        ("Events", escape(summary.events)),
    ]
    body = table(("", ""), [r for r in rows if r[1]], "t-", "short")
    text = "\n".join(show_structure(flattened, elimination, system))
    body += details("Variables, states, differentiated equations", f"<pre>{escape(text)}</pre>")
    text = "\n".join(show_blocks(flattened, elimination, system))
    body += details("Blocks in which the equations are solved", f"<pre>{escape(text)}</pre>")
    return Section("structure", "Structure", body)


def assertions(stages: Compilation) -> Section:
    """Return what the model demands of its variables."""
    flattened = stages.flattened
    assert flattened is not None
    model = flattened.model
    names = Names(flattened.numbering, model)
    lines = [assertion_line(a.family, a.message, names) for a in model.assertions[:MOST_ROWS]]
    body = f"<pre>{escape(chr(10).join(lines))}</pre>" if lines else ""
    if body and len(lines) > 12:
        body = details(counted(len(model.assertions), "assertion"), body)
    return Section("assertions", "Assertions", body)
