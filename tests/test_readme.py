"""The first page leads to all others, and no page leads nowhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = sorted((ROOT / "docs").glob("*.md"))
LINK = re.compile(r"\]\(([^)#\s:]+)(?:#[^)]*)?\)")


def targets(page: Path) -> list[Path]:
    """Return the files that a page links to."""
    text = re.sub(r"```.*?```|`[^`\n]*`", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    return [(page.parent / link).resolve() for link in LINK.findall(text)]


def test_every_page_is_linked_from_the_first_one() -> None:
    found = set(targets(ROOT / "README.md"))
    assert [p.name for p in PAGES if p.resolve() not in found] == []


@pytest.mark.parametrize("page", [ROOT / "README.md", *PAGES], ids=lambda p: p.stem)
def test_links_lead_to_files(page: Path) -> None:
    assert [str(t.relative_to(ROOT)) for t in targets(page) if not t.exists()] == []
