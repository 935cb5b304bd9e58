"""Start values of nodes, ``.ic``, as voltages of capacitors."""

from __future__ import annotations

from acausal.diagnostics import fail
from acausal.netlists.spice.scope import GROUND, Scope, Value, constant


def capacitor_starts(scope: Scope) -> dict[str, Value]:
    """Return the voltages at the start of capacitors between nodes of ``.ic`` and ground.

    SPICE holds the nodes at their voltages while it looks for the operating point and lets them go
    then. The capacitors keep the voltages at that moment, so they are what is given a start.

    Raises:
        AcausalError: ``P041`` for a node that no capacitor holds.
    """
    netlist = scope.netlist
    if scope.parent is not None or not netlist.start:
        return {}
    voltages = {GROUND: constant(0.0)}
    for node, expression in netlist.start:
        voltages[scope.key(node)] = scope.value(expression)
    found: dict[str, Value] = {}
    neighbours: dict[str, list[str]] = {}
    for element in scope.circuit.elements:
        if element.letter != "C" or len(element.words) < 2:
            continue
        first, second = (scope.key(node) for node in element.words[:2])
        if netlist.uic or (first in voltages and second in voltages):
            one, two = (voltages.get(k, voltages[GROUND]) for k in (first, second))
            found[element.name.low] = Value(one.number - two.number, _difference(one, two))
            neighbours.setdefault(first, []).append(second)
            neighbours.setdefault(second, []).append(first)
    if netlist.uic:
        return found
    reached, queue = {GROUND}, [GROUND]
    while queue:
        for beside in neighbours.get(queue.pop(), ()):
            if beside not in reached:
                reached.add(beside)
                queue.append(beside)
    for node, _ in netlist.start:
        if scope.key(node) not in reached:
            fail(
                "P041",
                f".ic of node {node.text}, which no capacitor holds",
                node.span,
                label="not supported",
                help=f"put a capacitor between {node.text} and ground, or leave it out",
            )
    return found


def _difference(one: Value, two: Value) -> object:
    if isinstance(two.given, int | float) and two.given == 0:
        return one.given
    return one.given - two.given
