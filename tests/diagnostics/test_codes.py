"""Every code that is used has one meaning, and every meaning is used."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import acausal
from acausal.diagnostics.codes import CODES, STAGES, manual_page

PACKAGE = Path(acausal.__file__).parent
REGISTRY = PACKAGE / "diagnostics" / "codes.py"
CODE = re.compile(r"[A-Z]\d{3}")


def codes_in(source: str) -> set[str]:
    """Return the string literals that look like codes."""
    return {
        node.value
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Constant)
        and isinstance(node.value, str)
        and CODE.fullmatch(node.value)
    }


def used() -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        if path != REGISTRY:
            for code in codes_in(path.read_text(encoding="utf-8")):
                found.setdefault(code, []).append(str(path.relative_to(PACKAGE)))
    return found


def test_every_code_in_the_source_is_registered():
    assert {c: where for c, where in used().items() if c not in CODES} == {}


def test_every_registered_code_is_used():
    assert sorted(set(CODES) - set(used())) == []


def test_no_code_is_registered_twice():
    keys = re.findall(r'^    "([A-Z]\d{3})":', REGISTRY.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(keys) == len(set(keys)) == len(CODES)


def test_codes_are_in_order_and_meanings_are_sentences():
    letters = list(STAGES)
    assert list(CODES) == sorted(CODES, key=lambda c: (letters.index(c[0]), c))
    assert [c for c, meaning in CODES.items() if not re.fullmatch(r"\S.*\.", meaning)] == []


def test_a_code_without_a_meaning_would_be_seen():
    assert codes_in('fail("X123", "m")') == {"X123"}


def test_the_manual_is_up_to_date():
    page = PACKAGE.parent / "docs" / "messages.md"
    assert page.read_text(encoding="utf-8") == manual_page()
