r"""Expressions as LaTeX mathematics."""

from __future__ import annotations

import re
from collections.abc import Callable, Hashable, Sequence
from typing import Final

from acausal.expressions.nodes import Expr
from acausal.expressions.text import is_negative, number_text

_GREEK: Final = frozenset((
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa",
    "lambda", "mu", "nu", "xi", "pi", "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi",
    "omega", "Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi", "Psi",
    "Omega",
))  # fmt: skip
_VARIANTS: Final = {"epsilon": r"\varepsilon", "phi": r"\varphi"}
_NAME: Final = re.compile(r"([A-Za-z]+?)_?(\d*)")
#: Functions with a name of their own in mathematics.
FUNCTIONS: Final = {
    "sin": r"\sin", "cos": r"\cos", "tan": r"\tan", "asin": r"\arcsin", "acos": r"\arccos",
    "atan": r"\arctan", "sinh": r"\sinh", "cosh": r"\cosh", "tanh": r"\tanh", "exp": r"\exp",
    "log": r"\ln", "log10": r"\log_{10}", "min": r"\min", "max": r"\max",
}  # fmt: skip
_DOTS: Final = {1: r"\dot", 2: r"\ddot", 3: r"\dddot"}

# Binding strength, from loosest to tightest.
_IF, _OR, _AND, _NOT, _RELATION, _SUM, _PRODUCT, _POWER, _ATOM = range(9)
_BINARY: Final = {
    "or": (r" \lor ", _OR, _OR, _AND),
    "and": (r" \land ", _AND, _AND, _NOT),
    "lt": (" < ", _RELATION, _SUM, _SUM),
    "le": (r" \le ", _RELATION, _SUM, _SUM),
    "gt": (" > ", _RELATION, _SUM, _SUM),
    "ge": (r" \ge ", _RELATION, _SUM, _SUM),
    "eq": (" = ", _RELATION, _SUM, _SUM),
    "ne": (r" \ne ", _RELATION, _SUM, _SUM),
    "add": (" + ", _SUM, _SUM, _PRODUCT),
    "sub": (" - ", _SUM, _SUM, _PRODUCT),
    "mul": (r" \, ", _PRODUCT, _PRODUCT, _POWER),
}

_Piece = str | tuple[Expr, int]


def latex_name(name: str) -> str:
    r"""Return a variable's name as mathematics.

    Greek letters become letters, what follows an underscore, trailing digits, array indices and
    the path of the component become a subscript, ``der(x)`` gets a dot:
    ``phi_rel`` is ``\varphi_{\mathrm{rel}}``, ``r[3].v`` is ``v_{\mathrm{r}[3]}``.
    """
    order = 0
    while name.startswith("der(") and name.endswith(")"):
        name, order = name[4:-1], order + 1
    path, _, last = name.rpartition(".")
    parts = [part.partition("[") for part in (*filter(None, path.split(".")), last)]
    return latex_path([(n, f"[{i}" if i else "") for n, _, i in parts], order)


def latex_path(parts: Sequence[tuple[str, str]], order: int = 0) -> str:
    """Return a dotted name as mathematics.

    Args:
        parts: The names with their indices: LaTeX in brackets, or nothing.
        order: How often it is differentiated.
    """
    *path, (last, index) = parts
    stem, _, suffix = last.partition("_")
    match = _NAME.fullmatch(stem)
    if match and match[2]:
        stem, suffix = match[1], ",".join(filter(None, (match[2], suffix)))
    symbol = _letters(stem, r"\mathit")
    if order:
        dots = _DOTS.get(order)
        symbol = f"{dots}{{{symbol}}}" if dots else f"{symbol}^{{({order})}}"
    subscript = [_letters(part, r"\mathrm") for part in filter(None, suffix.split(","))]
    if index:
        subscript.append(index.removeprefix("[").removesuffix("]"))
    if path:
        subscript.append(".".join(rf"\mathrm{{{escaped(n)}}}{i}" for n, i in path))
    return f"{symbol}_{{{','.join(subscript)}}}" if subscript else symbol


def _letters(text: str, font: str) -> str:
    if text in _GREEK:
        return _VARIANTS.get(text, "\\" + text)
    if len(text) == 1 or text.isdigit():
        return text
    return f"{font}{{{escaped(text)}}}"


