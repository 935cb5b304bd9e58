"""Stage flatten: families of variables, parameters and equations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from acausal.expressions.text import to_text
from acausal.flattening.flatten import Flattened
from acausal.flattening.model import EquationFamily, Ids, Operand
from acausal.inspection.equations import EquationForms
from acausal.inspection.hybrid import show_hybrid
from acausal.inspection.index_names import IndexNames
from acausal.inspection.lists import columns, counted, indented, quantity, shortened
from acausal.inspection.operands import Names
from acausal.instantiation.places import Place, path_text

#: Lines of one equation family.
_PER_FAMILY = 6


def show_flatten(flattened: Flattened) -> list[str]:
    """Return the flat model, a line for every family of scalars and every form of equation."""
    model, numbering = flattened.model, flattened.numbering
    names = Names(numbering, model)
    lines = [
        f"{counted(numbering.n_declared, 'variable')} and "
        f"{counted(numbering.n_variables - numbering.n_declared, 'derivative')}, "
        f"{counted(numbering.n_parameters, 'parameter')}, "
        f"{counted(model.n_rows, 'equation')} in "
        f"{counted(len(model.families), 'family', 'families')}",
        "",
        "variables",
    ]
    places = names.variables(np.arange(numbering.n_declared))
    rows = [_variable_row(flattened, p) for p in places[:20]]
    lines += indented([*columns(rows), *_more(places, "variable families")])
    derivatives = names.variables(np.arange(numbering.n_declared, numbering.n_variables))
    if derivatives:
        lines += ["", "derivatives"]
        rows = [_variable_row(flattened, p, numbering.n_declared) for p in derivatives[:20]]
        lines += indented([*columns(rows), *_more(derivatives, "families of derivatives")])
    parameters = names.parameters_of(np.arange(numbering.n_parameters))
    if parameters:
        lines += ["", "parameters"]
        rows = [_parameter_row(flattened, p) for p in parameters[:20]]
        lines += indented([*columns(rows), *_more(parameters, "parameter families")])
    lines += ["", "equations"]
    lines += indented(family_lines(model.families, names))
    if model.initial:
        lines += ["", f"initial equations ({model.n_initial})"]
        lines += indented(family_lines(model.initial, names))
    if model.assertions:
        lines += ["", "assertions"]
        own = [assertion_line(a.family, a.message, names) for a in model.assertions]
        lines += indented(shortened(len(own), own.__getitem__, "assertions"))
    if model.hybrid is not None:
        lines += show_hybrid(model.hybrid, names)
    return lines


def _more(places: Sequence[Place], noun: str) -> list[str]:
    return [f"... {len(places) - 20} more {noun}"] if len(places) > 20 else []


def place_text(place: Place) -> tuple[str, str]:
    """Return the path of a place with index letters, and their ranges."""
    indices = IndexNames(len(place.members))
    path = path_text(place.steps, [indices.text(r) for r in place.subscripts], place.order)
    return path, indices.text_of_ranges()


def _variable_row(flattened: Flattened, place: Place, first: int = 0) -> tuple[str, ...]:
    path, ranges = place_text(place)
    variable = first + int(place.members[0])
    names = flattened.model.names
    unit = names.unit(variable)
    return (path, f"[{unit}]" if unit else "", ranges, names.description(variable))


def _parameter_row(flattened: Flattened, place: Place) -> tuple[str, ...]:
    path, ranges = place_text(place)
    model = flattened.model
    unit = model.names.parameter_unit(int(place.members[0]))
    return (f"{path} = {quantity(model.parameters[place.members], unit)}", ranges)


def family_lines(families: Sequence[EquationFamily], names: Names) -> list[str]:
    """Return every family with its forms; rows that several families make up come last."""
    forms = EquationForms(families, names)
    own: dict[int, list[int]] = {}
    shared: list[int] = []
    for number in range(forms.count):
        of = forms.families_of(number)
        if len(of) == 1 and forms.terms_of(number) == 1:
            own.setdefault(of[0], []).append(number)
        else:
            shared.append(number)
    lines: list[str] = []

    def family(k: int) -> str:
        number = list(own)[k]
        rows = int(sum(forms.sizes[f] for f in own[number]))
        template = to_text(families[number].template, lambda key: f"_{key}", 200)
        head = [f"family {number + 1}: {counted(rows, 'equation')}, {template} = 0"]
        return "\n".join([*head, *indented(form_lines(forms, own[number], _PER_FAMILY))])

    for entry in shortened(len(own), family, "families"):
        lines += entry.split("\n")
    if shared:
        rows = int(sum(forms.sizes[f] for f in shared))
        lines.append(f"sums over several families: {counted(rows, 'equation')}")
        lines += indented(form_lines(forms, shared, 20))
    return lines


def form_lines(forms: EquationForms, numbers: Sequence[int], most: int = 20) -> list[str]:
    """Return forms with where they come from, shortened."""
    rows = []
    for number in numbers[:most]:
        form = forms.form(number)
        rows.append((form.text(), form.source()))
    lines = columns(rows, 76)
    if len(numbers) > most:
        left = int(sum(forms.sizes[n] for n in numbers[most:]))
        lines.append(f"... {counted(left, 'equation')} more in {len(numbers) - most} forms")
    return lines


def assertion_line(family: EquationFamily, message: str, names: Names) -> str:
    """Return the condition of an assertion and its message."""
    members: Ids = np.arange(family.count)
    indices = IndexNames(family.count)
    named = {
        j: names.locate(family.operands[j], Operand(kind)) for j, kind in enumerate(family.kinds)
    }
    text = to_text(
        family.template,
        lambda key: to_text(
            named[int(str(key))].name(members, indices),
            lambda payload: payload.text,  # type: ignore[attr-defined]
        ),
        200,
    )
    ranges = indices.text_of_ranges()
    return f'{text}   "{message}"' + (f"   {ranges}" if ranges else "")
