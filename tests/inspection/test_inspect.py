"""What ``acausal inspect`` and ``acausal check`` say about models of the lecture."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

from acausal.compiler import Stages, check_file, compile_class, inspect_file
from acausal.diagnostics import AcausalError
from acausal.inspection.inspect import STAGES, inspect
from acausal.inspection.summary import summary
from acausal.modeling.load import choose_model, load_file

EXAMPLES = Path(__file__).parents[2] / "examples"


@cache
def stages(name: str, model: str | None = None, **given: float) -> Stages:
    classes, _ = load_file(EXAMPLES / f"{name}.acm")
    return compile_class(choose_model(classes, model, name), given)


def section(text: str, title: str) -> list[str]:
    """Return the indented lines below a line that starts with a title."""
    lines = text.split("\n")
    (start,) = (k for k, line in enumerate(lines) if line.startswith(title))
    end = next(
        (k for k in range(start + 1, len(lines)) if not lines[k].startswith(" ")), len(lines)
    )
    return [line.strip() for line in lines[start + 1 : end]]


# --- S03: the simple network of the lecture --------------------------------------------------


def test_differential_and_algebraic_quantities_of_the_network():
    """The states are the current through the coil and the voltage of the capacitor."""
    text = inspect(stages("simple_network"), "structure")
    differential = [line.split()[0] for line in section(text, "differential variables: 2")]
    assert differential == ["c.v", "l.i"]
    assert section(text, "states: 2") == ["c.v", "l.i"]
    algebraic = " ".join(section(text, "algebraic variables given by those"))
    names = set(algebraic.split(", "))
    # The lecture's list: all other voltages and currents of the branches.
    assert {"u.v", "r1.v", "r2.v", "l.v", "u.i", "r1.i", "r2.i", "c.i"} <= names
    assert not names & {"c.v", "l.i"}
    assert len(names) == 36


def test_what_was_taken_out_of_the_network():
    text = inspect(stages("simple_network"), "eliminate")
    assert "38 equations became 2" in text
    assert any(re.fullmatch(r"r2\.i\s+= l\.i", line) for line in section(text, "equal up to"))
    assert section(text, "always zero: 4") == ["ground.p.v", "c.n.v", "l.n.v", "u.n.v"]
    definitions = section(text, "computed from others")
    assert any(line.startswith("c.i = c.C*der(c.v)") for line in definitions)
    assert any(line.startswith("u.i = ") and line.endswith("junction") for line in definitions)
    assert len(section(text, "what remains: 2")) == 2


def test_the_junctions_of_the_network():
    text = inspect(stages("simple_network"), "connect")
    assert sorted(sorted(line.split(", ")) for line in section(text, "junctions")) == [
        ["c.n", "ground.p", "l.n", "u.n"],
        ["c.p", "r1.n"],
        ["l.p", "r2.n"],
        ["r1.p", "r2.p", "u.p"],
    ]
    assert section(text, "1 island") == ["6 components: u, r1, r2, l, c, ground"]


def test_what_makes_the_ball_bounce():
    text = inspect(stages("bouncing_ball"), "flatten")
    assert "relation[1] = " in section(text, "relations, held between events")[0]
    said = section(text, "discrete equations, in order of evaluation")
    assert said[0].startswith("condition[1] = ")
    assert "pre(v)" in section(text, "reinit")[0]
    assert "1 when condition" in str(summary(stages("bouncing_ball")))
    assert "events" not in inspect(stages("simple_network"), "flatten")


def test_the_components_of_the_network():
    text = inspect(stages("simple_network"), "instantiate")
    assert 'r1: electrical.Resistor  "from node 1 to node 2"' in text
    assert "R = 100[Ohm]" in text and "C = 1e-5[F]" in text
    assert "switched off: heatPort" in text


def test_the_source_comes_back():
    text = inspect(stages("simple_network"), "parse")
    assert "connect(u.n, c.n, l.n, ground.p);" in text


# --- S28: index and differentiated equations -------------------------------------------------


@pytest.mark.parametrize(("model", "index"), [("Index1", 1), ("Index2", 2), ("Index3", 3)])
def test_the_index_of_hessenberg_systems(model, index):
    text = inspect(stages("hessenberg", model), "structure")
    assert re.search(rf"differentiation index {index}\b", text)
    assert ("differentiated equations" in text) == (index > 1)
    assert f"index {index}" in inspect(stages("hessenberg", model), "structure", latex=True)
    assert summary(stages("hessenberg", model)).index == index


def test_the_pendulum_tells_what_was_differentiated_and_why():
    text = inspect(stages("cartesian_pendulum"), "structure")
    assert "differentiation index 3, 2 degrees of freedom" in text
    said = section(text, "differentiated equations: 1")
    assert said[0].startswith("x^2 + y^2 = l^2") and "cartesian_pendulum.acm:" in said[0]
    assert said[1].startswith("twice differentiated, as it ties x, y,")
    assert said[2] == "d/dt: 2*x*vx + 2*y*vy = 0"
    assert said[3].startswith("d^2/dt^2: ") and "2*x*der(vx)" in said[3]
    assert "der(x) is vx" in text


def test_the_pendulum_as_mathematics():
    text = inspect(stages("cartesian_pendulum"), "structure", latex=True)
    assert "Differentiation index 3, 2 degrees of freedom." in text
    assert r"{x}^{2} + {y}^{2} &= {l}^{2}" in text
    assert r"2 \, x \, \mathit{vx} + 2 \, y \, \mathit{vy} &= 0" in text
    assert r"\dot{\mathit{vx}}" in text
    assert r"Algebraic variables} \(\lambda" in text


# --- chains and ladders ----------------------------------------------------------------------


def test_a_chain_is_a_few_lines_whatever_its_length():
    texts = [inspect(stages("pendulum_chain", "PendulumChain", n=n), "structure") for n in (20, 40)]
    assert "link[k].phi for k in 1:20" in texts[0]
    assert abs(len(texts[0].split("\n")) - len(texts[1].split("\n"))) == 0
    assert "twice differentiated, as it ties" in texts[0]


def test_islands_and_junctions_of_the_ladder():
    text = inspect(stages("ladder", N=1000), "connect")
    assert "rail.p, section[k].bias for k in 1:1000" in text
    assert "section[k].right (from inside)   for k in 1:1000" in text
    (island,) = section(text, "1 island")
    assert island.startswith("6004 components: ")
    assert len(text) < 2000


def test_blocks_of_the_ladder_are_grouped():
    text = inspect(stages("ladder", N=1000), "blocks")
    assert "2001 blocks: 2001 of size 1" in text
    assert re.search(r"\d+-\d+ +der\(section\[k.*\]\.l\.i\) +from .* for k in 1:999", text)
    assert text.count("\n") < 12


def test_blocks_of_the_pendulum_are_torn():
    text = inspect(stages("cartesian_pendulum"), "blocks")
    assert "1 of size 3" in text
    assert "3 equations together" in text
    assert "torn by" in text


def test_the_blocks_can_be_solved_in_their_order():
    """Each block's unknown stands in its equation, and in none before."""
    lines = section(inspect(stages("junction"), "blocks"), "in the order of solution")
    assert len(lines) == 4
    solved: list[str] = []
    for line in lines:
        match = re.match(r"\d+ +(\S+) +from (.*)", line)
        assert match, line
        assert match[1] in match[2]
        assert not any(later in match[2] for later in solved if later == match[1])
        solved.append(match[1])
    assert len(set(solved)) == 4


