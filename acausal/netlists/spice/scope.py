"""A circuit that becomes a model: names, nodes, and values of parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from acausal.compose.component import Component
from acausal.compose.model import Model
from acausal.compose.modifiers import modifier
from acausal.compose.names import RESERVED
from acausal.compose.parts import Part, modify
from acausal.diagnostics import Diagnostic, Span, fail
from acausal.diagnostics.suggest import nearest
from acausal.netlists.identifiers import identifier
from acausal.netlists.spice.cards import Circuit, ModelCard, Netlist
from acausal.netlists.spice.expressions import (
    Expression,
    Name,
    Number,
    evaluate,
    names_in,
    symbolic,
)
from acausal.netlists.spice.lines import Token

GROUND = "0"


@dataclass(frozen=True, slots=True)
class Value:
    """A value of a card.

    Attributes:
        number: Its number, with the parameters as they are in the netlist.
        given: What the model gets: the number, or an expression of its parameters.
    """

    number: float
    given: Any

    def map(self, function: Callable[[Any], Any]) -> Value:
        """Return a function of the value."""
        return Value(function(self.number), function(self.given))


def constant(number: float) -> Value:
    """Return a value that depends on no parameter; whole numbers are written as such."""
    whole = abs(number) < 1e7 and number == int(number)
    return Value(number, int(number) if whole else number)


class Scope:
    """One circuit, or one instance of a subcircuit.

    Args:
        netlist: The whole netlist.
        circuit: What it is made of.
        model: What is made of it.
        parent: The circuit that the instance is in.
        given: Values of the instance for parameters of the subcircuit.
    """

    def __init__(
        self,
        netlist: Netlist,
        circuit: Circuit,
        model: Model,
        parent: Scope | None = None,
        given: dict[str, tuple[Token, Expression]] | None = None,
    ) -> None:
        self.netlist = netlist
        self.circuit = circuit
        self.model = model
        self.parent = parent
        self.given = given or {}
        self.names: set[str] = set()
        #: Node -> cuts at it, in order of appearance.
        self.nodes: dict[str, list[Any]] = {}
        self.spelling: dict[str, str] = {}
        self.elements: dict[str, Part] = {}
        #: Names in the model of elements and of nodes that are seen from outside.
        self.part_names: dict[str, str] = {}
        self.port_names: dict[str, str] = {}
        #: Voltage source -> controlled sources that read its current.
        self.controls: dict[str, list[Any]] = {}
        #: Modifiers that the instance needs, made of the parent's values.
        self.passed: list[tuple[str, Any]] = []
        self.shared: list[str] = []
        #: Classes made of model cards, of the whole netlist.
        self.classes: dict[Any, Any] = {} if parent is None else parent.classes
        self._values: dict[str, Value] = {}
        self._open: list[str] = []

    # --- names ------------------------------------------------------------------------------

    def name(self, text: str, prefix: str) -> str:
        """Return an identifier that is free in the model."""
        found = identifier(text, prefix)
        while found in self.names or found in RESERVED or hasattr(Model, found):
            found += "_"
        self.names.add(found)
        return found

    def add(self, text: str, part: Part, span: Span, prefix: str = "e") -> str:
        """Add a part; return its name in the model."""
        name = self.name(text, prefix)
        part._span = span
        self.model.add(name, part)
        return name

    def circuits(self) -> Iterator[Scope]:
        """Yield this circuit and those around it."""
        scope: Scope | None = self
        while scope is not None:
            yield scope
            scope = scope.parent

    def find_model(self, token: Token) -> ModelCard:
        """Return a model card by name.

        Raises:
            AcausalError: ``N122``.
        """
        for scope in self.circuits():
            if token.low in scope.circuit.models:
                return scope.circuit.models[token.low]
        known = [m.name.text for s in self.circuits() for m in s.circuit.models.values()]
        close = nearest(token.text, known)
        return fail("N122", f"there is no .model {token.text}", token.span,
                    notes=[f"did you mean {' or '.join(close)}?"] if close else [],
                    help=f"write .model {token.text} and its kind and parameters")  # fmt: skip

    def has_model(self, token: Token) -> bool:
        """Tell whether a word is the name of a model card."""
        return any(token.low in s.circuit.models for s in self.circuits())

    def find_circuit(self, token: Token) -> Circuit:
        """Return a subcircuit by name.

        Raises:
            AcausalError: ``N122``.
        """
        for scope in self.circuits():
            if token.low in scope.circuit.circuits:
                return scope.circuit.circuits[token.low]
        known = [c.name for s in self.circuits() for c in s.circuit.circuits.values()]
        close = nearest(token.text, known)
        return fail("N122", f"there is no .subckt {token.text}", token.span,
                    notes=[f"did you mean {' or '.join(close)}?"] if close else [],
                    help="define it, or include the file that does")  # fmt: skip

    # --- nodes ------------------------------------------------------------------------------

    def join(self, node: Token, cut: Any) -> None:
        """Put a cut at a node."""
        key = self.key(node)
        self.nodes.setdefault(key, []).append(cut)

    def key(self, node: Token) -> str:
        """Return the name of a node without capitals; ground is 0."""
        if node.kind != "word":
            fail("P040", f"{node.text} is no node", node.span, help="name a node")
        key = node.low
        if key in ("0", "gnd"):
            return GROUND
        self.spelling.setdefault(key, node.text)
        if key in self.netlist.globals and self.parent is not None and key not in self.shared:
            self.shared.append(key)
        return key

    # --- values -----------------------------------------------------------------------------

    def value(self, expression: Expression) -> Value:
        """Return a value.

        Raises:
            AcausalError: ``N122`` for unknown parameters, ``P042`` for values that are not finite.
        """
        if isinstance(expression, Number):
            return constant(expression.value)
        found = evaluate(expression, lambda n: self._parameter(n).number)
        if not names_in(expression):
            return constant(found)
        return Value(found, symbolic(expression, lambda n: self._parameter(n).given))

    def _parameter(self, name: Name) -> Value:
        key = name.name.lower()
        found = self._values.get(key)
        if found is None:
            if key in self._open:
                fail("P042", f"the parameter {name.name} needs its own value", name.span,
                     help="break the circle: give one of them a number")  # fmt: skip
            self._open.append(key)
            found = self._values[key] = self._declared(key, name)
            self._open.pop()
        return found

    def _declared(self, key: str, name: Name) -> Value:
        circuit = self.circuit
        if key in circuit.defaults:
            token, expression = circuit.defaults[key]
            return self._passed(token.text, self.value(expression), self.given.get(key), token.span)
        if key in circuit.parameters:
            token, expression = circuit.parameters[key]
            value = self.value(expression)
            return Value(value.number, self._declare(token.text, value.given, token.span))
        if self.parent is None:
            if key in ("pi", "e"):
                from math import e, pi

                return constant({"pi": pi, "e": e}[key])
            known = [t.text for t, _ in circuit.parameters.values()]
            close = nearest(name.name, known)
            fail("N122", f"there is no parameter {name.name}", name.span,
                 notes=[f"did you mean {' or '.join(close)}?"] if close else [],
                 help=f"write .param {name.name}=value")  # fmt: skip
        outside = self.parent._parameter(name)
        if isinstance(outside.given, int | float):
            return outside
        inside = self._declare(name.name, outside.number, name.span)
        self.passed.append((inside._name, outside.given))
        return Value(outside.number, inside)

    def _passed(
        self, text: str, default: Value, given: tuple[Token, Expression] | None, span: Span
    ) -> Value:
        """Return a parameter of a subcircuit; the instance may give it another value."""
        part = self._declare(text, default.given, span)
        if given is None or self.parent is None:
            return Value(default.number, part)
        outside = self.parent.value(given[1])
        self.passed.append((part._name, outside.given))
        return Value(outside.number, part)

    def _declare(self, text: str, value: Any, span: Span) -> Any:
        from acausal.compose.declarations import Parameter

        part = Parameter(value)
        self.add(text, part, span, "p")
        return part

    def declare_parameters(self) -> None:
        """Declare all parameters, used or not, so that they can be changed."""
        span = self.circuit.span
        for token, _ in [*self.circuit.defaults.values(), *self.circuit.parameters.values()]:
            self._parameter(Name(token.text, token.span))
        for key, (token, _) in self.given.items():
            if key not in self.circuit.defaults:
                known = [t.text for t, _ in self.circuit.defaults.values()]
                close = nearest(token.text, known)
                fail("N122", f"{self.circuit.name} has no parameter {token.text}", token.span,
                     notes=[f"did you mean {close[0]}?"] if close else [],
                     help=f"its parameters are {', '.join(known)}" if known
                     else f"declare it: .subckt {self.circuit.name} ... {token.text}=value at "
                     f"line {span.line}")  # fmt: skip

    def warn(self, diagnostic: Diagnostic) -> None:
        """Note something that has no effect; once for all instances."""
        if diagnostic not in self.netlist.warnings:
            self.netlist.warnings.append(diagnostic)


def set_values(part: Component, values: list[tuple[str, Any]], span: Span) -> None:
    """Give an instance values for its parameters."""
    made = [modifier(part._kind, name, value, 0, span) for name, value in values]
    modify(part, (*part._modifiers, *made))
