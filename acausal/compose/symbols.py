"""Symbolic expressions: what Python's operators make of variables and parameters.

Nothing is computed here. An expression becomes syntax (:mod:`acausal.syntax.tree`) when the model
it belongs to is compiled, as only then the path from the model to its variables is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NoReturn, Protocol

from acausal.compose.places import here
from acausal.diagnostics import Span, fail
from acausal.syntax import tree

if TYPE_CHECKING:
    from acausal.compose.parts import Part

#: Deeper expressions are refused; every level is a level of recursion later on.
DEEPEST = 150


class Scope(Protocol):
    """The class that syntax is made for."""

    def path(self, part: Part, span: Span) -> list[str]:
        """Return the names that lead from the class to a part."""

    def class_reference(self, what: object, span: Span) -> tree.Reference:
        """Return how a class is called in the text."""


class Symbolic:
    """Anything that stands for a value that is not known yet."""

    __slots__ = ()
    __hash__ = object.__hash__

    #: Array dimensions, as far as known.
    @property
    def _ndim(self) -> int:
        return 0

    @property
    def _depth(self) -> int:
        return 0

    def _tree(self, scope: Scope, span: Span) -> tree.Expression:
        raise NotImplementedError

    # --- arithmetic ----------------------------------------------------------------------

    def __add__(self, other: Any) -> Symbolic:
        return binary("+", self, other)

    def __radd__(self, other: Any) -> Symbolic:
        # The built-in sum starts from 0.
        if isinstance(other, int) and other == 0:
            return self
        return binary("+", other, self)

    def __sub__(self, other: Any) -> Symbolic:
        return binary("-", self, other)

    def __rsub__(self, other: Any) -> Symbolic:
        return binary("-", other, self)

    def __mul__(self, other: Any) -> Symbolic:
        return binary("*", self, other)

    def __rmul__(self, other: Any) -> Symbolic:
        return binary("*", other, self)

    def __truediv__(self, other: Any) -> Symbolic:
        return binary("/", self, other)

    def __rtruediv__(self, other: Any) -> Symbolic:
        return binary("/", other, self)

    def __pow__(self, other: Any) -> Symbolic:
        return binary("^", self, other)

    def __rpow__(self, other: Any) -> Symbolic:
        return binary("^", other, self)

    def __matmul__(self, other: Any) -> Symbolic:
        return binary("@", self, other)

    def __rmatmul__(self, other: Any) -> Symbolic:
        return binary("@", other, self)

    def __mod__(self, other: Any) -> Symbolic:
        return called("mod", self, other)

    def __rmod__(self, other: Any) -> Symbolic:
        return called("mod", other, self)

    def __floordiv__(self, other: Any) -> Symbolic:
        return called("floor", binary("/", self, other))

    def __rfloordiv__(self, other: Any) -> Symbolic:
        return called("floor", binary("/", other, self))

    def __neg__(self) -> Symbolic:
        return Operation("-", (self,), here())

    def __pos__(self) -> Symbolic:
        return self

    def __abs__(self) -> Symbolic:
        return called("abs", self)

    # --- relations and logic ---------------------------------------------------------------

    def __eq__(self, other: object) -> Any:
        span = here()
        return Equality("==", (self, operand(other, span)), span)

    def __ne__(self, other: object) -> Any:
        return binary("<>", self, other)

    def __lt__(self, other: Any) -> Symbolic:
        return binary("<", self, other)

    def __le__(self, other: Any) -> Symbolic:
        return binary("<=", self, other)

    def __gt__(self, other: Any) -> Symbolic:
        return binary(">", self, other)

    def __ge__(self, other: Any) -> Symbolic:
        return binary(">=", self, other)

    def __and__(self, other: Any) -> Symbolic:
        return binary("and", self, other)

    def __rand__(self, other: Any) -> Symbolic:
        return binary("and", other, self)

    def __or__(self, other: Any) -> Symbolic:
        return binary("or", self, other)

    def __ror__(self, other: Any) -> Symbolic:
        return binary("or", other, self)

    def __invert__(self) -> Symbolic:
        return Operation("not", (self,), here())

    # --- what Python asks and nobody can answer --------------------------------------------

    def __bool__(self) -> bool:
        fail(
            "T150",
            f"whether {self!r} is true is not known in Python",
            here(),
            label="decided here, but its value changes during the simulation",
            help="write ac.where(condition, a, b) for a choice, & | ~ for and, or, not, "
            "and ac.if_then or ac.when for equations; a chain a < b < c is (a < b) & (b < c)",
        )

    def _no_number(self) -> NoReturn:
        fail(
            "T151",
            f"{self!r} has no number in Python",
            here(),
            help="use the functions of acausal, such as ac.sin and ac.exp, in equations; "
            "values are in the result of a simulation",
        )

    def __float__(self) -> float:
        self._no_number()

    def __int__(self) -> int:
        self._no_number()

    def __complex__(self) -> complex:
        self._no_number()

    def __index__(self) -> int:
        self._no_number()

    def __iter__(self) -> Any:
        fail("T113", f"{self!r} is no array, or its size is not known in Python", here(),
             help="equate whole arrays, or give the size as a number")  # fmt: skip

    def __repr__(self) -> str:
        from acausal.compose.wording import words

        return words(self)

    # NumPy's scalars and arrays on the left, and its functions.
    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        if method != "__call__" or options or ufunc.__name__ not in _UFUNCS:
            fail("T152", f"numpy.{ufunc.__name__} has no meaning for {self!r}", here(),
                 help="use the functions of acausal, such as ac.sin")  # fmt: skip
        name = _UFUNCS[ufunc.__name__]
        if name == "==":
            span = here()
            left, right = (operand(x, span) for x in inputs)
            return Equality("==", (left, right), span)
        if name == "-1":
            return -inputs[0]
        if name[0].isalpha() and name not in ("and", "or", "not"):
            return called(name, *inputs)
        return ~inputs[0] if name == "not" else binary(name, *inputs)


_UFUNCS = {
    "add": "+", "subtract": "-", "multiply": "*", "divide": "/", "true_divide": "/", "power": "^",
    "float_power": "^", "matmul": "@", "negative": "-1", "equal": "==", "not_equal": "<>",
    "less": "<", "less_equal": "<=", "greater": ">", "greater_equal": ">=", "logical_and": "and",
    "logical_or": "or", "logical_not": "not", "bitwise_and": "and", "bitwise_or": "or",
    "invert": "not", "absolute": "abs", "fabs": "abs", "sign": "sign", "sqrt": "sqrt", "exp": "exp",
    "log": "log", "log10": "log10", "sin": "sin", "cos": "cos", "tan": "tan", "arcsin": "asin",
    "arccos": "acos", "arctan": "atan", "arctan2": "atan2", "sinh": "sinh", "cosh": "cosh",
    "tanh": "tanh", "floor": "floor", "ceil": "ceil", "maximum": "max", "minimum": "min",
    "mod": "mod", "remainder": "mod",
}  # fmt: skip


class Literal(Symbolic):
    """Syntax that refers to nothing: numbers, texts, arrays of numbers."""

    __slots__ = ("_dimensions", "_node")

    def __init__(self, node: tree.Expression, dimensions: int = 0) -> None:
        self._node = node
        self._dimensions = dimensions

    @property
    def _ndim(self) -> int:
        return self._dimensions

    def _tree(self, scope: Scope, span: Span) -> tree.Expression:
        return self._node


class Operation(Symbolic):
    """An operator with one or two operands."""

    __slots__ = ("_arguments", "_depth_", "_operator", "_span")

    def __init__(self, operator: str, arguments: tuple[Symbolic, ...], span: Span) -> None:
        self._operator = operator
        self._arguments = arguments
        self._span = span
        self._depth_ = deeper(arguments, span)

    @property
    def _depth(self) -> int:
        return self._depth_

    @property
    def _ndim(self) -> int:
        if self._operator == "@":
            return max(0, sum(a._ndim for a in self._arguments) - 2)
        return max(a._ndim for a in self._arguments)

    def _tree(self, scope: Scope, span: Span) -> tree.Expression:
        span = self._span
        found = [a._tree(scope, span) for a in self._arguments]
        if len(found) == 1:
            return tree.Unary(span, self._operator, found[0])
        sizes = [a._ndim for a in self._arguments]
        return tree.Binary(span, written(self._operator, *sizes), found[0], found[1])


class Equality(Operation):
    """``left == right``: an equation where one is wanted, else a relation."""

    __slots__ = ()

    def _equation(self, scope: Scope, description: str = "") -> tree.SimpleEquation:
        left, right = self._arguments
        span = self._span
        return tree.SimpleEquation(
            span, description, left._tree(scope, span), right._tree(scope, span)
        )


def written(operator: str, left: int, right: int) -> str:
    """Return the operator of the language that acts as NumPy's does: element by element."""
    if operator == "@":
        return "*"
    if operator in ("+", "-") and left != right:
        return "." + operator
    if operator == "*" and left and right:
        return ".*"
    if operator == "/" and right:
        return "./"
    if operator == "^" and (left or right):
        return ".^"
    return operator


