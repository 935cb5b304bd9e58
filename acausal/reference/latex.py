r"""Syntax trees as LaTeX mathematics: what a textbook prints for an expression as it is written.

:mod:`acausal.expressions.latex` does the same for the compiled templates, whose names and functions
look alike. Trees are walked with an explicit stack, so their depth does not matter.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Final

from acausal.expressions.latex import FUNCTIONS, escaped, latex_path
from acausal.expressions.text import number_text
from acausal.syntax import tree
from acausal.syntax.precedence import (
    AND,
    BINARY_LEVELS,
    NOT,
    OR,
    POWER,
    PRODUCT,
    RELATION,
    SIGN,
    SUM,
    UNARY_LEVELS,
)

_LOOSE: Final = 0
_ATOM: Final = POWER + 1
_SIGNS: Final = {
    "*": r" \, ", ".*": r" \odot ", "+": " + ", "-": " - ", ".+": " + ", ".-": " - ",
    "<": " < ", "<=": r" \le ", ">": " > ", ">=": r" \ge ", "==": " = ", "<>": r" \ne ",
    "and": r" \land ", "or": r" \lor ",
}  # fmt: skip
#: Calls that say how something is computed, not what it is.
_TRANSPARENT: Final = {"noEvent": 0, "smooth": 1}
#: Calls written with brackets or marks of their own.
_ENCLOSED: Final = {
    "sqrt": (r"\sqrt{", "}"),
    "abs": (r"\left|", r"\right|"),
    "floor": (r"\left\lfloor ", r"\right\rfloor "),
    "integer": (r"\left\lfloor ", r"\right\rfloor "),
    "ceil": (r"\left\lceil ", r"\right\rceil "),
}
#: Vectors up to this length are written as columns.
_COLUMN: Final = 4

_Piece = str | tuple[tree.Expression, int]


def latex_expression(
    expression: tree.Expression,
    components: Collection[str] | None = None,
    *,
    side: bool = False,
) -> str:
    """Return an expression as LaTeX mathematics.

    Args:
        expression: The expression as it is written.
        components: Names of the components of the class it stands in. Dotted names that begin
            otherwise are constants and printed upright; None if that is not known.
        side: It is one side of an equation: relations and logic get parentheses.
    """
    pieces: list[str] = []
    stack: list[_Piece] = [(expression, SUM if side else _LOOSE)]
    while stack:
        item = stack.pop()
        if isinstance(item, str):
            pieces.append(item)
            continue
        strength, parts = _parts(item[0], components)
        if strength < item[1]:
            parts = [r"\left(", *parts, r"\right)"]
        stack += reversed(parts)
    return "".join(pieces)


def latex_reference(
    reference: tree.Reference, components: Collection[str] | None = None, order: int = 0
) -> str:
    """Return a variable's name with its subscripts, differentiated ``order`` times."""
    parts = reference.parts
    if len(parts) == 1 and parts[0].name == "time":
        return r"\mathit{time}" if components is not None and "t" in components else "t"
    if len(parts) > 1:
        first, owner, last = parts[0].name, parts[-2].name, parts[-1].name
        constant = first not in components if components is not None else owner[:1].isupper()
        if owner == "constants":
            return {"inf": r"\infty", "pi": r"\pi"}.get(last, latex_path([(last, "")]))
        if constant:
            return rf"\mathrm{{{escaped(f'{owner}.{last}')}}}"
    named = []
    for part in parts:
        inner = [latex_expression(s, components) for s in part.subscripts]
        named.append((part.name, f"[{', '.join(inner)}]" if inner else ""))
    return latex_path(named, order)


def unit_latex(unit: str) -> str:
    """Return a unit's text as LaTeX."""
    return rf"\text{{{unit.replace('Ohm', 'Ω').replace('.', '·')}}}"


