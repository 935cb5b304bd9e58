# ruff: noqa: D102 - a callback is named after its grammar rule, which says what it is
"""Callbacks of the parser for classes, declarations and modifiers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NoReturn

from lark import Token

from acausal.diagnostics import Label, Span, fail
from acausal.syntax import tree
from acausal.syntax.class_assembly import assemble_class, check_prefixes
from acausal.syntax.equation_builder import EquationBuilder
from acausal.syntax.expression_builder import Subscripts

_SECTION_LIKE = frozenset(("equation", "equations", "algorithm", "algorithms"))


@dataclass(frozen=True, slots=True)
class Modification:
    """``(x = 1, y(start = 2))`` behind a name."""

    span: Span
    arguments: tuple[tree.Modifier, ...]


@dataclass(frozen=True, slots=True)
class Condition:
    """``if c`` behind a component."""

    expression: tree.Expression


@dataclass(frozen=True, slots=True)
class Declarator:
    """One name of a component clause with what belongs to it alone."""

    name: Token
    dimensions: tuple[tree.Expression, ...]
    modifiers: tuple[tree.Modifier, ...]
    value: tree.Expression | None
    condition: tree.Expression | None
    description: str
    annotation: tree.Annotation | None


class Constraint:
    """``constrainedby T``: read, and of no further use."""


class External:
    """``external ...``: only its presence matters."""


_CONSTRAINT = Constraint()
_EXTERNAL = External()


class ClassBuilder(EquationBuilder):
    """Makes the nodes of classes and what is declared in them."""

    def long_class(self, children: list[Any]) -> tree.ClassDefinition:
        end_name = children[-1]
        prefixes: list[Token] = []
        for child in children:
            if child.type == "KIND":
                break
            prefixes.append(child)
        position = len(prefixes)
        kind, name = children[position : position + 2]
        if str(end_name) != str(name):
            fail(
                "P004",
                f"{kind} {name} is closed by 'end {end_name}'",
                self._at(end_name),
                label=f"expected {name}",
                labels=[Label(self._at(name), f"{kind} {name} begins here")],
                help=f"write 'end {name};' here, or close {name} before this line",
            )
        body = children[position + 2 : -2]
        inner = [c for c in body if isinstance(c, tree.Node)]
        result = assemble_class(
            span=self._at(name),
            kind=str(kind),
            name=str(name),
            prefixes=check_prefixes(prefixes, "class", self._at),
            body=body,
            place=self._at,
        )
        self._nest(result, inner)
        return result

    def short_class(self, children: list[Any]) -> tree.ClassDefinition:
        before: list[Token] = []
        behind: list[Token] = []
        kind = name = base = None
        dimensions: tuple[tree.Expression, ...] = ()
        modifiers: tuple[tree.Modifier, ...] = ()
        description = ""
        annotation = None
        for child in children:
            if isinstance(child, Token):
                if child.type == "PREFIX":
                    (before if kind is None else behind).append(child)
                elif child.type == "KIND":
                    kind = child
                elif child.type == "IDENT":
                    name = child
            elif isinstance(child, tree.Reference):
                base = child
            elif isinstance(child, Subscripts):
                dimensions = child.items
            elif isinstance(child, Modification):
                modifiers = child.arguments
            elif isinstance(child, tree.Annotation):
                annotation = child
            elif isinstance(child, str):
                description = child
        assert kind is not None
        assert name is not None
        prefixes = check_prefixes(before, "class", self._at)
        return tree.ClassDefinition(
            self._at(name),
            str(kind),
            str(name),
            partial="partial" in prefixes,
            prefixes=tuple(p for p in prefixes if p != "partial"),
            description=description,
            alias=base,
            alias_dimensions=dimensions,
            alias_modifiers=modifiers,
            alias_prefixes=check_prefixes(behind, "component", self._at),
            annotation=annotation,
        )

    def enumeration_class(self, children: list[Any]) -> tree.ClassDefinition:
        prefixes = []
        literals: list[tuple[str, str]] = []
        description = ""
        annotation = None
        kind = name = None
        for child in children:
            if isinstance(child, Token):
                if child.type == "PREFIX":
                    prefixes.append(child)
                elif child.type == "KIND":
                    kind = child
                elif child.type == "IDENT":
                    name = child
                elif child.type == "COLON":
                    fail(
                        "P025",
                        "an enumeration without literals is not supported",
                        self._at(child),
                        help="list the literals: enumeration(first, second)",
                    )
            elif isinstance(child, tuple):
                literals.append(child)
            elif isinstance(child, tree.Annotation):
                annotation = child
            else:
                description = child
        assert kind is not None
        assert name is not None
        if kind != "type":
            fail(
                "P025",
                f"an enumeration is declared with 'type', not with '{kind}'",
                self._at(kind),
                help=f"write 'type {name} = enumeration(...)'",
            )
        return tree.ClassDefinition(
            self._at(name),
            str(kind),
            str(name),
            prefixes=check_prefixes(prefixes, "class", self._at),
            description=description,
            enumeration=tuple(literals),
            annotation=annotation,
        )

    def class_extends(self, children: list[Any]) -> NoReturn:
        token = next(c for c in children if isinstance(c, Token) and c.type == "EXTENDS")
        fail(
            "P025",
            "a class that redeclares an inherited one ('extends' behind the kind) is not supported",
            self._at(token),
            help="give the class a new name and write 'extends Base;' in its body",
        )

    def derivative_class(self, children: list[Any]) -> NoReturn:
        token = next(c for c in children if isinstance(c, Token) and c.type == "DER")
        fail(
            "P025",
            "a function defined as a partial derivative is not supported",
            self._at(token),
            help="write the derivative as a function with an algorithm",
        )

    def literal(self, children: list[Any]) -> tuple[str, str]:
        description = children[1] if len(children) > 1 else ""
        return str(children[0]), description if type(description) is str else ""

    def import_name(self, children: list[Any]) -> tree.ImportClause:
        names = _tokens(children)
        return tree.ImportClause(self._span(names[0], names[-1]), tuple(map(str, names[1:])))

    def import_renamed(self, children: list[Any]) -> tree.ImportClause:
        names = _tokens(children)
        path = tuple(map(str, names[3:]))
        return tree.ImportClause(self._span(names[0], names[-1]), path, alias=str(names[1]))

    def import_wildcard(self, children: list[Any]) -> tree.ImportClause:
        names = _tokens(children)
        path = tuple(map(str, names[1:-1]))
        return tree.ImportClause(self._span(names[0], names[-1]), path, wildcard=True)

    def import_list(self, children: list[Any]) -> tree.ImportClause:
        tokens = _tokens(children)
        brace = next(i for i, t in enumerate(tokens) if t.type == "LBRACE")
        path = tuple(map(str, tokens[1:brace]))
        names = tuple(map(str, tokens[brace + 1 :]))
        return tree.ImportClause(self._span(tokens[0], tokens[-1]), path, names=names)

    def extends_clause(self, children: list[Any]) -> tree.ExtendsClause:
        modifiers = children[2].arguments if _is(children, 2, Modification) else ()
        return tree.ExtendsClause(self._span(children[0], children[1]), children[1], modifiers)

    def component(self, children: list[Any]) -> Declarator:
        name = children[0]
        dimensions: tuple[tree.Expression, ...] = ()
        modifiers: tuple[tree.Modifier, ...] = ()
        value = condition = annotation = None
        description = ""
        for child in children[1:]:
            if isinstance(child, tree.Expression):
                value = child
            elif isinstance(child, Token):
                continue
            elif isinstance(child, Modification):
                modifiers = child.arguments
            elif isinstance(child, str):
                description = child
            elif isinstance(child, Subscripts):
                dimensions = child.items
            elif isinstance(child, Condition):
                condition = child.expression
            else:
                annotation = child
        return Declarator(name, dimensions, modifiers, value, condition, description, annotation)

    def component_clause(self, children: list[Any]) -> list[tree.ComponentDeclaration]:
        prefixes: list[Token] = []
        type_dimensions: tuple[tree.Expression, ...] = ()
        result = []
        type_name = None
        words: tuple[str, ...] = ()
        for child in children:
            if isinstance(child, Declarator):
                assert type_name is not None  # the grammar puts the type first
                result.append(
                    tree.ComponentDeclaration(
                        self._at(child.name),
                        str(child.name),
                        type_name,
                        child.dimensions + type_dimensions,
                        child.modifiers,
                        child.value,
                        child.condition,
                        words,
                        True,
                        child.description,
                        child.annotation,
                    )
                )
            elif isinstance(child, Token):
                prefixes.append(child)
            elif isinstance(child, tree.Reference):
                type_name = child
                if prefixes:
                    words = check_prefixes(prefixes, "component", self._at)
            elif isinstance(child, Subscripts):
                type_dimensions = child.items
        assert type_name is not None
        if type_name.parts[0].name.lower() in _SECTION_LIKE:
            self._refuse_section(type_name, result[0])
        return result

    def _refuse_section(
        self, type_name: tree.Reference, component: tree.ComponentDeclaration
    ) -> None:
        """Refuse ``Equation`` on a line of its own, which reads as the type of what follows.

        Raises:
            AcausalError: P001.
        """
        word = str(type_name)
        if type_name.span.line < component.span.line:
            fail(
                "P001",
                f"'{word}' is not a word of the language",
                type_name.span,
                help=f"write '{word.lower().removesuffix('s')}'",
            )

    def condition(self, children: list[Any]) -> Condition:
        return Condition(children[1])

    def constraint(self, children: list[Any]) -> Constraint:
        return _CONSTRAINT

    def external(self, children: list[Any]) -> External:
        return _EXTERNAL

    def type_name(self, children: list[Any]) -> tree.Reference:
        return self.reference(children)

    def description(self, children: list[Any]) -> str:
        for token in children[1::2]:
            if token != "+":
                fail(
                    "P001",
                    f"description strings are joined with '+', not with '{token}'",
                    self._at(token),
                    help="write '+', or one single string",
                )
        return "".join(self._text(token) for token in children[::2])

    def annotation(self, children: list[Any]) -> tree.Annotation:
        span = self._span(children[0], children[1])
        return tree.Annotation(span, children[1].arguments)

    def class_modification(self, children: list[Any]) -> Modification:
        return Modification(self._span(children[0], children[-1]), tuple(children[1:-1]))

    def modifier(self, children: list[Any]) -> tree.Modifier:
        each = final = False
        name: list[Token] = []
        nested: tuple[tree.Modifier, ...] = ()
        value = None
        last: Any = None
        first: Any = None
        for child in children:
            if isinstance(child, Token):
                if child.type == "IDENT":
                    name.append(child)
                    last = child
                    first = first or child
                elif child.type == "PREFIX":
                    if child == "each":
                        each = True
                    elif child == "final":
                        final = True
                    else:
                        check_prefixes([child], "modifier", self._at)
            elif isinstance(child, tree.Expression):
                value = last = child
            elif isinstance(child, Modification):
                nested = child.arguments
                last = child
        span = self._span(first, last)
        return tree.Modifier(span, tuple(map(str, name)), value, nested, each, final)

    def redeclared_component(self, children: list[Any]) -> tree.Modifier:
        component = self.component_clause(
            [c for c in children if not (isinstance(c, Token) and c == "each")]
        )[0]
        if not {"redeclare", "replaceable"} & set(component.prefixes):
            fail(
                "P020",
                f"'{component.type_name} {component.name}' looks like a declaration inside a"
                " modification",
                component.type_name.span.to(component.span),
                help=f"write '{component.name} = value', or 'redeclare {component.type_name}"
                f" {component.name}'",
            )
        return tree.Modifier(
            component.span,
            (component.name,),
            each="each" in children,
            final="final" in component.prefixes,
            redeclaration=component,
        )

    def redeclared_class(self, children: list[Any]) -> tree.Modifier:
        definition = children[0]
        return tree.Modifier(
            definition.span,
            (definition.name,),
            final="final" in definition.prefixes,
            redeclaration=definition,
        )


def _tokens(children: list[Any]) -> list[Token]:
    return [c for c in children if isinstance(c, Token)]


def _is(children: list[Any], position: int, kind: type) -> bool:
    return len(children) > position and isinstance(children[position], kind)
