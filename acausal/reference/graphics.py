"""What a symbol is made of: five primitives in coordinates that point right and up.

Names and meaning are those of Modelica 3.6, chapter 18.6. Lengths are in units of the symbol (a
component is usually 200 wide), line widths too.
"""

from __future__ import annotations

from dataclasses import dataclass, field

Point = tuple[float, float]
Box = tuple[float, float, float, float]

#: Width of a line where nothing is said.
THIN = 2.5


@dataclass(frozen=True, slots=True)
class Color:
    """A colour that carries a meaning, as numbers from 0 to 255.

    Where a primitive has None instead, it is drawn in the colour of the text around it.
    """

    red: int
    green: int
    blue: int

    @property
    def hexadecimal(self) -> str:
        """``#rrggbb``."""
        return f"#{self.red:02x}{self.green:02x}{self.blue:02x}"


@dataclass(frozen=True, slots=True)
class Pen:
    """How a line is drawn.

    Attributes:
        color: None for the colour of the text around the symbol.
        width: Width of the line.
        pattern: ``Solid``, ``Dash``, ``Dot``, ``DashDot``, ``DashDotDot`` or ``None``.
    """

    color: Color | None = None
    width: float = THIN
    pattern: str = "Solid"


@dataclass(frozen=True, slots=True)
class Fill:
    """How an area is filled; ``pattern`` is ``None``, ``Solid``, ``Horizontal`` and so on.

    A solid area without a colour is filled with the colour of the text around the symbol.
    """

    color: Color | None = None
    pattern: str = "None"


@dataclass(frozen=True, slots=True)
class Line:
    """A line through points, with arrow heads (``None``, ``Open``, ``Filled``, ``Half``)."""

    points: tuple[Point, ...]
    pen: Pen = field(default_factory=Pen)
    smooth: bool = False
    arrows: tuple[str, str] = ("None", "None")


@dataclass(frozen=True, slots=True)
class Polygon:
    """A closed line and its area."""

    points: tuple[Point, ...]
    pen: Pen = field(default_factory=Pen)
    fill: Fill = field(default_factory=Fill)
    smooth: bool = False


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A rectangle between two corners, its own corners rounded by ``radius``."""

    extent: Box
    pen: Pen = field(default_factory=Pen)
    fill: Fill = field(default_factory=Fill)
    radius: float = 0.0


@dataclass(frozen=True, slots=True)
class Ellipse:
    """An ellipse inside of a box, or its arc between two angles in degrees.

    ``closure`` is how an arc is closed: ``None``, ``Chord`` or ``Radial``.
    """

    extent: Box
    pen: Pen = field(default_factory=Pen)
    fill: Fill = field(default_factory=Fill)
    start: float = 0.0
    end: float = 360.0
    closure: str = "Chord"


@dataclass(frozen=True, slots=True)
class Text:
    """A line of text in the middle of a box; ``size`` 0 means as large as fits."""

    extent: Box
    text: str
    pen: Pen = field(default_factory=Pen)
    size: float = 0.0
    align: str = "Center"
    bold: bool = False
    italic: bool = False


@dataclass(frozen=True, slots=True)
class Placed:
    """A primitive with an own origin, turned about it counter-clockwise by degrees."""

    primitive: Line | Polygon | Rectangle | Ellipse | Text
    origin: Point = (0.0, 0.0)
    rotation: float = 0.0


Graphic = Line | Polygon | Rectangle | Ellipse | Text | Placed


@dataclass(frozen=True, slots=True)
class Icon:
    """The drawing of a class: primitives from back to front, in a coordinate system."""

    graphics: tuple[Graphic, ...] = ()
    extent: Box = (-100.0, -100.0, 100.0, 100.0)


@dataclass(frozen=True, slots=True)
class Port:
    """A cut of a symbol.

    Attributes:
        name: The component's name.
        position: Its middle.
        field: Key of its field, such as ``electrical`` (:mod:`acausal.reference.fields`).
        shape: ``square``, ``circle``, ``in`` or ``out`` (triangles of signals).
        filled: False for the cut where the counted flow leaves (``n``, ``flange_b``).
        conditional: It exists only if a parameter says so.
        array: There may be any number of it.
    """

    name: str
    position: Point
    field: str
    shape: str = "square"
    filled: bool = True
    conditional: bool = False
    array: bool = False


@dataclass(frozen=True, slots=True)
class Symbol:
    """A class as it stands in a schematic.

    Attributes:
        name: Full name of the class.
        graphics: Primitives from back to front, those of base classes first.
        ports: Position of every cut by name, in the coordinates of ``extent``.
        cuts: The same cuts with what is needed to draw them.
        extent: The coordinate system: left, bottom, right, top.
        drawn: False where the class has no icon and the graphics are only a plain box.
    """

    name: str
    graphics: tuple[Graphic, ...]
    ports: dict[str, Point]
    cuts: tuple[Port, ...]
    extent: Box = (-100.0, -100.0, 100.0, 100.0)
    drawn: bool = True
