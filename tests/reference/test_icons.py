"""Icon annotations become drawings; what is wrong with them is said with its line."""

from __future__ import annotations

import pytest

from acausal.modeling.classes import ClassDef
from acausal.modeling.load import library_class, load_text
from acausal.reference.graphics import Color, Ellipse, Line, Placed, Polygon, Rectangle, Text
from acausal.reference.icons import check_icon, icon
from acausal.reference.symbols import symbol


def made(text: str, name: str = "A") -> ClassDef:
    return load_text(text)[0][name]


def drawn(graphics: str) -> ClassDef:
    return made(f"model A\n  annotation(Icon(graphics = {{\n{graphics}}}));\nend A;\n")


def test_primitives_are_read() -> None:
    found = icon(
        drawn("""
    Line(points = {{-100, 0}, {-60, 20}}, color = {255, 0, 0}, thickness = 0.5,
         pattern = LinePattern.Dash, smooth = Smooth.Bezier, arrow = {Arrow.None, Arrow.Filled}),
    Rectangle(extent = {{-60, 30}, {60, -30}}, fillPattern = FillPattern.Solid, radius = 5),
    Ellipse(extent = {{0, 0}, {10, 10}}, startAngle = 0, endAngle = 90),
    Polygon(points = {{0, 0}, {1, 0}, {0, 1}}),
    Text(extent = {{-90, 80}, {90, 45}}, textString = "M", textStyle = {TextStyle.Bold}),
    Line(points = {{0, 0}, {1, 0}}, origin = {3, 4}, rotation = 90),
    Line(points = {{0, 0}, {9, 9}}, visible = false)
    """)
    ).graphics
    assert [type(g) for g in found] == [Line, Rectangle, Ellipse, Polygon, Text, Placed]
    line, rectangle, arc = found[:3]
    assert isinstance(line, Line)
    assert line.points == ((-100, 0), (-60, 20))
    assert line.pen.color == Color(255, 0, 0)
    assert line.pen.width == 5.0
    assert (line.pen.pattern, line.smooth, line.arrows) == ("Dash", True, ("None", "Filled"))
    assert isinstance(rectangle, Rectangle)
    assert rectangle.extent == (-60, -30, 60, 30)
    assert rectangle.pen.color is None
    assert isinstance(arc, Ellipse)
    assert arc.closure == "None"


def test_drawings_of_bases_come_first() -> None:
    text = """
    partial model Base annotation(Icon(graphics = {Line(points = {{0, 0}, {1, 1}})})); end Base;
    model A extends Base;
      annotation(Icon(graphics = {Line(points = {{2, 2}, {3, 3}})})); end A;
    model B extends A; extends Base; end B;
    """
    both = [((0, 0), (1, 1)), ((2, 2), (3, 3))]
    assert [g.points for g in icon(made(text)).graphics if isinstance(g, Line)] == both
    # A base that comes twice is drawn once.
    assert [g.points for g in icon(made(text, "B")).graphics if isinstance(g, Line)] == both


@pytest.mark.parametrize(
    ("code", "graphics"),
    [
        ("D101", "Lne(points = {{0, 0}, {1, 1}})"),
        ("D101", '"text"'),
        ("D102", "Line(color = {0, 0, 0})"),
        ("D102", "Line(points = {{0, 0}, {1, 1}}, colour = {0, 0, 0})"),
        ("D102", "Line({{0, 0}, {1, 1}}, points = {{0, 0}, {1, 1}})"),
        ("D103", "Line(points = {{0, 0}})"),
        ("D103", "Line(points = {{0, 0}, {1}})"),
        ("D103", "Rectangle(extent = {{0, 0}, {1, x}})"),
        ("D103", "Rectangle(extent = {{0, 0}, {1, 1}}, fillColor = {0, 0, 300})"),
        ("D103", "Rectangle(extent = {{0, 0}, {1, 1}}, fillPattern = FillPattern.Full)"),
        ("D103", "Text(extent = {{0, 0}, {1, 1}})"),
        ("D103", "Line(points = {{0, 0}, {1, 1}}, arrow = Arrow.Filled)"),
        ("D104", "Line(points = {{0, 0}, {400, 0}})"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(code: str, graphics: str) -> None:
    found = check_icon(drawn(graphics))
    assert [d.code for d in found] == [code]
    assert found[0].span is not None
    assert found[0].span.line == (3 if code != "D104" else 2)
    # The rest is drawn, and nothing fails.
    symbol(drawn(f"{graphics}, Line(points = {{{{5, 5}}, {{6, 6}}}})"))


def test_mistakes_get_the_right_word() -> None:
    assert check_icon(drawn("Rectangel(extent = {{0, 0}, {1, 1}})"))[0].help == "use Rectangle"
    wrong = made("model A annotation(Icon(grafics = {1})); end A;")
    assert [d.code for d in check_icon(wrong)] == ["D102"]


PORTS = """
connector Pin across Real v; through Real i; end Pin;
connector In = input Real; connector Out = output Real;
model A
  Pin p "left", n "right";
  Pin q annotation(Placement(transformation(extent = {{-10, 90}, {10, 110}})));
  Pin r annotation(Placement(transformation(origin = {20, -30}, extent = {{-5, -5}, {5, 5}})));
  In u; Out y;
protected
  Pin hidden;
end A;
model Block In u1, u2; Out y; end Block;
model Wide Block block_; Pin p1, p2, n1, n2; annotation(Icon(
  coordinateSystem(extent = {{-200, -100}, {200, 100}}),
  graphics = {Line(points = {{0, 0}, {1, 1}})}));
end Wide;
"""


def test_ports_have_places() -> None:
    found = symbol(made(PORTS))
    assert found.ports == {
        "p": (-100, 0),
        "n": (100, 0),
        "q": (0, 100),
        "r": (20, -30),
        "u": (0, 100),
        "y": (0, -100),
    }
    assert not found.drawn
    assert symbol(made(PORTS, "Block")).ports == {
        "u1": (-100, 60),
        "u2": (-100, -60),
        "y": (100, 0),
    }
    wide = symbol(made(PORTS, "Wide"))
    assert wide.ports == {"p1": (-200, 50), "p2": (-200, -50), "n1": (200, 50), "n2": (200, -50)}


def test_fields_shapes_and_conditions() -> None:
    resistor = library_class("electrical.Resistor")
    assert isinstance(resistor, ClassDef)
    cuts = {c.name: c for c in symbol(resistor).cuts}
    assert {n: c.field for n, c in cuts.items()} == {
        "p": "electrical", "n": "electrical", "heatPort": "thermal",
    }  # fmt: skip
    assert cuts["p"].filled and not cuts["n"].filled
    assert cuts["heatPort"].conditional
    gain = library_class("blocks.Gain")
    assert isinstance(gain, ClassDef)
    assert [(c.shape, c.field) for c in symbol(gain).cuts] == [("in", "Real"), ("out", "Real")]


def test_misplaced_ports_are_told() -> None:
    text = """connector P across Real v; through Real i; end P;
    model A P p annotation(Placement(transformation(extent = {{0, 0}, 1}))); end A;"""
    assert [d.code for d in check_icon(made(text))] == ["D103"]
