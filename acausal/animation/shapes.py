"""Shapes of annotations become sprites: arguments are evaluated, missing sizes are chosen."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from acausal.animation import geometry, solids
from acausal.animation.annotations import Shape
from acausal.animation.geometry import NAMED, PALETTE, STEEL
from acausal.animation.scene import Array, Sprite
from acausal.animation.values import Place, Values, stacked
from acausal.diagnostics import fail
from acausal.syntax import tree

_LAYERS = {
    "Trail": -3.0, "Wall": -2.0, "Ground": -1.0, "Car": 0.5, "Tyre": 0.0, "Spring": 0.2,
    "Damper": 0.1, "Rod": 1.0, "Line": 0.9, "Piston": 1.0, "Box": 1.1, "Gear": 1.2, "Wheel": 1.2,
    "Polygon": 1.1, "Circle": 2.0, "Sphere": 2.0, "Joint": 3.0, "Arrow": 4.0, "Text": 5.0,
}  # fmt: skip
_COLORS = {
    "Spring": "#6c7a88", "Damper": "#6c7a88", "Line": "#56636f", "Joint": "#39434d",
    "Arrow": NAMED["red"], "Trail": NAMED["orange"], "Text": "#4b5763",
    "Cylinder": NAMED["orange"],
}  # fmt: skip


@dataclass(frozen=True)
class Context:
    """What a shape is made with.

    Attributes:
        values: Variables and parameters.
        prefix: Path of the component.
        loop: Values of loop variables.
        number: Number of the component among those drawn, chooses a colour.
        unit: Length that looks small in the scene, metres.
        dimension: 2 or 3.
        along: Moves a point of a line into the plane, by the path of its flange.
    """

    values: Values
    prefix: str
    loop: Mapping[str, int]
    number: int
    unit: float
    dimension: int
    along: Callable[[str, Place], Place]


class Arguments:
    """The arguments of one shape, evaluated when asked for."""

    def __init__(self, shape: Shape, context: Context) -> None:
        self.shape = shape
        self.context = context

    def has(self, name: str) -> bool:
        """Tell whether an argument was given."""
        return name in self.shape.arguments

    def value(self, name: str) -> Array:
        """Return an argument over time."""
        c = self.context
        return c.values.evaluate(self.shape.arguments[name], c.prefix, c.loop)

    def number(self, name: str, default: float) -> float:
        """Return a number that is constant (if it changes, its first value)."""
        if not self.has(name):
            return default
        value = self.value(name)
        if value.ndim != 1:
            self.refuse(name, "a number")
        return float(value[0])

    def vector(self, name: str, default: tuple[float, ...]) -> tuple[float, ...]:
        """Return a vector that is constant."""
        if not self.has(name):
            return default
        value = self.value(name)
        if value.ndim != 2:
            self.refuse(name, "a vector")
        return tuple(float(x) for x in value[:, 0])

    def place(self, name: str) -> Place:
        """Return a point or frame, in the dimension of the scene, moved by ``offset``."""
        c = self.context
        expression = self.shape.arguments[name]
        place = c.values.place(expression, c.prefix, c.loop)
        if place.dimension == 1:
            path = (
                c.values.path(expression, c.prefix, c.loop)
                if isinstance(expression, tree.Reference)
                else ""
            )
            place = c.along(path, place)
        if name == "at" and self.has("offset"):
            place = self._moved(place, self.value("offset"))
        if c.dimension == 3 and place.dimension == 2:
            position = stacked([*place.position, np.zeros(1)])
            return Place(position, None, _axes_at(place.angle))
        return Place(place.position[:2], place.angle) if c.dimension == 2 else place

    def _moved(self, place: Place, offset: Array) -> Place:
        if offset.ndim != 2 or len(offset) != place.dimension:
            self.refuse("offset", f"a vector of {place.dimension} numbers")
        return Place(place.position + turned(place, offset), place.angle, place.axes)

    def color(self, default: str) -> str:
        """Return the colour as ``#rrggbb``."""
        given = self.shape.arguments.get("color")
        if given is None:
            return _COLORS.get(self.shape.kind, default)
        if isinstance(given, tree.StringLiteral):
            text = given.value
            if text in NAMED:
                return NAMED[text]
            if (
                len(text) == 7
                and text[0] == "#"
                and all(x in "0123456789abcdefABCDEF" for x in text[1:])
            ):
                return text.lower()
        elif isinstance(given, tree.ArrayLiteral):
            parts = self.vector("color", ())
            if len(parts) == 3 and all(0 <= p <= 255 for p in parts):
                return "#" + "".join(f"{round(p):02x}" for p in parts)
        fail("D113", f"this is no colour of a {self.shape.kind}", given.span,
             help=f"use one of {', '.join(NAMED)}, \"#rrggbb\", or "
             "{red, green, blue} up to 255")  # fmt: skip

    def flag(self, name: str) -> bool:
        """Return whether a Boolean is true at the first instant."""
        return self.number(name, 0.0) > 0.5

    def visible(self) -> Array | None:
        """Return where the shape is drawn; None for always."""
        return self.value("visible") if self.has("visible") else None

    def refuse(self, name: str, expected: str) -> NoReturn:
        """Refuse an argument.

        Raises:
            AcausalError: ``D113``.
        """
        fail("D113", f"{name} of a {self.shape.kind} is not {expected}",
             self.shape.arguments[name].span)  # fmt: skip


