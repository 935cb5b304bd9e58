"""Places in source text."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Span:
    """A range of characters in a source.

    Attributes:
        source: File path, or a name in angle brackets for text that came from no file.
        line: First line, counted from 1.
        column: First column, counted from 1.
        end_line: Last line, counted from 1.
        end_column: Column after the last character, counted from 1.
    """

    source: str
    line: int
    column: int
    end_line: int
    end_column: int

    def to(self, other: Span) -> Span:
        """Return the range from the start of this span to the end of ``other``."""
        return Span(self.source, self.line, self.column, other.end_line, other.end_column)

    def __str__(self) -> str:
        return f"{self.source}:{self.line}:{self.column}"
