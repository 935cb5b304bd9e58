"""What a caller asks of a simulation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike

from acausal.results.snapshot import Snapshot

#: Points of a run that says nothing about its output.
DEFAULT_POINTS = 501


@dataclass(frozen=True)
class Request:
    """One run.

    Attributes:
        start_time, stop_time: Seconds; None leaves it to the model's experiment annotation.
        tolerance: Relative tolerance; None likewise.
        solver: Name of the integrator.
        points: Number of equidistant output points.
        interval: Distance of output points, seconds; wins over ``points``.
        variables: Patterns of the variables to keep; None keeps everything.
        progress: Called with the time reached and the stop time.
        max_step: Largest step, seconds.
        kept: Ids of the variables to keep; wins over ``variables``.
        continue_from: Where an earlier run stood.
        dense: Whether the integrator's polynomials are kept.
        output: File that is written while the run goes on.
        keep: Whether the result stays in memory, too.
    """

    start_time: float | None = None
    stop_time: float | None = None
    tolerance: float | None = None
    solver: str = "ida"
    points: int | None = None
    interval: float | None = None
    variables: Sequence[str] | None = None
    progress: Callable[[float, float], None] | None = None
    max_step: float = float("inf")
    kept: tuple[int, ...] | None = None
    continue_from: Snapshot | None = None
    dense: bool = False
    output: str | PathLike[str] | None = None
    keep: bool = True
