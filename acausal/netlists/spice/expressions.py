"""Numbers with scale suffixes and expressions of parameters.

Grammar, loosest first: ``a ? b : c``, ``||``, ``&&``, relations, ``+ -``, ``* /``, signs and ``!``,
``** ^`` (to the right), calls and brackets. The same tree gives a number, or an expression of
parameters of the model.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NoReturn

from acausal.compose import functions
from acausal.diagnostics import Span, fail
from acausal.diagnostics.suggest import nearest
from acausal.netlists.spice.lines import Token

#: Scale suffixes; letters after them are units and mean nothing.
SCALES = {
    "meg": 1e6, "mil": 25.4e-6, "t": 1e12, "g": 1e9, "k": 1e3, "m": 1e-3, "u": 1e-6, "µ": 1e-6,
    "μ": 1e-6, "n": 1e-9, "p": 1e-12, "f": 1e-15, "a": 1e-18,
}  # fmt: skip

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?[A-Za-zµμΩ%°]*"
_SIGNED = re.compile(rf"[+-]?{_NUMBER}\Z")
_PIECE = re.compile(
    rf"\s*(?:(?P<number>{_NUMBER})|(?P<name>[A-Za-z_]\w*)"
    r"|(?P<operator>\*\*|\|\||&&|==|!=|<=|>=|[-+*/^<>!?:(),]))"
)
_NAME = re.compile(r"[A-Za-z_][\w.]*\Z")
#: Levels of brackets and number of words of an expression; longer ones become several ``.param``.
_DEEPEST = 30
_LONGEST = 300


def number(text: str) -> float | None:
    """Return a number with its scale suffix, or None.

    Example:
        >>> number("2.2MEGohm"), number("10mF"), number("x")
        (2200000.0, 0.01, None)
    """
    if not _SIGNED.match(text):
        return None
    match = re.match(r"([+-]?[\d.]+(?:[eE][+-]?\d+)?)(.*)", text)
    assert match is not None
    suffix = match[2].lower()
    digits = match[1]
    factor = next((f for s, f in SCALES.items() if suffix.startswith(s)), 1.0)
    # 10u is 1e-05, and not 9.999999999999999e-06: the decimal point is moved, not multiplied.
    power = round(math.log10(factor)) if factor != SCALES["mil"] else 0
    if factor == SCALES["mil"]:
        return float(digits) * factor
    mantissa, _, exponent = digits.lower().partition("e")
    return float(f"{mantissa}e{int(exponent or 0) + power}")


@dataclass(frozen=True, slots=True)
class Number:
    """A number."""

    value: float


@dataclass(frozen=True, slots=True)
class Name:
    """A parameter."""

    name: str
    span: Span


@dataclass(frozen=True, slots=True)
class Call:
    """A function or operator with its arguments; ``?`` is the choice."""

    function: str
    arguments: tuple[Expression, ...]
    span: Span


Expression = Number | Name | Call


def value_of(token: Token) -> Expression:
    """Return a value of a card: a number, a parameter, or an expression in braces.

    Raises:
        AcausalError: ``P042``.
    """
    if token.kind == "expression":
        return parse(token.text, token.span)
    found = number(token.text)
    if found is not None:
        return Number(found)
    if _NAME.match(token.text):
        return Name(token.text, token.span)
    return fail(
        "P042",
        f"{token.text} is no number",
        token.span,
        help="write a number such as 4.7k or 10MEG, or an expression in braces: {2*r}",
    )


def parse(text: str, span: Span) -> Expression:
    """Return an expression.

    Raises:
        AcausalError: ``P042``.
    """
    return _Parser(text, span).whole()


_LEVELS = (
    {"||"}, {"&&"}, {"<", ">", "<=", ">=", "==", "!="}, {"+", "-"}, {"*", "/"},
)  # fmt: skip


class _Parser:
    def __init__(self, text: str, span: Span) -> None:
        self.text = text
        self.span = span
        self.pieces: list[tuple[str, str]] = []
        self.at = 0
        self.depth = 0
        position = 0
        while text[position:].strip():
            match = _PIECE.match(text, position)
            if match is None:
                self.wrong(f"{text[position:].strip()[0]} has no meaning in an expression")
            kind = str(match.lastgroup)
            self.pieces.append((kind, match[kind]))
            position = match.end()
        if len(self.pieces) > _LONGEST:
            self.wrong("the expression is too long; divide it into several .param")

    def wrong(self, message: str) -> NoReturn:
        fail("P042", message, self.span, help="expressions have + - * / ** ^, relations, && || !, "
             "a ? b : c, brackets and the functions " + ", ".join(FUNCTIONS))  # fmt: skip

    def peek(self) -> str:
        return self.pieces[self.at][1] if self.at < len(self.pieces) else ""

    def expect(self, mark: str) -> None:
        if self.peek() != mark:
            self.wrong(f"{mark} is missing" + (f" before {self.peek()}" if self.peek() else ""))
        self.at += 1

    def whole(self) -> Expression:
        found = self.choice()
        if self.peek():
            self.wrong(f"{self.peek()} has no meaning there")
        return found

    def choice(self) -> Expression:
        self.depth += 1
        if self.depth > _DEEPEST:
            self.wrong("the expression is nested too deep")
        found = self.binary(0)
        if self.peek() == "?":
            self.at += 1
            first = self.choice()
            self.expect(":")
            found = Call("?", (found, first, self.choice()), self.span)
        self.depth -= 1
        return found

    def binary(self, level: int) -> Expression:
        if level == len(_LEVELS):
            return self.signed()
        found = self.binary(level + 1)
        while self.peek() in _LEVELS[level]:
            operator = self.peek()
            self.at += 1
            found = Call(operator, (found, self.binary(level + 1)), self.span)
        return found

    def signed(self) -> Expression:
        signs = []
        while self.peek() in ("-", "+", "!"):
            signs.append(self.peek())
            self.at += 1
        found = self.power()
        for sign in reversed(signs):
            if sign == "-" and isinstance(found, Number):
                found = Number(-found.value)
            elif sign != "+":
                found = Call("neg" if sign == "-" else "!", (found,), self.span)
        return found

    def power(self) -> Expression:
        base = self.operand()
        if self.peek() not in ("**", "^"):
            return base
        self.at += 1
        self.depth += 1
        if self.depth > _DEEPEST:
            self.wrong("the expression is nested too deep")
        exponent = self.signed()
        self.depth -= 1
        return Call("**", (base, exponent), self.span)

    def operand(self) -> Expression:
        if self.at >= len(self.pieces):
            self.wrong("an expression is incomplete" if self.pieces else "an expression is empty")
        kind, text = self.pieces[self.at]
        self.at += 1
        if kind == "number":
            value = number(text)
            assert value is not None
            return Number(value)
        if text == "(":
            found = self.choice()
            self.expect(")")
            return found
        if kind != "name":
            self.wrong(f"{text} has no meaning there")
        if self.peek() != "(":
            return Name(text, self.span)
        return self.call(text)

    def call(self, text: str) -> Expression:
        self.at += 1
        arguments = [self.choice()]
        while self.peek() == ",":
            self.at += 1
            arguments.append(self.choice())
        self.expect(")")
        name = text.lower()
        if name not in FUNCTIONS:
            close = nearest(name, FUNCTIONS)
            self.wrong(
                f"there is no function {text}" + (f"; did you mean {close[0]}?" * bool(close))
            )
        if len(arguments) != FUNCTIONS[name]:
            self.wrong(f"{text} takes {FUNCTIONS[name]} arguments, not {len(arguments)}")
        if name in ("if", "ternary_fcn"):
            name = "?"
        return Call(name, tuple(arguments), self.span)


#: Function -> number of its arguments; ``log`` is the natural logarithm, as in ngspice.
FUNCTIONS = {
    "sqrt": 1, "exp": 1, "ln": 1, "log": 1, "log10": 1, "abs": 1, "sgn": 1, "int": 1, "floor": 1,
    "ceil": 1, "sin": 1, "cos": 1, "tan": 1, "asin": 1, "acos": 1, "atan": 1, "sinh": 1, "cosh": 1,
    "tanh": 1, "atan2": 2, "min": 2, "max": 2, "pow": 2, "pwr": 2, "if": 3, "ternary_fcn": 3,
}  # fmt: skip

_NUMBERS: dict[str, Callable[..., float]] = {
    "neg": lambda a: -a, "!": lambda a: float(not a), "+": lambda a, b: a + b,
    "-": lambda a, b: a - b, "*": lambda a, b: a * b, "/": lambda a, b: a / b,
    "**": lambda a, b: a**b, "<": lambda a, b: float(a < b), ">": lambda a, b: float(a > b),
    "<=": lambda a, b: float(a <= b), ">=": lambda a, b: float(a >= b),
    "==": lambda a, b: float(a == b), "!=": lambda a, b: float(a != b),
    "&&": lambda a, b: float(bool(a and b)), "||": lambda a, b: float(bool(a or b)),
    "?": lambda a, b, c: b if a else c, "ln": math.log, "abs": abs,
    "sgn": lambda a: float((a > 0) - (a < 0)), "int": lambda a: float(math.trunc(a)),
    "floor": lambda a: float(math.floor(a)), "ceil": lambda a: float(math.ceil(a)),
    "min": min, "max": max, "pow": lambda a, b: a**b,
    "pwr": lambda a, b: math.copysign(abs(a) ** b, a),
}  # fmt: skip

#: What becomes an expression of the model; the others need numbers.
_RELATIONS = ("<", ">", "<=", ">=", "==", "!=", "&&", "||", "!")


def evaluate(expression: Expression, lookup: Callable[[Name], float]) -> float:
    """Return the number of an expression.

    Raises:
        AcausalError: ``P042`` for what has no finite value.
    """
    if isinstance(expression, Number):
        return expression.value
    if isinstance(expression, Name):
        return lookup(expression)
    arguments = [evaluate(a, lookup) for a in expression.arguments]
    function = _NUMBERS.get(expression.function) or getattr(math, expression.function)
    try:
        value = function(*arguments)
    except (ArithmeticError, ValueError):
        value = math.nan
    if isinstance(value, complex) or not math.isfinite(value):
        shown = ", ".join(f"{a:g}" for a in arguments)
        fail("P042", f"{expression.function} of {shown} is no finite number", expression.span,
             help="change the parameters or the expression")  # fmt: skip
    return float(value)


def symbolic(expression: Expression, lookup: Callable[[Name], Any]) -> Any:
    """Return an expression as one of the model's parameters."""
    if isinstance(expression, Name):
        return lookup(expression)
    if isinstance(expression, Number) or not names_in(expression):
        value = evaluate(expression, lookup)
        return int(value) if value == int(value) and abs(value) < 1e6 else value
    name = expression.function
    first, *others = (symbolic(a, lookup) for a in expression.arguments)
    if name in _RELATIONS:
        return _relation(name, first, *others)
    if name == "?":
        return _choice(first, *others)
    if name in ("+", "-", "*", "/", "**"):
        return _NUMBERS[name](first, *others)
    if name == "neg":
        return -first
    if name == "int":
        return functions.sign(first) * functions.floor(abs(first))
    if name == "pow":
        return first ** others[0]
    if name == "pwr":
        return functions.sign(first) * abs(first) ** others[0]
    return getattr(functions, {"ln": "log", "sgn": "sign"}.get(name, name))(first, *others)


