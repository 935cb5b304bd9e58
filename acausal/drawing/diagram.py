"""What a schematic shows: parts with their ports, and nets of ports that are connected.

Everything is taken from the templates of a compiled model, in which an array of components is one
declaration. A net stands for all junctions that join the same ports; which elements of an array
take part is said at the ends of its wires.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from math import prod

import numpy as np
from numpy.typing import NDArray

from acausal.instantiation.numbering import linear
from acausal.instantiation.template import Child, ConnectDecl, CutRef, Step, Template
from acausal.reference.graphics import Port, Rectangle, Symbol
from acausal.reference.symbols import symbol


@dataclass(frozen=True)
class Part:
    """A component, an array of components, or a cut of the model itself.

    Attributes:
        name: Its name; the schematic shows ``label``.
        size: Array size as people write it, ``[100]``; empty for one component.
        class_name: Full name of its class.
        description: What the author says.
        symbol: Symbol with the ports that exist.
        inside: What it is made of, if that is to be drawn.
        terminal: It is a cut of the drawn model itself.
        inner: It is an ``inner`` component, such as a world.
    """

    name: str
    size: str
    class_name: str
    description: str
    symbol: Symbol
    inside: Diagram | None = None
    terminal: bool = False
    inner: bool = False

    @property
    def label(self) -> str:
        """Name and size."""
        return self.name + self.size


@dataclass(frozen=True)
class Pin:
    """One end of a net.

    Attributes:
        part: Number of the part.
        port: Name of its port.
        note: Which elements of an array take part, ``[1]`` or ``[2:10]``; empty for all.
    """

    part: int
    port: str
    note: str = ""


@dataclass(frozen=True)
class Net:
    """Ports that are connected.

    Attributes:
        pins: Its ends, each port once.
        field: Key of the field (:mod:`acausal.reference.fields`).
        signal: It carries a signal; the first pin is the source if there is one.
    """

    pins: tuple[Pin, ...]
    field: str
    signal: bool = False


@dataclass(frozen=True)
class Diagram:
    """Parts and nets of one class."""

    parts: tuple[Part, ...]
    nets: tuple[Net, ...]


def parts_of(shown: Diagram) -> int:
    """Return the number of parts, those inside of others too."""
    return sum(1 + (parts_of(p.inside) if p.inside is not None else 0) for p in shown.parts)


def diagram(template: Template, depth: int = 1) -> Diagram:
    """Return what a schematic of a class shows.

    Args:
        template: The class with its structural parameters.
        depth: How many levels of components are drawn; at 1 every component is one symbol.

    Raises:
        AcausalError: If a class of an icon is not found.
    """
    parts: list[Part] = []
    number: dict[str, int] = {}
    for child in template.children.values():
        if child.template.is_connector:
            part = _terminal(child, template)
        elif child.template.definition.kind == "record":
            continue
        else:
            part = _component(child, depth)
        number[child.name] = len(parts)
        parts.append(part)
    nets, extra = _nets(template, parts, number)
    for k, ports in extra.items():
        parts[k] = replace(parts[k], symbol=_with_ports(parts[k].symbol, ports))
    return Diagram(tuple(parts), tuple(nets))


def _size(shape: tuple[int, ...]) -> str:
    return f"[{', '.join(map(str, shape))}]" if shape else ""


def _component(child: Child, depth: int) -> Part:
    template = child.template
    drawing = symbol(template.definition)
    cuts = tuple(
        replace(c, conditional=False, array=False)
        for c in drawing.cuts
        if c.name in template.children or c.name in template.variables
    )
    drawing = replace(drawing, cuts=cuts, ports={c.name: c.position for c in cuts})
    inside = None
    if depth > 1 and is_composite(template):
        inside = diagram(template, depth - 1)
    return Part(
        child.name, _size(child.shape), template.definition.full_name,
        child.description or template.definition.tree.description, drawing, inside,
        inner=child.inner,
    )  # fmt: skip


def is_composite(template: Template) -> bool:
    """Tell whether a class is made of components that are connected."""
    components = [
        c
        for c in template.children.values()
        if not c.template.is_connector and c.template.definition.kind != "record"
    ]
    return len(components) > 1 and bool(template.connects)


def _terminal(child: Child, owner: Template) -> Part:
    """Return a cut of the model itself: a port whose wire leads inwards."""
    outside = next((c for c in symbol(owner.definition).cuts if c.name == child.name), None)
    if outside is None:
        outside = Port(child.name, (-100.0, 0.0), "other")
    left = outside.position[0] <= 0
    shape = {"in": "out", "out": "in"}.get(outside.shape, outside.shape)
    port = Port(child.name, (0.0, 0.0), outside.field, shape, outside.filled)
    small = (-10.0, -10.0, 10.0, 10.0)
    port = replace(port, position=(small[2] if left else small[0], 0.0))
    return Part(
        child.name, _size(child.shape), child.template.definition.full_name, child.description,
        Symbol(child.template.definition.full_name, (), {port.name: port.position}, (port,), small),
        terminal=True,
    )  # fmt: skip


def _with_ports(drawing: Symbol, names: list[str]) -> Symbol:
    """Add ports for cuts of components inside, which have no place at the symbol."""
    left, bottom, right, _ = drawing.extent
    added = []
    for k, name in enumerate(names):
        x = left + (right - left) * (k + 1) / (len(names) + 1)
        added.append(Port(name, (round(x, -1), bottom), "other"))
    cuts = (*drawing.cuts, *added)
    return replace(drawing, cuts=cuts, ports={c.name: c.position for c in cuts})


@dataclass
class _Ends:
    """Collects ends of connections: (part, port) with element numbers."""

    keys: list[tuple[int, str]]
    shapes: list[tuple[int, ...]]

    def number(self, key: tuple[int, str], shape: tuple[int, ...]) -> int:
        if key not in self.keys:
            self.keys.append(key)
            self.shapes.append(shape)
        return self.keys.index(key)


def _nets(
    template: Template, parts: list[Part], number: dict[str, int]
) -> tuple[list[Net], dict[int, list[str]]]:
    """Return the nets of a class, and ports of parts that their symbols lack."""
    ends = _Ends([], [])
    extra: dict[int, list[str]] = {}
    joined: list[tuple[int, NDArray[np.int64], int, NDArray[np.int64]]] = []
    for connect in template.connects:
        found = [_end(cut, connect, template, number, ends) for cut in connect.cuts]
        known = [f for f in found if f is not None]
        for (a, i), (b, j) in pairwise(known):
            joined.append((a, i, b, j))
    for part, port in ends.keys:
        if port not in parts[part].symbol.ports and port not in extra.get(part, ()):
            extra.setdefault(part, []).append(port)
    nets = []
    for members in _junctions(ends, joined):
        pins = []
        for end, elements in members:
            part, port = ends.keys[end]
            pins.append(Pin(part, port, _note(elements, ends.shapes[end])))
        nets.append(_net(tuple(pins), parts))
    return nets, extra


def _net(pins: tuple[Pin, ...], parts: list[Part]) -> Net:
    cuts = [next((c for c in parts[p.part].symbol.cuts if c.name == p.port), None) for p in pins]
    fields = [c.field for c in cuts if c is not None]
    signal = any(c is not None and c.shape in ("in", "out") for c in cuts)
    if signal:
        order = sorted(range(len(pins)), key=lambda k: getattr(cuts[k], "shape", "") != "out")
        pins = tuple(pins[k] for k in order)
    return Net(pins, fields[0] if fields else "other", signal)


def _end(
    cut: CutRef, connect: ConnectDecl, template: Template, number: dict[str, int], ends: _Ends
) -> tuple[int, NDArray[np.int64]] | None:
    """Return the number of an end and its element in every pass of the loops around."""
    steps = (Step(cut.outer), *cut.path) if cut.outer else cut.path
    first = steps[0].name
    if first not in number:
        return None  # an inner component of a class around this one
    child = template.children[first]
    if child.template.is_connector:
        key = (number[first], first)
    else:
        key = (number[first], ".".join(s.name for s in steps[1:]))
    shape: list[int] = []
    element = np.zeros(connect.domain.length, np.int64)
    owner = template
    for step in steps:
        here = owner.children.get(step.name)
        own = here.shape if here is not None else ()
        if own:
            element = element * prod(own) + linear(step.index, own, connect.domain)[0]
            shape += own
        if here is None:
            break
        owner = here.template
    return ends.number(key, tuple(shape)), element


def _junctions(
    ends: _Ends, joined: list[tuple[int, NDArray[np.int64], int, NDArray[np.int64]]]
) -> list[list[tuple[int, NDArray[np.int64]]]]:
    """Return for every set of ends that meet which elements of them do, in order."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    if not joined:
        return []
    sizes = np.array([prod(s) for s in ends.shapes])
    base = np.concatenate([[0], np.cumsum(sizes)])
    tails = np.concatenate([base[a] + i for a, i, _, _ in joined])
    heads = np.concatenate([base[b] + j for _, _, b, j in joined])
    total = int(base[-1])
    graph = coo_matrix((np.ones(len(tails), np.int8), (tails, heads)), shape=(total, total))
    _, label = connected_components(graph.tocsr(), directed=False)
    used = np.unique(np.concatenate([tails, heads]))
    end = np.searchsorted(base, used, "right") - 1
    junction = label[used]
    # Junctions of the same ends are told by a sum of one random number for each end.
    random = np.random.default_rng(0).integers(1, 2**62, len(sizes), np.int64)
    pairs = np.unique(np.stack([junction, end]), axis=1)
    code = np.zeros(int(label.max()) + 1, np.int64)
    np.add.at(code, pairs[0], random[pairs[1]])
    found: dict[int, list[tuple[int, NDArray[np.int64]]]] = {}
    codes = code[junction]
    _, first = np.unique(codes, return_index=True)
    for which in codes[np.sort(first)].tolist():
        own = codes == which
        found[which] = [(k, used[own & (end == k)] - base[k]) for k in np.unique(end[own]).tolist()]
    return list(found.values())


def _note(elements: NDArray[np.int64], shape: tuple[int, ...]) -> str:
    """Return ``[1]``, ``[2:10]`` or ``[...]`` for some elements of an array; empty for all."""
    if not shape or len(elements) == prod(shape):
        return ""
    low, high = int(elements.min()), int(elements.max())
    if low == high:
        subscripts = np.unravel_index(low, shape)
        return f"[{','.join(str(int(s) + 1) for s in subscripts)}]"
    if len(shape) == 1 and high - low + 1 == len(elements):
        return f"[{low + 1}:{high + 1}]"
    return "[…]"


def frame_symbol(part: Part, width: float, height: float, cuts: tuple[Port, ...]) -> Symbol:
    """Return the frame around what a part is made of."""
    extent = (-width / 2, -height / 2, width / 2, height / 2)
    return Symbol(
        part.class_name, (Rectangle(extent, radius=20.0),), {c.name: c.position for c in cuts},
        cuts, extent,
    )  # fmt: skip
