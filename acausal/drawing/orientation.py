"""Symbols turned by quarters and mirrored; texts in them stay upright."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from acausal.reference.graphics import (
    Box,
    Ellipse,
    Graphic,
    Line,
    Placed,
    Point,
    Polygon,
    Rectangle,
    Symbol,
    Text,
)


@dataclass(frozen=True, slots=True)
class Orientation:
    """Mirrored about the vertical axis, then turned counter-clockwise by quarters."""

    quarters: int = 0
    mirrored: bool = False

    def point(self, x: float, y: float) -> Point:
        """Return where a point about the middle of a symbol comes to; y points up."""
        if self.mirrored:
            x = -x
        for _ in range(self.quarters):
            x, y = -y, x
        return x + 0.0, y + 0.0


UPRIGHT = Orientation()
ORIENTATIONS = tuple(Orientation(q, m) for m in (False, True) for q in range(4))


def turned(symbol: Symbol, orientation: Orientation) -> Symbol:
    """Return a symbol in another orientation, with its middle at the origin."""
    left, bottom, right, top = symbol.extent
    cx, cy = (left + right) / 2, (bottom + top) / 2

    def at(point: Point) -> Point:
        return orientation.point(point[0] - cx, point[1] - cy)

    graphics = tuple(_turned(g, at, orientation) for g in symbol.graphics)
    cuts = tuple(replace(c, position=at(c.position)) for c in symbol.cuts)
    return replace(
        symbol,
        graphics=graphics,
        cuts=cuts,
        ports={c.name: c.position for c in cuts},
        extent=_box(symbol.extent, at),
    )


def _box(extent: Box, at: Callable[[Point], Point]) -> Box:
    (x1, y1), (x2, y2) = at((extent[0], extent[1])), at((extent[2], extent[3]))
    return min(x1, x2), min(y1, y2), max(x1, x2), max(y1, y2)


def _turned(graphic: Graphic, at: Callable[[Point], Point], by: Orientation) -> Graphic:
    match graphic:
        case Line() | Polygon():
            return replace(graphic, points=tuple(at(p) for p in graphic.points))
        case Rectangle():
            return replace(graphic, extent=_box(graphic.extent, at))
        case Ellipse():
            start, end = graphic.start, graphic.end
            if end - start < 360 and start - end < 360:
                if by.mirrored:
                    start, end = 180 - end, 180 - start
                start, end = start + 90 * by.quarters, end + 90 * by.quarters
            return replace(graphic, extent=_box(graphic.extent, at), start=start, end=end)
        case Text():
            x1, y1, x2, y2 = graphic.extent
            x, y = at(((x1 + x2) / 2, (y1 + y2) / 2))
            w, h = (x2 - x1) / 2, (y2 - y1) / 2
            align = "Center" if by != UPRIGHT else graphic.align
            return replace(graphic, extent=(x - w, y - h, x + w, y + h), align=align)
        case Placed():
            rotation, primitive = graphic.rotation, graphic.primitive
            if by.mirrored:
                mirror = Orientation(0, True)
                inner = _turned(primitive, lambda p: mirror.point(*p), mirror)
                assert not isinstance(inner, Placed)
                rotation, primitive = -rotation, inner
            turned_by = (rotation + 90 * by.quarters) % 360
            return replace(
                graphic, primitive=primitive, origin=at(graphic.origin), rotation=turned_by
            )


def drawn_box(symbol: Symbol) -> Box:
    """Return the box around everything that is drawn of a symbol, ports left out."""
    xs: list[float] = []
    ys: list[float] = []
    for graphic in symbol.graphics:
        for x, y in _corners(graphic):
            xs.append(x)
            ys.append(y)
    if not xs:
        return symbol.extent
    return min(xs), min(ys), max(xs), max(ys)


def _corners(graphic: Graphic) -> list[Point]:
    if isinstance(graphic, Line | Polygon):
        return list(graphic.points)
    if isinstance(graphic, Placed):
        quarters = round(graphic.rotation / 90) % 4
        turn = Orientation(quarters)
        x0, y0 = graphic.origin
        return [
            (x0 + p[0], y0 + p[1]) for p in (turn.point(*c) for c in _corners(graphic.primitive))
        ]
    x1, y1, x2, y2 = graphic.extent
    return [(x1, y1), (x2, y2)]
