"""Outlines of shapes in the plane, as parts that are filled and stroked.

A *placed* outline has points ``(x, y)`` in metres, seen from a frame that moves. A *stretched* one
lies between two points that move: ``(u, w, v)`` is ``u`` of the way from the first to the second,
plus ``w`` metres along it, and ``v`` metres to its left.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

Point = tuple[float, ...]

DARK = "#2f3b47"
PALE = "#f4f6f8"
STEEL = "#8d9cab"
#: Colours of bodies, one after the other.
PALETTE = ("#3b78b5", "#e08a2e", "#4f9d69", "#8566a8", "#c8504f", "#3a9a9a", "#b08d3c", "#6b7fae")
NAMED = {
    "blue": "#3b78b5", "orange": "#e08a2e", "green": "#4f9d69", "purple": "#8566a8",
    "red": "#c8504f", "teal": "#3a9a9a", "gold": "#c9a227", "grey": "#8a94a0", "gray": "#8a94a0",
    "dark": DARK, "steel": STEEL, "pale": PALE, "black": "#1c232b", "white": "#ffffff",
    "yellow": "#e9c83c", "brown": "#8a6242", "sky": "#a9cbe8",
}  # fmt: skip


@dataclass(frozen=True)
class Part:
    """A line or area.

    Attributes:
        points: Its corners.
        fill: Colour inside, empty for none.
        stroke: Colour of the line, empty for none.
        width: Width of the line in pixels of a picture 600 pixels high.
        closed: The last point is joined to the first.
    """

    points: tuple[Point, ...]
    fill: str = ""
    stroke: str = ""
    width: float = 1.5
    closed: bool = True


Outline = tuple[Part, ...]


def mixed(color: str, other: str, share: float) -> str:
    """Return a colour with a share of another one in it, both ``#rrggbb``."""
    a, b = (tuple(int(c[k : k + 2], 16) for k in (1, 3, 5)) for c in (color, other))
    return "#" + "".join(f"{round(x + (y - x) * share):02x}" for x, y in zip(a, b, strict=True))


def darker(color: str) -> str:
    """Return the colour of an edge."""
    return mixed(color, "#101820", 0.4)


def arc(radius: float, start: float, end: float, n: int, x: float = 0, y: float = 0) -> list[Point]:
    """Return ``n + 1`` points on a circle from one angle to another, radians."""
    return [
        (
            x + radius * math.cos(start + (end - start) * k / n),
            y + radius * math.sin(start + (end - start) * k / n),
        )
        for k in range(n + 1)
    ]


def disc(radius: float, n: int = 40) -> tuple[Point, ...]:
    """Return the corners of a polygon that looks like a circle."""
    return tuple(arc(radius, 0, 2 * math.pi, n)[:-1])


def circle(radius: float, color: str, marked: bool = False) -> Outline:
    """A ball: its edge and a highlight; marked, two quarters show how it turns."""
    parts = [Part(disc(radius), color, darker(color))]
    if marked:
        light = mixed(color, "#ffffff", 0.55)
        for k in (0, 2):
            quarter = arc(radius * 0.86, k * math.pi / 2, (k + 1) * math.pi / 2, 12)
            parts.append(Part(((0.0, 0.0), *quarter), light))
    else:
        light = mixed(color, "#ffffff", 0.45)
        spot = arc(radius * 0.32, 0, 2 * math.pi, 20, -0.3 * radius, 0.32 * radius)
        parts.append(Part(tuple(spot[:-1]), light))
    return tuple(parts)


def pin(radius: float, color: str = DARK) -> Outline:
    """A hinge."""
    return (Part(disc(radius, 24), PALE, color, 2.0), Part(disc(radius * 0.3, 12), color))


def ground(size: float) -> Outline:
    """A hinge fixed in the world: a foot with hatching, and the pin."""
    w, h = size * 1.3, size * 1.7
    foot = ((-w * 0.28, 0.0), (-w, -h), (w, -h), (w * 0.28, 0.0))
    return (Part(foot, "#cdd5dd", DARK), *hatched(-w * 1.5, w * 1.5, -h, size * 0.6))


