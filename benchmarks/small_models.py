"""Process start to written CSV file for small models, and the import of the package."""

from __future__ import annotations

import csv
import importlib.util
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.processes import EXAMPLES, MODELS, FailedError, environment, run
from benchmarks.table import Column, Table

POINTS = 501
BAR, IMPORT_BAR = 0.35, 0.15

COLUMNS = (
    Column("model", "model"),
    Column("cold", "caches empty", "s"),
    Column("time", "acausal", "s", BAR),
    Column("median", "median", "s"),
    Column("cpu", "processor", "s"),
    Column("peak", "memory", "MB"),
    Column("other", "rumoca", "s"),
    Column("other_median", "median", "s"),
    Column("ratio", "ratio", "x"),
    Column("difference", "difference", "e"),
)


@dataclass(frozen=True)
class SmallModel:
    """The same model for both tools.

    Attributes:
        label: Name in the table.
        ours, theirs: Files.
        model: Name of the model in both.
        stop: Stop time, seconds.
        compared: Variable whose trajectories are compared.
    """

    label: str
    ours: Path
    theirs: Path
    model: str
    stop: float
    compared: str


MODELS_COMPARED = (
    SmallModel("RLC", EXAMPLES / "rlc.acm", MODELS / "rlc.mo", "RLC", 0.1, "c.v"),
    SmallModel(
        "Cartesian pendulum",
        EXAMPLES / "cartesian_pendulum.acm",
        MODELS / "cartesian_pendulum.mo",
        "CartesianPendulum",
        10.0,
        "x",
    ),
)


def measure(quick: bool, say: Callable[[str], None]) -> Table:
    """Return the table of whole-process times."""
    table = Table("small", "acausal simulate, process start to written CSV", COLUMNS)
    table.notes.append(
        f"Minima (and medians) over runs in turn, {POINTS} points, tolerance 1e-6, caches filled; "
        "rumoca compiles and simulates a Modelica file of the same components through its Python "
        "interface. Difference: of one trajectory between both tools, relative to its largest "
        "value."
    )
    if importlib.util.find_spec("rumoca") is None:
        table.notes.append("rumoca is not installed (pip install rumoca).")
    turns = 5 if quick else 15
    for model in MODELS_COMPARED:
        say(model.label)
        try:
            table.rows.append(_row(model, turns))
        except FailedError as failure:
            table.rows.append({"model": model.label, "failed": str(failure)})
    say("import acausal")
    table.rows.append(_import_row(turns))
    return table


def _row(model: SmallModel, turns: int) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ours_csv, theirs_csv = folder / "ours.csv", folder / "theirs.csv"
        cache = {"ACAUSAL_CACHE": str(folder / "cache")}
        ours = [
            *_acausal(), "simulate", str(model.ours), model.model, "--stop", str(model.stop),
            "--points", str(POINTS), "--tolerance", "1e-6", "--output", str(ours_csv),
        ]  # fmt: skip
        theirs = [
            sys.executable, str(Path(__file__).parent / "rumoca_run.py"), str(model.theirs),
            model.model, str(model.stop), str(POINTS), str(theirs_csv),
        ]  # fmt: skip
        both = importlib.util.find_spec("rumoca") is not None
        cold = run(ours, cache)
        run(ours, cache)
        a, b = [], []
        for _ in range(turns):
            a.append(run(ours, cache))
            if both:
                b.append(run(theirs))
        best = min(a, key=lambda r: r.wall)
        row: dict[str, Any] = {
            "model": model.label,
            "cold": cold.wall,
            "time": best.wall,
            "median": statistics.median(r.wall for r in a),
            "cpu": min(r.cpu for r in a),
            "peak": max(r.peak for r in a),
        }
        if both:
            row["other"] = min(r.wall for r in b)
            row["other_median"] = statistics.median(r.wall for r in b)
            row["ratio"] = row["time"] / row["other"]
            row["difference"] = _difference(ours_csv, theirs_csv, model.compared)
    return row


def _acausal() -> list[str]:
    """Return the command that users type, or the module if it is not installed."""
    script = Path(sys.executable).parent / "acausal"
    return [str(script)] if script.exists() else [sys.executable, "-m", "acausal"]


def _column(file: Path, name: str) -> tuple[list[float], list[float]]:
    with file.open(newline="", encoding="utf-8") as stream:
        rows = [row for row in csv.reader(stream) if row and not row[0].startswith("#")]
    # A heading may carry the unit: "c.v [V]".
    heading = [cell.split(" ")[0].split("[V")[0].strip() for cell in rows[0]]
    place = heading.index(name)
    values = []
    for row in rows[1:]:
        try:
            values.append((float(row[0]), float(row[place])))
        except ValueError:
            continue
    times, numbers = zip(*values, strict=True)
    return list(times), list(numbers)


def _difference(ours: Path, theirs: Path, name: str) -> float:
    import numpy as np

    t, x = _column(ours, name)
    other_t, other_x = _column(theirs, name)
    other = np.asarray(other_x)
    return float(np.abs(np.interp(other_t, t, x) - other).max() / np.abs(other).max())


def _import_row(turns: int) -> dict[str, Any]:
    """Measure the import inside the interpreter, without its own start."""
    text = "import time; a = time.perf_counter(); import acausal; print(time.perf_counter() - a)"
    times = [
        float(
            subprocess.run(
                [sys.executable, "-c", text],
                capture_output=True,
                text=True,
                check=True,
                env=environment(),
            ).stdout
        )
        for _ in range(turns)
    ]
    return {
        "model": "import acausal",
        "time": min(times),
        "median": statistics.median(times),
        "bars": {"time": IMPORT_BAR},
    }
