"""Collecting equation families: one for every distinct template, wherever it comes from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Span, fail
from acausal.expressions.nodes import Expr, const, slot
from acausal.expressions.traverse import postorder, slots, substitute
from acausal.flattening.model import EquationFamily, Ids, Operand, Origin, RowKind
from acausal.flattening.signals import SignalNumbering
from acausal.instantiation.domain import has_loops, only_loops, over
from acausal.instantiation.numbering import Numbering
from acausal.instantiation.template import Domain, Ref, Signal, Template


class LiteralPool:
    """Numbers that differ between members of a family, kept as anonymous parameters."""

    def __init__(self, first: int) -> None:
        self._first = first
        self._known: dict[bytes, int] = {}
        self.values: list[NDArray[np.float64]] = []
        self.count = 0

    def ids(self, values: NDArray[np.float64]) -> Ids:
        """Return parameter ids that hold ``values``, same shape."""
        data = np.ascontiguousarray(values).tobytes()
        if data not in self._known:
            self._known[data] = self._first + self.count
            self.values.append(np.array(values))
            self.count += len(values)
        first = self._known[data]
        return np.arange(first, first + len(values))


class FamilyBuilder:
    """Collects members by template."""

    def __init__(
        self,
        numbering: Numbering,
        literals: LiteralPool,
        signals: SignalNumbering | None = None,
    ) -> None:
        self.numbering = numbering
        self.literals = literals
        self.signals = SignalNumbering(numbering) if signals is None else signals
        self._parts: dict[
            tuple[Expr, tuple[Operand, ...]], list[tuple[Ids, Ids, tuple[Origin, ...]]]
        ] = {}

    def add(
        self, template: Expr, kinds: tuple[Operand, ...], operands: Ids, rows: Ids,
        origins: tuple[Origin, ...],
    ) -> None:  # fmt: skip
        """Add members of a template over ``slot(0) ..``."""
        self._parts.setdefault((template, kinds), []).append((operands, rows, origins))

    def add_filled(
        self, template: Expr, operands: Ids, rows: Ids, origins: tuple[Origin, ...]
    ) -> None:
        """Add members of a template that need not use all of its operands, all variables."""
        used = sorted(int(s) for s in slots(template))  # type: ignore[call-overload]
        body = substitute(template, {slot(k): slot(i) for i, k in enumerate(used)})
        self.add(body, (Operand.VARIABLE,) * len(used), operands[used], rows, origins)

    def add_class_equation(
        self, template: Template, residual: Expr, domain: Domain, first_row: int, span: Span,
        text: str, kind: RowKind, owner: str,
    ) -> int:  # fmt: skip
        """Add an equation of a class for all its instances and passes of its loops.

        Returns:
            The number of rows added.

        Raises:
            AcausalError: ``T114`` for a subscript out of range.
        """
        count = self.numbering.groups[template.number].count * domain.length
        rows = first_row + np.arange(count)
        self.add_class_rows(template, residual, domain, rows, span, text, kind, owner)
        return count

    def add_class_rows(
        self, template: Template, residual: Expr, domain: Domain, rows: Ids, span: Span,
        text: str, kind: RowKind, owner: str,
    ) -> None:  # fmt: skip
        """Add an expression of a class for given rows, instance by instance, pass by pass.

        Raises:
            AcausalError: ``T114`` for a subscript out of range.
        """
        group = self.numbering.groups[template.number]
        count = group.count * domain.length
        if not count:
            return
        try:
            body, kinds, operands = self.canonical(template, residual, domain)
        except IndexError as error:
            index, n = error.args
            fail("T114", f"subscript {index} is outside 1..{n} in {text}", span,
                 help=f"the array has {n} elements; check the range of the loop")  # fmt: skip
        origin = Origin(
            0, count, kind, span, text, owner, template.number,
            np.repeat(np.arange(group.count), domain.length),
        )  # fmt: skip
        self.add(body, kinds, operands, rows, (origin,))

    def canonical(
        self, template: Template, expr: Expr, domain: Domain
    ) -> tuple[Expr, tuple[Operand, ...], Ids]:
        """Return an expression over numbered slots, their kinds and ids ``(m, members)``.

        Raises:
            IndexError: For a subscript out of range.
        """
        instances = self.numbering.groups[template.number].count
        mapping: dict[Expr, Expr] = {}
        literal: dict[Expr, NDArray[np.float64]] = {}
        if domain.names and has_loops(expr):
            for part in maximal_loop_parts(expr):
                values = over(domain, part)
                if (values == values[0]).all():
                    mapping[part] = const(float(values[0]))
                else:
                    literal[part] = values
            # A constant part can stand inside of one that is not: that one stays as it is.
            expr = substitute(expr, {**mapping, **{part: part for part in literal}})
        numbered: dict[Expr, Expr] = {}
        kinds: list[Operand] = []
        rows: list[Ids] = []
        for part in postorder(expr):
            if part in literal:
                ids = np.tile(self.literals.ids(literal[part]), instances)
                kinds.append(Operand.PARAMETER)
            elif part.op == "slot" and isinstance(part.value, Ref):
                ids = self.numbering.ids(template, part.value, domain)
                kinds.append(_kind(part.value))
            elif part.op == "slot" and isinstance(part.value, Signal):
                ids = self.signals.ids(template, part.value, domain)
                kinds.append(Operand.PRE_SIGNAL if part.value.pre else Operand.SIGNAL)
            else:
                continue
            numbered[part] = slot(len(rows))
            rows.append(ids)
        body = substitute(expr, numbered)
        # Slots inside replaced parts may have vanished: number those that are left anew.
        left = slots(body)
        if left != tuple(range(len(rows))):
            order = [int(s) for s in left]  # type: ignore[call-overload]
            body = substitute(body, {slot(k): slot(i) for i, k in enumerate(order)})
            kinds, rows = [kinds[k] for k in order], [rows[k] for k in order]
        members = instances * domain.length
        operands = np.stack(rows) if rows else np.zeros((0, members), np.int64)
        return body, tuple(kinds), operands

    def build(self) -> tuple[EquationFamily, ...]:
        """Return the families in order of first appearance."""
        result = []
        for (template, kinds), parts in self._parts.items():
            origins: list[Origin] = []
            first = 0
            for operands, _, own in parts:
                origins += [replace(o, first=first + o.first) for o in own]
                first += operands.shape[1]
            result.append(
                EquationFamily(
                    template,
                    kinds,
                    np.concatenate([p[0] for p in parts], axis=1),
                    np.concatenate([p[1] for p in parts]),
                    tuple(origins),
                )
            )
        return tuple(result)


def _kind(ref: Ref) -> Operand:
    if ref.parameter:
        return Operand.PARAMETER
    return Operand.PRE if ref.pre else Operand.VARIABLE


def maximal_loop_parts(expr: Expr) -> list[Expr]:
    """Return the largest subexpressions that depend on loop indices alone, in order."""
    loops = {p for p in postorder(expr) if p.op != "const" and only_loops(p)}
    result: list[Expr] = []
    seen: set[Expr] = set()
    stack = [expr]
    while stack:
        part = stack.pop()
        if part in seen:
            continue
        seen.add(part)
        if part in loops:
            result.append(part)
        else:
            stack += reversed(part.args)
    return result
