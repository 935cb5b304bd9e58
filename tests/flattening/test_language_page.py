"""The examples of docs/language.md do what the page says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from acausal import compile_text
from acausal.diagnostics import AcausalError
from tests.flattening.static import flat, parameters, solve_flat

PAGE = Path(__file__).parents[2] / "docs" / "language.md"
EXAMPLES = re.findall(r"```modelica\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
VALUE = re.compile(r"^// (\S+) = (\S+)$", re.MULTILINE)
LATER = re.compile(r"^// at (\S+): (\S+) = (\S+)$", re.MULTILINE)
ERROR = re.compile(r"^// error (\w\d{3})$", re.MULTILINE)


def test_there_are_examples():
    assert len(EXAMPLES) >= 15


def name(example: str) -> str:
    return re.findall(r"^(?:model|block) (\w+)", example, re.MULTILINE)[-1]


@pytest.mark.parametrize("example", EXAMPLES, ids=name)
def test_example(example):
    expected = {path: float(value) for path, value in VALUE.findall(example)}
    error = ERROR.search(example)
    later = LATER.findall(example)
    assert expected or error or later, "the example says nothing that could be checked"
    if error:
        with pytest.raises(AcausalError) as caught:
            flat(example)
        assert caught.value.diagnostics[0].code == error[1]
        return
    if later:
        for time, path, value in later:
            result = compile_text(example).simulate(stop_time=float(time))
            assert result[path].values[-1] == pytest.approx(float(value), rel=1e-5)
        return
    found = {**parameters(example), **solve_flat(flat(example))}
    assert {path: found[path] for path in expected} == pytest.approx(expected, rel=1e-6, abs=1e-9)
