"""The examples of the manual page run."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import acausal as ac

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "animation.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("number", range(3))
def test_python_examples(number, tmp_path, monkeypatch):
    code = re.findall(r"```python\n(.*?)```", PAGE, re.S)[number]
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "animation.md", "exec"), {})
    written = re.findall(r'"(\w+\.(?:html|gif))"', code)
    assert all((tmp_path / name).stat().st_size > 5000 for name in written)


def test_model_example():
    (code,) = re.findall(r"```modelica\n(.*?)```", PAGE, re.S)
    scene = ac.compile_text(code).simulate(stop_time=1).animate().scene()
    assert [s.kind for s in scene.sprites] == ["trail", "placed", "stretched", "placed"]


def test_table_names_every_shape():
    from acausal.animation.annotations import SHAPES

    table = [line for line in PAGE.splitlines() if line.startswith("| `")]
    named = {word for line in table for word in re.findall(r"`(\w+)`", line.split("|")[1])}
    assert named == set(SHAPES)
    for line in table:
        cells = line.split("|")
        arguments = {a for kind in re.findall(r"`(\w+)`", cells[1])
                     for group in SHAPES[kind] for a in group}  # fmt: skip
        assert set(re.findall(r"`(\w+)`", cells[2] + cells[3])) <= arguments
