"""Time from the first line of Python that makes a model to the compiled model."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from typing import Any

from benchmarks.table import Column, Table

COLUMNS = (
    Column("model", "circuit in Python, components"),
    Column("build", "made", "s"),
    Column("compile", "compiled", "s"),
    Column("total", "first line to compiled", "s"),
    Column("text", "the same from a text", "s"),
    Column("peak", "memory", "MB"),
    Column("slowest", "slowest stages"),
)

#: Each in a process of its own, imports included; prints what it measured.
_SEPARATE = """
import json, resource, sys, time
begun = time.perf_counter()
import acausal as ac
from acausal.library import electrical as el
count = int(sys.argv[1])
m = ac.Model("ladder")
m.source = el.ConstantVoltage(V=1.0)
m.ground = el.Ground()
m.connect(m.source.n, m.ground.p)
before = m.source.p
for k in range(count // 2):
    r = m.add(f"r{k}", el.Resistor(R=1.0 + 1e-3 * k))
    c = m.add(f"c{k}", el.Capacitor(C=1e-6, v=dict(start=0, fixed=True)))
    m.connect(before, r.p)
    m.connect(r.n, c.p)
    m.connect(c.n, m.ground.p)
    before = r.n
"""
_ARRAYS = """
import json, resource, sys, time
begun = time.perf_counter()
import numpy as np
import acausal as ac
from acausal.library import electrical as el
count = int(sys.argv[1])
n = count // 2
m = ac.Model("ladder")
m.source = el.ConstantVoltage(V=1.0)
m.ground = el.Ground()
m.connect(m.source.n, m.ground.p)
m.r = el.Resistor(R=np.linspace(1.0, 2.0, n), shape=n)
m.c = el.Capacitor(C=1e-6, v=dict(start=0, fixed=True), shape=n)
m.base = el.Ground(shape=n)
m.connect(m.source.p, m.r[0].p)
m.connect(m.r[:-1].n, m.r[1:].p)
m.connect(m.r.n, m.c.p)
m.connect(m.c.n, m.base.p)
"""
_END = """
made = time.perf_counter()
compiled = m.compile()
done = time.perf_counter()
answer = {
    "build": made - begun, "compile": done - made, "total": done - begun,
    "stages": compiled.timings,
    "peak": 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
}
if "text" in sys.argv:
    text = m.to_acm()
    begun = time.perf_counter()
    ac.compile_text(text)
    answer["text"] = time.perf_counter() - begun
print(json.dumps(answer))
"""
#: Title, program, components, largest good total.
CASES: tuple[tuple[str, str, int, float | None], ...] = (
    ("separate, {}", _SEPARATE, 1000, None),
    ("separate, {}", _SEPARATE, 100_000, 10.0),
    ("arrays, {}", _ARRAYS, 1000, None),
    ("arrays, {}", _ARRAYS, 100_000, 1.0),
)


def measure(quick: bool, say: Callable[[str], None]) -> Table:
    """Return the table of models made in Python."""
    table = Table("compose", "Models made in Python", COLUMNS)
    table.notes.append(
        "Every model in a fresh process, imports included; kernels are cached from a small model. "
        "A ladder of resistors and capacitors, one and a half connections for each component. "
        "Minima over runs."
    )
    with tempfile.TemporaryDirectory() as cache:
        for title, program, count, bar in CASES:
            row: dict[str, Any] = {"model": title.format(count)}
            if bar is not None:
                row["bars"] = {"total": bar}
            say(row["model"])
            _run(program, 100, cache)
            best: dict[str, Any] | None = None
            for _ in range(1 if quick else 3):
                answer = _run(program, count, cache)
                if best is None or answer["total"] < best["total"]:
                    best = answer
            assert best is not None
            row |= best
            if count <= 1000:
                row["text"] = _run(program, count, cache, "text")["text"]
            slowest = sorted(best["stages"].items(), key=lambda item: -item[1])[:3]
            row["slowest"] = ", ".join(f"{name} {value:.2g} s" for name, value in slowest)
            table.rows.append(row)
    return table


def _run(program: str, count: int, cache: str, *more: str) -> dict[str, Any]:
    done = subprocess.run(
        [sys.executable, "-c", program + _END, str(count), *more],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "ACAUSAL_CACHE": cache},
    )
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer
