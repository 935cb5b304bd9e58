"""The examples of the manual's page about many runs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]


def test_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = (ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    code = "\n".join(blocks).replace('"examples/', f'"{ROOT.as_posix()}/examples/')
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(compile(code, "sweeps.md", "exec"), names)
    study = names["study"]
    assert len(study) == 8
    assert study.complete.all()
    assert len(names["tolerances"]) == 20
    assert names["listed"].complete.all()
    whole = names["compiled"].simulate(stop_time=0.02)
    assert names["second"]["c.v"].values[-1] == pytest.approx(
        whole["c.v"].values[-1], rel=1e-3, abs=1e-4
    )
    assert names["again"].time == 0.01
    assert names["result"]["c.v"].values[0] == pytest.approx(5.0)
    assert not np.allclose(names["changed"]["c.v"].values, names["second"]["c.v"].values)
