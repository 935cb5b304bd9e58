"""Solids in space as meshes of flat faces, in the same two manners as outlines in the plane.

A *placed* mesh has corners ``(x, y, z)`` seen from a frame; a *stretched* one ``(u, w, p, q)``:
``u`` of the way between two points plus ``w`` metres, ``p`` and ``q`` metres across. Corners of a
face go counter-clockwise seen from outside.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acausal.animation.geometry import DARK, Point, mixed

Vector = tuple[float, float, float]
SIDES = 20


@dataclass(frozen=True)
class Mesh:
    """Flat faces of one colour, or lines.

    Attributes:
        points: Corners.
        faces: Numbers of corners, each face convex.
        color: Colour in full light.
        lines: The faces are polylines instead.
        width: Width of lines in pixels of a picture 600 pixels high.
    """

    points: tuple[Point, ...]
    faces: tuple[tuple[int, ...], ...]
    color: str
    lines: bool = False
    width: float = 1.5


Solid = tuple[Mesh, ...]


def _axes(direction: Sequence[float], side: Sequence[float]) -> tuple[np.ndarray, ...]:
    """Return three perpendicular unit vectors: along, as near to ``side`` as can be, across."""
    along = np.asarray(direction, dtype=np.float64)
    size = float(np.sqrt(along @ along))
    along = along / size if size > 0 else np.array([1.0, 0.0, 0.0])
    across = np.asarray(side, dtype=np.float64)
    across = across - (across @ along) * along
    if across @ across < 1e-12:
        other = np.eye(3)[int(np.argmin(np.abs(along)))]
        across = other - (other @ along) * along
    across = across / np.sqrt(across @ across)
    return along, across, np.cross(along, across)


def box(
    begin: Sequence[float], direction: Sequence[float], side: Sequence[float],
    length: float, width: float, height: float, color: str,
) -> Solid:  # fmt: skip
    """A box whose length begins at a point and goes in a direction; the width points to a side."""
    along, across, up = _axes(direction, side)
    start = np.asarray(begin, dtype=np.float64)
    corners = [
        tuple(float(c) for c in start + a * length * along + b * width * across + c * height * up)
        for a in (0.0, 1.0)
        for b in (-0.5, 0.5)
        for c in (-0.5, 0.5)
    ]
    faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return (Mesh(tuple(corners), faces, color),)


def _tube(rings: Sequence[tuple[Point, float]], color: str, lift: bool) -> tuple[list[Point], Mesh]:
    """Return rim points and the mantle of a surface of revolution in ``(u, w, p, q)``."""
    points: list[Point] = []
    for (u, w), radius in rings:
        for k in range(SIDES):
            a = 2 * math.pi * k / SIDES
            points.append((u, w, radius * math.cos(a), radius * math.sin(a)))
    faces: list[tuple[int, ...]] = []
    for ring in range(len(rings) - 1):
        for k in range(SIDES):
            i, j = ring * SIDES + k, ring * SIDES + (k + 1) % SIDES
            faces.append((i, j, j + SIDES, i + SIDES))
    if lift:
        last = (len(rings) - 1) * SIDES
        faces.append(tuple(range(SIDES - 1, -1, -1)))
        faces.append(tuple(range(last, last + SIDES)))
    return points, Mesh(tuple(points), tuple(faces), color)


def rod(radius: float, color: str, pieces: int = 4, start: float = 0.0, end: float = 1.0) -> Solid:
    """A round bar between two points, stretched; in pieces, so that it can pass behind others."""
    rings = [((start + (end - start) * k / pieces, 0.0), radius) for k in range(pieces + 1)]
    return (_tube(rings, color, True)[1],)


def damper(radius: float, color: str) -> Solid:
    """A pot and a rod, stretched."""
    return (*rod(radius, color, 2, 0.12, 0.6), *rod(radius * 0.4, "#c9d1d9", 2, 0.6, 1.0),
            *rod(radius * 0.4, DARK, 1, 0.0, 0.12))  # fmt: skip


def arrow(width: float, color: str) -> Solid:
    """An arrow between two points, stretched."""
    head = 5 * width
    shaft = _tube([((0.0, 0.0), width / 2), ((1.0, -head), width / 2)], color, True)[1]
    tip = _tube([((1.0, -head), width * 1.5), ((1.0, 0.0), width * 0.02)], color, True)[1]
    return (shaft, tip)


def spring(radius: float, coils: int, color: str) -> Solid:
    """A coil spring, stretched."""
    points: list[Point] = [(0.0, 0.0, 0.0, 0.0), (0.08, 0.0, 0.0, 0.0)]
    n = 14 * coils
    for k in range(n + 1):
        a = 2 * math.pi * k / 14
        points.append((0.08 + 0.84 * k / n, 0.0, radius * math.cos(a), radius * math.sin(a)))
    points += [(0.92, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)]
    pieces = tuple(tuple(range(k, min(k + 4, len(points)))) for k in range(0, len(points) - 1, 3))
    return (Mesh(tuple(points), pieces, color, True, 2.6),)


def line(color: str, thickness: float) -> Solid:
    """A line between two points, stretched."""
    points = tuple((k / 6, 0.0, 0.0, 0.0) for k in range(7))
    return (Mesh(points, tuple((k, k + 1) for k in range(6)), color, True, thickness),)


def cylinder(
    begin: Sequence[float], axis: Sequence[float], length: float, radius: float, color: str,
    marked: bool = False,
) -> Solid:  # fmt: skip
    """A cylinder fixed in a frame; marked, sectors of its ends show how it turns."""
    along, p, q = _axes(axis, (0.0, 0.0, 1.0))
    start = np.asarray(begin, dtype=np.float64)

    def at(points: Sequence[Point]) -> tuple[Point, ...]:
        return tuple(
            tuple(float(c) for c in start + u * length * along + a * p + b * q)
            for u, _, a, b in points
        )

    points, mantle = _tube([((k / 2, 0.0), radius) for k in range(3)], color, not marked)
    solid = [Mesh(at(points), mantle.faces, color)]
    if marked:
        light = mixed(color, "#ffffff", 0.6)
        for end in (0.0, 1.0):
            for share in (0, 1):
                ring: list[Point] = [(end, 0.0, 0.0, 0.0)]
                ring += [(end, 0.0, c[2], c[3]) for c in points[:SIDES]]
                faces = []
                for sector in range(share, 4, 2):
                    each = SIDES // 4
                    rim = [1 + (sector * each + k) % SIDES for k in range(each + 1)]
                    faces.append((0, *(rim if end else rim[::-1])))
                solid.append(Mesh(at(ring), tuple(faces), light if share else color))
    return tuple(solid)


def wheel(axis: Sequence[float], radius: float, width: float, color: str) -> Solid:
    """A wheel with a tyre about an axis of its frame."""
    along, p, q = _axes(axis, (0.0, 0.0, 1.0))
    rubber, light = "#3d4650", mixed(color, "#ffffff", 0.65)
    n = 2 * SIDES
    rims: list[Point] = []
    for side, r in ((-0.5, radius * 0.7), (-0.5, radius), (0.5, radius), (0.5, radius * 0.7)):
        for k in range(n):
            a = 2 * math.pi * k / n
            corner = side * width * along + r * (math.cos(a) * p + math.sin(a) * q)
            rims.append(tuple(float(c) for c in corner))
    faces = []
    for ring in range(3):
        for k in range(n):
            i, j = ring * n + k, ring * n + (k + 1) % n
            faces.append((i, j, j + n, i + n))
    parts = [Mesh(tuple(rims), tuple(faces), rubber)]
    for side, first in ((-0.35, 0), (0.35, 3 * n)):
        inwards = (side - (0.5 if side > 0 else -0.5)) * width * along
        inner = tuple(
            tuple(float(c) for c in np.asarray(rims[first + k]) + inwards) for k in range(n)
        )
        middle = tuple(float(c) for c in side * width * along)
        for share in (0, 1):
            sectors = []
            for sector in range(share, 8, 2):
                each = n // 8
                rim = [1 + (sector * each + k) % n for k in range(each + 1)]
                sectors.append((0, *(rim if side > 0 else rim[::-1])))
            parts.append(Mesh((middle, *inner), tuple(sectors), light if share else color))
    return tuple(parts)


def line_along(end: Sequence[float], color: str) -> Solid:
    """A line from the origin of a frame."""
    points = tuple(tuple(float(x) * k / 4 for x in end) for k in range(5))
    return (Mesh(points, tuple((k, k + 1) for k in range(4)), color, True, 2.5),)