def turned(place: Place, vector: Array) -> Array:
    """Return a vector that is seen from a frame as the world sees it; points have no directions."""
    if place.axes is not None and len(vector) == 3:
        return np.asarray((place.axes * vector[:, None, :]).sum(axis=0))
    if place.angle is not None:
        c, s = np.cos(place.angle), np.sin(place.angle)
        return stacked([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])
    return vector


def _axes_at(angle: Array | None) -> Array | None:
    if angle is None:
        return None
    c, s, zero, one = np.cos(angle), np.sin(angle), np.zeros(1), np.ones(1)
    return stacked([stacked([c, s, zero]), stacked([-s, c, zero]), stacked([zero, zero, one])])


def places(shape: Shape, context: Context) -> list[Place]:
    """Return the points of a shape, for the size of the scene."""
    arguments = Arguments(shape, context)
    return [arguments.place(name) for name in ("at", "from", "to") if arguments.has(name)]


def dimension_of(shape: Shape, context: Context) -> int:
    """Return 1, 2 or 3: whether a shape moves along a line, in the plane or in space."""
    c, found = context, 0
    for name in ("at", "from", "to"):
        if name in shape.arguments:
            found = max(found, c.values.place(shape.arguments[name], c.prefix, c.loop).dimension)
    return found or 2


