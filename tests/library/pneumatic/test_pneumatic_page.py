"""The example of docs/pneumatic.md does what the page says."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from acausal import compile_text

PAGE = Path(__file__).parents[3] / "docs" / "pneumatic.md"
EXAMPLES = re.findall(r"```modelica\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
VALUE = re.compile(r"^// at (\S+) s: (\S+) = (\S+)$", re.MULTILINE)


@pytest.mark.parametrize("example", EXAMPLES, ids=[e.split()[3] for e in EXAMPLES])
def test_example(example: str) -> None:
    found = VALUE.findall(example)
    assert found
    last = max(float(time) for time, _, _ in found)
    result = compile_text(example).simulate(stop_time=last, points=1001, tolerance=1e-8)
    for time, path, value in found:
        signal = np.asarray(result[path].values, float)
        shown = np.interp(float(time), result.times, signal)
        assert shown == pytest.approx(float(value), rel=3e-3), path
