"""Component references: from a dotted name down the tree of components to a value."""

from __future__ import annotations

from typing import TYPE_CHECKING

from acausal.diagnostics import fail
from acausal.diagnostics.suggest import nearest
from acausal.expressions.nodes import Expr, slot
from acausal.instantiation.selection import chosen
from acausal.instantiation.subscripts import axis
from acausal.instantiation.template import Ref, Step, Template, VariableDecl
from acausal.instantiation.values import LITERAL, Index, UnitOf, Value, number
from acausal.syntax import tree
from acausal.units.unit import parse_unit

if TYPE_CHECKING:
    from acausal.instantiation.elaborate import TemplateBuilder
    from acausal.instantiation.expressions import Environment


def unit_of(declaration: VariableDecl) -> UnitOf:
    """Return the dimension of a variable; None without a unit or with an offset or factor."""
    if not declaration.unit:
        return None
    unit = parse_unit(declaration.unit)
    return unit.dimension if unit.factor == 1.0 and not unit.offset else None


def follow(builder: TemplateBuilder, reference: tree.Reference, env: Environment) -> Value:
    """Walk down a component reference.

    Raises:
        AcausalError: ``N102`` for an unknown part, ``N113`` for a component used as a value,
            ``N114`` for one that is switched off.
    """
    first = reference.parts[0]
    builder.declare(first.name)
    template = builder.template
    steps: list[tuple[str, list[Value]]] = []
    outer = ""
    if first.name in template.outer_values:
        return _outer_value(builder, reference, env)
    for k, part in enumerate(reference.parts):
        name = part.name
        if k == 0 and name in template.outers and name not in template.children:
            outer, template = name, template.outers[name]
            continue
        if name in template.absent:
            fail("N114", f"{reference} does not exist here", part.span,
                 label=f"{name} is a conditional component and switched off",
                 help="set the parameter that switches it on, or do not use it")  # fmt: skip
        if name in template.children:
            child = template.children[name]
            axes = _axes(part, child.shape, env)
            steps.append((name, axes))
            template = child.template
            continue
        declaration = template.variables.get(name) or template.parameters.get(name)
        if declaration is not None:
            axes = _axes(part, declaration.shape, env)
            _no_more(reference, k, name)
            return _leaf(builder, template, declaration, steps, axes, outer)
        if name in template.structural:
            _no_more(reference, k, name)
            value = template.structural[name]
            own = _selected(value, _axes(part, value.shape, env))
            return _broadcast(own, [a for _, step in steps for a in step])
        _unknown_part(reference, k, template)
    if template.primitive_connector:
        return _leaf(builder, template, template.variables[""], steps, [], outer)
    if template.definition.kind in ("record", "connector") or outer or steps:
        return _record(builder, template, steps, outer, reference)
    raise AssertionError(reference)


def component_shape(
    builder: TemplateBuilder, reference: tree.Reference, env: Environment
) -> tuple[int, ...] | None:
    """Return the array dimensions of a component with equations of its own; None for a value."""
    builder.declare(reference.parts[0].name)
    template = builder.template
    shape: tuple[int, ...] = ()
    for part in reference.parts:
        child = template.children.get(part.name)
        if child is None:
            return None
        shape += tuple(a.size for a in _axes(part, child.shape, env) if a.shape)
        template = child.template
    if template.primitive_connector or template.definition.kind == "record":
        return None
    return shape


def _outer_value(builder: TemplateBuilder, reference: tree.Reference, env: Environment) -> Value:
    """Return an ``outer`` variable, parameter or constant."""
    part = reference.parts[0]
    owner = builder.template.outer_values[part.name]
    _no_more(reference, 0, part.name)
    if part.name in owner.structural:
        value = owner.structural[part.name]
        return _selected(value, _axes(part, value.shape, env))
    declaration = owner.variables.get(part.name) or owner.parameters[part.name]
    axes = _axes(part, declaration.shape, env)
    return _leaf(builder, owner, declaration, [], axes, part.name)


def _axes(part: tree.NamePart, shape: tuple[int, ...], env: Environment) -> list[Value]:
    if len(part.subscripts) > len(shape):
        what = "is not an array" if not shape else f"has {len(shape)} dimensions"
        fail("T113", f"{part.name} {what}", part.span,
             help="remove the subscript" if not shape else "use fewer subscripts")  # fmt: skip
    subscripts = (*part.subscripts, *[None] * (len(shape) - len(part.subscripts)))
    return [axis(s, n, env) for s, n in zip(subscripts, shape, strict=True)]


def _no_more(reference: tree.Reference, k: int, name: str) -> None:
    if k + 1 < len(reference.parts):
        fail("N102", f"{name} is a number and has no parts", reference.parts[k + 1].span,
             help=f"remove .{reference.parts[k + 1].name}")  # fmt: skip


