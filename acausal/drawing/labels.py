"""Names beside parts and notes at wires, where they cover nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from acausal.drawing.diagram import Diagram, Part
from acausal.drawing.placement import Placed, part_pins
from acausal.drawing.routing import Box, Wire

#: Height of the letters of names and of notes.
NAME, NOTE = 34.0, 26.0
_WIDTH = 0.58


@dataclass(frozen=True)
class Label:
    """A text at a place; ``anchor`` is ``start``, ``middle`` or ``end``, (x, y) the base line."""

    text: str
    x: float
    y: float
    anchor: str
    size: float

    @property
    def box(self) -> Box:
        """Left, top, right, bottom."""
        width = _WIDTH * self.size * len(self.text)
        left = self.x - {"start": 0.0, "middle": width / 2, "end": width}[self.anchor]
        return left, self.y - 0.8 * self.size, left + width, self.y + 0.22 * self.size


def label_parts(
    parts: Sequence[Part],
    placed: Sequence[Placed],
    boxes: Sequence[Box],
    inks: Sequence[Box],
    wires: Sequence[Wire],
    notes: Sequence[Label],
) -> tuple[Label, ...]:
    """Return the names of parts, each above, below or beside its part where there is room."""
    segments = [line for wire in wires for line in wire.lines]
    taken = [note.box for note in notes]
    # A name may stand beside a narrow symbol, inside of the box that wires keep away from.
    found: list[Label] = []
    for k, part in enumerate(parts):
        best: tuple[float, Label] | None = None
        for dislike, label in _candidates(part, placed[k], inks[k]):
            cost = dislike
            own = label.box
            for number, other in enumerate(boxes):
                if number == k:
                    other = inks[k]
                if _overlap(own, other) > 0:
                    cost += 60
            for other in taken:
                if _overlap(own, other) > 0:
                    cost += 60
            for (x1, y1), (x2, y2) in segments:
                line = (min(x1, x2) - 6, min(y1, y2) - 6, max(x1, x2) + 6, max(y1, y2) + 6)
                if _overlap(own, line) > 0:
                    cost += 25
            if best is None or cost < best[0]:
                best = cost, label
        assert best is not None
        found.append(best[1])
        taken.append(best[1].box)
    return tuple(found)


def _candidates(part: Part, at: Placed, box: Box) -> list[tuple[float, Label]]:
    left, top, right, bottom = box
    text = part.label
    cx, cy = at.x, at.y
    sides = {(dx, dy) for _, _, dx, dy in part_pins(part, at.orientation).values()}
    if part.inside is not None:
        return [(0.0, Label(text, left + 22, top + 44, "start", NAME))]
    if part.terminal:
        return [
            (0.0, Label(text, cx, top - 12, "middle", NAME)),
            (1.0, Label(text, cx, bottom + 34, "middle", NAME)),
        ]
    upright = (0, -1) in sides or (0, 1) in sides
    beside = 3.0 if not upright or (1, 0) in sides else -1.0
    before = 3.5 if not upright or (-1, 0) in sides else -0.5
    found = [
        (0.0 + 2 * ((0, -1) in sides), Label(text, cx, top - 14, "middle", NAME)),
        (1.0 + 2 * ((0, 1) in sides), Label(text, cx, bottom + 40, "middle", NAME)),
        (beside, Label(text, right + 14, cy + 12, "start", NAME)),
        (before, Label(text, left - 14, cy + 12, "end", NAME)),
    ]
    for anchor, x in (("start", cx + 16), ("end", cx - 16)):
        found.append((2.5, Label(text, x, top - 14, anchor, NAME)))
        found.append((3.0, Label(text, x, bottom + 40, anchor, NAME)))
    for anchor, x in (("start", right + 14), ("end", left - 14)):
        found.append((4.0, Label(text, x, top + 34, anchor, NAME)))
        found.append((4.5, Label(text, x, bottom - 14, anchor, NAME)))
    return found


def _overlap(a: Box, b: Box) -> float:
    width = min(a[2], b[2]) - max(a[0], b[0])
    height = min(a[3], b[3]) - max(a[1], b[1])
    return width * height if width > 0 and height > 0 else 0.0


def note_labels(
    diagram: Diagram, placed: Sequence[Placed], wires: Sequence[Wire]
) -> tuple[Label, ...]:
    """Return which elements of arrays take part, beside the wires near to the ports."""
    found: list[Label] = []
    for net, wire in zip(diagram.nets, wires, strict=True):
        for pin in net.pins:
            if not pin.note:
                continue
            at = placed[pin.part]
            x, y, dx, dy = part_pins(diagram.parts[pin.part], at.orientation)[pin.port]
            end = at.x + x, at.y + y
            along = _leaves(wire, end)
            px, py = end
            if along == (0, 0):
                along = (dx, dy)
            # Beside the wire, as far from the port as the wire needs to show where it goes.
            if along[1] == 0:
                label = Label(pin.note, px + 20 * dx, py - 14, "start" if dx > 0 else "end", NOTE)
            else:
                label = Label(pin.note, px + 14, py + 30 * dy + 8, "start", NOTE)
            while any(_overlap(label.box, other.box) for other in found):
                label = Label(label.text, label.x, label.y + 44, label.anchor, NOTE)
            found.append(label)
    return tuple(found)


def _leaves(wire: Wire, end: tuple[float, float]) -> tuple[int, int]:
    for a, b in wire.lines:
        for here, there in ((a, b), (b, a)):
            if abs(here[0] - end[0]) < 1 and abs(here[1] - end[1]) < 1:
                return (
                    (there[0] > here[0]) - (there[0] < here[0]),
                    (there[1] > here[1]) - (there[1] < here[1]),
                )
    return 0, 0
