"""SPICE netlists on the command line: a file that is no text of the language is translated."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from acausal.cli.report import report

if TYPE_CHECKING:
    from acausal.compiler import Compiled

#: How files of netlists are called; the same as in :mod:`acausal.netlists.spice.reader`.
SUFFIXES = (".cir", ".net", ".ckt", ".sp", ".spi", ".spice")


def is_netlist(file: Path) -> bool:
    """Tell whether a file is a SPICE netlist, by its name."""
    return file.suffix.lower() in SUFFIXES


def compile_source(
    file: Path, model: str | None, parameters: Mapping[str, float | str], as_json: bool
) -> Compiled:
    """Compile a model of a file, or a netlist.

    Raises:
        AcausalError: For any mistake in it; ``F105`` if a netlist is asked for one of its parts.
    """
    if not is_netlist(file):
        from acausal import compiler

        return compiler.compile_file(file, model=model, parameters=parameters)
    from acausal.diagnostics import fail
    from acausal.netlists.spice.reader import model_and_warnings

    circuit, warnings = model_and_warnings(file)
    report(warnings, as_json)
    if model not in (None, circuit.name):
        fail("F105", f"{file} has no model {model}",
             help=f"leave it out: a netlist is one model, {circuit.name}")  # fmt: skip
    return circuit.compile(parameters)
