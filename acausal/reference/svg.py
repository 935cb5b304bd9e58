"""Symbols as SVG.

What has no colour of its own takes ``currentColor``. Everything is drawn as on white paper; a dark
page inverts the lightness of the whole picture.
"""

from __future__ import annotations

import math
import re
from html import escape
from itertools import pairwise
from typing import Final

from acausal.reference.fields import FIELDS
from acausal.reference.graphics import (
    THIN,
    Box,
    Color,
    Ellipse,
    Fill,
    Graphic,
    Line,
    Pen,
    Placed,
    Point,
    Polygon,
    Port,
    Rectangle,
    Symbol,
    Text,
)

#: Room around the coordinate system for ports that stand on its edge.
MARGIN: Final = 14.0
#: Half the size of a port.
PORT: Final = 8.0

_DASHES: Final = {
    "Dash": "10 6",
    "Dot": "2.5 5",
    "DashDot": "10 5 2.5 5",
    "DashDotDot": "10 5 2.5 5 2.5 5",
}
#: Hatchings are patterns that the page defines once (:func:`hatchings`).
_HATCHED: Final = {
    "Horizontal": "M0 5H10",
    "Vertical": "M5 0V10",
    "Cross": "M0 5H10M5 0V10",
    "Forward": "M-2 8L2 12M0 0L10 10M8 -2L12 2",
    "Backward": "M-2 2L2 -2M0 10L10 0M8 12L12 8",
    "CrossDiag": "M0 0L10 10M0 10L10 0",
}


def svg(symbol: Symbol, title: str = "") -> str:
    """Return a symbol as an ``svg`` element that can stand alone or in a page."""
    head = f'<svg xmlns="http://www.w3.org/2000/svg" class="icon" viewBox="{view_box(symbol)}">'
    about = f"<title>{escape(title)}</title>" if title else ""
    return f"{head}{about}{hatchings(symbol.graphics)}{content(symbol)}</svg>"


def view_box(symbol: Symbol) -> str:
    """Return the four numbers of the ``viewBox`` of a symbol."""
    left, bottom, right, top = symbol.extent
    numbers = (left - MARGIN, -top - MARGIN, right - left + 2 * MARGIN, top - bottom + 2 * MARGIN)
    return " ".join(_n(x) for x in numbers)


def content(symbol: Symbol) -> str:
    """Return graphics and ports of a symbol, without the element around them."""
    drawn = "".join(_graphic(g) for g in symbol.graphics)
    ports = "".join(_port(cut, symbol.extent) for cut in symbol.cuts)
    return f'<g stroke-linecap="round" stroke-linejoin="round" fill="none">{drawn}</g>{ports}'


def hatchings(graphics: tuple[Graphic, ...]) -> str:
    """Return the definitions of the hatchings that some graphics use, in fixed order."""
    used = set()
    for graphic in graphics:
        primitive = graphic.primitive if isinstance(graphic, Placed) else graphic
        if isinstance(primitive, (Polygon, Rectangle, Ellipse)):
            used.add(primitive.fill.pattern)
    patterns = "".join(
        f'<pattern id="hatch-{name}" width="10" height="10" patternUnits="userSpaceOnUse">'
        f'<path d="{path}" stroke="currentColor" stroke-width="1.2"/></pattern>'
        for name, path in _HATCHED.items()
        if name in used
    )
    return f"<defs>{patterns}</defs>" if patterns else ""


def _graphic(graphic: Graphic) -> str:
    match graphic:
        case Placed(primitive, (x, y), rotation):
            turn = f" rotate({_n(-rotation)})" if rotation else ""
            return f'<g transform="translate({_n(x)} {_n(-y)}){turn}">{_graphic(primitive)}</g>'
        case Line():
            path = _path(graphic.points, graphic.smooth)
            heads = "".join(_arrow_heads(graphic))
            return f'<path d="{path}"{_pen(graphic.pen)}/>{heads}'
        case Polygon():
            points = graphic.points
            if graphic.smooth:
                closed = points if points[0] == points[-1] else (*points, points[0])
                path = _path(closed, True)
            else:
                path = _path(points, False) + "Z"
            return f'<path d="{path}"{_pen(graphic.pen)}{_fill(graphic.fill)}/>'
        case Rectangle():
            x1, y1, x2, y2 = graphic.extent
            radius = f' rx="{_n(graphic.radius)}"' if graphic.radius else ""
            return (
                f'<rect x="{_n(x1)}" y="{_n(-y2)}" width="{_n(x2 - x1)}" height="{_n(y2 - y1)}"'
                f"{radius}{_pen(graphic.pen)}{_fill(graphic.fill)}/>"
            )
        case Ellipse():
            return _ellipse(graphic)
        case Text():
            return _text(graphic)


