"""The command line. Everything but click is imported when a command needs it."""

from __future__ import annotations

import os


def main() -> None:
    """Run the command line and exit with its code."""
    # Nothing here multiplies large dense matrices, and the threads that NumPy's BLAS would start
    # wait actively: a tenth of a second of processor time at every start. Before NumPy's import.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from acausal.cli.main import run

    run()
