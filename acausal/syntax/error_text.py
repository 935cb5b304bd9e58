"""Words for tokens and characters in syntax errors."""

from __future__ import annotations

import unicodedata
from collections.abc import Set as AbstractSet
from typing import NoReturn

from acausal.diagnostics import fail
from acausal.syntax.error_context import Context, Lexeme

_REPLACEMENTS = {
    "\u2212": "-",
    "\u2013": "-",
    "\u2014": "-",
    "\u00d7": "*",
    "\u00b7": "*",
    "\u22c5": "*",
    "\u00f7": "/",
    "\u2215": "/",
    "\u201c": '"',
    "\u201d": '"',
    "\u201e": '"',
    "\u00ab": '"',
    "\u00bb": '"',
    "\u2018": "'",
    "\u2019": "'",
    "\u2264": "<=",
    "\u2265": ">=",
    "\u2260": "<>",
    "\u00b2": "^2",
    "\u00b3": "^3",
    "\u00a0": "an ordinary blank",
    "\u2003": "an ordinary blank",
    "\u2009": "an ordinary blank",
    "\u202f": "an ordinary blank",
    "\u200b": "nothing",
    "\uff1b": ";",
    "\uff0c": ",",
}

_HINTS = {
    "!": "'not equal' is written '<>', and 'not' is a word",
    "~": "'not equal' is written '<>', and 'not' is a word",
    "&": "write 'and'",
    "|": "write 'or'",
    "%": "a comment begins with '//'; the remainder is mod(a, b)",
    "#": "a comment begins with '//'",
    "?": "write 'if c then a else b'",
    "@": "a matrix product is written '*'",
    "$": "remove it; names have letters, digits and '_'",
    "`": "a string is written \"...\", a quoted name '...'",
    "\\": "a backslash belongs into strings only",
}

_EXPRESSION_STARTS = frozenset(("NUMBER", "STRING", "TRUE", "LBRACE", "IDENT"))

_WORDS = {
    "IDENT": "a name",
    "NUMBER": "a number",
    "STRING": "a string",
    "KIND": "a class",
    "PREFIX": "a declaration",
    "END": "'end'",
    "$END": "the end of the text",
    "EQ": "'='",
    "ASSIGN": "':='",
    "SEMICOLON": "';'",
    "COMMA": "','",
    "COLON": "':'",
    "DOT": "'.'",
    "STAR": "'*'",
    "LPAR": "'('",
    "RPAR": "')'",
    "LSQB": "'['",
    "RSQB": "']'",
    "LBRACE": "'{'",
    "RBRACE": "'}'",
}

_OPERATOR_TERMINALS = frozenset(("ADDOP", "MULOP", "POWER", "RELATION", "AND", "OR"))
_EXPRESSION_ONLY = frozenset(
    (
        "NUMBER",
        "QUANTITY",
        "STRING",
        "TRUE",
        "FALSE",
        "LBRACE",
        "LSQB",
        "LPAR",
        "IDENT",
        "DOT",
        "IF",
        "NOT",
        "ADDOP",
        "DER",
        "INITIAL_CALL",
        "END_INDEX",
    )
)


def shorten(text: str) -> str:
    """Return the text on one line and of bounded length."""
    text = " ".join(text.split())
    return text if len(text) <= 30 else text[:27] + "..."


def expected_words(accepts: AbstractSet[str]) -> str:
    """Return what could have stood at the error, for a person; at most five things."""
    rest = set(accepts)
    words = []
    if rest >= _EXPRESSION_STARTS:
        words.append("an expression")
        rest -= _EXPRESSION_ONLY
    elif len(rest & _OPERATOR_TERMINALS) > 3:
        words.append("an operator")
        rest -= _OPERATOR_TERMINALS
    words += [_WORDS.get(name, f"'{name.lower()}'") for name in sorted(rest)]
    if len(words) > 5:
        words = [w for w in words if w in ("an expression", "an operator", "';'", "a name", "')'")]
    if not words:
        return ""
    if len(words) == 1:
        return words[0]
    return ", ".join(words[:-1]) + " or " + words[-1]


def explain_character(c: Context, token: Lexeme) -> NoReturn:
    """Raise the diagnostic for a character that is no part of the language.

    Raises:
        AcausalError: P008.
    """
    mark = token.text
    code = f"U+{ord(mark):04X}"
    help_text = _HINTS.get(mark, "")
    if mark in _REPLACEMENTS:
        replacement = _REPLACEMENTS[mark]
        help_text = f"write {replacement if len(replacement) > 2 else repr(replacement)} instead"
    elif not help_text and mark.isalpha():
        help_text = "a name has the letters a to z, digits and '_'; quote any other name: 'name'"
    name = unicodedata.name(mark, "")
    shown = f"'{mark}'" if mark.isprintable() and not mark.isspace() else name.lower() or code
    if not mark.isascii():
        shown += f" ({code})"
    fail(
        "P008",
        f"the character {shown} does not belong into a model",
        c.span(token),
        help=help_text or "remove it",
    )


def report_semicolon(c: Context, previous: Lexeme) -> NoReturn:
    """Raise P002 for the place behind a token."""
    # An item that begins with a miswritten keyword is a name in the eyes of the parser.
    fail(
        "P002",
        f"';' is missing behind '{shorten(previous.text)}'",
        c.behind(previous),
        help="end it with ';'",
    )
