"""Stage instantiate: the tree of component families with what was set in them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from acausal.flattening.flatten import Flattened
from acausal.inspection.lists import SHOWN, counted, quantity
from acausal.instantiation.merge import merge
from acausal.instantiation.numbering import Ids, Numbering
from acausal.instantiation.template import Child, Template
from acausal.instantiation.values import Value, constants


def show_instantiate(flattened: Flattened) -> list[str]:
    """Return the component tree: a line for every declared component, array or not."""
    numbering = flattened.numbering
    values = flattened.model.parameters
    used = sum(g.count > 0 for g in numbering.groups)
    root = numbering.groups[-1].template
    lines = [f"{counted(used, 'class', 'classes')} in use", "", root.name]
    lines += _settings(root, np.zeros(1, np.int64), numbering, values, "  ")
    # Depth first: template, numbers of its instances, indentation, component not yet shown.
    stack: list[tuple[Template, Ids, str, int]] = [(root, np.zeros(1, np.int64), "  ", 0)]
    while stack:
        template, here, indent, place = stack.pop()
        children = [c for c in template.children.values() if not c.template.is_connector]
        if place >= len(children):
            continue
        if place == SHOWN:
            lines.append(f"{indent}... {len(children) - SHOWN} more components")
            continue
        stack.append((template, here, indent, place + 1))
        child = children[place]
        inside = _instances(numbering, template, child, here)
        lines.append(indent + _headline(child, len(inside)))
        if len(inside):
            lines += _settings(child.template, inside, numbering, values, indent + "    ")
            stack.append((child.template, inside, indent + "  ", 0))
    return lines


def _instances(numbering: Numbering, owner: Template, child: Child, here: Ids) -> Ids:
    first = numbering.first_of(owner, child.name)
    return (first + here[:, None] * child.size + np.arange(child.size)).reshape(-1)


def _headline(child: Child, count: int) -> str:
    shape = f"[{','.join(map(str, child.shape))}]" if child.shape else ""
    inner = "inner " if child.inner else ""
    total = f"  ({count} in all)" if count > max(child.size, 1) else ""
    about = f'  "{child.description}"' if child.description else ""
    return f"{child.name}{shape}: {inner}{child.template.name}{total}{about}"


def _settings(
    template: Template,
    instances: Ids,
    numbering: Numbering,
    values: NDArray[np.float64],
    indent: str,
) -> list[str]:
    """Return lines for structural parameters, parameters, variables and cuts of a class."""
    own: list[str] = []
    elements = merge(template.definition).elements
    for name, value in template.structural.items():
        if name in elements and not elements[name].has("constant"):
            own.append(f"{name} = {_structural(value)}")
    for name, declaration in template.parameters.items():
        if not declaration.size:
            continue
        first = numbering.first_parameter(template, name)
        ids = first + instances[:, None] * declaration.size + np.arange(declaration.size)
        shape = f"[{','.join(map(str, declaration.shape))}]" if declaration.shape else ""
        own.append(f"{name}{shape} = {quantity(values[ids], declaration.unit)}")
    lines = _wrapped(own, indent)
    cuts: dict[str, list[str]] = {}
    for child in template.children.values():
        if child.template.is_connector:
            shape = f"[{','.join(map(str, child.shape))}]" if child.shape else ""
            cuts.setdefault(_type_name(child), []).append(child.name + shape)
    if cuts:
        said = "; ".join(f"{', '.join(names)}: {kind}" for kind, names in cuts.items())
        lines.append(f"{indent}cuts {said}")
    if template.absent:
        lines.append(f"{indent}switched off: {', '.join(sorted(template.absent))}")
    return lines


def _type_name(child: Child) -> str:
    template = child.template
    return template.variables[""].type_name if template.primitive_connector else template.name


def _wrapped(items: list[str], indent: str) -> list[str]:
    lines: list[str] = []
    line = ""
    for k, item in enumerate(items):
        piece = item + ("," if k + 1 < len(items) else "")
        if line and len(indent) + len(line) + len(piece) > 98:
            lines.append(indent + line)
            line = piece
        else:
            line = f"{line} {piece}".strip()
    return [*lines, indent + line] if line else lines


def _structural(value: Value) -> str:
    if value.text is not None:
        return f'"{value.text}"'
    if value.fields is not None:
        return "(" + ", ".join(f"{n} = {_structural(v)}" for n, v in value.fields.items()) + ")"
    numbers = constants(value)
    if numbers is None:
        return "?"
    if value.enumeration is not None and not numbers.shape:
        literals = value.enumeration.tree.enumeration or ()
        return f"{value.enumeration.name}.{literals[int(numbers) - 1][0]}"
    if value.type == "Boolean" and not numbers.shape:
        return "true" if numbers else "false"
    if not numbers.shape:
        return f"{float(numbers):.10g}"
    if numbers.size <= 12:
        return str(numbers.tolist()).replace(".0", "").replace("[", "{").replace("]", "}")
    return f"an array of size {list(numbers.shape)}"
