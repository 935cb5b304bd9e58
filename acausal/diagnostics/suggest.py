"""Nearest names to a misspelt one."""

from __future__ import annotations

from collections.abc import Iterable


def nearest(name: str, candidates: Iterable[str], limit: int = 3) -> list[str]:
    """Return the candidates most like ``name``, best first.

    Ties go by the order of the candidates, so the answer is always the same. A difference in
    case alone counts as almost none; one dropped, added, wrong or swapped letter as one.

    Args:
        name: What was written.
        candidates: What exists; repetitions are ignored.
        limit: Largest number of names returned.
    """
    allowed = max(1.0, len(name) / 3) if len(name) > 1 else 0.5
    scored: list[tuple[float, int, str]] = []
    for position, candidate in enumerate(dict.fromkeys(candidates)):
        if candidate == name or abs(len(candidate) - len(name)) > allowed:
            continue
        distance = _distance(name, candidate, allowed)
        if distance <= allowed:
            scored.append((distance, position, candidate))
    return [candidate for _, _, candidate in sorted(scored)[:limit]]


def _distance(a: str, b: str, limit: float) -> float:
    """Optimal string alignment distance (Damerau 1964, Wagner and Fischer 1974).

    Cost: ``len(a) * len(b)``; given up as soon as every alignment costs more than ``limit``.
    """
    before: list[float] = []
    row: list[float] = [float(j) for j in range(len(b) + 1)]
    for i, x in enumerate(a, 1):
        current = [float(i)]
        for j, y in enumerate(b, 1):
            change = 0.0 if x == y else 0.25 if x.lower() == y.lower() else 1.0
            best = min(row[j] + 1.0, current[j - 1] + 1.0, row[j - 1] + change)
            if i > 1 and j > 1 and x == b[j - 2] and a[i - 2] == y:
                best = min(best, before[j - 2] + 1.0)
            current.append(best)
        if min(current) > limit and min(row) > limit:
            return limit + 1.0
        before, row = row, current
    return row[-1]
