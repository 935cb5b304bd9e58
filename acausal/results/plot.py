"""Plots: over time, one set of axes for each unit; phase portraits; several runs over each other.

Matplotlib's object interface is used without ``pyplot``: no window system is touched, and no figure
is kept alive by a global list. Figures have an opaque ground of their own, so that they can be read
on a dark page, too; the user's Matplotlib settings hold.
"""

from __future__ import annotations

import io
import os
import re
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import fail
from acausal.results.expressions import chosen
from acausal.results.files import check_suffix, whole_file
from acausal.results.result import Ending, Result
from acausal.results.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

SUFFIXES = (".png", ".svg", ".pdf")
#: Variables drawn when none were named.
DEFAULT_LINES = 12
#: Longest legend.
LONGEST_LEGEND = 15
#: Event marks that can be told apart.
MOST_MARKS = 300
#: Points of a smooth curve where the solver's polynomial is at hand.
SMOOTH = 2000
_SUPERSCRIPT = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


def default_paths(result: Result) -> list[str]:
    """Return what is drawn when nothing was asked for: the states, or else the first variables."""
    paths = [path for path in result.states if not path.startswith("der(")]
    if not paths:
        paths = list(result.variables.paths()[:DEFAULT_LINES])
    return paths[:DEFAULT_LINES]


def draw(
    result: Result, patterns: Sequence[str] = (), title: str = "", events: bool = False
) -> Figure:
    """Draw variables over time.

    Args:
        result: The simulation's result.
        patterns: Paths, patterns or expressions; the states if there are none.
        title: Text above; the model's name and description if empty.
        events: Whether events are marked.

    Raises:
        AcausalError: ``N901`` if a pattern matches nothing.
    """
    found = _found(result, patterns)
    groups = _by_unit(found)
    figure, axes = _axes(len(groups))
    for ax, (unit, trajectories) in zip(axes, groups.items(), strict=False):
        lines = [(trajectory.path, trajectory) for trajectory in trajectories]
        _draw_lines(ax, unit, lines)
        if events:
            _mark_events(ax, result)
    _finish_time(axes, [result])
    figure.align_ylabels()
    figure.suptitle(_title(result, title))
    return figure


def draw_runs(
    runs: Iterable[Result | None],
    patterns: Sequence[str] = (),
    labels: Sequence[str] | None = None,
    title: str = "",
) -> Figure:
    """Draw variables of several runs over each other, one set of axes for each variable.

    Args:
        runs: Results, or a :class:`~acausal.runs.study.Study`; points without a result are left
            out.
        patterns: Paths, patterns or expressions; the states of the first run if there are none.
        labels: Names of the runs; what was varied in a study, else numbers.
        title: Text above; the model's name and description if empty.

    Raises:
        AcausalError: ``N901`` if a pattern matches nothing, ``F213`` if there is no run or not
            one label for each.
    """
    points = getattr(runs, "points", None)
    every = list(runs)
    if labels is None:
        labels = [f"run {k + 1}" for k in range(len(every))]
        if points is not None:
            labels = [", ".join(f"{n} = {_short(v)}" for n, v in p.items()) for p in points]
    if len(labels) != len(every):
        fail("F213", f"{len(labels)} labels for {len(every)} runs", help="give one for each run")
    named = [(label, run) for label, run in zip(labels, every, strict=True) if run is not None]
    if not named:
        fail("F213", "there is no run to draw", help="look at study.errors")
    first = named[0][1]
    texts = list(patterns) or default_paths(first)
    drawn = {x.path: [(label, x)] for label, x in ((named[0][0], x) for x in chosen(first, texts))}
    for label, run in named[1:]:
        for x in chosen(run, texts):
            drawn.setdefault(x.path, []).append((label, x))
    figure, axes = _axes(len(drawn))
    for ax, (path, lines) in zip(axes, drawn.items(), strict=False):
        _draw_lines(ax, lines[0][1].unit, lines, name=path, graded=len(lines) > 6)
    if len(named) > 1:
        handles, names = axes[0].get_legend_handles_labels()
        _legend(figure, handles, names, loc="outside right upper")
    _finish_time(axes, [run for _, run in named])
    figure.align_ylabels()
    figure.suptitle(_title(first, title, ending=False))
    return figure


