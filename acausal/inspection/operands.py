"""Names of the operands of equation families: ids to places and index letters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acausal.expressions import build
from acausal.expressions.latex import latex_name
from acausal.expressions.nodes import Expr, const, slot
from acausal.expressions.text import number_text
from acausal.flattening.model import FlatModel, Hybrid, Ids, Operand
from acausal.inspection.index_names import IndexNames
from acausal.instantiation.numbering import Numbering
from acausal.instantiation.places import Place, parameter_places, path_text, variable_places
from acausal.structural.incidence import Chains

#: Lists of held values that are no variables; those that are alone have no number.
_LISTS = ("false", "condition", "initial()", "terminal()", "sample", "delay", "relation")
_ALONE = ("false", "initial()", "terminal()")
_PRE = 1


class Label(NamedTuple):
    """The payload of a slot that is only a name."""

    text: str
    latex: str


def label(text: str) -> Label:
    """Return the name of a variable as text and as mathematics."""
    return Label(text, latex_name(text))


@dataclass(frozen=True)
class HeldPlace(Place):
    """The place of held values: that of a variable, or a list that the events pass has made.

    Attributes:
        around: How the path is written, e.g. ``pre({})``.
    """

    around: str = "{}"


@dataclass(frozen=True)
class Located:
    """A list of operands of one sort by place.

    Attributes:
        places: The places; None stands for numbers without a name.
        code: Place of each operand, shape ``(n,)``.
        position: Its position among the members of the place.
        values: Values of numbers without a name, shape ``(n,)``; NaN elsewhere.
    """

    places: tuple[Place | None, ...]
    code: Ids
    position: Ids
    values: NDArray[np.float64] | None = None

    def name(self, members: Ids, indices: IndexNames) -> Expr:
        """Return what stands for operands ``members``, all of one place, in an equation."""
        place = self.places[int(self.code[members[0]])]
        if place is None:
            assert self.values is not None
            return _number(self.values[members], indices)
        rows = place.subscripts[:, self.position[members]]
        text = path_text(place.steps, [indices.text(r) for r in rows], place.order)
        return slot(label(place.around.format(text) if isinstance(place, HeldPlace) else text))


def _number(values: NDArray[np.float64], indices: IndexNames) -> Expr:
    if (values == values[0]).all():
        return const(float(values[0]))
    rule = indices.affine(values)
    if rule is not None:
        a, b, letter = rule
        index = slot(Label(letter, letter))
        return build.add(build.mul(const(a), index), const(b))
    listed = ", ".join(number_text(float(f"{v:.6g}")) for v in values[:3])
    more = ", ..." if len(values) > 3 else ""
    return slot(
        Label(f"{{{listed}{more}}}", rf"\{{{listed}{', ' + chr(92) + 'dots' if more else ''}\}}")
    )


class HeldPlaces:
    """Places of held values.

    Attributes:
        first: Parameter id of held value 0.
    """

    def __init__(self, numbering: Numbering, hybrid: Hybrid) -> None:
        self.first = hybrid.first
        self._numbering = numbering
        n, count = hybrid.n_discrete, hybrid.count
        # The variable of each position, or -1; of equal variables the lowest.
        self._variable = np.full(count, -1, np.int64)
        held = np.flatnonzero(hybrid.place >= 0)[::-1]
        self._variable[hybrid.place[held]] = held
        self._variable[n : 2 * n] = self._variable[:n]
        self._around = np.zeros(count, np.int64)
        self._around[n : 2 * n] = _PRE
        for family in hybrid.limits:
            self._variable[family.rows] = family.operands[0]
            self._around[family.rows] = _PRE
        # The list of each position without a variable, and its number there, from 1.
        self._list = np.zeros(count, np.int64)
        self._number = np.zeros(count, np.int64)
        relations = [np.sort(np.concatenate([r.family.rows for r in hybrid.relations]))]
        lists = [
            hybrid.conditions, np.array([hybrid.initial_flag]), np.array([hybrid.terminal_flag]),
            hybrid.sample_places, hybrid.delay_places, *(relations if hybrid.relations else []),
        ]  # fmt: skip
        for kind, positions in enumerate(lists, start=1):
            self._list[positions] = kind
            self._number[positions] = np.arange(len(positions)) + 1
        self._list[n : 2 * n] = self._list[:n]
        self._number[n : 2 * n] = self._number[:n]

    def of(self, ids: Ids) -> list[HeldPlace]:
        """Sort the held values among parameters ids by place."""
        result: list[HeldPlace] = []
        last = self.first + len(self._variable)
        members = np.flatnonzero((ids >= self.first) & (ids < last))
        positions = ids[members] - self.first
        later = np.flatnonzero(ids >= last)
        if len(later):
            # What the elimination adds, see acausal.elimination.rests.
            numbers = ids[later][None, :] - last + 1
            result.append(HeldPlace((("rest", 1),), numbers, later))
        for around in np.unique(self._around[positions]).tolist():
            same = self._around[positions] == around
            form = "pre({})" if around == _PRE else "{}"
            named = members[same & (self._variable[positions] >= 0)]
            for p in variable_places(self._numbering, self._variable[ids[named] - self.first]):
                result.append(
                    HeldPlace(p.steps, p.subscripts, named[p.members], p.order, around=form)
                )
            other = members[same & (self._variable[positions] < 0)]
            kinds = self._list[ids[other] - self.first]
            for kind in np.unique(kinds).tolist():
                own = other[kinds == kind]
                name = _LISTS[kind]
                numbers = self._number[ids[own] - self.first][None, :]
                alone = name in _ALONE
                steps = ((name, 0 if alone else 1),)
                result.append(HeldPlace(steps, numbers[: 0 if alone else 1], own, 0, around=form))
        return result


class Names:
    """Places of all ids of a model, those of index reduction included.

    Args:
        numbering: The numbering.
        model: The flat model.
        chains: Chains of derivatives that may reach behind the numbering; None without.
    """

    def __init__(
        self,
        numbering: Numbering,
        model: FlatModel,
        chains: Chains | None = None,
    ) -> None:
        self.numbering = numbering
        self.parameters = model.parameters
        self._held = HeldPlaces(numbering, model.hybrid) if model.hybrid is not None else None
        self._chains = chains

    def variables(self, ids: Ids) -> list[Place]:
        """Sort variable ids by place; new derivatives are written ``der(...)`` of declared ones."""
        n = self.numbering.n_variables
        if self._chains is None or not (ids >= n).any():
            return variable_places(self.numbering, ids)
        base, order = self._declared(ids)
        found: list[Place] = []
        for extra in np.unique(order).tolist():
            chosen = np.flatnonzero(order == extra)
            for p in variable_places(self.numbering, base[chosen]):
                found.append(Place(p.steps, p.subscripts, chosen[p.members], p.order + extra))
        return sorted(found, key=lambda p: int(p.members[0]))

    def parameters_of(self, ids: Ids) -> list[Place]:
        """Sort ids of declared parameters by place."""
        return parameter_places(self.numbering, ids)

    def _declared(self, ids: Ids) -> tuple[Ids, Ids]:
        """Return the last declared id before each id in its chain, and the distance."""
        chains = self._chains
        assert chains is not None
        new = np.flatnonzero(ids >= self.numbering.n_variables)
        before = np.full(chains.n_variables, -1, np.int64)
        mothers = np.flatnonzero(chains.derivative >= 0)
        before[chains.derivative[mothers]] = mothers
        base, order = ids.copy(), np.zeros(len(ids), np.int64)
        while len(new):
            base[new] = before[base[new]]
            order[new] += 1
            new = new[base[new] >= self.numbering.n_variables]
        return base, order

    def one(self, variable: int) -> str:
        """Return the path of one variable."""
        return self.variables(np.array([variable]))[0].paths()[0]

    def locate(self, ids: Ids, kind: Operand) -> Located:
        """Sort operands by place."""
        values = None
        places: list[Place | None]
        if kind == Operand.VARIABLE:
            places = list(self.variables(ids))
            code, position = codes_of(places, len(ids))
        elif kind == Operand.PRE:
            places = [
                HeldPlace(p.steps, p.subscripts, p.members, p.order, around="pre({})")
                for p in self.variables(ids)
            ]
            code, position = codes_of(places, len(ids))
        elif kind in (Operand.SIGNAL, Operand.PRE_SIGNAL):
            form = "{}" if kind == Operand.SIGNAL else "pre({})"
            places = [
                HeldPlace((("signal", 1),), ids[None, :], np.arange(len(ids)), 0, around=form)
            ]
            code, position = codes_of(places, len(ids))
        else:
            n = self.numbering.n_parameters
            named = np.flatnonzero(ids < n)
            own = parameter_places(self.numbering, ids[named])
            places = [Place(p.steps, p.subscripts, named[p.members]) for p in own]
            code, position = codes_of(places, len(ids))
            if self._held is not None:
                for held in self._held.of(ids):
                    code[held.members] = len(places)
                    position[held.members] = np.arange(len(held.members))
                    places.append(held)
                n_known = self._held.first
            else:
                n_known = len(self.parameters)
            literal = (ids >= n) & (ids < n_known)
            if literal.any():
                code[literal] = len(places)
                places.append(None)
                values = np.full(len(ids), np.nan)
                values[literal] = self.parameters[ids[literal]]
        return Located(tuple(places), code, position, values)


def codes_of(places: list[Place | None], n: int) -> tuple[Ids, Ids]:
    """Return the place of each of ``n`` operands, and its position among the members there."""
    code, position = np.zeros(n, np.int64), np.zeros(n, np.int64)
    for k, place in enumerate(places):
        assert place is not None
        code[place.members] = k
        position[place.members] = np.arange(len(place.members))
    return code, position
