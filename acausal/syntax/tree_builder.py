"""Callbacks of the LALR parser: each reduction makes its node of :mod:`acausal.syntax.tree`.

The parser calls the method named after the rule with the list of its children: tokens that the
grammar keeps and nodes that were made before. No parse tree of Lark's own is ever built.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NoReturn

from lark import Token, Transformer

from acausal.diagnostics import Label, Span, fail
from acausal.syntax import tree
from acausal.syntax.class_assembly import assemble_class, check_prefixes
from acausal.syntax.precedence import resolve_operators

MAXIMAL_NESTING = 150
"""Blocks, classes and if-expressions inside each other; deeper text is refused."""

_ESCAPES = {
    "'": "'",
    '"': '"',
    "?": "?",
    "\\": "\\",
    "a": "\a",
    "b": "\b",
    "f": "\f",
    "n": "\n",
    "r": "\r",
    "t": "\t",
    "v": "\v",
}


@dataclass(frozen=True, slots=True)
class Subscripts:
    """``[a, b]`` behind a name."""

    span: Span
    items: tuple[tree.Expression, ...]


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


class TreeBuilder(Transformer[Token, Any]):
    """Makes the tree of one source; set ``source`` with :meth:`begin` before each parse."""

    def __init__(self) -> None:
        super().__init__()
        self.begin("<text>")

    def begin(self, source: str) -> None:
        """Forget the last parse; ``source`` goes into the spans that follow."""
        self.source = source
        self._depth: dict[int, int] = {}
        self._open_ends: list[Span] = []

    # --- places --------------------------------------------------------------------------

    def _at(self, token: Token) -> Span:
        return Span(self.source, token.line, token.column, token.end_line, token.end_column)  # type: ignore[arg-type]

    def _span(self, first: Any, last: Any) -> Span:
        """Return the span from one child to another, each a token or a node."""
        if isinstance(first, Token):
            line, column = first.line, first.column
        else:
            line, column = first.span.line, first.span.column
        if isinstance(last, Token):
            end_line, end_column = last.end_line, last.end_column
        else:
            end_line, end_column = last.span.end_line, last.span.end_column
        return Span(self.source, line, column, end_line, end_column)  # type: ignore[arg-type]

    def _nest(self, node: tree.Node, inner: list[Any]) -> None:
        """Note how deep ``node`` is nested, and refuse what no later stage could walk.

        Raises:
            AcausalError: P026.
        """
        depths = self._depth
        depth = 1 + max((depths.get(id(child), 0) for child in inner), default=0)
        depths[id(node)] = depth
        if depth > MAXIMAL_NESTING:
            fail(
                "P026",
                f"more than {MAXIMAL_NESTING} blocks or conditions inside each other",
                node.span,
                help="split it into several classes, equations or functions",
            )

    # --- files and classes ---------------------------------------------------------------

    def file(self, children: list[Any]) -> tree.File:
        if self._open_ends:
            fail(
                "P024",
                "'end' as a number has a meaning only inside the brackets of a subscript",
                self._open_ends[0],
                help="write x[end], or size(x, 1) for the length of x",
            )
        within: tuple[str, ...] = ()
        imports = []
        classes = []
        for child in children:
            if isinstance(child, tree.ImportClause):
                imports.append(child)
            elif isinstance(child, tree.ClassDefinition):
                classes.append(child)
            else:
                within = child
        if children:
            first = next((c for c in children if isinstance(c, tree.Node)), None)
            span = first.span if first is not None else Span(self.source, 1, 1, 1, 1)
            if classes:
                span = span.to(classes[-1].span)
        else:
            span = Span(self.source, 1, 1, 1, 1)
        return tree.File(span, within, tuple(imports), tuple(classes))

    def expression_only(self, children: list[Any]) -> tree.Expression:
        if self._open_ends:
            fail("P024", "'end' has a meaning only inside a subscript", self._open_ends[0])
        expression: tree.Expression = children[0]
        return expression

    def within(self, children: list[Any]) -> tuple[str, ...]:
        return tuple(str(t) for t in children[1:])

    def long_class(self, children: list[Any]) -> tree.ClassDefinition:
        end_name = children[-1]
        prefixes: list[Token] = []
        for position, child in enumerate(children):
            if child.type == "KIND":
                break
            prefixes.append(child)
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
        assert kind is not None and name is not None
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
        assert kind is not None and name is not None
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

    # --- imports, extends, components ----------------------------------------------------

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
                if type_name is None:  # pragma: no cover - the grammar puts the type first
                    raise AssertionError
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
        return result

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
                )
        return "".join(self._text(token) for token in children[::2])

    def annotation(self, children: list[Any]) -> tree.Annotation:
        span = self._span(children[0], children[1])
        return tree.Annotation(span, children[1].arguments)

    # --- modifiers -----------------------------------------------------------------------

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

    # --- equations -----------------------------------------------------------------------

    def simple_equation(self, children: list[Any]) -> tree.SimpleEquation:
        left, right = children[0], children[2]
        return tree.SimpleEquation(left.span.to(right.span), _description(children), left, right)

    def call_equation(self, children: list[Any]) -> tree.CallEquation:
        call = children[0]
        if not isinstance(call, tree.Call):
            if isinstance(call, tree.Binary) and call.operator == "==":
                fail(
                    "P014",
                    "'==' compares two values; an equation is written with '='",
                    self._between(call.left.span, call.right.span),
                    help="write a single '='",
                )
            fail(
                "P019",
                "this is an expression, not an equation",
                call.span,
                help="an equation has the form 'left = right'",
            )
        return tree.CallEquation(call.span, _description(children), call)

    def connect_equation(self, children: list[Any]) -> tree.ConnectEquation:
        cuts = tuple(c for c in children if isinstance(c, tree.Reference))
        span = self._whole(children)
        if len(cuts) < 2:
            fail(
                "P012",
                f"connect needs at least two cuts and has {'one' if cuts else 'none'}",
                span,
                help="write connect(a.p, b.n), with as many cuts as meet at the junction",
            )
        return tree.ConnectEquation(span, _description(children), cuts)

    def tuple_target(self, children: list[Any]) -> tree.TupleExpression:
        elements: list[tree.Expression | None] = [None]
        for child in children[1:-1]:
            if isinstance(child, Token):
                elements.append(None)
            else:
                elements[-1] = child
        return tree.TupleExpression(self._span(children[0], children[-1]), tuple(elements))

    def index(self, children: list[Any]) -> tree.ForIndex:
        span = self._span(children[0], children[-1])
        return tree.ForIndex(span, str(children[0]), children[2] if len(children) > 1 else None)

    def for_equation(self, children: list[Any]) -> tree.ForEquation:
        indices, body = _loop(children)
        node = tree.ForEquation(self._whole(children), _description(children), indices, body)
        self._nest(node, children)
        return node

    def if_equation(self, children: list[Any]) -> tree.IfEquation:
        branches, otherwise = _branches(children)
        node = tree.IfEquation(self._whole(children), _description(children), branches, otherwise)
        self._nest(node, children)
        return node

    def when_equation(self, children: list[Any]) -> tree.WhenEquation:
        branches, _ = _branches(children)
        node = tree.WhenEquation(self._whole(children), _description(children), branches)
        self._nest(node, children)
        return node

    # --- statements ----------------------------------------------------------------------

    def assignment(self, children: list[Any]) -> tree.Assignment:
        target, value = children[0], children[2]
        span = target.span.to(value.span)
        if isinstance(target, tree.TupleExpression) and not isinstance(value, tree.Call):
            fail(
                "P024",
                "several names in parentheses take their values from one function call",
                value.span,
                help="write (a, b) := f(x), or one assignment for each name",
            )
        return tree.Assignment(span, _description(children), target, value)

    def assigned_tuple(self, children: list[Any]) -> tree.TupleExpression:
        return self.tuple_target(children)

    def call_statement(self, children: list[Any]) -> tree.CallStatement:
        return tree.CallStatement(children[0].span, _description(children), children[0])

    def for_statement(self, children: list[Any]) -> tree.ForStatement:
        indices, body = _loop(children)
        node = tree.ForStatement(self._whole(children), _description(children), indices, body)
        self._nest(node, children)
        return node

    def while_statement(self, children: list[Any]) -> tree.WhileStatement:
        body = tuple(c for c in children[2:] if isinstance(c, tree.Statement))
        node = tree.WhileStatement(
            self._whole(children), _description(children), children[1], body
        )
        self._nest(node, children)
        return node

    def if_statement(self, children: list[Any]) -> tree.IfStatement:
        branches, otherwise = _branches(children)
        node = tree.IfStatement(self._whole(children), _description(children), branches, otherwise)
        self._nest(node, children)
        return node

    def when_statement(self, children: list[Any]) -> tree.WhenStatement:
        branches, _ = _branches(children)
        node = tree.WhenStatement(self._whole(children), _description(children), branches)
        self._nest(node, children)
        return node

    def return_statement(self, children: list[Any]) -> tree.ReturnStatement:
        return tree.ReturnStatement(self._at(children[0]), _description(children))

    def break_statement(self, children: list[Any]) -> tree.BreakStatement:
        return tree.BreakStatement(self._at(children[0]), _description(children))

    def _whole(self, children: list[Any]) -> Span:
        """Return the span of a block, from its keyword to the one behind its ``end``."""
        last = children[-1]
        for child in reversed(children):
            if isinstance(child, Token):
                last = child
                break
        return self._span(children[0], last)

    def _between(self, left: Span, right: Span) -> Span:
        return Span(self.source, left.end_line, left.end_column, right.line, right.column)

    # --- expressions ---------------------------------------------------------------------

    def simple_expression(self, children: list[Any]) -> tree.Expression:
        colons = [i for i, c in enumerate(children) if isinstance(c, Token) and c.type == "COLON"]
        if not colons:
            return resolve_operators(children, self._at)
        bounds = [-1, *colons, len(children)]
        parts = [
            resolve_operators(children[a + 1 : b], self._at)
            for a, b in zip(bounds, bounds[1:], strict=False)
        ]
        step = parts[1] if len(parts) == 3 else None
        span = parts[0].span.to(parts[-1].span)
        return tree.RangeExpression(span, parts[0], step, parts[-1])

    def if_expression(self, children: list[Any]) -> tree.IfExpression:
        parts = [c for c in children if isinstance(c, tree.Expression)]
        branches = tuple(zip(parts[:-1:2], parts[1:-1:2], strict=True))
        node = tree.IfExpression(self._span(children[0], parts[-1]), branches, parts[-1])
        self._nest(node, parts)
        return node

    def number(self, children: list[Any]) -> tree.NumberLiteral:
        token = children[0]
        span = self._at(token)
        unit = None
        text = str(token)
        if token.type == "QUANTITY":
            text, _, unit = text.partition("[")
            text = text.rstrip()
            unit = unit[:-1].strip()
            if not unit:
                fail(
                    "P015",
                    "the brackets behind a number hold its unit and are empty",
                    span,
                    help=f"write {text}[1] for a number without unit, or {text}",
                )
        value = float(text)
        if value == float("inf"):
            fail("P022", f"the number {_short(text)} is too large for a double", span)
        return tree.NumberLiteral(span, value, text.isdigit(), unit)

    def string(self, children: list[Any]) -> tree.StringLiteral:
        return tree.StringLiteral(self._at(children[0]), self._text(children[0]))

    def boolean(self, children: list[Any]) -> tree.BooleanLiteral:
        return tree.BooleanLiteral(self._at(children[0]), children[0].type == "TRUE")

    def end(self, children: list[Any]) -> tree.End:
        span = self._at(children[0])
        self._open_ends.append(span)
        return tree.End(span)

    def colon(self, children: list[Any]) -> tree.Colon:
        return tree.Colon(self._at(children[0]))

    def parenthesised(self, children: list[Any]) -> tree.Expression:
        # The span takes the parentheses in, so that a message never shows half of a pair.
        inner: tree.Expression = children[1]
        result = replace(inner, span=self._span(children[0], children[2]))
        depth = self._depth.get(id(inner))
        if depth is not None:
            self._depth[id(result)] = depth
        return result

    def array(self, children: list[Any]) -> tree.ArrayLiteral:
        span = self._span(children[0], children[-1])
        return tree.ArrayLiteral(span, tuple(children[1:-1]))

    def comprehension(self, children: list[Any]) -> tree.ArrayComprehension:
        span = self._span(children[0], children[-1])
        return tree.ArrayComprehension(span, children[1], tuple(children[3:-1]))

    def matrix(self, children: list[Any]) -> tree.MatrixLiteral:
        rows: list[list[tree.Expression]] = [[]]
        for child in children[1:-1]:
            if not isinstance(child, Token):
                rows[-1].append(child)
            elif child.type == "SEMICOLON":
                rows.append([])
        return tree.MatrixLiteral(
            self._span(children[0], children[-1]), tuple(tuple(row) for row in rows)
        )

    def reference(self, children: list[Any]) -> tree.Reference:
        first = children[0]
        if len(children) == 1:
            span = self._at(first)
            return tree.Reference(span, (tree.NamePart(span, str(first)),))
        absolute = first.type == "DOT"
        parts: list[tree.NamePart] = []
        for child in children[1:] if absolute else children:
            if isinstance(child, Subscripts):
                part = parts[-1]
                parts[-1] = tree.NamePart(part.span.to(child.span), part.name, child.items)
            else:
                parts.append(tree.NamePart(self._at(child), str(child)))
        start = self._at(first) if absolute else parts[0].span
        return tree.Reference(start.to(parts[-1].span), tuple(parts), absolute)

    def subscripts(self, children: list[Any]) -> Subscripts:
        start = (children[0].line, children[0].column)
        while self._open_ends:
            place = self._open_ends[-1]
            if (place.line, place.column) < start:
                break
            self._open_ends.pop()
        return Subscripts(self._span(children[0], children[-1]), tuple(children[1:-1]))

    def call(self, children: list[Any]) -> tree.Call:
        function = children[0]
        arguments = []
        named = []
        indices = []
        for child in children[1:-1]:
            if isinstance(child, tree.Expression):
                arguments.append(child)
            elif isinstance(child, tree.NamedArgument):
                named.append(child)
            elif isinstance(child, tree.ForIndex):
                indices.append(child)
        return tree.Call(
            self._span(function, children[-1]),
            function,
            tuple(arguments),
            tuple(named),
            tuple(indices),
        )

    def function_keyword(self, children: list[Any]) -> tree.Reference:
        return self.reference(children)

    def named(self, children: list[Any]) -> tree.NamedArgument:
        return tree.NamedArgument(
            self._span(children[0], children[2]), str(children[0]), children[2]
        )

    def _text(self, token: Token) -> str:
        """Return the content of a string token, escapes resolved.

        Raises:
            AcausalError: P023.
        """
        text = str(token)[1:-1]
        if "\\" not in text:
            return text
        pieces = []
        position = 0
        while True:
            slash = text.find("\\", position)
            if slash < 0:
                pieces.append(text[position:])
                return "".join(pieces)
            pieces.append(text[position:slash])
            mark = text[slash + 1]
            if mark not in _ESCAPES:
                before = text[:slash]
                line = token.line + before.count("\n")  # type: ignore[operator]
                column = (
                    len(before) - before.rfind("\n")
                    if "\n" in before
                    else token.column + 1 + len(before)  # type: ignore[operator]
                )
                fail(
                    "P023",
                    f"'\\{mark}' is not an escape sequence of a string",
                    Span(self.source, line, column, line, column + 2),
                    help="write '\\\\' for a backslash itself; known are"
                    " \\n \\t \\r \\\" \\' \\\\ \\? \\a \\b \\f \\v",
                )
            pieces.append(_ESCAPES[mark])
            position = slash + 2


def _tokens(children: list[Any]) -> list[Token]:
    return [c for c in children if isinstance(c, Token)]


def _is(children: list[Any], position: int, kind: type) -> bool:
    return len(children) > position and isinstance(children[position], kind)


def _description(children: list[Any]) -> str:
    for child in children[-2:]:
        if type(child) is str:
            return child
    return ""


def _short(text: str) -> str:
    return text if len(text) <= 24 else text[:20] + "..."


def _loop(children: list[Any]) -> tuple[tuple[tree.ForIndex, ...], tuple[Any, ...]]:
    indices = tuple(c for c in children if isinstance(c, tree.ForIndex))
    body = tuple(c for c in children if isinstance(c, tree.Equation | tree.Statement))
    return indices, body


def _branches(children: list[Any]) -> tuple[tuple[tuple[Any, tuple[Any, ...]], ...], tuple[Any, ...]]:
    """Split the flat children of an if or when into conditions with bodies, and the else part."""
    branches: list[tuple[tree.Expression, list[Any]]] = []
    otherwise: list[Any] = []
    body: list[Any] = otherwise
    for child in children:
        if isinstance(child, tree.Expression):
            body = []
            branches.append((child, body))
        elif isinstance(child, tree.Equation | tree.Statement):
            body.append(child)
        elif isinstance(child, Token):
            if child.type == "ELSE":
                body = otherwise
            elif child.type == "END":
                break
    return tuple((c, tuple(b)) for c, b in branches), tuple(otherwise)
