"""Wires: shortest paths with few bends and crossings, around the parts, along a grid.

The grid has a line through every port and a few between the parts. Each net grows as a tree: the
port that is cheapest to reach joins next (Dijkstra's algorithm, with the direction as part of the
state so that bends can cost something). Then every net is taken out and laid again with all others
in place.
"""

from __future__ import annotations

import heapq
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

Place = tuple[float, float]
Box = tuple[float, float, float, float]
Node = tuple[int, int]
Edge = tuple[Node, Node]

BEND = 60.0
CROSSING = 150.0
FORBIDDEN = 6000.0
#: How far wires stay away from parts that they do not belong to.
CLEAR = 16.0
_STEPS = ((1, 0), (0, 1), (-1, 0), (0, -1))


@dataclass(frozen=True)
class End:
    """A port: its place and the direction in which its wire leaves."""

    x: float
    y: float
    dx: int
    dy: int


@dataclass(frozen=True)
class Wire:
    """A net as drawn.

    Attributes:
        lines: Straight lines between places, horizontal or vertical.
        dots: Where three lines or more meet.
    """

    lines: tuple[tuple[Place, Place], ...]
    dots: tuple[Place, ...]


def route(boxes: Sequence[Box], nets: Sequence[Sequence[End]]) -> tuple[list[Wire], float]:
    """Return the wires of nets around boxes, and what they cost.

    Args:
        boxes: Left, top, right, bottom of every part.
        nets: Ends of every net; they stand at the edges of boxes.
    """
    grid = _Grid(boxes, nets)
    order = sorted(range(len(nets)), key=lambda k: (len(nets[k]) > 2, _spread(nets[k]), k))
    for k in order:
        grid.lay(k)
    for _ in range(2):
        for k in order:
            grid.take_out(k)
            grid.lay(k)
    return [grid.wire(k) for k in range(len(nets))], sum(grid.cost)


def _spread(net: Sequence[End]) -> float:
    xs, ys = [e.x for e in net], [e.y for e in net]
    return max(xs) - min(xs) + max(ys) - min(ys)


def _lines(needed: set[float], wanted: set[float]) -> list[float]:
    """Return coordinates of grid lines: all needed ones, wanted ones that keep a distance."""
    lines = sorted(needed)
    for x in sorted(wanted):
        k = bisect_left(lines, x)
        if (k == len(lines) or lines[k] - x > 14) and (k == 0 or x - lines[k - 1] > 14):
            lines.insert(k, x)
    return lines