def _relation(name: str, first: Any, second: Any = None) -> Any:
    """Return a truth value: symbolic, or a number."""
    if not any(hasattr(x, "_tree") for x in (first, second)):
        return _NUMBERS[name](first) if second is None else _NUMBERS[name](first, second)
    if name == "!":
        return ~_truth(first)
    if name == "&&":
        return _truth(first) & _truth(second)
    if name == "||":
        return _truth(first) | _truth(second)
    import operator

    functions = {"<": operator.lt, ">": operator.gt, "<=": operator.le, ">=": operator.ge,
                 "==": operator.eq, "!=": operator.ne}  # fmt: skip
    return functions[name](first, second)


_TRUTHS = ("<", ">", "<=", ">=", "==", "<>", "and", "or", "not")


def _truth(value: Any) -> Any:
    if not hasattr(value, "_tree"):
        return bool(value)
    return value if getattr(value, "_operator", "") in _TRUTHS else value != 0


def _choice(condition: Any, first: Any, second: Any) -> Any:
    if not hasattr(condition, "_tree"):
        return first if condition else second
    return functions.where(_truth(condition), first, second)


def names_in(expression: Expression) -> bool:
    """Tell whether an expression has parameters."""
    if isinstance(expression, Call):
        return any(names_in(a) for a in expression.arguments)
    return isinstance(expression, Name)
