"""From a diagram to a picture: parts, wires and names with coordinates."""

from __future__ import annotations

from dataclasses import dataclass, replace

from acausal.drawing.diagram import Diagram, Net, Part, frame_symbol
from acausal.drawing.labels import Label, label_parts, note_labels
from acausal.drawing.orientation import UPRIGHT, drawn_box, turned
from acausal.drawing.placement import Placed, part_pins, place, stress_layout
from acausal.drawing.routing import Box, End, Wire, route
from acausal.reference.graphics import Port

#: Distance from the outermost part or wire to the frame.
ROOM = 60.0
#: Free places beside a part that nothing connects.
_BESIDE = 110.0


@dataclass(frozen=True)
class Layout:
    """A diagram with coordinates; x to the right, y down.

    Attributes:
        parts: The parts; those that were to be drawn with their inside have its layout.
        placed: Where each part stands.
        insides: Layout of the inside of each part, None for a plain symbol.
        nets: The nets.
        wires: The wire of each net.
        names: Name of each part with its place.
        notes: Elements of arrays at the ends of wires.
        box: Left, top, right and bottom of everything.
    """

    parts: tuple[Part, ...]
    placed: tuple[Placed, ...]
    insides: tuple[Layout | None, ...]
    nets: tuple[Net, ...]
    wires: tuple[Wire, ...]
    names: tuple[Label, ...]
    notes: tuple[Label, ...]
    box: Box


def lay_out(diagram: Diagram) -> Layout:
    """Return the layout of a diagram: the best of a few attempts, always the same."""
    insides = tuple(None if p.inside is None else lay_out(p.inside) for p in diagram.parts)
    parts = tuple(
        part if inside is None else _framed(part, inside)
        for part, inside in zip(diagram.parts, insides, strict=True)
    )
    diagram = Diagram(parts, diagram.nets)
    attempts = 5 if len(parts) < 16 else 3 if len(parts) < 40 else 2
    best: tuple[float, list[Placed], list[Wire]] | None = None
    start = stress_layout(diagram)
    for seed in range(attempts):
        placed = place(diagram, start, seed)
        placed = _lone_parts(diagram, _terminals_outside(diagram, placed))
        wires, cost = route(
            [part_box(p, at) for p, at in zip(parts, placed, strict=True)],
            [_ends(net, parts, placed) for net in diagram.nets],
        )
        xs = [b for p, at in zip(parts, placed, strict=True) for b in part_box(p, at)]
        width, height = max(xs[0::4] + xs[2::4], default=0.0), max(xs[1::4] + xs[3::4], default=0.0)
        cost += 0.3 * (width + 1.5 * height)
        if best is None or cost < best[0]:
            best = cost, placed, wires
    assert best is not None
    _, placed, wires = best
    boxes = [part_box(p, at) for p, at in zip(parts, placed, strict=True)]
    notes = note_labels(diagram, placed, wires)
    inks = [_ink(p, at) for p, at in zip(parts, placed, strict=True)]
    names = label_parts(parts, placed, boxes, inks, wires, notes)
    return Layout(
        parts, tuple(placed), insides, diagram.nets, tuple(wires), names, notes,
        _around(boxes, wires, (*names, *notes)),
    )  # fmt: skip


def part_box(part: Part, at: Placed) -> Box:
    """Return left, top, right and bottom of a part at its place."""
    left, bottom, right, top = part.symbol.extent
    w, h = (right - left) / 2, (top - bottom) / 2
    if at.orientation.quarters % 2:
        w, h = h, w
    return at.x - w, at.y - h, at.x + w, at.y + h


def _ink(part: Part, at: Placed) -> Box:
    """Return the box around what is drawn of a part, which may be narrower than its symbol."""
    if part.inside is not None or part.terminal or not part.symbol.drawn:
        return part_box(part, at)
    left, bottom, right, top = drawn_box(turned(part.symbol, at.orientation))
    return at.x + left, at.y - top, at.x + right, at.y - bottom


def _ends(net: Net, parts: tuple[Part, ...], placed: list[Placed]) -> list[End]:
    found = []
    for pin in net.pins:
        at = placed[pin.part]
        x, y, dx, dy = part_pins(parts[pin.part], at.orientation)[pin.port]
        found.append(End(round(at.x + x, 1), round(at.y + y, 1), dx, dy))
    return found


