"""Runs the circuits of the folder ``spice`` in ngspice, if it is installed."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

from benchmarks.processes import FailedError

DECKS = Path(__file__).resolve().parent / "spice"


def ngspice() -> str | None:
    """Return which ngspice there is, None if there is none."""
    if shutil.which("ngspice") is None:
        return None
    told = subprocess.run(["ngspice", "--version"], capture_output=True, text=True, check=False)
    found = re.search(r"ngspice-\S+", told.stdout)
    return found.group() if found else "ngspice"


def solve(
    circuit: str, quantity: str, stop: float, step: float, tolerance: float, folder: Path
) -> dict[str, Any]:
    """Run a circuit.

    Args:
        circuit: File without its ending.
        quantity: What is kept, such as ``v(p)``.
        stop: End, seconds.
        step: Longest step, seconds.
        tolerance: Relative tolerance.
        folder: For files.

    Returns:
        ``cpu`` (of the analysis, without reading), ``points`` accepted, ``final`` value.

    Raises:
        FailedError: ngspice does not finish.
    """
    deck = (DECKS / f"{circuit}.cir").read_text(encoding="utf-8")
    control = f"""
.options reltol={tolerance!r} abstol=1e-9 vntol=1e-6
.save {quantity}
.control
tran {step!r} {stop!r} 0 {step!r} uic
rusage trantime accept
print {quantity}[length({quantity})-1]
quit
.endc
.end
"""
    file = folder / f"{circuit}.cir"
    file.write_text(deck + control, encoding="utf-8")
    done = subprocess.run(
        ["ngspice", "-b", str(file)], capture_output=True, text=True, check=False, cwd=folder
    )
    figures = {}
    for name, pattern in (
        ("cpu", r"Transient analysis time = (\S+)"),
        ("points", r"Accepted timepoints = (\S+)"),
        ("final", r"\[length\(.*\)-1\] = (\S+)"),
    ):
        found = re.search(pattern, done.stdout)
        if found is None:
            raise FailedError(f"ngspice: {(done.stderr or done.stdout).strip()[-300:]}")
        figures[name] = float(found.group(1))
    return figures
