"""The report: one page that needs nothing else and says what is true of the model and its run."""

from __future__ import annotations

import base64
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

import acausal as ac
from acausal.reporting.html import number, table

EXAMPLES = Path(__file__).parents[2] / "examples"
MODELS = [
    ("rlc", None),
    ("power_electronics", "BuckConverter"),
    ("crane_crab", "ControlledCraneCrab"),
    ("pendulum_chain", "Chain10"),
    ("spatial_loop", None),
]


@pytest.fixture(scope="module", params=MODELS, ids=lambda m: m[0])
def page(request):
    name, model = request.param
    compiled = ac.compile_file(EXAMPLES / f"{name}.acm", model)
    result = compiled.simulate(points=101)
    return compiled, result, compiled.report(result=result)


def root_of(text: str) -> ET.Element:
    """The page as XML: well-formed, but for the document type and entities of HTML."""
    return ET.fromstring(text.removeprefix("<!doctype html>"))


def test_the_page_is_well_formed_and_complete(page):
    compiled, result, text = page
    root = root_of(text)
    sections = [s.get("id") for s in root.iter("section")]
    assert sections[0] == "schematic"
    wanted = {"plots", "parameters", "states", "equations", "structure", "solver", "data"}
    assert wanted <= set(sections)
    assert ("events" in sections) == bool(result.events)
    links = [a.get("href") for a in next(root.iter("nav"))]
    assert links == [f"#{s}" for s in sections]
    assert next(root.iter("h1")).text == compiled.name


def test_nothing_is_loaded_from_elsewhere(page):
    root = root_of(page[2])
    for element in root.iter():
        for key, value in element.attrib.items():
            if key.split("}")[-1] in ("href", "src", "data", "action"):
                assert value.startswith(("#", "data:"))
        assert element.tag.split("}")[-1] not in ("script", "link", "img", "iframe")
    style = next(root.iter("style")).text
    assert "url(" not in style
    assert "@import" not in style


def test_names_inside_of_the_page_are_unique(page):
    names = [e.get("id") for e in root_of(page[2]).iter() if e.get("id")]
    assert len(names) == len(set(names))


def test_every_use_refers_to_something(page):
    root = root_of(page[2])
    names = {e.get("id") for e in root.iter()}
    for match in re.findall(r'(?:href="#|url\(#)([^")]+)', page[2]):
        assert match in names


def test_the_table_of_states_has_their_values(page):
    _, result, text = page
    section = next(s for s in root_of(text).iter("section") if s.get("id") == "states")
    rows = [["".join(td.itertext()) for td in tr] for tr in section.iter("tr")][1:]
    assert len(rows) == min(60, len(result.states))
    for row in rows:
        values = result[row[0]].values
        assert row[1] == number(float(values[0]))
        assert row[4] == number(float(values[-1]))


def test_the_data_are_those_of_the_run(page):
    _, result, text = page
    found = re.search(r'href="data:text/csv;base64,([^"]+)"', text)
    assert found is not None
    lines = base64.b64decode(found[1]).decode().splitlines()
    assert len(lines) == len(result.times) + 1
    head = [h.strip('"') for h in re.findall(r'"[^"]*"|[^,]+', lines[0])]
    values = np.array([[float(x) for x in line.split(",")] for line in lines[1:]])
    assert values.shape == (len(result.times), len(head))
    path = head[1].partition(" [")[0]
    np.testing.assert_allclose(values[:, 1], result[path].values, rtol=1e-6, atol=1e-300)


def test_parameters_are_listed_with_unit_and_description():
    text = ac.compile_file(EXAMPLES / "rlc.acm").report(run=False)
    section = next(s for s in root_of(text).iter("section") if s.get("id") == "parameters")
    rows = [["".join(td.itertext()) for td in tr] for tr in section.iter("tr")]
    own = next(k for k, row in enumerate(rows) if row[0].startswith("c") and len(row) == 1)
    assert rows[own + 1][:3] == ["C", "10⁻⁶", "F"]
    assert rows[own + 1][-1] == "capacitance"


def test_a_page_without_a_run_is_about_the_model_alone():
    text = ac.compile_file(EXAMPLES / "rlc.acm").report(run=False)
    sections = [s.get("id") for s in root_of(text).iter("section")]
    assert sections == ["schematic", "parameters", "equations", "structure"]


def test_the_same_run_gives_the_same_page():
    pages = [ac.compile_file(EXAMPLES / "rlc.acm").report() for _ in range(2)]
    assert pages[0] == pages[1]


def test_a_model_that_cannot_start_is_reported():
    text = """
    model Impossible "square root of a negative number"
      Real x(start = 1, fixed = true);
      Real y;
    equation
      der(x) = -1;
      y*y = -x;
    end Impossible;
    """
    page = ac.compile_text(text).report()
    root = root_of(page)
    boxes = [d for d in root.iter("div") if d.get("class") == "bad"]
    assert boxes
    assert "plots" not in [s.get("id") for s in root.iter("section")]


def test_a_failed_run_is_told():
    text = """
    model Explosion "grows without limit in finite time"
      Real x(start = 1, fixed = true);
    equation
      der(x) = x^2;
      annotation(experiment(StopTime = 2));
    end Explosion;
    """
    root = root_of(ac.compile_text(text).report())
    assert [d for d in root.iter("div") if d.get("class") == "bad"]
    assert "plots" in [s.get("id") for s in root.iter("section")]


def test_numbers_are_written_for_people():
    assert number(1e-6) == "10⁻⁶"
    assert number(-2.5e7) == "−2.5·10⁷"
    assert number(0.25) == "0.25"
    assert number(float("inf")) == "∞"
    assert number(float("nan")) == "–"


def test_empty_columns_are_left_out():
    assert "unit" not in table(("name", "unit"), [("a", ""), ("b", "")], "t-")
    assert table(("name",), [], "t") == ""


def test_command_line(tmp_path, capsys):
    from acausal.cli.main import execute

    target = tmp_path / "rlc.html"
    words = ["report", str(EXAMPLES / "rlc.acm"), "-o", str(target), "--stop", "20[ms]"]
    assert execute([*words, "-v", "c.v", "-p", "r.R=50"]) == 0
    root = root_of(target.read_text(encoding="utf-8"))
    section = next(s for s in root.iter("section") if s.get("id") == "solver")
    assert "0.02 s" in "".join(section.itertext())
    assert execute([*words[:2], "-o", str(tmp_path / "rlc.pdf")]) == 1
    assert "F201" in capsys.readouterr().err