class Invocation(Symbolic):
    """A function call; the function is a name or a class of the library."""

    __slots__ = ("_arguments", "_depth_", "_dimensions", "_function", "_named", "_span")

    def __init__(
        self,
        function: object,
        arguments: tuple[Symbolic, ...],
        span: Span,
        named: Sequence[tuple[str, Symbolic]] = (),
        dimensions: int = 0,
    ) -> None:
        self._function = function
        self._arguments = arguments
        self._named = tuple(named)
        self._span = span
        self._dimensions = dimensions
        self._depth_ = deeper((*arguments, *(value for _, value in named)), span)

    @property
    def _depth(self) -> int:
        return self._depth_

    @property
    def _ndim(self) -> int:
        return self._dimensions

    def _tree(self, scope: Scope, span: Span) -> tree.Call:
        span = self._span
        name = (
            tree.Reference(span, (tree.NamePart(span, self._function),))
            if isinstance(self._function, str)
            else scope.class_reference(self._function, span)
        )
        return tree.Call(
            span,
            name,
            tuple(a._tree(scope, span) for a in self._arguments),
            tuple(tree.NamedArgument(span, n, v._tree(scope, span)) for n, v in self._named),
        )


class Choice(Symbolic):
    """``if condition then a else b``."""

    __slots__ = ("_condition", "_depth_", "_first", "_second", "_span")

    def __init__(self, condition: Symbolic, first: Symbolic, second: Symbolic, span: Span) -> None:
        self._condition = condition
        self._first = first
        self._second = second
        self._span = span
        self._depth_ = deeper((condition, first, second), span)

    @property
    def _depth(self) -> int:
        return self._depth_

    @property
    def _ndim(self) -> int:
        return max(self._first._ndim, self._second._ndim)

    def _tree(self, scope: Scope, span: Span) -> tree.Expression:
        span = self._span
        branch = (self._condition._tree(scope, span), self._first._tree(scope, span))
        otherwise = self._second._tree(scope, span)
        if isinstance(otherwise, tree.IfExpression):
            return tree.IfExpression(span, (branch, *otherwise.branches), otherwise.otherwise)
        return tree.IfExpression(span, (branch,), otherwise)


