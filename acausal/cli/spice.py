"""``acausal spice``."""

from __future__ import annotations

from pathlib import Path

import click

from acausal.cli.options import file_argument, json_errors


@click.command(
    "spice",
    epilog="""\b
Examples:
  acausal spice amplifier.cir -o amplifier.acm
  acausal spice amplifier.cir
  acausal simulate amplifier.cir --plot amplifier.png
""",
)
@file_argument
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    help="File to write; the standard output without it.",
)
@click.option("--name", help="Name of the model (default: that of the file).")
@json_errors
@click.pass_obj
def command(as_json: bool, file: Path, output: Path | None, name: str | None) -> None:
    """Translate the SPICE netlist FILE to a model.

    What is not supported is refused with its line; what has no effect here is told.
    """
    from acausal.cli.report import report
    from acausal.diagnostics import fail
    from acausal.netlists.spice.reader import model_and_warnings

    model, warnings = model_and_warnings(file, name)
    report(warnings, as_json)
    text = model.to_acm()
    if output is None:
        click.echo(text, nl=False)
        return
    try:
        output.write_text(text, encoding="utf-8")
    except OSError as error:
        fail("F202", f"{output} cannot be written: {error.strerror or error}",
             help="check the folder and its permissions")  # fmt: skip
    click.echo(f"{model.name} in {output}", err=True)
