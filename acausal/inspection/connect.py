"""Stage connect: which cuts meet, and which parts of the model nothing connects."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from acausal.connections.graph import Connections, connections
from acausal.expressions import build
from acausal.expressions.nodes import Expr, slot
from acausal.flattening.flatten import Flattened
from acausal.flattening.model import EquationFamily, Ids, Operand
from acausal.inspection.eliminate import place_names
from acausal.inspection.equations import EquationForms
from acausal.inspection.lists import counted, indented, listed, shortened
from acausal.inspection.operands import Located, Names, codes_of
from acausal.instantiation.places import Place, instance_places


class _CutNames(Names):
    """Names of cuts, by number."""

    def __init__(self, flattened: Flattened) -> None:
        super().__init__(flattened.numbering, flattened.model)
        self._junctions = flattened.junctions

    def locate(self, ids: Ids, kind: Operand) -> Located:
        groups = self._junctions.group[ids]
        places: list[Place | None] = []
        for number in np.unique(groups).tolist():
            own = np.flatnonzero(groups == number)
            instances = self._junctions.instance[ids[own]]
            for p in instance_places(self.numbering, number, instances):
                places.append(Place(p.steps, p.subscripts, own[p.members]))
        return Located(tuple(places), *codes_of(places, len(ids)))


def show_connect(flattened: Flattened) -> list[str]:
    """Return the junctions, the cuts that meet nothing, and the islands."""
    junctions = flattened.junctions
    whole = np.flatnonzero(junctions.interface >= 0)
    faces = np.bincount(junctions.junction, minlength=2 * junctions.count + 1)
    outer, inner = junctions.junction[2 * whole], junctions.junction[2 * whole + 1]
    names = _CutNames(flattened)
    families = [
        _family(slot(0), whole[faces[outer] > 1], outer[faces[outer] > 1]),
        _family(build.neg(slot(0)), whole[faces[inner] > 1], inner[faces[inner] > 1]),
    ]
    forms = EquationForms(families, names, gathered="{} for {}")
    lines = [
        f"{counted(len(whole), 'cut')}, {counted(forms.n_rows, 'junction')}, "
        f"{counted(len(junctions.edges), 'connection')}",
        "",
        "junctions",
    ]

    def junction(number: int) -> str:
        form = forms.form(number)
        said = [_cut_text(text) for text in form.term_texts()]
        ranges = form.indices.text_of_ranges()
        return ", ".join(said) + (f"   {ranges}" if ranges else "")

    lines += indented(shortened(forms.count, junction, "kinds of junctions")) or ["  none"]
    through = np.array([any(t for _, _, t in i.leaves) for i in junctions.interfaces], np.bool_)
    alone = whole[(faces[outer] == 1) & through[junctions.interface[whole]]]
    alone = alone[~_of_model(flattened, alone)] if len(alone) else alone
    if len(alone):
        lines += ["", "connected to nothing (what flows through them is 0)"]
        lonely = EquationForms([_family(slot(0), alone, np.arange(len(alone)))], names)
        lines += indented(shortened(lonely.count, lambda k: _single(lonely, k), "kinds of cuts"))
    return [*lines, "", *_islands(flattened, connections(flattened))]


def _of_model(flattened: Flattened, cuts: Ids) -> NDArray[np.bool_]:
    """Tell which cuts belong to the model itself."""
    root = len(flattened.numbering.groups) - 1
    result = np.zeros(len(cuts), np.bool_)
    groups = flattened.junctions.group[cuts]
    for number in np.unique(groups).tolist():
        for block in flattened.numbering.groups[number].blocks:
            if block.owner == root:
                instance = flattened.junctions.instance[cuts]
                inside = (instance >= block.first) & (instance < block.first + block.size)
                result |= (groups == number) & inside
    return result


def _family(template: Expr, cuts: Ids, rows: Ids) -> EquationFamily:
    return EquationFamily(template, (Operand.VARIABLE,), cuts[None, :], rows)


def _single(forms: EquationForms, number: int) -> str:
    form = forms.form(number)
    ranges = form.indices.text_of_ranges()
    return form.term_texts()[0] + (f"   {ranges}" if ranges else "")


def _cut_text(text: str) -> str:
    return f"{text[1:]} (from inside)" if text.startswith("-") else text


def _islands(flattened: Flattened, edges: Connections) -> list[str]:
    """Return the parts that are connected, signals apart."""
    count, of_component, _ = edges.islands()
    physical = np.zeros(count, np.bool_)
    physical[of_component[edges.component[edges.physical]]] = True
    numbers = np.flatnonzero(physical)
    lines = [counted(len(numbers), "island") + " (parts that no junction connects)"]

    def island(k: int) -> str:
        own = np.flatnonzero(of_component == numbers[k])
        said: list[str] = []
        groups = edges.component_group[own]
        for number in np.unique(groups).tolist():
            instances = edges.component_instance[own[groups == number]]
            places = instance_places(flattened.numbering, number, instances)
            said += [name or "(the model itself)" for name in place_names(places)]
        return f"{counted(len(own), 'component')}: {listed(said)}"

    return lines + indented(shortened(len(numbers), island, "islands"))