def _ellipse(ellipse: Ellipse) -> str:
    x1, y1, x2, y2 = ellipse.extent
    cx, cy, rx, ry = (x1 + x2) / 2, (y1 + y2) / 2, (x2 - x1) / 2, (y2 - y1) / 2
    style = _pen(ellipse.pen) + _fill(ellipse.fill)
    if abs(ellipse.end - ellipse.start) >= 360:
        return (
            f'<ellipse cx="{_n(cx)}" cy="{_n(-cy)}" rx="{_n(rx)}" ry="{_n(ry)}"{style}/>'
            if rx != ry
            else f'<circle cx="{_n(cx)}" cy="{_n(-cy)}" r="{_n(rx)}"{style}/>'
        )

    def at(angle: float) -> str:
        radians = math.radians(angle)
        return f"{_n(cx + rx * math.cos(radians))} {_n(-cy - ry * math.sin(radians))}"

    large = int(abs(ellipse.end - ellipse.start) > 180)
    sweep = int(ellipse.end < ellipse.start)
    arc = f"{at(ellipse.start)}A{_n(rx)} {_n(ry)} 0 {large} {sweep} {at(ellipse.end)}"
    if ellipse.closure == "Radial":
        path = f"M{_n(cx)} {_n(-cy)}L{arc}Z"
    else:
        path = f"M{arc}" + "Z" * (ellipse.closure == "Chord")
    return f'<path d="{path}"{style}/>'


def _text(text: Text) -> str:
    words = text.text.replace("%%", "\0")
    if "%name" in words or not words:
        return ""
    words = words.replace("%", "").replace("\0", "%").replace("\n", " ")
    x1, y1, x2, y2 = text.extent
    width, height = abs(x2 - x1), abs(y2 - y1)
    size = text.size * 2 if text.size else 0.85 * height
    if width and not text.size:
        size = min(size, width / (0.58 * len(words)))
    written = _written(words)
    anchor, x = {
        "Left": ("start", x1),
        "Right": ("end", x2),
    }.get(text.align, ("middle", (x1 + x2) / 2))
    style = ' font-weight="bold"' * text.bold + ' font-style="italic"' * text.italic
    y = -(y1 + y2) / 2 + 0.35 * size
    return (
        f'<text x="{_n(x)}" y="{_n(y)}" font-size="{_n(size)}" text-anchor="{anchor}"{style}'
        f' fill="{_color(text.pen.color)}">{written}</text>'
    )


#: Greek letters as names of quantities spell them.
_GREEK: Final = dict(zip(
    ("alpha", "beta", "gamma", "delta", "epsilon", "eta", "theta", "lambda", "mu", "pi", "rho",
     "sigma", "tau", "phi", "psi", "omega", "Delta", "Sigma", "Phi", "Psi", "Omega"),
    "αβγδεηθλμπρστφψωΔΣΦΨΩ", strict=True,
))  # fmt: skip
_QUANTITY: Final = re.compile(r"([A-Za-z]+)_([A-Za-z0-9]+)")


def _written(words: str) -> str:
    """Return a text with Greek letters, and with a subscript for what follows ``_``."""
    found = _QUANTITY.fullmatch(words)
    if found is None:
        return escape(_GREEK.get(words, words))
    name = _GREEK.get(found[1], found[1])
    return f'{name}<tspan dy=".25em" font-size="70%">{found[2]}</tspan>'


