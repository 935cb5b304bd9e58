"""Diagnostics as text for people and as plain data for tools."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from acausal.diagnostics.diagnostic import AcausalError, Diagnostic, Severity
from acausal.diagnostics.excerpt import Mark, excerpt, printable, read_lines
from acausal.diagnostics.span import Span

#: Most diagnostics shown of one run.
MOST_DIAGNOSTICS = 20
#: Most places shown of one diagnostic.
MOST_LABELS = 12
#: Most notes shown of one diagnostic.
MOST_NOTES = 12
#: Longest message, remark, note or help, in characters.
LONGEST_TEXT = 1500

_RED, _YELLOW, _BLUE, _CYAN, _BOLD = "1;31", "1;33", "1;34", "1;36", "1"


def render(
    what: AcausalError | Diagnostic | Iterable[Diagnostic],
    color: bool = False,
    sources: Mapping[str, str] | None = None,
) -> str:
    """Return diagnostics as text: message, place, marked source, notes and help.

    Args:
        what: An error, or one or more diagnostics.
        color: Whether to write ANSI colour codes.
        sources: Texts that came from no file, by the name their spans give.

    Returns:
        Text that ends in a newline, or the empty string if there are no diagnostics.
    """
    if isinstance(what, AcausalError):
        diagnostics: Sequence[Diagnostic] = what.diagnostics
    elif isinstance(what, Diagnostic):
        diagnostics = (what,)
    else:
        diagnostics = tuple(what)
    paint = _Paint(color)
    texts = sources or {}
    blocks = [_one(d, paint, texts) for d in diagnostics[:MOST_DIAGNOSTICS]]
    hidden = len(diagnostics) - MOST_DIAGNOSTICS
    if hidden > 0:
        blocks.append(paint(_BOLD, f"... and {hidden} more messages") + "\n")
    return "\n".join(blocks)


def as_data(diagnostic: Diagnostic) -> dict[str, Any]:
    """Return a diagnostic as dictionaries, lists, strings and numbers (for JSON)."""
    return {
        "code": diagnostic.code,
        "severity": diagnostic.severity.value,
        "message": diagnostic.message,
        "span": _span_data(diagnostic.span),
        "label": diagnostic.label,
        "labels": [{"span": _span_data(x.span), "text": x.text} for x in diagnostic.labels],
        "notes": list(diagnostic.notes),
        "help": diagnostic.help,
    }


def _span_data(span: Span | None) -> dict[str, Any] | None:
    if span is None:
        return None
    return {
        "source": span.source,
        "line": span.line,
        "column": span.column,
        "end_line": span.end_line,
        "end_column": span.end_column,
    }


class _Paint:
    """Wraps text in colour codes, or leaves it alone."""

    def __init__(self, on: bool) -> None:
        self._on = on

    def __call__(self, code: str, text: str) -> str:
        return f"\x1b[{code}m{text}\x1b[0m" if self._on and text else text


def _one(diagnostic: Diagnostic, paint: _Paint, sources: Mapping[str, str]) -> str:
    severity = diagnostic.severity.value
    tone = _RED if diagnostic.severity is Severity.ERROR else _YELLOW
    head = paint(tone, f"{severity}[{diagnostic.code}]")
    out = [head + paint(_BOLD, ": " + _text(diagnostic.message, "  "))]
    marks = [] if diagnostic.span is None else [Mark(diagnostic.span, diagnostic.label, True)]
    marks += [Mark(label.span, label.text, False) for label in diagnostic.labels]
    if diagnostic.span is None and diagnostic.label:
        out.append(_said("note", _CYAN, diagnostic.label, paint))
    out += _places(marks[:MOST_LABELS], tone, paint, sources)
    if len(marks) > MOST_LABELS:
        out.append(_said("note", _CYAN, f"{len(marks) - MOST_LABELS} more places", paint))
    out += [_said("note", _CYAN, note, paint) for note in diagnostic.notes[:MOST_NOTES]]
    if len(diagnostic.notes) > MOST_NOTES:
        hidden = len(diagnostic.notes) - MOST_NOTES
        out.append(_said("note", _CYAN, f"{hidden} more notes", paint))
    if diagnostic.help:
        out.append(_said("help", _CYAN, diagnostic.help, paint))
    return "\n".join(line.rstrip() for line in out) + "\n"


def _said(word: str, tone: str, text: str, paint: _Paint) -> str:
    return f"{paint(tone, word)}: {_text(text, '      ')}"


def _places(marks: list[Mark], tone: str, paint: _Paint, sources: Mapping[str, str]) -> list[str]:
    """Return the excerpts, one for each source, that of the primary place first."""
    by_source: dict[str, list[Mark]] = {}
    for mark in marks:
        by_source.setdefault(mark.span.source, []).append(mark)
    largest = max((m.span.end_line for m in marks), default=1)
    margin = max(2, len(str(largest)) + 1)
    out: list[str] = []
    for source, here in by_source.items():
        first = here[0].span
        where = f"{display_path(source)}:{first.line}:{first.column}"
        out.append(f"{' ' * margin}{paint(_BLUE, '-->')} {where}")
        lines = read_lines(source, sources)
        if lines is None:
            out += [
                f"{' ' * margin}{paint(_BLUE, '=')} line {m.span.line}: {_text(m.text, '')}"
                for m in here
                if m.text
            ]
            continue
        for line in excerpt(here, lines):
            if line.number is None and line.text == "...":
                out.append(" " * (margin - 2) + paint(_BLUE, "..."))
                continue
            number = str(line.number) if line.number is not None else ""
            gutter = paint(_BLUE, f"{number:>{margin}} |")
            if line.number is not None:
                out.append(f"{gutter} {line.text}")
            else:
                marked = paint(tone if line.primary else _BLUE, line.text.lstrip())
                indent = " " * (len(line.text) - len(line.text.lstrip()))
                remark = f" {_text(line.remark, '')}" if line.remark else ""
                out.append(f"{gutter} {indent}{marked}{remark}")
    return out


def display_path(source: str) -> str:
    """Return a path as a person would type it: relative when it lies below the current folder."""
    if source.startswith("<") or not os.path.isabs(source):
        return printable(source)
    try:
        relative = os.path.relpath(source)
    except (OSError, ValueError):
        return printable(source)
    return printable(source if relative.startswith(os.pardir) else relative)


def _text(text: str, indent: str) -> str:
    """Make a text safe and short enough to print; further lines are indented."""
    if len(text) > LONGEST_TEXT:
        text = f"{text[:LONGEST_TEXT]}... ({len(text) - LONGEST_TEXT} more characters)"
    return ("\n" + indent).join(printable(line) for line in text.split("\n"))
