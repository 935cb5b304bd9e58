"""Classes, equations and statements back to text, two blanks for each level.

Nesting of blocks is bounded by the parser, so these functions may call themselves.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from acausal.syntax import tree
from acausal.syntax.formatter import (
    format_expression,
    format_indices,
    format_modification,
    format_string,
)

_STEP = "  "


def class_lines(definition: tree.ClassDefinition, indent: str) -> list[str]:
    """Return the lines of a class definition; the last ends with a semicolon."""
    words = [*definition.prefixes, "partial"] if definition.partial else [*definition.prefixes]
    head = " ".join([*words, definition.kind, definition.name])
    comment = _comment(definition.description, definition.annotation)
    if definition.enumeration is not None:
        literals = ", ".join(name + _comment(text, None) for name, text in definition.enumeration)
        return [f"{indent}{head} = enumeration({literals}){comment};"]
    if definition.alias is not None:
        base = " ".join([*definition.alias_prefixes, format_expression(definition.alias)])
        base += _dimensions(definition.alias_dimensions)
        base += format_modification(definition.alias_modifiers)
        return [f"{indent}{head} = {base}{comment};"]
    inner = indent + _STEP
    lines = [indent + head + _comment(definition.description, None)]
    lines += [import_line(i, inner) for i in definition.imports]
    for public in (True, False):
        elements = [_extends_line(e, inner) for e in definition.extends if e.public is public]
        if public:
            for nested in definition.classes:
                elements += class_lines(nested, inner)
        for component in definition.components:
            if component.public is public:
                elements.append(f"{inner}{component_text(component)};")
        if elements and not public:
            lines.append(f"{indent}protected")
        lines += elements
    sections: list[tuple[str, Sequence[tree.Equation] | Sequence[tree.Statement]]] = []
    if definition.initial_equations:
        sections.append(("initial equation", definition.initial_equations))
    if definition.equations:
        sections.append(("equation", definition.equations))
    sections += [("initial algorithm", section) for section in definition.initial_algorithms]
    sections += [("algorithm", section) for section in definition.algorithms]
    for title, body in sections:
        lines.append(indent + title)
        for item in body:
            if isinstance(item, tree.Equation):
                lines += equation_lines(item, inner)
            else:
                lines += statement_lines(item, inner)
    if definition.external:
        lines.append(f"{indent}external;")
    if definition.annotation is not None:
        lines.append(f"{inner}{_annotation(definition.annotation)};")
    return [*lines, f"{indent}end {definition.name};"]


def component_text(component: tree.ComponentDeclaration) -> str:
    """Return a component declaration without its semicolon."""
    words = [*component.prefixes, format_expression(component.type_name), component.name]
    text = " ".join(words) + _dimensions(component.dimensions)
    text += format_modification(component.modifiers)
    if component.value is not None:
        text += f" = {format_expression(component.value)}"
    if component.condition is not None:
        text += f" if {format_expression(component.condition)}"
    return text + _comment(component.description, component.annotation)


def format_redeclaration(modifier: tree.Modifier) -> str:
    """Return a modifier that redeclares a component or class."""
    new = modifier.redeclaration
    each = "each " * modifier.each
    if isinstance(new, tree.ClassDefinition):
        return each + "\n".join(class_lines(new, "")).removesuffix(";")
    assert new is not None
    return each + component_text(new)


def import_line(clause: tree.ImportClause, indent: str) -> str:
    """Return an import clause as a line."""
    path = ".".join(clause.path)
    if clause.alias is not None:
        path = f"{clause.alias} = {path}"
    elif clause.wildcard:
        path += ".*"
    elif clause.names:
        path += ".{" + ", ".join(clause.names) + "}"
    return f"{indent}import {path};"


def equation_lines(equation: tree.Equation, indent: str) -> list[str]:
    """Return the lines of an equation; the last ends with a semicolon."""
    end = _comment(equation.description, None) + ";"
    match equation:
        case tree.SimpleEquation():
            left = equation.left
            # An if-expression or range begins no equation unless in parentheses.
            text = format_expression(left)
            if isinstance(left, tree.IfExpression):
                text = f"({text})"
            return [f"{indent}{text} = {format_expression(equation.right)}{end}"]
        case tree.ConnectEquation():
            cuts = ", ".join(format_expression(cut) for cut in equation.cuts)
            return [f"{indent}connect({cuts}){end}"]
        case tree.CallEquation():
            return [f"{indent}{format_expression(equation.call)}{end}"]
        case tree.ForEquation():
            head = f"{indent}for {format_indices(equation.indices)} loop"
            return [head, *_body(equation.body, indent), f"{indent}end for{end}"]
        case tree.IfEquation():
            lines = _branch_lines(equation.branches, "if", "elseif", indent)
            if equation.otherwise:
                lines += [f"{indent}else", *_body(equation.otherwise, indent)]
            return [*lines, f"{indent}end if{end}"]
        case tree.WhenEquation():
            lines = _branch_lines(equation.branches, "when", "elsewhen", indent)
            return [*lines, f"{indent}end when{end}"]
        case _:  # pragma: no cover - an equation class added to the tree and forgotten here
            raise TypeError(f"no text for {type(equation).__name__}")


def statement_lines(statement: tree.Statement, indent: str) -> list[str]:
    """Return the lines of a statement; the last ends with a semicolon."""
    end = _comment(statement.description, None) + ";"
    match statement:
        case tree.Assignment():
            target = format_expression(statement.target)
            return [f"{indent}{target} := {format_expression(statement.value)}{end}"]
        case tree.CallStatement():
            return [f"{indent}{format_expression(statement.call)}{end}"]
        case tree.ForStatement():
            head = f"{indent}for {format_indices(statement.indices)} loop"
            return [head, *_body(statement.body, indent), f"{indent}end for{end}"]
        case tree.WhileStatement():
            head = f"{indent}while {format_expression(statement.condition)} loop"
            return [head, *_body(statement.body, indent), f"{indent}end while{end}"]
        case tree.IfStatement():
            lines = _branch_lines(statement.branches, "if", "elseif", indent)
            if statement.otherwise:
                lines += [f"{indent}else", *_body(statement.otherwise, indent)]
            return [*lines, f"{indent}end if{end}"]
        case tree.WhenStatement():
            lines = _branch_lines(statement.branches, "when", "elsewhen", indent)
            return [*lines, f"{indent}end when{end}"]
        case tree.ReturnStatement():
            return [f"{indent}return{end}"]
        case tree.BreakStatement():
            return [f"{indent}break{end}"]
        case _:  # pragma: no cover - a statement class added to the tree and forgotten here
            raise TypeError(f"no text for {type(statement).__name__}")


def _body(items: Iterable[tree.Equation | tree.Statement], indent: str) -> list[str]:
    lines: list[str] = []
    for item in items:
        if isinstance(item, tree.Equation):
            lines += equation_lines(item, indent + _STEP)
        else:
            lines += statement_lines(item, indent + _STEP)
    return lines


def _branch_lines(
    branches: Iterable[tuple[tree.Expression, Iterable[tree.Equation | tree.Statement]]],
    first: str,
    later: str,
    indent: str,
) -> list[str]:
    lines: list[str] = []
    for condition, body in branches:
        word = later if lines else first
        lines.append(f"{indent}{word} {format_expression(condition)} then")
        lines += _body(body, indent)
    return lines


def _extends_line(clause: tree.ExtendsClause, indent: str) -> str:
    base = format_expression(clause.base) + format_modification(clause.modifiers)
    return f"{indent}extends {base};"


def _dimensions(dimensions: Sequence[tree.Expression]) -> str:
    if not dimensions:
        return ""
    return "[" + ", ".join(format_expression(d) for d in dimensions) + "]"


def _comment(description: str, annotation: tree.Annotation | None) -> str:
    text = f" {format_string(description)}" if description else ""
    return text if annotation is None else f"{text} {_annotation(annotation)}"


def _annotation(annotation: tree.Annotation) -> str:
    arguments = ", ".join(
        format_modification((argument,))[1:-1] for argument in annotation.arguments
    )
    return f"annotation({arguments})"
