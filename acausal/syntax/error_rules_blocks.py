"""Rules for syntax errors in blocks, sections and classes.

Each rule looks at the surroundings of an error and raises its diagnostic if it knows the cause.
"""

from __future__ import annotations

from typing import NoReturn

from acausal.diagnostics import Label, fail
from acausal.syntax.error_context import (
    CLASS_KINDS,
    OPERATORS,
    PREFIX_WORDS,
    SECTION_WORDS,
    Block,
    Context,
    Lexeme,
)
from acausal.syntax.error_rules_tokens import report_case
from acausal.syntax.error_text import report_semicolon, shorten

_EQUATION_WORDS = frozenset(("connect", "der", "for", "when", "if", "while"))
_EQUATION_FUNCTIONS = frozenset(("assert", "reinit", "terminate"))


def missing_keyword(c: Context) -> None:
    """Find a missing 'then', 'loop' or 'else'."""
    token, previous = c.token, c.previous
    if previous is None:
        return
    if token is not None and (token.text in OPERATORS or token.text in ("=", ":=", "(", "[", ".")):
        return
    for terminal, reason in (
        ("THEN", "behind the condition"),
        ("LOOP", "behind the range of the loop"),
    ):
        if terminal in c.accepts:
            word = terminal.lower()
            condition = "if c" if word == "then" else "for i in 1:n"
            if c.item and c.item[0].text in ("when", "elsewhen", "while"):
                condition = f"{c.item[0].text} c"
            fail(
                "P005",
                f"'{word}' is missing {reason}",
                c.behind(previous),
                help=f"write '{condition} {word}'",
            )
    if (
        "ELSE" in c.accepts
        and "SEMICOLON" not in c.accepts
        and "END" not in c.accepts
        and not (token is not None and token.is_name and not c.on_new_line)
    ):
        fail(
            "P005",
            "an if-expression needs 'else': it must have a value in every case",
            c.behind(previous),
            help="write 'if c then a else b'",
        )


def block_ends(c: Context) -> None:
    """Find a missing 'end', and one that does not fit."""
    previous, token = c.previous, c.token
    if previous is None or not c.blocks:
        return
    block = c.blocks[-1]
    if previous.text == "end" and not c.brackets:
        span = c.span(previous, token) if token is not None else c.span(previous)
        opened = [Label(c.span(block.opening), f"{block.title} begins here")]
        if token is None or token.text == ";":
            fail(
                "P004",
                f"'end' does not say what it closes: {block.title} is open",
                c.span(previous),
                labels=opened,
                help=f"write '{block.closing};'",
            )
        if block.is_class:
            fail(
                "P004",
                f"'end {shorten(token.text)}' closes nothing: {block.title} is open here",
                span,
                labels=opened,
                help=f"remove it, or write '{block.closing};'",
            )
        hint = f"add '{block.closing};' before this line"
        if block.after_else or block.closed_after_else:
            hint = "write 'elseif' in one word, or add a second 'end if;'"
        fail(
            "P003",
            f"{block.title} is not closed before 'end {shorten(token.text)}'",
            span,
            labels=opened,
            help=hint,
        )
    if token is None and not c.brackets:
        if "SEMICOLON" in c.accepts and c.item:
            report_semicolon(c, previous)
        for lexeme in c.before:
            if lexeme.text in ("End", "END"):
                report_case(c, lexeme)
        report_open_block(c, block, previous)
    starts_section = token is not None and token.text in SECTION_WORDS
    if token is not None and starts_section and not block.is_class and not c.item:
        fail(
            "P003",
            f"{block.title} is not closed before '{token.text}'",
            c.span(token),
            labels=[Label(c.span(block.opening), f"{block.title} begins here")],
            help=f"add '{block.closing};'",
        )


def report_open_block(c: Context, block: Block, last: Lexeme) -> NoReturn:
    """Raise P003 for a block that is open at the end of the text.

    A class that begins further left than the body of the open one, or as far left as it, shows
    where the missing end belongs.
    """
    labels = [Label(c.span(block.opening), f"{block.title} begins here")]
    margin = c.span(block.opening).column
    for kind, name in zip(c.tokens, c.tokens[1:], strict=False):
        if kind.start > block.opening.start and kind.text in CLASS_KINDS and name.is_name:
            place = c.span(kind)
            if place.column <= margin:
                labels.append(Label(place, f"{kind.text} {name.text} begins before it is closed"))
                break
    fail(
        "P003",
        f"the text ends, but {block.title} is still open",
        c.behind(last),
        labels=labels,
        help=f"add '{block.closing};'"
        + (f" before line {labels[1].span.line}" if len(labels) > 1 else ""),
    )


