"""Expressions of annotations over time: evaluated with the trajectories of a result.

A value is an array whose last axis is time, of length ``nt``, or 1 if it is constant; the axes
before are those of the expression. Variables are interpolated to the times of the pictures first.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Span, fail
from acausal.diagnostics.suggest import nearest
from acausal.results.result import Result
from acausal.syntax import tree

Array = NDArray[np.float64]
#: Structural parameters of the component at a path, by name.
Structural = Callable[[str], Mapping[str, Array]]

_FUNCTIONS: dict[str, Callable[..., Array]] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos,
    "atan": np.arctan, "atan2": np.arctan2, "sqrt": np.sqrt, "exp": np.exp, "log": np.log,
    "abs": np.abs, "sign": np.sign, "floor": np.floor, "ceil": np.ceil, "mod": np.mod,
    "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh,
}  # fmt: skip
_CONSTANTS = {"constants.pi": np.pi, "pi": np.pi, "constants.g_n": 9.80665}
_COMPARISONS: dict[str, Callable[[Array, Array], NDArray[np.bool_]]] = {
    "<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal,
    "==": np.equal, "<>": np.not_equal, "!=": np.not_equal,
}  # fmt: skip


@dataclass(frozen=True)
class Place:
    """A point over time, with axes if it is a frame.

    Attributes:
        position: Shape ``(d, nt)`` or ``(d, 1)`` with ``d`` 1, 2 or 3; metres.
        angle: Angle of a planar frame, shape ``(nt,)`` or ``(1,)``; radians.
        axes: Axes of a frame in space, ``axes[i]`` the i-th one seen from the world, shape
            ``(3, 3, nt)``.
    """

    position: Array
    angle: Array | None = None
    axes: Array | None = None

    @property
    def dimension(self) -> int:
        """1 along a line, 2 in the plane, 3 in space."""
        return len(self.position)


class Values:
    """Variables and parameters of one result at the times of the pictures.

    Args:
        result: The result.
        times: Seconds, shape ``(nt,)``.
        structural: Structural parameters of components, if the model is known.
    """

    def __init__(self, result: Result, times: Array, structural: Structural | None = None) -> None:
        self.result = result
        self.times = times
        self.structural = structural
        self._known: dict[str, Array | None] = {}
        self._parameters: dict[str, list[str]] | None = None
        stored = result.times
        if len(stored) > 1:
            left = np.searchsorted(stored, times, side="right") - 1
            self._left = np.clip(left, 0, len(stored) - 2)
            width = stored[self._left + 1] - stored[self._left]
            part = (times - stored[self._left]) / np.where(width > 0, width, 1.0)
            self._part = np.clip(np.where(width > 0, part, 1.0), 0.0, 1.0)

    def find(self, path: str) -> Array | None:
        """Return the value of a variable or parameter, an array if the path lacks subscripts."""
        if path not in self._known:
            self._known[path] = self._find(path)
        return self._known[path]

    def _find(self, path: str) -> Array | None:
        if path == "time":
            return self.times
        if path in _CONSTANTS:
            return np.array([_CONSTANTS[path]])
        found = self.result.variables.find(path)
        # A path finds its own array only, nothing below it.
        found = [name for name in found if name == path or name.startswith(f"{path}[")]
        if found:
            values = self.at_times(self.result.variables.many(found)).T
            return _shaped(path, found, values)
        if self._parameters is None:
            self._parameters = {}
            for name in self.result.parameters:
                self._parameters.setdefault(_base(name), []).append(name)
                if name.endswith("]"):
                    self._parameters.setdefault(name, [name])
        names = self._parameters.get(path, [])
        if names:
            numbers = np.array([[float(self.result.parameters[name])] for name in names])
            return _shaped(path, names, numbers)
        if self.structural is not None:
            owner, _, name = path.rpartition(".")
            return self.structural(owner).get(name)
        return None

    def at_times(self, values: Array) -> Array:
        """Return stored values at the times of the pictures, along the first axis."""
        if len(self.result.times) < 2:
            return np.repeat(values[:1], len(self.times), axis=0)
        part = self._part[:, None]
        return np.asarray(values[self._left] * (1 - part) + values[self._left + 1] * part)

    def place(self, expression: tree.Expression, prefix: str, loop: Mapping[str, int]) -> Place:
        """Return the point or frame that an expression means in the component ``prefix``.

        Raises:
            AcausalError: ``D113`` if it is none.
        """
        if isinstance(expression, tree.Reference):
            path = self.path(expression, prefix, loop)
            position = self.find(f"{path}.r_0")
            if position is not None and len(position) == 3:
                axes = self.find(f"{path}.R.T")
                return Place(position, None, None if axes is None else orthonormal(axes))
            x, y = self.find(f"{path}.x"), self.find(f"{path}.y")
            if x is not None and y is not None and x.ndim == y.ndim == 1:
                return Place(stacked([x, y]), self.find(f"{path}.phi"))
            s = self.find(f"{path}.s")
            if s is not None and s.ndim == 1:
                return Place(s[None])
            phi = self.find(f"{path}.phi")
            if phi is not None and phi.ndim == 1:
                return Place(np.zeros((1, 1)), phi)
        value = self.evaluate(expression, prefix, loop)
        if value.ndim == 1:
            return Place(value[None])
        if value.ndim != 2 or len(value) not in (2, 3):
            fail("D113", "this is no point", expression.span,
                 help="name a frame, hinge or flange, or write {x, y} or {x, y, z}")  # fmt: skip
        return Place(value)

    def path(self, reference: tree.Reference, prefix: str, loop: Mapping[str, int]) -> str:
        """Return the path of a reference with its subscripts as numbers."""
        parts = []
        for part in reference.parts:
            text = part.name
            if part.subscripts:
                numbers = [self.evaluate(s, prefix, loop) for s in part.subscripts]
                if any(n.shape != (1,) for n in numbers):
                    fail("D113", "a subscript of a shape has to be a constant number",
                         part.span, help="write frame[1], or {... for k in 1:3}")  # fmt: skip
                text += "[" + ",".join(str(round(float(n[0]))) for n in numbers) + "]"
            parts.append(text)
        return (f"{prefix}." if prefix else "") + ".".join(parts)

    def evaluate(
        self, expression: tree.Expression, prefix: str = "", loop: Mapping[str, int] | None = None
    ) -> Array:
        """Return the value of an expression in the component ``prefix``.

        Raises:
            AcausalError: ``D113`` for unknown names and what cannot be evaluated.
        """
        loop = {} if loop is None else loop

        def value(node: tree.Expression) -> Array:
            match node:
                case tree.NumberLiteral():
                    return np.array([_si(node)])
                case tree.BooleanLiteral():
                    return np.array([float(node.value)])
                case tree.Reference():
                    return reference(node)
                case tree.Unary():
                    inner = value(node.operand)
                    return -inner if node.operator == "-" else inner if node.operator == "+" \
                        else 1.0 - inner  # fmt: skip
                case tree.Binary():
                    return _binary(node, value(node.left), value(node.right))
                case tree.IfExpression():
                    result = value(node.otherwise)
                    for condition, branch in reversed(node.branches):
                        result = np.where(value(condition) > 0.5, value(branch), result)
                    return result
                case tree.ArrayLiteral():
                    return stacked([value(element) for element in node.elements])
                case tree.Call():
                    return call(node)
                case _:
                    _unknown(node.span, "this cannot be evaluated in an animation")

        def reference(node: tree.Reference) -> Array:
            if len(node.parts) == 1 and node.parts[0].name in loop:
                return np.array([float(loop[node.parts[0].name])])
            path = self.path(node, prefix, loop)
            found = self.find(path)
            if found is None:
                found = self.find(str(node)) if str(node) in _CONSTANTS else None
            if found is None:
                near = self.result.variables.suggestions(path)[:3]
                near = near or nearest(path, list(self.result.parameters))[:3]
                fail("D113", f"there is no variable or parameter {path}", node.span,
                     notes=[f"did you mean {' or '.join(near)}?"] if near else [],
                     help="shapes are made of variables and parameters of the component; if not "
                     "all variables were kept, simulate without a choice of them")  # fmt: skip
            return found

        def call(node: tree.Call) -> Array:
            name = str(node.function)
            if name == "der" and len(node.arguments) == 1:
                inner = node.arguments[0]
                if isinstance(inner, tree.Reference):
                    found = self.find(f"der({self.path(inner, prefix, loop)})")
                    if found is not None:
                        return found
            arguments = [value(argument) for argument in node.arguments]
            if name in ("min", "max"):
                across = np.minimum if name == "min" else np.maximum
                flat = list(arguments[0]) if len(arguments) == 1 else arguments
                result = flat[0]
                for other in flat[1:]:
                    result = across(result, other)
                return result
            if name not in _FUNCTIONS:
                _unknown(node.span, f"an animation does not know the function {name}")
            with np.errstate(all="ignore"):
                return np.asarray(_FUNCTIONS[name](*arguments), dtype=np.float64)

        return value(expression)


def _unknown(span: Span, message: str) -> NoReturn:
    fail("D113", message, span,
         help="shapes may use numbers, variables, + - * / ^, if, comparisons, sin, cos, sqrt, "
         "min, max and their like")  # fmt: skip


def _si(node: tree.NumberLiteral) -> float:
    if node.unit is None:
        return node.value
    from acausal.units import parse_unit

    return node.value * parse_unit(node.unit).factor


def _binary(node: tree.Binary, left: Array, right: Array) -> Array:
    operator = node.operator.removeprefix(".") if len(node.operator) == 2 else node.operator
    if node.operator in _COMPARISONS:
        return _COMPARISONS[node.operator](left, right).astype(np.float64)
    with np.errstate(all="ignore"):
        match operator:
            case "+":
                return left + right
            case "-":
                return left - right
            case "*" if left.ndim == 2 and right.ndim == 2 and node.operator == "*":
                return np.asarray((left * right).sum(axis=0))
            case "*":
                return left * right
            case "/":
                return left / right
            case "^":
                return np.asarray(left**right)
            case "and":
                return np.minimum(left, right)
            case "or":
                return np.maximum(left, right)
    _unknown(node.span, f"an animation does not know the operator {node.operator}")


def stacked(parts: list[Array]) -> Array:
    """Return components as one array, constants repeated if one of them is none."""
    length = max(part.shape[-1] for part in parts)
    return np.stack([np.broadcast_to(p, (*p.shape[:-1], length)) for p in parts])


def orthonormal(axes: Array) -> Array:
    """Return axes that interpolation has bent a little as right angles and unit lengths again."""
    x = axes[0] / np.maximum(np.sqrt((axes[0] ** 2).sum(axis=0)), 1e-300)
    y = axes[1] - (axes[1] * x).sum(axis=0) * x
    y = y / np.maximum(np.sqrt((y**2).sum(axis=0)), 1e-300)
    return np.stack([x, y, np.cross(x, y, axis=0)])


def _base(name: str) -> str:
    return name[: name.rindex("[")] if name.endswith("]") else name


def _shaped(path: str, names: list[str], values: Array) -> Array:
    """Return the rows of ``values`` as the array that the subscripts of their names tell."""
    if names == [path]:
        return np.asarray(values[0])
    last = names[-1][len(path) :].strip("[]").split(",")
    shape = tuple(int(n) for n in last if n.isdecimal())
    if int(np.prod(shape)) != len(names):
        return values
    return values.reshape(*shape, values.shape[-1])
