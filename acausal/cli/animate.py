"""``acausal animate``."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import click

from acausal.cli.main import EXIT_MODEL
from acausal.cli.options import (
    file_argument,
    json_errors,
    model_argument,
    parameter_option,
    read_parameters,
)
from acausal.cli.progress import SimulatedTime
from acausal.cli.report import report
from acausal.cli.simulate import Seconds, _exit_code
from acausal.diagnostics import AcausalError


@click.command(
    "animate",
    epilog="""\b
Examples:
  acausal animate four_bar.acm -o four_bar.html
  acausal animate percussion_hammer.acm -o hammer.gif --speed 0.05 --width 640
  acausal animate pendulum_chain.acm TriplePendulum -p 'phi0[1]=170[deg]' -o chain.mp4
""",
)
@file_argument
@model_argument
@parameter_option
@click.option(
    "-o",
    "--output",
    required=True,
    type=click.Path(path_type=Path, readable=False),
    help=".html to play with in any browser, .gif, or .mp4.",
)
@click.option("--stop", "stop_time", type=Seconds(), help="Stop time (default: as in the model).")
@click.option(
    "--speed",
    type=click.FloatRange(0, min_open=True),
    help="Simulated seconds per second (default: some ten seconds in all).",
)
@click.option(
    "--fps", type=click.FloatRange(0, min_open=True), default=25, show_default=True,
    help="Pictures per second of a GIF or MP4.",
)  # fmt: skip
@click.option(
    "--width", type=click.IntRange(16, 4096), default=800, show_default=True,
    help="Width of a GIF or MP4 in pixels.",
)  # fmt: skip
@click.option(
    "--points", type=click.IntRange(min=2), default=1001, show_default=True,
    help="Number of computed points.",
)  # fmt: skip
@json_errors
@click.pass_context
def command(
    ctx: click.Context,
    file: Path,
    model: str | None,
    parameters: tuple[str, ...],
    output: Path,
    stop_time: float | None,
    speed: float | None,
    fps: float,
    width: int,
    points: int,
) -> int:
    """Simulate MODEL in FILE and animate its components.

    Mechanisms in the plane and in space, parts that move along a line, and vehicles have shapes;
    others get them by annotations.
    """
    from acausal import compiler
    from acausal.animation.animation import SUFFIXES, animate
    from acausal.results.files import check_target

    check_target(output, SUFFIXES)
    values = read_parameters(parameters)
    as_json = bool(ctx.obj)
    try:
        compiled = compiler.compile_file(file, model=model, parameters=values)
    except AcausalError as error:
        # A value given with -p is a source of its own.
        report(error, as_json, {f"<{name}>": str(value) for name, value in values.items()})
        return EXIT_MODEL
    report(compiled.warnings, as_json)
    with SimulatedTime(0.0, sys.stderr.isatty() and not as_json) as progress:
        result = compiled.simulate(stop_time=stop_time, points=points, progress=progress)
    report(result.diagnostics, as_json)
    begin = time.perf_counter()
    animate(result, output, speed=speed, fps=fps, width=width)
    click.echo(f"{result.model_name}: {output} ({time.perf_counter() - begin:.1f} s)", err=True)
    return _exit_code(result)
