"""A class as a symbol with ports: what a page of the reference or a schematic draws."""

from __future__ import annotations

from acausal.modeling.classes import ClassDef
from acausal.modeling.listing import Declared, declared
from acausal.reference.graphics import Graphic, Icon, Polygon, Rectangle, Symbol
from acausal.reference.icons import icon
from acausal.reference.ports import place_ports

#: Kinds of classes that stand in schematics.
DRAWN_KINDS = ("model", "block", "class", "connector")


def cuts_of(definition: ClassDef) -> tuple[Declared, ...]:
    """Return the public cuts of a class, inherited ones first."""
    return tuple(
        d
        for d in declared(definition)
        if d.component.public
        and isinstance(d.type_class, ClassDef)
        and d.type_class.kind == "connector"
    )


def symbol(definition: ClassDef) -> Symbol:
    """Return the symbol of a class with the places of its cuts.

    Drawings of base classes come first; a class that has none, and whose bases have none, is a
    plain box. Coordinates point right and up; ``extent`` is the coordinate system, usually from
    -100 to 100. For a schematic, draw ``graphics`` in order, then ``cuts``; connections end at
    ``ports``.

    Example:
        >>> from acausal.modeling.load import library_class
        >>> symbol(library_class("electrical.Resistor")).ports["p"]
        (-100.0, 0.0)

    Raises:
        AcausalError: If a base class or the class of a component is not found.
    """
    drawing = icon(definition)
    cuts = place_ports(cuts_of(definition), drawing.extent)
    return Symbol(
        name=definition.full_name,
        graphics=drawing.graphics or _plain(definition, drawing),
        ports={cut.name: cut.position for cut in cuts},
        cuts=cuts,
        extent=drawing.extent,
        drawn=bool(drawing.graphics),
    )


def _plain(definition: ClassDef, drawing: Icon) -> tuple[Graphic, ...]:
    left, bottom, right, top = drawing.extent
    if definition.kind == "connector":
        middle = (bottom + top) / 2
        return (Polygon(((left, middle), ((left + right) / 2, top), (right, middle),
                         ((left + right) / 2, bottom))),)  # fmt: skip
    return (Rectangle(drawing.extent, radius=(right - left) / 20),)
