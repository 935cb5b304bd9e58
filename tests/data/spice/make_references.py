"""Compute references.json with ngspice, which must be installed: ``python make_references.py``.

The netlists are run with narrow tolerances and small steps; every twentieth of the run is kept.
"""

from __future__ import annotations

import json
import re
import subprocess
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
#: Netlist -> nodes that are compared.
NODES = {
    "rc": ["out"],
    "rlc": ["out"],
    "rectifier": ["p", "a"],
    "amplifier": ["out", "c", "e"],
    "pnp": ["out"],
    "inverter": ["out"],
    "transformer": ["p", "s", "t"],
    "subcircuit": ["out", "end"],
    "controlled": ["b", "e", "f", "g", "h", "q", "w"],
    "oscillator": ["a", "b", "c"],
    "temperature": ["a", "b"],
}
POINTS = 40


def reference(name: str) -> dict[str, list[float]]:
    text = (HERE / f"{name}.cir").read_text()
    match = re.search(r"(?m)^\.tran (\S+) (\S+)(.*)$", text)
    assert match is not None
    uic = match[3]
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.txt"
        vectors = " ".join(f"v({n})" for n in NODES[name])
        control = f""".control
option reltol=1e-6 abstol=1e-14 vntol=1e-9
run
linearize
wrdata {out} {vectors}
.endc
.end"""
        # Steps a hundredth of the printed ones, as linearize draws straight lines.
        tran = f".tran {match[1]} {match[2]} 0 {{{number(match[1]) / 50}}} {uic}"
        text = re.sub(r"(?m)^\.tran.*$", tran, text).replace("\n.end\n", "\n" + control + "\n")
        netlist = HERE / f"_{name}.tmp"
        netlist.write_text(text)
        try:
            done = subprocess.run(["ngspice", "-b", str(netlist)], capture_output=True, text=True)
        finally:
            netlist.unlink()
        if not out.exists():
            raise SystemExit(f"{name}: {done.stdout}{done.stderr}")
        rows = [[float(x) for x in line.split()] for line in out.read_text().splitlines()]
    every = max(1, (len(rows) - 1) // POINTS)
    rows = rows[::every]
    result = {"time": [float(f"{r[0]:.9g}") for r in rows]}
    for k, node in enumerate(NODES[name]):
        result[node] = [float(f"{r[2 * k + 1]:.7g}") for r in rows]
    return result


def number(text: str) -> float:
    scales = {"m": 1e-3, "u": 1e-6, "n": 1e-9}
    return float(text[:-1]) * scales[text[-1]]


if __name__ == "__main__":
    found = {name: reference(name) for name in NODES}
    text = json.dumps(found, indent=None, separators=(",", ":")).replace('},"', '},\n"')
    (HERE / "references.json").write_text(text.replace("],", "],\n ") + "\n")
