"""Pictures of a scene: what the player draws on a canvas, drawn by Pillow for GIF and MP4.

Both follow the same rules: sprites in the plane one over the other; in space, faces sorted by their
distance from the viewer, shaded by their direction.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from acausal.animation.geometry import Part, mixed
from acausal.animation.scene import Array, Scene, Sprite
from acausal.animation.solids import Mesh

if TYPE_CHECKING:
    from PIL.Image import Image

_PAPER = "#fbfcfd"
#: Pictures are drawn this much larger and then made smaller, so that edges are smooth.
_FINER = 2
_LIGHT = np.array([-0.4, 0.6, 0.8]) / np.sqrt(1.16)


def picture_size(scene: Scene, width: int, height: int) -> tuple[int, int]:
    """Return width and height in pixels, even numbers; a height of 0 follows the scene."""
    if not height:
        wide, high = scene.camera.extent
        height = round(width * min(1.0, max(0.35, high / wide))) if scene.dimension == 2 \
            else round(width * 0.75)  # fmt: skip
    return width - width % 2, height - height % 2


def pictures(scene: Scene, width: int, height: int, stride: int = 1) -> Iterator[Image]:
    """Draw the scene at each of its times, or at some: trails pass through all of them."""
    painter = _Painter(scene, width * _FINER, height * _FINER)
    for k in range(0, len(scene.times), stride):
        yield painter.picture(k).reduce(_FINER)


class _Painter:
    """Draws pictures of one size."""

    def __init__(self, scene: Scene, width: int, height: int) -> None:
        from PIL import ImageFont

        self.scene, self.width, self.height = scene, width, height
        self.px = min(width, height) / 600
        self.fonts: dict[int, Any] = {}
        self.font = ImageFont.load_default
        camera = scene.camera
        if scene.dimension == 2:
            self.scale = min(width / camera.extent[0], height / camera.extent[1])
        else:
            self.scale = min(width, height) / camera.extent[0] / 0.98
            self.right, self.up, self.ahead, self.east, self.north = view_axes(
                camera.azimuth, camera.elevation, np.array(camera.up)
            )
        # Arrays of the corners, once.
        self.corners: dict[int, list[Array]] = {
            id(s.geometry): [np.asarray(p.points) for p in s.geometry]
            for s in scene.sprites
            if s.geometry is not None
        }

    def picture(self, k: int) -> Image:
        """Draw the picture of time ``k``."""
        from PIL import Image, ImageDraw

        scene = self.scene
        image = Image.new("RGB", (self.width, self.height), _PAPER)
        self.draw = ImageDraw.Draw(image)
        follow = scene.camera.follow
        center = [_at(c, k) for c in follow] if follow else scene.camera.center
        self.center = np.asarray(center)
        if scene.grid:
            self._grid() if scene.dimension == 2 else self._floor()
        if scene.dimension == 2:
            for sprite in scene.sprites:
                if _seen(sprite, k):
                    self._plane(sprite, k)
        else:
            self._space(k)
        text = f"{scene.title}   {scene.times[k]:.{_digits(scene)}f} s".strip()
        self._text(12 * self.px, 10 * self.px, text, 15, "#4b5763", "la")
        return image

    # ---- in the plane ---------------------------------------------------------------------------

    def _screen(self, points: Array) -> Array:
        """Return pixels of points in the world, shape ``(n, 2)``."""
        out = (points - self.center) * self.scale
        return np.stack([self.width / 2 + out[:, 0], self.height / 2 - out[:, 1]], axis=1)

    def _plane(self, sprite: Sprite, k: int) -> None:
        c = [_at(channel, k) for channel in sprite.channels]
        if sprite.kind == "trail":
            self._trail(sprite, k, self._screen)
        elif sprite.kind == "text":
            x, y = self._screen(np.array([c]))[0]
            self._text(x, y, sprite.text, sprite.size, sprite.color, "ms")
        elif sprite.kind == "placed":
            turn = np.array([[np.cos(c[2]), np.sin(c[2])], [-np.sin(c[2]), np.cos(c[2])]])
            self._parts(sprite, lambda p: p @ turn + np.array(c[:2]))
        else:
            a, b = np.array(c[:2]), np.array(c[2:])
            length = float(np.hypot(*(b - a)))
            e = (b - a) / length if length > 0 else np.array([1.0, 0.0])
            basis = np.array([(b - a), e, [-e[1], e[0]]])
            self._parts(sprite, lambda p: p @ basis + a)

    def _parts(self, sprite: Sprite, place: Callable[[Array], Array]) -> None:
        for part, points in zip(
            sprite.geometry or (), self.corners[id(sprite.geometry)], strict=True
        ):
            assert isinstance(part, Part)
            corners = [tuple(p) for p in self._screen(place(points)).tolist()]
            if part.fill and len(corners) > 2:
                self.draw.polygon(corners, fill=part.fill)
            if part.stroke:
                width = max(1, round(abs(part.width) * self.px))
                if part.width < 0:
                    self._dashed(corners[0], corners[-1], part.stroke, width)
                else:
                    # A closed line goes on along its first side, so that its corner is round too.
                    line = [*corners, *corners[:2]] if part.closed else corners
                    self.draw.line(line, fill=part.stroke, width=width, joint="curve")

    def _dashed(self, a: Any, b: Any, color: str, width: int) -> None:
        first, last = np.array(a), np.array(b)
        n = max(1, round(float(np.hypot(*(last - first))) / (11 * self.px)))
        for k in range(n):
            ends = [first + (last - first) * (k + share) / n for share in (0.0, 0.55)]
            self.draw.line([tuple(e) for e in ends], fill=color, width=width)

    def _grid(self) -> None:
        step = _nice(90 * self.px / self.scale)
        for axis, size in ((0, self.width), (1, self.height)):
            half = size / 2 / self.scale
            middle = float(self.center[axis])
            for k in range(int(np.ceil((middle - half) / step)), int((middle + half) // step) + 1):
                at = (k * step - middle) * self.scale
                color = "#c3ccd5" if k == 0 else "#e6eaee"
                ends = [(size / 2 + at, 0), (size / 2 + at, self.height)] if axis == 0 \
                    else [(0, size / 2 - at), (self.width, size / 2 - at)]  # fmt: skip
                self.draw.line(ends, fill=color, width=max(1, round(self.px)))

    def _trail(self, sprite: Sprite, k: int, screen: Callable[[Array], Array]) -> None:
        times, n = self.scene.times, len(self.scene.times)
        first = 0
        if sprite.size > 0:
            first = int(np.searchsorted(times, times[k] - sprite.size))
        if k <= first:
            return
        channels = [np.broadcast_to(c, n)[first : k + 1] for c in sprite.channels]
        points = [tuple(p) for p in screen(np.stack(channels, axis=1))[:, :2].tolist()]
        width = max(1, round(1.8 * self.px))
        chunks = 12 if sprite.size > 0 else 1
        for chunk in range(chunks):
            a, b = (len(points) - 1) * chunk // chunks, (len(points) - 1) * (chunk + 1) // chunks
            share = 0.75 * (chunk + 1) / chunks if chunks > 1 else 0.55
            if b > a:
                color = mixed(_PAPER, sprite.color, share)
                self.draw.line(points[a : b + 1], fill=color, width=width, joint="curve")

    def _text(self, x: float, y: float, text: str, size: float, color: str, anchor: str) -> None:
        pixels = round(max(size * self.px, 12 * _FINER))
        if pixels not in self.fonts:
            self.fonts[pixels] = self.font(pixels)
        self.draw.text((x, y), text, fill=color, font=self.fonts[pixels], anchor=anchor)

    # ---- in space -------------------------------------------------------------------------------

    def _project(self, points: Array) -> Array:
        """Return pixels, distance towards the viewer and enlargement, shape ``(n, 4)``."""
        d = points - self.center
        far = 2.6 * self.scene.camera.extent[0]
        z = d @ self.ahead
        f = far / np.maximum(far - z, 0.05 * far)
        x = self.width / 2 + (d @ self.right) * f * self.scale
        y = self.height / 2 - (d @ self.up) * f * self.scale
        return np.stack([x, y, z, f], axis=1)

    def _floor(self) -> None:
        camera = self.scene.camera
        up, middle = np.array(camera.up), np.array(camera.center)
        half = 0.75 * camera.extent[0]
        step = _nice(half / 6)
        m = int(np.ceil(half / step))
        low = up * float(middle @ up + camera.floor)
        base = low + sum(np.round(middle @ v / step) * step * v for v in (self.east, self.north))
        for p, q in ((self.east, self.north), (self.north, self.east)):
            for k in range(-m, m + 1):
                ends = np.array([base + k * step * p + s * m * step * q for s in (-1, 1)])
                color = mixed(_PAPER, "#96a3b0", 0.45 * (1 - abs(k) / (m + 1)))
                line = [tuple(e) for e in self._project(ends)[:, :2].tolist()]
                self.draw.line(line, fill=color, width=max(1, round(self.px)))

    def _space(self, k: int) -> None:
        faces: list[tuple[float, int, Callable[[], None]]] = []
        for sprite in self.scene.sprites:
            if not _seen(sprite, k):
                continue
            c = np.array([_at(channel, k) for channel in sprite.channels])
            if sprite.kind == "trail":
                self._trail(sprite, k, self._project)
            elif sprite.kind in ("ball", "text"):
                q = self._project(c[None, :3])[0]
                near = 0.2 * sprite.size if sprite.kind == "ball" else self.scene.camera.extent[0]
                faces.append((q[2] + near, len(faces), partial(self._ball, sprite, q)))
            else:
                self._solid(sprite, c, faces)
        faces.sort(key=lambda face: face[:2])
        for _, _, paint in faces:
            paint()

    def _solid(self, sprite: Sprite, c: Array, faces: list[Any]) -> None:
        if sprite.kind == "placed":
            x = c[3:6] / max(float(np.sqrt(c[3:6] @ c[3:6])), 1e-300)
            y = c[6:9] - (c[6:9] @ x) * x
            y = y / max(float(np.sqrt(y @ y)), 1e-300)
            basis = np.array([x, y, np.cross(x, y)])
        else:
            d = c[3:6] - c[:3]
            length = float(np.sqrt(d @ d))
            e = d / length if length > 0 else np.array([1.0, 0.0, 0.0])
            least = np.eye(3)[0 if abs(e[0]) < 0.6 else 1]
            f = least - (e @ least) * e
            f = f / np.sqrt(f @ f)
            basis = np.array([d, e, f, np.cross(e, f)])
        for mesh, points in zip(
            sprite.geometry or (), self.corners[id(sprite.geometry)], strict=True
        ):
            assert isinstance(mesh, Mesh)
            at = self._project(points @ basis + c[:3])
            for face in mesh.faces:
                p = at[list(face)]
                corners = [tuple(q) for q in p[:, :2].tolist()]
                z = float(p[:, 2].mean())
                if mesh.lines:
                    width = max(1, round(mesh.width * self.px))
                    stroke = partial(self.draw.line, corners, mesh.color, width, "curve")
                    faces.append((z, len(faces), stroke))
                    continue
                x, y = p[:, 0], p[:, 1]
                if float((np.roll(x, 1) * y - x * np.roll(y, 1)).sum()) >= 0:
                    continue
                a, b = (
                    np.array([(v[0] - u[0]) / self.scale, (u[1] - v[1]) / self.scale, v[2] - u[2]])
                    for u, v in ((p[0], p[1]), (p[1], p[2]))
                )
                normal = np.cross(a, b)
                size = float(np.sqrt(normal @ normal)) or 1.0
                color = shaded(mesh.color, 0.62 + 0.5 * max(0.0, float(normal @ _LIGHT) / size))
                faces.append((z, len(faces), partial(self.draw.polygon, corners, color, color)))

    def _ball(self, sprite: Sprite, q: Array) -> None:
        if sprite.kind == "text":
            return self._text(q[0], q[1], sprite.text, sprite.size, sprite.color, "ms")
        radius = max(sprite.size * self.scale * float(q[3]), 1.0)
        for k in range(12):
            share = k / 11
            r = radius * (1 - 0.85 * share)
            x, y = q[0] - 0.32 * radius * share, q[1] - 0.36 * radius * share
            light = 0.6 + 0.9 * share
            self.draw.ellipse((x - r, y - r, x + r, y + r), fill=shaded(sprite.color, light))
        return None


def view_axes(azimuth: float, elevation: float, up: Array) -> tuple[Array, ...]:
    """Return right, up and towards the viewer on the screen, then east and north on the floor."""
    helper = np.array([0.0, 0.0, -1.0] if abs(up[1]) > 0.9 else [0.0, 1.0, 0.0])
    east = np.cross(helper, up)
    east = east / np.sqrt(east @ east)
    north = np.cross(up, east)
    a, e = np.radians(azimuth), np.radians(elevation)
    ahead = east * np.sin(a) - north * np.cos(a)
    viewer = ahead * np.cos(e) + up * np.sin(e)
    right = np.cross(up, ahead)
    return right, np.cross(viewer, right), viewer, east, north


def shaded(color: str, light: float) -> str:
    """Return a colour in less light (below 1) or more (up to 2)."""
    if light > 1:
        return mixed(color, "#ffffff", min(light - 1, 1.0))
    return mixed("#000000", color, light)


def _at(channel: Array, k: int) -> float:
    return float(channel[k] if len(channel) > 1 else channel[0])


def _seen(sprite: Sprite, k: int) -> bool:
    return sprite.visible is None or _at(sprite.visible, k) > 0.5


def _nice(x: float) -> float:
    power = 10.0 ** np.floor(np.log10(x))
    m = x / power
    return float((1 if m < 1.5 else 2 if m < 3.5 else 5 if m < 7.5 else 10) * power)


def _digits(scene: Scene) -> int:
    duration = float(scene.times[-1] - scene.times[0])
    return max(1, min(6, 2 - int(np.floor(np.log10(duration)))))
