"""The tutorials run, and what they show is what they have stored."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import latex2mathml.converter
import nbformat
import pytest
from jupyter_client import KernelManager
from nbformat import v4

from tests.tutorials.notebooks import (
    COLOUR,
    FOLDER,
    NOTEBOOKS,
    execute,
    kernel,
    read,
    stored_form,
    texts,
)

FORMULA = re.compile(r"\$\$.*?\$\$|\$.*?\$", re.S)
NAMES = [path.stem for path in NOTEBOOKS]


@pytest.fixture(scope="module")
def manager(tmp_path_factory: pytest.TempPathFactory) -> Iterator[KernelManager]:
    with kernel(tmp_path_factory.mktemp("kernel")) as started:
        yield started


def test_there_are_tutorials():
    assert len(NOTEBOOKS) >= 5
    assert [name[:2] for name in NAMES] == [f"{k + 1:02}" for k in range(len(NAMES))]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=NAMES)
def test_a_tutorial_runs_and_its_outputs_are_current(path: Path, manager: KernelManager):
    stored, fresh = read(path), read(path)
    execute(fresh, manager)
    assert texts(fresh) == texts(stored), "python -m tests.tutorials writes the outputs anew"


@pytest.mark.parametrize("path", NOTEBOOKS, ids=NAMES)
def test_a_tutorial_reads_well_where_it_is_stored(path: Path):
    assert path.stat().st_size < 300_000
    notebook = read(path)
    nbformat.validate(notebook)
    assert stored_form(read(path)) == notebook, "python -m tests.tutorials writes its stored form"
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    pictures = [
        output
        for cell in code
        for output in cell.outputs
        if {"image/png", "image/svg+xml"} & set(output.get("data", {}))
    ]
    assert len(pictures) >= 2
    assert any("np.testing" in cell.source for cell in code)
    for cell in notebook.cells:
        assert max(map(len, cell.source.splitlines())) <= 120
        if cell.cell_type == "markdown":
            for formula in FORMULA.findall(cell.source):
                assert "merror" not in latex2mathml.converter.convert(formula.strip("$"))
    # Nothing of the machine that has executed it.
    everything = "\n".join(
        [cell.source for cell in notebook.cells] + [t for _, t in texts(notebook)]
    )
    assert not re.search(r"/(tmp|home|root|work)/|0x[0-9a-f]{6}", everything)


def test_all_tutorials_are_listed():
    listed = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert re.findall(r"\]\((\w+)\.ipynb\)", listed) == NAMES


CELLS = (
    "import acausal as ac\nfrom acausal.library import electrical as el\nm = ac.Model('m')",
    "# the mistake stands in line 3\n\nm.r = el.Resistor(r=100)",
    "m.r = el.Resistor(\n    R='1[kg]'\n)\nm.g = el.Ground()",
    "m.connect(m.r.p, m.r.n, m.g.p)\nm.compile()",
)


def test_a_kernel_shows_mistakes_at_the_line_of_their_cell(manager: KernelManager):
    """A part that is wrong may have been made in an earlier cell than the one that compiles."""
    notebook = v4.new_notebook(cells=[v4.new_code_cell(source) for source in CELLS])
    execute(notebook, manager, allow_errors=True)
    errors = [[o for o in cell.outputs if o.output_type == "error"] for cell in notebook.cells]
    assert errors[0] == errors[2] == []
    (unknown,), (unit,) = errors[1], errors[3]
    assert "error[N103]" in unknown.evalue and " 3 | m.r = el.Resistor(r=100)" in unknown.evalue
    assert "error[U102]" in unit.evalue
    assert re.search(r"^ +1 \| m\.r = el\.Resistor\($", unit.evalue, re.M)
    for error in (unknown, unit):
        shown = COLOUR.sub("", "\n".join(error.traceback))
        assert "acausal/" not in shown.replace("library/", ""), "frames inside of acausal"
        assert error.evalue.splitlines()[0] in shown
    # The first cell is the one that makes the notebook forget: the mistakes stand in cells 3 and 4.
    assert re.search(r"--> Cell In\[\d+\]:3:7", COLOUR.sub("", "\n".join(unknown.traceback)))
    assert re.search(r"--> Cell In\[\d+\]:1:7", COLOUR.sub("", "\n".join(unit.traceback)))
