"""The report: everything about a model and a run of it on one page that needs nothing else."""

from __future__ import annotations

import os
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from acausal.diagnostics import AcausalError, Diagnostic
from acausal.drawing.paint import paint
from acausal.drawing.schematic import schematic
from acausal.inspection.summary import summary
from acausal.reporting import model_sections, run_sections
from acausal.reporting.html import Section
from acausal.results.files import check_suffix, whole_file
from acausal.results.result import Ending
from acausal.version import __version__

if TYPE_CHECKING:
    from acausal.inspection.inspect import Compilation
    from acausal.results.result import Result

_HERE = Path(__file__).parent
SUFFIXES = (".html", ".htm")


def report_page(
    stages: Compilation,
    result: Result | None = None,
    patterns: Sequence[str] = (),
    depth: int = 1,
    failure: Sequence[Diagnostic] = (),
) -> str:
    """Return the page about a model.

    The same model and the same trajectories give the same text.

    Args:
        stages: What the compiler has made of the model.
        result: A run of it; without one the page is about the model alone.
        patterns: Variables to plot; the states if there are none.
        depth: Levels of components in the schematic.
        failure: Why there is no result, if one was wanted.

    Raises:
        AcausalError: ``N901`` if a pattern matches nothing.
    """
    counts = summary(stages)
    run: list[Section] = []
    states: list[Section] = []
    events: list[Section] = []
    plots: list[Section] = []
    if result is not None:
        plots = [run_sections.plots(result, tuple(patterns))]
        states = [run_sections.states(result)]
        events = [run_sections.events(result)]
        run = [run_sections.solver(result), run_sections.data(result)]
    parts = [
        _schematic(stages, depth),
        *plots,
        model_sections.parameters(stages),
        *states,
        model_sections.equations(stages),
        model_sections.structure(stages, counts),
        *events,
        model_sections.assertions(stages),
        *run,
    ]
    failed = bool(failure) or (result is not None and result.ending is Ending.FAILED)
    told = tuple(failure) + (result.diagnostics if result is not None else ())
    boxes = run_sections.messages(counts.warnings, False) + run_sections.messages(told, failed)
    head = model_sections.facts(counts) + boxes
    return _document(counts.name, counts.description, head, [p for p in parts if p.body])


def write_page(path: str | os.PathLike[str], page: str) -> None:
    """Write a page into a file.

    Raises:
        AcausalError: ``F201`` unknown suffix, ``F202`` cannot write, ``F203`` disk full.
    """
    check_suffix(path, SUFFIXES)
    with whole_file(path) as unfinished:
        Path(unfinished).write_text(page, encoding="utf-8")


def _schematic(stages: Compilation, depth: int) -> Section:
    flattened = stages.flattened
    assert flattened is not None
    title = "Schematic"
    try:
        drawing = schematic(flattened.numbering.groups[-1].template, depth)
    except AcausalError as error:
        if error.diagnostics[0].code != "F112":
            raise
        note = escape(error.diagnostics[0].message)
        return Section("schematic", title, f'<p class="note">Not drawn: {note}.</p>')
    if not drawing.layout.nets:
        return Section("schematic", title, "")
    picture = paint(drawing.layout, drawing.title, styled=False)
    left, top, right, bottom = drawing.layout.box
    tall = ' class="tall"' if bottom - top > 0.9 * (right - left) else ""
    return Section("schematic", title, f"<figure{tall}>{picture}</figure>")


def _document(title: str, about: str, head: str, sections: Sequence[Section]) -> str:
    style = (_HERE / "style.css").read_text(encoding="utf-8")
    links = "".join(f'<a href="#{s.key}">{s.title}</a>' for s in sections)
    body = "".join(f'<section id="{s.key}"><h2>{s.title}</h2>{s.body}</section>' for s in sections)
    lead = f'<p class="lead">{escape(about)}</p>' if about else ""
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8"/>'
        '<meta name="viewport" content="width=device-width,initial-scale=1"/>'
        f"<title>{escape(title)} · report</title><style>{style}</style></head><body>"
        f'<div class="page"><nav>{links}</nav><main><h1>{escape(title)}</h1>{lead}{head}{body}'
        f"<footer>Made by acausal {__version__}.</footer></main></div></body></html>\n"
    )
