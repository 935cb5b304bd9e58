"""From a class definition to all class templates of a model."""

from __future__ import annotations

from acausal.diagnostics import fail
from acausal.expressions.nodes import const
from acausal.instantiation.elaborate import Elaborator, Environment
from acausal.instantiation.merge import merge, primitive_type, type_of
from acausal.instantiation.template import Template
from acausal.instantiation.values import Value, scalar
from acausal.modeling.classes import ClassDef

#: Passed on the command line or from Python: a number, true/false or a text.
Given = dict[str, float]


def instantiate(
    definition: ClassDef,
    given: Given | None = None,
    answers: dict[tuple[str, ...], bool] | None = None,
) -> tuple[list[Template], Given]:
    """Elaborate a model.

    Args:
        definition: The model.
        given: Parameter values by path; those of structural parameters are used here.
        answers: What classes ask about overdetermined records, by path of the instance and
            question; see :func:`acausal.connections.spanning.instantiate_rooted`.

    Returns:
        All templates, components before their owners, the model last; and the given values
        that are left for the flat model.

    Raises:
        AcausalError: For mistakes in any class that the model uses.
    """
    values: dict[tuple[str, ...], Value] = {}
    left: Given = {}
    for path, number in (given or {}).items():
        parts = tuple(path.split("."))
        kind = _structural_kind(definition, parts)
        if kind is None:
            left[path] = number
            continue
        if kind == "Integer" and number != round(number):
            fail("T115", f"{path} must be an Integer, not {number:g}", help="give a whole number")
        values[parts] = scalar(const(float(number)), kind)
    for question, holds in (answers or {}).items():
        values[question] = scalar(const(float(holds)), "Boolean")
    elaborator = Elaborator()
    elaborator.template(definition, Environment(values))
    return elaborator.templates, left


def _structural_kind(definition: ClassDef, parts: tuple[str, ...]) -> str | None:
    """Return the type of a structural scalar parameter, None for anything else."""
    where = definition
    for k, name in enumerate(parts):
        element = merge(where).elements.get(name)
        if element is None:
            return None
        found = type_of(element)
        kind = primitive_type(found)
        if kind is None:
            assert isinstance(found, ClassDef)
            where = found
            continue
        if k + 1 == len(parts) and element.has("parameter") and kind.base in ("Integer", "Boolean"):
            return kind.base
        return None
    return None