def hatched(left: float, right: float, y: float, depth: float) -> Outline:
    """A level surface, hatched below."""
    n = max(3, min(200, round((right - left) / depth)))
    step = (right - left) / n
    strokes = tuple(
        Part(
            ((left + k * step, y - depth), (left + k * step + depth, y)), "", "#7b8794", 1.0, False
        )
        for k in range(n)
        if left + k * step + depth <= right + 1e-9
    )
    return (*strokes, Part(((left, y), (right, y)), "", DARK, 2.0, False))


def box(length: float, width: float, color: str) -> Outline:
    """A rectangle about its middle."""
    a, b = length / 2, width / 2
    return (
        Part(((-a, -b), (a, -b), (a, b), (-a, b)), color, darker(color)),
        Part(
            ((-a * 0.94, b * 0.55), (a * 0.94, b * 0.55),
             (a * 0.94, b * 0.85), (-a * 0.94, b * 0.85)),
            mixed(color, "#ffffff", 0.3),
        ),
    )  # fmt: skip


def wheel(radius: float, color: str) -> Outline:
    """A wheel seen from the side, with spokes."""
    rim = Part(disc(radius, 48), "#3d4650", "#20262d")
    face = Part(disc(radius * 0.76, 48), mixed(color, "#ffffff", 0.75), "#20262d", 1.0)
    spokes = []
    for k in range(5):
        c, s = math.cos(k * 0.4 * math.pi), math.sin(k * 0.4 * math.pi)
        end = (radius * 0.74 * c, radius * 0.74 * s)
        spokes.append(Part(((0.0, 0.0), end), "", color if k else DARK, 3.0, False))
    return (rim, face, *spokes, Part(disc(radius * 0.15, 16), DARK))


def gear(radius: float, teeth: int, color: str, inside: bool = False) -> Outline:
    """A gear wheel with its pitch circle and a spoke that shows how it turns."""
    depth = math.pi * radius / teeth * 0.6
    corners: list[Point] = []
    for k in range(teeth):
        for part, r in ((-0.30, -1), (-0.16, 1), (0.16, 1), (0.30, -1)):
            angle = (k + part) * 2 * math.pi / teeth
            rr = radius + r * depth / 2
            corners.append((rr * math.cos(angle), rr * math.sin(angle)))
    if inside:
        return (
            Part(tuple(corners), "", darker(color), 2.0),
            Part(disc(radius * 1.12, 64), "", color, 6.0),
        )
    mark = Part(((0.0, 0.0), (radius * 0.8, 0.0)), "", darker(color), 3.0, False)
    hub = Part(disc(radius * 0.2, 20), PALE, darker(color))
    return (Part(tuple(corners), color, darker(color)), mark, hub)  # fmt: skip


def tyre(radius: float, width: float) -> Outline:
    """A wheel seen from above, its x axis ahead."""
    a, b = radius, width / 2
    body = rounded(a, b, b * 0.6)
    grooves = [
        Part(((-a * 0.85, y), (a * 0.85, y)), "", "#6b747e", 1.0, False)
        for y in (-b * 0.35, b * 0.35)
    ]
    return (Part(body, "#2b3138", "#12161a"), *grooves)


def rounded(a: float, b: float, r: float) -> tuple[Point, ...]:
    """Return a rectangle ``2 a`` by ``2 b`` with round corners."""
    corners: list[Point] = []
    for k, (x, y) in enumerate(((a - r, b - r), (r - a, b - r), (r - a, r - b), (a - r, r - b))):
        corners += arc(r, k * math.pi / 2, (k + 1) * math.pi / 2, 5, x, y)
    return tuple(corners)


def car(front: float, rear: float, width: float, color: str) -> Outline:
    """A car seen from above: ``front`` and ``rear`` are the distances of its axles."""
    wheelbase = front + rear
    nose, tail, w = front + 0.32 * wheelbase, rear + 0.36 * wheelbase, width / 2

    def outline(*points: Point) -> tuple[Point, ...]:
        return (*points, *((x, -y) for x, y in reversed(points)))

    x = [-tail + (nose + tail) * k for k in (0, 0.05, 0.3, 0.62, 0.75, 0.95, 1)]
    shell = outline(
        (x[0], w * 0.72), (x[1], w * 0.93), (x[2], w), (x[3], w), (x[5], w * 0.84), (x[6], w * 0.5)
    )
    roof = outline((x[2], w * 0.74), (x[3] - 0.1 * wheelbase, w * 0.72))
    screen = outline((x[3] - 0.08 * wheelbase, w * 0.72), (x[3] + 0.06 * wheelbase, w * 0.84))
    window = outline((x[2] - 0.16 * wheelbase, w * 0.8), (x[2] - 0.02 * wheelbase, w * 0.74))
    glass, light = "#d3e4ef", mixed(color, "#ffffff", 0.35)
    return (
        Part(shell, color, darker(color), 2.0),
        Part(roof, light, darker(color), 1.0),
        Part(screen, glass, darker(color), 1.0),
        Part(window, glass, darker(color), 1.0),
    )  # fmt: skip


