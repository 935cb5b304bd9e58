"""Source excerpts with marks under the places that a diagnostic talks about."""

from __future__ import annotations

import linecache
import os
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from acausal.diagnostics.span import Span

#: Longest source text shown of one line, in columns of the terminal.
WIDTH = 100
#: Most lines of one span that are shown.
SPAN_LINES = 4
#: Largest file that is read for an excerpt, bytes.
LARGEST_FILE = 50_000_000
_TAB = "    "


@dataclass(frozen=True, slots=True)
class Mark:
    """A place to underline.

    Attributes:
        span: The place.
        text: The remark printed beside the underline.
        primary: Whether this is the place that the message itself is about.
    """

    span: Span
    text: str
    primary: bool


@dataclass(frozen=True, slots=True)
class Line:
    """One line of an excerpt.

    Attributes:
        number: Line number in the source; None for a line of marks.
        text: Source text, or spaces and marks.
        remark: Text after the marks.
        primary: Whether the marks belong to the primary place.
    """

    number: int | None
    text: str
    remark: str = ""
    primary: bool = False


def read_lines(source: str, sources: Mapping[str, str]) -> list[str] | None:
    """Return the lines of a source, or None if it cannot be shown.

    Args:
        source: File path or name of a text.
        sources: Texts that came from no file, by name; they win over files.
    """
    text = sources.get(source)
    if text is None:
        # Cells of notebooks are no files, but Python knows them.
        known = linecache.cache.get(source)
        if known is not None and not os.path.isfile(source):
            return [line.rstrip("\n") for line in linecache.getlines(source)]
        try:
            if not os.path.isfile(source) or os.path.getsize(source) > LARGEST_FILE:
                return None
            with open(source, encoding="utf-8-sig", errors="replace", newline="") as file:
                text = file.read()
        except (OSError, ValueError):
            return None
    # Only \n ends a line, as in the lexer; splitlines would also split at form feeds.
    return text.replace("\r\n", "\n").split("\n")


def excerpt(marks: Iterable[Mark], lines: list[str]) -> list[Line]:
    """Return the marked lines of one source, in line order, each followed by its marks.

    A span over several lines is marked on its first and last ones. Places outside the text are
    moved to its end.
    """
    shown: dict[int, list[tuple[int, int, str, bool]]] = {}
    for mark in marks:
        for number, first, last, text in _line_ranges(mark, lines):
            shown.setdefault(number, []).append((first, last, text, mark.primary))
    result: list[Line] = []
    previous = 0
    for number in sorted(shown):
        ranges = sorted(shown[number], key=lambda r: (not r[3], r[0]))
        raw = lines[number - 1].rstrip("\r")
        # One window for all marks of a line, placed by its first mark.
        window = _window(raw, ranges[0][0])
        if previous and number > previous + 1:
            result.append(Line(None, "..."))
        previous = number
        result.append(Line(number, _shown(raw, window)))
        for first, last, text, primary in ranges:
            result.append(_marks(raw, window, first, last, text, primary))
    return result


def _line_ranges(mark: Mark, lines: list[str]) -> list[tuple[int, int, int, str]]:
    """Split a mark into (line, first column, column after the last, remark), counted from 1."""
    span = mark.span
    start = min(max(span.line, 1), len(lines))
    end = min(max(span.end_line, start), len(lines))
    if start == end:
        last = span.end_column if span.end_line == start else len(lines[start - 1]) + 1
        return [(start, span.column, last, mark.text)]
    numbers = list(range(start, end + 1))
    if len(numbers) > SPAN_LINES:
        numbers = [*numbers[: SPAN_LINES - 1], end]
    ranges = []
    for number in numbers:
        raw = lines[number - 1].rstrip()
        first = len(raw) - len(raw.lstrip()) + 1
        last = len(raw) + 1
        if number == start:
            first = span.column
        if number == end:
            last = min(span.end_column, last)
        if raw or number == end:
            ranges.append((number, first, last, mark.text if number == end else ""))
    return ranges


def _window(raw: str, column: int) -> tuple[int, int]:
    """Return the range of characters shown of a line, so that ``column`` is among them."""
    if len(raw) <= WIDTH:
        return 0, len(raw)
    start = max(0, min(column - 1 - WIDTH // 4, len(raw) - WIDTH))
    return start, min(len(raw), start + WIDTH)


def _shown(raw: str, window: tuple[int, int]) -> str:
    start, end = window
    before = "..." if start > 0 else ""
    after = "..." if end < len(raw) else ""
    return before + printable(raw[start:end]) + after


def _marks(
    raw: str, window: tuple[int, int], first: int, last: int, text: str, primary: bool
) -> Line:
    start, end = window
    # A mark of a missing thing stands behind the line's end, one column wide at least.
    begin = min(max(first - 1, start), end)
    stop = max(min(last - 1, end), begin)
    offset = (3 if start > 0 else 0) + columns(raw[start:begin])
    width = max(1, columns(raw[begin:stop]))
    return Line(None, " " * offset + ("^" if primary else "-") * width, text, primary)


def printable(text: str) -> str:
    """Expand tabs, and replace characters that would move a terminal's cursor."""
    if text.isprintable():
        return text
    return "".join(_TAB if c == "\t" else c if _harmless(c) else "�" for c in text)


def columns(text: str) -> int:
    """Return how many columns of a terminal a text takes after :func:`printable`."""
    if text.isascii() and text.isprintable():
        return len(text)
    return sum(_columns(c) for c in text)


def _columns(c: str) -> int:
    if c == "\t":
        return len(_TAB)
    if unicodedata.combining(c):
        return 0
    return 2 if unicodedata.east_asian_width(c) in "WF" else 1


def _harmless(c: str) -> bool:
    return c.isprintable() or unicodedata.combining(c) > 0
