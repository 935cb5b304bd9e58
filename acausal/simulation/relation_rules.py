"""The rules of frozen relations as templates: they run as kernels, all relations at once.

Every rule is an expression over numbers about one relation (see
:class:`acausal.simulation.relations.Places`): slots 0 to 3 are the difference ``g``, its
coefficient of time, the largest difference so far and the one before the event; slot 4 is what
it is held at.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from acausal.expressions.build import (
    add,
    and_,
    call,
    div,
    if_,
    mul,
    neg,
    not_,
    or_,
    relation,
    sub,
)
from acausal.expressions.nodes import ONE, TIME, ZERO, Expr, const, slot
from acausal.flattening.model import Ids
from acausal.simulation.relations import (
    FLOOR,
    GREATER_EQUAL,
    JUMP,
    LEAST,
    SAME_TIME,
    SHARE,
    Relations,
)

#: Order of the numbers that rules read.
OPERANDS = ("g", "slope", "largest", "left", "held")
_G, _SLOPE, _LARGEST, _LEFT, _HELD = (slot(k) for k in range(5))
_NEVER = const(float("inf"))


@dataclass(frozen=True)
class Rule:
    """A template for some relations.

    Attributes:
        template: Over slots 0 to 4.
        members: Relations (or root functions) it is for, ascending.
    """

    template: Expr
    members: Ids


def _greater(inclusive: bool, a: Expr, b: Expr) -> Expr:
    return relation("ge" if inclusive else "gt", a, b)


def _instant() -> Expr:
    """Return the smallest time that counts as later."""
    return mul(const(SAME_TIME), call("max", call("abs", TIME), const(1e-3)))


def largest() -> Expr:
    """Return the rule of the largest difference so far."""
    return call("max", _LARGEST, call("abs", _G))


def wanted(kind: int, scheduled: bool, *, exact: bool) -> Expr:
    """Return what a relation should be held at.

    Args:
        kind: ``GREATER``, ``GREATER_EQUAL`` or ``FLOOR``.
        scheduled: It is linear in time: it has changed when its time has come.
        exact: Without hysteresis, for the first instant.
    """
    inclusive = kind == GREATER_EQUAL
    plain = call("floor", _G) if kind == FLOOR else if_(_greater(inclusive, _G, ZERO), ONE, ZERO)
    if scheduled:
        nearest = call("floor", add(_G, const(0.5))) if kind == FLOOR else ZERO
        tolerance = mul(call("abs", _SLOPE), _instant())
        here = and_(
            relation("le", call("abs", sub(_G, nearest)), tolerance), relation("ne", _SLOPE, ZERO)
        )
        after = sub(nearest, ONE) if kind == FLOOR else ZERO
        before = nearest if kind == FLOOR else ONE
        return if_(here, if_(relation("gt", _SLOPE, ZERO), before, after), plain)
    if exact:
        return plain
    margin = mul(const(SHARE), _LARGEST)
    if kind == FLOOR:
        inside = and_(
            relation("ge", add(sub(_G, _HELD), margin), ZERO),
            relation("lt", sub(sub(sub(_G, _HELD), ONE), margin), ZERO),
        )
        return if_(inside, _HELD, plain)
    level = if_(relation("gt", _HELD, ZERO), neg(margin), margin)
    follows = if_(_greater(inclusive, _G, level), ONE, ZERO)
    jumped = and_(
        relation("eq", _G, ZERO),
        relation("gt", call("abs", _LEFT), mul(const(JUMP), _LARGEST)),
    )
    return if_(jumped, ONE if inclusive else ZERO, follows)


def next_time(kind: int) -> Expr:
    """Return when a relation that is linear in time changes next."""
    rising = relation("gt", _SLOPE, ZERO)
    if kind == FLOOR:
        level = add(_HELD, if_(rising, ONE, ZERO))
        coming = relation("ne", _SLOPE, ZERO)
    else:
        level = ZERO
        held = relation("gt", _HELD, ZERO)
        falling = relation("lt", _SLOPE, ZERO)
        coming = or_(and_(held, falling), and_(not_(held), rising))
    wait = div(sub(level, _G), _SLOPE)
    return if_(and_(coming, relation("gt", wait, _instant())), add(TIME, wait), _NEVER)


def _up(kind: int, side: int) -> Expr:
    if kind == FLOOR:
        return ONE if side else ZERO
    return if_(relation("gt", _HELD, ZERO), ZERO, ONE)


def direction(kind: int, side: int) -> Expr:
    """Return the direction in which a root function is looked at."""
    return sub(mul(const(2.0), _up(kind, side)), ONE)


def shift(kind: int, side: int) -> Expr:
    """Return the shift of a root function: exact, but away from zero at the start."""
    up = relation("gt", _up(kind, side), ZERO)
    level = add(_HELD, const(float(side))) if kind == FLOOR else ZERO
    inside = if_(up, sub(level, _G), sub(_G, level))  # how far it is from changing
    margin = call("max", mul(const(SHARE), _LARGEST), const(LEAST))
    close = relation("lt", inside, mul(const(0.5), margin))
    room = if_(close, margin, ZERO)
    return add(neg(level), if_(up, neg(room), room))


def rules_of_wanted(relations: Relations, *, exact: bool) -> list[Rule]:
    """Return the rules for what all relations should be held at."""
    result = []
    for kind in np.unique(relations.kind).tolist():
        for scheduled in (False, True):
            members = np.flatnonzero((relations.kind == kind) & (relations.scheduled == scheduled))
            if len(members):
                result.append(Rule(wanted(kind, scheduled, exact=exact), members))
    return result


def rules_of_next_times(relations: Relations) -> list[Rule]:
    """Return the rules for the times of the relations that are linear in time."""
    result = []
    for kind in np.unique(relations.kind).tolist():
        members = np.flatnonzero((relations.kind == kind) & relations.scheduled)
        if len(members):
            result.append(Rule(next_time(kind), members))
    return result


def rules_of_roots(relations: Relations) -> list[tuple[Rule, Rule]]:
    """Return the rules for shift and direction of root functions."""
    result = []
    kinds = relations.kind[relations.root_relation]
    for kind in np.unique(kinds).tolist():
        for side in (0, 1):
            members = np.flatnonzero((kinds == kind) & (relations.root_side == side))
            if len(members):
                result.append(
                    (Rule(shift(kind, side), members), Rule(direction(kind, side), members))
                )
    return result
