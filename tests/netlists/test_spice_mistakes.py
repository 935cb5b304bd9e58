"""What netlists get wrong is refused with a code, its line and a way out."""

from __future__ import annotations

import pytest

import acausal as ac
from acausal.netlists.spice.reader import NetlistWarning

GOOD = "V1 a 0 1\nR1 a 0 1k\n"

MISTAKES = {
    "unknown letter": ("S1 a 0 b 0 sw", "P041", "letter S"),
    "behavioural source": ("B1 a 0 V=1", "P041", "letter B"),
    "incomplete": ("R2 a", "P040", "R1 a b 1k"),
    "no value": ("R2 a b", "P040", "R1 a b 1k"),
    "bad number": ("R2 a b 1+k", "P042", "1+k is no number"),
    "unknown parameter": (".param rlo=1\nR2 a b {rho}", "N122", "did you mean rlo?"),
    "bare unknown word": ("R2 a b model1", "N122", "no parameter model1"),
    "malformed expression": ("R2 a b {1+}", "P042", "incomplete"),
    "unclosed": ("R2 a b {1+2", "P040", "not closed"),
    "function": ("R2 a b {sqr(2)}", "P042", "did you mean sqrt?"),
    "not finite": (".param x=0\nR2 a b {1/x}", "P042", "no finite number"),
    "circular parameters": (".param x={y} y={x}\nR2 a b {x}", "P042", "its own value"),
    "twice": ("r1 a b 1", "N105", "first here"),
    "option": ("R2 a b 1 tc3=1", "N103", "did you mean tc1"),
    "wave": ("V2 b 0 PULS(0 1)", "P041", "did you mean PULSE?"),
    "pwl": ("V2 b 0 PWL(0 1 2)", "P040", "pairs"),
    "pwl back": ("V2 b 0 PWL(0 1 2 3 1 4)", "P040", "go back"),
    "phase": ("V2 b 0 SIN(0 1 50 0 0 90)", "P041", "more than 5"),
    "no model": (".model d1 D(IS=1f)\nD2 a 0 d2", "N122", "did you mean d1?"),
    "model of another kind": (".model sw1 SW(RON=1)\nD2 a 0 sw1", "P041", "kind SW"),
    "model parameter": (".model d1 D(ISS=1f)\nD2 a 0 d1", "N103", "did you mean IS?"),
    "level": (".model m1 NMOS(LEVEL=3)\nM2 a a 0 0 m1", "P041", "level 3"),
    "no subcircuit": ("X1 a 0 amp", "N122", "no .subckt amp"),
    "number of nodes": (".subckt s a b\nR1 a b 1\n.ends\nX1 a s", "P040", "2 nodes"),
    "subcircuit parameter": (".subckt s a g=1\nR1 a 0 {g}\n.ends\nX1 a s gg=2", "N122", "gg"),
    "in itself": (".subckt s a\nX1 a s\n.ends\nX1 a s", "N106", "contains itself"),
    "open subcircuit": (".subckt s a\nR9 a 0 1", "P040", "no .ends"),
    "ends": (".ends", "P040", "closes nothing"),
    "card": (".trans 1 2", "P041", "did you mean .tran?"),
    "tran": (".tran 1u", "P040", ".tran step stop"),
    "coupling": ("L1 a 0 1\nK1 L1 L2 0.5", "N122", "no inductor L2"),
    "coefficient": ("L1 a 0 1\nL2 a 0 1\nK1 L1 L2 1.5", "P042", "between -1 and 1"),
    "control": ("F1 a 0 V9 2", "N122", "did you mean V1?"),
    "poly": ("E1 b 0 POLY(2) a 0 a 0 1 2", "P041", "POLY(1) is"),
    "long": ("R2 a b {" + "1+" * 300 + "1}", "P042", "too long"),
    "value": ("E1 b 0 VALUE={v(a)*2}", "P041", "VALUE"),
    "table": ("E1 b 0 TABLE {v(a)} = (0,0)", "P041", "TABLE"),
    "start of a node": (".ic v(a)=1", "P041", "which no capacitor holds"),
    "include": (".include nothere.lib", "F101", "nothere.lib"),
    "absolute include": (".include /etc/hosts", "F107", "relative"),
    "own include": (".include test.cir", "F107", "includes itself"),
    "deep": ("R2 a b {" + "(" * 100 + "1" + ")" * 100 + "}", "P042", "too deep"),
}  # fmt: skip


@pytest.fixture
def read(tmp_path):
    def read(cards):
        (tmp_path / "test.cir").write_text(cards, encoding="utf-8")
        return ac.read_spice(tmp_path / "test.cir")

    return read


@pytest.mark.parametrize("case", MISTAKES)
def test_mistakes(read, case):
    cards, code, text = MISTAKES[case]
    with pytest.raises(ac.AcausalError) as caught:
        read(f"title\n{GOOD}{cards}\n")
    (found,) = caught.value.diagnostics
    assert found.code == code
    assert found.span is not None
    assert found.span.source.endswith("test.cir")
    assert found.span.line >= 4 or case in ("circular parameters",)
    assert found.help
    assert text in str(caught.value)


def test_no_ground(read):
    with pytest.raises(ac.AcausalError, match="C110"):
        read("title\nV1 a b 1\nR1 a b 1\n")


def test_nothing_in_it(read):
    with pytest.raises(ac.AcausalError, match="P040"):
        read("title\n")


@pytest.mark.parametrize(
    ("title", "cards", "text"),
    [
        ("title", ".ac dec 10 1 1k", ".ac is not carried out"),
        ("title", ".control\nrun\nplot v(a)\n.endc", "commands between .control"),
        ("title", ".options temp=27 reltol=1e-3 wurst=3", "the option wurst"),
        ("title", "D1 a 0 d1\n.model d1 D(IS=1f ISR=1p)", "ISR of d1"),
        ("R9 a 0 5k", "", "the first line is the title"),
        (
            "title",
            ".subckt s a\nQ1 a a 0 q\n.ends\n.model q NPN\nX1 a s\n.tran 1u 1m uic",
            "UIC has no effect",
        ),
    ],
)
def test_what_has_no_effect_is_told(read, title, cards, text):
    with pytest.warns(NetlistWarning, match="P043") as caught:
        read(f"{title}\n{GOOD}{cards}\n")
    assert len(caught) == 1
    assert text in str(caught[0].message)


def test_mistakes_of_the_circuit_are_at_its_lines(read):
    """A node that only capacitors hold has no voltage; the compiler names the elements' lines."""
    model = read("title\nV1 a 0 1\nR1 a 0 1\nI1 0 b 1m\nI2 b 0 2m\n.tran 1 2\n")
    with pytest.raises(ac.AcausalError) as caught:
        model.compile()
    places = [s.source for d in caught.value.diagnostics if (s := d.span)]
    places += [x.span.source for d in caught.value.diagnostics for x in d.labels]
    assert any(p.endswith("test.cir") for p in places)
