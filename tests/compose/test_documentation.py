"""The examples of the manual and of the docstrings run."""

from __future__ import annotations

import doctest
import importlib
import re
from pathlib import Path

import pytest

import acausal as ac

_PAGE = Path(__file__).parents[2] / "docs" / "python.md"


def test_examples_of_the_manual():
    """They run in order, with the names of those before."""
    names: dict[str, object] = {}
    blocks = re.findall(r"```python\n(.*?)```", _PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 8
    for block in blocks:
        exec(compile(block, str(_PAGE), "exec"), names)
    circuit = names["circuit"]
    assert isinstance(circuit, ac.Model)
    assert abs(names["result"]["c.v"].values).max() > 9


@pytest.mark.parametrize(
    "module",
    ["component", "declarations", "equations", "functions", "loading", "model", "modifiers"],
)
def test_docstrings(module, monkeypatch):
    monkeypatch.chdir(Path(__file__).parents[2])
    found = doctest.testmod(
        importlib.import_module(f"acausal.compose.{module}"), optionflags=doctest.ELLIPSIS
    )
    assert found.failed == 0
