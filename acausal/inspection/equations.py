"""Equations as a person reads them: rows of one form are one line with an index range.

Two rows have the same form if the same terms, over operands from the same places, add up to them.
The form of a row is a hash of its terms (a sum over 64-bit numbers, one for each term), so that
finding the forms of millions of rows is a sort. Only forms that are shown are put into words.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import PurePath

import numpy as np
from numpy.typing import NDArray

from acausal.expressions import build
from acausal.expressions.latex import to_latex
from acausal.expressions.nodes import ZERO, Expr, slot
from acausal.expressions.text import to_text
from acausal.expressions.traverse import substitute
from acausal.flattening.model import EquationFamily, Ids, Operand, Origin, RowKind
from acausal.inspection.index_names import IndexNames
from acausal.inspection.operands import Label, Located, Names

#: Terms of one sort that are written out in a sum; more get a summation sign.
_MOST_TERMS = 3
#: Summands of an expression that are written out.
_MOST_SUMMANDS = 12
_LONGEST = 600
#: Contributions to a row whose operands are looked at for a reason.
_MOST_OPERANDS = 50


@dataclass(frozen=True)
class EquationForm:
    """Rows that look the same but for their subscripts.

    Attributes:
        rows: The rows, ascending (variables they define, for definitions).
        families: Numbers of the families that contribute.
        target: What a definition defines; None for an equation.
        terms: The terms, over slots with :class:`Label` payload.
        residual: Their sum.
        indices: Letters of the subscripts that vary.
        origin: Where the first contribution to the first row comes from.
        operands: Variable ids in the first row with the names they have here.
    """

    rows: Ids
    families: tuple[int, ...]
    target: Expr | None
    terms: tuple[Expr, ...]
    residual: Expr
    indices: IndexNames
    origin: Origin | None
    operands: tuple[tuple[int, str], ...]

    def sides(self) -> tuple[Expr, Expr]:
        """Return left and right side, long sums shortened."""
        if self.target is not None:
            return self.target, shortened_sum(self.residual)
        if self.residual.op == "sub":
            return shortened_sum(self.residual.args[0]), shortened_sum(self.residual.args[1])
        if self.residual.op == "neg":
            return shortened_sum(self.residual.args[0]), ZERO
        return shortened_sum(self.residual), ZERO

    def term_texts(self) -> list[str]:
        """Return the terms one by one as text."""
        return [to_text(term, _text_of, _LONGEST) for term in self.terms]

    def text(self) -> str:
        """Return the equation as text, with its index range."""
        left, right = (to_text(side, _text_of, _LONGEST) for side in self.sides())
        ranges = self.indices.text_of_ranges()
        return f"{left} = {right}" + (f"   {ranges}" if ranges else "")

    def latex(self) -> str:
        r"""Return the equation as LaTeX with an alignment mark, index ranges after ``\quad``."""
        left, right = (to_latex(side, _latex_of) for side in self.sides())
        ranges = self.indices.latex_of_ranges()
        return f"{left} &= {right}" + (rf" \quad {ranges}" if ranges else "")

    def source(self) -> str:
        """Return class and line of the equation, or what sort of row it is."""
        return source_of(self.origin)


def shortened_sum(expr: Expr) -> Expr:
    """Return a sum with its terms in a row, the middle of a long one replaced by dots."""
    terms: list[tuple[bool, Expr]] = []
    stack = [(False, expr)]
    while stack:
        negative, part = stack.pop()
        if part.op in ("add", "sub"):
            stack.append((negative != (part.op == "sub"), part.args[1]))
            stack.append((negative, part.args[0]))
        elif part.op == "neg":
            stack.append((not negative, part.args[0]))
        else:
            terms.append((negative, part))
    if len(terms) > _MOST_SUMMANDS:
        dots = (False, slot(Label("...", r"\dots")))
        terms = [*terms[:_MOST_TERMS], dots, terms[-1]]
    result = ZERO
    for negative, part in terms:
        result = build.sub(result, part) if negative else build.add(result, part)
    return result


def source_of(origin: Origin | None) -> str:
    """Return class, file and line of an equation, or what sort of row it is."""
    if origin is None:
        return ""
    if origin.kind == RowKind.UNCONNECTED:
        return "not connected"
    if origin.kind == RowKind.JUNCTION:
        return "junction"
    place = ""
    if origin.span is not None:
        place = f"{PurePath(origin.span.source).name}:{origin.span.line}"
    return ", ".join(filter(None, (origin.class_name, place)))


def _text_of(payload: object) -> str:
    return payload.text if isinstance(payload, Label) else str(payload)


def _latex_of(payload: object) -> str:
    return payload.latex if isinstance(payload, Label) else str(payload)


class EquationForms:
    """The forms of all rows of some families, in order of their first rows.

    Args:
        families: Equation families; every row is the sum of its contributions.
        names: Names of the operands.
        rows: Rows to look at; all rows if None.
        definitions: ``rows`` of the families are the variables they define.
        gathered: How many terms of one sort are written: pattern with term and index ranges.
    """

    def __init__(
        self,
        families: Sequence[EquationFamily],
        names: Names,
        rows: Ids | None = None,
        definitions: bool = False,
        gathered: str = "sum({} for {})",
    ) -> None:
        self._gathered = gathered
        self._families = families
        self._located: list[tuple[Located, ...]] = []
        contributions: list[tuple[Ids, Ids, Ids, Ids]] = []
        terms = 0
        for number, family in enumerate(families):
            members = _members(family, rows)
            own = tuple(
                names.locate(family.operands[j, members], Operand(kind))
                for j, kind in enumerate(family.kinds)
            )
            self._located.append(own)
            code, count = _combined([located.code for located in own], len(members))
            number_of = np.full(len(members), number)
            contributions.append((family.rows[members], code + terms, number_of, members))
            terms += count
        joined = [np.concatenate(part) for part in zip(*contributions, strict=True)]
        row, term, family_of, member = joined if joined else [np.zeros(0, np.int64)] * 4
        # Positions among the members looked at, by which names are known.
        local = np.concatenate([np.arange(len(c[0])) for c in contributions]) if joined else row
        order = np.lexsort((term, row))
        self._row, self._term = row[order], term[order]
        self._family, self._member, self._local = family_of[order], member[order], local[order]
        self._targets: Located | None = None
        self._group(names, definitions)

    def _group(self, names: Names, definitions: bool) -> None:
        change = np.flatnonzero(np.diff(self._row)) + 1
        starts = np.concatenate([[0], change]) if len(self._row) else np.zeros(0, np.int64)
        self._rows = self._row[starts]
        self._starts = starts
        self._lengths = np.diff(np.concatenate([starts, [len(self._row)]]))
        signature = mixed(self._term.astype(np.uint64) + np.uint64(1))
        total = np.zeros(len(starts), np.uint64)
        number = np.repeat(np.arange(len(starts)), self._lengths)
        np.add.at(total, number, signature)
        if definitions and len(starts):
            self._targets = names.locate(self._rows, Operand.VARIABLE)
            total += mixed(self._targets.code.astype(np.uint64) + np.uint64(1 << 40))
        _, first, inverse = np.unique(total, return_index=True, return_inverse=True)
        self.count = len(first)
        rank = np.argsort(np.argsort(first))
        self.form_of = rank[inverse.reshape(-1)] if len(first) else np.zeros(0, np.int64)
        self._order = np.argsort(self.form_of, kind="stable")
        sizes = np.bincount(self.form_of, minlength=self.count)
        self._bounds = np.concatenate([[0], np.cumsum(sizes)])
        self.sizes = sizes

    @property
    def n_rows(self) -> int:
        """Number of rows looked at."""
        return len(self._rows)

    def rows_of(self, number: int) -> Ids:
        """Return the rows of a form, ascending."""
        rows: Ids = self._rows[self._places(number)]
        return rows

    def _places(self, number: int) -> Ids:
        places: Ids = self._order[self._bounds[number] : self._bounds[number + 1]]
        return places

    def families_of(self, number: int) -> tuple[int, ...]:
        """Return the numbers of the families that contribute to a form."""
        first = int(self._places(number)[0])
        begin = int(self._starts[first])
        own = self._family[begin : begin + int(self._lengths[first])]
        return tuple(np.unique(own).tolist())

    def terms_of(self, number: int) -> int:
        """Return the number of terms of each row of a form."""
        return int(self._lengths[int(self._places(number)[0])])

    def numbers_of(self, rows: Ids) -> Ids:
        """Return the form of each row, shape of ``rows``."""
        numbers: Ids = self.form_of[np.searchsorted(self._rows, rows)]
        return numbers

    def of_rows(self, rows: Ids) -> EquationForm:
        """Put rows of one form into words, with index ranges of their own."""
        return self._form(np.searchsorted(self._rows, rows))

    def form(self, number: int) -> EquationForm:
        """Put a form into words."""
        return self._form(self._places(number))

    def _form(self, places: Ids) -> EquationForm:
        indices = IndexNames(len(places))
        target = None
        if self._targets is not None:
            target = self._targets.name(places, indices)
        matrix = self._starts[places][:, None] + np.arange(int(self._lengths[places[0]]))
        named: list[Expr] = []
        terms = self._term[matrix[0]]
        edges = np.flatnonzero(np.concatenate([[True], np.diff(terms) != 0, [True]]))
        for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
            if b - a <= _MOST_TERMS:
                named += [self._named(matrix[:, k], indices) for k in range(a, b)]
            else:
                named.append(self._sum(matrix[:, a:b], indices))
        residual: Expr = ZERO
        for term in named:
            residual = build.add(residual, term)
        first = int(matrix[0, 0])
        families = tuple(np.unique(self._family[matrix[0]]).tolist())
        origin = self._origin(int(self._family[first]), int(self._member[first]))
        return EquationForm(
            self._rows[places],
            families,
            target,
            tuple(named),
            residual,
            indices,
            origin,
            self._operands(matrix, indices),
        )

    def _operands(self, matrix: Ids, indices: IndexNames) -> tuple[tuple[int, str], ...]:
        """Return the variables of the first row with their names in the form, each once."""
        found: dict[int, str] = {}
        for k in range(min(matrix.shape[1], _MOST_OPERANDS)):
            number = int(self._family[matrix[0, k]])
            family = self._families[number]
            for j, located in enumerate(self._located[number]):
                variable = int(family.operands[j, self._member[matrix[0, k]]])
                if family.kinds[j] == Operand.VARIABLE and variable not in found:
                    name = located.name(self._local[matrix[:, k]], indices).value
                    assert isinstance(name, Label)
                    found[variable] = name.text
        return tuple(found.items())

    def _named(self, contributions: Ids, indices: IndexNames) -> Expr:
        """Return a term over names; one contribution for each row."""
        number = int(self._family[contributions[0]])
        members = self._local[contributions]
        family = self._families[number]
        return substitute(
            family.template,
            {
                slot(j): located.name(members, indices)
                for j, located in enumerate(self._located[number])
            },
        )

    def _sum(self, matrix: Ids, indices: IndexNames) -> Expr:
        """Return many terms of one sort under a summation sign, as seen in the first row."""
        inner = IndexNames(matrix.shape[1], indices.used + 4 * (len(matrix) > 1))
        term = self._named(matrix[0], inner)
        text = to_text(term, _text_of, _LONGEST)
        latex = to_latex(term, _latex_of)
        if term.op != "slot":
            latex = rf"\left({latex}\right)"
        ranges = inner.text_of_ranges().removeprefix("for ")
        low = r",\, ".join(f"{letter}" for letter, _, _ in inner.ranges())
        return slot(Label(self._gathered.format(text, ranges), rf"\sum_{{{low}}} {latex}"))

    def _origin(self, number: int, member: int) -> Origin | None:
        for origin in self._families[number].origins:
            if origin.first <= member < origin.first + origin.count:
                return origin
        return None


def _members(family: EquationFamily, rows: Ids | None) -> Ids:
    if rows is None:
        return np.arange(family.count)
    return np.flatnonzero(np.isin(family.rows, rows))


def _combined(codes: Sequence[Ids], n: int) -> tuple[Ids, int]:
    """Return one code for every combination of codes, and the number of combinations."""
    result, count = np.zeros(n, np.int64), min(n, 1)
    for code in codes:
        own = int(code.max(initial=0)) + 1
        if own > 1:
            distinct, result = np.unique(result * own + code, return_inverse=True)
            result, count = result.reshape(-1), len(distinct)
    return result, count


def mixed(x: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Return well-mixed 64-bit numbers (the finaliser of SplitMix64, Steele et al. 2014)."""
    x = x * np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))
