"""Expressions over loop indices, evaluated for all passes of the loops at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from acausal.expressions.build import number_of
from acausal.expressions.evaluate import evaluate
from acausal.expressions.nodes import Expr, const, slot
from acausal.expressions.traverse import postorder, slot_nodes, slots, substitute
from acausal.instantiation.template import Domain, LoopIndex, Ref, Signal, Step, TableEntry, Unset


def only_loops(expr: Expr) -> bool:
    """Tell whether an expression has the same value for every instance at every time."""
    stack, seen = [expr], set()
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        if node.op == "time" or (
            node.op == "slot" and isinstance(node.value, (Ref, Signal, Unset))
        ):
            return False
        stack += node.args
    return True


def has_loops(expr: Expr) -> bool:
    """Tell whether an expression depends on a loop index."""
    return any(isinstance(s, (LoopIndex, TableEntry)) for s in slots(expr))


def loop_names(*exprs: Expr) -> set[str]:
    """Return the names of all loop indices in expressions, those in subscripts included."""
    found: set[str] = set()
    stack = list(exprs)
    while stack:
        for payload in slots(stack.pop()):
            if isinstance(payload, LoopIndex):
                found.add(payload.name)
            elif isinstance(payload, TableEntry):
                stack += payload.index
            elif isinstance(payload, Ref):
                stack += payload.index
                stack += (i for step in payload.path for i in step.index)
    return found


def at_pass(expr: Expr, domain: Domain, k: int) -> Expr:
    """Return an expression with the values that the loop indices have in pass ``k``."""
    numbers = {
        LoopIndex(n): const(float(v))
        for n, v in zip(domain.names, domain.values[:, k], strict=True)
    }
    return _placed(expr, numbers)


def _placed(expr: Expr, numbers: dict[LoopIndex, Expr]) -> Expr:
    mapping: dict[Expr, Expr] = {}
    for part in slot_nodes(expr):
        payload = part.value
        if isinstance(payload, LoopIndex) and payload in numbers:
            mapping[part] = numbers[payload]
        elif isinstance(payload, TableEntry):
            index = tuple(_placed(i, numbers) for i in payload.index)
            if all(i.op == "const" for i in index):
                places = tuple(int(number_of(i)) - 1 for i in index)
                mapping[part] = const(float(payload.array()[places]))
            else:
                mapping[part] = slot(replace(payload, index=index))
        elif isinstance(payload, Ref):
            path = tuple(
                Step(s.name, tuple(_placed(i, numbers) for i in s.index)) for s in payload.path
            )
            index = tuple(_placed(i, numbers) for i in payload.index)
            mapping[part] = slot(replace(payload, path=path, index=index))
    return substitute(expr, mapping)


def over(domain: Domain, expr: Expr) -> NDArray[np.float64]:
    """Return the values of an expression over loop indices, shape ``(domain.length,)``.

    Raises:
        IndexError: If a subscript of a constant array is out of range.
    """
    if expr.op == "const":
        return np.full(domain.length, number_of(expr))
    values: dict[object, NDArray[np.float64]] = {}
    for payload in slots(expr):
        if isinstance(payload, LoopIndex):
            values[payload] = domain.values[domain.names.index(payload.name)]
        else:
            assert isinstance(payload, TableEntry)
            places = tuple(
                checked(over(domain, i), n)
                for i, n in zip(payload.index, payload.shape, strict=True)
            )
            values[payload] = payload.array()[places]
    return np.broadcast_to(evaluate(expr, values, 0.0), (domain.length,))


def split_by_indices(domain: Domain, expr: Expr) -> list[tuple[Domain, Expr]]:
    """Split the passes of loops where a condition on loop indices selects between expressions.

    A branch then is there only for the passes that take it, and its subscripts need be valid
    only for those. Passes without any are left out.
    """
    result: list[tuple[Domain, Expr]] = []
    stack = [(domain, expr)]
    while stack:
        passes, whole = stack.pop()
        choice = _choice(whole) if passes.names else None
        if choice is None:
            if passes.length:
                result.append((passes, whole))
            continue
        holds = over(passes, choice.args[0]) != 0.0
        for mask, branch in ((~holds, choice.args[2]), (holds, choice.args[1])):
            if mask.any():
                stack.append((passes.where(mask), substitute(whole, {choice: branch})))
    return result


def _choice(expr: Expr) -> Expr | None:
    for part in postorder(expr):
        if part.op == "if" and part.args[0].op != "const" and only_loops(part.args[0]):
            return part
    return None


def checked(subscripts: NDArray[np.float64], n: int) -> NDArray[np.int64]:
    """Return subscripts from 1 as positions from 0.

    Raises:
        IndexError: If one is outside ``1..n``; its arguments are the subscript and ``n``.
    """
    places = subscripts.astype(np.int64)
    if places.size and (places.min() < 1 or places.max() > n):
        bad = places.min() if places.min() < 1 else places.max()
        raise IndexError(int(bad), n)
    return places - 1
