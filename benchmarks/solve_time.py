"""Time inside the integrator, beside a C program written by hand for the same problem."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.problems import PROBLEMS, Problem
from benchmarks.processes import FailedError, Worker
from benchmarks.reference_program import ReferenceProgram, build
from benchmarks.table import Column, Table

Array = NDArray[np.float64]

RELATIVE, ABSOLUTE = 1e-6, 1e-9
#: Output points after the initial one.
POINTS = 200
#: Seconds that one side of a problem may take, all repeats together.
BUDGET = 3.0
#: Up to this effort there is a solution with small tolerance to compare with, seconds.
ACCURATE = 0.1
#: Tolerances around the main one for small problems, as factors.
AROUND = (0.7, 0.85, 1.2, 1.4)

COLUMNS = (
    Column("problem", "problem"),
    Column("time", "acausal", "s"),
    Column("plain", "C", "s"),
    Column("ratio_plain", "ratio", "x"),
    Column("suppressed", "C, same test", "s"),
    Column("ratio", "ratio", "x", 1.3),
    Column("around", "at 5 tolerances", "x"),
    Column("per_step", "ratio per step", "x"),
    Column("steps", "steps", "n"),
    Column("steps_plain", "C", "n"),
    Column("steps_suppressed", "C, same test", "n"),
    Column("difference", "difference", "e"),
    Column("error", "error", "e"),
    Column("error_plain", "error C, same test", "e"),
)


def measure(quick: bool, say: Callable[[str], None]) -> Table:
    """Return the table of solve times."""
    table = Table("solve", "Solve time against a C program", COLUMNS)
    with tempfile.TemporaryDirectory() as folder:
        try:
            program = build(Path(folder))
        except FailedError as failure:
            table.notes.append(f"Skipped: {failure}.")
            return table
        table.notes += [
            f"{program.description}. Tolerance {RELATIVE:g}, {POINTS} output points, minima over "
            "runs in turn. The C program runs with IDA's plain error test, and with algebraic "
            "unknowns left out of it as acausal does (\"same test\").",
            "Processor seconds of the integration alone, stored points included, set-up not. "
            "Difference: end values of acausal and of C with the same test, relative to the "
            "largest value of their kind. Error: the same against C at tolerance 1e-10.",
            "The number of steps jumps by a quarter when anything changes in the last digit. At 5 "
            "tolerances: geometric mean of the ratio to C with the same test at 0.7 to 1.4 times "
            "the tolerance.",
        ]  # fmt: skip
        for problem in PROBLEMS:
            if quick and problem.effort > 1.0:
                continue
            say(problem.label)
            try:
                table.rows.append(_row(problem, program, Path(folder), quick))
            except FailedError as failure:
                table.rows.append({"problem": problem.label, "failed": str(failure)})
    return table


def _row(problem: Problem, program: ReferenceProgram, folder: Path, quick: bool) -> dict[str, Any]:
    turns = 3 if quick or problem.effort > 1.0 else 7
    repeats = max(1, min(20, round(BUDGET / turns / problem.effort / 3)))
    tolerance = (RELATIVE, ABSOLUTE)
    ends = {kind: folder / f"{kind}.bin" for kind in ("plain", "suppressed", "accurate")}
    ours: list[dict[str, Any]] = []
    theirs: dict[str, list[dict[str, Any]]] = {"plain": [], "suppressed": []}
    with Worker() as worker:
        worker.ask(
            action="compile",
            file=str(problem.file),
            model=problem.model,
            parameters=dict(problem.parameters),
        )
        for _ in range(turns):
            for kind, figures in theirs.items():
                figures.append(
                    program.solve(
                        problem.reference, problem.size, repeats, POINTS, tolerance,
                        kind == "suppressed", ends[kind],
                    )
                )  # fmt: skip
            ours.append(
                worker.ask(
                    action="simulate",
                    repeats=repeats,
                    points=POINTS + 1,
                    tolerance=RELATIVE,
                    stop=None,
                )
            )
        final = worker.ask(action="final", paths=list(problem.compared))["values"]
        ratios = []
        for factor in AROUND if problem.effort <= ACCURATE else ():
            reference = program.solve(
                problem.reference, problem.size, repeats, POINTS,
                (factor * RELATIVE, factor * ABSOLUTE), True,
            )  # fmt: skip
            other = worker.ask(
                action="simulate",
                repeats=repeats,
                points=POINTS + 1,
                tolerance=factor * RELATIVE,
                stop=None,
            )
            ratios.append(other["solve_cpu_time"] / reference["cpu"])
    mine = min(ours, key=lambda f: f["solve_cpu_time"])
    plain = min(theirs["plain"], key=lambda f: f["cpu"])
    suppressed = min(theirs["suppressed"], key=lambda f: f["cpu"])
    row = {
        "problem": problem.label,
        "time": mine["solve_cpu_time"],
        "plain": plain["cpu"],
        "suppressed": suppressed["cpu"],
        "ratio_plain": mine["solve_cpu_time"] / plain["cpu"],
        "ratio": mine["solve_cpu_time"] / suppressed["cpu"],
        "per_step": (mine["solve_cpu_time"] / mine["steps"])
        / (suppressed["cpu"] / suppressed["steps"]),
        "steps": mine["steps"],
        "steps_plain": plain["steps"],
        "steps_suppressed": suppressed["steps"],
        "around": None,
        "difference": difference(problem, final, np.fromfile(ends["suppressed"])),
        "ours": mine,
        "reference": {"plain": plain, "suppressed": suppressed},
    }
    if ratios:
        row["around"] = float(np.exp(np.mean(np.log([row["ratio"], *ratios]))))
    if problem.effort <= ACCURATE:
        program.solve(
            problem.reference, problem.size, 1, POINTS, (1e-10, 1e-13), False, ends["accurate"]
        )
        accurate, values = np.fromfile(ends["accurate"]), np.fromfile(ends["suppressed"])
        row["error"] = difference(problem, final, accurate)
        row["error_plain"] = difference(
            problem, [values[k] for k in problem.compared.values()], accurate
        )
    return row


def difference(problem: Problem, values: list[float], reference: Array) -> float:
    """Return the largest difference, relative to the largest value of each kind."""
    kinds: dict[str, list[tuple[float, float]]] = {}
    for (path, place), value in zip(problem.compared.items(), values, strict=True):
        kinds.setdefault(path.rsplit(".", 1)[1], []).append((value, reference[place]))
    return max(
        max(abs(a - b) for a, b in pairs) / max(abs(b) for _, b in pairs)
        for pairs in kinds.values()
    )
