"""Relations that make events, taken out of templates and held between events.

``x > y`` outside of ``noEvent`` and ``smooth``, and ``floor`` and what is made of it, become held
values if they depend on time or on a continuous variable; a relation between held values changes
at events anyway. Relations with the same template and operands are one (Modelica 3.6, sections
3.7.2 and 8.5). Work is done once per template; members are compared as columns of index arrays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from acausal.expressions import build
from acausal.expressions.nodes import Expr, slot
from acausal.expressions.traverse import postorder
from acausal.flattening.members import join_origins, partition, renumbered, take_members
from acausal.flattening.model import EquationFamily, Ids, Operand, RelationFamily

#: What is not descended into: relations inside make no events.
_QUIET = ("noevent", "smooth")
_ROUNDED = ("floor", "integer", "ceil", "div", "mod", "rem")
_ORDERED = ("gt", "ge", "lt", "le")


@dataclass(frozen=True)
class Watched:
    """A node of a template that makes events.

    Attributes:
        node: The node.
        function: ``g`` over the slots of the template.
        kind: ``gt``, ``ge`` or ``floor``.
    """

    node: Expr
    function: Expr
    kind: str

    def value(self, held: Expr) -> Expr:
        """Return what the node is, from the held value of ``g``."""
        op, args = self.node.op, self.node.args
        if op != "call":
            opposite = (op in ("lt", "le")) != _swapped(self.node)
            return build.not_(held) if opposite else held
        if self.node.value in ("floor", "integer"):
            return held
        if self.node.value == "ceil":
            return build.neg(held)
        quotient = held
        if self.node.value in ("div", "rem"):
            # Truncation is the floor of the magnitude with the sign; where the sign changes,
            # the floor is zero.
            quotient = build.mul(build.call("sign", build.div(*args)), held)
        if self.node.value == "div":
            return quotient
        return build.sub(args[0], build.mul(quotient, args[1]))


def _swapped(node: Expr) -> bool:
    """Return whether the sides change places: a constant on the left goes to the right."""
    return node.args[0].op == "const"


def _watched(node: Expr) -> Watched:
    if node.op == "call":
        if node.value in ("floor", "integer"):
            return Watched(node, node.args[0], "floor")
        if node.value == "ceil":
            return Watched(node, build.neg(node.args[0]), "floor")
        quotient = build.div(*node.args)
        if node.value != "mod":
            quotient = build.call("abs", quotient)
        return Watched(node, quotient, "floor")
    op = node.op
    left, right = node.args
    if _swapped(node):
        left, right = right, left
        op = {"lt": "gt", "le": "ge", "gt": "lt", "ge": "le"}[op]
    # A relation and its opposite are one: x <= y is not x > y.
    return Watched(node, build.sub(left, right), "gt" if op in ("gt", "le") else "ge")


def _live(template: Expr) -> list[Expr]:
    """Return the nodes outside of ``noEvent`` and ``smooth``, arguments first."""
    order: list[Expr] = []
    done: set[Expr] = set()
    stack: list[tuple[Expr, bool]] = [(template, False)]
    while stack:
        item, expanded = stack.pop()
        if item in done:
            continue
        if expanded:
            done.add(item)
            order.append(item)
            continue
        stack.append((item, True))
        if item.op not in _QUIET:
            stack += [(a, False) for a in reversed(item.args) if a not in done]
    return order


def _may_watch(item: Expr) -> bool:
    return item.op in _ORDERED or (item.op == "call" and item.value in _ROUNDED)


@lru_cache(maxsize=16384)
def watched(template: Expr, kinds: tuple[Operand, ...]) -> tuple[Watched, ...]:
    """Return the innermost nodes of a template that make events, in order."""
    if not any(_may_watch(item) for item in postorder(template)):
        return ()
    changing: dict[Expr, bool] = {}
    inside: dict[Expr, bool] = {}
    found: list[Watched] = []
    for item in postorder(template):
        if item.op == "slot":
            assert isinstance(item.value, int)
            changing[item] = kinds[item.value] == Operand.VARIABLE
        else:
            changing[item] = item.op == "time" or any(changing[a] for a in item.args)
    for item in _live(template):
        below = item.op not in _QUIET and any(inside[a] for a in item.args)
        makes = _may_watch(item) and changing[item]
        if makes and not below:
            found.append(_watched(item))
        inside[item] = makes or below
    return tuple(found)


def _with(template: Expr, values: dict[Expr, Expr]) -> Expr:
    """Return the template with nodes outside of ``noEvent`` and ``smooth`` replaced."""
    result: dict[Expr, Expr] = {}
    for item in _live(template):
        replacement = values.get(item)
        if replacement is None:
            quiet = not item.args or item.op in _QUIET
            replacement = (
                item if quiet else build.rebuild(item, tuple(result[a] for a in item.args))
            )
        result[item] = replacement
    return result[template]


_Key = tuple[Expr, tuple[Operand, ...], str]


class Extraction:
    """Takes relations out of families; several calls share what they find.

    Attributes:
        count: Number of held positions that are taken.
    """

    def __init__(self, first: int, count: int) -> None:
        self._first = first
        self.count = count
        self._known: dict[_Key, list[EquationFamily]] = {}

    def extracted(self, groups: Sequence[Sequence[EquationFamily]]) -> list[list[EquationFamily]]:
        """Return the families with held values in place of relations, group by group.

        Relations inside relations are taken out in an earlier round than those around them.
        """
        result = [list(group) for group in groups]
        open_ = [(g, k) for g, group in enumerate(result) for k in range(len(group))]
        while True:
            requests: dict[_Key, list[tuple[int, int, int, EquationFamily]]] = {}
            again: list[tuple[int, int]] = []
            for g, k in open_:
                family = result[g][k]
                nodes = watched(family.template, family.kinds)
                if nodes:
                    again.append((g, k))
                for number, node in enumerate(nodes):
                    function = renumbered(family, node.function)
                    key = (function.template, function.kinds, node.kind)
                    requests.setdefault(key, []).append((g, k, number, function))
            if not again:
                return result
            places: dict[tuple[int, int], dict[int, Ids]] = {}
            for key, asked in requests.items():
                found = self._places(key, [function for *_, function in asked])
                for (g, k, number, _), own in zip(asked, found, strict=True):
                    places.setdefault((g, k), {})[number] = own
            for g, k in again:
                result[g][k] = self._replaced(result[g][k], places[g, k])
            open_ = again

    def shared(self, families: Sequence[EquationFamily]) -> list[EquationFamily]:
        """Return bodies of whens with the held values of relations that are watched elsewhere.

        In ``when x > 1 then b = x > 1`` both have to be the same relation: at the very instant
        of the event the numbers do not tell. All other relations in a body are left alone.

        Args:
            families: Templates are ``noevent`` of what the when gives its target.
        """
        result: list[EquationFamily] = []
        for family in families:
            if family.template.op != "noevent":
                result.append(family)
                continue
            (body,) = family.template.args
            found = [
                (node, places)
                for node in watched(body, family.kinds)
                if (places := self._found(node, family)).max(initial=-1) >= 0
            ]
            if not found:
                result.append(family)
                continue
            bare = replace(family, template=body)
            keys = [(places >= 0).astype(np.int64) for _, places in found]
            for members in partition(keys, [2] * len(keys)):
                part = take_members(bare, members)
                own = [(node, places[members]) for node, places in found]
                part = self._held(part, [(n, p) for n, p in own if p[0] >= 0])
                result.append(replace(part, template=build.noevent(part.template)))
        return result

    def _found(self, node: Watched, family: EquationFamily) -> Ids:
        """Return the held positions of a relation that is known already, -1 elsewhere."""
        function = renumbered(family, node.function)
        known = self._known.get((function.template, function.kinds, node.kind), [])
        if not known:
            return np.full(family.count, -1)
        operands = np.concatenate([f.operands for f in (*known, function)], axis=1)
        rows = np.concatenate([f.rows for f in known])
        first, inverse = unique_columns(operands)
        place = np.where(first < len(rows), rows[np.minimum(first, len(rows) - 1)], -1)
        found: Ids = place[inverse[len(rows) :]]
        return found

    def _places(self, key: _Key, asked: list[EquationFamily]) -> list[Ids]:
        """Return the held positions of functions of one template, new ones where needed."""
        known = self._known.setdefault(key, [])
        operands = np.concatenate([f.operands for f in (*known, *asked)], axis=1)
        n_known = sum(f.count for f in known)
        first, inverse = unique_columns(operands)
        old = int(np.searchsorted(first, n_known))
        place = np.empty(len(first), np.int64)
        place[:old] = np.concatenate([f.rows for f in known])[first[:old]] if old else 0
        new = len(first) - old
        place[old:] = self.count + np.arange(new)
        self.count += new
        begin = n_known
        result: list[Ids] = []
        for function in asked:
            end = begin + function.count
            mine = (first >= begin) & (first < end)
            if mine.any():
                members = first[mine] - begin
                part = take_members(function, members)
                known.append(
                    EquationFamily(
                        part.template, part.kinds, part.operands, place[mine], part.origins
                    )
                )
            result.append(place[inverse[begin:end]])
            begin = end
        return result

    def _replaced(self, family: EquationFamily, places: dict[int, Ids]) -> EquationFamily:
        nodes = watched(family.template, family.kinds)
        return self._held(family, [(node, places[i]) for i, node in enumerate(nodes)])

    def _held(self, family: EquationFamily, nodes: list[tuple[Watched, Ids]]) -> EquationFamily:
        """Return a family with held values in place of nodes."""
        if not nodes:
            return family
        m = len(family.kinds)
        values = {node.node: node.value(slot(m + i)) for i, (node, _) in enumerate(nodes)}
        held = [self._first + places for _, places in nodes]
        extended = EquationFamily(
            family.template,
            (*family.kinds, *[Operand.PARAMETER] * len(nodes)),
            np.concatenate([family.operands, np.stack(held)]),
            family.rows,
            family.origins,
        )
        return renumbered(extended, _with(family.template, values))

    def relations(self) -> tuple[RelationFamily, ...]:
        """Return all relations, inner ones before those they are part of."""
        return tuple(
            RelationFamily(
                EquationFamily(
                    template,
                    kinds,
                    np.concatenate([part.operands for part in parts], axis=1),
                    np.concatenate([part.rows for part in parts]),
                    join_origins(parts),
                ),
                kind,
            )
            for (template, kinds, kind), parts in self._known.items()
            if parts
        )


def unique_columns(columns: Ids) -> tuple[Ids, Ids]:
    """Return the first of equal columns, ascending, and for every column the number of its first.

    Args:
        columns: Shape ``(m, count)``; without rows all columns are equal.
    """
    count = columns.shape[1]
    if not count:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    code = np.zeros(count, np.int64)
    for row in columns:
        own, inverse = np.unique(row, return_inverse=True)
        code = code * len(own) + inverse
        code = np.unique(code, return_inverse=True)[1]
    _, first, inverse = np.unique(code, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    return first[order], rank[inverse]


def makes_events(families: Sequence[EquationFamily]) -> bool:
    """Return whether any relation of these families makes events."""
    return any(watched(family.template, family.kinds) for family in families)
