"""``acausal plot``."""

from __future__ import annotations

from pathlib import Path

import click

from acausal.cli.options import json_errors, split_patterns


@click.command(
    "plot",
    epilog="""\b
Examples:
  acausal plot run.nc -o run.png
  acausal plot run.nc -v 'link[*].angle' -v 'c.v*r.i' --events -o run.svg
  acausal plot light.csv heavy.csv -v x -o compared.png
  acausal plot run.parquet --phase x v -o phase.pdf
""",
)
@click.argument(
    "files", nargs=-1, required=True, metavar="RESULTFILE...", type=click.Path(path_type=Path)
)
@click.option(
    "-o",
    "--output",
    required=True,
    type=click.Path(path_type=Path, readable=False),
    help="Picture: .png, .svg, .pdf.",
)
@click.option(
    "-v",
    "--variables",
    multiple=True,
    metavar="PATTERN",
    help="Variables or expressions, e.g. 'link[*].angle' or 'c.v*r.i'. May be repeated.",
)
@click.option("--phase", nargs=2, metavar="X Y", help="Draw Y over X instead of over time.")
@click.option("--events", is_flag=True, help="Mark events (of a single result over time).")
@click.option("--title", default="", help="Text above the plot.")
@json_errors
def command(
    files: tuple[Path, ...],
    output: Path,
    variables: tuple[str, ...],
    phase: tuple[str, str] | None,
    events: bool,
    title: str,
) -> int:
    """Draw results that were stored in files, several of them over each other."""
    from acausal.results.files import check_target, read_result
    from acausal.results.plot import SUFFIXES, draw, draw_phase, draw_runs, write_figure

    if phase and variables:
        raise click.UsageError("Give --phase or --variables, not both.")
    check_target(output, SUFFIXES)
    patterns = split_patterns(variables)
    results = [read_result(file) for file in files]
    labels = [file.stem for file in files] if len(files) > 1 else []
    if len(set(labels)) < len(labels):
        labels = [str(file) for file in files]
    if phase:
        figure = draw_phase(results, *phase, title=title, labels=labels)
    elif len(results) == 1:
        figure = draw(results[0], patterns, title, events)
    else:
        figure = draw_runs(results, patterns, labels, title)
    write_figure(figure, output)
    return 0
