"""A progress bar that shows the simulated time, on runs long enough for one."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from click._termui_impl import ProgressBar

#: Seconds of silence before the bar appears.
PATIENCE = 1.0
#: Seconds between two drawings.
PERIOD = 0.1
_STEPS = 1000


class SimulatedTime:
    """Callable for ``progress``: draws ``t_now`` of ``t_stop`` on the standard error stream.

    Args:
        start_time: Start of the simulation, seconds.
        shown: Draw at all; off without a terminal.
    """

    def __init__(self, start_time: float, shown: bool) -> None:
        self._start = start_time
        self._shown = shown
        self._next = time.monotonic() + PATIENCE
        self._bar: ProgressBar[Any] | None = None
        self._done = 0

    def __enter__(self) -> SimulatedTime:
        return self

    def __call__(self, now: float, stop: float) -> None:
        """Draw, if it is time to."""
        if not self._shown or (clock := time.monotonic()) < self._next:
            return
        self._next = clock + PERIOD
        if self._bar is None:
            import click

            self._bar = click.progressbar(
                length=_STEPS,
                label="simulating",
                file=sys.stderr,
                item_show_func=lambda item: item,
                width=30,
            )
            self._bar.__enter__()
        span = stop - self._start
        position = int(_STEPS * min(max((now - self._start) / span, 0.0), 1.0)) if span else 0
        step, self._done = position - self._done, position
        self._bar.update(step, f"t = {now:.4g} s of {stop:g} s")

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.__exit__(kind, error, trace)
