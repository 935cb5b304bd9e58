"""A layout as SVG: wires in the colours of their fields, symbols, names."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from html import escape
from typing import Final

from acausal.drawing.labels import Label
from acausal.drawing.layout import Layout
from acausal.drawing.orientation import Orientation, turned
from acausal.drawing.routing import Place, Wire
from acausal.reference.fields import FIELDS
from acausal.reference.graphics import Graphic, Rectangle, Symbol, Text
from acausal.reference.svg import content, hatchings

#: Pixels for one unit of a symbol.
SCALE: Final = 0.36
FONT: Final = "system-ui,'Segoe UI',Roboto,'Helvetica Neue',Arial,'DejaVu Sans',sans-serif"
_STYLE: Final = (
    f".schematic{{color:#14171b;font-family:{FONT}}}"
    ".schematic .wire{fill:none;stroke-linecap:round;stroke-linejoin:round}"
    "@media(prefers-color-scheme:dark){.schematic{filter:invert(.92) hue-rotate(180deg)}}"
)


def paint(layout: Layout, title: str = "", *, styled: bool = True, prefix: str = "") -> str:
    """Return a layout as an ``svg`` element.

    Args:
        layout: What to draw.
        title: What the picture shows, for people who cannot see it.
        styled: Put the style into the picture; a page that has its own leaves it out.
        prefix: Put before the names inside, if several pictures stand on one page.
    """
    return _Painter(prefix).picture(layout, title, styled)


@dataclass
class _Painter:
    prefix: str
    symbols: dict[tuple[object, ...], str] = field(default_factory=dict)
    definitions: list[str] = field(default_factory=list)
    graphics: list[Graphic] = field(default_factory=list)

    def picture(self, layout: Layout, title: str, styled: bool) -> str:
        left, top, right, bottom = layout.box
        width, height = right - left, bottom - top
        body = "".join(self.layout(layout, ""))
        about = f"<title>{escape(title)}</title>" if title else ""
        style = f"<style>{_STYLE}</style>" if styled else ""
        hatches = hatchings(tuple(self.graphics))
        definitions = f"<defs>{''.join(self.definitions)}</defs>" if self.definitions else ""
        return (
            '<svg xmlns="http://www.w3.org/2000/svg" class="schematic" role="img" '
            f'width="{_n(width * SCALE)}" height="{_n(height * SCALE)}" '
            f'viewBox="{_n(left)} {_n(top)} {_n(width)} {_n(height)}">'
            f"{about}{style}{hatches}{definitions}{body}</svg>"
        )

    def layout(self, layout: Layout, path: str) -> Iterator[str]:
        for k, part in enumerate(layout.parts):
            inside = layout.insides[k]
            if inside is not None:
                yield from self.frame(layout, k, inside, path + part.label)
        for net, wire in zip(layout.nets, layout.wires, strict=True):
            ends = " ".join(
                f"{path}{'.' * bool(path)}{layout.parts[p.part].name}.{p.port}"
                if not layout.parts[p.part].terminal
                else f"{path}{'.' * bool(path)}{p.port}"
                for p in net.pins
            )
            yield _wire(wire, net.field, net.signal, ends)
        for k, part in enumerate(layout.parts):
            at = layout.placed[k]
            if layout.insides[k] is not None:
                continue
            name = self.symbol(part.symbol, at.orientation, part.terminal)
            about = f"{path}{'.' * bool(path)}{part.label}: {part.class_name}"
            if part.description:
                about += f" – {part.description}"
            full = escape(path + "." * bool(path) + part.name, quote=True)
            yield (f'<g class="part" data-path="{full}"><title>{escape(about)}</title>')
            if part.size:  # an array: a second copy behind
                yield f'<use href="#{name}" x="{_n(at.x + 12)}" y="{_n(at.y - 12)}" opacity=".3"/>'
            yield f'<use href="#{name}" x="{_n(at.x)}" y="{_n(at.y)}"/></g>'
        for label in layout.names:
            yield _label(label, "name")
        for label in layout.notes:
            yield _label(label, "elements")

    def frame(self, layout: Layout, k: int, inside: Layout, path: str) -> Iterator[str]:
        part, at = layout.parts[k], layout.placed[k]
        x1, y1, x2, y2 = part.symbol.extent
        full = escape(path, quote=True)
        yield (
            f'<g class="part frame" data-path="{full}" '
            f'transform="translate({_n(at.x)} {_n(at.y)})">'
            f"<title>{escape(f'{path}: {part.class_name}')}</title>"
            f'<rect x="{_n(x1)}" y="{_n(-y2)}" width="{_n(x2 - x1)}" height="{_n(y2 - y1)}" '
            'rx="24" fill="#7a8aa0" fill-opacity=".07" stroke="#7a8aa0" stroke-width="3" '
            'stroke-dasharray="14 9"/>'
        )
        cx, cy = (inside.box[0] + inside.box[2]) / 2, (inside.box[1] + inside.box[3]) / 2
        yield f'<g transform="translate({_n(-cx)} {_n(-cy)})">'
        yield from self.layout(inside, path)
        yield "</g>"
        frame = Symbol(
            part.symbol.name, (), part.symbol.ports, part.symbol.cuts, part.symbol.extent
        )
        for terminal, place in zip(inside.parts, inside.placed, strict=True):
            if not terminal.terminal or terminal.name not in frame.ports:
                continue
            x, y = frame.ports[terminal.name]
            color = FIELDS[terminal.symbol.cuts[0].field].color.hexadecimal
            start = (place.x - cx, place.y - cy)
            yield (
                f'<path class="wire" stroke="{color}" stroke-width="4" '
                f'd="M{_n(start[0])} {_n(start[1])}H{_n(x)}V{_n(-y)}"/>'
            )
        yield content(frame) + "</g>"

    def symbol(self, drawing: Symbol, orientation: Orientation, terminal: bool) -> str:
        """Return the name of a symbol in an orientation, defined when it is first used."""
        key = (drawing.name, drawing.cuts, drawing.extent, orientation, terminal)
        if key in self.symbols:
            return self.symbols[key]
        name = f"{self.prefix}s{len(self.symbols)}"
        self.symbols[key] = name
        shown = turned(drawing, orientation)
        left, bottom, right, top = shown.extent
        background = ""
        if not drawing.drawn:
            shown = _boxed(shown)
            background = (
                f'<rect x="{_n(left)}" y="{_n(-top)}" width="{_n(right - left)}" '
                f'height="{_n(top - bottom)}" rx="10" fill="#fff"/>'
            )
        self.graphics += shown.graphics
        self.definitions.append(f'<g id="{name}">{background}{content(shown)}</g>')
        return name


def _boxed(shown: Symbol) -> Symbol:
    """Write the class into the box of a class without a drawing, a word in a line."""
    left, _, right, _ = shown.extent
    inset = 0.12 * (right - left)
    name = shown.name.rpartition(".")[2]
    lines: list[str] = []
    for word in re.findall(r"[A-Z]?[^A-Z]+|[A-Z]+(?![a-z])", name) or [name]:
        if lines and len(lines[-1]) + len(word) <= 10:
            lines[-1] += word
        else:
            lines.append(word)
    lines = lines[:4]
    graphics: list[Graphic] = [Rectangle(shown.extent, radius=10.0)]
    width, height = right - left - 2 * inset, 38.0
    size = min(0.85 * height, width / (0.58 * max(map(len, lines)))) / 2
    for k, line in enumerate(lines):
        y = (len(lines) - 1) / 2 * height - k * height
        box = (left + inset, y - height / 2, right - inset, y + height / 2)
        graphics.append(Text(box, line, size=size, italic=True))
    return Symbol(shown.name, tuple(graphics), shown.ports, shown.cuts, shown.extent, shown.drawn)


def _wire(wire: Wire, key: str, signal: bool, ends: str) -> str:
    color = FIELDS[key].color.hexadecimal
    path = "".join(_polyline(points) for points in _joined(wire))
    dots = "".join(
        f'<circle cx="{_n(x)}" cy="{_n(y)}" r="8" fill="{color}"/>' for x, y in wire.dots
    )
    width = "3" if signal else "7" if key == "mechanical.multibody" else "4.5"
    return (
        f'<g class="net" data-ends="{escape(ends, quote=True)}"><title>{escape(ends)}</title>'
        f'<path class="wire" stroke="{color}" stroke-width="{width}" d="{path}"/>{dots}</g>'
    )


def _joined(wire: Wire) -> list[list[Place]]:
    """Return the lines of a wire joined at its corners."""
    ends: dict[Place, list[int]] = {}
    for k, line in enumerate(wire.lines):
        for place in line:
            ends.setdefault(place, []).append(k)
    stops = set(wire.dots) | {p for p, own in ends.items() if len(own) != 2}
    left = dict.fromkeys(range(len(wire.lines)))
    paths: list[list[Place]] = []
    while left:
        first = next((k for k in left if stops & set(wire.lines[k])), next(iter(left)))
        a, b = wire.lines[first]
        if a not in stops:
            a, b = b, a
        left.pop(first)
        path = [a, b]
        while path[-1] not in stops:
            following = [k for k in ends[path[-1]] if k in left]
            if not following:
                break
            left.pop(following[0])
            c, d = wire.lines[following[0]]
            path.append(d if c == path[-1] else c)
        paths.append(path)
    return paths


def _polyline(points: list[Place]) -> str:
    """Return a path with slightly rounded corners."""
    text = f"M{_n(points[0][0])} {_n(points[0][1])}"
    for before, corner, after in zip(points, points[1:], points[2:], strict=False):
        r = min(12.0, _half(before, corner), _half(corner, after))
        p, q = _towards(corner, before, r), _towards(corner, after, r)
        text += f"L{_n(p[0])} {_n(p[1])}Q{_n(corner[0])} {_n(corner[1])} {_n(q[0])} {_n(q[1])}"
    return text + f"L{_n(points[-1][0])} {_n(points[-1][1])}"


def _half(a: Place, b: Place) -> float:
    return (abs(a[0] - b[0]) + abs(a[1] - b[1])) / 2


def _towards(a: Place, b: Place, r: float) -> Place:
    length = abs(a[0] - b[0]) + abs(a[1] - b[1]) or 1.0
    return a[0] + (b[0] - a[0]) * r / length, a[1] + (b[1] - a[1]) * r / length


def _label(label: Label, kind: str) -> str:
    color = "currentColor" if kind == "name" else "#626d7a"
    return (
        f'<text class="{kind}" x="{_n(label.x)}" y="{_n(label.y)}" font-size="{_n(label.size)}" '
        f'text-anchor="{label.anchor}" fill="{color}" stroke="#fff" stroke-width="9" '
        f'paint-order="stroke" stroke-linejoin="round">{escape(label.text)}</text>'
    )


def _n(value: float) -> str:
    text = f"{value:.1f}".removesuffix(".0")
    return "0" if text == "-0" else text
