"""Subscripts: elements and slices of arrays."""

from __future__ import annotations

import itertools

import numpy as np

from acausal.diagnostics import Span, fail
from acausal.expressions.nodes import Expr
from acausal.instantiation.arrays import LONGEST_REDUCTION, shape_text
from acausal.instantiation.expressions import EndEnvironment, Environment, elaborate
from acausal.instantiation.selection import chosen
from acausal.instantiation.values import LITERAL, Index, Value, constants, table
from acausal.syntax import tree
from acausal.syntax.formatter import format_expression


def subscripted(value: Value, subscripts: tuple[tree.Expression, ...], env: Environment,
                span: Span) -> Value:  # fmt: skip
    """Return elements or a slice of an array.

    Raises:
        AcausalError: ``T113`` for too many subscripts, ``T114`` for one out of range.
    """
    if not subscripts:
        return value
    if len(subscripts) > len(value.shape):
        fail("T113", f"{len(subscripts)} subscripts for {shape_text(value.shape)}", span,
             help="give at most one subscript for each dimension")  # fmt: skip
    axes = [axis(s, n, env) for s, n in itertools.zip_longest(subscripts, value.shape)]
    shape = tuple(a.size for a in axes if a.shape)

    def get(index: Index) -> Expr:
        free = iter(index)
        full = tuple(a.get((next(free),)) if a.shape else a.expr for a in axes)
        return chosen(value.get, full, value.shape)

    if not shape:
        return Value(value.type, (), lambda _: get(()), value.unit, value.text,
                     value.fields, value.enumeration)  # fmt: skip
    return Value(value.type, shape, get, value.unit, enumeration=value.enumeration)


def axis(subscript: tree.Expression | None, n: int, env: Environment) -> Value:
    """Return a subscript as a scalar or a vector of positions along a dimension of size ``n``.

    Raises:
        AcausalError: ``T114`` if a constant position is out of range, ``T115`` if it is no
            Integer.
    """
    if subscript is None or isinstance(subscript, tree.Colon):
        return Value("Integer", (n,), lambda index: index[0], LITERAL)
    value = elaborate(subscript, EndEnvironment(env, n))
    if value.type == "Boolean" and value.shape == (n,):
        mask = constants(value)
        if mask is not None:
            return table(np.flatnonzero(mask).astype(np.float64) + 1.0, "Integer", LITERAL)
    if value.type not in ("Integer", "enumeration") or len(value.shape) > 1:
        fail("T115", f"{format_expression(subscript)} is not an Integer", subscript.span,
             help="subscripts are whole numbers from 1")  # fmt: skip
    small = value.size <= LONGEST_REDUCTION
    fixed = constants(value) if small or value.numbers is not None else None
    if fixed is not None and fixed.size and (fixed.min() < 1 or fixed.max() > n):
        bad = fixed.min() if fixed.min() < 1 else fixed.max()
        fail("T114", f"subscript {int(bad)} is outside 1..{n}", subscript.span,
             help=f"the array has {n} elements here")  # fmt: skip
    return value
