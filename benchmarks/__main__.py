"""``python -m benchmarks [--only NAME] [--quick] [--json FILE]``."""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks import (
    chain,
    compile_time,
    compose,
    events,
    library,
    small_models,
    solve_time,
    sweep,
)
from benchmarks.table import Table

BENCHMARKS: dict[str, Callable[[bool, Callable[[str], None]], Table | list[Table]]] = {
    "solve": solve_time.measure,
    "compile": compile_time.measure,
    "compose": compose.measure,
    "small": small_models.measure,
    "chain": chain.measure,
    "events": events.measure,
    "library": library.measure,
    "sweep": sweep.measure,
}


def machine() -> dict[str, Any]:
    """Return what kind of machine this is."""
    model = ""
    information = Path("/proc/cpuinfo")
    if information.exists():
        lines = information.read_text(encoding="utf-8", errors="replace").splitlines()
        model = next((x.split(":")[1].strip() for x in lines if x.startswith("model name")), "")
    return {
        "processor": model or platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
    }


def main(arguments: list[str] | None = None) -> int:
    """Run benchmarks, print their tables; return 1 if a row misses its bar."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--only", action="append", choices=sorted(BENCHMARKS), metavar="NAME",
                        help="one of " + ", ".join(BENCHMARKS) + "; may be repeated")  # fmt: skip
    parser.add_argument("--quick", action="store_true", help="small sizes and few repeats")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures to a file")
    options = parser.parse_args(arguments)
    where = machine()
    print(
        f"{where['processor']}, {where['cores']} cores, {where['system']}, "
        f"Python {where['python']}\n"
    )

    def say(text: str) -> None:
        if sys.stderr.isatty():
            print(f"\r\033[K... {text}", end="", file=sys.stderr, flush=True)

    tables: list[Table] = []
    for name in options.only or BENCHMARKS:
        made = BENCHMARKS[name](options.quick, say)
        if sys.stderr.isatty():
            print("\r\033[K", end="", file=sys.stderr)
        for table in made if isinstance(made, list) else [made]:
            print("\n".join(table.lines()) + "\n", flush=True)
            tables.append(table)
    misses = [line for table in tables for line in table.misses()]
    print("\n".join(("Missed:", *misses)) if misses else "Every bar is reached.")
    if options.json is not None:
        data = {"machine": where, "quick": options.quick, "tables": [t.data() for t in tables]}
        options.json.write_text(json.dumps(data, indent=1, default=float) + "\n", encoding="utf-8")
    return 1 if misses else 0


if __name__ == "__main__":
    sys.exit(main())
