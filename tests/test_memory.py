"""What is remembered of objects belongs to these objects, and is forgotten in order."""

from __future__ import annotations

from acausal.memory import Remembered


def test_equal_objects_are_told_apart() -> None:
    known: Remembered[int] = Remembered()
    a, b = [1], [1]
    assert known.get(a, "k", lambda: 1) == 1
    assert known.get(b, "k", lambda: 2) == 2
    assert known.get(a, "k", lambda: 3) == 1
    assert known.get(a, "other", lambda: 4) == 4


def test_the_longest_unused_goes_first() -> None:
    known: Remembered[int] = Remembered(2)
    a, b, c = [1], [2], [3]
    known.get(a, "", lambda: 1)
    known.get(b, "", lambda: 2)
    known.get(a, "", lambda: 0)
    known.get(c, "", lambda: 3)
    assert known.get(a, "", lambda: 9) == 1
    assert known.get(b, "", lambda: 9) == 9
