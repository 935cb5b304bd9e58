"""Where in Python something was written: the caller's line, as a span.

A loop that creates a hundred thousand components does so at one place, so spans are kept by code
object and instruction, and shared.
"""

from __future__ import annotations

import linecache
import sys
from bisect import bisect_right
from types import CodeType
from typing import Any

from acausal.diagnostics import Span

#: Larger code objects (scripts that a program has written) are looked up by line only.
_LARGE = 200_000
_MOST_SPANS = 500_000

#: Spans by code object and instruction; the code is kept so that its id stays its own.
_spans: dict[tuple[int, int], tuple[CodeType, Span]] = {}
_positions: dict[int, tuple[CodeType, list[Any]]] = {}
_NOWHERE = Span("<python>", 1, 1, 1, 1)


def here() -> Span:
    """Return the place of the call in the user's code: the nearest frame outside of acausal."""
    frame = sys._getframe(1)
    while frame.f_globals.get("__name__", "").startswith("acausal."):
        if frame.f_back is None:
            return _NOWHERE
        frame = frame.f_back
    code = frame.f_code
    known = _spans.get((id(code), frame.f_lasti))
    if known is not None:
        return known[1]
    span = _span(code, frame.f_lasti)
    if len(_spans) > _MOST_SPANS:
        _spans.clear()
        _positions.clear()
    _spans[(id(code), frame.f_lasti)] = (code, span)
    return span


def _span(code: CodeType, instruction: int) -> Span:
    large = len(code.co_code) > _LARGE
    if id(code) not in _positions:
        table: list[Any] = list(code.co_lines()) if large else list(code.co_positions())
        _positions[id(code)] = (code, table)
    table = _positions[id(code)][1]
    source = code.co_filename
    if large:
        found = bisect_right(table, instruction, key=lambda row: row[0]) - 1
        return _whole_line(source, table[found][2] or code.co_firstlineno)
    line, end_line, column, end_column = table[instruction // 2]
    if line is None:
        return _whole_line(source, code.co_firstlineno)
    if column is None or end_column is None or end_line is None:
        return _whole_line(source, line)
    return Span(source, line, column + 1, end_line, end_column + 1)


def _whole_line(source: str, line: int) -> Span:
    text = linecache.getline(source, line).rstrip()
    first = len(text) - len(text.lstrip()) + 1
    return Span(source, line, first, line, len(text) + 1)
