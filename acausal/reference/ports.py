"""Where the cuts of a component stand at its symbol.

A ``Placement`` annotation decides; without one the name does. Positive cuts (``p``, ``flange_a``,
``port_a``, ``frame_a``) and inputs stand left, negative ones and outputs right, a housing or heat
port below; numbered ones (``p1``, ``n1``) stand one above the other. Signals of a component whose
left and right sides have physical cuts stand above (in) and below (out).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from acausal.modeling.classes import ClassDef
from acausal.modeling.listing import Declared
from acausal.reference.fields import FIELDS, direction_of, field_of
from acausal.reference.graphics import Box, Point, Port
from acausal.reference.icons import placement

_LEFT: Final = re.compile(
    r"(p|.*_a|.*_p|in_.*|u.*|in[A-Z].*|incoming|inlet|pivot|anode|Anode|left|a)\d*", re.ASCII
)
_RIGHT: Final = re.compile(
    r"(n|.*_b|.*_n|out|y.*|out[A-Z].*|outgoing|outlet|tip|cathode|Cathode|right|b)\d*", re.ASCII
)
_BELOW: Final = re.compile(r"(support.*|heatPort.*|housing|ground|internalHeat)", re.ASCII)
_ABOVE: Final = re.compile(r"control\d*", re.ASCII)
#: Where standard symbols have their cuts: names of all the cuts -> positions in per cent.
_STANDARD: Final[dict[frozenset[str], dict[str, Point]]] = {
    frozenset("CBE"): {"C": (100, 50), "B": (-100, 0), "E": (100, -50)},
    frozenset("DGSB"): {"D": (100, 50), "G": (-100, -50), "S": (100, -50), "B": (100, 0)},
    frozenset("DGS"): {"D": (100, 50), "G": (-100, -50), "S": (100, -50)},
    frozenset(("in_p", "in_n", "out")): {"in_p": (-100, -50), "in_n": (-100, 50), "out": (100, 0)},
    frozenset(("VMax", "VMin")): {"VMax": (0, 100), "VMin": (0, -100)},
    frozenset(("s_p", "s_n")): {"s_p": (0, 100), "s_n": (0, -100)},
    frozenset(("p1", "p2", "p3")): {"p1": (-100, 0), "p2": (100, 0), "p3": (0, -100)},
    frozenset(("p", "n1", "n2")): {"p": (-100, 0), "n1": (100, 50), "n2": (100, 0)},
    frozenset(("sun", "carrier", "ring")): {
        "sun": (-100, 0), "carrier": (-100, 50), "ring": (100, 0),
    },
    frozenset(("Anode", "Cathode", "Gate")): {
        "Anode": (-100, 0), "Cathode": (100, 0), "Gate": (60, 100),
    },
    frozenset(("flangeR", "flangeT")): {"flangeR": (-100, 0), "flangeT": (100, 0)},
    frozenset(("supportR", "supportT")): {"supportR": (-100, -100), "supportT": (100, -100)},
}  # fmt: skip


def place_ports(cuts: Sequence[Declared], extent: Box) -> tuple[Port, ...]:
    """Return the cuts of a class with their places, in the order of declaration.

    Args:
        cuts: Public components that are connectors.
        extent: The coordinate system of the symbol.
    """
    names = {c.component.name for c in cuts}
    standard: dict[str, Point] = {}
    for group, places in _STANDARD.items():
        if group <= names:
            standard = {**places, **standard}
    placed: dict[str, Point] = {}
    sides: dict[str, list[str]] = {"left": [], "right": [], "top": [], "bottom": []}
    directions = {c.component.name: _direction(c) for c in cuts}
    horizontal = _physical_sides([n for n in names if not directions[n]], cuts)
    for cut in cuts:
        name = cut.component.name
        given = placement(cut.component)
        if given is not None:
            placed[name] = given
        elif name in standard:
            placed[name] = _scaled(standard[name], extent)
        else:
            sides[_side(cut, directions[name], horizontal)].append(name)
    for side, members in sides.items():
        for name, along in zip(members, _along(side, members, directions), strict=True):
            placed[name] = _scaled(_on(side, along), extent)
    return tuple(_port(cut, placed[cut.component.name], directions) for cut in cuts)


def _physical_sides(names: list[str], cuts: Sequence[Declared]) -> set[str]:
    """Return which of left and right have physical cuts."""
    return {_side(c, "", set()) for c in cuts if c.component.name in names} & {"left", "right"}


def _direction(cut: Declared) -> str:
    for prefix in ("input", "output"):
        if prefix in cut.component.prefixes:
            return prefix
    return direction_of(cut.type_class) if isinstance(cut.type_class, ClassDef) else ""


def _side(cut: Declared, direction: str, horizontal: set[str]) -> str:
    name = cut.component.name
    if direction:
        if len(horizontal) == 2:
            return "top" if direction == "input" else "bottom"
        if direction == "input":
            return "right" if horizontal == {"left"} else "left"
        return "left" if horizontal == {"right"} else "right"
    type_name = cut.type_class.name if isinstance(cut.type_class, ClassDef) else ""
    if _BELOW.fullmatch(name):
        return "bottom"
    if _ABOVE.fullmatch(name):
        return "top"
    if _LEFT.fullmatch(name):
        return "left"
    if _RIGHT.fullmatch(name):
        return "right"
    if type_name.endswith("_b") or type_name.startswith("Negative"):
        return "right"
    return "left"


def _along(side: str, members: list[str], directions: dict[str, str]) -> list[float]:
    """Return places along a side, from top to bottom or from left to right."""
    count = len(members)
    if side == "bottom" and members and not directions[members[0]]:
        return {1: [0.0], 2: [0.0, 80.0]}.get(count) or _spread(count)
    if count == 1:
        return [0.0]
    signals = all(directions[m] for m in members)
    if count == 2:
        return [60.0, -60.0] if signals else [50.0, -50.0]
    return _spread(count)


def _spread(count: int) -> list[float]:
    """Return places from 80 to -80."""
    return [round(80 - 160 * k / (count - 1), 1) for k in range(count)]


def _on(side: str, along: float) -> Point:
    match side:
        case "left":
            return -100, along
        case "right":
            return 100, along
        case "top":
            return -along, 100
    return -along, -100


def _scaled(point: Point, extent: Box) -> Point:
    left, bottom, right, top = extent
    x, y = point
    return (
        (left + right) / 2 + x / 200 * (right - left),
        (bottom + top) / 2 + y / 200 * (top - bottom),
    )


def _port(cut: Declared, position: Point, directions: dict[str, str]) -> Port:
    name = cut.component.name
    connector = cut.type_class
    key = field_of(connector) if isinstance(connector, ClassDef) else "other"
    type_name = connector.name if isinstance(connector, ClassDef) else ""
    direction = directions[name]
    shape = {"input": "in", "output": "out"}.get(direction, FIELDS[key].shape)
    negative = type_name.endswith("_b") or type_name.startswith("Negative") or name == "n"
    return Port(
        name=name,
        position=position,
        field=key,
        shape=shape,
        filled=not negative and direction != "output",
        conditional=cut.component.condition is not None,
        array=bool(cut.component.dimensions),
    )
