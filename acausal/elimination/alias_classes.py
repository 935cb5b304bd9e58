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

from acausal.elimination.signed_components import Signs, redundant_edges, signed_components
from acausal.flattening.model import Ids

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class AliasRows:
    """Rows ``a = sign * b``; ``a = 0`` is written ``a = -a``. Arrays of shape ``(m,)``."""

    rows: Ids
    a: Ids
    b: Ids
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
class _Closure:
    """Classes of the nodes that take part (``local`` numbers)."""

    component: Ids
    sign: Signs
    count: int
    a: Ids
    b: Ids
    edge_sign: Signs


def alias_classes(aliases: AliasRows, derivative: Ids, priority: Ids) -> AliasClasses:
    """Return the classes that alias rows and congruence make.

    Args:
        aliases: The alias rows.
        derivative: Id of the derivative of each variable, or -1, shape ``(n,)``.
        priority: Small integers, the lowest becomes representative; ties go by id.
    """
    n = derivative.shape[0]
    nodes = _participants(aliases, derivative)
    local = np.full(n, -1, dtype=np.int64)
    local[nodes] = np.arange(nodes.shape[0])
    child = np.full(nodes.shape[0], -1, dtype=np.int64)
    has_child = derivative[nodes] >= 0
    child[has_child] = local[derivative[nodes[has_child]]]
    while True:
        a, b = local[aliases.a], local[aliases.b]
        closure = _closure(nodes.shape[0], a, b, aliases.sign, child)
        cut = _contradicting(closure, child)
        chosen: Ids | None = None
        if not cut.any():
            chosen, orientation, cut = _representatives(closure, child, priority[nodes])
        left_out = cut[a] | cut[b]
        if not cut.any():
            break
        if not left_out.any():
            raise AssertionError("alias classes: a contradiction without an alias row")
        aliases = aliases.without(left_out)
    assert chosen is not None
    component, sign = closure.component, closure.sign
    representative = np.arange(n)
    representative[nodes] = nodes[chosen[component]]
    signs = np.ones(n, dtype=np.int8)
    signs[nodes] = sign * orientation[component]
    result = derivative.copy()
    result[nodes] = -1
    mothers = np.flatnonzero((child >= 0) & (sign != 0))
    daughters = child[mothers]
    alive = sign[daughters] != 0
    result[nodes[chosen[component[mothers[alive]]]]] = nodes[chosen[component[daughters[alive]]]]
    # The edges of congruence come first: what they imply makes an alias row redundant.
    implied = closure.a.shape[0] - aliases.rows.shape[0]
    redundant = redundant_edges(
        component, sign, closure.count, closure.a, closure.b, closure.edge_sign
    )[implied:]
    return AliasClasses(representative, signs, result, aliases, redundant)


def _participants(aliases: AliasRows, derivative: Ids) -> Ids:
    """Return the variables of the alias rows with all their derivatives and antiderivatives."""
    mask = np.zeros(derivative.shape[0], dtype=np.bool_)
    mask[aliases.a] = True
    mask[aliases.b] = True
    mothers = np.flatnonzero(derivative >= 0)
    daughters = derivative[mothers]
    while True:
        new = mothers[mask[mothers] != mask[daughters]]
        if new.shape[0] == 0:
            return np.flatnonzero(mask)
        mask[new] = True
        mask[derivative[new]] = True


def _closure(n: int, a: Ids, b: Ids, sign: Signs, child: Ids) -> _Closure:
    """Return the components of the alias graph closed under congruence."""
    component, signs, count = signed_components(n, a, b, sign)
    mothers = np.flatnonzero(child >= 0)
    extra_a = extra_b = np.zeros(0, dtype=np.int64)
    extra_sign = np.zeros(0, dtype=np.int8)
    while True:
        order = mothers[np.argsort(component[mothers], kind="stable")]
        same = component[order[1:]] == component[order[:-1]]
        x, y = order[:-1][same], order[1:][same]
        s = signs[x] * signs[y]
        zero = order[signs[order] == 0]
        # Of an unbalanced class every derivative is zero on its own.
        new_a = np.concatenate([child[x[s != 0]], child[zero]])
        new_b = np.concatenate([child[y[s != 0]], child[zero]])
        new_sign = np.concatenate([s[s != 0], np.full(zero.shape[0], -1, dtype=np.int8)])
        known = (component[new_a] == component[new_b]) & (
            (signs[new_a] * signs[new_b] == new_sign) | (signs[new_a] == 0)
        )
        new_a, new_b, new_sign = new_a[~known], new_b[~known], new_sign[~known]
        if new_a.shape[0] == 0:
            break
        extra_a = np.concatenate([extra_a, new_a])
        extra_b = np.concatenate([extra_b, new_b])
        extra_sign = np.concatenate([extra_sign, new_sign])
        component, signs, count = signed_components(
            n,
            np.concatenate([extra_a, a]),
            np.concatenate([extra_b, b]),
            np.concatenate([extra_sign, sign]),
        )
    return _Closure(
        component,
        signs,
        count,
        np.concatenate([extra_a, a]),
        np.concatenate([extra_b, b]),
        np.concatenate([extra_sign, sign]),
    )


