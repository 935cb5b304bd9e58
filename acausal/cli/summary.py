"""A short table of a result, for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from acausal.results.files import computed
from acausal.results.plot import default_paths
from acausal.results.result import Result

#: Longest table.
MOST_ROWS = 40


def summary(result: Result, patterns: Sequence[str] = ()) -> str:
    """Return a table: first, last, smallest and largest value of the matching variables.

    Args:
        result: The simulation's result.
        patterns: Paths, patterns or expressions; the states if there are none.

    Raises:
        AcausalError: ``N901`` if a pattern matches nothing.
    """
    name = f"{result.model_name} - {result.description}".removesuffix(" - ")
    count = len(result.times)
    if not count:
        return f"{name}: no points"
    head = f"{name}: {result.times[0]:g} s to {result.times[-1]:g} s, {count} points"
    result = computed(result, patterns)
    paths = result.find() if patterns else default_paths(result)
    rows: list[tuple[str, ...]] = [("variable", "unit", "first", "last", "smallest", "largest")]
    for path in paths[:MOST_ROWS]:
        trajectory = result.trajectory(path)
        x = trajectory.values
        # Adding 0 turns -0 into 0.
        numbers = (x[0], x[-1], x.min(), x.max())
        rows.append((path, trajectory.unit, *(f"{float(v) + 0.0:.6g}" for v in numbers)))
    widths = [max(len(row[k]) for row in rows) for k in range(6)]
    lines = [
        "  ".join(
            cell.ljust(width) if k < 2 else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]
    if len(paths) > MOST_ROWS:
        lines.append(f"... and {len(paths) - MOST_ROWS} more")
    if not patterns:
        lines.append("(the states; others with --variables, a file with --output, --plot)")
    return "\n".join([head, *lines])
