"""Sweeps of a small circuit: what a point costs beside the solver, and what a second core saves."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.table import Column, Table

MODEL = Path(__file__).parents[1] / "examples" / "rlc.acm"
POINTS = 1000

COLUMNS = (
    Column("how", "1000 points of a series resonant circuit"),
    Column("time", "time", "s"),
    Column("solver", "in the solver", "s"),
    Column("beside", "beside the solver, per point and core", "s"),
    Column("share", "time over that of one core", "x"),
)


def measure(quick: bool, say: Callable[[str], None]) -> Table:
    """Return the table of sweeps."""
    import acausal as ac

    table = Table("sweep", "Sweeps", COLUMNS)
    table.notes.append(
        "A compiled model, other values of one resistance, 501 points and all variables kept of "
        "every run. Minima over runs; the speed-up is that of the same points on one core in the "
        "same run."
    )
    compiled = ac.compile_file(MODEL)
    values = {"r.R": np.linspace(50.0, 200.0, POINTS)}
    single: float | None = None
    for workers in (1, 2):
        say(f"{workers} process(es)")
        ac.sweep(compiled, {"r.R": values["r.R"][:20]}, workers=workers)
        best: dict[str, Any] | None = None
        for _ in range(1 if quick else 3):
            begun = time.perf_counter()
            study = ac.sweep(compiled, values, workers=workers)
            spent = time.perf_counter() - begun
            if best is None or spent < best["time"]:
                solver = sum(
                    float(o.about["statistics"]["solve_time"]) for o in study.outcomes if o
                )
                best = {"time": spent, "solver": solver}
                best["beside"] = (spent * workers - solver) / POINTS
        assert best is not None
        row: dict[str, Any] = {"how": f"{workers} process{'es' * (workers > 1)}", **best}
        if single is None:
            single = best["time"]
            row["bars"] = {"beside": 3e-3}
        else:
            row["share"] = best["time"] / single
            row["bars"] = {"share": 1 / 1.8}
        table.rows.append(row)
    return table
