"""Expressions as flat records, for caches: pickling the nodes themselves would recurse."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

from acausal.expressions.nodes import Expr, node
from acausal.expressions.traverse import postorder

#: Operator, payload and the numbers of the records that are the arguments.
Record = tuple[str, Hashable, tuple[int, ...]]


def to_records(*roots: Expr) -> tuple[tuple[Record, ...], tuple[int, ...]]:
    """Return the nodes below ``roots``, arguments first, and the number of each root."""
    order = postorder(*roots)
    number = {item: position for position, item in enumerate(order)}
    records = tuple((item.op, item.value, tuple([number[a] for a in item.args])) for item in order)
    return records, tuple(number[root] for root in roots)


def from_records(records: Sequence[Record], roots: Sequence[int]) -> tuple[Expr, ...]:
    """Return the expressions of which ``to_records`` made ``records`` and ``roots``."""
    nodes: list[Expr] = []
    for op, value, args in records:
        nodes.append(node(op, tuple([nodes[a] for a in args]), value))
    return tuple(nodes[root] for root in roots)
