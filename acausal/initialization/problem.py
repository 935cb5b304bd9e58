"""The algebraic system of a start: residuals and sparse Jacobian from the kernels.

The kernels are those of the simulation; only the index arrays differ. The work vector is

    w = [ 0.0 | time | values of all ids in use (k) | parameters (p) | lambda ]

and every order of derivative has a position of its own. ``lambda`` is the homotopy parameter,
1 for the actual equations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from acausal.assembly.problem import KernelCall
from acausal.codegen.kernels import compile_kernels
from acausal.elimination.families import variable_slots
from acausal.expressions.build import add, mul, sub
from acausal.expressions.nodes import Expr, slot
from acausal.expressions.traverse import postorder, substitute
from acausal.flattening.model import EquationFamily, Ids, Operand
from acausal.initialization.system import StartSystem

Array = NDArray[np.float64]

#: Position of the first value in the work vector.
VALUES = 2


@dataclass(frozen=True)
class AlgebraicProblem:
    """``F(x) = 0`` in some rows and some of the values, all others known.

    Attributes:
        calls: Kernel calls; targets are positions in a residual of ``n_rows + 1`` entries, the
            last of which collects the rows left out.
        sources: Where each call comes from: the family, its members, and their rows here.
        w: Work vector, float64, shared by all problems of one start.
        rows: Global rows (the model's, then initial ones), shape ``(n_rows,)``.
        ids: Unknown ids, shape ``(n,)``.
        positions: Their positions in ``w``, shape ``(n,)``.
        indptr: Column pointers of the Jacobian, shape ``(n+1,)``.
        indices: Row indices, sorted in each column, shape ``(nnz,)``.
        scale: Magnitudes of the unknowns, shape ``(n,)``.
        minimum: Lower bounds of the unknowns.
        maximum: Upper bounds of the unknowns.
    """

    calls: tuple[KernelCall, ...]
    sources: tuple[tuple[EquationFamily, Ids, NDArray[np.int32]], ...]
    w: Array
    rows: Ids
    ids: Ids
    positions: Ids
    indptr: NDArray[np.int64]
    indices: NDArray[np.int32]
    scale: Array
    minimum: Array
    maximum: Array

    @property
    def n(self) -> int:
        """Number of unknowns."""
        return int(self.ids.shape[0])

    @property
    def n_rows(self) -> int:
        """Number of rows."""
        return int(self.rows.shape[0])

    @property
    def nnz(self) -> int:
        """Number of structurally non-zero entries of the Jacobian."""
        return int(self.indices.shape[0])

    def get(self) -> Array:
        """Return the unknowns, a copy."""
        x: Array = self.w[self.positions]
        return x

    def put(self, x: Array) -> None:
        """Set the unknowns."""
        self.w[self.positions] = x

    def residual(self, x: Array) -> Array:
        """Return ``F(x)``, shape ``(n_rows,)``; may be NaN or infinite."""
        self.put(x)
        out = np.zeros(self.n_rows + 1)
        for call in self.calls:
            call.kernel.evaluate_residual(self.w, call.index, call.target, out)
        return out[:-1]

    def jacobian(self, x: Array) -> Array:
        """Return the values of the Jacobian in CSC order, shape ``(nnz,)``."""
        self.put(x)
        out = np.zeros(self.nnz + 1)
        for call in self.calls:
            if call.kernel.q:
                call.kernel.evaluate_jacobian(self.w, call.index, call.entry, out)
        return out[:-1]


@dataclass(frozen=True)
class Layout:
    """Positions in the work vector.

    Attributes:
        position: Position of each id, -1 if it is in no row, shape ``(n_ids,)``.
        first_parameter: Position of parameter 0.
        last: Position of the homotopy parameter.
    """

    position: NDArray[np.int32]
    first_parameter: int
    last: int


@dataclass(frozen=True)
class StartEquations:
    """All rows of a start with their kernel calls, before any is chosen.

    Attributes:
        system: The equations.
        layout: Positions.
        w: The work vector.
        families: Families with global rows; initial rows follow the model's.
        calls: A kernel call for each family, without targets and entries.
    """

    system: StartSystem
    layout: Layout
    w: Array
    families: tuple[EquationFamily, ...]
    calls: tuple[KernelCall, ...]

    @property
    def total_rows(self) -> int:
        """Number of rows, initial ones counted."""
        return self.system.n_rows + self.system.n_initial

    def values(self) -> Array:
        """Return the values of all ids; start values where an id is in no row."""
        result = self.system.variables.start.copy()
        used = self.layout.position >= 0
        result[used] = self.w[self.layout.position[used]]
        return result

    def set_values(self, values: Array, time: float) -> None:
        """Put values of all ids and the time into the work vector."""
        used = self.layout.position >= 0
        self.w[self.layout.position[used]] = values[used]
        self.w[1] = time

    def set_lambda(self, value: float) -> None:
        """Set the homotopy parameter: 0 simplified, 1 actual."""
        self.w[self.layout.last] = value


def start_equations(
    system: StartSystem, *, with_initial: bool = True, with_homotopy: bool = False
) -> StartEquations:
    """Return all rows with compiled kernels.

    Args:
        system: The equations.
        with_initial: Initial equations count.
        with_homotopy: ``homotopy(actual, simplified)`` moves with the homotopy parameter;
            otherwise it is ``actual``.
    """
    used = system.used()
    position = np.full(system.n_ids, -1, dtype=np.int32)
    position[used] = VALUES + np.arange(int(used.sum()), dtype=np.int32)
    first_parameter = VALUES + int(used.sum())
    last = first_parameter + system.parameters.shape[0]
    w = np.zeros(last + 1)
    w[first_parameter:last] = system.parameters
    w[last] = 1.0
    layout = Layout(position, first_parameter, last)
    families = list(system.families)
    if with_initial:
        families += [replace(f, rows=f.rows + system.n_rows) for f in system.initial]
    templates: list[tuple[Expr, tuple[int, ...]]] = []
    indices: list[NDArray[np.int32]] = []
    for family in families:
        template = family.template
        rows = [
            first_parameter + family.operands[j] if kind == Operand.PARAMETER
            else position[family.operands[j]]
            for j, kind in enumerate(family.kinds)
        ]  # fmt: skip
        if with_homotopy and has_homotopy(template):
            template = moving(template, len(family.kinds))
            rows.append(np.full(family.count, last))
        index = np.empty((len(rows), family.count), dtype=np.int32)
        for j, row in enumerate(rows):
            index[j] = row
        templates.append((template, tuple(variable_slots(family))))
        indices.append(index)
    nothing = np.zeros(0, dtype=np.int32)
    calls = tuple(
        KernelCall(kernel, index[: kernel.m], nothing, nothing)
        for kernel, index in zip(compile_kernels(templates), indices, strict=True)
    )
    return StartEquations(system, layout, w, tuple(families), calls)


def has_homotopy(template: Expr) -> bool:
    """Return whether a template contains the homotopy operator."""
    return any(item.op == "homotopy" for item in postorder(template))


def moving(template: Expr, parameter: int) -> Expr:
    """Return the template with ``s + slot(parameter)*(a - s)`` for each ``homotopy(a, s)``."""
    mapping: dict[Expr, Expr] = {}
    weight = slot(parameter)
    for item in postorder(template):
        if item.op == "homotopy":
            actual, simplified = (substitute(argument, mapping) for argument in item.args)
            mapping[item] = add(simplified, mul(weight, sub(actual, simplified)))
    return substitute(template, mapping)


def algebraic_problem(equations: StartEquations, rows: Ids, ids: Ids) -> AlgebraicProblem:
    """Return the problem of some rows and some unknowns, everything else known.

    Args:
        equations: All rows.
        rows: Global rows to be solved.
        ids: Unknowns.
    """
    row_of = np.full(equations.total_rows, rows.shape[0], dtype=np.int32)
    row_of[rows] = np.arange(rows.shape[0], dtype=np.int32)
    column_of = np.full(equations.system.n_ids, -1, dtype=np.int32)
    column_of[ids] = np.arange(ids.shape[0], dtype=np.int32)
    everything = rows.shape[0] == equations.total_rows
    chosen: list[tuple[int, Ids]] = []
    for number, family in enumerate(equations.families):
        members = np.arange(family.count)
        if not everything:
            members = members[row_of[family.rows] < rows.shape[0]]
        if members.shape[0]:
            chosen.append((number, members))
    return assembled(equations, chosen, row_of, column_of, rows, ids)


def assembled(
    equations: StartEquations,
    chosen: Sequence[tuple[int, Ids]],
    row_of: NDArray[np.int32],
    column_of: NDArray[np.int32],
    rows: Ids,
    ids: Ids,
) -> AlgebraicProblem:
    """Return the problem of the chosen members of families.

    Args:
        equations: All rows.
        chosen: Number of a family and its members, ascending.
        row_of: Row in the problem of each global row.
        column_of: Unknown of each id, -1 if it is known.
        rows: Global rows.
        ids: Unknown ids.
    """
    n, n_rows = ids.shape[0], rows.shape[0]
    parts: list[tuple[EquationFamily, Ids, KernelCall]] = []
    keys: list[NDArray[np.int64]] = []
    for number, members in chosen:
        family, call = equations.families[number], equations.calls[number]
        whole = members.shape[0] == family.count
        index = call.index if whole else np.ascontiguousarray(call.index[:, members])
        target = row_of[family.rows if whole else family.rows[members]]
        slots = list(call.kernel.variable_slots)
        operands = family.operands[slots] if whole else family.operands[slots][:, members]
        columns = column_of[operands]
        key = columns * np.int64(n_rows) + target
        key[(columns < 0) | (target >= n_rows)] = -1
        keys.append(key.ravel())
        parts.append((family, members, KernelCall(call.kernel, index, target, index[:0])))
    joined = np.concatenate([*keys, np.zeros(0, dtype=np.int64)])
    unique, inverse = np.unique(joined, return_inverse=True)
    offset = 1 if unique.shape[0] and unique[0] < 0 else 0
    entry = (inverse - offset).astype(np.int32)
    unique = unique[offset:]
    entry[entry < 0] = unique.shape[0]
    indptr = np.zeros(n + 1, dtype=np.int64)
    if n_rows:
        np.cumsum(np.bincount(unique // n_rows, minlength=n), out=indptr[1:])
    indices = (unique % max(n_rows, 1)).astype(np.int32)
    calls: list[KernelCall] = []
    start = 0
    for (_, members, call), key in zip(parts, keys, strict=True):
        shape = (call.kernel.q, members.shape[0])
        mine = np.ascontiguousarray(entry[start : start + key.shape[0]].reshape(shape))
        start += key.shape[0]
        calls.append(replace(call, entry=mine))
    variables = equations.system.variables
    positions = equations.layout.position[ids].astype(np.int64)
    return AlgebraicProblem(
        calls=tuple(calls),
        sources=tuple((family, members, call.target) for family, members, call in parts),
        w=equations.w,
        rows=rows,
        ids=ids,
        positions=positions,
        indptr=indptr,
        indices=indices,
        scale=np.abs(variables.nominal[ids]),
        minimum=variables.minimum[ids],
        maximum=variables.maximum[ids],
    )
