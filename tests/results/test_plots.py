"""Plots of runs, phase portraits, notebooks, the command, and the page of the manual."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import acausal as ac
from acausal.cli.main import execute

ROOT = Path(__file__).parents[2]
BALL = """
model Ball "falls"
  parameter Real e = 0.8;
  Real h(start = 1, fixed = true, unit = "m") "height";
  Real v(start = 0, fixed = true, unit = "m/s");
equation
  der(h) = v;
  der(v) = -9.81[m/s2];
  when h < 0 then
    reinit(v, -e*pre(v));
  end when;
end Ball;
"""


@pytest.fixture(scope="module")
def compiled():
    return ac.compile_text(BALL)


@pytest.fixture(scope="module")
def result(compiled):
    return compiled.simulate(stop_time=1.5)


def code(error) -> str:
    return error.value.diagnostics[0].code


def test_events_are_marked(result):
    plain, marked = result.plot("h"), result.plot("h", events=True)
    assert len(plain.get_axes()[0].get_lines()) == 1
    # Two bounces; the recordings of one of them lie at one place of the picture.
    assert len(marked.get_axes()[0].get_lines()) == 3


def test_phase_portrait(result, tmp_path):
    figure = result.plot_phase("h", "v*1[kg]", file=tmp_path / "a.png")
    (ax,) = figure.get_axes()
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("h [m]", "v*1[kg] [N·s]")
    np.testing.assert_array_equal(ax.get_lines()[0].get_xdata(), result["h"].values)
    assert (tmp_path / "a.png").stat().st_size > 5000
    with pytest.raises(ac.AcausalError) as error:
        result.plot_phase("*", "v")
    assert code(error) == "F213"


def test_runs_over_each_other(compiled, result):
    other = compiled.simulate(stop_time=2.0, parameters={"e": 0.5})
    figure = ac.plot_runs([result, other], "h", "v", labels=["elastic", "dull"])
    axes = figure.get_axes()
    assert [len(ax.get_lines()) for ax in axes] == [2, 2]
    assert axes[1].get_xlim() == (0.0, 2.0)
    (legend,) = figure.legends
    assert [t.get_text() for t in legend.get_texts()] == ["elastic", "dull"]
    study = ac.sweep(compiled, {"e": [0.4, 0.6, 0.8]}, stop_time=1.0, variables=["h"])
    (legend,) = ac.plot_runs(study, "h").legends
    assert [t.get_text() for t in legend.get_texts()] == ["e = 0.4", "e = 0.6", "e = 0.8"]
    for runs, labels in (([], None), ([None], None), ([result], ["a", "b"])):
        with pytest.raises(ac.AcausalError) as error:
            ac.plot_runs(runs, "h", labels=labels)
        assert code(error) == "F213"


def test_what_notebooks_show(compiled, result):
    html = result._repr_html_()
    assert "falls" in html
    assert "<code>h</code>" in html
    assert "image/svg+xml" in html
    assert "m/s" in result["v"]._repr_html_()
    html = compiled._repr_html_()
    assert "States (2)" in html
    assert "0.8" in html
    assert "2 states" in html
    equations = compiled.equations
    assert len(equations) == 2
    assert r"\dot{h} &= v" in str(equations)
    assert equations._repr_latex_().startswith("$$")
    assert equations._repr_html_().count("<math") == 2


def test_the_command(result, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    result.write("a.nc")
    result.write("b.csv")
    assert execute(["plot", "a.nc", "-o", "1.png"]) == 0
    assert execute(["plot", "a.nc", "-v", "h, max(h, 0)", "--events", "-o", "2.svg"]) == 0
    assert execute(["plot", "a.nc", "b.csv", "-v", "h", "-o", "3.pdf"]) == 0
    assert execute(["plot", "a.nc", "--phase", "h", "v", "-o", "4.png"]) == 0
    assert all(Path(name).stat().st_size > 1000 for name in ("1.png", "2.svg", "3.pdf", "4.png"))
    assert execute(["plot", "a.nc", "-v", "x", "-o", "5.png"]) == 1
    assert execute(["plot", "none.nc", "-o", "5.png"]) == 1
    assert execute(["plot", "a.nc", "-v", "h", "--phase", "h", "v", "-o", "5.png"]) == 2
    assert not Path("5.png").exists()
    Path("ball.acm").write_text(BALL, encoding="utf-8")
    assert execute(["simulate", "ball.acm", "--stream", "-v", "h", "-o", "s.parquet"]) == 0
    assert ac.read_result("s.parquet").find() == ["h"]
    assert execute(["simulate", "ball.acm", "--stream"]) == 2
    assert execute(["simulate", "ball.acm", "-v", "h * 2, v", "-o", "-"]) == 0
    assert "time,h * 2,v" in capsys.readouterr().out


def test_the_examples_of_the_manual(tmp_path, monkeypatch):
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "docs" / "results.md").read_text(encoding="utf-8")
    names: dict[str, object] = {}
    for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        exec(block, names)
    assert names["power"].unit == "W"
    for name in ("rlc.png", "run.nc", "power.svg", "power.csv", "phase.png", "runs.png",
                 "large.nc", "few.parquet"):  # fmt: skip
        assert (tmp_path / name).stat().st_size > 500
