"""From the cards of a netlist to a model."""

from __future__ import annotations

from typing import Any

from acausal.compose.component import Component
from acausal.compose.declarations import Variable
from acausal.compose.model import Model
from acausal.diagnostics import Diagnostic, Label, Span, fail
from acausal.diagnostics.suggest import nearest
from acausal.netlists.identifiers import identifier
from acausal.netlists.packages import package
from acausal.netlists.spice.cards import Element, Netlist, warning
from acausal.netlists.spice.elements import controlled, incomplete, passive
from acausal.netlists.spice.expressions import value_of
from acausal.netlists.spice.lines import Token
from acausal.netlists.spice.scope import GROUND, Scope, Value, set_values
from acausal.netlists.spice.semiconductors import device
from acausal.netlists.spice.start import capacitor_starts
from acausal.netlists.spice.waves import source

_MOST_LEVELS = 50


def model_of(netlist: Netlist, name: str) -> Model:
    """Return the model of a netlist.

    Args:
        netlist: Its cards.
        name: Name of the model.

    Raises:
        AcausalError: For all that is not understood.
    """
    circuit = netlist.circuit
    if not circuit.elements:
        fail("P040", "the netlist has no elements", circuit.span,
             help="its first line is the title; elements follow")  # fmt: skip
    scope = Scope(netlist, circuit, Model(name, netlist.title))
    _fill(scope)
    for key, cuts in scope.nodes.items():
        if key != GROUND:
            _voltage(scope, key, cuts[0])
    times = [scope.value(t).number for t in netlist.transient]
    if times:
        step, stop = times[:2]
        if not 0 < step <= stop:
            fail("P040", f".tran {step:g} {stop:g}", circuit.span,
                 help="the step is positive and smaller than the stop time")  # fmt: skip
        scope.model.experiment(stop_time=stop, interval=step)
    return scope.model


def _voltage(scope: Scope, key: str, cut: Any) -> None:
    """Declare the voltage of a node under a name of its own."""
    si = package("si")

    node = scope.spelling[key]
    variable = Variable(type=si.Voltage, description=f"voltage of node {node}")
    scope.add(f"v_{identifier(node, '')}", variable, scope.circuit.span)
    scope.model.equation(variable == cut.v)


def _fill(scope: Scope) -> None:
    """Make the elements of a circuit and join them."""
    electrical = package("electrical")
    spice = package("electrical.spice")

    for port in scope.circuit.ports:
        _port(scope, port.low, port.text, port.span, electrical.Pin)
    for element in scope.circuit.elements:
        # Elements come first in the choice of names, whatever their values need.
        scope.part_names[element.name.low] = scope.name(element.name.text, "e")
    scope.declare_parameters()
    starts = capacitor_starts(scope)
    made: list[tuple[Element, Component, list[tuple[str, Token]]]] = []
    for element in scope.circuit.elements:
        if element.letter == "K":
            continue
        part, cuts, reads = _part(scope, element, starts.get(element.name.low))
        _add(scope, element, part)
        made.append((element, part, cuts))
        if reads is not None:
            _read_current(scope, part, reads)
    for element, part, cuts in made:
        for cut, node in cuts:
            readers = scope.controls.get(element.name.low, ()) if cut == "n" else ()
            at = getattr(part, cut)
            for reader in readers:  # control ports in series with the source
                scope.model.connect(at, reader.p1)
                at = reader.n1
            scope.join(node, at)
    for element in scope.circuit.elements:
        if element.letter == "K":
            _couple(scope, element)
    for key in scope.shared:
        if key not in [p.low for p in scope.circuit.ports]:
            _port(scope, key, scope.spelling[key], scope.circuit.span, electrical.Pin)
    if GROUND in scope.nodes:
        ground = spice.Ground()
        scope.add("ground", ground, scope.circuit.span)
        scope.nodes.setdefault(GROUND, []).append(ground.p)
    elif scope.parent is None:
        fail("C110", "no element is connected to node 0", scope.circuit.span,
             help="one node is ground and is called 0")  # fmt: skip
    for cuts_at in scope.nodes.values():
        if len(cuts_at) > 1:
            scope.model.connect(*cuts_at)


def _port(scope: Scope, key: str, text: str, span: Span, pin: Any) -> None:
    """Declare a node of a subcircuit that is seen from outside."""
    part = pin()
    scope.add(text, part, span, "n")
    scope.spelling.setdefault(key, text)
    scope.port_names[key] = part._name
    scope.nodes.setdefault(key, []).insert(0, part)


def _add(scope: Scope, element: Element, part: Component) -> None:
    part._span = element.span
    scope.model.add(scope.part_names[element.name.low], part)
    scope.elements[element.name.low] = part


