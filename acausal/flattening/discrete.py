"""The discrete part of a model as it is collected: what changes at events, and how."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Span, fail
from acausal.expressions import build
from acausal.expressions.nodes import Expr, slot
from acausal.flattening.families import FamilyBuilder, LiteralPool
from acausal.flattening.model import (
    Base,
    Discrete,
    EquationFamily,
    Ids,
    Operand,
    Origin,
    ReinitFamily,
    RowKind,
    SignalFamily,
    Termination,
)
from acausal.flattening.signals import SignalNumbering
from acausal.instantiation.numbering import Numbering
from acausal.instantiation.template import DiscreteDecl, Domain, Ref, Template

_BASES = {
    "Real": Base.REAL,
    "Integer": Base.INTEGER,
    "Boolean": Base.BOOLEAN,
    "enumeration": Base.ENUMERATION,
}


def discrete_variables(
    numbering: Numbering,
) -> tuple[NDArray[np.int8], NDArray[np.bool_]]:
    """Return the :class:`Base` of each variable, and which of them change at events only.

    A Real variable does if it is declared so, or if a when gives it its value: that is a matter
    of the single variable, not of its class.
    """
    base = np.zeros(numbering.n_variables, np.int8)
    discrete = np.zeros(numbering.n_variables, np.bool_)
    for block in numbering.variables:
        if block.order:
            continue
        own = slice(block.first, block.first + block.count)
        base[own] = _BASES[block.declaration.base]
        discrete[own] = block.declaration.discrete or block.declaration.base != "Real"
    for group in numbering.groups:
        if not group.count:
            continue
        for d in group.template.discrete:
            if d.held:
                discrete[variable_ids(numbering, group.template, d.target, d)] = True
    return base, discrete


def variable_ids(numbering: Numbering, template: Template, target: Expr, where: object) -> Ids:
    """Return the variables that a slot means, instance by instance, pass by pass.

    Args:
        numbering: Ids.
        template: The class.
        target: A slot with a :class:`Ref`.
        where: The declaration it stands in, with ``domain``, ``span`` and ``text``.

    Raises:
        AcausalError: ``T114`` for a subscript out of range.
    """
    assert isinstance(target.value, Ref)
    domain: Domain = where.domain  # type: ignore[attr-defined]
    span: Span = where.span  # type: ignore[attr-defined]
    text: str = where.text  # type: ignore[attr-defined]
    try:
        return numbering.ids(template, target.value, domain)
    except IndexError as error:
        index, n = error.args
        fail("T114", f"subscript {index} is outside 1..{n} in {text}", span,
             help=f"the array has {n} elements; check the range of the loop")  # fmt: skip


def discrete_part(
    numbering: Numbering,
    literals: LiteralPool,
    signals: SignalNumbering,
    base: NDArray[np.int8],
    discrete: NDArray[np.bool_],
    junctions: Sequence[EquationFamily],
) -> Discrete:
    """Collect the discrete part of a model.

    Args:
        numbering: Ids of variables and parameters.
        literals: Receives numbers that differ between passes of loops.
        signals: Ids of signals.
        base: See :func:`discrete_variables`.
        discrete: Likewise.
        junctions: Equalities of discrete variables at junctions.
    """
    collector = _Collector(numbering, literals, signals)
    groups = [g for g in reversed(numbering.groups) if g.count]
    equal, assigned = collector.builder(), collector.builder()
    initial, initial_pre = collector.builder(), collector.builder()
    for template in [g.template for g in groups]:
        for d in template.discrete:
            if d.symmetric and not d.held:
                collector.add_equality(equal, template, d)
            else:
                collector.add(assigned, template, d, RowKind.DECLARED)
        for d in template.initial_discrete:
            assert isinstance(d.target.value, Ref)
            chosen = initial_pre if d.target.value.pre else initial
            collector.add(chosen, template, d, RowKind.INITIAL)
    return Discrete(
        base,
        discrete,
        signals.count,
        tuple(s for g in groups for s in collector.signals(g.template)),
        assigned.build(),
        (*junctions, *equal.build()),
        initial.build(),
        initial_pre.build(),
        tuple(r for g in groups for r in collector.reinits(g.template)),
        tuple(t for g in groups for t in collector.terminations(g.template)),
    )


class _Collector:
    """Turns declarations of classes into families."""

    def __init__(
        self, numbering: Numbering, literals: LiteralPool, signals: SignalNumbering
    ) -> None:
        self._numbering = numbering
        self._literals = literals
        self._signals = signals

    def builder(self) -> FamilyBuilder:
        return FamilyBuilder(self._numbering, self._literals, self._signals)

    def _family(
        self, template: Template, value: Expr, domain: Domain, rows: Ids, span: Span, text: str
    ) -> EquationFamily:
        own = self.builder()
        own.add_class_rows(
            template, value, domain, rows, span, text, RowKind.DECLARED, template.name
        )
        (family,) = own.build()
        return family

    def add(
        self, builder: FamilyBuilder, template: Template, d: DiscreteDecl, kind: RowKind
    ) -> None:
        targets = variable_ids(self._numbering, template, d.target, d)
        # The body of a when is evaluated at the instant it fires: its relations watch nothing.
        value = build.noevent(d.value) if d.held else d.value
        builder.add_class_rows(template, value, d.domain, targets, d.span, d.text, kind, d.owner)

    def add_equality(self, builder: FamilyBuilder, template: Template, d: DiscreteDecl) -> None:
        left = variable_ids(self._numbering, template, d.target, d)
        right = variable_ids(self._numbering, template, d.value, d)
        group = self._numbering.groups[template.number]
        origin = Origin(
            0, len(left), RowKind.DECLARED, d.span, d.text, d.owner, template.number,
            np.repeat(np.arange(group.count), d.domain.length),
        )  # fmt: skip
        kinds = (Operand.VARIABLE, Operand.VARIABLE)
        builder.add(build.sub(slot(0), slot(1)), kinds, np.stack([left, right]), left, (origin,))

    def signals(self, template: Template) -> list[SignalFamily]:
        return [
            SignalFamily(
                s.kind,
                tuple(
                    self._family(
                        template, operand, s.domain, self._signals.all(template, k), s.span, s.text
                    )
                    for operand in s.operands
                ),
            )
            for k, s in enumerate(template.signals)
            if s.domain.length
        ]

    def reinits(self, template: Template) -> list[ReinitFamily]:
        result = []
        for r in template.reinits:
            if not r.domain.length:
                continue
            state = variable_ids(self._numbering, template, r.state, r)
            impulse = np.full(len(state), -1)
            if r.impulse is not None:
                impulse = variable_ids(self._numbering, template, r.impulse, r)
            value, fires = (
                self._family(template, e, r.domain, state, r.span, r.text)
                for e in (build.noevent(r.value), r.fires)
            )
            result.append(ReinitFamily(value, fires, impulse))
        return result

    def terminations(self, template: Template) -> list[Termination]:
        result = []
        for t in template.terminates:
            count = self._numbering.groups[template.number].count * t.domain.length
            if count:
                rows = np.arange(count)
                family = self._family(template, t.fires, t.domain, rows, t.span, t.text)
                result.append(Termination(family, t.message))
        return result
