"""Every example has a description and an experiment, starts without warnings, and is listed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from acausal import compile_file
from acausal.modeling.load import load_file

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "examples").glob("*.acm"))
MODEL = re.compile(r"^(partial )?model (\w+)(.*?)^end \2;", re.MULTILINE | re.DOTALL)


def runs(path: Path) -> list[str]:
    """Return the models of a file that say how long they run, or extend one that does."""
    timed: dict[str, bool] = {}
    for partial, name, body in MODEL.findall(path.read_text(encoding="utf-8")):
        base = re.search(r"^  extends (\w+)", body, re.MULTILINE)
        if "experiment(" in body or (base and base[1] in timed):
            timed[name] = not partial
    return [name for name, whole in timed.items() if whole]


def test_the_page_lists_every_file_with_its_system() -> None:
    page = (ROOT / "docs" / "examples.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| \[(\w+)\]\(\.\./examples/\1\.acm\) \| (\w*) \| (.+) \|$", page, re.M)
    assert [name for name, _, _ in rows] == [path.stem for path in FILES]
    for path, (_, system, shows) in zip(FILES, rows, strict=True):
        assert len(shows) > 10
        assert set(re.findall(r"\bS\d\d\b", path.read_text(encoding="utf-8"))) <= {system}, path


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_models_have_descriptions_and_start_without_warnings(path: Path) -> None:
    classes, _ = load_file(path)
    assert [c.full_name for c in classes.values() if not c.tree.description] == []
    names = runs(path)
    assert names
    for name in names:
        compiled = compile_file(path, model=name)
        assert compiled.warnings == (), name
        result = compiled.simulate(stop_time=1e-6, points=2)
        assert result.diagnostics == (), name
