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
    Column("warm", "new model", "s"),
    Column("ratio", "to 10", "x"),
    Column("again", "again in the process", "s"),
    Column("ratio_again", "to 10", "x"),
    Column("recall", "known model", "s"),
    Column("start", "consistent start", "s"),
    Column("peak", "memory", "MB"),
    Column("peak_recall", "memory, known", "MB"),
    Column("slowest", "slowest stages of a new model"),
)
#: Sections -> largest good values.
SIZES: dict[int, dict[str, float]] = {
    10: {},
    10**5: {"warm": 3.0, "again": 3.0, "ratio": 30.0, "ratio_again": 30.0, "recall": 3.0},
    10**6: {"warm": 30.0, "peak": 8e9, "recall": 30.0, "peak_recall": 8e9},
}


def measure(quick: bool, say: Callable[[str], None]) -> Table:
    """Return the table of compile times."""
    table = Table("compile", "Compile time, file read to ready to step", COLUMNS)
    table.notes.append(
        "Every compilation in a fresh process, imports included. New model: the caches know the "
        "library and the kernels from a ladder of another length, but not this model; known model: "
        'it was compiled before. "Again" is a second new model in the same process, without the '
        "imports. Minima over runs."
    )
    first: dict[str, Any] | None = None
    for sections, bars in SIZES.items():
        if quick and sections > 10**5:
            continue
        row: dict[str, Any] = {"model": f"{sections}", "bars": bars}
        say(f"{sections} sections")
        try:
            row |= _figures(sections)
        except FailedError as failure:
            row["failed"] = str(failure)
        else:
            if first is None:
                first = row
            else:
                row["ratio"] = row["warm"] / first["warm"]
                if row["again"] is not None:
                    row["ratio_again"] = row["again"] / first["again"]
        table.rows.append(row)
    return table


def _request(sections: int) -> dict[str, Any]:
    problem = ladder(sections)
    return {
        "action": "compile",
        "file": str(problem.file),
        "model": problem.model,
        "parameters": dict(problem.parameters),
    }


def _figures(sections: int) -> dict[str, Any]:
    turns = 1 if sections >= 10**6 else 3
    row: dict[str, Any] = {"cold": None, "warm": None, "again": None, "recall": None}

    def keep(key: str, value: float) -> bool:
        """Keep a minimum; return whether it is a new one."""
        better = row[key] is None or value < row[key]
        row[key] = value if better else row[key]
        return better

    for turn in range(turns):
        with tempfile.TemporaryDirectory() as cache:
            fresh = {"ACAUSAL_CACHE": cache}
            with Worker(fresh) as worker:
                # Another length fills the caches of library and kernels.
                answer = worker.ask(**_request(13))
                if sections == 10:
                    keep("cold", answer["import"] + answer["compile"])
            with Worker(fresh) as worker:
                answer = worker.ask(**_request(sections))
                if keep("warm", answer["import"] + answer["compile"]):
                    row["stages"], row["imports"] = answer["stages"], answer["import"]
                row["peak"] = answer["peak"]
                if sections < 10**6:
                    keep("again", worker.ask(**_request(sections + 1))["compile"])
            with Worker(fresh) as worker:
                answer = worker.ask(**_request(sections))
                keep("recall", answer["import"] + answer["compile"])
                row["peak_recall"] = answer["peak"]
                if turn == 0:
                    tiny = {"repeats": 1, "points": 2, "tolerance": 1e-6, "stop": 1e-9}
                    row["start"] = worker.ask(action="simulate", **tiny)["start_time"]
        if 10 < sections < 10**6 and turn == 0:
            with tempfile.TemporaryDirectory() as cache, Worker({"ACAUSAL_CACHE": cache}) as worker:
                answer = worker.ask(**_request(sections))
                row["cold"] = answer["import"] + answer["compile"]
    slowest = sorted(row["stages"].items(), key=lambda item: -item[1])[:4]
    row["slowest"] = ", ".join(f"{name} {value:.2g} s" for name, value in slowest)
    return row
