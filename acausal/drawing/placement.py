"""Where parts stand and how they are turned: simulated annealing on a lattice.

Parts take cells of a lattice, so that rows and columns come by themselves. Where a part may go
first is what the stress layout of networkx says; then moves, swaps and turns are tried at a falling
temperature (Sechen and Sangiovanni-Vincentelli 1985, the TimberWolf placement and routing package).
The cost of a net is the length and the bends of the best wire with one straight trunk, and what the
trunk would run over. A last pass shifts parts a little where that makes wires straight.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass, field

from acausal.drawing.diagram import Diagram, Part
from acausal.drawing.orientation import ORIENTATIONS, UPRIGHT, Orientation

#: Distance of lattice points; a symbol is 200 wide.
PITCH = 320.0
#: Room between two parts in which wires run.
GAP = 110.0
#: What a bend costs, in units of length.
BEND = 70.0
#: What it costs to run over a part.
OVER = 320.0

#: x, y and the direction outwards; y points down.
Terminal = tuple[float, float, int, int]
Cell = tuple[int, int]


@dataclass(frozen=True)
class Placed:
    """A part at its place: its middle, y down, and its orientation."""

    x: float
    y: float
    orientation: Orientation


@dataclass
class _Body:
    """What placement knows about one part.

    Attributes:
        width, height: Of the upright symbol.
        cells: Columns and rows that it takes, by whether it lies on its side.
        choices: Orientations with what each costs.
        pins: For each choice, port -> place about the middle and direction outwards.
        weight: How much it is drawn downwards.
        aside: How much it is drawn to the left.
        nets: Numbers of its nets.
    """

    width: float
    height: float
    cells: tuple[tuple[int, int], tuple[int, int]]
    choices: list[tuple[Orientation, float]]
    pins: list[dict[str, Terminal]]
    weight: float = 0.0
    aside: float = 0.0
    nets: list[int] = field(default_factory=list)

    def size(self, choice: int) -> tuple[int, int]:
        return self.cells[self.choices[choice][0].quarters % 2]

    def box(self, choice: int) -> tuple[float, float]:
        on_side = self.choices[choice][0].quarters % 2
        return (self.height, self.width) if on_side else (self.width, self.height)


def outward(x: float, y: float, half_width: float, half_height: float) -> tuple[int, int]:
    """Return the direction out of a box at a place of its edge; y points down."""
    sides = (
        (half_width + x, (-1, 0)),
        (half_width - x, (1, 0)),
        (half_height + y, (0, -1)),
        (half_height - y, (0, 1)),
    )
    return min(sides, key=lambda side: abs(side[0]))[1]


def part_pins(part: Part, orientation: Orientation) -> dict[str, Terminal]:
    """Return place and direction of the ports of a turned part about its middle; y points down."""
    left, bottom, right, top = part.symbol.extent
    cx, cy, w, h = (left + right) / 2, (bottom + top) / 2, (right - left) / 2, (top - bottom) / 2
    found: dict[str, Terminal] = {}
    for name, (px, py) in part.symbol.ports.items():
        dx, dy = outward(px - cx, cy - py, w, h)
        if part.terminal:
            dx, dy = (1, 0) if px > cx else (-1, 0)
        x, y = orientation.point(px - cx, py - cy)
        ox, oy = orientation.point(dx, -dy)
        found[name] = (x, -y, round(ox), round(-oy))
    return found


def _body(part: Part) -> _Body:
    left, bottom, right, top = part.symbol.extent
    w, h = right - left, top - bottom

    def cells(width: float, height: float) -> tuple[int, int]:
        return (max(1, math.ceil((width + GAP) / PITCH)), max(1, math.ceil((height + GAP) / PITCH)))

    choices: list[tuple[Orientation, float]] = []
    pins: list[dict[str, Terminal]] = []
    for orientation in ORIENTATIONS:
        at = part_pins(part, orientation)
        penalty = _turning(part, orientation)
        if penalty is None or at in pins:
            continue
        choices.append((orientation, penalty))
        pins.append(at)
    return _Body(w, h, (cells(w, h), cells(h, w)), choices, pins, _weight(part), _aside(part))


def _sinks(part: Part) -> bool:
    """Tell whether a part belongs below: one cut, above in the middle, like a ground."""
    upright = list(part_pins(part, UPRIGHT).values())
    return len(upright) == 1 and upright[0][3] == -1


def _weight(part: Part) -> float:
    """Return how much a part is drawn downwards, upwards if negative."""
    if _sinks(part):
        return 0.8
    fields = {c.field for c in part.symbol.cuts}
    if len(part.symbol.cuts) == 1 and fields & {"mechanical.planar", "mechanical.multibody"}:
        # What hangs hangs below what it hangs from.
        fixed = part.class_name.rpartition(".")[2] in ("Fixed", "Anchor", "World")
        return -0.4 if fixed else 0.4
    return 0.0


def _aside(part: Part) -> float:
    """Return how much a part is drawn to the left, to the right if negative."""
    if not part.terminal:
        return 0.0
    return 0.4 if part.symbol.cuts[0].position[0] > 0 else -0.4


def _turning(part: Part, orientation: Orientation) -> float | None:
    """Return what an orientation costs; None if it must not be."""
    if orientation == UPRIGHT:
        return 0.0
    if part.inside is not None or part.terminal or _sinks(part):
        return None
    if part.inner and orientation != Orientation(0, True):
        return None
    if part.class_name.startswith("vehicle."):
        # A car does not stand on its bumper, and a wheel has the road below.
        return 20.0 if orientation == Orientation(0, True) else None
    ports = part.symbol.cuts
    signals = sum(c.shape in ("in", "out") for c in ports)
    if signals and signals == len(ports):  # a block: to the left in a feedback, else upright
        return 220.0 if orientation == Orientation(0, True) else None
    if not part.symbol.drawn:
        return 40.0 if orientation == Orientation(0, True) else None
    if len(ports) <= 2 + (signals > 0):
        # Plus above minus, left before right.
        turn = (0.0, 50.0, 20.0, 0.0)[orientation.quarters]
        return 4.0 + turn + 6.0 * orientation.mirrored
    if any(c.field != "electrical" for c in ports):
        return None if orientation.quarters == 2 else 40.0 + 100.0 * (orientation.quarters % 2)
    return 40.0 + (0.0, 50.0, 160.0, 50.0)[orientation.quarters]


def stress_layout(diagram: Diagram) -> dict[int, tuple[float, float]]:
    """Return a place for every connected part such that connected ones are near to each other."""
    import networkx

    graph = networkx.Graph()
    for k, net in enumerate(diagram.nets):
        graph.add_edges_from((p.part, -1 - k) for p in net.pins)
    if len(graph) < 100:
        at = networkx.kamada_kawai_layout(graph)
    else:
        at = networkx.spring_layout(graph, seed=1)
    return {k: (float(at[k][0]), float(at[k][1])) for k in sorted(graph) if k >= 0}


def place(diagram: Diagram, start: dict[int, tuple[float, float]], seed: int) -> list[Placed]:
    """Return the places of all parts; the same seed gives the same places.

    Parts that nothing connects are left at the origin: :func:`acausal.drawing.layout.lay_out` puts
    them beside the rest.
    """
    search = _Search(diagram, random.Random(seed), start, 0.9 * seed)
    search.anneal()
    return search.aligned()


class _Search:
    """One run of annealing."""

    def __init__(
        self,
        diagram: Diagram,
        chance: random.Random,
        start: dict[int, tuple[float, float]],
        angle: float,
    ) -> None:
        self.diagram = diagram
        self.random = chance
        self.bodies = [_body(part) for part in diagram.parts]
        self.nets = [tuple((p.part, p.port) for p in net.pins) for net in diagram.nets]
        for k, net in enumerate(self.nets):
            for part in dict.fromkeys(p for p, _ in net):
                self.bodies[part].nets.append(k)
        self.movable = [k for k, b in enumerate(self.bodies) if b.nets]
        self.choice = [0] * len(self.bodies)
        self.cell: list[Cell] = [(0, 0)] * len(self.bodies)
        self.taken: dict[Cell, int] = {}
        self.shift: list[tuple[float, float]] = [(0.0, 0.0)] * len(self.bodies)
        self.through: dict[Cell, dict[int, None]] = {}
        self.passed: list[list[Cell]] = [[] for _ in self.nets]
        self._start(start, angle)
        self.costs = [0.0] * len(self.nets)
        for k in range(len(self.nets)):
            self._renew(k)

    def _start(self, at: dict[int, tuple[float, float]], angle: float) -> None:
        """Put parts on the lattice near to where the stress layout, turned, has them."""
        scale = 1.5 * math.sqrt(sum(math.prod(self.bodies[k].cells[0]) for k in self.movable))
        cos, sin = math.cos(angle), math.sin(angle)
        for k in self.movable:
            x, y = at[k][0] * cos - at[k][1] * sin, at[k][0] * sin + at[k][1] * cos
            wanted = (round(x * scale * 0.6), round(y * scale * 0.45))
            self._occupy(k, self._nearest_free(k, wanted))

    def _nearest_free(self, k: int, wanted: Cell) -> Cell:
        for radius in range(200):
            ring = [
                (wanted[0] + dx, wanted[1] + dy)
                for dx in range(-radius, radius + 1)
                for dy in range(-radius, radius + 1)
                if max(abs(dx), abs(dy)) == radius
            ]
            for cell in ring:
                if self._fits(k, cell):
                    return cell
        raise AssertionError("no free cell")

    def _own(self, k: int, cell: Cell) -> list[Cell]:
        columns, rows = self.bodies[k].size(self.choice[k])
        return [(cell[0] + c, cell[1] + r) for c in range(columns) for r in range(rows)]

    def _fits(self, k: int, cell: Cell) -> bool:
        return all(self.taken.get(c, k) == k for c in self._own(k, cell))

    def _occupy(self, k: int, cell: Cell) -> None:
        self.cell[k] = cell
        for c in self._own(k, cell):
            self.taken[c] = k

    def _leave(self, k: int) -> None:
        for c in self._own(k, self.cell[k]):
            self.taken.pop(c, None)

    def middle(self, k: int) -> tuple[float, float]:
        """Return the middle of a part."""
        columns, rows = self.bodies[k].size(self.choice[k])
        c, r = self.cell[k]
        dx, dy = self.shift[k]
        return (c + (columns - 1) / 2) * PITCH + dx, (r + (rows - 1) / 2) * PITCH + dy

    def _pins(self, number: int) -> list[Terminal]:
        found = []
        for part, port in self.nets[number]:
            x, y = self.middle(part)
            px, py, dx, dy = self.bodies[part].pins[self.choice[part]][port]
            found.append((x + px, y + py, dx, dy))
        return found

    def _renew(self, number: int) -> None:
        """Compute the cost of a net again."""
        self._set(number, *self._net_cost(number))

    def _set(self, number: int, cost: float, cells: list[Cell]) -> None:
        for cell in self.passed[number]:
            self.through[cell].pop(number, None)
        self.costs[number] = cost
        self.passed[number] = cells
        for cell in cells:
            self.through.setdefault(cell, {})[number] = None

    def _net_cost(self, number: int) -> tuple[float, list[Cell]]:
        pins = self._pins(number)
        best, trunk = trunk_cost(pins)
        own = {p for p, _ in self.nets[number]}
        cells: list[Cell] = []
        for x1, y1, x2, y2 in trunk_lines(pins, trunk):
            cells += _cells_on(x1, y1, x2, y2)
        over = sum(self.taken.get(c, -1) not in own and c in self.taken for c in cells)
        return best + OVER * over, cells

    def _part_cost(self, k: int) -> float:
        body = self.bodies[k]
        x, y = self.middle(k)
        cost = body.choices[self.choice[k]][1] + 0.05 * (0.5 * abs(x) + abs(y))
        cost -= body.weight * y - body.aside * x
        return cost

    def _touched(self, parts: Sequence[int], cells: Sequence[Cell]) -> list[int]:
        nets = [n for k in parts for n in self.bodies[k].nets]
        for cell in cells:
            nets += self.through.get(cell, ())
        return list(dict.fromkeys(nets))

    def anneal(self) -> None:
        """Move, swap and turn parts while the temperature falls."""
        count = len(self.movable)
        if count < 1:
            return
        steps = min(400 + 300 * count, 12000)
        hot, cold = 500.0, 6.0
        reach = max(2.0, math.sqrt(count))
        for step in range(steps):
            progress = step / steps
            temperature = hot * (cold / hot) ** progress
            window = max(1, round(reach * (1 - progress)))
            self._try(temperature, window)

    def _try(self, temperature: float, window: int) -> None:
        pick = self.random
        k = self.movable[int(pick.random() * len(self.movable))]
        body = self.bodies[k]
        old_cell, old_choice = self.cell[k], self.choice[k]
        other = -1
        kind = pick.random()
        if kind < 0.3 and len(body.choices) > 1:
            choice = int(pick.random() * len(body.choices))
            if choice == old_choice:
                return None
            if body.size(choice) != body.size(old_choice):
                return self._try_turn(k, choice, temperature)
            nets = body.nets
            before, saved = self._cost([k], nets), self._saved(nets)
            self.choice[k] = choice
        else:
            if kind < 0.65 and body.nets:
                net = self.nets[body.nets[int(pick.random() * len(body.nets))]]
                near = self.cell[net[int(pick.random() * len(net))][0]]
                wanted = (near[0] + pick.randint(-1, 1), near[1] + pick.randint(-1, 1))
            else:
                wanted = (
                    old_cell[0] + pick.randint(-window, window),
                    old_cell[1] + pick.randint(-window, window),
                )
            if wanted == old_cell:
                return None
            other = self.taken.get(wanted, -1)
            if other == k:
                other = -1
            if other >= 0 and (
                self.cell[other] != wanted
                or self.bodies[other].size(self.choice[other]) != body.size(old_choice)
            ):
                return None
            if other < 0 and not self._fits(k, wanted):
                return None
            moved = [k] if other < 0 else [k, other]
            changed = self._own(k, old_cell) + self._own(k, wanted)
            nets = self._touched(moved, changed)
            before, saved = self._cost(moved, nets), self._saved(nets)
            self._exchange(k, other, wanted, old_cell)
            after = self._cost_new(moved, nets)
            if after > before and pick.random() >= math.exp((before - after) / temperature):
                self._exchange(k, other, old_cell, wanted)
                self._restore(saved)
            return None
        after = self._cost_new([k], nets)
        if after > before and pick.random() >= math.exp((before - after) / temperature):
            self.choice[k] = old_choice
            self._restore(saved)

    def _try_turn(self, k: int, choice: int, temperature: float) -> None:
        """Turn a part that takes other cells when it lies on its side."""
        old, cell = self.choice[k], self.cell[k]
        before_cells = self._own(k, cell)
        self._leave(k)
        self.choice[k] = choice
        if not self._fits(k, cell):
            self.choice[k] = old
            self._occupy(k, cell)
            return
        nets = self._touched([k], before_cells + self._own(k, cell))
        self.choice[k] = old
        before, saved = self._cost([k], nets), self._saved(nets)
        self.choice[k] = choice
        self._occupy(k, cell)
        after = self._cost_new([k], nets)
        if after > before and self.random.random() >= math.exp((before - after) / temperature):
            self._leave(k)
            self.choice[k] = old
            self._occupy(k, cell)
            self._restore(saved)

    def _restore(self, saved: list[tuple[int, float, list[Cell]]]) -> None:
        for number, cost, cells in saved:
            self._set(number, cost, cells)

    def _saved(self, nets: Sequence[int]) -> list[tuple[int, float, list[Cell]]]:
        return [(n, self.costs[n], self.passed[n]) for n in nets]

    def _exchange(self, k: int, other: int, there: Cell, here: Cell) -> None:
        self._leave(k)
        if other >= 0:
            self._leave(other)
            self._occupy(other, here)
        self._occupy(k, there)

    def _cost(self, parts: Sequence[int], nets: Sequence[int]) -> float:
        return sum(self.costs[n] for n in nets) + sum(self._part_cost(k) for k in parts)

    def _cost_new(self, parts: Sequence[int], nets: Sequence[int]) -> float:
        for n in nets:
            self._renew(n)
        return self._cost(parts, nets)

    def aligned(self) -> list[Placed]:
        """Shift parts by a fraction of a cell where it makes wires straight; return all places."""
        self._close_up()
        for _ in range(3):
            for k in self.movable:
                self._align(k)
        return [
            Placed(*self.middle(k), body.choices[self.choice[k]][0])
            for k, body in enumerate(self.bodies)
        ]

    def _close_up(self) -> None:
        """Take empty rows and columns out."""
        for axis in (0, 1):
            used = sorted({c[axis] for k in self.movable for c in self._own(k, self.cell[k])})
            new = {old: number for number, old in enumerate(used)}
            for k in self.movable:
                c = list(self.cell[k])
                c[axis] = new[c[axis]]
                self.cell[k] = (c[0], c[1])
        self.taken.clear()
        for k in self.movable:
            self._occupy(k, self.cell[k])
        for n in range(len(self.nets)):
            self._renew(n)

    def _align(self, k: int) -> None:
        body = self.bodies[k]
        nets = body.nets
        now = self.shift[k]
        best, chosen = sum(self.costs[n] for n in nets) - 1.0, now
        x, y = self.middle(k)
        offsets = {(0.0, 0.0)}
        for n in nets:
            pins = self._pins(n)
            for (part, _), (px, py, _, _) in zip(self.nets[n], pins, strict=True):
                if part == k:
                    offsets |= {(round(qx - px), 0.0) for qx, _, _, _ in pins}
                    offsets |= {(0.0, round(qy - py)) for _, qy, _, _ in pins}
        for dx, dy in sorted(offsets):
            if not 0 < abs(dx) + abs(dy) <= 130 or not self._room(k, x + dx, y + dy):
                continue
            self.shift[k] = (now[0] + dx, now[1] + dy)
            cost = sum(self._net_cost(n)[0] for n in nets)
            if cost < best:
                best, chosen = cost, self.shift[k]
        self.shift[k] = chosen
        for n in nets:
            self._renew(n)

    def _room(self, k: int, x: float, y: float) -> bool:
        w, h = self.bodies[k].box(self.choice[k])
        for other in self.movable:
            if other == k:
                continue
            ox, oy = self.middle(other)
            ow, oh = self.bodies[other].box(self.choice[other])
            if abs(ox - x) < (w + ow) / 2 + 70 and abs(oy - y) < (h + oh) / 2 + 70:
                return False
        return True


def _cells_on(x1: float, y1: float, x2: float, y2: float) -> list[Cell]:
    """Return the cells whose parts a straight line would run over."""
    if y1 == y2:
        row = round(y1 / PITCH)
        if abs(y1 - row * PITCH) >= 100:
            return []
        low, high = sorted((x1, x2))
        first, last = math.ceil((low - 99) / PITCH), math.floor((high + 99) / PITCH)
        return [(c, row) for c in range(first, last + 1)]
    column = round(x1 / PITCH)
    if abs(x1 - column * PITCH) >= 100:
        return []
    low, high = sorted((y1, y2))
    first, last = math.ceil((low - 99) / PITCH), math.floor((high + 99) / PITCH)
    return [(column, r) for r in range(first, last + 1)]


def trunk_cost(pins: Sequence[Terminal]) -> tuple[float, tuple[bool, float]]:
    """Return the cost of the best wire with one straight trunk, and the trunk.

    The trunk is (horizontal, its y) or (vertical, its x).
    """
    best, chosen = math.inf, (True, 0.0)
    if len(pins) < 2:
        return 0.0, chosen
    two = len(pins) == 2
    for horizontal in (True, False):
        if horizontal:
            at = [(x, y, dx, dy) for x, y, dx, dy in pins]
        else:
            at = [(y, x, dy, dx) for x, y, dx, dy in pins]
        along = [p[0] for p in at]
        low, high = min(along), max(along)
        levels = sorted(p[1] for p in at)
        tries = dict.fromkeys((levels[0], levels[len(levels) // 2], levels[-1]))
        tries[(levels[0] + levels[-1]) / 2] = None
        for level in tries:
            cost = high - low
            bends = 0.0
            for a, b, da, db in at:
                off = level - b
                if off:
                    cost += off if off > 0 else -off
                    bends += 1.0 if two else 0.4
                    if da:
                        bends += 1.0
                    elif db * off < 0:
                        bends += 2.0
                elif da:
                    if (da > 0 and a >= high) or (da < 0 and a <= low):
                        bends += 2.0
                else:
                    bends += 1.0 if high > low else 0.0
            cost += BEND * bends
            if cost < best:
                best, chosen = cost, (horizontal, level)
    return best, chosen


def trunk_lines(
    pins: Sequence[Terminal], trunk: tuple[bool, float]
) -> list[tuple[float, float, float, float]]:
    """Return trunk and branches as lines."""
    horizontal, level = trunk
    if horizontal:
        xs = [p[0] for p in pins]
        lines = [(min(xs), level, max(xs), level)]
        return lines + [(x, y, x, level) for x, y, _, _ in pins if y != level]
    ys = [p[1] for p in pins]
    lines = [(level, min(ys), level, max(ys))]
    return lines + [(x, y, level, y) for x, y, _, _ in pins if x != level]
