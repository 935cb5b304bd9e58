"""Memory of large models."""

from __future__ import annotations

import gc
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from typing import Generic, TypeVar

_T = TypeVar("_T")


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


class Remembered(Generic[_T]):
    """What was made of an object, by the object itself (not by its value) and a key.

    A handful of objects is kept alive; the one that was used longest ago goes first.
    """

    def __init__(self, most: int = 16) -> None:
        self._most = most
        self._known: OrderedDict[tuple[int, Hashable], tuple[object, _T]] = OrderedDict()

    def get(self, owner: object, key: Hashable, make: Callable[[], _T]) -> _T:
        """Return what was made, or make it."""
        where = (id(owner), key)
        found = self._known.get(where)
        if found is None:
            found = self._known[where] = (owner, make())
            if len(self._known) > self._most:
                self._known.popitem(last=False)
        else:
            self._known.move_to_end(where)
        return found[1]
