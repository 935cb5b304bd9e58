"""Explicit locals: variables that one row defines, ``x = f(...)``, are put into their uses.

One batch at a time, a set of definitions is chosen of which none refers to another, and put into
all families at once. What pays is judged as in sparse elimination (H. M. Markowitz, Management
Science 3, 1957): a variable with ``u`` uses and ``s`` variables in its definition removes
``u + s + 1`` entries of the Jacobian and makes ``u s``; and the value of ``f`` is then computed
``u`` times instead of once. All members of a family that stand in equal surroundings are treated
alike, so that a long chain of equal components keeps a handful of templates.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from acausal.elimination.families import Tally, variable_slots
from acausal.elimination.linear_form import shifted, solved_for, tidied
from acausal.elimination.rewriting import split_duplicates
from acausal.expressions.build import number_of
from acausal.expressions.differentiate import partial
from acausal.expressions.evaluate import evaluate
from acausal.expressions.nodes import RELATIONS, Expr, slot
from acausal.expressions.traverse import postorder, slots, substitute
from acausal.flattening.members import merge_families, partition, renumbered, take_members
from acausal.flattening.model import EquationFamily, Ids, Operand

Mask = NDArray[np.bool_]

#: Entries of the Jacobian that one elimination may add.
MAX_FILL = 0
#: Additional operations that the repeated evaluation of a definition may cost.
MAX_REPEATED_COST = 30
#: Largest definition, and largest template something is put into, in nodes.
MAX_DEFINITION = 60
MAX_TEMPLATE = 240

#: No division by parameters smaller than this, nor larger than its inverse.
TINY = 1e-100

#: A variable is not solved for if its constant coefficient is this much smaller than another one.
SMALL = 1e-6

_COSTS = {"div": 4, "pow": 10, "call": 12}
_JUMPS = ("sign", "floor", "ceil", "integer", "mod", "rem", "div", "abs", "min", "max")


@lru_cache(maxsize=4096)
def cost(template: Expr) -> int:
    """Return about how many multiplications the evaluation of a template costs."""
    return sum(_COSTS.get(e.op, 1) for e in postorder(template) if e.args and e.op != "neg")


@lru_cache(maxsize=4096)
def size(template: Expr) -> int:
    """Return the number of nodes of a template."""
    return len(postorder(template))


@lru_cache(maxsize=4096)
def has_jumps(template: Expr) -> bool:
    """Return whether a template has relations or kinks, which make events."""
    return any(
        e.op in RELATIONS or (e.op == "call" and e.value in _JUMPS) for e in postorder(template)
    )


@lru_cache(maxsize=16384)
def solution(
    template: Expr,
    key: int,
    parameters: frozenset[int] = frozenset(),
    limit: int = MAX_DEFINITION,
) -> tuple[Expr, Expr] | None:
    """Return ``(f, c)`` of :func:`solved_for`, or None if the row is no definition of the slot.

    Rows of more than ``limit`` nodes are none.
    """
    if has_jumps(template) or size(template) > limit:
        return None
    solved = solved_for(template, key, parameters)
    return None if solved is None or _cancels(template, key, solved[1]) else solved


def _cancels(template: Expr, key: int, divisor: Expr) -> bool:
    """Tell whether a definition would be the small difference of large terms.

    In ``h = 3 a + 1e-14 b`` the value of ``b`` is lost in the round-off of the others.
    """
    if divisor.op != "const":
        return False
    others = [k for k in slots(template) if k != key]
    if len(others) < 2:
        return False
    coefficients = (partial(template, slot(k)) for k in others)
    largest = max((abs(number_of(c)) for c in coefficients if c.op == "const"), default=0.0)
    return abs(number_of(divisor)) < SMALL * largest


@dataclass(frozen=True)
class Definitions:
    """Variables ``variables = template(operands)``, all members of one family.

    ``divisor`` is what the template divides by, a constant or an expression of parameters.
    """

    family: EquationFamily
    template: Expr
    divisor: Expr
    slot: int
    members: Ids

    @property
    def variables(self) -> Ids:
        """The defined variables."""
        variables: Ids = self.family.operands[self.slot, self.members]
        return variables

    def value_family(self) -> EquationFamily:
        """Return the definitions as a family: the value of the variable ``rows[k]``."""
        part = take_members(self.family, self.members)
        value = EquationFamily(
            part.template, part.kinds, part.operands, part.operands[self.slot], part.origins
        )
        return renumbered(value, self.template)

    def divisor_family(self) -> EquationFamily | None:
        """Return what must not become zero, as a family; None for a literal."""
        if self.divisor.op == "const":
            return None
        part = take_members(self.family, self.members)
        value = EquationFamily(
            part.template, part.kinds, part.operands, part.operands[self.slot], part.origins
        )
        return renumbered(value, self.divisor)


@dataclass(frozen=True)
class _Choice:
    """All members of a family that could define the variable of one slot."""

    order: tuple[float, int, int, int]
    family: EquationFamily
    template: Expr
    divisor: Expr
    slot: int
    members: Ids


def choose_definitions(
    families: Sequence[EquationFamily],
    counts: Tally,
    uses: Tally,
    blocked: Mask,
    parameters: NDArray[np.float64] | None = None,
) -> list[Definitions]:
    """Return definitions that pay, none of which refers to another.

    Args:
        families: Families of the model.
        counts: Number of contributions to each row.
        uses: Number of member slots that refer to each variable.
        blocked: Variables that must stay.
        parameters: Values of the parameters if it is allowed to divide by them.
    """
    heavy = blocked.copy()
    for family in families:
        if size(family.template) > MAX_TEMPLATE:
            heavy[family.operands[variable_slots(family)].ravel()] = True
    choices: list[_Choice] = []
    for index, family in enumerate(families):
        ordinary: Mask | None = None
        among = variable_slots(family)
        constant = frozenset(range(len(family.kinds))).difference(among)
        for j in among:
            solved = solution(
                family.template, j, constant if parameters is not None else frozenset()
            )
            if solved is None:
                continue
            value, divisor = solved
            if ordinary is None:
                ordinary = counts[family.rows] == 1
            x = family.operands[j]
            others = len(among) - 1
            u = uses[x] - 1
            pays = (u * others - u - others - 1 <= MAX_FILL) & (
                (u - 1) * cost(value) <= MAX_REPEATED_COST
            )
            fits = pays & ordinary & ~heavy[x]
            if divisor.op != "const" and parameters is not None:
                fits &= _usable(divisor, family, parameters)
            members = np.flatnonzero(fits)
            if members.shape[0]:
                mean = float(u[members].mean())
                choices.append(
                    _Choice((mean, others, index, j), family, value, divisor, j, members)
                )
    choices.sort(key=lambda choice: choice.order)
    defined = np.zeros(uses.shape[0], dtype=np.bool_)
    referred = np.zeros(uses.shape[0], dtype=np.bool_)
    spent = np.zeros(counts.shape[0], dtype=np.bool_)
    chosen: list[Definitions] = []
    for choice in choices:
        members = _independent(choice, defined, referred, spent)
        if members.shape[0]:
            chosen.append(
                Definitions(choice.family, choice.template, choice.divisor, choice.slot, members)
            )
    return chosen


def _usable(divisor: Expr, family: EquationFamily, parameters: NDArray[np.float64]) -> Mask:
    """Return where a divisor is a normal, non-zero number."""

    def slot_values(key: object) -> NDArray[np.float64]:
        assert isinstance(key, int)
        values: NDArray[np.float64] = parameters[family.operands[key]]
        return values

    values = np.abs(evaluate(divisor, slot_values))
    return np.broadcast_to((values > TINY) & (values < 1.0 / TINY), (family.count,))


def _independent(choice: _Choice, defined: Mask, referred: Mask, spent: Mask) -> Ids:
    """Return the members that fit to what is chosen already, and mark them as chosen."""
    family = choice.family
    members: Ids = choice.members
    x: Ids = family.operands[choice.slot, members]
    free = ~(defined[x] | referred[x] | spent[family.rows[members]])
    others = [j for j in variable_slots(family) if j != choice.slot]
    for j in others:
        free &= ~defined[family.operands[j, members]]
    members = members[free]
    if members.shape[0] == 0:
        return members
    x = family.operands[choice.slot, members]
    _, first = np.unique(x, return_index=True)
    if first.shape[0] < members.shape[0]:
        members = members[np.sort(first)]
        x = family.operands[choice.slot, members]
    # In a chain x[k] = f(x[k-1]) of one family all links stay: uniform, and no growing terms.
    defined[x] = True
    conflict = np.zeros(members.shape[0], dtype=np.bool_)
    for j in others:
        conflict |= defined[family.operands[j, members]]
    if conflict.any():
        own = np.zeros_like(referred)
        for j in others:
            own[family.operands[j, members]] = True
        defined[x] = False
        stay = ~(conflict | own[x])
        members = members[stay]
        x = x[stay]
        defined[x] = True
    for j in others:
        referred[family.operands[j, members]] = True
    spent[family.rows[members]] = True
    return members


def put_in(
    families: Iterable[EquationFamily], definitions: Sequence[Definitions], n_variables: int
) -> tuple[EquationFamily, ...]:
    """Return the families with the defined variables replaced by their definitions."""
    which = np.zeros(n_variables, dtype=np.int32)
    member = np.zeros(n_variables, dtype=np.int64)
    for number, definition in enumerate(definitions, start=1):
        which[definition.variables] = number
        member[definition.variables] = definition.members
    result: list[EquationFamily] = []
    for family in families:
        hit = [j for j in variable_slots(family) if which[family.operands[j]].any()]
        if not hit:
            result.append(family)
            continue
        keys = [which[family.operands[j]] for j in hit]
        for members in partition(keys, [len(definitions) + 1] * len(hit)):
            part = take_members(family, members)
            pattern = [(j, int(key[members[0]])) for j, key in zip(hit, keys, strict=True)]
            pattern = [(j, number) for j, number in pattern if number]
            if pattern:
                result += _composed(part, pattern, definitions, member)
            else:
                result.append(part)
    return merge_families(result)


def _composed(
    family: EquationFamily,
    pattern: list[tuple[int, int]],
    definitions: Sequence[Definitions],
    member: Ids,
) -> list[EquationFamily]:
    """Return a family with the variables of some slots replaced by their definitions."""
    kinds: list[Operand] = list(family.kinds)
    operands = [family.operands]
    mapping: dict[Expr, Expr] = {}
    for j, number in pattern:
        definition = definitions[number - 1]
        source = definition.family
        mapping[slot(j)] = shifted(definition.template, len(kinds))
        kinds += source.kinds
        operands.append(source.operands[:, member[family.operands[j]]])
    template = tidied(substitute(family.template, mapping))
    everything = EquationFamily(
        template, tuple(kinds), np.concatenate(operands, axis=0), family.rows, family.origins
    )
    return split_duplicates(renumbered(everything, template))