def escaped(text: str) -> str:
    """Return a text with the characters escaped that mean something in LaTeX."""
    return re.sub(r"([_#$%&{}])", r"\\\1", text)


def to_latex(
    expr: Expr,
    name_of_slot: Callable[[Hashable], str] = lambda key: latex_name(str(key)),
    max_length: int = 20_000,
) -> str:
    r"""Return ``expr`` as LaTeX mathematics: fractions, roots, powers, cases.

    Args:
        expr: The expression.
        name_of_slot: LaTeX of a slot from its key (``latex_name`` of its name).
        max_length: Longer text ends in ``\ldots``, perhaps inside a group.
    """
    pieces: list[str] = []
    length = 0
    stack: list[_Piece] = [(expr, _IF)]
    while stack:
        item = stack.pop()
        if isinstance(item, str):
            pieces.append(item)
            length += len(item)
            if length > max_length:
                return "".join(pieces) + r"\ldots"
            continue
        inner, needed = item
        while inner.op in ("noevent", "smooth", "homotopy"):  # how it is computed, not what it is
            inner = inner.args[0]
        strength, parts = _parts(inner, name_of_slot)
        if strength < needed:
            parts = [r"\left(", *parts, r"\right)"]
        stack.extend(reversed(parts))
    return "".join(pieces)


def _parts(expr: Expr, name_of_slot: Callable[[Hashable], str]) -> tuple[int, list[_Piece]]:
    op, args = expr.op, expr.args
    if op in _BINARY:
        symbol, strength, left, right = _BINARY[op]
        if op == "mul" and _starts_with_digit(args[1]):
            symbol = r" \cdot "
        if op == "mul" and is_negative(args[0]):
            return _SUM, [(args[0], _SUM), symbol, (args[1], right)]
        return strength, [(args[0], left), symbol, (args[1], right)]
    match op:
        case "const":
            assert isinstance(expr.value, float)
            return _number(expr.value)
        case "time":
            return _ATOM, ["t"]
        case "slot":
            return _ATOM, [name_of_slot(expr.value)]
        case "neg":
            return _SUM, ["-", (args[0], _PRODUCT)]
        case "not":
            return _NOT, [r"\lnot ", (args[0], _ATOM)]
        case "div":
            return _PRODUCT, [r"\frac{", (args[0], _IF), "}{", (args[1], _IF), "}"]
        case "pow":
            return _POWER, ["{", (args[0], _ATOM), "}^{", (args[1], _IF), "}"]
        case "if":
            return _ATOM, [
                r"\begin{cases}", (args[1], _OR), r" & \text{if } ", (args[0], _OR), r" \\ ",
                (args[2], _OR), r" & \text{otherwise}\end{cases}",
            ]  # fmt: skip
    return _call(expr)


def _number(value: float) -> tuple[int, list[_Piece]]:
    mantissa, _, exponent = number_text(value).partition("e")
    strength = _SUM if mantissa.startswith("-") else _PRODUCT if exponent else _ATOM
    if not exponent:
        return strength, [mantissa]
    power = rf"10^{{{exponent}}}"
    return strength, [power if mantissa == "1" else rf"{mantissa} \cdot {power}"]


def _starts_with_digit(expr: Expr) -> bool:
    while expr.op in ("mul", "pow"):
        expr = expr.args[0]
    return expr.op == "const"


def _call(expr: Expr) -> tuple[int, list[_Piece]]:
    name, args = str(expr.value), expr.args
    match name:
        case "sqrt":
            return _ATOM, [r"\sqrt{", (args[0], _IF), "}"]
        case "exp":
            return _POWER, [r"e^{", (args[0], _IF), "}"]
        case "abs":
            return _ATOM, [r"\left|", (args[0], _IF), r"\right|"]
        case "floor" | "integer":
            return _ATOM, [r"\left\lfloor ", (args[0], _IF), r"\right\rfloor"]
        case "ceil":
            return _ATOM, [r"\left\lceil ", (args[0], _IF), r"\right\rceil"]
    pieces: list[_Piece] = [FUNCTIONS.get(name, rf"\operatorname{{{name}}}"), r"\left("]
    for number, argument in enumerate(args):
        pieces += [", ", (argument, _IF)] if number else [(argument, _IF)]
    return _ATOM, [*pieces, r"\right)"]