class Listing(Symbolic):
    """``{a, b, c}`` with symbolic elements."""

    __slots__ = ("_elements", "_span")

    def __init__(self, elements: tuple[Symbolic, ...], span: Span) -> None:
        self._elements = elements
        self._span = span

    @property
    def _depth(self) -> int:
        return 1 + max((e._depth for e in self._elements), default=0)

    @property
    def _ndim(self) -> int:
        return 1 + max((e._ndim for e in self._elements), default=0)

    def _tree(self, scope: Scope, span: Span) -> tree.Expression:
        return tree.ArrayLiteral(
            self._span, tuple(e._tree(scope, self._span) for e in self._elements)
        )


class GlobalName(Symbolic):
    """A name that means the same everywhere: ``time``, ``StateSelect.prefer``, ``blocks.Init.x``.

    The first part may be a class of the library, whose name is only known in the scope.
    """

    __slots__ = ("_home", "_names")

    def __init__(self, names: tuple[str, ...], home: object = None) -> None:
        self._names = names
        self._home = home

    def _tree(self, scope: Scope, span: Span) -> tree.Expression:
        parts = tuple(tree.NamePart(span, name) for name in self._names)
        if self._home is None:
            return tree.Reference(span, parts)
        home = scope.class_reference(self._home, span)
        return tree.Reference(span, (*home.parts, *parts), home.absolute)


def deeper(arguments: Sequence[Symbolic], span: Span) -> int:
    """Return the depth of an expression made of others.

    Raises:
        AcausalError: ``T107`` if it is too deep.
    """
    depth = 1 + max((a._depth for a in arguments), default=0)
    if depth > DEEPEST:
        fail("T107", f"an expression of more than {DEEPEST} levels", span,
             label="each operation adds a level",
             help="use ac.sum of an array, or give parts of it their own variables")  # fmt: skip
    return depth


def operand(value: object, span: Span) -> Symbolic:
    """Return anything that can stand in an expression as a symbolic one.

    Raises:
        AcausalError: ``T152`` for what cannot, ``T153`` for a number that is not finite.
    """
    if isinstance(value, Symbolic):
        return value
    from acausal.compose.numbers import symbolic_value

    return symbolic_value(value, span)


def binary(operator: str, left: object, right: object) -> Symbolic:
    """Return ``left operator right``."""
    span = here()
    one, two = operand(left, span), operand(right, span)
    if operator == "+" and max(one._depth, two._depth) > DEEPEST // 2:
        return _balanced_sum(one, two, span)
    return Operation(operator, (one, two), span)


def _balanced_sum(left: Symbolic, right: Symbolic, span: Span) -> Symbolic:
    """Return a long sum as a tree of little depth; Python makes a chain of it."""
    terms: list[Symbolic] = []
    stack = [right, left]
    while stack:
        item = stack.pop()
        if isinstance(item, Operation) and item._operator == "+":
            stack += [item._arguments[1], item._arguments[0]]
        else:
            terms.append(item)
    while len(terms) > 1:
        pairs = [
            Operation("+", (terms[k], terms[k + 1]), span) for k in range(0, len(terms) - 1, 2)
        ]
        terms = pairs + terms[len(terms) - len(terms) % 2 :]
    return terms[0]


def called(name: str, *arguments: object, dimensions: int | None = None) -> Symbolic:
    """Return a call of a function of the language, element by element unless told otherwise."""
    span = here()
    given = tuple(operand(a, span) for a in arguments)
    if dimensions is None:
        dimensions = max((a._ndim for a in given), default=0)
    return Invocation(name, given, span, dimensions=dimensions)