def _terminals_outside(diagram: Diagram, placed: list[Placed]) -> list[Placed]:
    """Put cuts of the model itself left and right of everything else, near to where they were."""
    used = {pin.part for net in diagram.nets for pin in net.pins}
    others = [k for k in used if not diagram.parts[k].terminal]
    boxes = [part_box(diagram.parts[k], placed[k]) for k in others]
    if not boxes:
        return placed
    ends = min(b[0] for b in boxes) - _BESIDE, max(b[2] for b in boxes) + _BESIDE
    result = list(placed)
    taken: set[tuple[bool, float]] = set()
    for k in sorted(used, key=lambda k: (placed[k].y, k)):
        if not diagram.parts[k].terminal:
            continue
        right = diagram.parts[k].symbol.cuts[0].position[0] < 0
        y = placed[k].y
        while any(side == right and abs(y - other) < 70 for side, other in taken):
            y += 70
        taken.add((right, y))
        result[k] = Placed(ends[right], y, UPRIGHT)
    return result


def _lone_parts(diagram: Diagram, placed: list[Placed]) -> list[Placed]:
    """Put parts that nothing connects in a row below the others."""
    used = {pin.part for net in diagram.nets for pin in net.pins}
    boxes = [part_box(diagram.parts[k], placed[k]) for k in sorted(used)]
    left = min((b[0] for b in boxes), default=0.0)
    right = max((b[2] for b in boxes), default=0.0)
    y = max((b[3] for b in boxes), default=-_BESIDE - 40) + _BESIDE + 40
    x = left
    row = 0.0
    result = list(placed)
    columns_end = max(right, left + 1400)
    for k, part in enumerate(diagram.parts):
        if k in used:
            continue
        box = part_box(part, Placed(0.0, 0.0, UPRIGHT))
        w, h = box[2] - box[0], box[3] - box[1]
        if x > left and x + w > columns_end:
            x, y, row = left, y + row + _BESIDE, 0.0
        result[k] = Placed(x + w / 2, y + h / 2, UPRIGHT)
        x += w + _BESIDE
        row = max(row, h)
    return result


def _around(boxes: list[Box], wires: list[Wire], labels: tuple[Label, ...]) -> Box:
    xs = [x for b in boxes for x in (b[0], b[2])] + [x for lb in labels for x in lb.box[0::2]]
    ys = [y for b in boxes for y in (b[1], b[3])] + [y for lb in labels for y in lb.box[1::2]]
    for wire in wires:
        for a, b in wire.lines:
            xs += [a[0], b[0]]
            ys += [a[1], b[1]]
    if not xs:
        return (-100.0, -100.0, 100.0, 100.0)
    return min(xs) - 24, min(ys) - 24, max(xs) + 24, max(ys) + 24


def _framed(part: Part, inside: Layout) -> Part:
    """Return a part whose symbol is the frame around its inside.

    Its ports stand where the terminals inside are nearest to the frame.
    """
    left, top, right, bottom = inside.box
    width = _even(right - left + 2 * ROOM)
    height = _even(bottom - top + 2 * ROOM)
    cy = (top + bottom) / 2
    cuts: list[Port] = []
    known = {c.name: c for c in part.symbol.cuts}
    for terminal, at in zip(inside.parts, inside.placed, strict=True):
        if not terminal.terminal or terminal.name not in known:
            continue
        outward = -1 if terminal.symbol.cuts[0].position[0] > 0 else 1
        y = round(-(at.y - cy), -1)
        while any(c.position == (outward * width / 2, y) for c in cuts):
            y -= 40.0
        cuts.append(replace(known[terminal.name], position=(outward * width / 2, y)))
    missing = [c for c in part.symbol.cuts if c.name not in {p.name for p in cuts}]
    for k, cut in enumerate(missing):
        x = round(-width / 2 + width * (k + 1) / (len(missing) + 1), -1)
        cuts.append(replace(cut, position=(x, -height / 2)))
    return replace(part, symbol=frame_symbol(part, width, height, tuple(cuts)))


def _even(length: float) -> float:
    return 20.0 * round(length / 20.0 + 0.5)