def _parts(node: tree.Expression, known: Collection[str] | None) -> tuple[int, list[_Piece]]:
    """Return how strongly an expression binds, and what it is made of."""
    match node:
        case tree.NumberLiteral():
            return _number(node)
        case tree.StringLiteral():
            return _ATOM, [rf"\text{{“{escaped(node.value)}”}}"]
        case tree.BooleanLiteral():
            return _ATOM, [r"\text{true}" if node.value else r"\text{false}"]
        case tree.Reference():
            return _ATOM, [latex_reference(node, known)]
        case tree.Unary():
            if node.operator == "not":
                return NOT, [r"\lnot ", (node.operand, _ATOM)]
            level = UNARY_LEVELS[node.operator]
            return level, [node.operator.lstrip("."), (node.operand, level + 1)]
        case tree.Binary():
            return _binary(node)
        case tree.IfExpression():
            return _cases(node)
        case tree.Call():
            return _call(node, known)
        case tree.RangeExpression():
            return _LOOSE, [(node.start, SUM), r", \dots, ", (node.stop, SUM)]
        case tree.ArrayLiteral():
            return _ATOM, _array(node)
        case tree.ArrayComprehension():
            return _ATOM, [
                r"\left(", (node.element, _LOOSE), r"\right)_{", *_indices(node.indices), "}",
            ]  # fmt: skip
        case tree.MatrixLiteral():
            return _ATOM, _matrix(node.rows)
        case tree.Colon():
            return _ATOM, [":"]
        case tree.End():
            return _ATOM, [r"\text{end}"]
        case tree.TupleExpression():
            inner: list[_Piece] = []
            for element in node.elements:
                inner += [", "] * bool(inner) + [r"\_" if element is None else (element, _LOOSE)]
            return _ATOM, [r"\left(", *inner, r"\right)"]
    raise TypeError(f"no mathematics for {type(node).__name__}")  # pragma: no cover


def _number(node: tree.NumberLiteral) -> tuple[int, list[_Piece]]:
    mantissa, _, exponent = number_text(node.value).partition("e")
    text, strength = mantissa, _ATOM
    if exponent:
        power = rf"10^{{{exponent}}}"
        text = power if mantissa == "1" else rf"{mantissa} \cdot {power}"
        strength = PRODUCT
    if node.unit is not None:
        text, strength = rf"{text}\,{unit_latex(node.unit)}", PRODUCT
    return (SIGN if mantissa.startswith("-") else strength), [text]


def _binary(node: tree.Binary) -> tuple[int, list[_Piece]]:
    operator, left, right = node.operator, node.left, node.right
    level = BINARY_LEVELS[operator]
    if operator in ("/", "./"):
        return PRODUCT, [r"\frac{", (left, _LOOSE), "}{", (right, _LOOSE), "}"]
    if operator in ("^", ".^"):
        base: list[_Piece] = [(left, _ATOM)]
        if isinstance(left, tree.Call) and not _is_derivative(left):
            base = [r"\left(", (left, _LOOSE), r"\right)"]
        return POWER, ["{", *base, "}^{", (right, _LOOSE), "}"]
    sign = _SIGNS[operator]
    if operator == "*" and _starts_with_digit(right):
        sign = r" \cdot "
    if level == RELATION:
        return level, [(left, SUM), sign, (right, SUM)]
    if level in (AND, OR):
        return level, [(left, level), sign, (right, level)]
    # A factor that ends in a fraction or cases is told apart from the next one by its shape.
    return level, [(left, level), sign, (right, level + 1)]


def _is_derivative(call: tree.Call) -> bool:
    return str(call.function) == "der"


def _starts_with_digit(node: tree.Expression) -> bool:
    while isinstance(node, tree.Binary) and node.operator in ("*", "^"):
        node = node.left
    return isinstance(node, tree.NumberLiteral)


def _cases(node: tree.IfExpression) -> tuple[int, list[_Piece]]:
    parts: list[_Piece] = [r"\begin{cases}"]
    otherwise: tree.Expression = node.otherwise
    branches = list(node.branches)
    while isinstance(otherwise, tree.IfExpression):  # "else if" reads as "elseif"
        branches += otherwise.branches
        otherwise = otherwise.otherwise
    for condition, value in branches:
        parts += [(value, OR), r" & \text{if } ", (condition, _LOOSE), r" \\ "]
    return _ATOM, [*parts, (otherwise, OR), r" & \text{otherwise}\end{cases}"]


def _array(node: tree.ArrayLiteral) -> list[_Piece]:
    rows = [e.elements for e in node.elements if isinstance(e, tree.ArrayLiteral)]
    if rows and len(rows) == len(node.elements) and len({len(r) for r in rows}) == 1:
        return _matrix(rows)
    if 1 < len(node.elements) <= _COLUMN:
        return _matrix([(e,) for e in node.elements])
    inner: list[_Piece] = []
    for element in node.elements:
        inner += [r",\; "] * bool(inner) + [(element, _LOOSE)]
    return [r"\left(", *inner, r"\right)"]


