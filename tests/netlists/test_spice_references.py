"""Netlists against ngspice: waveforms of nodes, see tests/data/spice/README.md."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import acausal as ac

DATA = Path(__file__).parents[1] / "data" / "spice"
REFERENCES = json.loads((DATA / "references.json").read_text())

#: Largest deviation relative to the swing of the voltage, by netlist, and where it comes from.
TOLERANCES = {
    "rc": 2e-6,  # linear
    "rlc": 5e-5,  # linear; ngspice's trapezoidal rule shifts the phase of the ringing
    "rectifier": 1e-4,  # junctions switch within microseconds
    "amplifier": 1e-4,  # linear around the operating point
    "pnp": 1e-4,  # saturation charge flows off
    "inverter": 1e-4,  # square law, corners of the characteristic
    "transformer": 1e-5,  # linear
    "subcircuit": 1e-6,  # linear, straight lines at the input
    "controlled": 1e-5,  # no dynamics but one capacitor
    "oscillator": 5e-4,  # a phase error at the unstable start grows
    "temperature": 1e-5,  # no dynamics; constants of physics differ in the sixth digit
}


@pytest.mark.parametrize("name", TOLERANCES)
def test_voltages_are_those_of_ngspice(name):
    reference = REFERENCES[name]
    result = ac.read_spice(DATA / f"{name}.cir").simulate(tolerance=1e-7)
    time = np.array(reference["time"])
    assert result.times[-1] == pytest.approx(time[-1], rel=0.1)
    for node in reference.keys() - {"time"}:
        expected = np.array(reference[node])
        computed = np.interp(time, result.times, result[f"v_{node}"].values)
        assert np.ptp(expected) > 0.01
        error = np.abs(computed - expected).max()
        assert error <= TOLERANCES[name] * np.ptp(expected), (node, error)


def test_all_references_are_compared():
    assert set(REFERENCES) == set(TOLERANCES) == {p.stem for p in DATA.glob("*.cir")}


@pytest.mark.parametrize("name", TOLERANCES)
def test_the_written_model_is_the_same_one(name):
    """The text of the model compiles to the same trajectory."""
    model = ac.read_spice(DATA / f"{name}.cir")
    text = model.to_acm()
    written = ac.compile_text(text).simulate(tolerance=1e-6)
    direct = model.simulate(tolerance=1e-6)
    for node in REFERENCES[name].keys() - {"time"}:
        assert np.array_equal(written[f"v_{node}"].values, direct[f"v_{node}"].values)


def test_text_is_readable():
    text = ac.read_spice(DATA / "subcircuit.cir").to_acm()
    # Both sections are one class, and values depend on parameters as in the netlist.
    assert len(re.findall(r"^model section", text, re.MULTILINE)) == 1
    assert "section X2(r = 2*r, scale = 0.5, cap = cap);" in text
    assert "electrical.spice.C_Capacitor C1(C = cap*scale);" in text
    assert "pair Xb(r = 5000, cap = cap);" in text
    assert "experiment(StopTime = 0.004, Interval = 2e-05)" in text


def test_parameters_of_the_netlist_can_be_changed():
    compiled = ac.read_spice(DATA / "subcircuit.cir").compile()
    slow = compiled.simulate(parameters={"cap": 1e-5}, stop_time=5e-4)["v_out"].values
    fast = compiled.simulate(stop_time=5e-4)["v_out"].values
    assert slow[-1] < 0.01 < 0.05 < fast[-1]
