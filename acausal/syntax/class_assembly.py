"""Sorts what stands in a class into the fields of its definition, and checks prefixes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from acausal.diagnostics import Span, fail
from acausal.syntax import tree

if TYPE_CHECKING:
    from lark import Token

_CLASS_PREFIXES = frozenset(
    (
        "encapsulated",
        "partial",
        "final",
        "replaceable",
        "redeclare",
        "expandable",
        "operator",
        "pure",
        "impure",
        "inner",
        "outer",
        "each",
    )
)
_COMPONENT_PREFIXES = frozenset(
    (
        "parameter",
        "constant",
        "discrete",
        "flow",
        "across",
        "through",
        "stream",
        "input",
        "output",
        "inner",
        "outer",
        "final",
        "replaceable",
        "redeclare",
    )
)
_MODIFIER_PREFIXES = frozenset(("each", "final"))
_ALLOWED = {
    "class": (_CLASS_PREFIXES, "a class"),
    "component": (_COMPONENT_PREFIXES, "a component or variable"),
    "modifier": (_MODIFIER_PREFIXES, "a modifier"),
}
_EXCLUSIVE = (
    ("parameter", "constant", "discrete"),
    ("across", "through", "stream"),
    ("input", "output"),
    ("pure", "impure"),
)


def check_prefixes(
    tokens: Sequence[Token], what: str, place: Callable[[Token], Span]
) -> tuple[str, ...]:
    """Return the prefixes as words, ``flow`` as ``through``.

    Args:
        tokens: The prefixes as written.
        what: What they stand before: ``class``, ``component`` or ``modifier``.
        place: Gives the span of a token.

    Raises:
        AcausalError: P020 for a prefix that cannot stand here, twice the same, or two that
            exclude each other.
    """
    allowed, noun = _ALLOWED[what]
    words: list[str] = []
    for token in tokens:
        word = str(token)
        if word not in allowed:
            fail(
                "P020",
                f"'{word}' cannot stand before {noun}",
                place(token),
                help=f"remove '{word}'",
            )
        word = "through" if word == "flow" else word
        if word in words:
            fail("P020", f"'{token}' is written twice", place(token), help="remove one of them")
        for group in _EXCLUSIVE:
            other = next((w for w in words if w in group), None)
            if word in group and other is not None:
                fail(
                    "P020",
                    f"'{other}' and '{token}' exclude each other",
                    place(token),
                    help="keep one of them",
                )
        words.append(word)
    return tuple(words)


def assemble_class(
    span: Span,
    kind: str,
    name: str,
    prefixes: tuple[str, ...],
    body: Sequence[Any],
    place: Callable[[Token], Span],
) -> tree.ClassDefinition:
    """Return the definition of a class written out in full.

    Args:
        span: Place of the class's name.
        kind: ``model``, ``connector`` and so on.
        name: The class's name.
        prefixes: The checked prefixes.
        body: Description, elements, section keywords, equations and statements as they come.
        place: Gives the span of a token.

    Raises:
        AcausalError: P020 for a connector or record with equations.
    """
    description = ""
    imports: list[tree.ImportClause] = []
    extends: list[tree.ExtendsClause] = []
    components: list[tree.ComponentDeclaration] = []
    classes: list[tree.ClassDefinition] = []
    equations: list[tree.Equation] = []
    initial_equations: list[tree.Equation] = []
    algorithms: list[list[tree.Statement]] = []
    initial_algorithms: list[list[tree.Statement]] = []
    annotations: list[tree.Annotation] = []
    external = False
    public = True
    initial = False
    section: list[Any] = []
    for item in body:
        if isinstance(item, tree.Equation | tree.Statement):
            section.append(item)
        elif isinstance(item, list):
            components += item if public else [replace(c, public=False) for c in item]
        elif isinstance(item, tree.ClassDefinition):
            classes.append(item)
        elif isinstance(item, tree.ExtendsClause):
            extends.append(item if public else replace(item, public=False))
        elif isinstance(item, tree.ImportClause):
            imports.append(item)
        elif isinstance(item, tree.Annotation):
            annotations.append(item)
        elif type(item) is str:
            description = item
        elif isinstance(item, str):
            word: Token = item  # type: ignore[assignment]
            if word.type == "PUBLIC":
                public = True
            elif word.type == "PROTECTED":
                public = False
            elif word.type == "INITIAL":
                initial = True
            elif word.type == "EQUATION":
                section = initial_equations if initial else equations
                initial = False
            elif word.type == "ALGORITHM":
                section = []
                (initial_algorithms if initial else algorithms).append(section)
                initial = False
        elif type(item).__name__ == "External":
            external = True
    return tree.ClassDefinition(
        span,
        kind,
        name,
        partial="partial" in prefixes,
        prefixes=tuple(p for p in prefixes if p != "partial"),
        description=description,
        imports=tuple(imports),
        extends=tuple(extends),
        components=tuple(components),
        classes=tuple(classes),
        equations=tuple(equations),
        initial_equations=tuple(initial_equations),
        algorithms=tuple(tuple(s) for s in algorithms),
        initial_algorithms=tuple(tuple(s) for s in initial_algorithms),
        external=external,
        annotation=_merge(annotations),
    )


def _merge(annotations: list[tree.Annotation]) -> tree.Annotation | None:
    if not annotations:
        return None
    if len(annotations) == 1:
        return annotations[0]
    arguments = tuple(a for annotation in annotations for a in annotation.arguments)
    return tree.Annotation(annotations[0].span, arguments)
