"""What a report says about a run: plots, states, events, the solver, data."""

from __future__ import annotations

import base64
import io
import re
from collections import Counter
from html import escape
from typing import TYPE_CHECKING

from acausal.inspection.lists import counted
from acausal.reporting.html import Section, code, details, number, table, unit
from acausal.results.plot import default_paths, pretty_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from acausal.diagnostics import Diagnostic
    from acausal.results.result import Result
    from acausal.results.trajectory import Trajectory

#: Largest CSV file that goes into the page, in characters.
MOST_DATA = 400_000
#: Lines in plots.
MOST_LINES = 40
#: States and events in tables.
MOST_STATES, MOST_EVENTS = 60, 60


def plots(result: Result, patterns: tuple[str, ...]) -> Section:
    """Return the trajectories as one picture."""
    if len(result.times) < 2:
        return Section("plots", "Plots", "")
    paths = result.find(*patterns) if patterns else default_paths(result)
    body = f"<figure>{figure_svg(_figure(result, paths[:MOST_LINES]))}</figure>"
    if len(paths) > MOST_LINES:
        body += f'<p class="note">{MOST_LINES} of {len(paths)} variables.</p>'
    return Section("plots", "Plots", body)


def _figure(result: Result, paths: list[str]) -> Figure:
    """Return a figure with one set of axes for each unit, two in a row if there are many."""
    from matplotlib.figure import Figure

    by_unit: dict[str, list[Trajectory]] = {}
    for path in paths:
        trajectory = result.trajectory(path)
        by_unit.setdefault(trajectory.unit, []).append(trajectory)
    columns = 1 if len(by_unit) < 3 else 2
    rows = -(-len(by_unit) // columns)
    size = (10.5, 2.7 * rows + 0.3) if columns == 2 else (8.5, 2.7 * rows + 0.5)
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(rows, columns, sharex=True, squeeze=False).reshape(-1)
    for ax, (of, trajectories) in zip(axes, by_unit.items(), strict=False):
        for trajectory in trajectories:
            ax.plot(trajectory.time, trajectory.values, linewidth=1.4, label=trajectory.path)
        shown = f" [{pretty_unit(of)}]" if of and of != "1" else ""
        one = len(trajectories) == 1
        ax.set_title((trajectories[0].path if one else "") + shown, fontsize=10, loc="left")
        if not one:
            beside = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0)} if len(by_unit) < 3 else {}
            ax.legend(fontsize="small", framealpha=0.8, **beside)
        ax.grid(visible=True, alpha=0.3)
        ax.margins(x=0)
        ax.spines[["top", "right"]].set_visible(False)
    for ax in axes[len(by_unit) :]:
        ax.set_visible(False)
    for ax in axes[max(0, len(by_unit) - columns) : len(by_unit)]:
        ax.set_xlabel("time [s]")
        ax.tick_params(labelbottom=True)
    return figure


def figure_svg(figure: Figure) -> str:
    """Return a matplotlib figure as SVG for a page: no header, no metadata, text as text."""
    import matplotlib

    buffer = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": "acausal", "svg.fonttype": "none"}):
        figure.savefig(buffer, format="svg", metadata={"Date": None}, transparent=True)
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r"\s*\n\s*", "\n", text)
    return text.replace(' version="1.1"', "").strip()


def states(result: Result) -> Section:
    """Return the states with their start and end values and ranges."""
    if not len(result.times):
        return Section("states", "States", "")
    paths = [p for p in result.states if p in result]
    rows = []
    for path in paths[:MOST_STATES]:
        trajectory = result.trajectory(path)
        values = trajectory.values
        rows.append(
            (code(path), number(float(values[0])), number(float(values.min())),
             number(float(values.max())), number(float(values[-1])), unit(trajectory.unit),
             escape(trajectory.description))
        )  # fmt: skip
    body = table(("", "start", "least", "largest", "end", "unit", ""), rows, "tnnnn--")
    if len(paths) > MOST_STATES:
        body += f'<p class="note">and {counted(len(paths) - MOST_STATES, "more state")}.</p>'
    return Section("states", "States", body)


