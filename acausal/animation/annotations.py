"""What a class says about how it is drawn: ``annotation(Animation(shapes = {Circle(...)}))``.

The arguments of shapes stay expressions here; they are evaluated with a result (``values.py``).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from acausal.diagnostics import Span, fail
from acausal.diagnostics.suggest import nearest
from acausal.modeling.classes import ClassDef
from acausal.syntax import tree

#: Arguments that every shape may have.
COMMON = ("color", "visible", "layer")
_END = ("from", "to")
_BODY = ("at", "offset", "angle")
#: Shape -> arguments that must be given, arguments that may be.
SHAPES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "Line": (_END, ("thickness", "dashed")),
    "Rod": (_END, ("width",)),
    "Spring": (_END, ("radius", "coils", "lane")),
    "Damper": (_END, ("radius", "lane")),
    "Piston": (_END, ("radius",)),
    "Arrow": (("at", "vector"), ("offset", "scale", "width", "local")),
    "Circle": (("at",), ("offset", "angle", "radius", "marked")),
    "Sphere": (("at",), ("offset", "radius")),
    "Wheel": (("at",), ("offset", "angle", "radius", "axis", "width")),
    "Gear": (("at",), ("offset", "angle", "radius", "teeth", "phase")),
    "Box": (("at",), ("offset", "angle", "length", "width", "height", "direction", "side")),
    "Cylinder": (("at", "axis"), ("offset", "length", "radius", "marked")),
    "Tyre": (("at",), ("offset", "angle", "radius", "width")),
    "Car": (("at",), ("angle", "front", "rear", "width")),
    "Joint": (("at",), ("radius", "axis", "offset")),
    "Ground": (("at",), ("angle", "size", "offset")),
    "Wall": (("at",), ("angle", "length", "offset")),
    "Axes": (("at",), ("length",)),
    "Polygon": (("points",), ("at", "offset", "angle")),
    "Trail": (("at",), ("offset", "duration")),
    "Text": (("at", "text"), ("offset", "size")),
}
#: Arguments of a camera.
CAMERA = ("azimuth", "elevation", "up", "follow", "width", "axis")


@dataclass(frozen=True)
class Shape:
    """A shape as it is written.

    Attributes:
        kind: A key of :data:`SHAPES`.
        arguments: Expressions by name.
        span: Where it stands.
        indices: Loop variables around it with their ranges.
    """

    kind: str
    arguments: Mapping[str, tree.Expression]
    span: Span
    indices: tuple[tree.ForIndex, ...] = ()


@dataclass(frozen=True)
class Drawing:
    """What a class says about its animation, with what it inherits.

    Attributes:
        shapes: Those of base classes first.
        camera: Arguments of the camera by name, empty if nothing is said.
        components: Whether the shapes of its components are drawn as well.
    """

    shapes: tuple[Shape, ...] = ()
    camera: Mapping[str, tree.Expression] = field(default_factory=dict)
    components: bool = True


def drawing(definition: ClassDef) -> Drawing:
    """Return what a class and its base classes say about their animation.

    Raises:
        AcausalError: ``D111``, ``D112``, ``D113`` for what cannot be read.
    """
    shapes: list[Shape] = []
    camera: dict[str, tree.Expression] = {}
    components = True
    for base, _ in definition.bases:
        if isinstance(base, ClassDef):
            inherited = drawing(base)
            shapes += [shape for shape in inherited.shapes if shape not in shapes]
            camera |= inherited.camera
            components = components and inherited.components
    if any(part.name == ("inherit",) and _false(part) for part in _parts(definition)):
        shapes, camera, components = [], {}, True
    for part in _parts(definition):
        name = ".".join(part.name)
        if name == "shapes":
            shapes += read_shapes(part.value, part.span)
        elif name == "camera":
            camera |= _camera(part)
        elif name == "components" and isinstance(part.value, tree.BooleanLiteral):
            components = part.value.value
        elif name == "inherit" and isinstance(part.value, tree.BooleanLiteral):
            continue
        else:
            fail("D112", f"an animation has no part {name} of this form", part.span,
                 help="it has shapes = {...}, camera = Camera(...), components = false and "
                 "inherit = false")  # fmt: skip
    return Drawing(tuple(shapes), camera, components)


def _parts(definition: ClassDef) -> Iterator[tree.Modifier]:
    if definition.tree.annotation is not None:
        for modifier in definition.tree.annotation.arguments:
            if modifier.name == ("Animation",):
                yield from modifier.nested


def _false(part: tree.Modifier) -> bool:
    return isinstance(part.value, tree.BooleanLiteral) and not part.value.value


def read_shapes(value: tree.Expression | None, span: Span) -> list[Shape]:
    """Return the shapes of a list.

    Raises:
        AcausalError: ``D111`` if something in it is no shape, ``D112`` for its arguments.
    """
    if isinstance(value, tree.ArrayComprehension):
        return [
            Shape(s.kind, s.arguments, s.span, (*value.indices, *s.indices))
            for s in read_shapes(value.element, span)
        ]
    if isinstance(value, tree.ArrayLiteral):
        return [shape for element in value.elements for shape in read_shapes(element, span)]
    if not isinstance(value, tree.Call):
        fail(
            "D111",
            "something in an animation is no shape",
            span if value is None else value.span,
            help="write shapes = {Rod(from = frame_a, to = frame_b), Circle(at = frame_a)}",
        )
    if value.indices:
        fail("D111", "a shape has no loop of its own", value.span,
             help="write {Circle(at = frame[k]) for k in 1:3}")  # fmt: skip
    return [_shape(value)]


def a(kind: str) -> str:
    """Return the name of a shape with its article."""
    return f"{'an' if kind[0] in 'AEIO' else 'a'} {kind}"


def _shape(call: tree.Call) -> Shape:
    kind = str(call.function)
    if kind not in SHAPES:
        close = nearest(kind, list(SHAPES))
        every = f"the shapes are {', '.join(SHAPES)}"
        fail("D111", f"there is no shape {kind}", call.span,
             help=f"write {close[0]}" if close else every)  # fmt: skip
    needed, allowed = SHAPES[kind]
    known = (*needed, *allowed, *COMMON)
    given = _named(call, kind, known)
    for name in needed:
        if name not in given:
            fail("D112", f"{a(kind)} needs {name}", call.span,
                 help=f"write {kind}({', '.join(f'{n} = ...' for n in needed)})")  # fmt: skip
    return Shape(kind, given, call.span)


def _named(call: tree.Call, kind: str, known: tuple[str, ...]) -> dict[str, tree.Expression]:
    if call.arguments:
        fail("D112", f"the arguments of {a(kind)} have names", call.span,
             help=f"write {kind}({known[0]} = ...)")  # fmt: skip
    for argument in call.named:
        if argument.name not in known:
            close = nearest(argument.name, known)
            fail("D112", f"{a(kind)} has no {argument.name}", argument.span,
                 help=f"write {close[0]}" if close else f"it has {', '.join(known)}")  # fmt: skip
    return {argument.name: argument.value for argument in call.named}


def _camera(part: tree.Modifier) -> dict[str, tree.Expression]:
    if not isinstance(part.value, tree.Call) or str(part.value.function) != "Camera":
        fail("D113", "the camera of an animation is not Camera(...)", part.span,
             help="write camera = Camera(follow = {x, y}, width = 20)")  # fmt: skip
    return _named(part.value, "Camera", CAMERA)
