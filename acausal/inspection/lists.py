"""Lists that do not get longer than a person reads."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from acausal.expressions.text import number_text

#: Entries of a list that are shown.
SHOWN = 20
#: Names that are shown where they stand in lines, one after the other.
SHOWN_IN_LINES = 80
#: Width of such lines.
_WIDTH = 96


def shortened(count: int, line: Callable[[int], str], noun: str = "") -> list[str]:
    """Return ``line(0) ..`` up to :data:`SHOWN` lines, and how many more there are."""
    lines = [line(k) for k in range(min(count, SHOWN))]
    if count > SHOWN:
        lines.append(f"... {count - SHOWN} more" + (f" {noun}" if noun else ""))
    return lines


def listed(names: Sequence[str]) -> str:
    """Return names in one line, shortened."""
    more = f", ... {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more


def indented(lines: Sequence[str], depth: int = 1) -> list[str]:
    """Return lines moved to the right."""
    return ["  " * depth + line for line in lines]


def columns(rows: Sequence[Sequence[str]], widest: int = 60) -> list[str]:
    """Return rows as aligned columns; a cell wider than ``widest`` moves the rest of its line."""
    if not rows:
        return []
    widths = [min(widest, max(len(row[k]) for row in rows)) for k in range(len(rows[0]))]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def wrapped(names: Sequence[str], noun: str) -> list[str]:
    """Return names one after the other in lines of limited width, shortened."""
    shown = list(names[:SHOWN_IN_LINES])
    if len(names) > SHOWN_IN_LINES:
        shown.append(f"... {len(names) - SHOWN_IN_LINES} more {noun}")
    lines: list[str] = []
    for k, name in enumerate(shown):
        piece = name + ("," if k + 1 < len(shown) else "")
        if lines and len(lines[-1]) + len(piece) < _WIDTH:
            lines[-1] += " " + piece
        else:
            lines.append(piece)
    return lines


def counted(count: int, noun: str, plural: str = "") -> str:
    """Return ``1 state``, ``2 states``."""
    return f"{count} {noun if count == 1 else plural or noun + 's'}"


def quantity(values: NDArray[np.float64], unit: str) -> str:
    """Return a value with its unit as the language writes it, or the range of several."""
    low, high = float(values.min()), float(values.max())
    text = number_text(float(f"{low:.10g}"))
    if not np.isnan(low) and low != high:
        text += f" .. {number_text(float(f'{high:.10g}'))}"
    return text + (f"[{unit}]" if unit else "")
