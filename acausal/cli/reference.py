"""``acausal reference``."""

from __future__ import annotations

from pathlib import Path

import click

from acausal.cli.options import json_errors


@click.command(
    "reference",
    epilog="""\b
Examples:
  acausal reference
  acausal reference electrical mechanical.planar -o pages
""",
)
@click.argument("packages", nargs=-1, metavar="[PACKAGE]...")
@click.option(
    "-o",
    "--output",
    "folder",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("reference"),
    show_default=True,
    help="Folder for the pages; made if it is not there.",
)
@json_errors
@click.pass_obj
def command(as_json: bool, packages: tuple[str, ...], folder: Path) -> None:
    """Write the reference of the component library as web pages.

    One page for each PACKAGE (without any: all of them) and index.html with a search over all
    classes. Every page stands alone: symbols, equations and style are in it.
    """
    from acausal.cli.report import report
    from acausal.modeling.library import standard_library
    from acausal.reference.write import icon_diagnostics, write_reference

    library = standard_library()
    try:
        written = write_reference(folder, packages, library)
    except OSError as error:
        reason = error.strerror or str(error)
        raise click.BadParameter(f"{folder} cannot be written: {reason}") from error
    report(icon_diagnostics(library), as_json)
    size = sum(path.stat().st_size for path in written)
    click.echo(f"{len(written)} pages, {size / 1e6:.1f} MB: open {written[0]}")
