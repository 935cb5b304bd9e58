"""Elements of arrays by subscripts that change during the simulation."""

from __future__ import annotations

from collections.abc import Callable

from acausal.diagnostics import fail
from acausal.expressions import build
from acausal.expressions.nodes import Expr, const
from acausal.instantiation.arrays import LONGEST_REDUCTION
from acausal.instantiation.domain import only_loops
from acausal.instantiation.values import Index


def chosen(element: Callable[[Index], Expr], index: Index, shape: tuple[int, ...]) -> Expr:
    """Return ``element(index)`` where subscripts may be variables: a choice among all elements.

    Args:
        element: From subscripts over loop indices to an element.
        index: The subscripts.
        shape: Sizes of the dimensions.

    Raises:
        AcausalError: ``T107`` for a choice among very many.
    """
    for k, expr in enumerate(index):
        if expr.op == "const" or only_loops(expr):
            continue
        if shape[k] > LONGEST_REDUCTION:
            fail("T107", f"a choice among {shape[k]} elements in one expression is too long",
                 help="use a table or an interpolation")  # fmt: skip
        result: Expr | None = None
        for i in range(shape[k], 0, -1):
            number = const(float(i))
            own = chosen(element, (*index[:k], number, *index[k + 1 :]), shape)
            here = build.relation("eq", expr, number)
            result = own if result is None else build.if_(here, own, result)
        assert result is not None
        return result
    return element(index)
