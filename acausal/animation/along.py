"""Parts that move along a line, or turn, side by side in the plane.

Their coordinate alone would put most of them in the same place: masses have no length, and many
models count every position from its rest. So every junction gets an offset of its own, just large
enough that what lies between two junctions can be seen. Motion is true to scale; parts between the
same two junctions lie side by side.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from acausal.animation.scene import Array
from acausal.animation.values import Place


@dataclass(frozen=True)
class Part:
    """Something between two flanges, or on one.

    Attributes:
        name: Path of the component.
        nodes: Junctions of its flanges, by the path of each flange.
        fixed: It holds its flange in the world.
    """

    name: str
    nodes: Mapping[str, str]
    fixed: bool = False


@dataclass(frozen=True)
class Row:
    """Where parts are drawn.

    Attributes:
        offset: What is added to the coordinate of a junction, metres.
        height: Height of a part above the first row, metres.
        node_of: Junction of a flange.
        bars: Lines across: junction, lowest and highest height of what meets there.
        unit: A length that looks small beside the parts.
    """

    offset: Mapping[str, float]
    height: Mapping[str, float]
    node_of: Mapping[str, str]
    bars: tuple[tuple[str, float, float], ...]
    unit: float

    def place(self, flange: str, place: Place) -> Place:
        """Return a flange's point in the plane."""
        node = self.node_of.get(flange, "")
        component = flange.rpartition(".")[0]
        x = place.position[0] + self.offset.get(node, 0.0)
        y = np.full(1, self.height.get(component, 0.0))
        return Place(np.stack(np.broadcast_arrays(x, y)), place.angle)


def side_by_side(parts: list[Part], positions: Mapping[str, Array]) -> Row:
    """Find places for parts.

    Args:
        parts: The parts, in the order of the model.
        positions: Coordinate of every junction over time, metres, shape ``(nt,)`` or ``(1,)``.
    """
    node_of = {flange: node for part in parts for flange, node in part.nodes.items()}
    motion = max((float(np.ptp(p)) for p in positions.values()), default=0.0)
    spread = float(np.ptp([float(p[0]) for p in positions.values()])) if positions else 0.0
    unit = max(motion, 0.15 * spread) or 1.0
    between: dict[str, list[tuple[str, Part, bool]]] = {node: [] for node in positions}
    for part in parts:
        ends = list(dict.fromkeys(part.nodes.values()))
        if len(ends) == 2:
            between[ends[0]].append((ends[1], part, True))
            between[ends[1]].append((ends[0], part, False))
    offset: dict[str, float] = {}
    row_of: dict[str, int] = {}
    roots = [n for p in parts if p.fixed for n in p.nodes.values()] + list(positions)
    rows = 0
    for root in roots:
        if root in offset:
            continue
        # Where the tree starts, it reaches as far to the left as to the right.
        offset[root], row_of[root] = 0.0, rows
        work = [root]
        while work:
            node = work.pop(0)
            for other, _, forward in between[node]:
                if other in offset:
                    continue
                a, b = (node, other) if forward else (other, node)
                gap = float((positions[b] - positions[a]).min())
                missing = 0.0 if gap > 0.4 * unit else 1.6 * unit - gap
                offset[other] = offset[node] + (missing if forward else -missing)
                row_of[other] = rows
                work.append(other)
        rows += 1
    lanes: dict[tuple[str, ...], list[str]] = {}
    for part in parts:
        lanes.setdefault(tuple(sorted(set(part.nodes.values()))), []).append(part.name)
    height: dict[str, float] = {}
    reach: dict[str, list[float]] = {}
    for nodes, names in lanes.items():
        for k, name in enumerate(names):
            level = (len(names) - 1) / 2 - k if len(nodes) > 1 else 0.0
            height[name] = unit * (0.9 * level - 3.0 * row_of[nodes[0]])
            for node in nodes:
                reach.setdefault(node, []).append(height[name])
    bars = tuple((n, min(h), max(h)) for n, h in reach.items() if max(h) - min(h) > 1e-9 * unit)
    return Row(offset, height, node_of, bars, unit)
