"""Connect equations: from names of cuts to references, arrays of cuts element by element."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from acausal.diagnostics import Label, Span, fail
from acausal.diagnostics.suggest import nearest
from acausal.instantiation.arrays import shape_text
from acausal.instantiation.bindings import over_elements
from acausal.instantiation.environment import ClassEnvironment
from acausal.instantiation.sinks import Sink
from acausal.instantiation.subscripts import axis
from acausal.instantiation.template import ConnectDecl, CutRef, Domain, Step, Template
from acausal.instantiation.values import Index, Value
from acausal.syntax import tree
from acausal.units.unit import parse_unit

if TYPE_CHECKING:
    from acausal.instantiation.elaborate import TemplateBuilder


@dataclass(frozen=True)
class Cut:
    """A cut or an array of cuts named in a connect equation."""

    steps: tuple[tuple[str, tuple[Value, ...]], ...]
    template: Template
    outer: str
    inner_face: bool
    shape: tuple[int, ...]
    span: Span

    def at(self, index: Index) -> CutRef:
        """Return one cut of the array."""
        free = iter(index)
        path = tuple(
            Step(n, tuple(a.get((next(free),)) if a.shape else a.expr for a in axes))
            for n, axes in self.steps
        )
        return CutRef(path, self.outer, self.inner_face)


def add_connect(
    equation: tree.ConnectEquation, domain: Domain, env: ClassEnvironment, sink: Sink
) -> None:
    """Add a connect equation.

    Raises:
        AcausalError: ``C1xx`` for what is no cut, and for cuts that do not fit.
    """
    if sink.initial:
        fail("C104", "connect does not belong into initial equations", equation.span,
             help="move it to the equation section")  # fmt: skip
    if env.builder is not None and _add_plain(equation, domain, env.builder, sink):
        return
    found = [cut_named(reference, env) for reference in equation.cuts]
    cuts = [c for c in found if c is not None]
    if len(cuts) < 2:
        return
    first = cuts[0]
    for other in cuts[1:]:
        if other.shape != first.shape:
            fail("C102", f"connecting {shape_text(first.shape)} with {shape_text(other.shape)}",
                 equation.span,
                 labels=[Label(first.span, shape_text(first.shape)),
                         Label(other.span, shape_text(other.shape))],
                 help="connect arrays of the same size, "
                 "or pick elements by subscripts")  # fmt: skip
        check_alike(first.template, other.template, equation.span, first.span, other.span)

    def emit(index: Index, domain_: Domain) -> None:
        sink.connects.append(ConnectDecl(tuple(c.at(index) for c in cuts), domain_, equation.span))

    over_elements(first.shape, emit, domain)


def _add_plain(
    equation: tree.ConnectEquation, domain: Domain, builder: TemplateBuilder, sink: Sink
) -> bool:
    """Add a connection of cuts without subscripts, as circuits made by programs have in masses.

    Returns:
        False if there is anything unusual about it; then nothing has been done.
    """
    cuts: list[CutRef] = []
    first: Template | None = None
    for reference in equation.cuts:
        template = builder.template
        steps: list[Step] = []
        for part in reference.parts:
            child = template.children.get(part.name)
            if child is None or part.subscripts or child.shape:
                return False
            if steps and template.is_connector:
                return False
            step = _steps.get(part.name)
            if step is None:
                step = _steps.setdefault(part.name, Step(part.name))
            steps.append(step)
            template = child.template
        if not template.is_connector:
            return False
        if first is None:
            first = template
        elif template is not first and template.number not in first.alike:
            return False
        cuts.append(CutRef(tuple(steps), "", len(steps) == 1))
    sink.connects.append(ConnectDecl(tuple(cuts), domain, equation.span))
    return True


#: Steps without subscripts, by name; cleared when there are very many.
_steps: dict[str, Step] = {}


def cut_named(reference: tree.Reference, env: ClassEnvironment) -> Cut | None:
    """Return the cut or array of cuts that a reference names, None if it is switched off.

    Raises:
        AcausalError: ``C1xx`` for what is no cut.
    """
    builder = env.builder
    assert builder is not None
    first = reference.parts[0].name
    if first not in builder.merged.elements:
        env.unknown(reference)
    builder.declare(first)
    template = builder.template
    outer = ""
    inner_face = False
    steps: list[tuple[str, tuple[Value, ...]]] = []
    for k, part in enumerate(reference.parts):
        if k == 0 and part.name in template.outers and part.name not in template.children:
            outer, template = part.name, template.outers[part.name]
            continue
        if part.name in template.absent:
            return None
        if part.name not in template.children:
            _not_a_cut(reference, k, template)
        child = template.children[part.name]
        if k and template.is_connector:
            fail("C103", f"{reference} is inside a connector", part.span,
                 help="connect the connector as a whole")  # fmt: skip
        if len(part.subscripts) > len(child.shape):
            fail("T113", f"{part.name} has {len(child.shape)} dimensions", part.span,
                 help="use fewer subscripts")  # fmt: skip
        given = (*part.subscripts, *[None] * (len(child.shape) - len(part.subscripts)))
        axes = tuple(axis(s, n, env) for s, n in zip(given, child.shape, strict=True))
        steps.append((part.name, axes))
        inner_face = k == 0 and child.template.is_connector
        template = child.template
    if not template.is_connector:
        fail("C101", f"{reference} is a component, not a cut", reference.span,
             label=f"a {template.name}",
             help="name one of its cuts: "
             + (", ".join(n for n, c in template.children.items() if c.template.is_connector)
                or "it has none"))  # fmt: skip
    shape = tuple(a.size for _, axes in steps for a in axes if a.shape)
    return Cut(tuple(steps), template, outer, inner_face, shape, reference.span)


def _not_a_cut(reference: tree.Reference, k: int, template: Template) -> None:
    name = reference.parts[k].name
    known = [n for n, c in template.children.items()]
    if name in template.variables or name in template.parameters or name in template.structural:
        fail("C101", f"{reference} is a variable, not a cut", reference.parts[k].span,
             help="write an equation between variables; connect joins cuts")  # fmt: skip
    close = nearest(name, known)
    fail("N102", f"{template.name} has nothing called {name}", reference.parts[k].span,
         label="this name is not declared there",
         notes=[f"did you mean {' or '.join(close)}?"] if close else [],
         help=f"write {close[0]}, if that is what you mean" if close
         else f"acausal list {template.name} shows what it has")  # fmt: skip


def cut_leaves(
    template: Template, prefix: tuple[str, ...] = ()
) -> list[tuple[tuple[str, ...], int, bool, str]]:
    """Return the variables of a cut: path, number of scalars, through or not, unit."""
    result = [((*prefix, v.name), v.size, v.through, v.unit) for v in template.variables.values()]
    for name, child in template.children.items():
        for path, size, through, unit in cut_leaves(child.template, (*prefix, name)):
            result.append((path, size * child.size, through, unit))
    return result


def check_alike(a: Template, b: Template, span: Span, first: Span, second: Span) -> None:
    """Refuse to join unlike cuts.

    Raises:
        AcausalError: ``C101`` if their variables differ, ``U107`` if their units do.
    """
    if a is b or b.number in a.alike:
        return
    mine = {path: (size, through) for path, size, through, _ in cut_leaves(a)}
    other = {path: (size, through) for path, size, through, _ in cut_leaves(b)}
    labels = [Label(first, f"a {a.name}"), Label(second, f"a {b.name}")]
    if mine != other:
        fail("C101", f"a {a.name} cannot be connected to a {b.name}", span,
             label="the two cuts have different variables", labels=labels,
             help="connect cuts of one field; a transducer couples two fields")  # fmt: skip
    one, two = _bases(a), _bases(b)
    for path, base in one.items():
        if two[path] != base:
            fail("C101", f"a {a.name} cannot be connected to a {b.name}", span,
                 label=f"one is {base[0]}, the other {two[path][0]}", labels=labels,
                 help="put a block in between that converts one into the other")  # fmt: skip
    units = dict.fromkeys(mine, "")
    for path, _, _, unit in cut_leaves(a):
        units[path] = unit
    for path, _, _, unit in cut_leaves(b):
        if unit and units[path] and parse_unit(unit).dimension != parse_unit(units[path]).dimension:
            fail("U107", f"connecting {units[path]} with {unit}", span, labels=labels,
                 label="the two cuts have different units",
                 help="put a converter between them")  # fmt: skip
    a.alike.add(b.number)


def _bases(
    template: Template, prefix: tuple[str, ...] = ()
) -> dict[tuple[str, ...], tuple[str, tuple[str, ...]]]:
    """Return the base types of the variables of a cut, with an enumeration's literals."""
    result = {(*prefix, v.name): (v.base, v.literals) for v in template.variables.values()}
    for name, child in template.children.items():
        result |= _bases(child.template, (*prefix, name))
    return result