def rod(width: float, color: str) -> Outline:
    """A bar with round ends, stretched."""
    r = width / 2
    first = [(0.0, x, y) for x, y in arc(r, math.pi / 2, 1.5 * math.pi, 10)]
    last = [(1.0, x, y) for x, y in arc(r, -math.pi / 2, math.pi / 2, 10)]
    return (Part((*first, *last), color, darker(color)),)


def line(thickness: float, color: str) -> Outline:
    """A line, stretched; thickness in pixels."""
    return (Part(((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), "", color, thickness, False),)


def spring(radius: float, coils: int, color: str) -> Outline:
    """A coil spring seen from the side, stretched."""
    points: list[Point] = [(0.0, 0.0, 0.0), (0.1, 0.0, 0.0)]
    for k in range(2 * coils):
        points.append((0.1 + 0.8 * (k + 0.5) / (2 * coils), 0.0, radius * (1 - 2 * (k % 2))))
    points += [(0.9, 0.0, 0.0), (1.0, 0.0, 0.0)]
    return (Part(tuple(points), "", color, 2.5, False),)


def damper(radius: float, color: str) -> Outline:
    """A cylinder with a piston, stretched."""
    r = radius
    pot = ((0.62, 0.0, r), (0.2, 0.0, r), (0.2, 0.0, -r), (0.62, 0.0, -r))
    inside = mixed(color, "#ffffff", 0.7)
    return (
        Part(((0.0, 0.0, 0.0), (0.2, 0.0, 0.0)), "", DARK, 2.0, False),
        Part(pot, inside, ""),
        Part(pot, "", color, 2.5, False),
        Part(((0.45, 0.0, 0.0), (1.0, 0.0, 0.0)), "", DARK, 2.0, False),
        Part(((0.45, 0.0, 0.8 * r), (0.45, 0.0, -0.8 * r)), "", DARK, 3.0, False),
    )


def beside(outline: Outline, shift: float) -> Outline:
    """Move a stretched outline to its left and join its ends to the two points by lines."""
    if not shift:
        return outline
    moved = [
        Part(tuple((u, w, v + shift) for u, w, v in p.points), p.fill, p.stroke, p.width, p.closed)
        for p in outline
    ]
    ends = [Part(((u, 0.0, 0.0), (u, 0.0, shift)), "", DARK, 2.0, False) for u in (0.0, 1.0)]
    return (*ends, *moved)


def piston(radius: float, color: str) -> Outline:
    """A block that reaches from one point to the other, stretched."""
    r = radius
    block = ((0.0, 0.0, -r), (1.0, 0.0, -r), (1.0, 0.0, r), (0.0, 0.0, r))
    light = ((0.0, 0.0, 0.35 * r), (1.0, 0.0, 0.35 * r), (1.0, 0.0, 0.65 * r), (0.0, 0.0, 0.65 * r))
    return (Part(block, color, darker(color)), Part(light, mixed(color, "#ffffff", 0.35)))


def arrow(width: float, color: str) -> Outline:
    """An arrow from one point to the other, stretched."""
    a, b, h = width / 2, width * 1.3, width * 3
    shaft = ((0.0, 0.0, -a), (1.0, -h, -a), (1.0, -h, -b), (1.0, 0.0, 0.0))
    mirror = ((1.0, -h, b), (1.0, -h, a), (0.0, 0.0, a))
    return (Part((*shaft, *mirror), color, darker(color), 1.0),)


def polygon(points: Sequence[Point], color: str) -> Outline:
    """An area fixed in a frame."""
    return (Part(tuple(points), color, darker(color)),)
