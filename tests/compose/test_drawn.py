"""Models made in Python are drawn and reported like others."""

from __future__ import annotations

import acausal as ac
from acausal.library import electrical as el


def test_a_model_is_drawn_and_reported(tmp_path):
    """The schematic has every component, the page the model's name."""
    circuit = ac.Model("Loop")
    circuit.source = el.ConstantVoltage(V=1)
    circuit.r = el.Resistor(R=2)
    circuit.ground = el.Ground()
    circuit.connect(circuit.source.p, circuit.r.p)
    circuit.connect(circuit.r.n, circuit.source.n, circuit.ground.p)
    drawing = circuit.schematic(tmp_path / "loop.svg")
    assert (tmp_path / "loop.svg").read_text().strip() == drawing.svg.strip()
    assert all(f">{name}<" in drawing.svg for name in ("source", "r", "ground"))
    assert "Loop" in circuit.report(run=False)
