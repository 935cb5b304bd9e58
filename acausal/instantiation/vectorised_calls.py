"""Calls of functions with arrays where single values are declared (Modelica 3.6, section 12.4.6).

``f({1, 2, 3})`` with a scalar input is ``{f(1), f(2), f(3)}``; arguments without further dimensions
are the same in every call.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from acausal.diagnostics import fail
from acausal.expressions.nodes import ONE
from acausal.instantiation.functions import inline
from acausal.instantiation.merge import merge, primitive_type, type_of
from acausal.instantiation.values import LITERAL, Index, Value, scalar, table
from acausal.modeling.classes import ClassDef
from acausal.syntax import tree

if TYPE_CHECKING:
    from acausal.instantiation.environment import ClassEnvironment


def call_function(
    function: ClassDef, call: tree.Call, given: list[Value], named: dict[str, Value],
    outside: ClassEnvironment, depth: int,
) -> list[Value]:  # fmt: skip
    """Return the outputs of a call, of arrays of calls if arguments ask for it.

    Args:
        function: The function.
        call: The call, for messages.
        given: Positional arguments.
        named: Named arguments.
        outside: Environment for constants and functions, with the function as scope.
        depth: How deep calls are nested.

    Raises:
        AcausalError: ``T104`` if two arguments ask for arrays of different size; else as the
            call itself.
    """
    declared = _dimensions(function)
    names = list(declared)
    if len(given) > len(names):
        return inline(function, call, given, named, outside, depth)  # which refuses it
    arguments = [*zip(names, given, strict=False), *named.items()]
    shapes: dict[tuple[int, ...], None] = {}
    further: dict[str, int] = {}
    for name, value in arguments:
        extra = len(value.shape) - declared.get(name, len(value.shape))
        if extra > 0:
            further[name] = extra
            shapes[value.shape[:extra]] = None
    if not further:
        return inline(function, call, given, named, outside, depth)
    if len(shapes) > 1:
        sizes = " and ".join(str(list(s)) for s in shapes)
        fail("T104", f"the arguments of {function.name} ask for {sizes} calls", call.span,
             help="give arrays of the same size, or single values")  # fmt: skip
    (shape,) = shapes
    if 0 in shape:
        return [table(np.zeros(shape), "Real", LITERAL)]
    n = len(shape)
    known: dict[Index, list[Value]] = {}

    def at(index: Index) -> list[Value]:
        if index not in known:
            own = {k: _part(v, index) if k in further else v for k, v in arguments}
            known[index] = inline(function, call, [], own, outside, depth)
        return known[index]

    def output(k: int, first: Value) -> Value:
        return Value(first.type, shape + first.shape, lambda i: at(i[:n])[k].get(i[n:]),
                     first.unit, enumeration=first.enumeration)  # fmt: skip

    return [output(k, first) for k, first in enumerate(at((ONE,) * n))]


def _dimensions(function: ClassDef) -> dict[str, int]:
    """Return the number of dimensions of each input, in order."""
    result: dict[str, int] = {}
    for name, element in merge(function).elements.items():
        if element.has("input"):
            kind = primitive_type(type_of(element))
            own = len(kind.dimensions) if kind is not None else 0
            result[name] = len(element.declaration.dimensions) + own
    return result


def _part(value: Value, index: Index) -> Value:
    rest = value.shape[len(index) :]
    if not rest:
        return scalar(value.get(index), value.type, value.unit, value.enumeration)
    return Value(value.type, rest, lambda i: value.get((*index, *i)), value.unit)