def _path(points: tuple[Point, ...], smooth: bool) -> str:
    at = [f"{_n(x)} {_n(-y)}" for x, y in points]
    if not smooth or len(points) < 3:
        return f"M{at[0]}" + "".join(f"L{p}" for p in at[1:])
    # Pieces of a quadratic spline: the given points are its control points.
    middles = [f"{_n((a[0] + b[0]) / 2)} {_n(-(a[1] + b[1]) / 2)}" for a, b in pairwise(points)]
    curves = "".join(f"Q{p} {m}" for p, m in zip(at[1:-1], middles[1:], strict=True))
    return f"M{at[0]}L{middles[0]}{curves}L{at[-1]}"


def _arrow_heads(line: Line) -> list[str]:
    ends = ((line.points[0], line.points[1]), (line.points[-1], line.points[-2]))
    heads = []
    for kind, (tip, before) in zip(line.arrows, ends, strict=True):
        length = math.hypot(tip[0] - before[0], tip[1] - before[1])
        if kind == "None" or not length:
            continue
        size = 5.0 * max(1.0, line.pen.width / THIN) + 5.0
        dx, dy = (before[0] - tip[0]) / length, (before[1] - tip[1]) / length
        left = (tip[0] + size * (dx - 0.4 * dy), tip[1] + size * (dy + 0.4 * dx))
        right = (tip[0] + size * (dx + 0.4 * dy), tip[1] + size * (dy - 0.4 * dx))
        pen = Pen(line.pen.color, line.pen.width)
        if kind == "Filled":
            heads.append(_graphic(Polygon((tip, left, right), pen, Fill(line.pen.color, "Solid"))))
        else:
            points = (left, tip, right) if kind == "Open" else (left, tip)
            heads.append(_graphic(Line(points, pen)))
    return heads


def _port(port: Port, extent: Box) -> str:
    """Return a port with its name as a tooltip."""
    x, y = port.position[0], -port.position[1]
    color = FIELDS[port.field].color.hexadecimal
    fill = color if port.filled else "#fff"
    dashed = ' fill-opacity=".3" stroke-dasharray="4 3"' if port.conditional else ""
    style = f'fill="{fill}" stroke="{color}" stroke-width="2.5"{dashed}'
    if port.shape == "circle":
        drawn = f'<circle cx="{_n(x)}" cy="{_n(y)}" r="{_n(PORT)}" {style}>'
        closing = "</circle>"
    elif port.shape in ("in", "out"):
        drawn, closing = f'<path d="{_triangle(port, extent)}" {style}>', "</path>"
    else:
        size = _n(2 * PORT)
        drawn = (
            f'<rect x="{_n(x - PORT)}" y="{_n(y - PORT)}" width="{size}" height="{size}" {style}>'
        )
        closing = "</rect>"
    name = port.name + "[:]" * port.array
    return f"{drawn}<title>{escape(name)}</title>{closing}"


def _triangle(port: Port, extent: Box) -> str:
    """Return a triangle that points into the symbol for an input, out of it for an output."""
    x, y = port.position
    left, bottom, right, top = extent
    # Distances to the four sides decide which one the port stands on.
    side = min(
        ((x - left, (1, 0)), (right - x, (-1, 0)), (top - y, (0, -1)), (y - bottom, (0, 1))),
        key=lambda item: abs(item[0]),
    )[1]
    dx, dy = side if port.shape == "in" else (-side[0], -side[1])
    size = 1.25 * PORT
    tip = (x + size * dx, y + size * dy)
    a = (x - size * dx - size * dy, y - size * dy + size * dx)
    b = (x - size * dx + size * dy, y - size * dy - size * dx)
    return _path((tip, a, b), False) + "Z"


def _pen(pen: Pen) -> str:
    if pen.pattern == "None":
        return ""
    dashes = f' stroke-dasharray="{_DASHES[pen.pattern]}"' if pen.pattern in _DASHES else ""
    return f' stroke="{_color(pen.color)}" stroke-width="{_n(pen.width)}"{dashes}'


def _fill(fill: Fill) -> str:
    if fill.pattern == "None":
        return ""
    if fill.pattern in _HATCHED:
        return f' fill="url(#hatch-{fill.pattern})"'
    return f' fill="{_color(fill.color)}"'


def _color(color: Color | None) -> str:
    return "currentColor" if color is None else color.hexadecimal


def _n(value: float) -> str:
    """Return a number with at most one decimal place."""
    text = f"{value:.1f}".removesuffix(".0")
    return "0" if text == "-0" else text
