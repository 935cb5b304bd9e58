"""The examples of docs/blocks.md do what the page says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from acausal import compile_text
from tests.library.blocks_runs import after

PAGE = Path(__file__).parents[2] / "docs" / "blocks.md"
EXAMPLES = re.findall(r"```modelica\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
VALUE = re.compile(r"^// (\S+) = (\S+) at (\S+) s$", re.MULTILINE)


@pytest.mark.parametrize("example", EXAMPLES)
def test_example(example: str) -> None:
    found = VALUE.findall(example)
    assert found
    result = compile_text(example).simulate(stop_time=2, points=201, tolerance=1e-9)
    for path, value, time in found:
        base, _, exponent = value.partition("^")
        expected = float(base) ** float(exponent or 1)
        assert after(result, path, float(time)) == pytest.approx(expected, abs=1e-6)