def _part(
    scope: Scope, element: Element, start: Value | None
) -> tuple[Component, list[tuple[str, Token]], Token | None]:
    """Return what an element becomes, its cuts with their nodes, and the source it reads."""
    letter, words = element.letter, element.words
    if letter in "EFGH":
        return controlled(scope, element)
    if letter in "DQM":
        return *device(scope, element), None
    if letter == "X":
        return *_instance(scope, element), None
    if len(words) < 2:
        incomplete(element)
    part = source(scope, element) if letter in "VI" else passive(scope, element, start)
    return part, [("p", words[0]), ("n", words[1])], None


def _instance(scope: Scope, element: Element) -> tuple[Component, list[tuple[str, Token]]]:
    """Return a subcircuit and its cuts."""
    words = [w for w in element.words if w.low != "params:"]
    if not words:
        incomplete(element)
    circuit = scope.find_circuit(words[-1])
    nodes = words[:-1]
    if len(nodes) != len(circuit.ports):
        fail("P040", f"{circuit.name} has {len(circuit.ports)} nodes, and {element.name.text} "
             f"gives {len(nodes)}", element.span,
             labels=[Label(circuit.span, "its nodes")],
             help="give each node of the subcircuit one node")  # fmt: skip
    around = list(scope.circuits())
    if len(around) > _MOST_LEVELS or any(s.circuit is circuit for s in around):
        fail("N106", f"{circuit.name} contains itself", element.span,
             help="break the circle of subcircuits")  # fmt: skip
    title = identifier(circuit.name, "circuit_")
    inside = Scope(scope.netlist, circuit, Model(title), scope, element.options)
    _fill(inside)
    set_values(inside.model, inside.passed, element.span)
    cuts = list(zip((inside.port_names[p.low] for p in circuit.ports), nodes, strict=True))
    for key in inside.shared:
        if key not in [p.low for p in circuit.ports]:
            node = Token("word", inside.spelling[key], element.span)
            cuts.append((inside.port_names[key], node))
    return inside.model, cuts


def _read_current(scope: Scope, part: Any, reads: Token) -> None:
    """Put the control port of a source in series with the voltage source that it names.

    Raises:
        AcausalError: ``N122``.
    """
    found = next((e for e in scope.circuit.elements if e.name.low == reads.low), None)
    if found is None or found.letter != "V":
        known = [e.name.text for e in scope.circuit.elements if e.letter == "V"]
        close = nearest(reads.text, known)
        fail(
            "N122",
            f"there is no voltage source {reads.text}",
            reads.span,
            notes=[f"did you mean {close[0]}?"] if close else [],
            help="currents are read from voltage sources of the same circuit; add one of 0 V",
        )
    scope.controls.setdefault(reads.low, []).append(part)


def _couple(scope: Scope, element: Element) -> None:
    """Couple coils, each pair of them.

    The library's positive coupling has the marks at opposite ends, SPICE's at the same.
    """
    spice = package("electrical.spice")

    if len(element.words) < 3:
        incomplete(element)
    coefficient = scope.value(value_of(element.words[-1]))
    if not abs(coefficient.number) <= 1:
        fail("P042", f"a coupling coefficient of {coefficient.number:g}", element.words[-1].span,
             help="it lies between -1 and 1")  # fmt: skip
    coils = []
    for word in element.words[:-1]:
        coil: Any = scope.elements.get(word.low)
        if coil is None or word.low[0] != "l":
            known = [e.name.text for e in scope.circuit.elements if e.letter == "L"]
            close = nearest(word.text, known)
            fail("N122", f"there is no inductor {word.text}", word.span,
                 notes=[f"did you mean {close[0]}?"] if close else [],
                 help="K names inductors of the same circuit")  # fmt: skip
        coils.append(coil)
    name = scope.part_names[element.name.low]
    for i, first in enumerate(coils):
        for j in range(i + 1, len(coils)):
            part = spice.K_CoupledInductors(k=-coefficient.given)
            part._span = element.span
            more = len(coils) > 2
            scope.model.add(scope.name(f"{name}_{i + 1}_{j + 1}", "e") if more else name, part)
            scope.model.connect(first.ICP, part.inductiveCouplePin1)
            scope.model.connect(coils[j].ICP, part.inductiveCouplePin2)


def uic_warnings(netlist: Netlist) -> list[Diagnostic]:
    """Return a warning if transistors start at the operating point although UIC is given."""
    transistors: list[Element] = []
    circuits = [netlist.circuit]
    while circuits:
        circuit = circuits.pop()
        transistors += [e for e in circuit.elements if e.letter in "QM"]
        circuits += circuit.circuits.values()
    if not netlist.uic or not transistors:
        return []
    return [warning("P043", "UIC has no effect on the charges in transistors",
                    transistors[0].span, "they do not change at first")]  # fmt: skip
