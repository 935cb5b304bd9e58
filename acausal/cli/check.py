"""``acausal check``."""

from __future__ import annotations

from pathlib import Path

import click

from acausal.cli.netlist import compile_source, is_netlist
from acausal.cli.options import file_argument, json_errors, model_argument


@click.command(
    "check",
    epilog="""\b
Examples:
  acausal check rlc.acm
  acausal check drives.acm Drive --json-errors
""",
)
@file_argument
@model_argument
@json_errors
@click.pass_obj
def command(as_json: bool, file: Path, model: str | None) -> None:
    """Check MODEL in FILE without simulating it.

    Reads the file, connects the components, checks units and counts equations and unknowns. Without
    MODEL the last model of the file is taken.
    """
    from acausal import compiler

    if is_netlist(file):
        from acausal.inspection.summary import summary

        compiled = compile_source(file, model, {}, as_json)
        assert compiled.stages is not None
        click.echo(str(summary(compiled.stages)).rstrip("\n"))
        return
    click.echo(str(compiler.check_file(file, model)).rstrip("\n"))
