"""How long a native stretch may be, so that Ctrl-C and progress are seen in time."""

from __future__ import annotations

import threading
from collections.abc import Callable

#: Wanted duration of a stretch in the main thread, seconds.
STRETCH = 0.01
#: Wanted duration of a stretch in a thread of its own, seconds.
LONG_STRETCH = 0.5
#: Numbers copied to the output in about :data:`STRETCH`.
COPIED = 2_000_000


class Pace:
    """Budget of steps and output rows per stretch, learnt from the stretches so far.

    Attributes:
        steps: Steps that the next stretch may take.
        rows: Rows that it may fill.
        slow: A single step takes so long that it has to run in a thread.
    """

    def __init__(self, n: int) -> None:
        """Guess from the number of unknowns."""
        self.rows = max(1, min(10_000, COPIED // max(n, 1)))
        self.steps = max(1, min(1000, 50_000 // max(n, 1)))
        self.slow = n > 50_000

    def learn(self, steps: int, elapsed: float) -> None:
        """Set the budget of the next stretch from the steps and seconds of the last one."""
        if steps <= 0:
            return
        cost = elapsed / steps
        self.slow = cost > 0.5 * STRETCH
        wanted = LONG_STRETCH if self.slow else STRETCH
        # Never much more than twice what was just measured: the cost of a step varies.
        self.steps = max(1, min(int(wanted / max(cost, 1e-9)), 2 * steps + 10, 1_000_000))


def interruptible(
    work: Callable[..., int], arguments: tuple[object, ...], halt: Callable[[], None]
) -> int:
    """Run native work in a thread; on Ctrl-C halt it, wait for its end, and raise.

    Args:
        work: A native function that releases the interpreter.
        arguments: Its arguments.
        halt: Makes the work return soon.

    Raises:
        KeyboardInterrupt: After the work has returned.
    """
    results: list[int] = []
    done = threading.Event()

    def target() -> None:
        try:
            results.append(work(*arguments))
        finally:
            done.set()

    thread = threading.Thread(target=target, name="integration", daemon=True)
    thread.start()
    try:
        # A timeout lets signals through on every platform.
        while not done.wait(0.1):
            pass
    except KeyboardInterrupt:
        halt()
        done.wait()
        raise
    return results[0]
