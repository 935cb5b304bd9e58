"""Lines of a netlist: comments taken out, continuations joined, words with their places."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

from acausal.diagnostics import AcausalError, Span, fail

#: A comment begins with ``;``, ``//`` or a free-standing ``$`` and goes to the end of the line.
_TOKEN = re.compile(
    r"(?P<space>\s+)|(?P<comment>;.*|//.*|\$(?=\s|$).*)|(?P<expression>\{[^{}]*\}|'[^']*')"
    r'|(?P<text>"[^"]*")|(?P<mark>[(),=])|(?P<word>[^\s(),=;{}\'"]+)'
)


@dataclass(frozen=True, slots=True)
class Token:
    """A word, a mark, or an expression in braces or quotes.

    Attributes:
        kind: ``word``, ``mark``, ``expression`` (without its braces) or ``text`` (a file name).
        text: As it is written.
        span: The place.
    """

    kind: str
    text: str
    span: Span

    @property
    def low(self) -> str:
        """The text without capitals; SPICE does not tell them apart."""
        return self.text.lower()


@dataclass(frozen=True, slots=True)
class Line:
    """A card: a line with its continuations, at least one word.

    Attributes:
        tokens: What it says, without commas, which separate as spaces do.
        raw: The same with commas.
    """

    tokens: tuple[Token, ...]
    raw: tuple[Token, ...]

    @property
    def span(self) -> Span:
        """The place of the first line."""
        first = self.tokens[0].span
        same = [t.span for t in self.tokens if t.span.line == first.line]
        return first.to(same[-1])

    @property
    def key(self) -> str:
        """The first word, without capitals."""
        return self.tokens[0].low


def read_text(path: Path, span: Span | None) -> str:
    """Return the text of a netlist.

    Args:
        path: The file.
        span: Where it is included.

    Raises:
        AcausalError: ``F101`` to ``F104`` for a file that cannot be read, ``P035`` for no text.
    """
    from acausal.syntax.source_text import read_bytes

    try:
        data = read_bytes(path)
    except AcausalError as error:
        if span is None:
            raise
        raise AcausalError([replace(d, span=span) for d in error.diagnostics]) from None
    if b"\0" in data:
        fail("P035", f"{path} is no text", span, help="give a netlist")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")  # comments of old netlists


def split_lines(text: str, source: str, titled: bool) -> tuple[str, list[Line]]:
    """Return the title and the cards of a netlist, up to ``.end``.

    Args:
        text: The netlist.
        source: Its file.
        titled: Whether the first line is a title, as in all files but included ones.

    Raises:
        AcausalError: ``P040`` for a continuation of nothing and unclosed braces.
    """
    rows = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    title = rows[0].strip() if titled else ""
    cards: list[list[Token]] = []
    for number, row in enumerate(rows, 1):
        if (titled and number == 1) or not row.strip() or row.lstrip()[0] == "*":
            continue
        start = len(row) - len(row.lstrip())
        if row[start] == "+":
            if not cards:
                fail("P040", "a line that goes on with + has nothing before it",
                     Span(source, number, start + 1, number, start + 2),
                     help="the first line of a netlist is its title, not a card")  # fmt: skip
            cards[-1] += _tokens(row, start + 1, number, source)
            continue
        found = _tokens(row, start, number, source)
        if found:
            if found[0].low == ".end":
                break
            cards.append(found)
    return title, [Line(tuple(t for t in c if t.text != ","), tuple(c)) for c in cards]


def _tokens(row: str, position: int, number: int, source: str) -> list[Token]:
    found: list[Token] = []
    while position < len(row):
        match = _TOKEN.match(row, position)
        if match is None:
            span = Span(source, number, position + 1, number, len(row) + 1)
            fail(
                "P040",
                f"{row[position]} is not closed in this line",
                span,
                help="close it in the same line; a long expression becomes several .param",
            )
        kind = str(match.lastgroup)
        if kind not in ("space", "comment"):
            text = match[0][1:-1] if kind in ("expression", "text") else match[0]
            span = Span(source, number, position + 1, number, match.end() + 1)
            found.append(Token(kind, text, span))
        position = match.end()
    return found
