"""``acausal schematic``."""

from __future__ import annotations

from pathlib import Path

import click

from acausal.cli.options import (
    file_argument,
    json_errors,
    model_argument,
    parameter_option,
    read_parameters,
)


@click.command(
    "schematic",
    epilog="""\b
Examples:
  acausal schematic rlc.acm
  acausal schematic electric_car.acm -o car.png --depth 2
""",
)
@file_argument
@model_argument
@parameter_option
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, readable=False, allow_dash=True),
    help="The picture, .svg or .png; - for SVG on the standard output (default: MODEL.svg).",
)
@click.option(
    "--depth",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    help="Levels of components; above 1 components are drawn with what they are made of.",
)
@json_errors
def command(
    file: Path, model: str | None, parameters: tuple[str, ...], output: Path | None, depth: int
) -> None:
    """Draw the components of MODEL in FILE and their connections.

    Without MODEL the last model of the file is taken.
    """
    from acausal import compiler
    from acausal.drawing.schematic import SUFFIXES
    from acausal.results.files import check_target

    if output is not None and str(output) != "-":
        check_target(output, SUFFIXES)
    compiled = compiler.compile_file(file, model=model, parameters=read_parameters(parameters))
    drawing = compiled.schematic(depth=depth)
    if output is not None and str(output) == "-":
        click.echo(drawing.svg)
        return
    target = output or Path(f"{compiled.name.rpartition('.')[2]}.svg")
    drawing.write(target)
    click.echo(f"{len(drawing.layout.parts)} parts, {len(drawing.layout.nets)} nets in {target}")
