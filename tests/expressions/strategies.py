"""Random expressions whose values stay moderate, for property tests."""

from __future__ import annotations

from hypothesis import strategies as st

from acausal.expressions.build import (
    add,
    and_,
    call,
    div,
    homotopy,
    if_,
    mul,
    neg,
    noevent,
    not_,
    or_,
    power,
    relation,
    smooth,
    sub,
)
from acausal.expressions.nodes import ONE, TIME, Expr, const, slot

_TWO = const(2.0)


def _square_plus_one(x: Expr) -> Expr:
    return add(ONE, power(x, _TWO))


def _bounded(x: Expr) -> Expr:
    return mul(const(0.9), call("tanh", x))


def _extend(inner: st.SearchStrategy[Expr]) -> st.SearchStrategy[Expr]:
    """Operations on ``inner`` with arguments kept inside the domain of each function."""
    relations = st.sampled_from(("lt", "le", "gt", "ge"))
    conditions = st.builds(relation, relations, inner, inner)
    conditions = st.one_of(
        conditions,
        st.builds(and_, conditions, conditions),
        st.builds(or_, conditions, st.builds(not_, conditions)),
    )
    entire = ("sin", "cos", "atan", "tanh", "abs")
    return st.one_of(
        st.builds(add, inner, inner),
        st.builds(sub, inner, inner),
        st.builds(mul, inner, inner),
        st.builds(neg, inner),
        st.builds(lambda a, b: div(a, _square_plus_one(b)), inner, inner),
        st.builds(lambda a, n: power(a, const(n)), inner, st.sampled_from((2.0, 3.0))),
        st.builds(
            lambda a, p: power(_square_plus_one(a), const(p)),
            inner,
            st.sampled_from((-2.0, -1.0, -0.5, 0.5, 0.75)),
        ),
        st.builds(lambda a, b: power(_square_plus_one(a), _bounded(b)), inner, inner),
        st.builds(call, st.sampled_from(entire), inner),
        st.builds(
            lambda f, a: call(f, _bounded(a)),
            st.sampled_from(("asin", "acos", "exp", "sinh", "cosh", "tan")),
            inner,
        ),
        st.builds(
            lambda f, a: call(f, _square_plus_one(a)),
            st.sampled_from(("sqrt", "log", "log10")),
            inner,
        ),
        st.builds(lambda a, b: call("atan2", a, _square_plus_one(b)), inner, inner),
        st.builds(call, st.sampled_from(("min", "max")), inner, inner),
        st.builds(if_, conditions, inner, inner),
        st.builds(noevent, inner),
        st.builds(lambda a: smooth(1, a), inner),
        st.builds(homotopy, inner, inner),
    )


def expressions(slot_count: int = 3, max_leaves: int = 12) -> st.SearchStrategy[Expr]:
    """Random expressions over the slots ``0 .. slot_count-1``, constants and time."""
    leaves = st.one_of(
        st.builds(slot, st.integers(0, slot_count - 1)),
        st.builds(const, st.sampled_from((-1.5, -1.0, 0.5, 2.0, 3.0))),
        st.just(TIME),
    )
    return st.recursive(leaves, _extend, max_leaves=max_leaves)