def sprites(shape: Shape, context: Context) -> list[Sprite]:
    """Return what a shape looks like.

    Raises:
        AcausalError: ``D113`` if an argument cannot be evaluated or is of the wrong kind.
    """
    a = Arguments(shape, context)
    u, kind, space = context.unit, shape.kind, context.dimension == 3
    color = a.color(PALETTE[context.number % len(PALETTE)])
    layer = a.number("layer", _LAYERS.get(kind, 1.0))

    def sprite(
        kind: str, channels: tuple[Array, ...], look: geometry.Outline | solids.Solid | None = None,
        size: float = 0.0, text: str = "",
    ) -> Sprite:  # fmt: skip
        return Sprite(
            kind,
            channels,
            look,
            context.prefix,
            layer,
            color,
            size,
            text,
            a.visible(),
            shape.kind in ("Wall", "Trail"),
        )

    def stretched(look: geometry.Outline | solids.Solid) -> list[Sprite]:
        first, last = a.place("from").position, a.place("to").position
        return [sprite("stretched", (*first, *last), look)]

    def placed(look: geometry.Outline | solids.Solid, more: float = 0.0) -> list[Sprite]:
        return [sprite("placed", frame_channels(a, space, more), look)]

    if kind == "Trail":
        return [sprite("trail", tuple(a.place("at").position), size=a.number("duration", 0.0))]
    if kind == "Text":
        given = shape.arguments["text"]
        if not isinstance(given, tree.StringLiteral):
            fail("D113", "text of a Text is not a text", given.span, help='write text = "name"')
        return [
            sprite(
                "text", tuple(a.place("at").position), size=a.number("size", 13.0), text=given.value
            )
        ]
    if kind == "Arrow":
        return _arrow(a, sprite, u, color, space)
    if space:
        return _solid(a, sprite, stretched, placed, u, color)
    match kind:
        case "Line":
            dashed = a.flag("dashed")
            return stretched(
                geometry.line(a.number("thickness", 2.0) * (-1 if dashed else 1), color)
            )
        case "Rod":
            return stretched(geometry.rod(a.number("width", 1.5 * u), color))
        case "Spring":
            radius, coils = a.number("radius", 1.5 * u), round(a.number("coils", 7))
            look = geometry.spring(radius, coils, color)
            return stretched(geometry.beside(look, a.number("lane", 0.0) * 1.9 * u))
        case "Damper":
            look = geometry.damper(a.number("radius", 1.3 * u), color)
            return stretched(geometry.beside(look, a.number("lane", 0.0) * 1.9 * u))
        case "Piston":
            return stretched(geometry.piston(a.number("radius", 3 * u), color))
        case "Circle" | "Sphere":
            return placed(geometry.circle(a.number("radius", 1.8 * u), color, a.flag("marked")))
        case "Wheel" | "Cylinder":
            return placed(geometry.wheel(a.number("radius", 4 * u), color))
        case "Gear":
            radius = a.number("radius", 4 * u)
            teeth = max(6, round(a.number("teeth", 0.0) or min(90, 12 + abs(radius) / (0.6 * u))))
            look = geometry.gear(abs(radius), teeth, color, radius < 0)
            return placed(look, a.number("phase", 0.0) * 2 * np.pi / teeth)
        case "Box":
            return placed(
                geometry.box(a.number("length", 5 * u), a.number("width", 3.4 * u), color)
            )
        case "Tyre":
            return placed(geometry.tyre(a.number("radius", 2 * u), a.number("width", 1.2 * u)))
        case "Car":
            front, rear = a.number("front", 1.2), a.number("rear", 1.4)
            return placed(geometry.car(front, rear, a.number("width", 0.7 * (front + rear)), color))
        case "Joint":
            return placed(geometry.pin(a.number("radius", 0.8 * u), color))
        case "Ground":
            return placed(geometry.ground(a.number("size", 2.0 * u)))
        case "Wall":
            half = a.number("length", 60 * u) / 2
            return placed(geometry.hatched(-half, half, 0.0, 1.3 * u))
        case "Axes":
            color = "#b9c2cb"
            return []
        case _:
            return _polygon(a, placed, color)


def frame_channels(a: Arguments, space: bool, more: float = 0.0) -> tuple[Array, ...]:
    """Return the channels of something placed; without ``at`` it stands in the world."""
    if not a.has("at"):
        zero = np.zeros(1)
        place = Place(np.zeros((3 if space else 2, 1)))
    else:
        place, zero = a.place("at"), np.zeros(1)
    if space:
        axes = place.axes if place.axes is not None else np.eye(3)[:, :, None]
        return (*place.position, *axes[0], *axes[1])
    angle = (zero if place.angle is None else place.angle) + more
    if a.has("angle"):
        angle = angle + a.value("angle")
    return (*place.position, angle)


def _arrow(
    a: Arguments, sprite: Callable[..., Sprite], u: float, color: str, space: bool
) -> list[Sprite]:
    place, vector = a.place("at"), a.value("vector")
    if vector.ndim != 2 or len(vector) < 2:
        a.refuse("vector", "a vector")
    if a.flag("local"):
        vector = turned(place, vector)
    at = place.position
    vector = stacked([*vector, np.zeros(1)]) if space and len(vector) == 2 else vector[: len(at)]
    size = np.sqrt((vector**2).sum(axis=0))
    largest = float(size.max())
    scale = a.number("scale", 14 * u / largest if largest > 0 else 1.0)
    width = a.number("width", 0.5 * u)
    seen = (size * scale > 2.5 * width).astype(np.float64)
    given = a.visible()
    seen = seen if given is None else np.minimum(seen, given)
    look = solids.arrow(width, color) if space else geometry.arrow(width, color)
    made = sprite("stretched", (*at, *(at + scale * vector)), look)
    return [Sprite(made.kind, made.channels, look, made.name, made.layer, color, visible=seen)]


