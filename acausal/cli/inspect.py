"""``acausal inspect``."""

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

STAGES = (
    "parse",
    "instantiate",
    "connect",
    "flatten",
    "eliminate",
    "structure",
    "blocks",
    "all",
)


@click.command(
    "inspect",
    epilog="""\b
Examples:
  acausal inspect rlc.acm
  acausal inspect rlc.acm --stage structure
  acausal inspect pendulum.acm --latex > equations.tex
""",
)
@file_argument
@model_argument
@click.option(
    "--stage",
    type=click.Choice(STAGES),
    default="all",
    show_default=True,
    help="The stage to show.",
)
@parameter_option
@click.option("--latex", is_flag=True, help="Print the equations as LaTeX.")
@json_errors
def command(
    file: Path, model: str | None, stage: str, parameters: tuple[str, ...], latex: bool
) -> None:
    """Show what each stage of the compiler made of MODEL in FILE.

    Families, junctions, states, what was differentiated and why, the index, and the blocks in which
    the equations are solved.
    """
    from acausal import compiler

    click.echo(
        compiler.inspect_file(
            file, model, stage=stage, latex=latex, parameters=read_parameters(parameters)
        ).rstrip("\n")
    )
