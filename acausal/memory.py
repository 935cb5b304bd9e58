"""Memory of large models."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def no_garbage_collection() -> Iterator[None]:
    """Keep the collector from searching millions of new objects, none of them garbage."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            # All that is new is moved to the oldest generation, or the next collection of young
            # objects would go through it at once.
            settle()
            gc.enable()


def settle() -> None:
    """Move all objects to the oldest generation, where the collector seldom looks.

    A program that makes a large model would otherwise spend half of its time in collections that
    go through the whole model and find nothing.
    """
    if not gc.get_freeze_count():
        gc.freeze()
        gc.unfreeze()
