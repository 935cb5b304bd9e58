"""Syntax trees back to text, with as few parentheses as a person would write.

Formatting is the inverse of parsing: the text of a tree parses to the same tree, places aside.
Expressions are printed with an explicit stack, so the depth of a tree does not matter.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence

from acausal.syntax import tree
from acausal.syntax.precedence import BINARY_LEVELS, POWER, RELATION, SIGN, UNARY_LEVELS

_IF, _RANGE, _TUPLE = -2, -1, -3
_PRIMARY = POWER + 1

_ESCAPES = str.maketrans(
    {
        "\\": "\\\\",
        '"': '\\"',
        "\n": "\\n",
        "\r": "\\r",
        "\t": "\\t",
        "\a": "\\a",
        "\b": "\\b",
        "\f": "\\f",
        "\v": "\\v",
    }
)


def format_expression(expression: tree.Expression) -> str:
    """Return an expression as a person would write it."""
    output: list[str] = []
    # A work item is text, or an expression with the strength its surroundings ask for.
    stack: list[str | tuple[tree.Expression, int]] = [(expression, _TUPLE)]
    while stack:
        item = stack.pop()
        if isinstance(item, str):
            output.append(item)
            continue
        node, required = item
        parts = _parts(node)
        if _strength(node) < required:
            parts = ["(", *parts, ")"]
        stack += reversed(parts)
    return "".join(output)


_Parts = list["str | tuple[tree.Expression, int]"]


def _strength(node: tree.Expression) -> int:
    """Return how strongly the outermost operator of an expression binds."""
    if isinstance(node, tree.Binary):
        return BINARY_LEVELS[node.operator]
    if isinstance(node, tree.Unary):
        return UNARY_LEVELS[node.operator]
    if isinstance(node, tree.IfExpression):
        return _IF
    if isinstance(node, tree.RangeExpression):
        return _RANGE
    if isinstance(node, tree.NumberLiteral) and node.value < 0:
        return SIGN
    return _PRIMARY


def _parts(node: tree.Expression) -> _Parts:
    """Return an expression as text and subexpressions, each with the strength it must have."""
    match node:
        case tree.NumberLiteral():
            return [format_number(node)]
        case tree.StringLiteral():
            return [format_string(node.value)]
        case tree.BooleanLiteral():
            return ["true" if node.value else "false"]
        case tree.Reference():
            return _reference_parts(node)
        case tree.Unary():
            return _unary_parts(node)
        case tree.Binary():
            return _binary_parts(node)
        case tree.IfExpression():
            result: _Parts = []
            for position, (condition, value) in enumerate(node.branches):
                result += [
                    " elseif " if position else "if ",
                    (condition, _RANGE),
                    " then ",
                    (value, _RANGE),
                ]
            # The last value may be an if-expression itself: nothing follows it.
            return [*result, " else ", (node.otherwise, _IF)]
        case tree.Call():
            return _call_parts(node)
        case tree.RangeExpression():
            middle: _Parts = [] if node.step is None else [":", (node.step, _RANGE + 1)]
            return [(node.start, _RANGE + 1), *middle, ":", (node.stop, _RANGE + 1)]
        case tree.ArrayLiteral():
            return ["{", *_list_parts(node.elements), "}"]
        case tree.NumberArray():
            return [format_number_array(node)]
        case tree.ArrayComprehension():
            return ["{", (node.element, _IF), *_indices_parts(node.indices), "}"]
        case tree.MatrixLiteral():
            inner: _Parts = []
            for row in node.rows:
                inner += ["; " if inner else "", *_list_parts(row)]
            return ["[", *inner, "]"]
        case tree.Colon():
            return [":"]
        case tree.End():
            return ["end"]
        case tree.TupleExpression():
            elements: _Parts = []
            for element in node.elements:
                if elements:
                    elements.append(", ")
                elements.append("" if element is None else (element, _IF))
            return ["(", *elements, ")"]
        case _:  # pragma: no cover - a node class added to the tree and forgotten here
            raise TypeError(f"no text for {type(node).__name__}")


def _unary_parts(node: tree.Unary) -> _Parts:
    level = UNARY_LEVELS[node.operator]
    # An operand is what the parser gathers behind the operator: a product behind a sign, a
    # comparison behind "not"; another prefix operator needs parentheses.
    blank = " " if node.operator == "not" else ""
    return [node.operator + blank, (node.operand, level + 1)]


def _binary_parts(node: tree.Binary) -> _Parts:
    level = BINARY_LEVELS[node.operator]
    left = level + 1 if level in (RELATION, POWER) else level
    # "1.*x" would read as "1." times x.
    tight = level > SIGN and not node.operator.startswith(".")
    sign = node.operator if tight else f" {node.operator} "
    right = level + 1
    if level > SIGN or level < RELATION:
        return [(node.left, left), sign, (node.right, right)]
    # Behind + and - no sign can stand; "a < -b" is allowed.
    if level != RELATION and _strength(node.right) == SIGN:
        right = _PRIMARY
    return [(node.left, left), sign, (node.right, right)]


def _reference_parts(node: tree.Reference) -> _Parts:
    result: _Parts = ["."] if node.absolute else []
    for position, part in enumerate(node.parts):
        result.append("." + part.name if position else part.name)
        if part.subscripts:
            result += ["[", *_list_parts(part.subscripts), "]"]
    return result


def _call_parts(node: tree.Call) -> _Parts:
    result = [*_reference_parts(node.function), "(", *_list_parts(node.arguments)]
    for position, argument in enumerate(node.named):
        comma = ", " if position or node.arguments else ""
        result += [f"{comma}{argument.name} = ", (argument.value, _IF)]
    return [*result, *_indices_parts(node.indices), ")"]


def _indices_parts(indices: Iterable[tree.ForIndex]) -> _Parts:
    result: _Parts = []
    for index in indices:
        result.append(", " if result else " for ")
        result.append(index.name)
        if index.range is not None:
            result += [" in ", (index.range, _IF)]
    return result


def _list_parts(expressions: Sequence[tree.Expression]) -> _Parts:
    result: _Parts = []
    for expression in expressions:
        if result:
            result.append(", ")
        result.append((expression, _IF))
    return result


def format_number(number: tree.NumberLiteral) -> str:
    """Return a number with its unit, such as ``10[kOhm]``."""
    text = str(int(number.value)) if number.integer else repr(float(number.value))
    return text if number.unit is None else f"{text}[{number.unit}]"


def format_number_array(array: tree.NumberArray) -> str:
    """Return a block of numbers as nested lists in braces."""
    if 0 in array.shape:
        return f"zeros({', '.join(map(str, array.shape))})"
    numbers = [n for (n,) in struct.iter_unpack("d", array.data)]
    items = [str(int(n)) if array.integer else repr(n) for n in numbers]
    if array.unit is not None:
        items = [f"{item}[{array.unit}]" for item in items]
    for size in reversed(array.shape):
        items = ["{" + ", ".join(items[k : k + size]) + "}" for k in range(0, len(items), size)]
    return items[0]


def format_string(value: str) -> str:
    """Return a string in quotes, with escapes."""
    return f'"{value.translate(_ESCAPES)}"'


def format_indices(indices: Iterable[tree.ForIndex]) -> str:
    """Return loop indices: ``i in 1:n, j``."""
    return ", ".join(
        i.name if i.range is None else f"{i.name} in {format_expression(i.range)}" for i in indices
    )


def format_modifier(modifier: tree.Modifier) -> str:
    """Return one argument of a modification, such as ``each R(min = 0) = 10[Ohm]``."""
    # Redeclarations need the text of whole declarations, which another module knows.
    if modifier.redeclaration is not None:
        from acausal.syntax.class_formatter import format_redeclaration

        return format_redeclaration(modifier)
    words = "each " * modifier.each + "final " * modifier.final + ".".join(modifier.name)
    words += format_modification(modifier.nested)
    if modifier.value is not None:
        words += f" = {format_expression(modifier.value)}"
    return words


def format_modification(modifiers: Sequence[tree.Modifier]) -> str:
    """Return ``(a = 1, b = 2)``, or nothing for no modifiers."""
    if not modifiers:
        return ""
    return "(" + ", ".join(format_modifier(m) for m in modifiers) + ")"


def format_equation(equation: tree.Equation) -> str:
    """Return an equation without its final semicolon; blocks take several lines."""
    from acausal.syntax.class_formatter import equation_lines

    return "\n".join(equation_lines(equation, "")).removesuffix(";")


def format_class(definition: tree.ClassDefinition) -> str:
    """Return the text of a class, with its final semicolon and line end."""
    from acausal.syntax.class_formatter import class_lines

    return "\n".join(class_lines(definition, "")) + "\n"


def format_file(file: tree.File) -> str:
    """Return the text of a file."""
    from acausal.syntax.class_formatter import import_line

    parts = []
    if file.within:
        parts.append(f"within {'.'.join(file.within)};\n")
    if file.imports:
        parts.append("".join(import_line(i, "") + "\n" for i in file.imports))
    parts += [format_class(c) for c in file.classes]
    return "\n".join(parts)