def draw_phase(
    results: Sequence[Result], x: str, y: str, title: str = "", labels: Sequence[str] = ()
) -> Figure:
    """Draw one variable over another; a dot stands at the start, an arrow tells the direction.

    Args:
        results: One run or several.
        x: Path or expression of what goes to the right.
        y: Path or expression of what goes up.
        title: Text above; the model's name and description if empty.
        labels: Names of the runs, if there are several.

    Raises:
        AcausalError: ``N901`` for an unknown name, ``F213`` if one of them means several
            variables.
    """
    figure = _shown_figure()(figsize=(6.4, 5.6), dpi=120, layout="constrained")
    ax = figure.add_subplot()
    across = up = None
    for k, result in enumerate(results):
        across, up = _single(result, x), _single(result, y)
        right, above = _smooth(across), _smooth(up)
        label = labels[k] if k < len(labels) else ""
        (line,) = ax.plot(right, above, linewidth=1.3, label=label)
        good = np.isfinite(right) & np.isfinite(above)
        if good.any():
            colour = line.get_color()
            begin = int(np.argmax(good))
            ax.plot(right[begin], above[begin], "o", markersize=5, color=colour)
            _arrow(ax, right[good], above[good], colour)
    if across is not None and up is not None:
        ax.set_xlabel(_axis_text(across.path, across.unit))
        ax.set_ylabel(_axis_text(up.path, up.unit))
        if across.unit == up.unit == "m":
            ax.set_aspect("equal", adjustable="datalim")
    if any(labels):
        ax.legend(fontsize="small")
    ax.grid(visible=True, alpha=0.3)
    if results:
        figure.suptitle(_title(results[0], title, ending=len(results) == 1))
    return figure


def _found(result: Result, patterns: Sequence[str]) -> list[Trajectory]:
    texts = list(patterns)
    if texts:
        return chosen(result, texts)
    return [result.trajectory(path) for path in default_paths(result)]


def _by_unit(found: Sequence[Trajectory]) -> dict[str, list[Trajectory]]:
    """Group variables by unit; ``1`` and no unit are one."""
    groups: dict[str, list[Trajectory]] = {}
    for trajectory in found:
        unit = "" if trajectory.unit == "1" else trajectory.unit
        groups.setdefault(unit, []).append(trajectory)
    return groups


@cache
def _shown_figure() -> type[Figure]:
    """Return the class of figures that a notebook shows without being asked to."""
    from matplotlib import figure

    class Figure(figure.Figure):
        def _repr_png_(self) -> bytes:
            return picture(self, "png")

    return Figure


def _axes(rows: int) -> tuple[Figure, Sequence[Axes]]:

    rows = max(1, rows)
    figure = _shown_figure()(figsize=(8.0, 1.2 + 2.6 * rows), dpi=120, layout="constrained")
    return figure, list(figure.subplots(rows, 1, sharex=True, squeeze=False)[:, 0])


def _finish_time(axes: Sequence[Axes], results: Sequence[Result]) -> None:
    axes[-1].set_xlabel("time [s]")
    times = [t for r in results if len(r.times) for t in (r.times[0], r.times[-1])]
    if times and max(times) > min(times):
        axes[-1].set_xlim(float(min(times)), float(max(times)))


def _title(result: Result, title: str, ending: bool = True) -> str:
    text = title or " - ".join(x for x in (result.model_name, result.description) if x)
    if ending and result.ending is not Ending.COMPLETE and not title:
        text += f" ({result.ending.value})"
    return text


def _draw_lines(
    ax: Axes,
    unit: str,
    lines: Sequence[tuple[str, Trajectory]],
    name: str = "",
    graded: bool = False,
) -> None:
    colours: list[tuple[float, float, float, float] | None] = [None] * len(lines)
    if graded:
        import matplotlib

        # Neither end of the scale: the one is too pale on white, the other too dark on black.
        scale = matplotlib.colormaps["viridis"]
        colours = [scale(0.1 + 0.75 * k / (len(lines) - 1)) for k in range(len(lines))]
    for (label, trajectory), colour in zip(lines, colours, strict=True):
        ax.plot(trajectory.time, trajectory.values, linewidth=1.3, label=label, color=colour)
    if name or len(lines) == 1:
        ax.set_ylabel(_axis_text(name or lines[0][1].path, unit))
    else:
        ax.set_ylabel(_axis_text("", unit) or "value")
    if len(lines) > 1 and not name:
        _legend(ax, *ax.get_legend_handles_labels())
    ax.grid(visible=True, alpha=0.3)
    ax.margins(x=0)