def _polygon(a: Arguments, placed: Callable[..., list[Sprite]], color: str) -> list[Sprite]:
    points = a.value("points")
    if points.ndim != 3 or points.shape[1] != 2:
        a.refuse("points", "a list of points {{x, y}, {x, y}, {x, y}}")
    corners = [(float(x), float(y)) for x, y in points[:, :, 0]]
    return placed(geometry.polygon(corners, color))


def _solid(
    a: Arguments, sprite: Callable[..., Sprite], stretched: Callable[..., list[Sprite]],
    placed: Callable[..., list[Sprite]], u: float, color: str,
) -> list[Sprite]:  # fmt: skip
    match a.shape.kind:
        case "Line":
            return stretched(solids.line(color, a.number("thickness", 2.0)))
        case "Rod" | "Piston":
            width = (
                a.number("width", 1.2 * u) if a.has("width") else 2 * a.number("radius", 0.6 * u)
            )
            return stretched(solids.rod(width / 2, color))
        case "Spring":
            return stretched(
                solids.spring(a.number("radius", 1.5 * u), round(a.number("coils", 8)), color)
            )
        case "Damper":
            return stretched(solids.damper(a.number("radius", 0.9 * u), color))
        case "Circle" | "Sphere":
            position = tuple(a.place("at").position)
            return [sprite("ball", position, size=a.number("radius", 1.6 * u))]
        case "Wheel" | "Gear":
            axis = a.vector("axis", (0.0, 1.0, 0.0))
            radius = abs(a.number("radius", 4 * u))
            return placed(solids.wheel(axis, radius, a.number("width", 0.35 * radius), color))
        case "Cylinder":
            axis = a.vector("axis", (0.0, 0.0, 1.0))
            length = a.number("length", float(np.sqrt(sum(x * x for x in axis))))
            size = a.number("radius", 1.5 * u)
            return placed(
                solids.cylinder((0.0, 0.0, 0.0), axis, length, size, color, a.flag("marked"))
            )
        case "Joint":
            radius = a.number("radius", 0.9 * u)
            if not a.has("axis"):
                return [sprite("ball", tuple(a.place("at").position), size=radius)]
            line = np.asarray(a.vector("axis", (0.0, 0.0, 1.0)))
            line = line / max(float(np.sqrt(line @ line)), 1e-300)
            begin = [float(x) for x in -1.5 * radius * line]
            return placed(solids.cylinder(begin, line.tolist(), 3 * radius, radius, color))
        case "Box":
            direction = a.vector("direction", (1.0, 0.0, 0.0))
            length = a.number("length", 5 * u)
            width = a.number("width", 2.5 * u)
            return placed(
                solids.box((0.0, 0.0, 0.0), direction, a.vector("side", (0.0, 1.0, 0.0)), length,
                           width, a.number("height", width), color)
            )  # fmt: skip
        case "Ground" | "Wall":
            size = a.number("size", 2.5 * u)
            return placed(
                solids.box((-size / 2, 0.0, 0.0), (1, 0, 0), (0, 1, 0), size, size, size, STEEL)
            )
        case "Axes":
            length = a.number("length", 6 * u)
            return [
                Sprite("placed", frame_channels(a, True),
                       solids.line_along(tuple(length * float(k == j) for j in range(3)), tint),
                       a.context.prefix)
                for k, tint in enumerate(("#c8504f", "#4f9d69", "#3b78b5"))
            ]  # fmt: skip
        case kind:
            fail("D113", f"a {kind} cannot be drawn in space", a.shape.span,
                 help="use Line, Rod, Spring, Damper, Sphere, Box, Cylinder, Wheel, Joint, Arrow "
                 "or Trail")  # fmt: skip
