"""A scene as one web page that needs nothing else: numbers, drawing and controls are inside."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from acausal.animation.build import extent_of
from acausal.animation.geometry import Part
from acausal.animation.scene import Array, Scene

_HERE = Path(__file__).parent


def page(scene: Scene) -> str:
    """Return a scene as an HTML page; the same scene gives the same text."""
    text = json.dumps(record(scene), separators=(",", ":"), ensure_ascii=False)
    return Template((_HERE / "page.html").read_text(encoding="utf-8")).substitute(
        title=escape(scene.title),
        subtitle=escape(scene.subtitle),
        # Nothing in a text may end the script element it stands in.
        scene=text.replace("<", "\\u003c"),
        player=(_HERE / "player.js").read_text(encoding="utf-8"),
    )


def record(scene: Scene) -> dict[str, Any]:
    """Return what the player gets: plain data, moving numbers packed as 32-bit floats."""
    packed = _Packed(scene)
    geometries: dict[tuple[Any, ...], int] = {}
    sprites = []
    for sprite in scene.sprites:
        entry: dict[str, Any] = {"kind": sprite.kind, "c": packed.references(sprite.channels)}
        if sprite.geometry is not None:
            entry["g"] = geometries.setdefault(tuple(sprite.geometry), len(geometries))
        if sprite.color and sprite.geometry is None:
            entry["color"] = sprite.color
        if sprite.size:
            entry["size"] = _short(sprite.size)
        elif sprite.kind == "trail":
            entry["size"] = 0
        if sprite.text:
            entry["text"] = sprite.text
        if sprite.name:
            entry["name"] = sprite.name
        if sprite.visible is not None:
            entry["visible"] = packed.references([sprite.visible])[0]
        sprites.append(entry)
    camera = scene.camera
    seen: dict[str, Any] = {
        "center": [_short(c) for c in camera.center],
        "extent": [_short(c) for c in camera.extent],
        "azimuth": camera.azimuth,
        "elevation": camera.elevation,
        "follow": packed.references(camera.follow),
    }
    if scene.dimension == 3:
        seen["up"] = list(camera.up)
        seen["floor"] = _short(camera.floor)
    elif camera.follow:
        low, high = extent_of(scene.sprites, scene.dimension)
        seen["whole"] = [_short(float(x) * 1.1) for x in high - low]
    duration = float(scene.times[-1] - scene.times[0])
    return {
        "title": scene.title,
        "dimension": scene.dimension,
        "start": float(scene.times[0]),
        "stop": float(scene.times[-1]),
        "n": len(scene.times),
        "speed": scene.speed,
        "digits": max(2, min(6, 2 - int(np.floor(np.log10(duration))))) if duration < 100 else 1,
        "grid": scene.grid,
        "camera": seen,
        "geometries": [[_geometry(part) for part in geometry] for geometry in geometries],
        "sprites": sprites,
        "data": packed.text(),
    }


class _Packed:
    """Channels that change, each once; constants stay plain numbers."""

    def __init__(self, scene: Scene) -> None:
        self.n = len(scene.times)
        # A millionth of what is seen is no difference that anyone could see, or that should make
        # two files differ.
        self.digits = 6 - int(np.floor(np.log10(max(scene.camera.extent))))
        self.rows: dict[bytes, int] = {}

    def references(self, channels: Sequence[Array]) -> list[float | list[int]]:
        """Return a number for a constant channel, ``[row]`` for one that changes."""
        result: list[float | list[int]] = []
        for channel in channels:
            rounded = np.round(np.nan_to_num(channel), max(5, self.digits)) + 0.0
            if (rounded == rounded[0]).all():
                result.append(float(f"{rounded[0]:.9g}"))
            else:
                row = np.broadcast_to(rounded, self.n).astype("<f4").tobytes()
                result.append([self.rows.setdefault(row, len(self.rows))])
        return result

    def text(self) -> str:
        """Return all rows one after the other in base 64."""
        return base64.b64encode(b"".join(self.rows)).decode("ascii")


def _short(number: float) -> float:
    return float(f"{number:.6g}")


def _geometry(part: Any) -> dict[str, Any]:
    flat = [_short(x) for point in part.points for x in point]
    if isinstance(part, Part):
        entry: dict[str, Any] = {"d": len(part.points[0]), "p": flat}
        if part.fill:
            entry["fill"] = part.fill
        if part.stroke:
            entry |= {"stroke": part.stroke, "width": part.width}
        if part.closed:
            entry["closed"] = True
        return entry
    entry = {"d": len(part.points[0]), "p": flat, "faces": [list(f) for f in part.faces]}
    entry["color"] = part.color
    if part.lines:
        entry |= {"lines": True, "width": part.width}
    return entry
