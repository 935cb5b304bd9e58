"""The problems whose solve time is compared with the C program's."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.processes import EXAMPLES, MODELS


@dataclass(frozen=True)
class Problem:
    """A model, and the same problem of the C program.

    Attributes:
        label: Name in the table.
        file, model, parameters: The model.
        reference: Name of the problem in the C program.
        size: Its size there.
        compared: Variables that are compared at the end -> their place among the unknowns of
            the C program.
        effort: About how many seconds one solution takes.
    """

    label: str
    file: Path
    model: str
    reference: str
    compared: Mapping[str, int]
    effort: float
    size: int = 0
    parameters: Mapping[str, Any] = field(default_factory=dict)


def ladder(sections: int) -> Problem:
    """Return the diode ladder with some sections; about a hundred of them are compared."""
    numbers = sorted({1, sections, *range(1, sections, max(1, sections // 100))})
    names = ("l.i", "c.v", "d.i")
    return Problem(
        f"diode ladder, {sections}",
        EXAMPLES / "ladder.acm",
        "Ladder",
        "ladder",
        {f"section[{s}].{n}": 3 * (s - 1) + k for s in numbers for k, n in enumerate(names)},
        6e-5 * sections + 1e-3,
        sections,
        {"N": sections},
    )


RECTIFIER = Problem(
    "rectifier, 8 variables",
    MODELS / "rectifier.acm",
    "Rectifier",
    "rectifier",
    {"ca.v": 0, "cb.v": 1, "cf.v": 2, "d1.i": 3, "d2.i": 4, "d3.i": 5, "d4.i": 6, "rs.i": 7},
    3e-3,
)

PENDULUM = Problem(
    "double pendulum",
    MODELS / "double_pendulum.acm",
    "DoublePendulum",
    "pendulum",
    {"upper.phi": 0, "lower.phi": 1, "upper.w": 2, "lower.w": 3},
    2e-3,
)

PROBLEMS = (RECTIFIER, PENDULUM, *(ladder(10**k) for k in range(1, 6)))
