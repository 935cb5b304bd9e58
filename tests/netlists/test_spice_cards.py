"""Cards of netlists one by one: numbers, sources, defaults, start values, hierarchy."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

import acausal as ac
from acausal.diagnostics import Span
from acausal.netlists.spice.expressions import evaluate, number, parse

SPAN = Span("<test>", 1, 1, 1, 1)


@pytest.fixture
def read(tmp_path):
    def read(cards, title="test", **options):
        (tmp_path / "test.cir").write_text(f"{title}\n{cards}\n", encoding="utf-8")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return ac.read_spice(tmp_path / "test.cir", **options)

    return read


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *[("1", 1.0), ("-2.5", -2.5), (".5", 0.5), ("3.", 3.0), ("1e3", 1e3), ("1E-3k", 1.0)],
        *[("1MEG", 1e6), ("1meg", 1e6), ("1M", 1e-3), ("1m", 1e-3), ("2T", 2e12), ("3g", 3e9)],
        *[("4.7kOhm", 4700.0), ("10uF", 1e-5), ("10µF", 1e-5), ("5n", 5e-9), ("7pF", 7e-12)],
        *[("3fF", 3e-15), ("1mil", 25.4e-6), ("5V", 5.0), ("1a", 1e-18), ("12Hz", 12.0)],
        *[("x", None), ("1+2", None), ("", None), ("1e", 1.0), ("4k7", None)],
    ],
)
def test_numbers(text, value):
    assert number(text) == value


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1+2*3", 7),
        ("(1+2)*3", 9),
        ("2**3**2", 512),
        ("2^3", 8),
        ("-2^2", -4),
        ("2*-3", -6),
        ("1k/4", 250),
        ("8/4/2", 1),
        ("5-3-1", 1),
        ("1 > 2 ? 10 : 20", 20),
        ("!0 && 1 || 0", 1),
        ("sqrt(16) + abs(-2)", 6),
        ("max(1, min(5, 3))", 3),
        ("ln(exp(2))", 2),
        ("pwr(-2, 2)", -4),
        ("sgn(-3)*int(-2.7)", 2),
        ("if(1 <= 1, 2, 3)", 2),
        ("atan2(0, -1) - pi", 0),
        ("log10(1MEG)", 6),
    ],
)
def test_expressions(text, value):
    found = evaluate(parse(text, SPAN), lambda n: {"pi": math.pi}[n.name])
    assert found == pytest.approx(value, abs=1e-15)


def test_expressions_become_those_of_the_model(read):
    """The same expression as a number and as one of the model's parameters."""
    texts = [
        "2*a - b/3",
        "a**2",
        "a > 2 ? 10 : b",
        "max(a, b)",
        "sqrt(a + 6)",
        "-a",
        "pow(a, 2)",
        "(a > 2 && b > 100) ? 1 : 2",
        "abs(b - 50)",
        "!(a > 2) ? 1 : 5",
        "int(a/2)",
    ]
    cards = "\n".join(f"V{k} n{k} 0 {{{t}}}\nR{k} n{k} 0 1" for k, t in enumerate(texts))
    compiled = read(f".param a=3 b=12\n{cards}").compile()
    for a, b in ((3.0, 12.0), (1.5, 200.0)):
        result = compiled.simulate(stop_time=1, parameters={"a": a, "b": b}, points=2)
        for k, text in enumerate(texts):
            expected = evaluate(parse(text, SPAN), lambda n, a=a, b=b: {"a": a, "b": b}[n.name])
            assert result[f"v_n{k}"].values[0] == pytest.approx(expected)


def test_lines_comments_and_capitals(read):
    model = read(
        """* a comment
V1 IN 0 dc 10 ; behind a line
r1 in Out
* between a line and its continuation
+ 1K $ another one
R2 oUT gnd 3k // and another
.print tran v(out)
.op
.end
nonsense behind the end"""
    )
    result = model.simulate(stop_time=1, points=2)
    assert result["v_Out"].values[0] == pytest.approx(7.5)
    assert result["r1.i"].values[0] == pytest.approx(2.5e-3)


def test_source_defaults(read):
    """As in ngspice: rise times are the step, the frequency of SIN is one period of the run."""
    text = read(
        "V1 a 0 PULSE(0 1)\nV2 b 0 SIN(0 1)\nV3 c 0 EXP(0 1)\nI4 0 d\nV5 e 0 PWL(1 2)\n"
        "V6 f 0 3 AC 1 90\nV7 g 0 DC=4\nV8 h 0 AC 1 SIN 1 2 3 \n"
        "R1 a b 1\nR2 c d 1\nR3 d e 1\nR4 f g 1\nR5 h 0 1\n.tran 1m 0.5"
    ).to_acm()
    assert "V_pulse V1(V1 = 0, V2 = 1, TR = 0.001, TF = 0.001)" in text
    assert "V_sin V2(VO = 0, VA = 1, FREQ = 2.0)" in text
    assert "V_exp V3(V1 = 0, V2 = 1, TD1 = 0.001, TAU1 = 0.001, TAU2 = 0.001, TD2 = 0.002)" in text
    assert "I_constant I4(I = 0)" in text
    assert "V_pwl V5(table = " in text
    assert "V_constant V6(V = 3)" in text
    assert "V_constant V7(V = 4)" in text
    assert "V_sin V8(VO = 1, VA = 2, FREQ = 3)" in text


