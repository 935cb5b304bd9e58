"""``acausal messages``."""

from __future__ import annotations

import click


@click.command(
    "messages",
    epilog="""\b
Examples:
  acausal messages
  acausal messages S103
  acausal messages U
""",
)
@click.argument("codes", nargs=-1, metavar="[CODE]...")
def command(codes: tuple[str, ...]) -> None:
    """Tell what message codes mean: all, those named, or those of a stage's letter."""
    from acausal.diagnostics.codes import CODES, STAGES

    for code in codes:
        if code.upper() not in CODES and code.upper() not in STAGES:
            raise click.BadParameter(
                f"there is no code {code}; the letters are "
                + ", ".join(f"{letter} ({about})" for letter, about in STAGES.items()),
                param_hint="CODE",
            )
    wanted = tuple(code.upper() for code in codes) or ("",)
    for letter, about in STAGES.items():
        rows = [
            f"  {code}  {meaning}"
            for code, meaning in CODES.items()
            if code[0] == letter and code.startswith(wanted)
        ]
        if rows:
            click.echo("\n".join([f"{letter}: {about}", *rows]))