def _unknown_part(reference: tree.Reference, k: int, template: Template) -> None:
    name = reference.parts[k].name
    known = [*template.variables, *template.parameters, *template.children, *template.structural]
    close = nearest(name, known)
    fail(
        "N102",
        f"{template.name} has nothing called {name}",
        reference.parts[k].span,
        label="this name is not declared there",
        notes=[f"did you mean {' or '.join(close)}?"] if close else [],
        help=f"write {close[0]}, if that is what you mean"
        if close
        else f"acausal list {template.name} shows what it has",
    )


def _leaf(
    builder: TemplateBuilder,
    template: Template,
    declaration: VariableDecl,
    steps: list[tuple[str, list[Value]]],
    axes: list[Value],
    outer: str,
) -> Value:
    every = [a for _, step in steps for a in step] + axes
    shape = tuple(a.size for a in every if a.shape)
    dimensions = _dimensions(builder.template, steps, outer)
    parameter = (
        declaration.name in template.parameters
        and template.parameters[declaration.name] is declaration
    )

    sizes = (*(n for own in dimensions for n in own), *declaration.shape)

    def element(index: Index) -> Expr:
        free = iter(index)
        path = tuple(Step(name, tuple(next(free) for _ in step)) for name, step in steps)
        return slot(Ref(path, declaration.name, tuple(free), parameter, 0, outer))

    def get(index: Index) -> Expr:
        free = iter(index)
        full = tuple(a.get((next(free),)) if a.shape else a.expr for a in every)
        return chosen(element, full, sizes)

    unit = unit_of(declaration)
    if declaration.base == "Integer" and unit is None:
        unit = LITERAL
    enumeration = template.enumerations.get(declaration.name)
    return Value(declaration.base, shape, get, unit, enumeration=enumeration)


def declaration_of(template: Template, ref: Ref) -> VariableDecl:
    """Return the declaration that a reference inside a class leads to."""
    if ref.outer:
        inner = template.outers.get(ref.outer)
        template = template.outer_values[ref.outer] if inner is None else inner
    for step in ref.path:
        template = template.children[step.name].template
    return (template.parameters if ref.parameter else template.variables)[ref.name]


def _dimensions(
    template: Template, steps: list[tuple[str, list[Value]]], outer: str
) -> list[tuple[int, ...]]:
    """Return the array dimensions of the components on a path."""
    if outer:
        inner = template.outers.get(outer)
        template = template.outer_values[outer] if inner is None else inner
    result: list[tuple[int, ...]] = []
    for name, _ in steps:
        child = template.children[name]
        result.append(child.shape)
        template = child.template
    return result


def _selected(value: Value, axes: list[Value]) -> Value:
    if not axes or all(a.shape and a.size == n for a, n in zip(axes, value.shape, strict=True)):
        return value
    shape = tuple(a.size for a in axes if a.shape)

    def get(index: Index) -> Expr:
        free = iter(index)
        full = tuple(a.get((next(free),)) if a.shape else a.expr for a in axes)
        return chosen(value.get, full, value.shape)

    return Value(value.type, shape, get, value.unit, value.text, None, value.enumeration)


def _broadcast(value: Value, axes: list[Value]) -> Value:
    outer = tuple(a.size for a in axes if a.shape)
    if not outer:
        return value
    n = len(outer)
    return Value(
        value.type, (*outer, *value.shape), lambda i: value.get(i[n:]), value.unit, value.text,
        None, value.enumeration,
    )  # fmt: skip


def _record(
    builder: TemplateBuilder,
    template: Template,
    steps: list[tuple[str, list[Value]]],
    outer: str,
    reference: tree.Reference,
) -> Value:
    if template.definition.kind not in ("record", "connector"):
        fail("N113", f"{reference} is a component, not a value", reference.span,
             label=f"a {template.name}",
             help="name one of its variables")  # fmt: skip
    fields: dict[str, Value] = {}
    for name, declaration in {**template.variables, **template.parameters}.items():
        axes = [Value("Integer", (n,), lambda i: i[0]) for n in declaration.shape]
        fields[name] = _leaf(builder, template, declaration, steps, axes, outer)
    every = [a for _, step in steps for a in step]
    for name, value in template.structural.items():
        fields[name] = _broadcast(value, every)
    for name, child in template.children.items():
        own = [Value("Integer", (n,), lambda i: i[0]) for n in child.shape]
        below = [*steps, (name, own)]
        if child.template.primitive_connector:
            inside = child.template.variables[""]
            fields[name] = _leaf(builder, child.template, inside, below, [], outer)
        else:
            fields[name] = _record(builder, child.template, below, outer, reference)
    return Value("record", (), lambda _: number(0.0).expr, None, None, fields)
