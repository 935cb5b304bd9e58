"""From a class to its template: elements declared on demand, then bindings and equations.

One template is made for every distinct structure of a class: the class together with the values
of its structural parameters (constants, Integer, Boolean, enumeration and String parameters, and
arrays whose size is left open). Everything else that a modification sets is a number in an array
and makes no new template.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field, replace

import numpy as np

from acausal.diagnostics import Label, fail
from acausal.diagnostics.suggest import nearest
from acausal.expressions.nodes import ONE, const
from acausal.instantiation import equations as equation_sections
from acausal.instantiation.bindings import bind_attributes, bind_child, bind_value
from acausal.instantiation.environment import ClassEnvironment
from acausal.instantiation.expressions import constant_number, elaborate
from acausal.instantiation.merge import (
    Element,
    Merged,
    Modification,
    PrimitiveType,
    merge,
    primitive_type,
    type_of,
    unknown_modifier,
)
from acausal.instantiation.references import follow
from acausal.instantiation.template import Child, Template, VariableDecl
from acausal.instantiation.values import (
    Index,
    UnitOf,
    Value,
    constants,
    indices,
    key,
    listed,
    scalar,
    string,
    table,
)
from acausal.modeling.classes import ClassDef, Constant, find_name
from acausal.syntax import tree
from acausal.units.unit import UnitError, parse_unit

#: What may be set on a variable besides its value.
NUMERIC_ATTRIBUTES = ("start", "fixed", "min", "max", "nominal", "stateSelect")
TEXT_ATTRIBUTES = ("unit", "displayUnit", "quantity")

Path = tuple[str, ...]


@dataclass(frozen=True)
class Environment:
    """What reaches a class from outside and decides its structure.

    Attributes:
        values: Values of structural parameters, by path below the class.
        bound: Variables whose own declaration equation is replaced from outside.
        inner: Templates of the ``inner`` components in sight, by name.
        inner_values: Templates that declare the ``inner`` variables in sight, by name.
        parameters: All variables are parameters (a record declared ``parameter``).
    """

    values: dict[Path, Value] = field(default_factory=dict)
    bound: frozenset[Path] = frozenset()
    inner: dict[str, Template] = field(default_factory=dict)
    inner_values: dict[str, Template] = field(default_factory=dict)
    parameters: bool = False

    def key(self) -> Hashable:
        """Return what tells structures apart."""
        return (
            tuple(sorted((p, key(v)) for p, v in self.values.items())),
            tuple(sorted(self.bound)),
            tuple((n, t.number) for n, t in sorted(self.inner.items())),
            # These are still being built, and have no number yet.
            tuple((n, id(t)) for n, t in sorted(self.inner_values.items())),
            self.parameters,
        )

    def below(self, name: str) -> tuple[dict[Path, Value], frozenset[Path]]:
        """Return what concerns one component."""
        values = {p[1:]: v for p, v in self.values.items() if p[0] == name and len(p) > 1}
        return values, frozenset(p[1:] for p in self.bound if p[0] == name and len(p) > 1)


class Elaborator:
    """All templates of one model, shared between equal structures."""

    def __init__(self) -> None:
        self.templates: list[Template] = []
        self._by_key: dict[Hashable, Template] = {}
        #: What is being elaborated, outermost first.
        self.active: list[tuple[ClassDef, Element | None]] = []

    def template(
        self, definition: ClassDef, environment: Environment, element: Element | None = None
    ) -> Template:
        """Return the template of a class in an environment.

        Raises:
            AcausalError: For mistakes in the class or in what is used of it.
        """
        where = (definition, environment.key())
        found = self._by_key.get(where)
        if found is not None:
            return found
        if len(self.active) > 60 or sum(d is definition for d, _ in self.active) > 8:
            fail(
                "N106",
                f"{definition.full_name} contains itself",
                element.declaration.span if element else definition.span,
                label="a component of this class has a component of this class, without end",
                help="remove the component, or make it conditional on a parameter that ends it",
            )
        self.active.append((definition, element))
        try:
            template = TemplateBuilder(self, definition, environment).build()
        finally:
            self.active.pop()
        self._by_key[where] = template
        return template

    def primitive_cut(
        self, kind: PrimitiveType, definition: ClassDef, own: VariableDecl
    ) -> Template:
        """Return the template of a connector that is a single number, such as RealInput."""
        where = (definition, own.unit, own.causality, own.type_name, own.discrete)
        found = self._by_key.get(where)
        if found is None:
            found = Template(len(self.templates), definition, primitive_connector=True)
            found.variables[""] = own
            if kind.enumeration is not None:
                found.enumerations[""] = kind.enumeration
            self.templates.append(found)
            self._by_key[where] = found
        return found


class TemplateBuilder:
    """Builds one template. Elements are declared when first needed, so order does not matter."""

    def __init__(
        self, elaborator: Elaborator, definition: ClassDef, environment: Environment
    ) -> None:
        self.elaborator = elaborator
        self.environment = environment
        self.merged: Merged = merge(definition)
        self.template = Template(-1, definition, bound=environment.bound)
        #: Elements declared ``inner``; a class of many components looks for them once.
        self._inner = [e for e in self.merged.elements.values() if e.has("inner")]
        self._declared: set[str] = set()
        #: What numbers for components of a template set: by template, path and type of literal.
        self.usual_targets: dict[tuple[int, Path, type], tuple[str, str, bool]] = {}
        #: Templates of components whose modifications decide nothing, by class and paths.
        self._usual: dict[tuple[ClassDef, tuple[Path, ...]], Template] = {}
        self._active: list[str] = []
        #: Signals by what they are made of.
        self.signal_numbers: dict[Hashable, int] = {}
        #: Child components, variables and parameters that still need their bindings.
        self.kinds: dict[str, PrimitiveType | None] = {}

    def scope(self, owner: ClassDef) -> ClassEnvironment:
        """Return the environment of text that is written in ``owner``."""
        return ClassEnvironment(self, owner)

    def forget_signals(self, count: int) -> None:
        """Undo the declaration of all but the first ``count`` signals."""
        del self.template.signals[count:]
        self.signal_numbers = {k: n for k, n in self.signal_numbers.items() if n < count}

    def build(self) -> Template:
        """Declare everything, bind, and elaborate the equations."""
        for name in self.merged.elements:
            self.declare(name)
        self._in_order()
        self.template.number = len(self.elaborator.templates)
        self.elaborator.templates.append(self.template)
        for name, element in self.merged.elements.items():
            if name in self.template.absent or name in self.template.outers:
                continue
            if name in self.template.outer_values:
                continue
            kind = self.kinds[name]
            if name in self.template.children:
                bind_child(self, element, self.template.children[name])
            elif kind is not None and name not in self.template.structural:
                bind_value(self, element, kind)
                bind_attributes(self, element, kind)
        equation_sections.elaborate_sections(self)
        return self.template

    def _in_order(self) -> None:
        order = {n: k for k, n in enumerate(self.merged.elements)}
        for entries in (
            self.template.variables,
            self.template.parameters,
            self.template.children,
            self.template.structural,
        ):
            items = sorted(entries.items(), key=lambda item: order[item[0]])
            entries.clear()
            entries.update(items)  # type: ignore[arg-type]

    # --- declarations ------------------------------------------------------------------

    def declare(self, name: str) -> None:
        """Make sure that an element is declared.

        Raises:
            AcausalError: ``N117`` when constants depend on each other in a circle.
        """
        if name in self._declared:
            return
        element = self.merged.elements[name]
        if name in self._active:
            cycle = [*self._active[self._active.index(name) :], name]
            fail("N117", f"{' needs '.join(cycle)}", element.declaration.span,
                 label="the values depend on each other in a circle",
                 help="give one of them a value of its own")  # fmt: skip
        self._active.append(name)
        try:
            self._declare(element)
        finally:
            self._active.pop()
        self._declared.add(name)

    def _declare(self, element: Element) -> None:
        name, declaration = element.name, element.declaration
        env = self.scope(element.owner)
        if declaration.condition is not None:
            value = elaborate(declaration.condition, env)
            number_ = constants(value) if value.type == "Boolean" else None
            if number_ is None:
                fail("T103", f"whether {name} exists must be known before the simulation",
                     declaration.condition.span,
                     help="use a Boolean parameter in the condition")  # fmt: skip
            if not number_:
                self.template.absent.add(name)
                return
        if element.has("outer"):
            self._declare_outer(element)
            if not element.has("inner"):
                return
        definition = type_of(element)
        kind = primitive_type(definition)
        self.kinds[name] = kind
        if element.has("inner") and kind is not None and not kind.connector:
            self.template.inner_values.add(name)
        if kind is None:
            assert isinstance(definition, ClassDef)
            self._declare_component(element, definition)
            return
        size: tuple[int, ...] | None = None
        if self._is_structural(element, kind):
            size = self._size_only(element, kind)
            if size is None:
                self.template.structural[name] = self._structural_value(element, kind)
                return
        parameter = element.has("parameter") or self.environment.parameters
        if kind.base == "String":
            fail("T110", "a text cannot change during the simulation", declaration.span,
                 help=f"declare {name} as a parameter")  # fmt: skip
        enumeration = kind.enumeration
        own = VariableDecl(
            name,
            self._shape(element, kind, size),
            self._unit(element, kind),
            declaration.description,
            "through" in declaration.prefixes or "flow" in declaration.prefixes,
            kind.causality or next((p for p in ("input", "output") if element.has(p)), ""),
            declaration.span,
            declaration.public,
            kind.name,
            kind.base,
            literals_of(enumeration),
            not parameter and (kind.base != "Real" or element.has("discrete")),
        )
        if enumeration is not None:
            self.template.enumerations[name] = enumeration
        if parameter:
            self.template.parameters[name] = own
        elif kind.connector:
            assert isinstance(definition, ClassDef)
            inside = replace(own, name="", shape=())
            cut = self.elaborator.primitive_cut(kind, definition, inside)
            self.template.children[name] = Child(
                name, own.shape, cut, declaration.span, False, declaration.description,
                declaration.public,
            )  # fmt: skip
        else:
            self.template.variables[name] = own

    def _declare_outer(self, element: Element) -> None:
        name = element.name
        template = self.environment.inner.get(name)
        if template is None and name in self.environment.inner_values:
            self.template.outer_values[name] = self.environment.inner_values[name]
            return
        if template is None:
            # The place to mend is where the component that needs it is declared.
            _, user = self.elaborator.active[-1]
            where = element.declaration.span if user is None else user.declaration.span
            fail(
                "N118",
                f"{self.merged.definition.full_name} needs an inner component called {name}",
                where,
                labels=[Label(element.declaration.span, "asked for here")],
                help=f"declare it in the model: inner {element.declaration.type_name} {name};",
            )
        self.template.outers[name] = template

    def _declare_component(self, element: Element, definition: ClassDef) -> None:
        name = element.name
        if definition.tree.partial:
            fail("N111", f"{definition.full_name} is partial", element.declaration.span,
                 label="a partial class has no complete equations",
                 help="use a class that extends it")  # fmt: skip
        shape = self._shape(element, None)
        # A class of many components has many of one class, modified at the same places.
        usual = (definition, tuple([m.path for m in element.modifications]))
        plain = not (self.environment.values or self.environment.bound or self._inner or shape)
        if plain and not element.declaration.prefixes and usual in self._usual:
            self.template.children[name] = Child(
                name, shape, self._usual[usual], element.declaration.span, False,
                element.declaration.description, element.declaration.public,
            )  # fmt: skip
            return
        outside, bound_outside = self.environment.below(name)
        values: dict[Path, Value] = {}
        bound: set[Path] = set()
        for change in element.modifications:
            if change.path and not any(
                change.path[: k + 1] in outside for k in range(len(change.path))
            ):
                self._reach(definition, change, shape, element, values, bound)
        for name_, value in self._record_fields(element, definition):
            values.setdefault(name_, value)
        if any(not m.path for m in element.modifications) and not element.has("parameter"):
            bound |= set(record_leaves(definition))
        inner, inner_values = self._inner_in_sight(name)
        parameters = self.environment.parameters or (
            definition.kind == "record" and (element.has("parameter") or element.has("constant"))
        )
        environment = Environment(
            {**values, **outside},
            bound_outside | frozenset(bound),
            inner,
            inner_values,
            parameters,
        )
        template = self.elaborator.template(definition, environment, element)
        if plain and not values and definition.kind != "record":
            self._usual[usual] = template
        self.template.children[name] = Child(
            name, shape, template, element.declaration.span, element.has("inner"),
            element.declaration.description, element.declaration.public,
        )  # fmt: skip

    def _inner_in_sight(self, name: str) -> tuple[dict[str, Template], dict[str, Template]]:
        """Return the ``inner`` components and variables that component ``name`` sees."""
        if not self._inner:
            return self.environment.inner, self.environment.inner_values
        inner = dict(self.environment.inner)
        values = dict(self.environment.inner_values)
        for other in self._inner:
            if other.name != name:
                self.declare(other.name)
                if other.name in self.template.children:
                    inner[other.name] = self.template.children[other.name].template
                    values.pop(other.name, None)
                elif other.name in self.template.inner_values:
                    values[other.name] = self.template
                    inner.pop(other.name, None)
        return inner, values

    def _record_fields(self, element: Element, definition: ClassDef) -> list[tuple[Path, Value]]:
        """Return structural fields of a record that is bound as a whole."""
        if definition.kind != "record":
            return []
        whole = next((m for m in element.modifications if not m.path), None)
        if whole is None:
            return []
        value = elaborate(whole.value, self.scope(whole.owner))
        result: list[tuple[Path, Value]] = []
        for name, part in (value.fields or {}).items():
            inside = merge(definition).elements.get(name)
            kind = primitive_type(type_of(inside)) if inside is not None else None
            if inside is not None and kind is not None and self._is_structural(inside, kind):
                result.append(((name,), part))
        return result

    def _reach(
        self,
        definition: ClassDef,
        change: Modification,
        shape: tuple[int, ...],
        element: Element,
        values: dict[Path, Value],
        bound: set[Path],
    ) -> None:
        """Sort a modification of a component: structural value, bound variable, or neither."""
        where: ClassDef = definition
        for depth, name in enumerate(change.path):
            elements = merge(where).elements
            if name not in elements:
                unknown_modifier(replace(change, path=change.path[depth:]), where)
            inside = elements[name]
            for other in inside.modifications:
                if other.final and other.path == change.path[depth + 1 :]:
                    fail("N109", f"{name} is final and cannot be changed", change.span,
                         labels=[Label(other.span, "made final here")],
                         help="remove the modifier")  # fmt: skip
            found = type_of(inside)
            kind = primitive_type(found)
            if kind is None:
                assert isinstance(found, ClassDef)
                where = found
                continue
            rest = change.path[depth + 1 :]
            if rest:
                if len(rest) > 1 or rest[0] not in (*NUMERIC_ATTRIBUTES, *TEXT_ATTRIBUTES):
                    close = nearest(rest[0], [*NUMERIC_ATTRIBUTES, *TEXT_ATTRIBUTES])
                    fail("N103", f"{name} has no attribute {'.'.join(rest)}", change.span,
                         notes=[f"did you mean {' or '.join(close)}?"] if close else [],
                         help=f"a variable has {', '.join(NUMERIC_ATTRIBUTES)}")  # fmt: skip
                return
            path = change.path
            if self._is_structural(inside, kind):
                if path not in values:
                    values[path] = self._uniform(change, shape, element, kind)
            elif not inside.has("parameter") and not element.has("parameter"):
                bound.add(path)
            return
        if not element.has("parameter"):
            bound |= {change.path + leaf for leaf in record_leaves(where)}

    def _uniform(
        self, change: Modification, shape: tuple[int, ...], element: Element, kind: PrimitiveType
    ) -> Value:
        """Return a structural value that is the same for all components of an array."""
        value = elaborate(change.value, self.scope(change.owner))
        if kind.base == "Real" and value.shape and constants(value) is None:
            size = value.shape if change.each else value.shape[len(shape) :]
            return table(np.full(size, np.nan), "Real", None)
        if value.text is None and value.fields is None and constants(value) is None:
            fail("T103", f"{'.'.join(change.path)} of {element.name} must be known before the "
                 "simulation", change.span,
                 label="this depends on something that can change",
                 help="use Integer or Boolean parameters and constants here")  # fmt: skip
        if not shape or change.each or not value.shape:
            return value
        first = _component(value, tuple(ONE for _ in shape))
        for index in indices(shape):
            if key(_component(value, index)) != key(first):
                fail("T116", f"{'.'.join(change.path)} decides the structure of "
                     f"{element.name} and must be the same in the whole array", change.span,
                     help="declare the unlike components one by one")  # fmt: skip
        return first

    # --- parts of declarations ---------------------------------------------------------

    def _is_structural(self, element: Element, kind: PrimitiveType) -> bool:
        if element.has("constant"):
            return True
        if not element.has("parameter") and not self.environment.parameters:
            return False
        return kind.base != "Real" or any(
            isinstance(d, tree.Colon) for d in element.declaration.dimensions
        )

    def _size_only(self, element: Element, kind: PrimitiveType) -> tuple[int, ...] | None:
        """Return the shape of a Real array whose size only is known when compiling, or None.

        A value from outside that depends on parameters has come as an array of NaN.
        """
        if kind.base != "Real" or element.has("constant") or self.environment.parameters:
            return None
        value = self.environment.values.get((element.name,))
        if value is None:
            change = next((m for m in element.modifications if not m.path), None)
            if change is None:
                return None
            value = elaborate(change.value, self.scope(change.owner))
        if value.fields is not None or value.text is not None or not value.size:
            return None
        numbers = constants(value)
        return value.shape if numbers is None or np.isnan(numbers).all() else None

    def _structural_value(self, element: Element, kind: PrimitiveType) -> Value:
        name = element.name
        value = self.environment.values.get((name,))
        span = element.declaration.span
        if value is None:
            change = next((m for m in element.modifications if not m.path), None)
            if change is None:
                change = next((m for m in element.modifications if m.path == ("start",)), None)
            if change is None:
                fail("N112", f"{name} has no value", span,
                     label="its value decides the structure of the model",
                     help=f"give it one: {name} = ..., or write {name}(…) "
                     "where it is used")  # fmt: skip
            value = elaborate(change.value, self.scope(change.owner))
            span = change.span
        if kind.base == "String":
            if value.text is None:
                fail("T101", f"{name} needs a text", span, help='write it in quotes: "text"')
            return string(value.text)
        numbers = constants(value) if value.fields is None and value.text is None else None
        if numbers is None:
            fail("T103", f"{name} must be known before the simulation", span,
                 label="this depends on something that can change",
                 help="use Integer or Boolean parameters and constants here")  # fmt: skip
        if kind.base == "Integer" and (numbers != np.round(numbers)).any():
            fail("T115", f"{name} must be an Integer", span, help="give it a whole number")
        if (kind.base == "Boolean") != (value.type == "Boolean"):
            fail("T102", f"{name} is declared {kind.base}, its value is {value.type}", span,
                 help="give it a value of its type")  # fmt: skip
        shape = self._shape(element, kind, numbers.shape)
        if numbers.shape != shape:
            if numbers.shape == ():
                fail("T104", f"{name} needs an array of size {list(shape)}", span,
                     help=f"write fill(value, {', '.join(map(str, shape))})")  # fmt: skip
            fail("T104", f"{name} has size {list(shape)}, its value {list(numbers.shape)}", span,
                 help="make both the same size")  # fmt: skip
        unit: UnitOf = value.unit
        text = self._unit(element, kind)
        if text:
            unit = parse_unit(text).dimension
        if not numbers.shape:
            return scalar(const(float(numbers)), kind.base, unit, kind.enumeration)
        result = listed([const(float(x)) for x in numbers.ravel()], numbers.shape, kind.base, unit)
        return replace(result, enumeration=kind.enumeration)

    def _shape(
        self,
        element: Element,
        kind: PrimitiveType | None,
        known: tuple[int, ...] | None = None,
    ) -> tuple[int, ...]:
        dimensions = [(d, element.owner) for d in element.declaration.dimensions]
        if kind is not None:
            dimensions += list(kind.dimensions)
        result: list[int] = []
        for k, (expression, owner) in enumerate(dimensions):
            if isinstance(expression, tree.Colon):
                if known is None:
                    known = self._bound_shape(element)
                if len(known) <= k:
                    fail("T125", f"the size of {element.name} is not known", expression.span,
                         help="give it a size")  # fmt: skip
                result.append(known[k])
                continue
            literals = _literals(expression, owner)
            if literals:
                result.append(literals)
                continue
            size = constant_number(expression, self.scope(owner), f"the size of {element.name}")
            if size != int(size) or size < 0:
                fail("T122", f"the size of {element.name} is {size:g}", expression.span,
                     help="use a whole number, 0 or more")  # fmt: skip
            result.append(int(size))
        return tuple(result)

    def _bound_shape(self, element: Element) -> tuple[int, ...]:
        change = next((m for m in element.modifications if not m.path), None)
        return elaborate(change.value, self.scope(change.owner)).shape if change else ()

    def _unit(self, element: Element, kind: PrimitiveType) -> str:
        for change in (*element.modifications, *kind.modifications):
            if change.path != ("unit",):
                continue
            value = elaborate(change.value, self.scope(change.owner))
            text = value.text or ""
            if text:
                try:
                    parse_unit(text)
                except UnitError as error:
                    fail("U104", f"{text} is not a unit", change.span, notes=[str(error)],
                         help=f"write {error.suggestions[0]}" if error.suggestions
                         else "units are written as in N.m/rad, m/s2, kOhm")  # fmt: skip
            return text
        return ""

    # --- references --------------------------------------------------------------------

    def reference(self, reference: tree.Reference, env: ClassEnvironment) -> Value:
        """Return the value of a reference that starts at an element of this class."""
        return follow(self, reference, env)


def record_leaves(definition: ClassDef) -> list[Path]:
    """Return the paths of the variables of a record; parameters and other classes have none."""
    if definition.kind != "record":
        return []
    result: list[Path] = []
    for name, element in merge(definition).elements.items():
        if element.has("parameter") or element.has("constant"):
            continue
        found = type_of(element)
        if primitive_type(found) is not None:
            result.append((name,))
        elif isinstance(found, ClassDef):
            result += [(name, *leaf) for leaf in record_leaves(found)]
    return result


def _literals(dimension: tree.Expression, owner: ClassDef) -> int:
    """Return the number of literals if an array dimension is an enumeration, else 0."""
    if not isinstance(dimension, tree.Reference):
        return 0
    found = find_name(owner, dimension)
    if not isinstance(found, ClassDef):
        return 0
    kind = primitive_type(found)
    enumeration = kind.enumeration if kind is not None else None
    return len(literals_of(enumeration))


def literals_of(enumeration: ClassDef | None) -> tuple[str, ...]:
    """Return the names of an enumeration's values."""
    return () if enumeration is None else tuple(n for n, _ in enumeration.tree.enumeration or ())


