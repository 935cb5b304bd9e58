"""Annotations to drawings: ``annotation(Icon(graphics = {Line(...), ...}))`` is read here.

Whatever is wrong with an annotation becomes a diagnostic with its line; the rest is drawn.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

from acausal.diagnostics import Diagnostic, Span
from acausal.diagnostics.suggest import nearest
from acausal.modeling.classes import ClassDef
from acausal.reference.graphics import (
    THIN,
    Box,
    Color,
    Ellipse,
    Fill,
    Graphic,
    Icon,
    Line,
    Pen,
    Placed,
    Point,
    Polygon,
    Rectangle,
    Text,
)
from acausal.syntax import tree

_T = TypeVar("_T")

_PEN = ("color", "lineColor", "textColor", "pattern", "thickness", "lineThickness")
_FILL = ("fillColor", "fillPattern", "borderPattern")
_PLACE = ("visible", "origin", "rotation")
#: Primitive -> what must be given, what may be.
_ARGUMENTS: dict[str, tuple[str, tuple[str, ...]]] = {
    "Line": ("points", ("color", "pattern", "thickness", "smooth", "arrow", "arrowSize")),
    "Polygon": ("points", (*_PEN, *_FILL, "smooth")),
    "Rectangle": ("extent", (*_PEN, *_FILL, "radius")),
    "Ellipse": ("extent", (*_PEN, *_FILL, "startAngle", "endAngle", "closure")),
    "Text": ("extent", (*_PEN, *_FILL, "textString", "string", "fontSize", "fontName", "textStyle",
                        "horizontalAlignment", "index")),
}  # fmt: skip
_LITERALS = {
    "LinePattern": ("None", "Solid", "Dash", "Dot", "DashDot", "DashDotDot"),
    "FillPattern": ("None", "Solid", "Horizontal", "Vertical", "Cross", "Forward", "Backward",
                    "CrossDiag", "HorizontalCylinder", "VerticalCylinder", "Sphere"),
    "Smooth": ("None", "Bezier"),
    "Arrow": ("None", "Open", "Filled", "Half"),
    "EllipseClosure": ("None", "Chord", "Radial", "Automatic"),
    "TextAlignment": ("Left", "Center", "Right"),
    "TextStyle": ("Bold", "Italic", "UnderLine"),
    "BorderPattern": ("None", "Raised", "Sunken", "Engraved"),
}  # fmt: skip
#: Modelica's thickness is in millimetres, 0.25 is what an ordinary line has.
_PER_MILLIMETRE = THIN / 0.25
#: A drawing may stand out of its coordinate system by this much.
_MARGIN = 60.0


def icon(definition: ClassDef) -> Icon:
    """Return the drawing of a class with those of its base classes behind it."""
    return _read(definition)[0]


def check_icon(definition: ClassDef) -> tuple[Diagnostic, ...]:
    """Return what is wrong with the class's own icon and the placements of its ports.

    Codes are ``D101`` to ``D104``; every diagnostic has the line of what it is about.
    """
    reader = _Reader()
    reader.icon(definition)
    for component in definition.tree.components:
        if component.annotation is not None:
            reader.placement(component.annotation)
    return tuple(reader.diagnostics)


def placement(component: tree.ComponentDeclaration) -> Point | None:
    """Return the middle of a port that has a ``Placement`` annotation, else None."""
    return None if component.annotation is None else _Reader().placement(component.annotation)


def _read(definition: ClassDef) -> tuple[Icon, bool]:
    """Return the drawing, and whether a coordinate system was given for it."""
    graphics: list[Graphic] = []
    extent, said = Icon().extent, False
    for base, _ in definition.bases:
        if isinstance(base, ClassDef):
            inherited, given = _read(base)
            graphics += [g for g in inherited.graphics if g not in graphics]
            if given:
                extent, said = inherited.extent, True
    own, box = _Reader().icon(definition)
    return Icon((*graphics, *own), box or extent), said or box is not None


class _WrongError(Exception):
    """A value that cannot be read."""

    def __init__(self, span: Span, expected: str) -> None:
        super().__init__(expected)
        self.span = span
        self.expected = expected


@dataclass
class _Reader:
    """Reads annotations and collects what is wrong with them."""

    diagnostics: list[Diagnostic] = field(default_factory=list)

    def say(self, code: str, message: str, span: Span, help: str = "") -> None:  # noqa: A002
        """Keep a diagnostic."""
        self.diagnostics.append(Diagnostic(code, message, span, help=help))

    def icon(self, definition: ClassDef) -> tuple[list[Graphic], Box | None]:
        """Return the class's own primitives and its coordinate system, if it says one."""
        if definition.tree.annotation is None:
            return [], None
        found: list[Graphic] = []
        extent: Box | None = None
        for modifier in definition.tree.annotation.arguments:
            if modifier.name != ("Icon",):
                continue
            for part in modifier.nested:
                if part.name == ("graphics",):
                    found += self.graphics(part)
                elif part.name == ("coordinateSystem",):
                    extent = self.coordinate_system(part) or extent
                else:
                    self.say("D102", f"an icon has no part {'.'.join(part.name)}", part.span,
                             "an icon has graphics and perhaps a coordinateSystem")  # fmt: skip
        left, bottom, right, top = extent or Icon().extent
        for graphic in found:
            for x, y in _corners(graphic):
                if not (
                    left - _MARGIN <= x <= right + _MARGIN
                    and bottom - _MARGIN <= y <= top + _MARGIN
                ):
                    self.say(
                        "D104",
                        f"the icon of {definition.name} leaves its coordinate system "
                        f"at ({x:g}, {y:g})",
                        definition.tree.annotation.span,
                        f"draw between ({left:g}, {bottom:g}) and ({right:g}, {top:g})",
                    )
                    break
        return found, extent

    def coordinate_system(self, part: tree.Modifier) -> Box | None:
        for inner in part.nested:
            if inner.name == ("extent",) and inner.value is not None:
                return self.guarded(inner.value, _box)
        return None

    def graphics(self, part: tree.Modifier) -> list[Graphic]:
        if not isinstance(part.value, tree.ArrayLiteral):
            self.say("D103", "graphics is not a list of primitives", part.span,
                     "write graphics = {Line(...), Rectangle(...)}")  # fmt: skip
            return []
        found = [self.primitive(element) for element in part.value.elements]
        return [graphic for graphic in found if graphic is not None]

    def primitive(self, call: tree.Expression) -> Graphic | None:
        if not isinstance(call, tree.Call):
            self.say("D101", "something in an icon is no primitive", call.span,
                     f"use {', '.join(_ARGUMENTS)}")  # fmt: skip
            return None
        name = str(call.function)
        if name not in _ARGUMENTS:
            close = nearest(name, list(_ARGUMENTS))
            self.say("D101", f"there is no primitive {name}", call.span,
                     f"use {close[0] if close else ', '.join(_ARGUMENTS)}")  # fmt: skip
            return None
        needed, allowed = _ARGUMENTS[name]
        given: dict[str, tree.Expression] = {}
        for argument in call.named:
            if argument.name != needed and argument.name not in (*allowed, *_PLACE):
                close = nearest(argument.name, [needed, *allowed, *_PLACE])
                self.say(
                    "D102",
                    f"a {name} has no {argument.name}",
                    argument.span,
                    f"write {close[0]}" if close else f"it has {needed}, {', '.join(allowed)}",
                )
            given[argument.name] = argument.value
        if call.arguments:
            self.say("D102", f"the arguments of a {name} have names", call.span,
                     f"write {name}({needed} = ...)")  # fmt: skip
        if needed not in given:
            self.say("D102", f"a {name} needs {needed}", call.span,
                     f"write {name}({needed} = {{{{-60, 30}}, {{60, -30}}}})")  # fmt: skip
            return None
        try:
            return _primitive(name, given)
        except _WrongError as wrong:
            self.say("D103", f"a value of a {name} is not {wrong.expected}", wrong.span)
            return None

    def placement(self, annotation: tree.Annotation) -> Point | None:
        for modifier in annotation.arguments:
            if modifier.name != ("Placement",):
                continue
            for part in modifier.nested:
                if part.name in (("transformation",), ("iconTransformation",)):
                    return self.transformation(part)
        return None

    def transformation(self, part: tree.Modifier) -> Point | None:
        origin, middle, known = (0.0, 0.0), (0.0, 0.0), False
        for inner in part.nested:
            if inner.name == ("origin",) and inner.value is not None:
                origin, known = self.guarded(inner.value, _point) or origin, True
            elif inner.name == ("extent",) and inner.value is not None:
                box = self.guarded(inner.value, _box)
                if box is not None:
                    middle, known = ((box[0] + box[2]) / 2, (box[1] + box[3]) / 2), True
        return (origin[0] + middle[0], origin[1] + middle[1]) if known else None

    def guarded(self, value: tree.Expression, read: Callable[[tree.Expression], _T]) -> _T | None:
        try:
            return read(value)
        except _WrongError as wrong:
            self.say("D103", f"a value of a drawing is not {wrong.expected}", wrong.span)
            return None


