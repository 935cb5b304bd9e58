"""``acausal report``."""

from __future__ import annotations

from pathlib import Path

import click

from acausal.cli.main import EXIT_INTERRUPTED, EXIT_PARTIAL
from acausal.cli.options import (
    file_argument,
    json_errors,
    model_argument,
    parameter_option,
    read_parameters,
)
from acausal.cli.report import report
from acausal.cli.simulate import SOLVERS, Seconds
from acausal.diagnostics import AcausalError, Diagnostic


@click.command(
    "report",
    epilog="""\b
Examples:
  acausal report rlc.acm -o rlc.html
  acausal report chain.acm Chain10 -v 'link[*].phi' --stop 20
  acausal report plant.acm --no-run
\b
Exit codes: as those of simulate; a run that failed is reported too.
""",
)
@file_argument
@model_argument
@parameter_option
@click.option("--stop", "stop_time", type=Seconds(), help="Stop time (default: as in the model).")
@click.option(
    "--tolerance",
    type=click.FloatRange(0, 1, min_open=True, max_open=True),
    help="Relative tolerance (default: as in the model).",
)
@click.option("--solver", type=click.Choice(SOLVERS), default="ida", show_default=True)
@click.option(
    "-v",
    "--variables",
    multiple=True,
    metavar="PATTERN",
    help="Variables to plot (default: the states). May be repeated.",
)
@click.option(
    "--depth",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    help="Levels of components in the schematic.",
)
@click.option("--no-run", is_flag=True, help="Report about the model alone, without a simulation.")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, readable=False),
    help="The page (default: MODEL.html).",
)
@json_errors
@click.pass_obj
def command(
    as_json: bool,
    file: Path,
    model: str | None,
    parameters: tuple[str, ...],
    stop_time: float | None,
    tolerance: float | None,
    solver: str,
    variables: tuple[str, ...],
    depth: int,
    no_run: bool,
    output: Path | None,
) -> int:
    """Write a report about MODEL in FILE and its simulation: one web page that needs nothing else.

    Without MODEL the last model of the file is taken.
    """
    from acausal import compiler
    from acausal.reporting.report import SUFFIXES, report_page, write_page
    from acausal.results import Ending
    from acausal.results.files import check_target

    if output is not None:
        check_target(output, SUFFIXES)
    compiled = compiler.compile_file(file, model=model, parameters=read_parameters(parameters))
    target = output or Path(f"{compiled.name.rpartition('.')[2]}.html")
    result, code = None, 0
    failure: tuple[Diagnostic, ...] = ()
    if not no_run:
        try:
            result = compiled.simulate(stop_time=stop_time, tolerance=tolerance, solver=solver)
        except AcausalError as error:
            failure, code = error.diagnostics, EXIT_PARTIAL
            report(error, as_json)
        else:
            report(result.diagnostics, as_json)
            if result.ending is Ending.FAILED:
                code = EXIT_PARTIAL
            elif result.ending is Ending.INTERRUPTED:
                code = EXIT_INTERRUPTED
    write_page(target, report_page(compiled._all_stages(), result, variables, depth, failure))
    click.echo(f"{target}: {target.stat().st_size / 1024:.0f} kB")
    return code
