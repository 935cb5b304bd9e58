"""A result and the annotations of its components become a scene."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from acausal.animation import geometry, shapes
from acausal.animation.along import Part, Row, side_by_side
from acausal.animation.annotations import Drawing, Shape, drawing
from acausal.animation.scene import Array, Camera, Scene, Sprite, picture_times, suited_speed
from acausal.animation.values import Place, Values
from acausal.diagnostics import fail
from acausal.instantiation.values import constants
from acausal.results.result import Result
from acausal.syntax import tree

if TYPE_CHECKING:
    from acausal.flattening.flatten import Flattened

#: Most pictures of a page and most numbers in it.
MOST_PICTURES, MOST_NUMBERS = 1500, 4_000_000


@dataclass(frozen=True)
class Component:
    """A component that says how it is drawn.

    Attributes:
        path: Its path, empty for the model itself.
        type: Full name of its class.
        drawing: What its class says.
    """

    path: str
    type: str
    drawing: Drawing


@dataclass(frozen=True)
class Drawn:
    """What is known of a model: the components with shapes, and their structural parameters.

    Attributes:
        components: In the order of their classes.
        structural: Values by path of the component and name.
        junction: Junction of every cut, by its path.
        description: Description of the model.
    """

    components: tuple[Component, ...] = ()
    structural: Mapping[str, Mapping[str, Array]] = field(default_factory=dict)
    junction: Mapping[str, str] = field(default_factory=dict)


def drawn_components(flattened: Flattened) -> Drawn:
    """Return the components of a model that say how they are drawn.

    Raises:
        AcausalError: ``D111`` to ``D113`` for annotations that cannot be read.
    """
    from acausal.connections.graph import connection_graph

    numbering = flattened.numbering
    found: list[Component] = []
    structural: dict[str, dict[str, Array]] = {}
    for number in range(len(numbering.groups) - 1, -1, -1):
        group = numbering.groups[number]
        if not group.count or group.template.is_connector:
            continue
        own = drawing(group.template.definition)
        if not own.shapes and own.components and not own.camera:
            continue
        known = {}
        for name, value in group.template.structural.items():
            numbers = constants(value)
            if numbers is not None:
                known[name] = np.asarray(numbers, dtype=np.float64)[..., None]
        for instance in range(group.count):
            path = numbering.path(number, instance)
            found.append(Component(path, group.template.name, own))
            structural[path] = known
    hidden = [c.path for c in found if not c.drawing.components]
    found = [c for c in found if not any(_inside(c.path, outer) for outer in hidden)]
    junction: dict[str, str] = {}
    if any(_along(c) for c in found):
        graph = connection_graph(flattened)
        for _, _, data in graph.edges(data=True):
            junction[data["cut"]] = str(data["junction"])
    return Drawn(tuple(found), structural, junction)


def _inside(path: str, outer: str) -> bool:
    return path != outer and (not outer or path.startswith(f"{outer}."))


def _along(component: Component) -> bool:
    return component.type.startswith(("mechanical.translational", "mechanical.rotational"))


@dataclass(frozen=True)
class Wish:
    """What a caller asks of a scene.

    Attributes:
        speed: Simulated seconds per second; a round number by default.
        fps: Pictures per second.
        most: Most pictures.
        camera: Arguments of the camera that win over those of the model.
        title: Text above; the name of the model by default.
    """

    speed: float | None = None
    fps: float = 60.0
    most: int = MOST_PICTURES
    camera: Mapping[str, tree.Expression] = field(default_factory=dict)
    title: str | None = None


def build_scene(
    result: Result, drawn: Drawn, own: Sequence[Shape] = (), wish: Wish | None = None
) -> Scene:
    """Return the scene of a result.

    Args:
        result: The result, with the variables that the shapes need.
        drawn: What its components say, see :func:`drawn_components`.
        own: Further shapes, in the model itself.
        wish: Speed and more.

    Raises:
        AcausalError: ``D113`` for shapes that cannot be evaluated, ``D114`` if there is nothing to
            draw or too little time.
    """
    wish = wish or Wish()
    components = [*drawn.components, Component("", "", Drawing(tuple(own)))]
    entries = [(c, s) for c in components for s in c.drawing.shapes]
    if not entries:
        fail("D114", f"nothing of {result.model_name} is drawn in an animation",
             notes=["components of mechanical and vehicle have shapes; others have none yet"],
             help="add shapes: annotation(Animation(shapes = {Circle(at = {x, y})})), or in Python "
             "Animation(result).circle(at=('x', 'y'))")  # fmt: skip
    if len(result.times) < 2 or result.times[-1] <= result.times[0]:
        fail("D114", f"the result of {result.model_name} covers no time",
             help="simulate until a later stop time")  # fmt: skip
    start, stop = float(result.times[0]), float(result.times[-1])
    speed = wish.speed or suited_speed(stop - start)
    most = max(2, min(wish.most, MOST_NUMBERS // (7 * len(entries))))
    times = picture_times(start, stop, speed, wish.fps, most)
    values = Values(result, times, lambda path: drawn.structural.get(path, {}))
    base = shapes.Context(values, "", {}, 0, 1.0, 2, lambda path, place: place)
    wanted = [
        (replace(base, prefix=c.path, loop=loop, number=k), shape)
        for k, c in enumerate(components)
        for shape in c.drawing.shapes
        for loop in _loops(shape, values, c.path)
    ]
    dimensions = [shapes.dimension_of(shape, context) for context, shape in wanted]
    dimension = max(dimensions)
    row = None
    if dimension == 1:
        row = _row(components, wanted, values, drawn.junction)
        dimension = 2
    else:
        # Parts along a line have no place in the plane or in space.
        wanted = [w for w, d in zip(wanted, dimensions, strict=True) if d > 1]
    along = row.place if row is not None else (lambda path, place: place)
    wanted = [(replace(c, dimension=dimension, along=along), s) for c, s in wanted]
    unit = _unit(wanted)
    sprites = [sprite for c, s in wanted for sprite in shapes.sprites(s, replace(c, unit=unit))]
    if row is not None:
        sprites += _bars(row, wanted, unit)
    sprites.sort(key=lambda sprite: sprite.layer)
    camera = _camera(components, wish, values, sprites, dimension, unit)
    return Scene(
        times, dimension, tuple(sprites), camera, speed,
        result.model_name if wish.title is None else wish.title,
        result.description if wish.title is None else "", row is None,
    )  # fmt: skip


def _loops(shape: Shape, values: Values, prefix: str) -> Iterator[dict[str, int]]:
    ranges = []
    for index in shape.indices:
        given = index.range
        if not isinstance(given, tree.RangeExpression) or given.step is not None:
            fail("D113", "shapes are repeated over a range", index.span, help="write for k in 1:5")
        low, high = (values.evaluate(e, prefix) for e in (given.start, given.stop))
        ranges.append(range(round(float(low.flat[0])), round(float(high.flat[0])) + 1))
    for numbers in product(*ranges):
        yield {i.name: n for i, n in zip(shape.indices, numbers, strict=True)}


def _row(
    components: Sequence[Component], wanted: Sequence[tuple[shapes.Context, Shape]], values: Values,
    junction: Mapping[str, str],
) -> Row:  # fmt: skip
    nodes: dict[str, dict[str, str]] = {}
    fixed: set[str] = set()
    positions: dict[str, Array] = {}
    for context, shape in wanted:
        for name in ("at", "from", "to"):
            given = shape.arguments.get(name)
            if not isinstance(given, tree.Reference):
                continue
            flange = values.path(given, context.prefix, context.loop)
            node = junction.get(flange, flange)
            nodes.setdefault(context.prefix, {})[flange] = node
            positions[node] = values.place(given, context.prefix, context.loop).position[0]
        if shape.kind in ("Ground", "Wall"):
            fixed.add(context.prefix)
    order = [c.path for c in components if c.path in nodes]
    order.sort(key=lambda path: path not in fixed)
    return side_by_side([Part(path, nodes[path], path in fixed) for path in order], positions)


def _bars(row: Row, wanted: Sequence[tuple[shapes.Context, Shape]], unit: float) -> list[Sprite]:
    """Return lines across where parts lie side by side."""
    found: dict[str, Array] = {}
    for context, shape in wanted:
        for name in ("from", "to"):
            given = shape.arguments.get(name)
            if isinstance(given, tree.Reference):
                path = context.values.path(given, context.prefix, context.loop)
                place = context.values.place(given, context.prefix, context.loop)
                found[row.node_of.get(path, "")] = row.place(path, place).position[0]
    look = geometry.line(3.0, geometry.DARK)
    return [
        Sprite(
            "stretched", (found[n], np.full(1, low), found[n], np.full(1, high)), look, layer=0.05
        )
        for n, low, high in row.bars
        if n in found
    ]


def _unit(wanted: Sequence[tuple[shapes.Context, Shape]]) -> float:
    """Return a length that looks small in the scene: a fiftieth of its diagonal."""
    low: Array | None = None
    high: Array | None = None
    sizes, lengths = 0.0, list[float]()
    for context, shape in wanted:
        if shape.kind == "Car":
            sizes = max(sizes, 5.0)
        found = shapes.places(shape, context)
        if len(found) == 2:
            apart = found[1].position[:, 0] - found[0].position[:, 0]
            size = float(np.sqrt(apart @ apart))
            lengths += [size] if size > 0 else []
        for place in found:
            least, most = place.position.min(axis=1), place.position.max(axis=1)
            low = least if low is None else np.minimum(low, least)
            high = most if high is None else np.maximum(high, most)
    diagonal = 0.0 if low is None or high is None else float(np.sqrt(((high - low) ** 2).sum()))
    if sizes:
        return min(diagonal, 6 * sizes) / 55
    unit = (diagonal or 1.0) / 55
    if lengths:
        # A chain of many links is thin.
        unit = max(min(unit, 0.12 * float(np.median(lengths))), unit / 7)
    return unit


def extent_of(sprites: Sequence[Sprite], dimension: int) -> tuple[Array, Array]:
    """Return the lowest and highest coordinates that sprites reach."""
    low, high = np.full(dimension, np.inf), np.full(dimension, -np.inf)
    for sprite in sprites:
        if not sprite.scenery:
            least, most = _reach(sprite, dimension)
            low, high = np.minimum(low, least), np.maximum(high, most)
    return low, high


def _reach(sprite: Sprite, dimension: int) -> tuple[Array, Array]:
    # Some sixty times are enough to see how far something moves.
    length = max(len(c) for c in sprite.channels)
    chosen = np.unique(np.linspace(0, length - 1, 61).astype(np.int64))
    channels = np.stack([np.broadcast_to(c, length)[chosen] for c in sprite.channels])
    points = channels[:dimension]
    radius = np.array(sprite.size if sprite.kind == "ball" else 0.0)
    if sprite.kind == "stretched":
        points = np.concatenate([points, channels[dimension : 2 * dimension]], axis=1)
        across = [np.asarray(part.points)[:, 2:] for part in sprite.geometry or ()]
        radius = max((np.sqrt((a**2).sum(axis=1)).max() for a in across), default=radius)
    elif sprite.kind == "placed":
        corners = np.concatenate([np.asarray(part.points) for part in sprite.geometry or ()])
        ends = np.array(list(product(*zip(corners.min(axis=0), corners.max(axis=0), strict=True))))
        if dimension == 3:
            x, y = channels[3:6], channels[6:9]
            axes = np.stack([x, y, np.cross(x, y, axis=0)])
        else:
            c, s = np.cos(channels[2]), np.sin(channels[2])
            axes = np.array([[c, s], [-s, c]])
        moved = points[:, None, :] + np.einsum("ka,ait->ikt", ends, axes)
        points = moved.reshape(dimension, -1)
    return points.min(axis=1) - radius, points.max(axis=1) + radius


def _camera(
    components: Sequence[Component], wish: Wish, values: Values, sprites: Sequence[Sprite],
    dimension: int, unit: float,
) -> Camera:  # fmt: skip
    low, high = extent_of(sprites, dimension)
    if not np.isfinite(low).all():
        low, high = np.full(dimension, -1.0), np.full(dimension, 1.0)
    margin = 3 * unit
    size = np.maximum(high - low + 2 * margin, 8 * unit)
    center = tuple(float(c) for c in (low + high) / 2)
    given: dict[str, tuple[tree.Expression, str]] = {}
    # What contains others knows better from where to look.
    for component in sorted(components, key=lambda c: -len(c.path)):
        given |= {k: (e, component.path) for k, e in component.drawing.camera.items()}
    given |= {k: (e, "") for k, e in wish.camera.items()}

    def number(name: str, default: float) -> float:
        if name not in given:
            return default
        return float(values.evaluate(*given[name]).flat[0])

    follow: tuple[Array, ...] = ()
    if "follow" in given:
        place: Place = values.place(*given["follow"], {})
        follow = tuple(place.position[:dimension])
    width = number("width", float(size[0]))
    if dimension == 2:
        height = width * 0.55 if "width" in given else float(size[1])
        return Camera(center, (width, height), follow=follow)
    up = (0.0, 0.0, 1.0)
    for component in components:
        if component.type == "mechanical.multibody.World":
            n = values.find(f"{component.path}.n")
            if n is not None and n.ndim == 2:
                up = _upwards(n[:, 0])
    if "up" in given:
        up = _upwards(-values.evaluate(*given["up"])[:, 0])
    diameter = number("width", 0.85 * float(np.sqrt(((high - low) ** 2).sum())))
    half = float((np.abs(np.array(up)) * (high - low) / 2).sum())
    return Camera(
        center, (diameter, diameter), number("azimuth", 35.0), number("elevation", 18.0), up,
        follow,
        -half - 0.01 * diameter,
    )  # fmt: skip


def _upwards(down: Array) -> tuple[float, float, float]:
    size = float(np.sqrt(down @ down))
    if not size > 0:
        return (0.0, 0.0, 1.0)
    x, y, z = (float(-c / size) + 0.0 for c in down)
    return (x, y, z)