def _contradicting(closure: _Closure, child: Ids) -> Mask:
    """Return the derivatives whose alias rows must stay in the model.

    These are: a derivative that is zero while its variable is not (the variable is constant,
    which is an equation), one shared by variables that are not equal, and those on a cycle of
    classes (``der(x) = x``).
    """
    component, sign = closure.component, closure.sign
    cut = np.zeros(component.shape[0], dtype=np.bool_)
    mothers = np.flatnonzero((child >= 0) & (sign != 0))
    daughters = child[mothers]
    cut[daughters[sign[daughters] == 0]] = True
    if cut.any():
        return cut
    of, to = component[mothers], component[daughters]
    mother_class = np.full(closure.count, closure.count, dtype=np.int64)
    np.minimum.at(mother_class, to, of)
    cut[daughters[of != mother_class[to]]] = True
    if cut.any():
        return cut
    # Now every class has at most one derivative class and is that of at most one: paths and
    # cycles. Doubling the step, a path ends; what does not is a cycle.
    step = np.full(closure.count + 1, closure.count, dtype=np.int64)
    step[of] = to
    for _ in range(int(closure.count).bit_length() + 1):
        step = step[step]
        if (step == closure.count).all():
            break
    endless = step[:-1] != closure.count
    cut[daughters[endless[to]]] = True
    return cut


def _representatives(
    closure: _Closure, child: Ids, priority: Ids
) -> tuple[Ids, Signs, Mask]:
    """Choose a representative for every class, variables before their derivatives.

    The derivative of a representative must be plus, not minus, the representative of its class.

    Returns:
        ``(node, orientation, cut)``: the representative of each class, its sign in the class,
        and derivatives whose alias rows must stay because no sign fits.
    """
    component, sign, count = closure.component, closure.sign, closure.count
    n = component.shape[0]
    key = (priority + 8 * (child < 0)) * np.int64(n) + np.arange(n)
    mother = np.full(count, -1, dtype=np.int64)
    relative = np.ones(count, dtype=np.int8)
    mothers = np.flatnonzero((child >= 0) & (sign != 0))
    daughters = child[mothers]
    mother[component[daughters]] = component[mothers]
    relative[component[daughters]] = sign[mothers] * sign[daughters]

    nothing = np.iinfo(np.int64).max
    best = np.full(count, nothing, dtype=np.int64)
    first_level = mother[component] < 0
    np.minimum.at(best, component[first_level], key[first_level])
    chosen = np.zeros(count, dtype=np.int64)
    level = np.flatnonzero(best < nothing)
    chosen[level] = best[level] % n
    orientation = np.zeros(count, dtype=np.int8)
    orientation[level] = sign[chosen[level]]
    cut = np.zeros(n, dtype=np.bool_)

    daughter = np.full(count, -1, dtype=np.int64)
    has_mother = np.flatnonzero(mother >= 0)
    daughter[mother[has_mother]] = has_mother
    members = np.flatnonzero(~first_level)
    while True:
        level = daughter[level]
        level = level[level >= 0]
        if level.shape[0] == 0:
            return chosen, orientation, cut
        orientation[level] = orientation[mother[level]] * relative[level]
        fits = members[sign[members] == orientation[component[members]]]
        best[level] = nothing
        in_level = fits[orientation[component[fits]] != 0]
        np.minimum.at(best, component[in_level], key[in_level])
        bad = level[best[level] == nothing]
        if bad.shape[0]:
            # The class above holds both a derivative and, with the other sign, a variable
            # that is itself differentiated: v = -der(x) with der(v) in use.
            above = np.zeros(count, dtype=np.bool_)
            above[mother[bad]] = True
            cut[daughters[above[component[daughters]]]] = True
            return chosen, orientation, cut
        chosen[level] = best[level] % n

