"""SPICE netlists as models."""

from __future__ import annotations

import warnings
from pathlib import Path

from acausal.compose.model import Model
from acausal.diagnostics import AcausalError, Diagnostic
from acausal.netlists.identifiers import identifier
from acausal.netlists.spice.cards import read_cards
from acausal.netlists.spice.circuit import model_of, uic_warnings
from acausal.netlists.spice.lines import read_text

#: How files of netlists are called.
SUFFIXES = (".cir", ".net", ".ckt", ".sp", ".spi", ".spice")


class NetlistWarning(UserWarning):
    """Something in a netlist has no effect."""


def read_spice(path: str | Path, name: str | None = None) -> Model:
    """Read a SPICE netlist as a model.

    Args:
        path: The file. Its first line is the title; files that it includes are relative to it.
        name: Name of the model; that of the file if not given.

    Returns:
        A model of the components of ``electrical.spice``, with the names of the netlist's elements.
        The voltage of node ``out`` is ``v_out``; ``.param`` become parameters; ``.tran`` sets what
        ``simulate`` does.

    Raises:
        AcausalError: For each mistake, and for what is not supported, at its line of the netlist.

    Warns:
        NetlistWarning: For what is left out: other analyses, parameters without effect here.

    Example:
        >>> import acausal as ac
        >>> circuit = ac.read_spice("examples/lowpass.cir")
        >>> result = circuit.simulate()
        >>> result["v_out"].unit
        'V'
    """
    model, found = model_and_warnings(Path(path), name)
    if found:
        warnings.warn(str(AcausalError(found)), NetlistWarning, stacklevel=2)
    return model


def model_and_warnings(path: Path, name: str | None = None) -> tuple[Model, list[Diagnostic]]:
    """Return the model of a netlist, and what was left out of it."""
    netlist = read_cards(read_text(path, None), path)
    model = model_of(netlist, name or identifier(path.stem, "circuit_"))
    return model, [*netlist.warnings, *uic_warnings(netlist)]
