"""Plots over time: one set of axes for each unit.

Matplotlib's object interface is used without ``pyplot``: no window system is touched, and no figure
is kept alive by a global list.
"""

from __future__ import annotations

import io
import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from acausal.results.files import check_suffix, whole_file
from acausal.results.result import Ending, Result
from acausal.results.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SUFFIXES = (".png", ".svg", ".pdf")
#: Variables drawn when none were named.
DEFAULT_LINES = 12
#: Longest legend.
LONGEST_LEGEND = 15
_SUPERSCRIPT = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


def default_paths(result: Result) -> list[str]:
    """Return what is drawn when nothing was asked for: the states, or else the first variables."""
    paths = [path for path in result.states if not path.startswith("der(")]
    if not paths:
        paths = list(result.variables.paths()[:DEFAULT_LINES])
    return paths[:DEFAULT_LINES]


def draw(result: Result, patterns: Sequence[str] = (), title: str = "") -> Figure:
    """Draw variables over time.

    Args:
        result: The simulation's result.
        patterns: Paths or patterns; the states if there are none.
        title: Text above; the model's name and description if empty.

    Raises:
        AcausalError: ``N901`` if a pattern matches nothing.
    """
    from matplotlib.figure import Figure

    paths = result.find(*patterns) if patterns else default_paths(result)
    by_unit: dict[str, list[Trajectory]] = {}
    for path in paths:
        trajectory = result.trajectory(path)
        by_unit.setdefault(trajectory.unit, []).append(trajectory)
    rows = max(1, len(by_unit))
    figure = Figure(figsize=(8.0, 1.2 + 2.6 * rows), dpi=120, layout="constrained")
    axes = figure.subplots(rows, 1, sharex=True, squeeze=False)[:, 0]
    for ax, (unit, trajectories) in zip(axes, by_unit.items(), strict=False):
        _draw_unit(ax, unit, trajectories)
    axes[-1].set_xlabel("time [s]")
    if len(result.times) > 1 and result.times[-1] > result.times[0]:
        axes[-1].set_xlim(float(result.times[0]), float(result.times[-1]))
    text = title or " - ".join(x for x in (result.model_name, result.description) if x)
    if result.ending is not Ending.COMPLETE and not title:
        text += f" ({result.ending.value})"
    figure.align_ylabels()
    figure.suptitle(text)
    return figure


def _draw_unit(ax: Axes, unit: str, trajectories: list[Trajectory]) -> None:
    for trajectory in trajectories:
        ax.plot(trajectory.time, trajectory.values, linewidth=1.3, label=trajectory.path)
    shown = f" [{pretty_unit(unit)}]" if unit and unit != "1" else ""
    if len(trajectories) == 1:
        ax.set_ylabel(trajectories[0].path + shown)
    else:
        ax.set_ylabel(shown.strip() or "value")
        handles, labels = ax.get_legend_handles_labels()
        if len(labels) > LONGEST_LEGEND:
            labels[LONGEST_LEGEND - 1] = f"... {len(labels) - LONGEST_LEGEND + 1} more"
        ax.legend(handles[:LONGEST_LEGEND], labels[:LONGEST_LEGEND], fontsize="small")
    ax.grid(visible=True, alpha=0.3)
    ax.margins(x=0)


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
    import matplotlib

    suffix = check_suffix(path, SUFFIXES)
    undated: dict[str, dict[str, str | None]] = {
        ".png": {},
        ".svg": {"Date": None},
        ".pdf": {"CreationDate": None},
    }
    buffer = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "acausal"}):
        figure.savefig(buffer, format=suffix[1:], metadata=undated[suffix])
    with whole_file(path) as unfinished:
        Path(unfinished).write_bytes(buffer.getvalue())