def _matrix(rows: Sequence[tuple[tree.Expression, ...]]) -> list[_Piece]:
    parts: list[_Piece] = [r"\begin{pmatrix}"]
    for number, row in enumerate(rows):
        parts += [r" \\ "] * bool(number)
        for place, element in enumerate(row):
            parts += [" & "] * bool(place) + [(element, _LOOSE)]
    return [*parts, r"\end{pmatrix}"]


def _indices(indices: Sequence[tree.ForIndex]) -> list[_Piece]:
    parts: list[_Piece] = []
    for index in indices:
        parts += [",\\,"] * bool(parts) + [latex_path([(index.name, "")])]
        if index.range is not None:
            parts += [" = ", (index.range, _LOOSE)]
    return parts


def _big(sign: str, call: tree.Call) -> list[_Piece]:
    """Return a sum or product over indices, or over all elements of an array."""
    argument: _Piece = (call.arguments[0], PRODUCT)
    if not call.indices:
        return [sign, " ", argument]
    parts: list[_Piece] = []
    for index in call.indices:
        below: list[_Piece] = [latex_path([(index.name, "")])]
        above: list[_Piece] = []
        if isinstance(index.range, tree.RangeExpression) and index.range.step is None:
            below += [" = ", (index.range.start, _LOOSE)]
            above = ["^{", (index.range.stop, _LOOSE), "}"]
        elif index.range is not None:
            below += [r" \in ", (index.range, _LOOSE)]
        parts += [sign, "_{", *below, "}", *above, " "]
    return [*parts, argument]


def _call(call: tree.Call, known: Collection[str] | None) -> tuple[int, list[_Piece]]:
    name, arguments = str(call.function), call.arguments
    first = arguments[0] if arguments else None
    if name in _TRANSPARENT and len(arguments) > _TRANSPARENT[name]:
        return _parts(arguments[_TRANSPARENT[name]], known)
    if name == "homotopy":
        actual = first or next((a.value for a in call.named if a.name == "actual"), None)
        if actual is not None:
            return _parts(actual, known)
    if first is not None:
        match name, len(arguments):
            case "der", 1:
                return _derivative(first, known)
            case (("sum" | "product"), 1):
                return PRODUCT, _big(r"\sum" if name == "sum" else r"\prod", call)
            case "exp", 1:
                return POWER, ["e^{", (first, _LOOSE), "}"]
            case "transpose", 1:
                return POWER, ["{", (first, _ATOM), r"}^{\mathsf{T}}"]
            case "cross", 2:
                return PRODUCT, [(first, _ATOM), r" \times ", (arguments[1], _ATOM)]
            case "identity", 1:
                return _ATOM, ["I_{", (first, _LOOSE), "}"]
            case "delay", 2 if isinstance(first, tree.Reference):
                return _ATOM, [(first, _ATOM), r"\left(t - ", (arguments[1], PRODUCT), r"\right)"]
        if name in _ENCLOSED and len(arguments) == 1:
            left, right = _ENCLOSED[name]
            return _ATOM, [left, (first, _LOOSE), right]
    inner: list[_Piece] = []
    for argument in arguments:
        inner += [", "] * bool(inner) + [(argument, _LOOSE)]
    for named in call.named:
        inner += [", "] * bool(inner)
        inner += [latex_path([(named.name, "")]), " = ", (named.value, _LOOSE)]
    if call.indices:
        inner += [r"\;", *_indices(call.indices)]
    short = call.function.parts[-1].name
    written = FUNCTIONS.get(name, rf"\operatorname{{{escaped(short)}}}")
    return _ATOM, [written, r"\left(", *inner, r"\right)"]


def _derivative(
    argument: tree.Expression, known: Collection[str] | None
) -> tuple[int, list[_Piece]]:
    order = 1
    while isinstance(argument, tree.Call) and _is_derivative(argument):
        argument, order = argument.arguments[0], order + 1
    if isinstance(argument, tree.Reference):
        return _ATOM, [latex_reference(argument, known, order)]
    power = f"^{order}" if order > 1 else ""
    return PRODUCT, [
        rf"\frac{{\mathrm{{d}}{power}}}{{\mathrm{{d}}t{power}}}", r"\left(", (argument, _LOOSE),
        r"\right)",
    ]  # fmt: skip
