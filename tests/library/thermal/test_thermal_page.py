"""The examples of docs/thermal.md do what the page says."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from acausal import compile_text

PAGE = Path(__file__).parents[3] / "docs" / "thermal.md"
EXAMPLES = re.findall(r"```modelica\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
VALUE = re.compile(r"^// (\S+) = (\S+) at (\S+) s$", re.MULTILINE)


@pytest.mark.parametrize("example", EXAMPLES)
def test_example(example: str) -> None:
    found = VALUE.findall(example)
    assert found
    for path, value, time in found:
        result = compile_text(example).simulate(stop_time=float(time), tolerance=1e-9)
        assert np.asarray(result[path].values)[-1] == pytest.approx(float(value), abs=1e-3)
