"""Text to syntax tree: an LALR parser with a contextual lexer, made by Lark from the grammar."""

from __future__ import annotations

import threading
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from acausal.diagnostics import Span, fail
from acausal.syntax import tree

if TYPE_CHECKING:
    from lark import Lark

    from acausal.syntax.tree_builder import TreeBuilder

_LOCK = threading.Lock()


def parse_text(text: str, source: str) -> tree.File:
    """Parse a source file given as text.

    Args:
        text: The whole text.
        source: What spans and messages call it: a path, or a name in angle brackets.

    Raises:
        AcausalError: The first syntax error, with its place and what to do.
    """
    from acausal.syntax.source_text import check_text

    checked = check_text(text, source)
    result = _parse(checked, source, "file")
    assert isinstance(result, tree.File)
    if not result.classes:
        fail(
            "F106",
            f"{source} {'holds no class' if checked.strip() else 'is empty'}",
            Span(source, 1, 1, 1, 1),
            help="a model begins with 'model Name' and ends with 'end Name;'",
        )
    return result


def parse_file(path: Path | str) -> tree.File:
    """Parse a file.

    Raises:
        AcausalError: The file cannot be read (F101 to F104, P030, P035), or the first syntax
            error in it.
    """
    from acausal.syntax.source_text import read_source

    return parse_text(read_source(Path(path)), str(path))


def parse_expression(text: str, source: str = "<expression>") -> tree.Expression:
    """Parse a single expression, such as a value given on the command line.

    Raises:
        AcausalError: The first syntax error.
    """
    from acausal.syntax.source_text import check_text

    result = _parse(check_text(text, source), source, "expression_only")
    assert isinstance(result, tree.Expression)
    return result


def _parse(text: str, source: str, start: str) -> tree.Node:
    from lark.exceptions import UnexpectedInput

    with _LOCK:
        lark, builder = _machine()
        builder.begin(source)
        try:
            result: tree.Node = lark.parse(text, start=start)  # type: ignore[assignment]
        except UnexpectedInput as error:
            from acausal.syntax.errors import explain

            explain(error, text, source, start)
    return result


@cache
def _machine() -> tuple[Lark, TreeBuilder]:
    """Return the parser and its callbacks; the parser's tables come from the cache if they can."""
    from lark import Lark

    from acausal.syntax.grammar_cache import load_tables, save_tables
    from acausal.syntax.tree_builder import TreeBuilder

    builder = TreeBuilder()
    grammar = grammar_text()
    lark = load_tables(grammar, builder)
    if lark is None:
        lark = Lark(
            grammar,
            parser="lalr",
            lexer="contextual",
            start=["file", "expression_only"],
            transformer=builder,
            propagate_positions=False,
        )
        save_tables(lark, grammar)
    return lark, builder


@cache
def grammar_text() -> str:
    """Return the grammar in Lark's notation."""
    return resources.files("acausal.syntax").joinpath("grammar.lark").read_text(encoding="utf-8")