def events(result: Result) -> Section:
    """Return what happened when."""
    happened = list(result.events)
    if not happened:
        return Section("events", "Events", "")
    rows = [(number(e.time), escape(e.text)) for e in happened[:MOST_EVENTS]]
    listing = table(("time [s]", "what"), rows, "n-")
    if len(happened) > MOST_EVENTS:
        listing += f'<p class="note">and {counted(len(happened) - MOST_EVENTS, "more event")}.</p>'
    counts = Counter(e.text for e in happened)
    body = f"<p>{counted(len(happened), 'event')}.</p>"
    if len(counts) < len(happened):
        common = [(str(n), escape(text)) for text, n in counts.most_common(20)]
        body += table(("times", "what"), common, "n-")
        return Section("events", "Events", body + details("In order of time", listing))
    return Section("events", "Events", body + listing)


_WORDS = {
    "steps": "Steps",
    "residual_evaluations": "Evaluations of the equations",
    "jacobian_evaluations": "Evaluations of the Jacobian",
    "error_test_failures": "Steps repeated for accuracy",
    "convergence_failures": "Steps repeated for convergence",
    "state_changes": "Changes of states",
}


def solver(result: Result) -> Section:
    """Return how the run went. Times are left out: the same run gives the same page."""
    experiment = dict(result.experiment)
    rows = [("Ending", escape(result.ending.value))]
    for key, title, of in (
        ("start_time", "Start", "s"),
        ("stop_time", "Stop", "s"),
        ("tolerance", "Relative tolerance", ""),
        ("solver", "Solver", ""),
    ):
        value = experiment.get(key)
        if value is not None:
            text = escape(value) if isinstance(value, str) else f"{number(float(value))} {of}"
            rows.append((title, text.strip()))
    rows.append(("Stored points", str(len(result.times))))
    rows += [
        (words, f"{result.statistics[key]}")
        for key, words in _WORDS.items()
        if result.statistics.get(key)
    ]
    return Section("solver", "Solver", table(("", ""), rows, "t-", "short"))


def data(result: Result) -> Section:
    """Return the trajectories as files inside of the page, if they are not too long."""
    if not len(result.times):
        return Section("data", "Data", "")
    name = re.sub(r"\W+", "_", result.model_name.rpartition(".")[2])
    every = list(result.variables.paths())
    plotted = [p for p in result.states if p in result]
    links = []
    for paths, what, suffix in ((every, "all variables", ""), (plotted, "states", "_states")):
        if not paths or len(paths) * len(result.times) * 8 > MOST_DATA:
            continue
        text = _csv(result, paths)
        if len(text) <= MOST_DATA:
            content = base64.b64encode(text.encode()).decode()
            links.append(
                f'<a class="button" download="{name}{suffix}.csv" '
                f'href="data:text/csv;base64,{content}">CSV, {what} '
                f'<span class="note">{len(text) / 1024:.0f} kB</span></a>'
            )
            break
    return Section("data", "Data", "".join(links))


def _csv(result: Result, paths: list[str]) -> str:
    """Return a table with six digits, which is what a page is for; files have them all."""
    import numpy as np

    table_ = np.column_stack([result.times, result.variables.many(paths)]) + 0.0
    head = ["time [s]"]
    for path in paths:
        of = result.variables.unit(path)
        head.append(f"{path} [{of}]" if of else path)
    lines = [",".join(f'"{h}"' if "," in h else h for h in head)]
    lines += [",".join(f"{x:.7g}" for x in row) for row in table_.tolist()]
    return "\n".join(lines) + "\n"


def messages(diagnostics: tuple[Diagnostic, ...], failed: bool) -> str:
    """Return warnings or errors as boxes."""
    boxes = []
    for diagnostic in diagnostics[:20]:
        kind = "bad" if failed else "warn"
        more = [*diagnostic.notes, *([diagnostic.help] if diagnostic.help else [])]
        about = "".join(f'<br/><span class="note">{escape(text)}</span>' for text in more)
        boxes.append(
            f'<div class="{kind}"><b>{escape(diagnostic.code)}</b> {escape(diagnostic.message)}'
            f"{about}</div>"
        )
    if len(diagnostics) > 20:
        boxes.append(f'<p class="note">and {len(diagnostics) - 20} more messages.</p>')
    return "".join(boxes)
