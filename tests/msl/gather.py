"""Copies MSL cases into the tests: description -> ``.acm``, reference -> ``tests/data/msl``.

Usage: ``python tests/msl/gather.py FOLDER CASE...`` where FOLDER holds the JSON descriptions and a
folder ``csv`` with the published reference trajectories.
"""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

from translate import translate

HERE = Path(__file__).parent
DATA = HERE.parent / "data" / "msl"


def gather(folder: Path, case: str) -> None:
    """Write ``CASE.acm``, ``CASE.json`` (times and tube) and, if there is one, ``CASE.csv.gz``."""
    description = json.loads((folder / f"{case}.json").read_text())
    circuits = json.loads((folder / "_subcircuits.json").read_text())
    name = description["model"].rsplit(".", 1)[-1]
    (HERE / f"{case}.acm").write_text(translate(description, circuits))
    reference = description["reference"]
    csv = folder / reference.get("full_csv", "missing")
    if csv.is_file():
        shutil.copyfile(csv, DATA / f"{case}.csv.gz")
    kept = {
        "model": name,
        "experiment": description["experiment"],
        "signals": reference["signals"],
        "times": reference.get("times", []),
        "tube": reference.get("tube", {}),
        "event_times": reference.get("event_times", []),
    }
    (DATA / f"{case}.json").write_text(json.dumps(kept, indent=1) + "\n")


if __name__ == "__main__":
    DATA.mkdir(parents=True, exist_ok=True)
    for one in sys.argv[2:]:
        gather(Path(sys.argv[1]), one)