class _Grid:
    def __init__(self, boxes: Sequence[Box], nets: Sequence[Sequence[End]]) -> None:
        ends = [e for net in nets for e in net]
        wanted_x = {
            x for b in boxes for x in (b[0] - 30, b[2] + 30, b[0] - 55, b[2] + 55, b[0] - 80)
        }
        wanted_y = {
            y for b in boxes for y in (b[1] - 30, b[3] + 30, b[1] - 55, b[3] + 55, b[1] - 80)
        }
        self.xs = _lines({e.x for e in ends}, wanted_x)
        self.ys = _lines({e.y for e in ends}, wanted_y)
        self.nets = nets
        self.column = {x: k for k, x in enumerate(self.xs)}
        self.row = {y: k for k, y in enumerate(self.ys)}
        self.blocked: set[Edge] = set()
        for box in boxes:
            self._block(box)
        for end in ends:
            self._open(end, boxes)
        self.used: dict[Edge, set[int]] = {}
        self.corner: dict[Node, set[int]] = {}
        self.straight: dict[Node, set[int]] = {}
        for k, net in enumerate(nets):
            for end in net:
                self.corner.setdefault(self.node(end), set()).add(k)
        self.edges: list[set[Edge]] = [set() for _ in nets]
        self.cost = [0.0] * len(nets)

    def node(self, end: End) -> Node:
        return self.column[end.x], self.row[end.y]

    def _block(self, box: Box) -> None:
        left, top, right, bottom = box[0] - CLEAR, box[1] - CLEAR, box[2] + CLEAR, box[3] + CLEAR
        xs, ys = self.xs, self.ys
        inside_x = [i for i in range(len(xs)) if left < xs[i] < right]
        inside_y = [j for j in range(len(ys)) if top < ys[j] < bottom]
        for j in inside_y:
            for i in range(len(xs) - 1):
                if xs[i] < right and xs[i + 1] > left:
                    self.blocked.add(((i, j), (i + 1, j)))
        for i in inside_x:
            for j in range(len(ys) - 1):
                if ys[j] < bottom and ys[j + 1] > top:
                    self.blocked.add(((i, j), (i, j + 1)))

    def _open(self, end: End, boxes: Sequence[Box]) -> None:
        """Let the wire of a port out of its own part."""
        own = [
            b for b in boxes
            if b[0] - 1 <= end.x <= b[2] + 1 and b[1] - 1 <= end.y <= b[3] + 1
        ]  # fmt: skip
        i, j = self.node(end)
        while True:
            x, y = self.xs[i], self.ys[j]
            if own and not any(
                b[0] - CLEAR < x < b[2] + CLEAR and b[1] - CLEAR < y < b[3] + CLEAR for b in own
            ):
                return
            k, m = i + end.dx, j + end.dy
            if not (0 <= k < len(self.xs) and 0 <= m < len(self.ys)):
                return
            self.blocked.discard(_edge((i, j), (k, m)))
            i, j = k, m
            if not own:
                return

    def take_out(self, k: int) -> None:
        for edge in self.edges[k]:
            self.used[edge].discard(k)
        for node in {n for edge in self.edges[k] for n in edge}:
            for nodes in (self.corner, self.straight):
                if node in nodes:
                    nodes[node].discard(k)
        for end in self.nets[k]:
            self.corner[self.node(end)].add(k)
        self.edges[k] = set()
        self.cost[k] = 0.0

    def lay(self, k: int) -> None:
        net = self.nets[k]
        if len(net) < 2:
            return
        pins: dict[Node, End] = {}
        for end in net:
            pins.setdefault(self.node(end), end)
        middle_x = sum(e.x for e in net) / len(net)
        middle_y = sum(e.y for e in net) / len(net)
        first = min(pins, key=lambda n: abs(pins[n].x - middle_x) + abs(pins[n].y - middle_y))
        if len(net) == 2:
            first = next(iter(pins))
        tree: dict[Node, None] = {first: None}
        left = dict.fromkeys(n for n in pins if n != first)
        while left:
            path, cost = self._nearest(k, tree, left, pins)
            self.cost[k] += cost
            for a, b in pairwise(path):
                self.edges[k].add(_edge(a, b))
            tree.update(dict.fromkeys(path))
            left.pop(path[-1])
        self._register(k, pins)

    def _register(self, k: int, pins: dict[Node, End]) -> None:
        at: dict[Node, list[Node]] = {}
        for a, b in self.edges[k]:
            at.setdefault(a, []).append(b)
            at.setdefault(b, []).append(a)
            self.used.setdefault((a, b), set()).add(k)
        for node, others in at.items():
            plain = (
                len(others) == 2
                and node not in pins
                and (others[0][0] == others[1][0] or others[0][1] == others[1][1])
            )
            (self.straight if plain else self.corner).setdefault(node, set()).add(k)

    def _nearest(
        self, k: int, tree: dict[Node, None], left: dict[Node, None], pins: dict[Node, End]
    ) -> tuple[list[Node], float]:
        """Return the cheapest path from a tree to one of the ports that are left."""
        heap: list[tuple[float, int, Node, int]] = []
        best: dict[tuple[Node, int], float] = {}
        before: dict[tuple[Node, int], tuple[Node, int] | None] = {}
        count = 0
        for node in tree:
            directions = range(4)
            alone = len(tree) == 1
            for d in directions:
                if alone and (pins[node].dx, pins[node].dy) != _STEPS[d]:
                    continue
                start = 0.0 if alone or node not in pins else 40.0
                best[node, d] = start
                before[node, d] = None
                heap.append((start, count, node, d))
                count += 1
        heapq.heapify(heap)
        xs, ys, blocked, used = self.xs, self.ys, self.blocked, self.used
        corner, straight = self.corner, self.straight
        none: set[int] = set()
        width, height = len(xs), len(ys)
        own = {k}
        while heap:
            cost, _, node, direction = heapq.heappop(heap)
            if cost > best[node, direction]:
                continue
            if node in left:
                path = []
                state: tuple[Node, int] | None = (node, direction)
                while state is not None:
                    path.append(state[0])
                    state = before[state]
                return path[::-1], cost
            i, j = node
            first = before[node, direction] is None
            for d in range(4):
                turn = (d - direction) % 4
                if turn == 2 or (first and turn):
                    continue
                dx, dy = _STEPS[d]
                a, b = i + dx, j + dy
                if not (0 <= a < width and 0 <= b < height):
                    continue
                there = (a, b)
                edge = (node, there) if d < 2 else (there, node)
                step = abs(xs[a] - xs[i]) + abs(ys[b] - ys[j])
                if edge in blocked:
                    step += FORBIDDEN
                if used.get(edge, none) - own:
                    step += FORBIDDEN
                if corner.get(there, none) - own and there not in left:
                    step += FORBIDDEN / 2
                elif straight.get(there, none) - own:
                    step += CROSSING
                if there in left and (pins[there].dx, pins[there].dy) != (-dx, -dy):
                    step += FORBIDDEN
                elif there in pins and there not in left:
                    step += 200.0
                total = cost + step + (BEND if turn else 0.0)
                key = (there, d)
                if total < best.get(key, 1e18):
                    best[key] = total
                    before[key] = (node, direction)
                    count += 1
                    heapq.heappush(heap, (total, count, there, d))
        raise AssertionError("the grid is connected")

    def wire(self, k: int) -> Wire:
        at: dict[Node, int] = {}
        for a, b in self.edges[k]:
            at[a] = at.get(a, 0) + 1
            at[b] = at.get(b, 0) + 1
        pins = [self.node(e) for e in self.nets[k]]
        stops = {n for n, count in at.items() if count != 2} | set(pins)
        lines: list[tuple[Place, Place]] = []
        for vertical in (False, True):
            own = sorted(e for e in self.edges[k] if (e[0][0] == e[1][0]) == vertical)
            if vertical:
                own.sort()
            else:
                own.sort(key=lambda e: (e[0][1], e[0][0]))
            run: list[Node] = []
            for a, b in own:
                if run and run[-1] == a:
                    run[-1] = b
                    continue
                if run:
                    lines.append((self._at(run[0]), self._at(run[-1])))
                run = [a, b]
            if run:
                lines.append((self._at(run[0]), self._at(run[-1])))
        dots = sorted(n for n in stops if at.get(n, 0) + pins.count(n) > 2)
        return Wire(tuple(lines), tuple(self._at(n) for n in dots))

    def _at(self, node: Node) -> Place:
        return self.xs[node[0]], self.ys[node[1]]


def _edge(a: Node, b: Node) -> Edge:
    return (a, b) if a <= b else (b, a)
