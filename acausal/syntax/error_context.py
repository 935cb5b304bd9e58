"""What stands around a syntax error: tokens, open brackets, open blocks, the section.

The parser stops at the first token it cannot use and knows only its own state. The rules in
:mod:`acausal.syntax.errors` need to know what a person sees: which block is open, which line
ended without a semicolon. This module reads the text again, up to the error and a little beyond.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

from acausal.diagnostics import Span
from acausal.syntax.source_text import place

LOOKAHEAD = 8
"""Tokens read beyond the error."""

KEYWORDS = frozenset(
    (
        "algorithm",
        "and",
        "annotation",
        "block",
        "break",
        "class",
        "connect",
        "connector",
        "constant",
        "constrainedby",
        "der",
        "discrete",
        "each",
        "else",
        "elseif",
        "elsewhen",
        "encapsulated",
        "end",
        "enumeration",
        "equation",
        "expandable",
        "extends",
        "external",
        "false",
        "final",
        "flow",
        "for",
        "function",
        "if",
        "import",
        "impure",
        "in",
        "initial",
        "inner",
        "input",
        "loop",
        "model",
        "not",
        "operator",
        "or",
        "outer",
        "output",
        "package",
        "parameter",
        "partial",
        "protected",
        "public",
        "pure",
        "record",
        "redeclare",
        "replaceable",
        "return",
        "stream",
        "then",
        "true",
        "type",
        "when",
        "while",
        "within",
    )
)
"""Reserved words."""

CLASS_KINDS = frozenset(
    ("package", "connector", "model", "block", "record", "type", "function", "class")
)
SECTION_WORDS = frozenset(("equation", "algorithm", "public", "protected"))
SIGNS = frozenset(("+", "-", ".+", ".-"))
"""Operators that can stand before an operand as well as between two."""

OPERATORS = SIGNS | frozenset(("*", "/", "^", ".*", "./", ".^", "<", ">", "<=", ">=", "==", "<>"))
"""Operators between two operands, without the words."""

PREFIX_WORDS = frozenset(
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
        "partial",
        "encapsulated",
    )
)
"""Words before a declaration."""

_TOKEN = re.compile(
    r"""(?P<skip>[ \t\n\f\r]+|//[^\n]*|/\*.*?\*/)
    |(?P<comment>/\*)
    |(?P<string>"[^"\\]*(?:\\.[^"\\]*)*")
    |(?P<quote>")
    |(?P<quoted>'(?:[^'\\\n]|\\.)+')
    |(?P<tick>')
    |(?P<word>[A-Za-z_][A-Za-z_0-9]*)
    |(?P<quantity>[0-9]+(?:\.[0-9]*)?(?:[eE][+-]?[0-9]+)?[ \t]*\[[^\[\]{};,"=\n]*\])
    |(?P<number>[0-9]+(?:\.[0-9]*)?(?:[eE][+-]?[0-9]+)?)
    |(?P<operator>:=|<=|>=|<>|==|\.[*/^+\-]|[-+*/^=<>:;,.()\[\]{}])
    |(?P<unknown>.)""",
    re.VERBOSE | re.DOTALL,
)

_OPENING = {"(": ")", "[": "]", "{": "}"}
_CLOSING = frozenset(")]}")


@dataclass(frozen=True, slots=True)
class Lexeme:
    """One token: its sort (a group of the pattern), text and offsets in the source."""

    sort: str
    text: str
    start: int
    end: int

    @property
    def is_keyword(self) -> bool:
        """Tell whether it is a reserved word."""
        return self.sort == "word" and self.text in KEYWORDS

    @property
    def is_name(self) -> bool:
        """Tell whether it can be a name."""
        return self.sort == "quoted" or (self.sort == "word" and self.text not in KEYWORDS)


@dataclass(slots=True)
class Block:
    """An open block: ``model X``, ``for``, ``if``, ``when`` or ``while``.

    Attributes:
        kind: Its keyword.
        name: The name of a class.
        opening: The token of the keyword.
        section: ``elements``, ``equation`` or ``algorithm``, where the text has arrived in it.
        after_else: It is an ``if`` right behind ``else``.
        closed_after_else: A block of that sort was closed in it.
    """

    kind: str
    name: str
    opening: Lexeme
    section: str = "elements"
    after_else: bool = False
    closed_after_else: bool = False

    @property
    def is_class(self) -> bool:
        """Tell whether it is a class."""
        return self.kind in CLASS_KINDS

    @property
    def closing(self) -> str:
        """The words that close it."""
        return f"end {self.name}" if self.is_class else f"end {self.kind}"

    @property
    def title(self) -> str:
        """What to call it in a message."""
        return f"{self.kind} {self.name}" if self.is_class else f"this '{self.kind}'"


@dataclass
class Context:
    """The surroundings of an error.

    Attributes:
        text: The whole source text.
        source: Its name.
        accepts: Terminals of the grammar that could have stood at the error.
        before: Tokens before the error.
        after: The token at the error and a few behind it; empty at the end of the text.
        brackets: Open brackets, outermost first.
        blocks: Open blocks, outermost first.
        item: Tokens of the unfinished equation, declaration or statement before the error.
        single: True for a lone expression.
    """

    text: str
    source: str
    accepts: frozenset[str]
    before: list[Lexeme]
    after: list[Lexeme]
    brackets: list[Lexeme] = field(default_factory=list)
    blocks: list[Block] = field(default_factory=list)
    item: list[Lexeme] = field(default_factory=list)
    single: bool = False

    @cached_property
    def tokens(self) -> list[Lexeme]:
        """All tokens of the text."""
        return list(_lexemes(self.text))

    def closes(self, name: str) -> bool:
        """Tell whether ``end name`` follows anywhere behind the error."""
        start = self.token.start if self.token is not None else len(self.text)
        return any(
            first.start >= start and first.text == "end" and second.text == name
            for first, second in zip(self.tokens, self.tokens[1:], strict=False)
        )

    @property
    def previous(self) -> Lexeme | None:
        """The token before the error."""
        return self.before[-1] if self.before else None

    @property
    def token(self) -> Lexeme | None:
        """The token at the error; None at the end of the text."""
        return self.after[0] if self.after else None

    @property
    def following(self) -> str:
        """The text of the token behind the one at the error, or nothing."""
        return self.after[1].text if len(self.after) > 1 else ""

    @property
    def on_new_line(self) -> bool:
        """Tell whether a line ends between the previous token and the error."""
        if self.previous is None or self.token is None:
            return True
        return "\n" in self.text[self.previous.end : self.token.start]

    @property
    def enclosing_class(self) -> Block | None:
        """The innermost open class."""
        return next((b for b in reversed(self.blocks) if b.is_class), None)

    def span(self, first: Lexeme, last: Lexeme | None = None) -> Span:
        """Return the span of a token, or from one to another."""
        return place(self.text, first.start, (last or first).end, self.source)

    def behind(self, lexeme: Lexeme | None) -> Span:
        """Return the place just behind a token."""
        end = lexeme.end if lexeme is not None else 0
        span = place(self.text, end, end, self.source)
        return Span(span.source, span.line, span.column, span.line, span.column + 1)

    def line_of(self, lexeme: Lexeme) -> int:
        """Return the line number of a token."""
        return self.text.count("\n", 0, lexeme.start) + 1


def read_context(
    text: str, source: str, offset: int, accepts: frozenset[str], single: bool
) -> Context:
    """Return the surroundings of an error.

    Args:
        text: The whole source text.
        source: Its name.
        offset: Where the error is; the length of the text for its end.
        accepts: What the parser could have used there.
        single: True for a lone expression.
    """
    before: list[Lexeme] = []
    after: list[Lexeme] = []
    for lexeme in _lexemes(text):
        if lexeme.end <= offset:
            before.append(lexeme)
        else:
            after.append(lexeme)
            if len(after) > LOOKAHEAD:
                break
    context = Context(text, source, accepts, before, after, single=single)
    _follow(context)
    return context


def _lexemes(text: str) -> Iterator[Lexeme]:
    """Yield the tokens of a text one by one; a comment that is not closed is the last."""
    for match in _TOKEN.finditer(text):
        sort = match.lastgroup or "unknown"
        if sort != "skip":
            yield Lexeme(sort, match[0], match.start(), match.end())
            if sort == "comment":
                return


def _follow(context: Context) -> None:
    """Find what is open at the error by going through all tokens before it."""
    tokens = [*context.before, *context.after]
    blocks = context.blocks
    brackets = context.brackets
    start = 0
    position = 0
    count = len(context.before)
    while position < count:
        token = tokens[position]
        word = token.text if token.sort in ("word", "operator") else ""
        next_token = tokens[position + 1] if position + 1 < len(tokens) else None
        at_start = position == start
        if word in _OPENING:
            brackets.append(token)
        elif word in _CLOSING:
            if brackets:
                brackets.pop()
        elif brackets:
            pass
        elif word == ";":
            start = position + 1
        elif word in CLASS_KINDS and next_token is not None and next_token.is_name:
            behind = tokens[position + 2].text if position + 2 < len(tokens) else ""
            if behind != "=" and position + 1 < count:
                blocks.append(Block(word, next_token.text, token))
                position += 1
                start = position + 1
        elif word == "end" and position + 1 < count and blocks:
            assert next_token is not None
            closed = blocks.pop()
            if closed.after_else and blocks:
                blocks[-1].closed_after_else = True
            position += 1
        elif (word in SECTION_WORDS and at_start) or word == "equation":
            if blocks:
                section = "elements" if word in ("public", "protected") else word
                blocks[-1].section = section
            start = position + 1
        elif word in ("for", "when", "while") or (word == "if" and at_start):
            before = tokens[position - 1].text if position else ""
            if before != "end":
                section = blocks[-1].section if blocks else "equation"
                blocks.append(Block(word, "", token, section, before == "else"))
        elif word in ("then", "loop"):
            if tokens[start].text in ("if", "elseif", "when", "elsewhen", "for", "while"):
                start = position + 1
        elif word == "else" and at_start:
            start = position + 1
        elif word == "algorithm":
            if blocks:
                blocks[-1].section = word
            start = position + 1
        position += 1
    context.item = tokens[start:count]
    while context.item and (context.item[0].sort == "string" or context.item[0].text == "+"):
        del context.item[0]
