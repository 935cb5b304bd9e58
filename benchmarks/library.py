"""Time to read the component library, and to compile a model that uses many of its classes."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from typing import Any

from acausal.modeling.library import FolderPackage, standard_library
from benchmarks.processes import MODELS, FailedError, Worker
from benchmarks.table import Column, Table

PACKAGES = (
    Column("package", "package"),
    Column("files", "files", "n"),
    Column("classes", "classes", "n"),
    Column("cold", "parsed", "s"),
    Column("cached", "from cache", "s"),
)
FIFTY = (
    Column("model", "model"),
    Column("empty", "caches empty", "s"),
    Column("cold", "kernels not cached", "s"),
    Column("cached", "kernels cached", "s"),
    Column("recall", "known model", "s"),
    Column("slowest", "slowest stages, kernels cached"),
)
#: Largest good values, seconds.
ALL_COLD, ONE_CACHED, FIFTY_COLD, FIFTY_CACHED = 15.0, 0.1, 2.0, 0.5


def measure(quick: bool, say: Callable[[str], None]) -> list[Table]:
    """Return the tables of packages and of the model with fifty classes."""
    return [_packages(quick, say), _fifty(quick, say)]


def package_names() -> list[str]:
    """Return the names of all packages that have files."""
    root = standard_library()
    names = [n for n in root.names() if n not in root.packages]
    pending = list(root.packages.values())
    while pending:
        package: FolderPackage = pending.pop(0)
        pending += package.packages.values()
        if package.files:
            names.append(package.full_name)
    return sorted(names)


def _packages(quick: bool, say: Callable[[str], None]) -> Table:
    table = Table("library", "Reading the component library", PACKAGES)
    table.notes.append(
        "Every package in a fresh process without the imports of Python modules: parsed with an "
        "empty cache, then read from the cache (least of several runs)."
    )
    total: dict[str, Any] = {"package": "all", "files": 0, "classes": 0, "cold": 0.0, "cached": 0.0}
    total["bars"] = {"cold": ALL_COLD}
    with tempfile.TemporaryDirectory() as cache:
        fresh = {"ACAUSAL_CACHE": cache}
        for name in package_names():
            say(name)
            row: dict[str, Any] = {"package": name, "bars": {"cached": ONE_CACHED}}
            try:
                row |= _package(name, fresh, 1 if quick else 3)
            except FailedError as failure:
                row["failed"] = str(failure)
            else:
                for key in ("files", "classes", "cold", "cached"):
                    total[key] += row[key]
            table.rows.append(row)
    table.rows.append(total)
    return table


def _package(name: str, fresh: dict[str, str], turns: int) -> dict[str, Any]:
    with Worker(fresh) as worker:
        first = worker.ask(action="parse", package=name)
    row = {"files": first["files"], "classes": first["classes"], "cold": first["parse"]}
    for _ in range(turns):
        with Worker(fresh) as worker:
            again = worker.ask(action="parse", package=name)["parse"]
        row["cached"] = min(again, row.get("cached", again))
    return row


def _fifty(quick: bool, say: Callable[[str], None]) -> Table:
    table = Table("fifty", "A model with components of fifty classes, read to ready to step", FIFTY)
    table.notes.append(
        "In fresh processes, imports of Python modules included. Kernels not cached: the library's "
        "trees are; kernels cached: the model is new, as after a change of its text."
    )
    row: dict[str, Any] = {
        "model": "FiftyClasses",
        "bars": {"cold": FIFTY_COLD, "cached": FIFTY_CACHED},
    }
    say("model with fifty classes")
    try:
        for _ in range(1 if quick else 3):
            for key, value in _one_turn().items():
                if key != "slowest" and value >= row.get(key, value + 1):
                    continue
                row[key] = value
    except FailedError as failure:
        row["failed"] = str(failure)
    table.rows.append(row)
    return table


def _one_turn() -> dict[str, Any]:
    """Compile with caches empty, with trees only, with trees and kernels, and once more."""
    text = (MODELS / "fifty_classes.acm").read_text(encoding="utf-8")
    found: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as trees:
        with Worker({"ACAUSAL_CACHE": trees}) as worker:
            for name in package_names():
                worker.ask(action="parse", package=name)
        for key, cache in (("empty", f"{folder}/cache"), ("cold", trees)):
            found[key], _ = _compile(text, f"{folder}/{key}.acm", cache)
        found["cached"], stages = _compile(text + "// changed\n", f"{folder}/new.acm", trees)
        found["recall"], _ = _compile(text + "// changed\n", f"{folder}/new.acm", trees)
    slowest = sorted(stages.items(), key=lambda item: -item[1])[:4]
    found["slowest"] = ", ".join(f"{name} {value:.2g} s" for name, value in slowest)
    return found


def _compile(text: str, path: str, cache: str) -> tuple[float, dict[str, float]]:
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    with Worker({"ACAUSAL_CACHE": cache}) as worker:
        answer = worker.ask(action="compile", file=path, model="FiftyClasses", parameters={})
    return answer["import"] + answer["compile"], answer["stages"]
