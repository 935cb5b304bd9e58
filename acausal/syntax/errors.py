"""Syntax errors in the user's words.

The rules are tried from the special to the general; the first that knows what happened raises its
diagnostic. Each rule sees the tokens around the error, what is open there, and the terminals that
the parser would have taken.
"""

from __future__ import annotations

from typing import NoReturn

from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from acausal.diagnostics import fail
from acausal.syntax import error_rules_blocks as blocks
from acausal.syntax import error_rules_tokens as tokens
from acausal.syntax.error_context import Context, read_context
from acausal.syntax.error_text import expected_words, shorten

_RULES = (
    tokens.unterminated,
    tokens.unknown_character,
    tokens.nothing_there,
    tokens.unit,
    tokens.number_form,
    tokens.superfluous,
    tokens.assignment_sign,
    tokens.sign_order,
    tokens.second_equal_sign,
    blocks.missing_keyword,
    tokens.brackets,
    blocks.block_ends,
    tokens.wrong_case,
    blocks.sections,
    tokens.names_in_a_row,
    blocks.missing_semicolon,
    blocks.top_level,
    tokens.reserved_word,
)


def explain(error: UnexpectedInput, text: str, source: str, start: str) -> NoReturn:
    """Raise the diagnostic for a syntax error.

    Args:
        error: What the parser raised.
        text: The whole source text.
        source: Its name.
        start: The rule that was asked for: ``file`` or ``expression_only``.

    Raises:
        AcausalError: Always.
    """
    accepts: frozenset[str] = frozenset()
    offset = error.pos_in_stream
    if isinstance(error, UnexpectedToken):
        accepts = frozenset(error.accepts or error.expected or ())
        if error.token.type == "$END":
            offset = len(text)
    elif isinstance(error, UnexpectedCharacters):
        accepts = frozenset(error.allowed or ())
    if offset is None or offset < 0:
        offset = len(text)
    context = read_context(text, source, offset, accepts, start == "expression_only")
    for rule in _RULES:
        rule(context)
    _unexpected(context)


def _unexpected(c: Context) -> NoReturn:
    expected = expected_words(c.accepts)
    wanted = f"; expected {expected}" if expected else ""
    behind = f" behind '{shorten(c.previous.text)}'" if c.previous is not None else ""
    if c.token is None:
        fail(
            "P001",
            f"the {'expression' if c.single else 'text'} ends too early{behind}{wanted}",
            c.behind(c.previous),
            help="complete it",
        )
    fail(
        "P001",
        f"'{shorten(c.token.text)}' cannot stand here{behind}{wanted}",
        c.span(c.token),
        help=f"look at what stands before '{shorten(c.token.text)}'",
    )