def _legend(where: Any, handles: list[Any], labels: list[str], **place: str) -> None:
    if len(labels) > LONGEST_LEGEND:
        labels[LONGEST_LEGEND - 1] = f"... {len(labels) - LONGEST_LEGEND + 1} more"
    where.legend(handles[:LONGEST_LEGEND], labels[:LONGEST_LEGEND], fontsize="small", **place)


def _mark_events(ax: Axes, result: Result) -> None:
    if not len(result.times):
        return
    # Marks that could not be told apart are one.
    width = float(result.times[-1] - result.times[0]) / MOST_MARKS
    last = -np.inf
    for time in sorted(event.time for event in result.events):
        if time - last < width:
            continue
        last = time
        ax.axvline(time, color="0.5", linewidth=0.7, linestyle=(0, (2, 2)), zorder=0.5)


def _axis_text(name: str, unit: str) -> str:
    shown = f"[{pretty_unit(unit)}]" if unit and unit != "1" else ""
    return f"{name} {shown}".strip()


def _single(result: Result, text: str) -> Trajectory:
    found = chosen(result, [text])
    if len(found) != 1:
        fail("F213", f"{text} means {len(found)} variables",
             help="a phase portrait needs one for each axis")  # fmt: skip
    return found[0]


def _smooth(x: Trajectory) -> Array:
    """Return values for a curve: points between the stored ones where those are far apart."""
    if x.curve is None or len(x.time) < 2 or len(x.time) >= SMOOTH:
        return np.asarray(x.values)
    more = -(-SMOOTH // len(x.time))
    parts = np.linspace(0.0, 1.0, more, endpoint=False)
    times = x.time[:-1, None] + np.diff(x.time)[:, None] * parts
    return np.append(x(times.reshape(-1)), x.values[-1])


def _arrow(ax: Axes, right: Array, above: Array, colour: Any) -> None:
    """Draw an arrow head where a tenth of the way has been gone, on the screen's scale."""
    if len(right) < 3:
        return
    size = [float(np.ptp(v)) or 1.0 for v in (right, above)]
    way = np.concatenate([[0], np.cumsum(np.hypot(np.diff(right) / size[0],
                                                  np.diff(above) / size[1]))])  # fmt: skip
    if not way[-1] > 0:
        return
    here = min(max(1, int(np.searchsorted(way, min(0.1 * way[-1], 0.4)))), len(way) - 2)
    there = min(int(np.searchsorted(way, way[here] + 1e-3)), len(way) - 1)
    ax.annotate(
        "",
        xy=(right[there], above[there]),
        xytext=(right[here], above[here]),
        arrowprops={"arrowstyle": "-|>", "color": colour, "mutation_scale": 16, "shrinkA": 0,
                    "shrinkB": 0},
    )  # fmt: skip


def _short(value: object) -> str:
    return f"{value:g}" if isinstance(value, int | float) else str(value)


def pretty_unit(unit: str) -> str:
    """Return a unit as it is printed: ``kg.m2/s`` becomes ``kg·m²/s``."""
    text = re.sub(
        r"(?<=[A-Za-zΩ%])(-?\d+)", lambda match: match.group().translate(_SUPERSCRIPT), unit
    )
    return re.sub(r"\bOhm\b", "Ω", text.replace(".", "·"))


def write_figure(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure as PNG, SVG or PDF; the same figure gives the same bytes.

    Raises:
        AcausalError: ``F201`` unknown suffix, ``F202`` cannot write, ``F203`` disk full.
    """
    suffix = check_suffix(path, SUFFIXES)
    data = picture(figure, suffix[1:])
    with whole_file(path) as unfinished:
        Path(unfinished).write_bytes(data)


def picture(figure: Figure, form: str) -> bytes:
    """Return a figure as the bytes of a ``png``, ``svg`` or ``pdf`` file."""
    import matplotlib

    undated: dict[str, dict[str, str | None]] = {
        "png": {},
        "svg": {"Date": None},
        "pdf": {"CreationDate": None},
    }
    buffer = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "acausal"}):
        figure.savefig(buffer, format=form, metadata=undated[form])
    return buffer.getvalue()
