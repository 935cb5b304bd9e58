"""``acausal list``."""

from __future__ import annotations

import click

from acausal.cli.options import json_errors


@click.command(
    "list",
    epilog="""\b
Examples:
  acausal list
  acausal list electrical
  acausal list electrical.Resistor
  acausal list mechanical --deep | grep -i spring
""",
)
@click.argument("name", required=False, default="", metavar="[PACKAGE|CLASS]")
@click.option("--deep", is_flag=True, help="Show the classes of sub-packages too.")
@json_errors
def command(name: str, deep: bool) -> None:
    """Show what the component library contains.

    Without a name the packages; of a package its classes; of a class its cuts, parameters and
    variables with units and defaults.
    """
    from acausal.modeling.listing import describe

    click.echo(describe(name, deep=deep))
