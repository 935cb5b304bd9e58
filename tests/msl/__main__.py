"""``python -m tests.msl [CASE...] [--json FILE]``: how the cases compare with their references.

The distance is the share of the tube that the worst signal uses: 0 on the reference, 1 at the
border, more outside. Ends with 1 if a case fails that has no known reason.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from tests.msl.cases import REASONS, SIGNALS, Comparison, compare


def lines(found: Sequence[Comparison]) -> list[str]:
    """Return the table, then those that miss with their reasons."""
    width = max(len(c.case) for c in found)
    table = [f"{'case':<{width}}  signals  distance  {'worst signal':<34}  time"]
    for c in found:
        signal, distance = c.worst
        count = len(c.signals) or len(SIGNALS.get(c.case, ()))
        shown = f"{distance:>9.3f} " if c.signals else "        - "
        mark = "" if c.inside else "  !"
        table.append(
            f"{c.case:<{width}}  {count:>7} {shown} {signal:<34}  {c.seconds:5.2f} s{mark}"
        )
    inside = sum(c.inside for c in found)
    signals = sum(len(c.signals) for c in found)
    table += ["", f"{inside} of {len(found)} cases inside of the tube, {signals} signals"]
    table += [
        f"  {c.case}: {c.reason or f'{c.worst[0]} leaves the tube'}" for c in found if not c.inside
    ]
    return table


def main(arguments: list[str] | None = None) -> int:
    """Run the cases, print the table."""
    parser = argparse.ArgumentParser(prog="python -m tests.msl", description=__doc__)
    parser.add_argument("cases", nargs="*", metavar="CASE", help="part of a name; all if none")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures to a file")
    options = parser.parse_args(arguments)
    chosen = [c for c in SIGNALS if not options.cases or any(p in c for p in options.cases)]
    if not chosen:
        parser.error("there is no such case")
    found = []
    for case in chosen:
        if sys.stderr.isatty():
            print(f"\r\033[K... {case}", end="", file=sys.stderr, flush=True)
        found.append(compare(case))
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr)
    print("\n".join(lines(found)))
    if options.json is not None:
        data = [{**asdict(c), "worst": c.worst, "inside": c.inside} for c in found]
        options.json.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    return int(any(not c.inside and c.case not in REASONS for c in found))


if __name__ == "__main__":
    sys.exit(main())
