"""Expressions and equations as they are written, in mathematics."""

from __future__ import annotations

import pytest

from acausal.modeling.load import load_text
from acausal.reference.equations import equation_lines, limits, statement_lines
from acausal.reference.latex import latex_expression
from acausal.reference.mathml import mathml
from acausal.syntax import tree


def expression(text: str) -> tree.Expression:
    definition = load_text(f"model A equation y = {text}; end A;")[0]["A"]
    equation = definition.tree.equations[0]
    assert isinstance(equation, tree.SimpleEquation)
    return equation.right


@pytest.mark.parametrize(
    ("text", "latex"),
    [
        ("p.v - n.v", r"v_{\mathrm{p}} - v_{\mathrm{n}}"),
        ("C*der(v)", r"C \, \dot{v}"),
        ("der(der(phi_rel))", r"\ddot{\varphi}_{\mathrm{rel}}"),
        ("der(x*y)", r"\frac{\mathrm{d}}{\mathrm{d}t}\left(x \, y\right)"),
        ("a - (b - c)", r"a - \left(b - c\right)"),
        ("(a + b)*c", r"\left(a + b\right) \, c"),
        ("a/b*c", r"\frac{a}{b} \, c"),
        ("-a^2", r"-{a}^{2}"),
        ("(a + b)^(1/2)", r"{\left(a + b\right)}^{\frac{1}{2}}"),
        ("sin(x)^2", r"{\left(\sin\left(x\right)\right)}^{2}"),
        ("x*2", r"x \cdot 2"),
        ("1e-3", "0.001"),
        ("2e-7", r"2 \cdot 10^{-7}"),
        ("10[kOhm]", r"10\,\text{kΩ}"),
        ("sqrt(abs(x))", r"\sqrt{\left|x\right|}"),
        ("exp(-t)", "e^{-t}"),
        ("noEvent(smooth(1, x))", "x"),
        ("homotopy(actual = x, simplified = 0)", "x"),
        ("sum(L[k]*i[k] for k in 1:n)", r"\sum_{k = 1}^{n} L_{k} \, i_{k}"),
        ("product(x)", r"\prod x"),
        ("{a, b}", r"\begin{pmatrix}a \\ b\end{pmatrix}"),
        ("[a, b; c, d]", r"\begin{pmatrix}a & b \\ c & d\end{pmatrix}"),
        ("{{a, b}, {c, d}}", r"\begin{pmatrix}a & b \\ c & d\end{pmatrix}"),
        ("transpose(R)*v", r"{R}^{\mathsf{T}} \, v"),
        ("cross(w, r)", r"w \times r"),
        ("delay(v, T)", r"v\left(t - T\right)"),
        ("a and not b or c", r"a \land \lnot b \lor c"),
        ("constants.pi*time", r"\pi \, t"),
        ("Init.NoInit", r"\mathrm{Init.NoInit}"),
        ("f.g(x, n = 2)", r"\operatorname{g}\left(x, n = 2\right)"),
        (
            "if x > 0 then 1 elseif x < 0 then -1 else 0",
            r"\begin{cases}1 & \text{if } x > 0 \\ -1 & \text{if } x < 0 \\ "
            r"0 & \text{otherwise}\end{cases}",
        ),
    ],
)
def test_expressions(text: str, latex: str) -> None:
    assert latex_expression(expression(text)) == latex


def test_known_components_decide_what_is_a_constant() -> None:
    assert latex_expression(expression("C.i"), {"C"}) == r"i_{\mathrm{C}}"
    assert latex_expression(expression("lib.x"), {"C"}) == r"\mathrm{lib.x}"
    assert latex_expression(expression("time"), {"t"}) == r"\mathit{time}"


def test_depth_does_not_matter() -> None:
    deep = "+".join(["x"] * 3000)
    assert latex_expression(expression(deep)).count("x") == 3000


MODEL = """
model A
equation
  off = s < 0 "which way";
  connect(a, b);
  for k in 1:n loop
    x[k] = 0;
  end for;
  if on then
    v = 0;
  else
    i = 0;
  end if;
  if bad then
    assert(x > 0, "inside");
  end if;
  when v > 1 then
    reinit(v, 0);
  elsewhen i > 1 then
    n = pre(n) + 1;
  end when;
  assert(T > 0, "too cold", AssertionLevel.warning);
end A;
function f input Real x; output Real y; algorithm
  y := 0;
  for k in 1:3 loop
    if x > 0 then y := y + k; else break; end if;
  end for;
  while y > 1 loop y := y/2; end while;
end f;
"""


def test_equations_are_lines() -> None:
    definition = load_text(MODEL)[0]["A"]
    lines = equation_lines(definition.tree.equations)
    shown = [(line.depth, line.words, line.latex or line.code) for line in lines]
    assert shown == [
        (0, "", r"\mathit{off} = \left(s < 0\right)"),
        (0, "", "connect(a, b)"),
        (0, "for", r"k = 1, \dots, n"),
        (1, "", "x_{k} = 0"),
        (0, "if", r"\mathit{on}"),
        (1, "", "v = 0"),
        (0, "else", ""),
        (1, "", "i = 0"),
        (0, "when", "v > 1"),
        (1, "", r"v \leftarrow 0"),
        (0, "else when", "i > 1"),
        (1, "", r"n = \operatorname{pre}\left(n\right) + 1"),
    ]
    assert lines[0].description == "which way"
    found = limits(definition.tree.equations)
    assert [(x.latex, x.message, x.warning) for x in found] == [
        ("x > 0", "inside", False),
        ("T > 0", "too cold", True),
    ]


def test_algorithms_are_lines() -> None:
    lines = statement_lines(load_text(MODEL)[0]["f"].tree.algorithms[0])
    assert [(line.depth, line.words or line.latex) for line in lines] == [
        (0, "y := 0"),
        (0, "for"),
        (1, "if"),
        (2, "y := y + k"),
        (1, "else"),
        (2, "leave the loop"),
        (0, "while"),
        (1, r"y := \frac{y}{2}"),
    ]


def test_mathml_is_short_and_keeps_words_together() -> None:
    found = mathml(r"\mathit{LossPower} = v_{\mathrm{flange\_a}} \, i")
    assert "<mi class=v>LossPower</mi>" in found
    assert "<mi>flange_a</mi>" in found
    assert "mathvariant" not in found
    assert "<mo form=prefix>−</mo>" in mathml("a = -b")
    assert "form=prefix" not in mathml("a = c - b")
    assert mathml(r"\left|\frac{a}{b}\right|").count("stretchy=true") == 2
    assert "&lt;" in mathml("a < b")
