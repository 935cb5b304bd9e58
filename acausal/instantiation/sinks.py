"""Where elaborated equations go: branches collect apart and are joined when complete."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from acausal.diagnostics import Label, Span, fail
from acausal.expressions import build
from acausal.expressions.nodes import Expr
from acausal.instantiation.domain import at_pass
from acausal.instantiation.template import (
    AssertDecl,
    BranchDecl,
    ConnectDecl,
    DiscreteDecl,
    Domain,
    EquationDecl,
    Ref,
    ReinitDecl,
    RootDecl,
    TerminateDecl,
)

#: Branches that name the same variables in different ways are written out up to this length.
LONGEST_BRANCH = 10_000

#: A variable or array of variables of a class: path, name and ``outer`` start, no subscripts.
Name = tuple[tuple[str, ...], str, str]
#: What tells the targets of assignments apart.
Target = tuple[Expr, tuple[str, ...], bytes]


@dataclass
class Sink:
    """Elaborated equations of a section or of a branch.

    Attributes:
        initial: Of an initial section.
        when: Inside a when; its equations are assignments.
        conditional: Under a condition that can change.
        held: Variables that whens of the class set; known to initial sections.
    """

    initial: bool
    when: bool = False
    conditional: bool = False
    held: frozenset[Name] = frozenset()
    equations: list[EquationDecl] = field(default_factory=list)
    connects: list[ConnectDecl] = field(default_factory=list)
    asserts: list[AssertDecl] = field(default_factory=list)
    discrete: list[DiscreteDecl] = field(default_factory=list)
    reinits: list[ReinitDecl] = field(default_factory=list)
    terminates: list[TerminateDecl] = field(default_factory=list)
    branches: list[BranchDecl] = field(default_factory=list)
    roots: list[RootDecl] = field(default_factory=list)

    def below(self, when: bool = False, conditional: bool = False) -> Sink:
        """Return an empty sink for a part of the section."""
        return Sink(self.initial, self.when or when, self.conditional or conditional, self.held)

    def take(self, other: Sink) -> None:
        """Add what another sink has collected."""
        self.equations += other.equations
        self.connects += other.connects
        self.asserts += other.asserts
        self.discrete += other.discrete
        self.reinits += other.reinits
        self.terminates += other.terminates
        self.branches += other.branches
        self.roots += other.roots


def name_of(ref: Ref) -> Name:
    """Return the variable that a reference names, without its subscripts."""
    return tuple(step.name for step in ref.path), ref.name, ref.outer


def target_text(target: Expr) -> str:
    """Return a target as text, without subscripts."""
    assert isinstance(target.value, Ref)
    path, name, _ = name_of(target.value)
    return ".".join(part for part in (*path, name) if part)


def take_guarded(sink: Sink, body: Sink, fires: Expr) -> None:
    """Add assertions, reinits and terminations that act only where ``fires`` is true."""
    idle = build.not_(fires)
    sink.asserts += [replace(a, condition=build.or_(idle, a.condition)) for a in body.asserts]
    sink.reinits += [replace(r, fires=build.and_(fires, r.fires)) for r in body.reinits]
    sink.terminates += [replace(t, fires=build.and_(fires, t.fires)) for t in body.terminates]


def aligned(
    branches: Sequence[Sink], span: Span, what: str
) -> list[tuple[DiscreteDecl, list[DiscreteDecl]]]:
    """Return the assignments of branches, sorted by target: the first one, and that of each branch.

    Raises:
        AcausalError: ``E009`` if a branch leaves out a variable that another one sets, ``E006`` if
            one sets a variable twice.
    """
    tables = [_by_target(b.discrete) for b in branches]
    if any(t.keys() != tables[0].keys() for t in tables):
        tables = [_by_target(_written_out(b.discrete)) for b in branches]
    for table in tables:
        for other in tables:
            for key, declaration in table.items():
                if key not in other:
                    fail("E009", f"{target_text(declaration.target)} is not set in every branch of "
                         f"this {what}", span, label="the branches must set the same variables",
                         labels=[Label(declaration.span, "set here")],
                         help=f"add {target_text(declaration.target)} = "
                         f"pre({target_text(declaration.target)}) to the others")  # fmt: skip
    return [(d, [t[key] for t in tables]) for key, d in tables[0].items()]


def _by_target(declarations: list[DiscreteDecl]) -> dict[Target, DiscreteDecl]:
    result: dict[Target, DiscreteDecl] = {}
    for d in declarations:
        key = (d.target, d.domain.names, d.domain.values.tobytes())
        if key in result:
            set_twice(result[key], d)
        result[key] = d
    return result


def set_twice(first: DiscreteDecl, second: DiscreteDecl) -> None:
    """Refuse two assignments of one variable.

    Raises:
        AcausalError: ``E006``.
    """
    name = target_text(second.target)
    fail("E006", f"{name} is set twice", second.span, label="set here again",
         labels=[Label(first.span, "set here")] if first.span != second.span else [],
         help="set it in one when, with elsewhen for the other condition")  # fmt: skip


def _written_out(declarations: list[DiscreteDecl]) -> list[DiscreteDecl]:
    """Return a declaration for every pass of the loops."""
    if sum(d.domain.length for d in declarations) > LONGEST_BRANCH:
        return declarations
    return [
        replace(d, target=at_pass(d.target, d.domain, k), value=at_pass(d.value, d.domain, k),
                domain=Domain())
        for d in declarations
        for k in range(d.domain.length)
    ]  # fmt: skip


def joined(
    c: Expr, first: Sink, second: Sink, sink: Sink, span: Span,
    keep: Callable[[EquationDecl], None],
) -> None:  # fmt: skip
    """Join the two branches of an ``if`` equation whose condition can change.

    Raises:
        AcausalError: ``C105`` for a connect in a branch, ``B105`` and ``E009`` if the branches have
            unlike equations.
    """
    if first.connects or second.connects:
        fail("C105", "connect stands under a condition that can change", span,
             help="use a Boolean parameter in the condition")  # fmt: skip
    rows = [sum(e.domain.length for e in s.equations) for s in (first, second)]
    same = len(first.equations) == len(second.equations) and all(
        a.domain.names == b.domain.names and a.domain.length == b.domain.length
        for a, b in zip(first.equations, second.equations, strict=False)
    )
    if not same:
        fail("B105", f"the branches of this if have {rows[0]} and {rows[1]} equations", span,
             label="a condition that can change must choose between equally many equations",
             help="give every branch the same number of equations")  # fmt: skip
    for a, b in zip(first.equations, second.equations, strict=True):
        keep(replace(a, residual=build.if_(c, a.residual, b.residual),
                     text=f"if … then {a.text} else {b.text}"))  # fmt: skip
    for own, (one, other) in aligned((first, second), span, "if"):
        text = own.text if first.when else f"if … then {one.text} else {other.text}"
        value = build.if_(c, one.value, other.value)
        sink.discrete.append(replace(one, value=value, text=text, symmetric=False))
    take_guarded(sink, first, c)
    take_guarded(sink, second, build.not_(c))
