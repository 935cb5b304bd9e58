"""Which variables are the same up to sign, which are zero, and who stands for them.

Alias rows make a signed graph; its components are classes of equal variables. Equal variables
have equal derivatives, which joins further classes until nothing changes (congruence closure
over ``der``). A variable and its own derivative never share a class: ``der(x) = x`` is a
differential equation. Such rows are left out of the graph and stay in the model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.elimination.signed_components import (
    Nodes,
    Signs,
    redundant_edges,
    signed_components,
)
from acausal.flattening.members import sorted_unique
from acausal.flattening.model import Ids

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class AliasRows:
    """Rows ``a = sign * b``; ``a = 0`` is written ``a = -a``. Arrays of shape ``(m,)``."""

    rows: Nodes
    a: Nodes
    b: Nodes
    sign: Signs

    def without(self, left_out: Mask) -> AliasRows:
        """Return the rows that are not left out."""
        kept = ~left_out
        return AliasRows(self.rows[kept], self.a[kept], self.b[kept], self.sign[kept])


@dataclass(frozen=True)
class AliasClasses:
    """The outcome.

    Attributes:
        representative: Who stands for each variable, shape ``(n,)``.
        sign: ``x = sign * representative``, 0 for a known zero, shape ``(n,)``.
        derivative: Derivative of each representative, -1 elsewhere, shape ``(n,)``.
        used: Alias rows that are used up.
        redundant: Which of them say nothing new.
    """

    representative: Ids
    sign: Signs
    derivative: Ids
    used: AliasRows
    redundant: Mask


@dataclass(frozen=True)
class _Graph:
    """The variables that take part, numbered locally, with their classes.

    Attributes:
        mothers: Nodes whose derivative takes part too.
        daughters: Those derivatives.
        root: Class of each node: its least node.
        sign: Sign of each node in its class, 0 in a class of zeros.
    """

    mothers: Nodes
    daughters: Nodes
    root: Nodes
    sign: Signs

    def alive(self) -> tuple[Nodes, Nodes]:
        """Return mothers and daughters of the classes that are not zero."""
        alive = self.sign[self.mothers] != 0
        return self.mothers[alive], self.daughters[alive]


def alias_classes(aliases: AliasRows, derivative: Ids, priority: Signs) -> AliasClasses:
    """Return the classes that alias rows and congruence make.

    Args:
        aliases: The alias rows.
        derivative: Id of the derivative of each variable, or -1, shape ``(n,)``.
        priority: Of equal variables that with the largest number (0 to 15) becomes the
            representative, of several the one with the lowest id, shape ``(n,)``.
    """
    n = derivative.shape[0]
    nodes = _participants(aliases, derivative)
    k = nodes.shape[0]
    local = np.zeros(n, dtype=np.int32)
    local[nodes] = np.arange(k, dtype=np.int32)
    mothers = np.flatnonzero(derivative[nodes] >= 0).astype(np.int32)
    daughters = local[derivative[nodes[mothers]]]
    priority = priority[nodes]
    priority[mothers] += 16
    a, b = local[aliases.a], local[aliases.b]
    del local
    while True:
        graph, redundant = _closure(k, a, b, aliases.sign, mothers, daughters)
        cut = _contradicting(graph)
        if not cut.any():
            chosen, orientation, cut = _representatives(graph, priority)
            if not cut.any():
                break
        left_out = cut[a] | cut[b]
        if not left_out.any():
            raise AssertionError("alias classes: a contradiction without an alias row")
        aliases, a, b = aliases.without(left_out), a[~left_out], b[~left_out]
    representative = np.arange(n)
    representative[nodes] = nodes[chosen[graph.root]]
    signs = np.ones(n, dtype=np.int8)
    signs[nodes] = graph.sign * orientation[graph.root]
    result = derivative.copy()
    result[nodes[mothers]] = -1
    of, to = graph.alive()
    result[representative[nodes[of]]] = representative[nodes[to]]
    return AliasClasses(representative, signs, result, aliases, redundant)


def _participants(aliases: AliasRows, derivative: Ids) -> Nodes:
    """Return the variables of the alias rows with all their derivatives and antiderivatives."""
    mask = np.zeros(derivative.shape[0], dtype=np.bool_)
    mask[aliases.a] = True
    mask[aliases.b] = True
    mothers = np.flatnonzero(derivative >= 0)
    daughters = derivative[mothers]
    while True:
        new = mothers[mask[mothers] != mask[daughters]]
        if new.shape[0] == 0:
            return np.flatnonzero(mask).astype(np.int32)
        mask[new] = True
        mask[derivative[new]] = True


def _closure(
    k: int, a: Nodes, b: Nodes, sign: Signs, mothers: Nodes, daughters: Nodes
) -> tuple[_Graph, Mask]:
    """Return the classes of the alias rows closed under congruence, and redundant rows."""
    root, signs = signed_components(k, a, b, sign)
    own = a.shape[0]
    while True:
        order = np.argsort(root[mothers], kind="stable")
        x, y = mothers[order[:-1]], mothers[order[1:]]
        same = root[x] == root[y]
        zero = daughters[signs[mothers] == 0]
        new_a = np.concatenate([daughters[order[:-1]][same], zero])
        new_b = np.concatenate([daughters[order[1:]][same], zero])
        # In a class of zeros every derivative is zero on its own.
        new_sign = np.concatenate([(signs[x] * signs[y])[same], np.full_like(zero, -1)])
        new_sign = new_sign.astype(np.int8)
        known = (new_sign == 0) | (
            (root[new_a] == root[new_b])
            & ((signs[new_a] * signs[new_b] == new_sign) | (signs[new_a] == 0))
        )
        if known.all():
            break
        new_a, new_b, new_sign = new_a[~known], new_b[~known], new_sign[~known]
        # The edges of congruence come first: what they imply makes an alias row redundant.
        a, b = np.concatenate([new_a, a]), np.concatenate([new_b, b])
        sign = np.concatenate([new_sign, sign])
        root, signs = signed_components(k, new_a, new_b, new_sign, (root, signs))
    redundant = redundant_edges(root, signs, a, b, sign)[a.shape[0] - own :]
    return _Graph(mothers, daughters, root, signs), redundant


def _contradicting(graph: _Graph) -> Mask:
    """Return the derivatives whose alias rows must stay in the model.

    These are: a derivative that is zero while its variable is not (the variable is constant,
    which is an equation), one shared by variables that are not equal, and those on a cycle of
    classes (``der(x) = x``).
    """
    root, k = graph.root, graph.root.shape[0]
    cut = np.zeros(k, dtype=np.bool_)
    mothers, daughters = graph.alive()
    cut[daughters[graph.sign[daughters] == 0]] = True
    if mothers.shape[0] == 0 or cut.any():
        return cut
    of, to = root[mothers], root[daughters]
    mother_class = np.full(k, k, dtype=np.int32)
    np.minimum.at(mother_class, to, of)
    cut[daughters[of != mother_class[to]]] = True
    if cut.any():
        return cut
    # Now every class has at most one derivative class and is that of at most one: paths and
    # cycles. Doubling the step, a path ends; what does not is a cycle, and is cut open where
    # its first variable is.
    step = np.full(k + 1, k, dtype=np.int32)
    step[of] = to
    first = np.arange(k + 1, dtype=np.int32)
    for _ in range(k.bit_length() + 1):
        if (step[to] == k).all():
            return cut
        first[of] = np.minimum(first[of], first[step[of]])
        step[of] = step[step[of]]
    cut[daughters[(step[to] != k) & (first[to] == to)]] = True
    return cut


def _representatives(graph: _Graph, priority: Signs) -> tuple[Nodes, Signs, Mask]:
    """Choose a representative for every class, variables before their derivatives.

    The derivative of a representative must be plus, not minus, the representative of its class.

    Returns:
        ``(node, orientation, cut)``: the representative of each class (at its root), its sign
        in the class, and derivatives whose alias rows must stay because no sign fits.
    """
    root, sign = graph.root, graph.sign
    k = root.shape[0]
    mothers, daughters = graph.alive()
    mother = np.full(k, -1, dtype=np.int32)
    mother[root[daughters]] = root[mothers]
    relative = np.ones(k, dtype=np.int8)
    relative[root[daughters]] = sign[mothers] * sign[daughters]

    chosen = np.arange(k, dtype=np.int32)
    orientation = np.ones(k, dtype=np.int8)
    found = np.zeros(k, dtype=np.bool_)

    def choose(candidates: Ids) -> None:
        """Let the candidate of highest priority stand for its class, of several the first."""
        classes = root[candidates]
        order = np.lexsort((candidates, -priority[candidates], classes))
        candidates, classes = candidates[order], classes[order]
        first = np.ones(order.shape[0], dtype=np.bool_)
        first[1:] = classes[1:] != classes[:-1]
        chosen[classes[first]] = candidates[first]
        found[classes[first]] = True

    # A root without a rival of higher priority stands for itself.
    top = mother[root] < 0
    choose(np.flatnonzero(top & (priority > 0)))
    heads = np.flatnonzero(found)
    orientation[heads] = sign[chosen[heads]]
    level = sorted_unique(root[mothers[mother[root[mothers]] < 0]])
    cut = np.zeros(k, dtype=np.bool_)

    daughter = np.full(k, -1, dtype=np.int32)
    daughter[root[mothers]] = root[daughters]
    below = np.flatnonzero(~top)
    while True:
        level = daughter[level]
        level = level[level >= 0]
        if level.shape[0] == 0:
            return chosen, orientation, cut
        orientation[level] = orientation[mother[level]] * relative[level]
        current = np.zeros(k, dtype=np.bool_)
        current[level] = True
        members = below[current[root[below]]]
        choose(members[sign[members] == orientation[root[members]]])
        bad = level[~found[level]]
        if bad.shape[0]:
            # The class above holds both a derivative and, with the other sign, a variable
            # that is itself differentiated: v = -der(x) with der(v) in use.
            above = np.zeros(k, dtype=np.bool_)
            above[mother[bad]] = True
            cut[daughters[above[root[daughters]]]] = True
            return chosen, orientation, cut
