"""The progress bar: only on long runs, with the simulated time."""

from __future__ import annotations

import io
import types

import pytest

from acausal.cli import progress
from acausal.cli.progress import SimulatedTime


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def terminal(monkeypatch):
    stream = Terminal()
    # Not sys.stderr itself: pytest sets that anew before every test.
    monkeypatch.setattr(progress, "sys", types.SimpleNamespace(stderr=stream))
    return stream


@pytest.fixture
def clock(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    return now


def test_a_short_run_shows_nothing(terminal, clock):
    with SimulatedTime(0.0, shown=True) as bar:
        for k in range(9):
            clock[0] = k / 10
            bar(k / 10, 1.0)
    assert terminal.getvalue() == ""


def test_a_long_run_shows_the_simulated_time(terminal, clock):
    with SimulatedTime(10.0, shown=True) as bar:
        for k in range(11):
            clock[0] = float(k)
            bar(10 + k / 10, 12.0)
    text = terminal.getvalue()
    assert "t = 10.1 s of 12 s" in text
    assert "t = 11 s of 12 s" in text
    assert "50%" in text


def test_drawing_is_paced(terminal, clock):
    with SimulatedTime(0.0, shown=True) as bar:
        clock[0] = 2.0
        for k in range(1000):
            bar(k / 1000, 1.0)
    assert terminal.getvalue().count("t = ") <= 2


def test_hidden(terminal, clock):
    with SimulatedTime(0.0, shown=False) as bar:
        clock[0] = 5.0
        bar(0.5, 1.0)
    assert terminal.getvalue() == ""


def test_odd_intervals(terminal, clock):
    """Backwards, empty, and beyond the end."""
    with SimulatedTime(1.0, shown=True) as bar:
        for k, (now, stop) in enumerate([(1.0, 1.0), (0.5, 0.0), (9.0, 2.0), (0.0, 2.0)]):
            clock[0] = 2.0 + k
            bar(now, stop)
    assert terminal.getvalue()