def sections(c: Context) -> None:
    """Equations among declarations, and declarations among equations."""
    token, block = c.token, c.enclosing_class
    if token is None or block is None or c.brackets:
        return
    if not c.blocks[-1].is_class:
        return
    first = c.item[0] if c.item else token
    if block.section == "elements":
        word = "algorithm" if block.kind == "function" else "equation"
        starts = not c.item and (token.text in _EQUATION_WORDS or token.text in ("-", "+", "("))
        names_only = bool(c.item) and all(t.is_name or t.text == "." for t in c.item)
        dotted = names_only and not any(
            a.is_name and b.is_name for a, b in zip(c.item, c.item[1:], strict=False)
        )
        operator = token.text in OPERATORS or token.text in ("=", ":=", "[")
        if c.item and c.item[-1].text == "]" and first.is_name and "[" in _texts(c.item[1:3]):
            # x[1] = 0 reads like the type x[1] without a name.
            dotted = token.text in ("=", ":=", ".") or token.text in OPERATORS
        called = token.text == "(" and first.text in _EQUATION_FUNCTIONS
        if starts or (dotted and (operator or called)):
            fail(
                "P013",
                f"this is no declaration; equations stand behind the word '{word}'"
                if word == "equation"
                else "this is no declaration; statements stand behind the word 'algorithm'",
                c.span(first, token),
                label=f"'{word}' is missing before this line",
                help=f"write '{word}' on a line of its own before the first of them",
            )
        if dotted and token.text in ("(", ";", ",", "if"):
            name = "".join(t.text for t in c.item)
            fail(
                "P001",
                f"this declaration of a {shorten(name)} has no name",
                c.behind(c.item[-1]),
                help=f"write '{shorten(name)} x' with the name of the component",
            )
    else:
        declared = not c.item and (token.text in PREFIX_WORDS or token.text in CLASS_KINDS)
        imported = not c.item and token.text in ("import", "extends")
        simple = bool(c.item) and all(t.is_name or t.text == "." for t in c.item)
        if declared and (c.following in ("=", ":=", ".", "(", "[") or c.following in OPERATORS):
            return
        if declared and token.text in CLASS_KINDS and not c.closes(block.name):
            report_open_block(c, block, c.tokens[-1])
        if declared or imported or (simple and token.is_name and not c.on_new_line):
            fail(
                "P021",
                f"a declaration cannot stand in the section '{block.section}'",
                c.span(first, token),
                help=f"move it before the word '{block.section}', or write 'public' before it",
            )


def _texts(lexemes: list[Lexeme]) -> list[str]:
    return [lexeme.text for lexeme in lexemes]


def missing_semicolon(c: Context) -> None:
    """Find a missing semicolon."""
    token, previous = c.token, c.previous
    if previous is None or "SEMICOLON" not in c.accepts or c.brackets:
        return
    if token is None:
        if not c.single:
            report_semicolon(c, previous)
        return
    starts = token.is_name or token.is_keyword or token.text == "("
    if c.on_new_line or starts:
        report_semicolon(c, previous)


def top_level(c: Context) -> None:
    """Find text outside of classes."""
    token = c.token
    if token is None or c.single or c.blocks:
        return
    if c.item and "KIND" not in c.accepts:
        return
    first = c.item[0] if c.item else token
    if token.text == "import":
        fail(
            "P027",
            "imports stand at the top of the file, before the first class",
            c.span(token),
            help="move it up, or into the class that needs it",
        )
    if token.text == "within":
        fail("P027", "'within' stands at the top of the file", c.span(token), help="move it up")
    if token.text == "end" and not c.item:
        fail(
            "P004",
            f"'end {shorten(c.following)}' closes nothing: all classes are closed",
            c.span(token),
            help="remove it, or look for an 'end' too many above",
        )
    lower = first.text.lower()
    if first.is_name and (lower in CLASS_KINDS or lower in PREFIX_WORDS):
        fail(
            "P016",
            f"'{first.text}' is not a word of the language",
            c.span(first),
            help=f"capital and small letters differ: write '{lower}'",
        )
    from difflib import get_close_matches

    close = get_close_matches(lower, sorted(CLASS_KINDS), n=1) if first.is_name else []
    where = "behind the last class" if c.before else "outside of a class"
    fail(
        "P016",
        f"'{shorten(first.text)}' stands {where}",
        c.span(first),
        help=f"did you mean '{close[0]}'?"
        if close
        else "a file holds classes, such as 'model Name ... end Name;'",
    )
