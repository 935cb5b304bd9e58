"""``acausal simulate``."""

from __future__ import annotations

import math
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from acausal.cli.main import EXIT_INTERRUPTED, EXIT_MODEL, EXIT_PARTIAL
from acausal.cli.netlist import compile_source
from acausal.cli.options import (
    file_argument,
    json_errors,
    model_argument,
    parameter_option,
    read_parameters,
    split_patterns,
)
from acausal.cli.progress import SimulatedTime
from acausal.cli.report import report
from acausal.diagnostics import AcausalError, fail

if TYPE_CHECKING:
    from acausal.results import Result

#: Largest number of variables written without being asked for by name.
MOST_UNASKED = 100_000

SOLVERS = ("ida", "odes-ida", "odes-cvode", "radau")


class Seconds(click.ParamType[float]):
    """A finite number of seconds, also with a unit: ``100[ms]``."""

    name = "seconds"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return seconds, or refuse."""
        text = str(value).strip()
        number, bracket, unit = text.partition("[")
        factor = 1.0
        if bracket:
            from acausal.units import UnitError, parse_unit

            try:
                parsed = parse_unit(unit.removesuffix("]"))
            except UnitError as error:
                self.fail(str(error), param, ctx)
            if parsed.dimension != (0, 0, 1, 0, 0, 0, 0):
                self.fail(f"{parsed.text} is not a unit of time", param, ctx)
            factor = parsed.factor
        try:
            seconds = float(number) * factor
        except ValueError:
            self.fail(f"'{text}' is not a number of seconds", param, ctx)
        if not math.isfinite(seconds):
            self.fail(f"'{text}' is not finite", param, ctx)
        return seconds


@click.command(
    "simulate",
    epilog="""\b
Examples:
  acausal simulate rlc.acm --plot rlc.png
  acausal simulate rlc.acm RLC -p r.R=1[kOhm] -p source.f=60 --stop 0.2 --output run.csv
  acausal simulate chain.acm --variables 'link[*].angle' --output run.nc
  acausal simulate rlc.acm --output - | head
