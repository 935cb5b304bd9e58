"""What names mean in the equations and modifications of a class."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from acausal.diagnostics import fail
from acausal.diagnostics.suggest import nearest
from acausal.expressions.nodes import Expr, slot
from acausal.expressions.traverse import slots
from acausal.instantiation.builtins import builtin_names, find_builtin
from acausal.instantiation.domain import loop_names
from acausal.instantiation.event_operators import event_operator_names, find_event_operator
from acausal.instantiation.expressions import Environment, elaborate
from acausal.instantiation.merge import merge, primitive_type
from acausal.instantiation.references import component_shape, declaration_of
from acausal.instantiation.subscripts import subscripted
from acausal.instantiation.template import Domain, Ref, Signal, SignalDecl
from acausal.instantiation.values import LITERAL, NeedsUnroll, Value, number, scalar, table
from acausal.instantiation.vectorised_calls import call_function
from acausal.modeling.classes import BUILTIN_TYPES, Builtin, ClassDef, Constant, find_name
from acausal.syntax import tree
from acausal.syntax.formatter import format_expression

if TYPE_CHECKING:
    from acausal.instantiation.elaborate import TemplateBuilder

#: The predefined enumeration ``StateSelect``.
STATE_SELECT = ("never", "avoid", "default", "prefer", "always")


class ClassEnvironment:
    """Names as seen in class ``owner``, whose instance is being elaborated by ``builder``.

    Attributes:
        builder: Elaborator of the instance; None where only constants may be used.
        owner: The class the text is written in.
        locals: Loop and reduction indices, which hide other names.
        depth: Depth of function calls.
        domain: The loops around the text.
    """

    def __init__(
        self,
        builder: TemplateBuilder | None,
        owner: ClassDef,
        locals_: dict[str, Value] | None = None,
        depth: int = 0,
        domain: Domain | None = None,
    ) -> None:
        self.builder = builder
        self.owner = owner
        self.locals = {} if locals_ is None else locals_
        self.depth = depth
        self.domain = Domain() if domain is None else domain

    def with_locals(self, values: dict[str, Value]) -> ClassEnvironment:
        """Return the environment with names that hide others."""
        own = {**self.locals, **values}
        return ClassEnvironment(self.builder, self.owner, own, self.depth, self.domain)

    def inside(self, domain: Domain) -> ClassEnvironment:
        """Return the environment of the same text inside loops."""
        if domain is self.domain:
            return self
        return ClassEnvironment(self.builder, self.owner, self.locals, self.depth, domain)

    def in_class(self, owner: ClassDef) -> ClassEnvironment:
        """Return the environment of the same instance in the scope of another class."""
        return ClassEnvironment(self.builder, owner, self.locals, self.depth, self.domain)

    def reference(self, reference: tree.Reference) -> Value:
        """Return the value of a component reference, constant or enumeration literal.

        Raises:
            AcausalError: ``N102`` if there is no such name.
        """
        first = reference.parts[0]
        if not reference.absolute:
            if first.name in self.locals and len(reference.parts) == 1:
                return subscripted(self.locals[first.name], first.subscripts, self, reference.span)
            if self.builder is not None and first.name in self.builder.merged.elements:
                return self.builder.reference(reference, self)
        return self.constant(reference)

    def stored(self, reference: tree.Reference) -> Value:
        """Return the variable that a reference names."""
        return self.reference(reference)

    def events(self, call: tree.Call) -> None:
        """Refuse an operator of hybrid systems where there are no events.

        Raises:
            AcausalError: ``E008``.
        """
        if self.builder is None:
            fail("E008", f"{call.function} has no meaning here", call.span,
                 help="functions and types have no events; use it in a model")  # fmt: skip

    def signal(self, kind: str, operands: tuple[Expr, ...], source: tree.Expression) -> Expr:
        """Return the slot of a signal, declared here if it is new.

        Raises:
            AcausalError: ``E008`` in functions and types.
            NeedsUnroll: If an operand depends on a loop that runs over an array expression.
        """
        if self.builder is None:
            fail("E008", "there are no events here", source.span,
                 help="functions and types have no events; use it in a model")  # fmt: skip
        declared = self.builder.template.signals
        names = loop_names(*operands)
        for inside in slots(*operands):
            if isinstance(inside, Signal) and inside.number >= 0:
                names.update(declared[inside.number].domain.names)
        if not names <= set(self.domain.names):
            raise NeedsUnroll
        domain = self.domain if names else Domain()
        key = (kind, operands, domain.names, domain.values.tobytes())
        known = self.builder.signal_numbers
        if key not in known:
            known[key] = len(declared)
            declared.append(
                SignalDecl(kind, operands, domain, source.span, format_expression(source))
            )
        return slot(Signal(known[key]))

    def is_discrete(self, ref: Ref) -> bool:
        """Tell whether a variable is declared to change at events only."""
        return self.builder is not None and declaration_of(self.builder.template, ref).discrete

    def component_shape(self, reference: tree.Reference) -> tuple[int, ...] | None:
        """Return the array dimensions of a component; None if the name means a value."""
        first = reference.parts[0].name
        if self.builder is None or reference.absolute or first in self.locals:
            return None
        if first not in self.builder.merged.elements:
            return None
        return component_shape(self.builder, reference, self)

    def constant(self, reference: tree.Reference) -> Value:
        """Return a constant found by class lookup; of an enumeration type, all its values.

        Raises:
            AcausalError: ``N102`` if there is no such name.
        """
        names = [p.name for p in reference.parts]
        if names[0] == "StateSelect" and len(names) == 2 and names[1] in STATE_SELECT:
            return number(STATE_SELECT.index(names[1]) + 1.0, "Integer", None)
        found = find_name(self.owner, _without_subscripts(reference))
        if isinstance(found, Constant):
            return self._constant_value(found, reference)
        if len(names) > 1:
            outer = find_name(self.owner, _without_subscripts(reference, len(names) - 1))
            if isinstance(outer, ClassDef):
                kind = primitive_type(outer)
                if kind is not None and kind.enumeration is not None:
                    return enumeration_literal(kind.enumeration, names[-1], reference)
        kind = primitive_type(found) if isinstance(found, ClassDef) else None
        if kind is not None and kind.enumeration is not None:
            literals = np.arange(1.0, len(kind.enumeration.tree.enumeration or ()) + 1.0)
            return replace(table(literals, "enumeration"), enumeration=kind.enumeration)
        if found is not None:
            fail("N110", f"{reference} is a class, not a value", reference.span,
                 help="name a component, parameter or constant")  # fmt: skip
        self.unknown(reference)

    def unknown(self, reference: tree.Reference) -> NoReturn:
        """Refuse a name that means nothing.

        Raises:
            AcausalError: ``N102``.
        """
        name = reference.parts[0].name
        known = list(self.locals)
        if self.builder is not None:
            known += self.builder.merged.elements
        close = nearest(name, known)
        fail(
            "N102",
            f"there is no {reference} in {self.owner.full_name}",
            reference.span,
            label="this name is not declared",
            notes=[f"did you mean {' or '.join(close)}?"] if close else [],
            help=f"write {close[0]}, if that is what you mean" if close else f"declare {name}",
        )

    def _constant_value(self, found: Constant, reference: tree.Reference) -> Value:
        declaration = found.declaration
        if "constant" not in declaration.prefixes and "parameter" not in declaration.prefixes:
            self.unknown(reference)
        from acausal.instantiation.elaborate import constant_of_class

        value = constant_of_class(found, self.depth)
        return subscripted(value, reference.parts[-1].subscripts, self, reference.span)

    def call(self, call: tree.Call) -> Value:
        """Return the value of a function call (its first output)."""
        return self.call_in(call, self)

    def call_in(self, call: tree.Call, arguments: Environment) -> Value:
        """Return the first output; arguments are read in another environment."""
        parts = call.function.parts
        if len(parts) == 1 and not call.function.absolute:
            handler = find_builtin(parts[0].name)
            if handler is None:
                handler = find_event_operator(parts[0].name)
            if handler is not None:
                return handler(call, arguments)
            if parts[0].name in BUILTIN_TYPES and len(call.arguments) == 1:
                value = elaborate(call.arguments[0], arguments)
                if parts[0].name == "Integer" and value.type == "enumeration":
                    return Value("Integer", value.shape, value.get, LITERAL)
                return value
        if len(parts) == 2 and parts[0].name == "Connections":
            from acausal.instantiation.overdetermined import ask_connections

            return ask_connections(call, self)
        results = self.call_all(call, arguments)
        if not results:
            fail("T120", f"{call.function} gives no value", call.span,
                 help="declare an output in the function")  # fmt: skip
        return results[0]

    def call_all(self, call: tree.Call, arguments: Environment) -> list[Value]:
        """Return all outputs of a call of a user function or record constructor."""
        found = find_name(self.owner, call.function, skip_components=True)
        if isinstance(found, Builtin) or not isinstance(found, ClassDef):
            name = str(call.function)
            close = nearest(
                name, [*builtin_names(), *event_operator_names(), *_functions_near(self.owner)]
            )
            fail("N116", f"there is no function {name}", call.function.span,
                 notes=[f"did you mean {' or '.join(close)}?"] if close else [],
                 help=f"write {close[0]}" if close else "declare it or import it")  # fmt: skip
        given = [elaborate(a, arguments) for a in call.arguments]
        named = {n.name: elaborate(n.value, arguments) for n in call.named}
        if found.kind == "record":
            return [self._record(found, call, given, named)]
        kind = primitive_type(found)
        if kind is not None and kind.enumeration is not None and len(given) == 1:
            return [scalar(given[0].expr, "enumeration", None, kind.enumeration)]
        if found.kind != "function":
            fail("N116", f"{call.function} is a {found.kind}, not a function", call.function.span,
                 help="only functions and records can be called")  # fmt: skip
        inner = ClassEnvironment(None, found, None, self.depth + 1)
        return call_function(found, call, given, named, inner, self.depth + 1)

    def _record(
        self, record: ClassDef, call: tree.Call, given: list[Value], named: dict[str, Value]
    ) -> Value:
        merged = merge(record)
        fields: dict[str, Value] = {}
        env = ClassEnvironment(None, record, fields, self.depth + 1)
        for k, (name, element) in enumerate(merged.elements.items()):
            if k < len(given):
                fields[name] = given[k]
            elif name in named:
                fields[name] = named[name]
            else:
                binding = next((m for m in element.modifications if not m.path), None)
                if binding is None:
                    fail("T120", f"{record.name} needs a value for {name}", call.span,
                         help=f"write {record.name}({name} = ...)")  # fmt: skip
                fields[name] = elaborate(binding.value, env.in_class(binding.owner))
        extra = [n for n in named if n not in merged.elements]
        if extra or len(given) > len(merged.elements):
            fail("T120", f"{record.name} has no field {extra[0] if extra else 'left'}", call.span,
                 help=f"its fields are {', '.join(merged.elements)}")  # fmt: skip
        return Value("record", (), lambda _: next(iter(fields.values())).expr, None, None, fields)


def enumeration_literal(enumeration: ClassDef, name: str, reference: tree.Reference) -> Value:
    """Return a literal of an enumeration.

    Raises:
        AcausalError: ``N102`` if it has no such literal.
    """
    names = [n for n, _ in enumeration.tree.enumeration or ()]
    if name not in names:
        close = nearest(name, names)
        fail("N102", f"{enumeration.name} has no value {name}", reference.span,
             notes=[f"did you mean {' or '.join(close)}?"] if close else [],
             help=f"its values are {', '.join(names)}")  # fmt: skip
    value = number(names.index(name) + 1.0, "enumeration", None)
    return scalar(value.expr, "enumeration", None, enumeration)


def _without_subscripts(reference: tree.Reference, count: int | None = None) -> tree.Reference:
    parts = tuple(tree.NamePart(p.span, p.name) for p in reference.parts[:count])
    return tree.Reference(reference.span, parts, reference.absolute)


def _functions_near(owner: ClassDef) -> list[str]:
    scope = owner.parent
    return scope.names() if scope is not None else []
