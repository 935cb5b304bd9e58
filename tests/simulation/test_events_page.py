"""The examples of docs/events.md do what the page says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from acausal import compile_text

PAGE = Path(__file__).parents[2] / "docs" / "events.md"
TEXT = PAGE.read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```modelica\n(.*?)```", TEXT, re.DOTALL)
LATER = re.compile(r"^// at (\S+): (\S+) = (\S+)$", re.MULTILINE)
ERROR = re.compile(r"^// error (\w\d{3})$", re.MULTILINE)


def name(example: str) -> str:
    return re.findall(r"^(?:model|block) (\w+)", example, re.MULTILINE)[-1]


@pytest.mark.parametrize("example", EXAMPLES, ids=name)
def test_example(example: str) -> None:
    error, later = ERROR.search(example), LATER.findall(example)
    assert error or later, "the example says nothing that could be checked"
    if error:
        result = compile_text(example).simulate(stop_time=2.0)
        assert [d.code for d in result.diagnostics] == [error[1]]
        return
    for time, path, value in later:
        result = compile_text(example).simulate(stop_time=float(time))
        assert result[path].values[-1] == pytest.approx(float(value), rel=1e-5, abs=1e-6)


def test_links_lead_somewhere() -> None:
    for target in re.findall(r"\]\(([\w-]+\.md)", TEXT):
        assert (PAGE.parent / target).exists(), target


def test_codes_exist() -> None:
    from acausal.diagnostics.codes import CODES

    for code in re.findall(r"`([A-Z]\d{3})`", TEXT):
        assert code in CODES, code