# --- every stage of every example ------------------------------------------------------------

FILES = sorted(path.stem for path in EXAMPLES.glob("*.acm"))


@pytest.mark.parametrize("name", FILES)
def test_every_stage_of_every_example_has_something_to_show(name):
    text = inspect(stages(name))
    for stage in STAGES:
        assert re.search(rf"^{stage}: ", text, re.MULTILINE), stage
    assert "Label(" not in text and "slot(" not in text and "Expr" not in text
    assert max(len(line) for line in text.split("\n")) < 2000


@pytest.mark.parametrize("name", FILES)
def test_latex_is_well_formed(name):
    text = inspect(stages(name), latex=True)
    assert text.startswith(r"\documentclass") and text.endswith("\\end{document}\n")
    for environment in ("document", "align*", "cases"):
        assert text.count(rf"\begin{{{environment}}}") == text.count(rf"\end{{{environment}}}")
    assert text.count(r"\left") == text.count(r"\right")
    plain = text.replace(r"\{", "").replace(r"\}", "")
    assert plain.count("{") == plain.count("}")
    for block in re.findall(r"\\begin{align\*}(.*?)\\end{align\*}", text, re.DOTALL):
        for line in block.strip().split("\\\\\n"):
            inside, nested = line, 1
            while nested:  # innermost first
                inside, nested = re.subn(
                    r"\\begin{cases}(?:(?!\\begin{cases}).)*?\\end{cases}", "", inside,
                    flags=re.DOTALL,
                )  # fmt: skip
            assert inside.count("&") == 1, line


def test_the_report_is_the_same_every_time():
    classes, _ = load_file(EXAMPLES / "ladder.acm")
    definition = choose_model(classes, None, "")
    assert inspect(compile_class(definition)) == inspect(compile_class(definition))


def test_stages_that_were_not_reached():
    text = inspect(Stages(), "flatten")
    assert "did not come to stage flatten" in text
    with pytest.raises(ValueError, match="no stage"):
        inspect(Stages(), "everything")


def test_stages_without_equations_say_so_in_latex():
    assert "% stage parse has no equations" in inspect(stages("rlc"), "parse", latex=True)


# --- check -----------------------------------------------------------------------------------


def test_the_summary_counts():
    found = summary(stages("simple_network"))
    assert (found.components, found.cuts, found.junctions) == (6, 11, 4)
    assert (found.variables, found.equations, found.remaining) == (38, 38, 2)
    assert (found.states, found.index, found.differentiated) == (2, 1, 0)
    text = str(found)
    assert text.startswith('SimpleNetwork "S03')
    assert "2 states, differentiation index 1" in text


def test_the_summary_of_many_instances():
    found = summary(stages("ladder", N=1000))
    assert found.components == 1000 * 7 + 6
    assert found.cuts == 1000 * 14 + 9
    assert found.states == 2000
    assert found.families < 20


def test_warnings_are_part_of_the_summary(tmp_path):
    path = tmp_path / "m.acm"
    path.write_text("model M parameter Real a(start = 4); Real x = a; end M;")
    assert "N120" in str(check_file(path))


def test_files_are_inspected_by_the_compiler():
    path = EXAMPLES / "rlc.acm"
    assert inspect_file(path, stage="parse").startswith("parse: RLC\n==========\nmodel RLC")
    assert "R = 7[Ohm]" in inspect_file(path, stage="instantiate", parameters={"r.R": 7})


def test_a_stage_can_be_shown_though_a_later_one_fails(tmp_path):
    path = tmp_path / "m.acm"
    path.write_text(
        "import electrical.*; model M ConstantVoltage v; Resistor r; "
        "equation connect(v.p, r.p); connect(v.n, r.n); end M;"
    )
    text = inspect_file(path, stage="connect")
    assert "v.p, r.p" in text or "r.p, v.p" in text
    for stage in ("structure", "all"):
        with pytest.raises(AcausalError) as caught:
            inspect_file(path, stage=stage)
        assert caught.value.diagnostics[0].code == "S103"
