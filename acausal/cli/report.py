"""Messages on the terminal: text for people, JSON for tools, colours only where they are seen."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Mapping
from typing import TextIO

import click

from acausal.diagnostics import AcausalError, Diagnostic


def wants_color(stream: TextIO) -> bool:
    """Return whether colours may be written: a terminal, and nobody asked for none."""
    if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return False
    return stream.isatty()


def report(
    what: AcausalError | Iterable[Diagnostic],
    as_json: bool = False,
    sources: Mapping[str, str] | None = None,
) -> None:
    """Write diagnostics to the standard error stream.

    Args:
        what: An error or diagnostics; nothing is written if there are none.
        as_json: Write one line of JSON.
        sources: Texts that came from no file, by the name their spans give.
    """
    diagnostics = what.diagnostics if isinstance(what, AcausalError) else tuple(what)
    if not diagnostics:
        return
    if as_json:
        import json

        from acausal.diagnostics.render import as_data

        text = json.dumps({"diagnostics": [as_data(d) for d in diagnostics]}) + "\n"
    else:
        from acausal.diagnostics.render import render

        text = render(diagnostics, color=wants_color(sys.stderr), sources=sources)
    click.echo(text, err=True, nl=False, color=True)


def report_error(error: Exception, as_json: bool = False) -> None:
    """Tell about a defect of acausal: an exception that is nobody's mistake but ours."""
    place = ""
    trace = error.__traceback__
    while trace is not None:
        code = trace.tb_frame.f_code
        place = f"{os.path.basename(code.co_filename)}:{trace.tb_lineno} in {code.co_name}"
        trace = trace.tb_next
    about = " ".join(str(error).split())[:300]
    report(
        [
            Diagnostic(
                "F499",
                f"internal error: {type(error).__name__}{': ' + about if about else ''}",
                notes=(f"at {place}", "this is a defect of acausal, not of your model"),
                help="run it again with ACAUSAL_TRACEBACK=1 and send us the output and the model",
            )
        ],
        as_json,
    )
