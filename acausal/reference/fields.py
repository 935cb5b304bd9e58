"""The fields of physics that cuts belong to, with the colours in which they are drawn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from acausal.modeling.classes import Builtin, ClassDef
from acausal.reference.graphics import Color


@dataclass(frozen=True, slots=True)
class Field:
    """A field: what cuts of it are called, their colour, and the shape of their ports."""

    title: str
    color: Color
    shape: str = "square"


#: Key -> field. The key is the package of the connector, or the type of a signal.
FIELDS: Final[dict[str, Field]] = {
    "electrical": Field("electrical", Color(0, 60, 230)),
    "electrical.digital": Field("digital", Color(125, 0, 170)),
    "magnetic": Field("magnetic", Color(230, 110, 0)),
    "mechanical.translational": Field("translational", Color(0, 125, 35)),
    "mechanical.rotational": Field("rotational", Color(85, 85, 85), "circle"),
    "mechanical.planar": Field("planar", Color(70, 110, 140)),
    "mechanical.multibody": Field("multibody", Color(95, 95, 95)),
    "thermal": Field("thermal", Color(200, 20, 0)),
    "thermal.fluid": Field("coolant", Color(175, 0, 90)),
    "hydraulic": Field("hydraulic", Color(150, 80, 0)),
    "pneumatic": Field("pneumatic", Color(0, 135, 190)),
    "multiport": Field("power cut", Color(120, 60, 150)),
    "blocks.state_graph": Field("step", Color(60, 60, 60)),
    "Real": Field("Real signal", Color(0, 0, 140)),
    "Integer": Field("Integer signal", Color(215, 110, 0)),
    "Boolean": Field("Boolean signal", Color(215, 0, 190)),
    "other": Field("other", Color(60, 60, 60)),
}


def field_of(connector: ClassDef) -> str:
    """Return the key of the field that a connector belongs to."""
    root: ClassDef | Builtin = connector
    while isinstance(root, ClassDef) and root.bases:
        base = root.bases[0][0]
        if isinstance(base, ClassDef) and base.kind != "connector":
            break  # a signal with an enumeration or a type, of the connector's own package
        root = base
    if isinstance(root, Builtin):
        return root.name if root.name in FIELDS else "other"
    key = root.full_name.rpartition(".")[0]
    while key and key not in FIELDS:  # a package inside of that of the field
        key = key.rpartition(".")[0]
    return key or "other"


def direction_of(connector: ClassDef) -> str:
    """Return ``input`` or ``output`` for the connector of a signal, else an empty text."""
    for ancestor in connector.ancestors():
        for prefix in ("input", "output"):
            if prefix in ancestor.tree.alias_prefixes:
                return prefix
    return ""
