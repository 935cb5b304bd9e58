"""Nearest names."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from acausal.diagnostics.suggest import nearest

NAMES = ["Resistor", "Capacitor", "Inductor", "Ground", "VariableResistor", "R", "C", "resistor2"]


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("Resistr", "Resistor"),
        ("resistor", "Resistor"),
        ("Reisstor", "Resistor"),
        ("Capacitator", "Capacitor"),
        ("GROUND", "Ground"),
        ("r", "R"),
    ],
)
def test_misspelt(wrong, right):
    assert nearest(wrong, NAMES)[0] == right


@pytest.mark.parametrize("wrong", ["Pendulum", "x", "", "Zzzzzzzz"])
def test_nothing_near(wrong):
    assert nearest(wrong, NAMES) == []


def test_ties_go_by_order_and_limit():
    assert nearest("ab", ["ac", "ad", "ae", "af"], limit=2) == ["ac", "ad"]
    assert nearest("ab", ["af", "ae", "ac", "ac"], limit=3) == ["af", "ae", "ac"]


@given(st.text(max_size=8), st.lists(st.text(max_size=8), max_size=12))
def test_answers_are_candidates_and_the_same_each_time(name, candidates):
    found = nearest(name, candidates)
    assert found == nearest(name, candidates)
    assert len(found) == len(set(found)) <= 3
    assert set(found) <= set(candidates) - {name}
