"""Schematics: everything is drawn, once; wires end at ports and run around parts."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

import acausal as ac
from acausal.diagnostics import AcausalError
from acausal.drawing.layout import Layout, part_box
from acausal.drawing.orientation import ORIENTATIONS, turned
from acausal.drawing.placement import part_pins
from acausal.modeling.load import library_class
from acausal.reference.symbols import symbol

EXAMPLES = Path(__file__).parents[2] / "examples"
SVG = "{http://www.w3.org/2000/svg}"
MODELS = [
    ("rlc", None),
    ("power_electronics", "BridgeRectifier"),
    ("quarter_car", "Bump"),
    ("crane_crab", "CraneCrab"),
    ("servo_cylinder", None),
    ("pendulum_chain", "Chain10"),
    ("spatial_loop", None),
]


@pytest.fixture(scope="module", params=MODELS, ids=lambda m: m[0])
def drawing(request):
    name, model = request.param
    compiled = ac.compile_file(EXAMPLES / f"{name}.acm", model)
    return compiled, compiled.schematic()


def ports(layout: Layout, k: int) -> list[tuple[float, float]]:
    """Places of the ends of a net."""
    found = []
    for pin in layout.nets[k].pins:
        at = layout.placed[pin.part]
        x, y, _, _ = part_pins(layout.parts[pin.part], at.orientation)[pin.port]
        found.append((at.x + x, at.y + y))
    return found


def test_every_component_is_drawn_once(drawing):
    compiled, picture = drawing
    root = ET.fromstring(picture.svg)
    drawn = [g.get("data-path") for g in root.iter(f"{SVG}g") if "part" in g.get("class", "")]
    assert len(drawn) == len(set(drawn))
    graph = compiled.connection_graph()
    components = {
        n.split(".")[0].split("[")[0]
        for n, kind in graph.nodes(data="kind")
        if kind == "component" and n
    }
    assert components <= set(drawn)


def test_components_do_not_touch(drawing):
    layout = drawing[1].layout
    boxes = [part_box(p, at) for p, at in zip(layout.parts, layout.placed, strict=True)]
    for k, a in enumerate(boxes):
        for b in boxes[:k]:
            assert a[2] < b[0] or b[2] < a[0] or a[3] < b[1] or b[3] < a[1]


def test_wires_join_all_ports_of_their_nets(drawing):
    layout = drawing[1].layout
    assert layout.nets
    for k, wire in enumerate(layout.wires):
        joined = [set(line) for line in wire.lines]
        for place in [p for line in wire.lines for p in line] + list(wire.dots):
            for line, ends in zip(wire.lines, joined, strict=True):
                if on(place, line):
                    ends.add(place)
        reached = set(ports(layout, k)[:1])
        for _ in joined:
            for ends in joined:
                if reached & ends:
                    reached |= ends
        assert set(ports(layout, k)) <= reached


def on(place, line):
    (x1, y1), (x2, y2) = line
    return (
        min(x1, x2) <= place[0] <= max(x1, x2)
        and min(y1, y2) <= place[1] <= max(y1, y2)
        and (x1 == x2 or y1 == y2)
    )


def test_wires_end_at_ports_only(drawing):
    layout = drawing[1].layout
    for k, wire in enumerate(layout.wires):
        ends = [p for line in wire.lines for p in line]
        loose = {
            p for p in ends
            if ends.count(p) == 1 and not any(on(p, line) and p not in line for line in wire.lines)
        }  # fmt: skip
        assert loose <= set(ports(layout, k))


def test_wires_run_around_other_components(drawing):
    layout = drawing[1].layout
    boxes = [part_box(p, at) for p, at in zip(layout.parts, layout.placed, strict=True)]
    for net, wire in zip(layout.nets, layout.wires, strict=True):
        own = {pin.part for pin in net.pins}
        for (x1, y1), (x2, y2) in wire.lines:
            for part, (left, top, right, bottom) in enumerate(boxes):
                if part not in own:
                    over = (
                        max(x1, x2) > left and min(x1, x2) < right
                        and max(y1, y2) > top and min(y1, y2) < bottom
                    )  # fmt: skip
                    assert not over, layout.parts[part].name


def test_nets_are_the_connections(drawing):
    """Ports that meet in the picture are those that meet in the connection graph."""
    compiled, picture = drawing
    graph = compiled.connection_graph()
    wanted = set()
    for node, kind in graph.nodes(data="kind"):
        if kind == "junction":
            cuts = {strip(key) for *_, key in graph.edges(node, keys=True)}
            if graph.degree(node) > 1:
                wanted.add(frozenset(c for c in cuts if c.count(".") == 1))
    shown = {
        frozenset(f"{picture.layout.parts[p.part].name}.{p.port}" for p in net.pins)
        for net in picture.layout.nets
    }
    assert {w for w in wanted if len(w) > 1} <= shown


def strip(path: str) -> str:
    import re

    return re.sub(r"\[[^\]]*\]", "", path)


def test_no_references_to_elsewhere(drawing):
    text = drawing[1].svg.replace("http://www.w3.org/2000/svg", "")
    assert "http" not in text
    root = ET.fromstring(drawing[1].svg)
    names = {e.get("id") for e in root.iter() if e.get("id")}
    for use in root.iter(f"{SVG}use"):
        assert use.get("href").removeprefix("#") in names


def test_the_same_model_gives_the_same_bytes():
    first, second = (
        ac.compile_file(EXAMPLES / "power_electronics.acm", "BuckConverter").schematic().svg
        for _ in range(2)
    )
    assert first == second


def test_an_array_is_drawn_once_with_its_size_and_elements():
    compiled = ac.compile_file(EXAMPLES / "pendulum_chain.acm", "Chain100")
    layout = compiled.schematic().layout
    assert "link[100]" in [label.text for label in layout.names]
    assert {label.text for label in layout.notes} == {"[1]", "[2:100]", "[1:99]"}


def test_depth_shows_what_components_are_made_of():
    compiled = ac.compile_file(EXAMPLES / "electric_car.acm")
    flat, deep = compiled.schematic(), compiled.schematic(depth=2)
    assert "motor.battery" not in flat.svg
    root = ET.fromstring(deep.svg)
    paths = [g.get("data-path") for g in root.iter(f"{SVG}g") if g.get("data-path")]
    assert {"motor", "motor.battery", "motor.rotor"} <= set(paths)
    assert len(paths) == len(set(paths))
    with pytest.raises(AcausalError, match="depth of 0"):
        compiled.schematic(depth=0)


def test_a_model_of_very_many_components_is_refused_and_reported_without_a_schematic():
    parts = "".join(f"  Resistor r{k};\n" for k in range(302))
    wires = "".join(f"  connect(r{k}.n, r{k + 1}.p);\n" for k in range(301))
    text = f"import electrical.*;\nmodel Many\n{parts}  Ground g;\nequation\n{wires}"
    compiled = ac.compile_text(text + "  connect(r0.p, r301.n, g.p);\nend Many;\n")
    with pytest.raises(AcausalError) as caught:
        compiled.schematic()
    assert caught.value.diagnostics[0].code == "F112"
    assert "Not drawn: a schematic of 303 parts" in compiled.report(run=False)


def test_cuts_of_a_model_stand_at_its_sides():
    layout = ac.compile_file(EXAMPLES / "quarter_car.acm", "RoadStep").schematic(depth=2).layout
    inside = next(i for i in layout.insides if i is not None)
    ends = [p.x for part, p in zip(inside.parts, inside.placed, strict=True) if part.terminal]
    rest = [p.x for part, p in zip(inside.parts, inside.placed, strict=True) if not part.terminal]
    assert len(ends) == 2
    assert all(x < min(rest) or x > max(rest) for x in ends)


def test_turning_four_times_is_nothing():
    drawing = symbol(library_class("electrical.Resistor"))
    once = turned(drawing, ORIENTATIONS[1])
    assert once.ports["p"] == (0.0, -100.0)
    again = turned(turned(turned(once, ORIENTATIONS[1]), ORIENTATIONS[1]), ORIENTATIONS[1])
    assert again.ports == drawing.ports
    assert again.extent == drawing.extent
    assert turned(drawing, ORIENTATIONS[4]).ports["p"] == (100.0, 0.0)


def test_files(tmp_path):
    pytest.importorskip("resvg_py")
    from PIL import Image

    picture = ac.compile_file(EXAMPLES / "rlc.acm").schematic(tmp_path / "rlc.svg")
    assert (tmp_path / "rlc.svg").read_text() == picture.svg + "\n"
    picture.write(tmp_path / "rlc.png")
    with Image.open(tmp_path / "rlc.png") as image:
        assert image.getextrema() != ((255, 255),) * 4
        assert image.width > 200
    with pytest.raises(AcausalError) as caught:
        picture.write(tmp_path / "rlc.jpg")
    assert caught.value.diagnostics[0].code == "F201"


def test_command_line(tmp_path, monkeypatch, capsys):
    from acausal.cli.main import execute

    target = tmp_path / "rlc.svg"
    assert execute(["schematic", str(EXAMPLES / "rlc.acm"), "-o", str(target)]) == 0
    assert ET.parse(target).getroot().tag == f"{SVG}svg"
    assert "5 parts, 4 nets" in capsys.readouterr().out
