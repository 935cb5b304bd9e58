"""Balance of a class: as many equations as unknowns (Modelica 3.6, section 4.7).

A class must bring an equation for each of its own variables, for each variable of its cuts that
is neither through nor an input, counted as: variables - through variables of its cuts - inputs. Its
components are balanced themselves; what flows through their cuts is settled by junctions.
"""

from __future__ import annotations

from acausal.diagnostics import Label, fail
from acausal.instantiation.connects import cut_leaves
from acausal.instantiation.overdetermined import excess_rows
from acausal.instantiation.template import Template


def _record_rows(record: Template) -> int:
    """Return the number of equations that a record brings: values of its own fields."""
    own = sum(e.domain.length for e in record.equations) + _discrete_rows(record)
    return own + sum(
        child.size * _record_rows(child.template) for child in record.children.values()
    )


def _discrete_rows(template: Template) -> int:
    """Return the number of equations of variables that only change at events.

    A target that is assigned twice counts once; that has a message of its own.
    """
    targets = {(d.target, d.domain.values.tobytes()): d.domain.length for d in template.discrete}
    return sum(targets.values())


def _inputs(cut: Template) -> int:
    """Return the number of inputs in a cut, which get their values from outside."""
    own = sum(v.size for v in cut.variables.values() if v.causality == "input")
    return own + sum(child.size * _inputs(child.template) for child in cut.children.values())


def check_class(template: Template) -> None:
    """Refuse a class without components whose equations and unknowns differ in number.

    Classes with components are judged with their connections, when the whole system is known.

    Raises:
        AcausalError: ``B101`` for too few, ``B102`` for too many equations.
    """
    if template.is_connector or template.definition.kind in ("record", "package"):
        return
    if any(not c.template.is_connector and c.template.definition.kind != "record"
           for c in template.children.values()):  # fmt: skip
        return
    if template.connects or template.outers or template.outer_values:
        return
    unknowns = sum(v.size for v in template.variables.values() if v.causality != "input")
    rows = sum(e.domain.length for e in template.equations) + _discrete_rows(template)
    for path in template.bound:
        own_variable = template.variables.get(path[0]) if len(path) == 1 else None
        if own_variable is not None and own_variable.causality != "input":
            rows += own_variable.size
    inside = 0
    for child in template.children.values():
        if child.template.definition.kind == "record":
            leaves = cut_leaves(child.template)
            inside += child.size * sum(size for _, size, _, _ in leaves)
            own = sum(size for path, size, _, _ in leaves if (child.name, *path) in template.bound)
            rows += child.size * (own + _record_rows(child.template))
            continue
        if child.template.primitive_connector:
            given = child.template.variables[""].causality == "input"
            inside += 0 if given else child.size
            if not given and (child.name,) in template.bound:
                rows += child.size
            continue
        leaves = cut_leaves(child.template)
        across = sum(size for _, size, through, _ in leaves if not through)
        inside += child.size * (across - _inputs(child.template))
    inside += excess_rows(template)
    wanted = unknowns + inside
    if rows == wanted:
        return
    names = ", ".join(v.name for v in template.variables.values() if v.causality != "input")
    cuts = ", ".join(c.name for c in template.children.values() if c.template.is_connector)
    notes = [
        f"{unknowns} own variables" + (f" ({names})" if names else ""),
        f"{inside} from its cuts" + (f" ({cuts}: a through variable each is settled outside)"
                                     if cuts else ""),
    ]  # fmt: skip
    labels = [Label(e.span, e.text) for e in template.equations[:6]]
    labels += [Label(d.span, d.text) for d in template.discrete[: 6 - len(labels)]]
    few = rows < wanted
    fail(
        "B101" if few else "B102",
        f"{template.name} has {rows} equations for {wanted} unknowns",
        template.definition.span,
        label=f"{abs(rows - wanted)} too {'few' if few else 'many'}",
        labels=labels if not few else (),
        notes=notes,
        help="add the missing equation" if few else "remove an equation, or declare a variable",
    )
