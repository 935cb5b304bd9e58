"""The pages stand alone, lead to each other, and say what is in the library."""

from __future__ import annotations

import json
import re
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path

import pytest
from click.testing import CliRunner

from acausal.cli.main import group
from acausal.modeling.library import Root, standard_library
from acausal.modeling.load import load_text
from acausal.reference.catalogue import packages
from acausal.reference.entries import class_entry
from acausal.reference.markdown import markdown_index
from acausal.reference.pages import unit_text
from acausal.reference.write import reference_pages

ROOT = Path(__file__).parents[2]
VOID = {"meta", "input", "br", "wbr", "mspace", "td", "th", "tr", "li"}


@pytest.fixture(scope="module")
def root() -> Root:
    return standard_library()


@pytest.fixture(scope="module")
def pages(root: Root) -> dict[str, str]:
    return reference_pages(root=root)


class Reader(HTMLParser):
    """Collects ids and links, and looks whether elements are closed in order."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.sources: list[str] = []
        self.wrong: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        if values.get("id"):
            self.ids.append(str(values["id"]))
        if values.get("href"):
            self.links.append(str(values["href"]))
        self.sources += [str(values[k]) for k in ("src", "srcset", "data") if values.get(k)]
        if tag == "link":
            self.sources.append("link")
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        if tag in VOID:
            return
        if not self.open or self.open[-1] != tag:
            self.wrong.append(f"{tag} at {self.getpos()}, open {self.open[-3:]}")
        else:
            self.open.pop()


def read(text: str) -> Reader:
    reader = Reader()
    reader.feed(text)
    return reader


def test_there_is_a_page_for_every_package(pages: dict[str, str], root: Root) -> None:
    names = [p.name for p in packages(root)]
    assert list(pages) == ["index.html", *(f"{n}.html" for n in names)]
    assert {"electrical", "electrical.digital", "constants", "si"} <= set(names)


def test_pages_are_well_formed_and_need_nothing_else(pages: dict[str, str]) -> None:
    for name, text in pages.items():
        reader = read(text)
        assert reader.wrong == [], name
        assert reader.open == [], name
        assert reader.sources == [], name
        assert [i for i, n in Counter(reader.ids).items() if n > 1] == [], name
        assert "http:" not in text.replace("http://www.w3.org", ""), name
        assert "https:" not in text and "@import" not in text and "url(h" not in text, name


def test_links_lead_somewhere(pages: dict[str, str]) -> None:
    readers = {name: read(text) for name, text in pages.items()}
    anchors = {name: set(reader.ids) for name, reader in readers.items()}
    broken = []
    for name, reader in readers.items():
        for link in reader.links:
            page, _, anchor = link.partition("#")
            target = anchors.get(page or name)
            if target is None or (anchor and anchor not in target):
                broken.append(f"{name}: {link}")
    assert broken == []
    assert sum(len(r.links) for r in readers.values()) > 3000


def test_every_class_has_its_place(pages: dict[str, str], root: Root) -> None:
    for package in packages(root):
        ids = set(read(pages[f"{package.name}.html"]).ids)
        assert {c.name.strip("'") for c in package.classes} <= ids, package.name


def test_a_component_is_described(pages: dict[str, str]) -> None:
    page = pages["electrical.html"]
    section = page.split('<section id="Resistor">')[1].split("</section>")[0]
    assert "Ideal resistor" in section
    assert 'extends <a href="#PartialResistor">PartialResistor</a>' in section
    assert '<a href="thermal.html#HeatPort_a">' in section
    assert "<td>Ω<td><code>1[Ohm]</code>" in section
    assert 'title="decides sizes or structure">structural' in section
    assert '<p class="from">from <a href="#TwoPin">TwoPin</a></p>' in section
    assert "<mi class=v>LossPower</mi>" in section
    assert "rlc.acm" in section
    assert '<use href="#s-Resistor"/>' in section and '<symbol id="s-Resistor"' in page


def test_other_kinds_of_classes_are_described(pages: dict[str, str]) -> None:
    pin = pages["electrical.html"].split('<section id="Pin">')[1].split("</section>")[0]
    assert "<td>across<td>" in pin and "<td>through<td>" in pin
    function = pages["mechanical.html"].split('<section id="stribeck">')[1].split("</section>")[0]
    assert "algorithm" in function
    assert "speed of light" in pages["constants.html"] or "pi" in pages["constants.html"]
    assert '<code id="Voltage">Voltage</code>' in pages["si.html"]


def test_the_index_finds_every_class(pages: dict[str, str], root: Root) -> None:
    text = re.search(r"const NAMES=(\[.*?\]),HERE=", pages["index.html"])
    assert text is not None
    names = json.loads(text[1])
    assert ["Resistor", "electrical"] in [n[:2] for n in names]
    known = packages(root)
    assert len(names) == sum(len(p.classes) for p in known)


def test_structural_parameters_origins_and_finals() -> None:
    text = """
    partial model Base
      parameter Integer n = 2 "size"; parameter Real k = 3 "factor"; parameter Real t[:] = {1};
      Real x "state"; constant Real c = 1 "fixed";
    equation der(x) = k; end Base;
    model A extends Base(final k = 4, n = 5); Real y "more"; equation y = x*n; end A;
    """
    entry = class_entry(load_text(text)[0]["A"])
    assert [(i.name, i.default, i.structural) for i in entry.parameters] == [
        ("n", "5", True),
        ("t[:]", "{1}", True),
    ]
    assert [i.origin.name if i.origin else "" for i in entry.variables] == ["Base", ""]
    assert [law.origin.name if law.origin else "" for law in entry.laws] == ["", "Base"]
    assert [i.name for i in entry.constants] == ["c"]


@pytest.mark.parametrize(
    ("unit", "shown"),
    [("kg.m2", "kg·m²"), ("Ohm", "Ω"), ("m/s2", "m/s²"), ("N.m/rad", "N·m/rad"), ("1/K", "1/K")],
)
def test_units_as_people_write_them(unit: str, shown: str) -> None:
    assert unit_text(unit) == shown


def test_the_command_writes_pages(tmp_path: Path) -> None:
    folder = tmp_path / "pages"
    done = CliRunner().invoke(group, ["reference", "constants", "-o", str(folder)])
    assert done.exit_code == 0, done.output
    assert sorted(p.name for p in folder.iterdir()) == ["constants.html", "index.html"]
    assert "2 pages" in done.output


def test_an_unknown_package_is_refused(tmp_path: Path) -> None:
    done = CliRunner().invoke(group, ["reference", "electrics", "-o", str(tmp_path)])
    assert done.exit_code != 0
    assert "N150" in str(done.exception)
    assert list(tmp_path.iterdir()) == []


def test_the_index_of_the_manual_is_current(root: Root) -> None:
    page = (ROOT / "docs" / "reference.md").read_text(encoding="utf-8")
    assert page == markdown_index(root), "python -m acausal.reference.markdown > docs/reference.md"