def test_coupling_of_three_coils_has_the_sign_of_spice(read):
    """Energy and induced voltages: marks are at the first nodes."""
    cards = """V1 p 0 SIN(0 1 1k)
R1 p a 1
L1 a 0 1m
L2 b 0 4m
L3 0 c 1m
{}
R2 b 0 1MEG
R3 c 0 1MEG
.tran 10u 1m"""
    together = read(cards.format("K1 L1 L2 L3 0.5")).simulate(tolerance=1e-8)
    pairs = cards.format("K1 L1 L2 0.5\nK2 L1 L3 0.5\nK3 L2 L3 0.5")
    apart = read(pairs).simulate(tolerance=1e-8)
    for node in "abc":
        assert together[f"v_{node}"].values == pytest.approx(apart[f"v_{node}"].values, abs=1e-6)
    a, b, c = (together[f"v_{n}"].values for n in "abc")
    assert b == pytest.approx(a, abs=1e-4)  # k*sqrt(L2/L1) = 1
    assert c == pytest.approx(-0.5 * a, abs=1e-4)


@pytest.mark.parametrize("uic", ["", "uic"])
def test_start_values(read, uic):
    """UIC: elements start at ic. Otherwise at the operating point, where .ic holds the nodes."""
    cards = f"""V1 a 0 10
R1 a b 1k
C1 b 0 1u ic=2
R2 b c 1k
C2 c 0 1u
.ic v(c)=4
.tran 10u 1m {uic}"""
    first = {n: v.values[0] for n, v in ((n, read_v) for n, read_v in _voltages(read(cards)))}
    assert first["c"] == pytest.approx(4)
    assert first["b"] == pytest.approx(2 if uic else 7)


def _voltages(model):
    result = model.simulate()
    return [(n, result[f"v_{n}"]) for n in "bc"]


def test_global_nodes_and_nested_subcircuits(read):
    model = read(
        """.global vdd
.subckt outer x
.subckt inner y
R1 vdd y 1k
.ends
X1 x inner
X2 x inner
.ends
V1 vdd 0 6
Xa out outer
R9 out 0 1k"""
    )
    assert model.simulate(stop_time=1, points=2)["v_out"].values[0] == pytest.approx(4)


def test_names_that_need_a_change(read):
    model = read("V1 1 0 5\nRin+ 1 in 1k\nR.2 in 0 1k\nCopy in 0 1u", name="names")
    text = model.to_acm()
    for name in ("Rinp", "R_2", "v_1", "v_in", "Copy"):
        assert f" {name}" in text
    assert model.simulate(stop_time=1)["v_in"].values[-1] == pytest.approx(2.5)


def test_multipliers_and_temperature(read):
    model = read(
        ".temp 127\nV1 a 0 1\nR1 a b 1k m=2\nR2 b 0 500 tc1=1m\nC1 b 0 1u m=3\nL1 b c 1m m=2\n"
        "R3 c 0 1"
    )
    text = model.to_acm()
    assert "R1(R = 500.0)" in text
    assert "R2(R = 550.0)" in text
    assert "C1(C = 3e-06)" in text
    assert "L1(L = 0.0005)" in text


def test_a_large_netlist(read):
    count = 5000
    cards = "\n".join(f"R{k} {k} {k + 1} 1" for k in range(count))
    model = read(f"V1 in 0 1\n{cards}\nRa in 5000 1")
    result = model.compile().simulate(stop_time=1, points=2, variables=["v_2500"])
    assert result["v_2500"].values[0] == pytest.approx(2500 / 5001)


def test_diode_card_as_class(read):
    text = read(
        "V1 a 0 1\nD1 a b dx 2\nD2 b 0 dx OFF\n.model DX D (IS=1e-12\n+ N=1.2 KF=1)"
    ).to_acm()
    assert "model DX" in text
    assert "extends electrical.spice.D_DIODE(modelcarddiode(IS = 1e-12, N = 1.2));" in text
    assert "DX D1(AREA = 2);" in text
    assert "DX D2;" in text


def test_model_card_with_parameters_stays_symbolic(read):
    model = read(".param sat=1e-12\nI1 0 a 1m\nD1 a 0 dx\n.model dx D(IS={2*sat} N=1)\n")
    compiled = model.compile()
    voltages = [
        compiled.simulate(stop_time=1, points=2, parameters={"sat": s})["v_a"].values[0]
        for s in (1e-12, 1e-11)
    ]
    vt = 1.380649e-23 * 300.15 / 1.602176634e-19
    assert voltages[0] - voltages[1] == pytest.approx(vt * np.log(10), rel=1e-5)