def _primitive(name: str, given: dict[str, tree.Expression]) -> Graphic | None:
    shown = given.get("visible")
    if isinstance(shown, tree.BooleanLiteral) and not shown.value:
        return None
    pen, fill = _pen(given), _fill(given)
    made: Line | Polygon | Rectangle | Ellipse | Text
    smooth = _literal(given.get("smooth"), "Smooth", "None") == "Bezier"
    match name:
        case "Line":
            made = Line(_points(given["points"]), pen, smooth, _arrows(given.get("arrow")))
        case "Polygon":
            made = Polygon(_points(given["points"]), pen, fill, smooth)
        case "Rectangle":
            made = Rectangle(_box(given["extent"]), pen, fill, _number(given.get("radius"), 0.0))
        case "Ellipse":
            start, end = (
                _number(given.get("startAngle"), 0.0),
                _number(given.get("endAngle"), 360.0),
            )
            whole = abs(end - start) >= 360
            closure = _literal(given.get("closure"), "EllipseClosure", "Automatic")
            if closure == "Automatic":
                closure = "Chord" if whole else "Radial" if fill.pattern != "None" else "None"
            made = Ellipse(_box(given["extent"]), pen, fill, start, end, closure)
        case _:
            made = _text(given, pen)
    origin = _point(given["origin"]) if "origin" in given else (0.0, 0.0)
    rotation = _number(given.get("rotation"), 0.0)
    return made if origin == (0.0, 0.0) and not rotation else Placed(made, origin, rotation)


