"""Time and memory from a model's text to a system ready to step."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from typing import Any

from benchmarks.problems import ladder
from benchmarks.processes import FailedError, Worker
from benchmarks.table import Column, Table

COLUMNS = (
    Column("model", "diode ladder, sections"),
    Column("cold", "caches empty", "s"),
    Column("warm", "caches filled", "s"),
    Column("ratio", "to 10 sections", "x"),
    Column("again", "again in the process", "s"),
    Column("ratio_again", "to 10 sections", "x"),
    Column("start", "consistent start", "s"),
    Column("peak", "peak memory", "MB"),
    Column("slowest", "slowest stages"),
)
#: Sections -> largest good values.
SIZES: dict[int, dict[str, float]] = {
    10: {},
    10**5: {"warm": 3.0, "again": 3.0, "ratio": 30.0, "ratio_again": 30.0},
    10**6: {"warm": 30.0, "peak": 8e9},
}


def measure(quick: bool, say: Callable[[str], None]) -> Table:
    """Return the table of compile times."""
    table = Table("compile", "Compile time, file read to ready to step", COLUMNS)
    table.notes.append(
        "Each figure is the minimum over fresh processes, with the imports that compiling needs; "
        '"again" is a second compilation in the same process, without them.'
    )
    first: dict[str, Any] | None = None
    for sections, bars in SIZES.items():
        if quick and sections > 10**5:
            continue
        say(f"{sections} sections")
        row: dict[str, Any] = {"model": f"{sections}", "bars": bars}
        try:
            row |= _figures(sections)
        except FailedError as failure:
            row["failed"] = str(failure)
        else:
            if first is None:
                first = row
            else:
                row["ratio"] = row["warm"] / first["warm"]
                row["ratio_again"] = row["again"] / first["again"] if "again" in row else None
        table.rows.append(row)
    return table


def _figures(sections: int) -> dict[str, Any]:
    problem = ladder(sections)
    request = {
        "action": "compile",
        "file": str(problem.file),
        "model": problem.model,
        "parameters": dict(problem.parameters),
    }
    big = sections >= 10**6
    row: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as cache:
        fresh = {"ACAUSAL_CACHE": cache}
        for turn in range(2 if big else 4):
            with Worker(fresh) as worker:
                answer = worker.ask(**request)
                total = answer["import"] + answer["compile"]
                if turn == 0:
                    row["cold"] = total
                    row["stages_cold"] = answer["stages"]
                elif total < row.get("warm", float("inf")):
                    row["warm"], row["stages"] = total, answer["stages"]
                    row["imports"] = answer["import"]
                row["peak"] = answer["peak"]
                if not big and turn > 0:
                    again = worker.ask(**request)["compile"]
                    row["again"] = min(again, row.get("again", float("inf")))
                if turn == 1 and not big:
                    start = worker.ask(
                        action="simulate", repeats=1, points=2, tolerance=1e-6, stop=1e-9
                    )
                    row["start"] = start["start_time"]
    slowest = sorted(row["stages"].items(), key=lambda item: -item[1])[:3]
    row["slowest"] = ", ".join(f"{name} {value:.2g} s" for name, value in slowest)
    return row
