"""Why an integration stopped, told in the user's words.

Codes: R100 unknown solver, R101 no SUNDIALS, R102 no scikits-odes, R110 error test, R111 Newton
iteration, R112 singular Jacobian, R113 too many steps, R114 a number that is not finite, R115
anything else a solver reports, R116 no explicit form, R117 too large for one.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import AcausalError, Diagnostic
from acausal.solvers.protocol import Labels
from acausal.solvers.system import NativeSystem

Array = NDArray[np.float64]

#: Largest system whose singular vectors are computed for a message.
LARGEST_DENSE = 600
#: Most names in a message.
SHOWN = 4


class Reason(Enum):
    """Sort of failure; the value is the code of the diagnostic."""

    ERROR_TEST = "R110"
    CONVERGENCE = "R111"
    SINGULAR = "R112"
    TOO_MANY_STEPS = "R113"
    NOT_FINITE = "R114"
    OTHER = "R115"
    EXPLICIT_FORM = "R116"


@dataclass(frozen=True)
class Failure:
    """The facts of a failure.

    Attributes:
        reason: Sort of failure.
        time: Where it stopped, seconds.
        step: Last step size tried, seconds; 0 if unknown.
        unknowns: The unknowns that have to do with it, worst first.
        rows: The rows that have to do with it, worst first.
    """

    reason: Reason
    time: float
    step: float = 0.0
    unknowns: tuple[int, ...] = ()
    rows: tuple[int, ...] = ()


class IntegrationError(AcausalError):
    """A run that cannot go on; :attr:`failure` has the facts for messages with sources."""

    def __init__(self, diagnostics: Iterable[Diagnostic], failure: Failure) -> None:
        """Keep the facts beside the message."""
        super().__init__(diagnostics)
        self.failure = failure

    def __reduce__(  # type: ignore[override]
        self,
    ) -> tuple[type[IntegrationError], tuple[tuple[Diagnostic, ...], Failure]]:
        return (type(self), (self.diagnostics, self.failure))


_MESSAGE = {
    Reason.ERROR_TEST: "no step is small enough for the tolerance",
    Reason.CONVERGENCE: "the equations could not be solved for the next step",
    Reason.SINGULAR: "the equations do not determine all unknowns (singular Jacobian matrix)",
    Reason.TOO_MANY_STEPS: "the limit on the number of steps is reached",
    Reason.NOT_FINITE: "an equation gives a value that is not a finite number",
    Reason.OTHER: "the integrator stopped",
    Reason.EXPLICIT_FORM: "the equations could not be solved for the derivatives",
}

_HELP = {
    Reason.ERROR_TEST: "look for a jump or an unlimited growth there; else try a larger tolerance "
    "or set the nominal values of the variables",
    Reason.CONVERGENCE: "look for a jump, a division by a small number or a function outside its "
    "domain there; else try a smaller tolerance or a smaller maximal step",
    Reason.SINGULAR: "look for a quantity that nothing determines in this position, e.g. a current "
    "in a loop without resistance or a mechanism at a dead centre",
    Reason.TOO_MANY_STEPS: "allow more steps, or simulate a shorter time",
    Reason.NOT_FINITE: "look for a division by zero, a logarithm or root of a negative number, or "
    "an overflow of an exponential",
    Reason.OTHER: "try another solver",
    Reason.EXPLICIT_FORM: "use the solver ida, which needs no explicit form",
}


def integration_error(
    failure: Failure, labels: Labels, notes: Iterable[str] = (), message: str = ""
) -> IntegrationError:
    """Return the error that tells a failure.

    Args:
        failure: The facts.
        labels: Names of unknowns and rows.
        notes: More facts.
        message: Instead of the usual sentence.
    """
    told = []
    if failure.unknowns:
        names = ", ".join(labels.unknown(k) for k in failure.unknowns[:SHOWN])
        told.append(f"variables concerned: {names}")
    if failure.rows:
        names = "; ".join(labels.row(k) for k in failure.rows[:SHOWN])
        told.append(f"equations concerned: {names}")
    if failure.step > 0.0:
        told.append(f"step size: {failure.step:.3g} s")
    diagnostic = Diagnostic(
        failure.reason.value,
        f"{message or _MESSAGE[failure.reason]} at time {failure.time:.9g} s",
        notes=(*told, *notes),
        help=_HELP[failure.reason],
    )
    return IntegrationError([diagnostic], failure)


def largest(weights: Array) -> tuple[int, ...]:
    """Return the positions of the largest magnitudes, at most :data:`SHOWN`, largest first.

    Only those within a factor of ten of the largest count; NaN comes first.
    """
    magnitude = np.where(np.isnan(weights), np.inf, np.abs(weights))
    order = np.argsort(-magnitude, kind="stable")[:SHOWN]
    if order.size == 0 or magnitude[order[0]] == 0.0:
        return ()
    limit = 0.1 * magnitude[order[0]]
    return tuple(int(k) for k in order if magnitude[k] >= limit or np.isinf(magnitude[k]))


def not_finite_rows(system: NativeSystem, t: float, y: Array, yp: Array) -> tuple[int, ...]:
    """Return the first rows whose residual is not finite at a point."""
    out = np.zeros(system.problem.n)
    system.residual(t, y, yp, out)
    return tuple(int(k) for k in np.flatnonzero(~np.isfinite(out))[:SHOWN])


def singular_parts(
    system: NativeSystem, t: float, cj: float, y: Array, yp: Array
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the unknowns and rows that make dF/dy + cj dF/dy' singular.

    They are the largest entries of the right and left singular vectors of the smallest singular
    value, after scaling rows and columns. Empty if the matrix is regular or too large.
    """
    problem = system.problem
    n = problem.n
    if n > LARGEST_DENSE:
        return _empty_lines(system, t, cj, y, yp)
    values = np.zeros(problem.nnz)
    system.jacobian_values(t, cj, y, yp, values)
    if not np.isfinite(values).all():
        return (), ()
    matrix = np.zeros((n, n))
    columns = np.repeat(np.arange(n), np.diff(problem.indptr))
    np.add.at(matrix, (problem.indices, columns), values)
    row_scale = np.abs(matrix).max(axis=1, initial=0.0)
    matrix /= np.where(row_scale > 0.0, row_scale, 1.0)[:, np.newaxis]
    column_scale = np.abs(matrix).max(axis=0, initial=0.0)
    matrix /= np.where(column_scale > 0.0, column_scale, 1.0)
    left, singular, right = np.linalg.svd(matrix)
    if singular[-1] > 1e-9 * singular[0]:
        return (), ()
    return largest(right[-1]), largest(left[:, -1])


def _empty_lines(
    system: NativeSystem, t: float, cj: float, y: Array, yp: Array
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return columns and rows of a large Jacobian that are numerically zero."""
    problem = system.problem
    values = np.zeros(problem.nnz)
    system.jacobian_values(t, cj, y, yp, values)
    columns = np.repeat(np.arange(problem.n), np.diff(problem.indptr))
    filled = np.abs(values) > 0.0
    column_filled = np.bincount(columns[filled], minlength=problem.n) > 0
    row_filled = np.bincount(problem.indices[filled], minlength=problem.n) > 0
    return (
        tuple(int(k) for k in np.flatnonzero(~column_filled)[:SHOWN]),
        tuple(int(k) for k in np.flatnonzero(~row_filled)[:SHOWN]),
    )
