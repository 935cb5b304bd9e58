"""The command line. Everything but click is imported when a command needs it."""

from __future__ import annotations


def main() -> None:
    """Run the command line and exit with its code."""
    from acausal.cli.main import run

    run()
