"""Pieces of HTML."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from acausal.reference.equations import Line
from acausal.reference.mathml import mathml
from acausal.reference.pages import unit_text


@dataclass(frozen=True)
class Section:
    """A part of the page with a title of its own; one without a body is left out."""

    key: str
    title: str
    body: str


def table(head: Sequence[str], rows: Sequence[Sequence[str]], kinds: str, style: str = "") -> str:
    """Return a table; columns that are empty everywhere are left out.

    Args:
        head: Titles of the columns.
        rows: Cells as HTML; a row of one cell spans all columns.
        kinds: One letter for each column: ``n`` number, ``t`` text that does not break, ``-``.
        style: Class of the table.
    """
    if not rows:
        return ""
    whole = [row for row in rows if len(row) == len(head)]
    kept = [k for k in range(len(head)) if any(row[k] for row in whole)]
    mark = {"n": ' class="n"', "t": ' class="t"', "-": ""}
    top = "".join(f"<th{mark[kinds[k]] if kinds[k] == 'n' else ''}>{head[k]}</th>" for k in kept)
    lines = []
    for row in rows:
        if len(row) == 1:
            lines.append(f'<tr class="part"><td colspan="{len(kept)}">{row[0]}</td></tr>')
        else:
            cells = "".join(f"<td{mark[kinds[k]]}>{row[k]}</td>" for k in kept)
            lines.append(f"<tr>{cells}</tr>")
    named = f' class="{style}"' if style else ""
    head_row = f"<thead><tr>{top}</tr></thead>" if any(head) else ""
    body = f"<tbody>{''.join(lines)}</tbody>"
    return f'<div class="scroll"><table{named}>{head_row}{body}</table></div>'


def number(value: float, digits: int = 6) -> str:
    """Return a number as people write it: 1.2·10⁻⁶, not 1.2e-06."""
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    text = f"{value:.{digits}g}"
    mantissa, exponent, power = text.partition("e")
    if exponent:
        raised = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        text = f"{mantissa}·10{raised}" if mantissa != "1" else f"10{raised}"
    return text.replace("-", "−")


def unit(text: str) -> str:
    """Return a unit as people write it."""
    return "" if text == "1" else unit_text(escape(text))


def code(text: str) -> str:
    """Return a name."""
    return f"<code>{escape(text)}</code>"


def laws(lines: Sequence[Line]) -> str:
    """Return equations as they stand in a class."""
    rows = []
    for line in lines:
        depth = f' style="--d:{line.depth}"' if line.depth else ""
        words = f"<i>{escape(line.words)}</i>" if line.words else ""
        mathematics = formula(line.latex) if line.latex else ""
        plain = code(line.code) if line.code else ""
        about = f"<small>{escape(line.description)}</small>" if line.description else ""
        rows.append(f"<div{depth}>{words}{mathematics}{plain}{about}</div>")
    return f'<div class="laws">{"".join(rows)}</div>'


def formula(latex: str) -> str:
    """Return LaTeX mathematics as MathML that is well-formed XML too."""
    text = mathml(latex)
    return re.sub(r"([\w-]+)=([^\s\"'<>/]+)(?=[^<>]*>)", r'\1="\2"', text)


def details(summary: str, body: str) -> str:
    """Return something that a reader may unfold."""
    return f"<details><summary>{summary}</summary>{body}</details>"