def _component(value: Value, index: Index) -> Value:
    rest = value.shape[len(index) :]
    if not rest:
        return scalar(value.get(index), value.type, value.unit, value.enumeration)
    return Value(value.type, rest, lambda i: value.get((*index, *i)), value.unit)


def constant_of_class(found: Constant, depth: int) -> Value:
    """Return the value of a constant of a package or class.

    Raises:
        AcausalError: ``N112`` if it has none, ``N117`` if it depends on itself.
    """
    merged = merge(found.owner)
    element = merged.elements[found.declaration.name]
    if depth > 50:
        fail("N117", f"{element.name} depends on itself", element.declaration.span,
             help="give it a value of its own")  # fmt: skip
    builder = TemplateBuilder(Elaborator(), found.owner, Environment())
    kind = primitive_type(type_of(element))
    if kind is None:
        whole = next((m for m in element.modifications if not m.path), None)
        if whole is None:
            fail("N112", f"{element.name} has no value", element.declaration.span,
                 help="give it one")  # fmt: skip
        return elaborate(whole.value, ClassEnvironment(builder, whole.owner, None, depth + 1))
    builder.declare(element.name)
    if element.name not in builder.template.structural:
        fail("N112", f"{element.name} is not a constant", element.declaration.span,
             help="declare it constant")  # fmt: skip
    return builder.template.structural[element.name]