\b
Exit codes: 0 done, 1 error in the model, 2 error on the command line, 3 the simulation failed
but what was computed is kept, 130 interrupted and what was computed is kept.
""",
)
@file_argument
@model_argument
@parameter_option
@click.option(
    "--start", "start_time", type=Seconds(), help="Start time (default: as in the model)."
)
@click.option("--stop", "stop_time", type=Seconds(), help="Stop time (default: as in the model).")
@click.option(
    "--tolerance",
    type=click.FloatRange(0, 1, min_open=True, max_open=True),
    help="Relative tolerance (default: as in the model).",
)
@click.option("--solver", type=click.Choice(SOLVERS), default="ida", show_default=True)
@click.option("--points", type=click.IntRange(min=2), help="Number of stored points.")
@click.option("--interval", type=Seconds(), help="Time between two stored points.")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, allow_dash=True, readable=False),
    help="Table of results: .csv, .nc, .h5, .parquet, or - for CSV on the standard output.",
)
@click.option(
    "--plot",
    type=click.Path(path_type=Path, readable=False),
    help="Picture of results: .png, .svg, .pdf.",
)
@click.option(
    "-v",
    "--variables",
    multiple=True,
    metavar="PATTERN",
    help="Variables to keep, e.g. 'link[*].angle' or 'c.*', or expressions of them, e.g. "
    "'c.v*r.i'. May be repeated.",
)
@click.option(
    "--stream",
    is_flag=True,
    help="Write the table while the simulation goes on: for results larger than the memory. "
    "Of expressions the variables in them are written.",
)
@click.option("--no-progress", is_flag=True, help="Draw no progress bar.")
@click.option("--timings", is_flag=True, help="Show how long each stage took.")
@json_errors
@click.pass_context
def command(
    ctx: click.Context,
    file: Path,
    model: str | None,
    parameters: tuple[str, ...],
    start_time: float | None,
    stop_time: float | None,
    tolerance: float | None,
    solver: str,
    points: int | None,
    interval: float | None,
    output: Path | None,
    plot: Path | None,
    variables: tuple[str, ...],
    stream: bool,
    no_progress: bool,
    timings: bool,
) -> int:
    """Simulate MODEL in FILE, or a SPICE netlist.

    Without MODEL the last model of the file is taken. Times are in seconds; a unit may be given in
    brackets, as in --stop 100[ms].
    """
    begin = time.perf_counter()
    values = read_parameters(parameters)
    if points is not None and interval is not None:
        raise click.UsageError("Give --points or --interval, not both.")
    if interval is not None and interval <= 0:
        raise click.BadParameter("must be greater than 0", param_hint="'--interval'")
    patterns = split_patterns(variables)
    if stream and (output is None or str(output) == "-"):
        raise click.UsageError("--stream needs a file: --output run.nc.")
    _check_targets(output, plot)
    as_json = bool(ctx.obj)

    try:
        compiled = compile_source(file, model, values, as_json)
    except AcausalError as error:
        # A value given with -p is a source of its own.
        report(error, as_json, {f"<{name}>": str(value) for name, value in values.items()})
        return EXIT_MODEL
    report(compiled.warnings, as_json)
    if output is not None and not patterns:
        _refuse_unasked(compiled.system.variables.count)
    streamed: dict[str, Any] = {"output": output, "keep": False} if stream else {}
    shown = sys.stderr.isatty() and not no_progress and not as_json
    with SimulatedTime(start_time or 0.0, shown) as progress:
        result = compiled.simulate(
            start_time=start_time,
            stop_time=stop_time,
            tolerance=tolerance,
            solver=solver,
            points=points,
            interval=interval,
            progress=progress,
            variables=patterns or None,
            **streamed,
        )
    report(result.diagnostics, as_json)
    simulated = time.perf_counter()
    _write(result, output, plot, patterns, stream)
    if timings:
        written = time.perf_counter() - simulated
        _show_timings({**compiled.timings, "write": written}, time.perf_counter() - begin)
    return _exit_code(result)


def _refuse_unasked(count: int) -> None:
    """Refuse to write a table that nobody can have meant, before it is computed."""
    if count > MOST_UNASKED:
        fail(
            "F206",
            f"the model has {count} variables; a table of all of them is hardly meant",
            help="choose some with --variables, e.g. --variables 'section[1].*'; "
            "--variables '*' writes all",
        )


def _check_targets(output: Path | None, plot: Path | None) -> None:
    """Refuse what cannot be written before anything is computed."""
    from acausal.results.files import SUFFIXES, check_target

    if output is not None and str(output) != "-":
        check_target(output, SUFFIXES)
    if plot is not None:
        check_target(plot, (".png", ".svg", ".pdf"))


def _write(
    result: Result,
    output: Path | None,
    plot: Path | None,
    patterns: tuple[str, ...],
    written: bool = False,
) -> None:
    if output is not None and str(output) == "-":
        from acausal.results.csv_file import write_rows
        from acausal.results.files import computed

        found = computed(result, patterns)
        write_rows(found, found.find(), sys.stdout)
    elif output is not None and not written:
        result.write(output, *patterns)
    if plot is not None:
        result.plot(*patterns, file=plot)
    if output is None and plot is None:
        from acausal.cli.summary import summary

        click.echo(summary(result, patterns))
    elif str(output) != "-":
        count = len(result.times)
        end = f" to {result.times[-1]:g} s" if count else ""
        where = " and ".join(str(x) for x in (output, plot) if x is not None)
        click.echo(f"{result.model_name}: {count} points{end} in {where}", err=True)


def _show_timings(timings: dict[str, float], total: float) -> None:
    width = max(map(len, timings), default=5)
    for stage, seconds in timings.items():
        click.echo(f"{stage:<{width}} {seconds * 1e3:10.2f} ms", err=True)
    click.echo(f"{'total':<{width}} {total * 1e3:10.2f} ms", err=True)


def _exit_code(result: Result) -> int:
    from acausal.results import Ending

    if result.ending is Ending.INTERRUPTED:
        click.echo("interrupted; what was computed is kept", err=True)
        return EXIT_INTERRUPTED
    return EXIT_PARTIAL if result.ending is Ending.FAILED else 0
