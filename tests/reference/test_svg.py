"""Symbols as SVG: well formed, the right way up, readable where the browser is."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

from acausal.reference.graphics import (
    Color,
    Ellipse,
    Fill,
    Graphic,
    Line,
    Pen,
    Placed,
    Polygon,
    Port,
    Rectangle,
    Symbol,
    Text,
)
from acausal.reference.svg import content, svg

RED = Color(200, 0, 10)


def written(*graphics: Graphic) -> str:
    text = content(Symbol("A", graphics, {}, ()))
    ElementTree.fromstring(f"<svg>{text}</svg>")
    return text


def test_up_is_up() -> None:
    assert 'd="M0 0L10 -20"' in written(Line(((0, 0), (10, 20))))
    rectangle = written(Rectangle((-60, -30, 60, 40), radius=3))
    assert 'x="-60" y="-40" width="120" height="70" rx="3"' in rectangle


def test_colours_and_lines() -> None:
    assert 'stroke="currentColor" stroke-width="2.5"' in written(Line(((0, 0), (1, 1))))
    text = written(Line(((0, 0), (1, 1)), Pen(RED, 5, "Dash")))
    assert 'stroke="#c8000a" stroke-width="5" stroke-dasharray' in text
    assert "stroke=" not in written(Polygon(((0, 0), (1, 1), (0, 1)), Pen(pattern="None"))).replace(
        "stroke-line", ""
    )
    assert 'fill="#c8000a"' in written(Rectangle((0, 0, 1, 1), fill=Fill(RED, "Solid")))


def test_hatchings_are_defined_where_they_are_used() -> None:
    hatched = Symbol("A", (Rectangle((0, 0, 9, 9), fill=Fill(None, "Forward")),), {}, ())
    assert 'id="hatch-Forward"' in svg(hatched)
    assert 'fill="url(#hatch-Forward)"' in svg(hatched)
    assert "defs" not in svg(Symbol("A", (Rectangle((0, 0, 9, 9)),), {}, ()))


def test_arcs_go_the_right_way() -> None:
    # From the right end upwards to the top: counter-clockwise.
    arc = Ellipse((-10, -10, 10, 10), start=0, end=90, closure="None")
    assert 'd="M10 0A10 10 0 0 0 0 -10"' in written(arc)
    assert 'd="M0 0L10 0A10 10 0 0 0 0 -10Z"' in written(
        Ellipse((-10, -10, 10, 10), start=0, end=90, closure="Radial")
    )
    assert "<circle" in written(Ellipse((-10, -10, 10, 10)))


def test_smooth_lines_are_splines_through_the_middles() -> None:
    line = Line(((0, 0), (10, 10), (20, 0), (30, 10)), smooth=True)
    assert 'd="M0 0L5 -5Q10 -10 15 -5Q20 0 25 -5L30 -10"' in written(line)


def test_arrow_heads_end_at_the_tip() -> None:
    text = written(Line(((0, 0), (50, 0)), arrows=("None", "Filled")))
    assert text.count("<path") == 2
    assert 'd="M50 0L' in text


def test_texts() -> None:
    text = written(Text((-50, -10, 50, 10), "<M & %d>"))
    assert "&lt;M &amp; d&gt;" in text
    assert 'font-size="17"' in text
    assert "<text" not in written(Text((-50, -10, 50, 10), "%name"))
    assert ">Φ<" in written(Text((-50, -10, 50, 10), "Phi"))
    assert ">V<tspan" in written(Text((-50, -10, 50, 10), "V_m"))
    long = written(Text((-10, -10, 10, 10), "much too long for it"))
    assert float(long.split('font-size="')[1].split('"')[0]) < 2


def test_turned_primitives() -> None:
    text = written(Placed(Line(((0, 0), (1, 0))), (10, 20), 90))
    assert 'transform="translate(10 -20) rotate(-90)"' in text


def test_ports() -> None:
    cuts = (
        Port("p", (-100, 0), "electrical"),
        Port("n", (100, 0), "electrical", filled=False),
        Port("flange", (0, 100), "mechanical.rotational", "circle"),
        Port("u", (-100, 50), "Real", "in"),
        Port("y", (100, 50), "Real", "out", filled=False),
        Port("support", (0, -100), "mechanical.rotational", "circle", conditional=True),
    )
    text = svg(Symbol("A", (), {}, cuts), "A & B")
    ElementTree.fromstring(text)
    assert text.count("<rect") == 2
    assert text.count("<circle") == 2
    assert "<title>flange</title>" in text
    assert "<title>A &amp; B</title>" in text
    assert text.count("stroke-dasharray") == 1
    # An input points into the symbol, an output out of it.
    assert 'd="M-90 -50L' in text
    assert 'd="M110 -50L' in text
