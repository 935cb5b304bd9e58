"""What notebooks show of a result and of a variable: a small table and a plot."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

from acausal.results.plot import DEFAULT_LINES, default_paths, picture, pretty_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from acausal.results.result import Result
    from acausal.results.trajectory import Trajectory

#: Columns of the table of a result.
_HEAD = ("variable", "unit", "min", "max", "end", "description")


def result_html(result: Result) -> str:
    """Return a result as HTML: how it went, the states in numbers, and a plot of them."""
    about = f" &ndash; {escape(result.description)}" if result.description else ""
    span = ""
    if len(result.times):
        span = f", {result.times[0]:g} s to {result.times[-1]:g} s"
    facts = f"{result.ending.value}, {len(result.times)} points{span}"
    if result.events:
        facts += f", {len(result.events)} events"
    parts = [f"<div><b>{escape(result.model_name)}</b>{about}<br><small>{facts}</small></div>"]
    parts += [
        f"<div><small><b>{d.severity.value}[{d.code}]</b>: {escape(d.message)}</small></div>"
        for d in result.diagnostics[:3]
    ]
    found = [result.trajectory(path) for path in default_paths(result)]
    if found and len(result.times):
        parts.append(_table(found))
        parts.append(_svg(result.plot(*[x.path for x in found][:DEFAULT_LINES], title=" ")))
    return "".join(parts)


def trajectory_html(x: Trajectory) -> str:
    """Return a variable as HTML: its numbers and a plot."""
    if not len(x.values):
        return f"<div>{escape(repr(x))}</div>"
    from acausal.results.result import Result
    from acausal.results.table import TableSource

    source = TableSource({x.path: x.values}, {x.path: x.unit})
    return _table([x]) + _svg(Result("", "", x.time, source, [x.path]).plot(title=" "))


def table_html(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table; cells are HTML already, numbers stand at the right of their column."""
    cells = "".join(f"<th style='text-align:left'>{text}</th>" for text in head)
    lines = [f"<tr>{cells}</tr>"]
    for row in rows:
        aligned = (
            f"<td style='text-align:{'right' if _numeric(cell) else 'left'}'>{cell}</td>"
            for cell in row
        )
        lines.append(f"<tr>{''.join(aligned)}</tr>")
    return f"<table>{''.join(lines)}</table>"


def _table(found: Sequence[Trajectory]) -> str:
    rows = []
    for x in found:
        numbers = (x.min(), x.max(), float(x.values[-1]))
        rows.append(
            [
                f"<code>{escape(x.path)}</code>",
                escape(pretty_unit(x.unit)) if x.unit else "",
                *(f"{number:.6g}" for number in numbers),
                escape(x.description),
            ]
        )
    return table_html(_HEAD, rows)


def _numeric(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _svg(figure: Figure) -> str:
    """Return a figure to be put into a page, as wide as the page allows."""
    import base64

    data = base64.b64encode(picture(figure, "svg")).decode()
    return (
        f'<img style="max-width:100%;width:44em;background:#fff" alt="plot" '
        f'src="data:image/svg+xml;base64,{data}">'
    )
