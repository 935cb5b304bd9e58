"""The examples of the manual run as they stand there."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from acausal.cli.main import execute

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    for example in ("rlc", "electric_car", "crane_crab"):
        (tmp_path / f"{example}.acm").symlink_to(ROOT / "examples" / f"{example}.acm")
    (tmp_path / "plant.acm").symlink_to(ROOT / "examples" / "rlc.acm")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def blocks(name: str, language: str) -> list[str]:
    text = (ROOT / "docs" / name).read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


@pytest.mark.parametrize("name", ["schematics.md", "report.md"])
def test_python_examples_run(name, folder):
    pytest.importorskip("resvg_py")
    found = blocks(name, "python")
    assert found
    for block in found:
        exec(compile(block, name, "exec"), {})
    assert (folder / "rlc.svg").exists() or (folder / "rlc.html").exists()


@pytest.mark.parametrize("name", ["schematics.md", "report.md"])
def test_commands_run(name, folder):
    pytest.importorskip("resvg_py")
    for line in "".join(blocks(name, "bash")).splitlines():
        words = shlex.split(line)
        assert words[0] == "acausal"
        assert execute(words[1:]) == 0
