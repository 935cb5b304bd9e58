"""A scene: sprites with the numbers that move them, at the times of the pictures.

What a player or a renderer needs and nothing else: it knows no models, classes or variables.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.animation.geometry import Outline
from acausal.animation.solids import Solid

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Sprite:
    """One shape.

    Attributes:
        kind: ``placed`` (channels x, y, angle; in space x, y, z, and the frame's x and y axes),
            ``stretched`` (two points), ``ball`` (x, y, z), ``trail`` and ``text`` (a point).
        channels: Numbers over time, each of shape ``(nt,)`` or ``(1,)``; metres and radians.
        geometry: Outline or solid; None for balls, trails and texts.
        name: Path of the component it belongs to.
        layer: In the plane, what is drawn over what.
        color: Colour of balls, trails and texts.
        size: Radius of a ball, duration of a trail (0: all of it), height of a text in pixels.
        text: What a text says.
        visible: Drawn where above one half; None for always.
        scenery: It does not count for what the camera shows.
    """

    kind: str
    channels: tuple[Array, ...]
    geometry: Outline | Solid | None = None
    name: str = ""
    layer: float = 0.0
    color: str = ""
    size: float = 0.0
    text: str = ""
    visible: Array | None = None
    scenery: bool = False


@dataclass(frozen=True)
class Camera:
    """From where a scene is seen.

    Attributes:
        center: Middle of what is seen, metres, 2 or 3 numbers.
        extent: Width and height of what is seen in the plane, metres; in space the diameter twice.
        azimuth, elevation: Direction from which a scene in space is seen, degrees.
        up: The vertical in space.
        follow: Channels of the point the camera goes with, if it does.
        floor: Height of the floor in space against the middle, metres.
    """

    center: tuple[float, ...]
    extent: tuple[float, float]
    azimuth: float = 35.0
    elevation: float = 18.0
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    follow: tuple[Array, ...] = ()
    floor: float = 0.0


@dataclass(frozen=True, eq=False)
class Scene:
    """A scene over time.

    Attributes:
        times: Times of the pictures, equidistant, seconds, shape ``(nt,)``.
        dimension: 2 or 3.
        sprites: In the order in which they are drawn in the plane.
        camera: From where it is seen.
        speed: Simulated seconds per second.
        title: Name of the model.
        subtitle: Its description.
        grid: Whether a grid shows how large things are.
    """

    times: Array
    dimension: int
    sprites: tuple[Sprite, ...]
    camera: Camera
    speed: float
    title: str = ""
    subtitle: str = ""
    grid: bool = True


def picture_times(
    start: float, stop: float, speed: float, fps: float, most: int
) -> NDArray[np.float64]:
    """Return equidistant times of pictures, seconds, at most ``most`` of them."""
    n = round((stop - start) / speed * fps) + 1
    return np.linspace(start, stop, max(2, min(most, n)))


def suited_speed(duration: float) -> float:
    """Return a round number of simulated seconds per second that gives some ten seconds."""
    if 3.0 <= duration <= 30.0:
        return 1.0
    wanted = duration / 10.0
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(f"{min((1, 2, 5, 10), key=lambda k: abs(k * power - wanted)) * power:.3g}")
