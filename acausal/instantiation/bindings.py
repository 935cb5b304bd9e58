"""Modifications become bindings of parameters and attributes, and declaration equations."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from acausal.diagnostics import AcausalError, Label, fail
from acausal.expressions import build
from acausal.expressions.nodes import Expr, const, slot
from acausal.expressions.traverse import slots
from acausal.instantiation.arrays import shape_text
from acausal.instantiation.domain import split_by_indices
from acausal.instantiation.environment import ClassEnvironment
from acausal.instantiation.event_operators import lone
from acausal.instantiation.expressions import elaborate
from acausal.instantiation.merge import Element, Modification, PrimitiveType
from acausal.instantiation.template import (
    BindingDecl,
    Child,
    DiscreteDecl,
    Domain,
    EquationDecl,
    LoopIndex,
    Ref,
    Signal,
    Step,
    Template,
    VariableDecl,
)
from acausal.instantiation.unit_algebra import added
from acausal.instantiation.values import Index, NeedsUnroll, UnitOf, Value, indices
from acausal.syntax import tree
from acausal.syntax.formatter import format_expression
from acausal.units.unit import parse_unit

if TYPE_CHECKING:
    from acausal.instantiation.elaborate import TemplateBuilder
    from acausal.modeling.classes import ClassDef

_NUMERIC = ("start", "fixed", "min", "max", "nominal", "stateSelect")
_WITHOUT_UNIT = ("fixed", "stateSelect")
_EVERYWHERE = Domain()


def bind_value(builder: TemplateBuilder, element: Element, kind: PrimitiveType) -> None:
    """Bind a parameter, or add the declaration equation of a variable."""
    template, name = builder.template, element.name
    change = next((m for m in element.modifications if not m.path), None)
    if change is None:
        return
    declaration = template.parameters.get(name) or template.variables[name]
    if name in template.variables and (name,) in builder.environment.bound:
        return
    try:
        value = elaborate(change.value, builder.scope(change.owner))
        _set(builder, [], declaration, "value", value, change, f"{name} = ")
    except AcausalError as error:
        if name in template.variables or error.diagnostics[0].code != "T104":
            raise
        # A default for another size does no harm where every instance has a value of its own.
        template.unfit_defaults[name] = error


def bind_attributes(builder: TemplateBuilder, element: Element, kind: PrimitiveType) -> None:
    """Bind start, fixed, ... of a variable or parameter declared in the class itself."""
    template, name = builder.template, element.name
    declaration = template.parameters.get(name) or template.variables[name]
    _attributes(builder, [], declaration, element, kind)


def _attributes(
    builder: TemplateBuilder,
    steps: list[tuple[str, tuple[int, ...]]],
    declaration: VariableDecl,
    element: Element,
    kind: PrimitiveType,
) -> None:
    seen: set[str] = set()
    for weak, changes in ((False, element.modifications), (True, kind.modifications)):
        for change in changes:
            if len(change.path) != 1 or change.path[0] in seen:
                continue
            attribute = change.path[0]
            if attribute not in (*_NUMERIC, "unit", "quantity", "displayUnit"):
                fail("N103", f"{element.name} has no attribute {attribute}", change.span,
                     help=f"a variable has {', '.join(_NUMERIC)}")  # fmt: skip
            seen.add(attribute)
            if attribute not in _NUMERIC:
                continue
            env = ClassEnvironment(None, change.owner) if weak else builder.scope(change.owner)
            value = elaborate(change.value, env)
            if weak and not value.shape:
                value = _repeated(value, declaration.shape)
            _set(builder, steps, declaration, attribute, value, change, "", weak)


def _repeated(value: Value, shape: tuple[int, ...]) -> Value:
    if not shape:
        return value
    return Value(value.type, shape, lambda _: value.expr, value.unit,
                 enumeration=value.enumeration)  # fmt: skip


def bind_child(builder: TemplateBuilder, element: Element, child: Child) -> None:
    """Bind what the modifications of a component set inside it; the outermost come first."""
    done: set[tuple[str, ...]] = set()
    for change in element.modifications:
        if change.path not in done:
            done.add(change.path)
            if () in done or not _bind_number(builder, child, change):
                _bind_path(builder, child, change, done)
    kind = builder.kinds[element.name]
    if kind is not None:  # a primitive connector: the attributes of its type
        inside = child.template.variables[""]
        steps = [(child.name, child.shape)]
        for change in kind.modifications:
            if len(change.path) == 1 and change.path[0] in _NUMERIC:
                value = elaborate(change.value, ClassEnvironment(None, change.owner))
                value = _repeated(value, child.shape) if not value.shape else value
                _set(builder, steps, inside, change.path[0], value, change, "", True)


def _bind_number(builder: TemplateBuilder, child: Child, change: Modification) -> bool:
    """Bind a bare number to a parameter or attribute, as models made by programs have in masses.

    Only where another component of the same template was given one in the usual way before: then
    everything has been checked. Returns False if this is not such a case.
    """
    value = change.value
    if type(value) is tree.NumberLiteral:
        if value.unit is not None:
            return False
        expression = const(value.value)
    elif type(value) is tree.BooleanLiteral:
        expression = const(float(value.value))
    else:
        return False
    found = builder.usual_targets.get((child.template.number, change.path, type(value)))
    if found is None or child.shape:
        return False
    name, attribute, parameter = found
    builder.template.bindings.append(
        BindingDecl(
            Ref((Step(child.name),), name, (), parameter), attribute, expression, _EVERYWHERE,
            change.span, False,
        )
    )  # fmt: skip
    return True


def _bind_path(
    builder: TemplateBuilder, child: Child, change: Modification, done: set[tuple[str, ...]]
) -> None:
    steps = [(child.name, child.shape)]
    template: Template = child.template
    declaration: VariableDecl | None = None
    rest: tuple[str, ...] = change.path
    while rest:
        name = rest[0]
        if name in template.absent or name in template.structural:
            return
        if template.primitive_connector:
            break
        if name in template.children:
            inside = template.children[name]
            steps.append((name, inside.shape))
            template, rest = inside.template, rest[1:]
            continue
        declaration = template.variables.get(name) or template.parameters.get(name)
        if declaration is None:  # an outer component of the component: not to be modified
            fail("N103", f"{'.'.join(change.path)} cannot be modified here", change.span,
                 help="modify it where it is declared inner")  # fmt: skip
        rest = rest[1:]
        break
    if declaration is None and template.primitive_connector:
        declaration = template.variables[""]
    attribute = rest[0] if rest else "value"
    if declaration is not None and attribute in ("unit", "quantity", "displayUnit"):
        return
    value = elaborate(change.value, builder.scope(change.owner))
    if declaration is None:
        _bind_record(builder, steps, template, value, change, done)
        return
    text = ".".join((child.name, *change.path)) + " = "
    is_variable = declaration.name in template.variables
    if attribute == "value":
        if is_variable and (child.name, *change.path) in builder.environment.bound:
            return
        if len(done) > 1 and any(change.path[:k] in done for k in range(len(change.path))):
            return  # the record it is a field of is set from further outside
    _set(builder, steps, declaration, attribute, value, change, text,
         parameter=not is_variable)  # fmt: skip


def _bind_record(
    builder: TemplateBuilder,
    steps: list[tuple[str, tuple[int, ...]]],
    template: Template,
    value: Value,
    change: Modification,
    done: set[tuple[str, ...]],
) -> None:
    if value.fields is None:
        fail("T130", f"{steps[-1][0]} is a {template.definition.kind} and has no single value",
             change.span, help="modify one of its variables, or give a record")  # fmt: skip
    for name, part in value.fields.items():
        if name in template.structural or name in template.absent:
            continue
        if name in template.children:
            inside = template.children[name]
            below = [*steps, (name, inside.shape)]
            _bind_record(builder, below, inside.template, part, change, done)
            continue
        declaration = template.variables.get(name) or template.parameters.get(name)
        if declaration is None:
            fail("T130", f"{template.name} has no field {name}", change.span,
                 help=f"its fields are {', '.join(template.parameters)}")  # fmt: skip
        path = (*(step for step, _ in steps), name)
        if path in builder.environment.bound or path[1:] in done:
            continue
        _set(builder, steps, declaration, "value", part, change, f"{steps[-1][0]}.{name} = ",
             parameter=name in template.parameters)  # fmt: skip


def _enumeration(
    template: Template, steps: list[tuple[str, tuple[int, ...]]], declaration: VariableDecl
) -> ClassDef | None:
    for name, _ in steps:
        template = template.children[name].template
    return template.enumerations.get(declaration.name)


def _set(
    builder: TemplateBuilder,
    steps: list[tuple[str, tuple[int, ...]]],
    declaration: VariableDecl,
    attribute: str,
    value: Value,
    change: Modification,
    text: str,
    weak: bool = False,
    parameter: bool | None = None,
) -> None:
    """Add a binding (parameters, attributes) or an equation (values of variables)."""
    template = builder.template
    if parameter is None:
        parameter = not steps and declaration.name in template.parameters
    full = tuple([n for _, shape in steps for n in shape]) + declaration.shape
    _check_type(value, declaration, attribute, change, _enumeration(template, steps, declaration))
    if not full and not value.shape and (attribute != "value" or parameter):
        # A number for a scalar, as circuits made by programs have in masses.
        unit_free = isinstance(value.unit, str) or attribute in _WITHOUT_UNIT
        expression = value.expr
        if unit_free and expression.op == "const" and value.text is None:
            if len(steps) == 1 and declaration.base == "Real" and declaration.name:
                # An integer literal fits every Real, other types of literals their like.
                inside = template.children[steps[0][0]].template.number
                key = (inside, change.path, type(change.value))
                usual = (declaration.name, attribute, parameter)
                builder.usual_targets.setdefault(key, usual)
            path = tuple([Step(n) for n, _ in steps])
            target = Ref(path, declaration.name, (), parameter)
            template.bindings.append(
                BindingDecl(target, attribute, expression, _EVERYWHERE, change.span, weak)
            )
            return
    value = _fitting(value, full, declaration, attribute, change)
    if attribute not in _WITHOUT_UNIT:
        unit: UnitOf = None
        if declaration.unit:
            parsed = parse_unit(declaration.unit)
            unit = parsed.dimension if parsed.factor == 1.0 and not parsed.offset else None
        what = f"{attribute} of {declaration.name or steps[-1][0]} is given"
        if attribute == "value":
            what = f"{declaration.name or steps[-1][0]} is given"
        added(value.unit, unit, what.replace("is given", "is a quantity in two units:"), "U102",
              change.span, change.span, declaration.span)  # fmt: skip

    def emit(index: Index, domain: Domain) -> None:
        free = iter(index)
        path = tuple(Step(n, tuple(next(free) for _ in shape)) for n, shape in steps)
        ref = Ref(path, declaration.name, tuple(free), parameter)
        said = ""
        if attribute == "value" and not parameter:
            said = text + format_expression(change.value)
        for part, expression in split_by_indices(domain, value.get(index)):
            if attribute != "value" or parameter:
                _no_events(expression, declaration, attribute, change)
                template.bindings.append(
                    BindingDecl(ref, attribute, expression, part, change.span, weak)
                )
                continue
            target, owner = slot(ref), change.owner.full_name
            if declaration.base != "Real":
                both = lone(expression) is not None
                template.discrete.append(
                    DiscreteDecl(target, expression, part, change.span, said, owner, symmetric=both)
                )
                continue
            residual = build.sub(target, expression)
            template.equations.append(EquationDecl(residual, part, change.span, said, owner))

    over_elements(full, emit)


def _no_events(
    expression: Expr, declaration: VariableDecl, attribute: str, change: Modification
) -> None:
    for payload in slots(expression):
        if isinstance(payload, Signal) or (isinstance(payload, Ref) and payload.pre):
            what = (
                declaration.name if attribute == "value" else f"{attribute} of {declaration.name}"
            )
            fail("T134", f"{what} cannot depend on what happens at events", change.span,
                 help="use parameters and constants here, or declare a variable")  # fmt: skip


def over_elements(shape: tuple[int, ...], emit: object, domain: Domain | None = None) -> None:
    """Call ``emit(index, domain)`` once with loop indices, or for each element if need be."""
    assert callable(emit)
    outer = domain if domain is not None else Domain()
    if not shape:
        emit((), outer)
        return
    loops = outer
    names: list[Expr] = []
    for k, n in enumerate(shape):
        name = f"${len(outer.names) + k}"
        loops = loops.product(name, np.arange(1.0, n + 1.0))
        names.append(slot(LoopIndex(name)))
    try:
        emit(tuple(names), loops)
    except NeedsUnroll:
        for index in indices(shape):
            emit(index, outer)


def _fitting(
    value: Value,
    full: tuple[int, ...],
    declaration: VariableDecl,
    attribute: str,
    change: Modification,
) -> Value:
    if value.shape == full:
        return value
    missing = len(full) - len(value.shape)
    if missing < 0 or full[missing:] != value.shape:
        fail("T104", f"{declaration.name} has {shape_text(full)}, its {attribute} "
             f"{shape_text(value.shape)}", change.span,
             label="the sizes differ", labels=[Label(declaration.span, "declared here")],
             help="make both the same size")  # fmt: skip
    if not change.each:
        fail("T118", f"{declaration.name} has {shape_text(full)}, its {attribute} "
             f"{shape_text(value.shape)}", change.span,
             label="one value for many",
             help="write each in front of the modifier to give all the same value")  # fmt: skip
    return Value(value.type, full, lambda i: value.get(i[missing:]), value.unit,
                 enumeration=value.enumeration)  # fmt: skip


def _check_type(
    value: Value,
    declaration: VariableDecl,
    attribute: str,
    change: Modification,
    enumeration: ClassDef | None,
) -> None:
    base = declaration.base
    if value.text is None and value.fields is None:
        if attribute == "fixed":
            fits = value.type == "Boolean"
        elif base == "Boolean" or base == "enumeration":
            fits = value.type == base and value.enumeration is enumeration
        elif base == "Integer" and attribute == "value":
            fits = value.type == "Integer"
        else:
            fits = value.type in ("Real", "Integer")
        if fits:
            return
    wanted = "a Boolean" if attribute == "fixed" else "a number"
    if attribute != "fixed" and base != "Real":
        wanted = "an Integer" if base == "Integer" else f"a {base}"
        wanted = wanted if enumeration is None else f"one of {enumeration.name}"
    help_ = f"give {wanted}"
    if base == "Integer" and value.type == "Real":
        help_ = "write integer(...) to cut off the fraction"
    what = declaration.name if attribute == "value" else f"{attribute} of {declaration.name}"
    given = value.type if value.enumeration is None else value.enumeration.name
    fail("T101", f"{what} must be {wanted}, not {given}", change.span, help=help_)
