"""The examples of the manual and of the docstrings run."""

from __future__ import annotations

import doctest
import importlib
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

import acausal as ac
from acausal.cli.main import group
from acausal.cli.netlist import SUFFIXES
from acausal.netlists.spice import reader

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def at_the_root(monkeypatch):
    monkeypatch.chdir(ROOT)


def test_examples_of_the_manual():
    names: dict[str, object] = {}
    page = (ROOT / "docs" / "netlists.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(blocks) == 5
    for block in blocks:
        exec(compile(block, "netlists.md", "exec"), names)
    assert names["current"].values[0] != 0
    assert abs(names["result"]["v_out"].values).max() > 1


@pytest.mark.parametrize(
    "module", ["graphs", "chains", "identifiers", "spice.expressions", "spice.reader"]
)
def test_docstrings(module):
    found = doctest.testmod(importlib.import_module(f"acausal.netlists.{module}"))
    assert found.attempted
    assert found.failed == 0


def test_translation_on_the_command_line(tmp_path):
    target = tmp_path / "lowpass.acm"
    done = CliRunner().invoke(group, ["spice", "examples/lowpass.cir", "-o", str(target)])
    assert done.exit_code == 0
    written = ac.compile_file(target).simulate()
    direct = ac.read_spice("examples/lowpass.cir").simulate()
    assert (written["v_out"].values == direct["v_out"].values).all()


def test_simulation_and_check_on_the_command_line(tmp_path):
    table = tmp_path / "out.csv"
    words = ["examples/lowpass.cir", "-p", "tau=1e-4", "-v", "v_out", "-o", str(table)]
    assert CliRunner().invoke(group, ["simulate", *words], standalone_mode=False).exit_code == 0
    assert "v_out" in table.read_text(encoding="utf-8")
    done = CliRunner().invoke(group, ["check", "examples/lowpass.cir"])
    assert done.output.startswith("lowpass")


def test_both_know_the_same_suffixes():
    assert SUFFIXES == reader.SUFFIXES