def _text(given: dict[str, tree.Expression], pen: Pen) -> Text:
    value = given.get("textString", given.get("string"))
    if not isinstance(value, tree.StringLiteral):
        span = (value or given["extent"]).span
        raise _WrongError(span, "a text: textString is a string")
    styles = given.get("textStyle")
    names: list[str] = []
    if isinstance(styles, tree.ArrayLiteral):
        names = [_literal(s, "TextStyle", "") for s in styles.elements]
    return Text(
        _box(given["extent"]),
        value.value,
        pen,
        _number(given.get("fontSize"), 0.0),
        _literal(given.get("horizontalAlignment"), "TextAlignment", "Center"),
        "Bold" in names,
        "Italic" in names,
    )


def _pen(given: dict[str, tree.Expression]) -> Pen:
    color = None
    for name in ("color", "textColor", "lineColor"):
        if name in given:
            color = _color(given[name])
            break
    width = THIN
    for name in ("thickness", "lineThickness"):
        if name in given:
            width = _number(given[name], 0.25) * _PER_MILLIMETRE
    return Pen(color, width, _literal(given.get("pattern"), "LinePattern", "Solid"))


def _fill(given: dict[str, tree.Expression]) -> Fill:
    color = _color(given["fillColor"]) if "fillColor" in given else None
    return Fill(color, _literal(given.get("fillPattern"), "FillPattern", "None"))


def _arrows(value: tree.Expression | None) -> tuple[str, str]:
    if value is None:
        return "None", "None"
    if not isinstance(value, tree.ArrayLiteral) or len(value.elements) != 2:
        raise _WrongError(value.span, "a pair of arrow heads, such as {Arrow.None, Arrow.Filled}")
    first, last = (_literal(v, "Arrow", "None") for v in value.elements)
    return first, last


def _literal(value: tree.Expression | None, kind: str, default: str) -> str:
    if value is None:
        return default
    known = _LITERALS[kind]
    if isinstance(value, tree.Reference) and len(value.parts) == 2 and value.parts[0].name == kind:
        name = value.parts[1].name
        if name in known:
            return name
    raise _WrongError(value.span, f"one of {kind}.{{{', '.join(known)}}}")


def _number(value: tree.Expression | None, default: float) -> float:
    if value is None:
        return default
    sign = 1.0
    while isinstance(value, tree.Unary) and value.operator in "+-":
        sign, value = (-sign if value.operator == "-" else sign), value.operand
    if isinstance(value, tree.NumberLiteral) and value.unit is None:
        return sign * value.value
    raise _WrongError(value.span, "a number")


def _list(value: tree.Expression, length: int, expected: str) -> tuple[tree.Expression, ...]:
    if not isinstance(value, tree.ArrayLiteral) or len(value.elements) != length:
        raise _WrongError(value.span, expected)
    return value.elements


def _point(value: tree.Expression) -> Point:
    x, y = _list(value, 2, "a point {x, y}")
    return _number(x, 0.0), _number(y, 0.0)


def _points(value: tree.Expression) -> tuple[Point, ...]:
    if not isinstance(value, tree.ArrayLiteral) or len(value.elements) < 2:
        raise _WrongError(value.span, "a list of two or more points {{x, y}, {x, y}}")
    return tuple(_point(p) for p in value.elements)


def _box(value: tree.Expression) -> Box:
    first, second = _list(value, 2, "an extent {{x1, y1}, {x2, y2}}")
    (x1, y1), (x2, y2) = _point(first), _point(second)
    return min(x1, x2), min(y1, y2), max(x1, x2), max(y1, y2)


def _color(value: tree.Expression) -> Color | None:
    expected = "a colour {red, green, blue} of numbers from 0 to 255"
    red, green, blue = (round(_number(v, 0.0)) for v in _list(value, 3, expected))
    if not all(0 <= c <= 255 for c in (red, green, blue)):
        raise _WrongError(value.span, expected)
    return Color(red, green, blue) if (red, green, blue) != (0, 0, 0) else None


def _corners(graphic: Any) -> tuple[Point, ...]:
    if isinstance(graphic, Placed):
        return ()
    if isinstance(graphic, (Line, Polygon)):
        return graphic.points
    x1, y1, x2, y2 = graphic.extent
    return (x1, y1), (x2, y2)
