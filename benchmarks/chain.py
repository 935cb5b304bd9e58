"""A chain of a hundred pendulums, from text to ten seconds of motion."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from benchmarks.processes import EXAMPLES, FailedError, Worker
from benchmarks.table import Column, Table

STOP, TOLERANCE, POINTS = 10.0, 1e-6, 501

COLUMNS = (
    Column("links", "links", "n"),
    Column("total", "text to result", "s"),
    Column("compile", "compile", "s"),
    Column("start", "start", "s"),
    Column("solve", "solve", "s"),
    Column("steps", "steps", "n"),
    Column("changes", "changes of states", "n"),
    Column("position", "rod length", "e"),
    Column("velocity", "velocity along rod", "e"),
    Column("energy", "energy drift", "e"),
    Column("relative", "relative", "e"),
    Column("peak", "memory", "MB"),
)


def measure(quick: bool, say: Callable[[str], None]) -> Table:
    """Return the table of pendulum chains."""
    table = Table("chain", "Pendulum chain from text to 10 s of motion", COLUMNS)
    table.notes.append(
        f"examples/pendulum_chain.acm, held level and let go, tolerance {TOLERANCE:g}, {POINTS} "
        "points, caches filled, one run. Errors are the largest over all points and links, in m, "
        "m/s and J; relative: energy drift to the largest kinetic energy."
    )
    for links in (2, 10) if quick else (2, 10, 100):
        say(f"{links} links")
        try:
            table.rows.append(_row(links))
        except FailedError as failure:
            table.rows.append({"links": links, "failed": str(failure)})
    return table


def _row(links: int) -> dict[str, Any]:
    request = {
        "action": "compile",
        "file": str(EXAMPLES / "pendulum_chain.acm"),
        "model": "PendulumChain",
        "parameters": {"n": links},
    }
    with Worker() as worker:  # fills the caches
        worker.ask(**request)
    with Worker() as worker:
        compiled = worker.ask(**request)
        run = worker.ask(
            action="simulate", repeats=1, points=POINTS, tolerance=TOLERANCE, stop=STOP
        )
        errors = worker.ask(action="chain_errors", links=links, length=1.0)
    compile_time = compiled["import"] + compiled["compile"]
    return {
        "links": links,
        "total": compile_time + run["wall"],
        "compile": compile_time,
        "start": run.get("start_time"),
        "solve": run["solve_time"],
        "steps": run["steps"],
        "changes": run.get("state_changes"),
        "position": errors["position"],
        "velocity": errors["velocity"],
        "energy": errors["energy"],
        "relative": errors["energy"] / errors["kinetic"],
        "peak": run["peak"],
        "stages": compiled["stages"],
        "statistics": run,
    }
