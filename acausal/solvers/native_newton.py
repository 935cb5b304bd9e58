"""Newton's method for a consistent restart as a native function, with a dense LU of its own.

The matrix is small and dense enough that a factorisation costs less than a call from Python.
Rows and columns are scaled first; partial pivoting as in Golub and Van Loan, Matrix Computations,
section 3.4. The matrix is kept for the next iteration while it still does its work.
"""

from __future__ import annotations

from enum import IntEnum, auto
from functools import cache
from hashlib import blake2b
from typing import Final

import numpy as np

from acausal.codegen.writer import Function, Value, module

#: A correction is small enough relative to the values.
TOLERANCE = 1e-10
#: Values count as at least this share of their nominal values.
SHARE = 1e-3
ITERATIONS = 16
#: The matrix is kept while a correction is so much smaller than the one before.
KEEP = 1e-3
#: Pivots of the scaled matrix below this are zero.
SMALLEST_PIVOT = 1e-14
#: A residual is roundoff below so many units of the sum of its terms.
ROUNDOFF_UNITS = 64.0
#: A correction that does not become smaller any more may be so large.
STAGNATION = 1e-7
_UNIT_ROUNDOFF: Final = float(np.finfo(float).eps)


class Field(IntEnum):
    """Positions in the table of the function."""

    RESIDUAL = 0
    JACOBIAN = auto()  #: the restart Jacobian
    TABLE = auto()
    N = auto()
    NNZ = auto()
    Y = auto()
    YP = auto()
    NOMINAL = auto()
    DIFFERENTIAL = auto()  #: 1.0 or 0.0
    ROWS = auto()  #: row of each entry, int64
    COLUMNS = auto()  #: column of each entry, int64
    VALUES = auto()
    MATRIX = auto()
    PIVOTS = auto()
    ROW_SCALE = auto()
    COLUMN_SCALE = auto()
    R = auto()  #: residual
    D = auto()  #: correction
    TERMS = auto()  #: sum of magnitudes of each row
    COUNT = auto()


def _get(f: Function, field: Field, kind: str = "ptr") -> Value:
    return f.load(f["table"], int(field), kind)


def _factorise() -> Function:
    """Scatter the values, scale, factorise; return 0, or 1 if singular or not finite."""
    f = Function("newton_factorise", "i32", internal=True, table="ptr")
    n, nnz = _get(f, Field.N, "i64"), _get(f, Field.NNZ, "i64")
    rows, columns = _get(f, Field.ROWS), _get(f, Field.COLUMNS)
    values, a = _get(f, Field.VALUES), _get(f, Field.MATRIX)
    row_scale, column_scale = _get(f, Field.ROW_SCALE), _get(f, Field.COLUMN_SCALE)
    pivots = _get(f, Field.PIVOTS)
    f.clear(a, n * n)
    f.clear(row_scale, n)
    f.clear(column_scale, n)
    with f.loop(nnz) as k:
        row, size = f.load(rows, k, "i64"), f.abs(f.load(values, k))
        with f.when(~(size < float("inf"))):
            f.give(1)
        f.store(row_scale, row, f.larger(size, f.load(row_scale, row)))
    with f.loop(n) as i:
        most = f.load(row_scale, i)
        with f.when(most.equals(0.0)):
            f.give(1)
        f.store(row_scale, i, 1.0 / most)
    with f.loop(nnz) as k:
        row, column = f.load(rows, k, "i64"), f.load(columns, k, "i64")
        size = f.abs(f.load(values, k) * f.load(row_scale, row))
        f.store(column_scale, column, f.larger(size, f.load(column_scale, column)))
    with f.loop(n) as j:
        most = f.load(column_scale, j)
        with f.when(most.equals(0.0)):
            f.give(1)
        f.store(column_scale, j, 1.0 / most)
    with f.loop(nnz) as k:
        row, column = f.load(rows, k, "i64"), f.load(columns, k, "i64")
        scaled = f.load(values, k) * f.load(row_scale, row) * f.load(column_scale, column)
        f.store(a, column * n + row, scaled)
    with f.loop(n) as k:
        column = f.at(a, k * n)
        place, most = f.variable("i64", k), f.variable("double", -1.0)
        with f.loop(n, k) as i:
            size = f.abs(f.load(column, i))
            with f.when(size > most):
                most.set(size)
                place.set(i)
        with f.when(~(most > SMALLEST_PIVOT)):
            f.give(1)
        f.store(pivots, k, place, "i64")
        with f.when(place.differs(k)), f.loop(n) as j:
            line = f.at(a, j * n)
            above, below = f.load(line, k), f.load(line, place.read())
            f.store(line, k, below)
            f.store(line, place.read(), above)
        inverse = 1.0 / f.load(column, k)
        with f.loop(n, k + 1) as i:
            f.store(column, i, f.load(column, i) * inverse)
        with f.loop(n, k + 1) as j:
            line = f.at(a, j * n)
            factor = f.load(line, k)
            with f.when(factor.differs(0.0)), f.loop(n, k + 1) as i:
                f.store(line, i, f.load(line, i) - f.load(column, i) * factor)
    f.give(0)
    return f


def _solve() -> Function:
    """Write the correction that belongs to the residual."""
    f = Function("newton_solve", "void", internal=True, table="ptr")
    n, a, pivots = _get(f, Field.N, "i64"), _get(f, Field.MATRIX), _get(f, Field.PIVOTS)
    r, d = _get(f, Field.R), _get(f, Field.D)
    row_scale, column_scale = _get(f, Field.ROW_SCALE), _get(f, Field.COLUMN_SCALE)
    with f.loop(n) as i:
        f.store(d, i, f.load(r, i) * f.load(row_scale, i))
    with f.loop(n) as k:
        place = f.load(pivots, k, "i64")
        above, below = f.load(d, k), f.load(d, place)
        f.store(d, place, above)
        f.store(d, k, below)
    with f.loop(n) as k:
        column, x = f.at(a, k * n), f.load(d, k)
        with f.loop(n, k + 1) as i:
            f.store(d, i, f.load(d, i) - f.load(column, i) * x)
    with f.loop(n) as turn:
        k = n - 1 - turn
        column = f.at(a, k * n)
        x = f.load(d, k) / f.load(column, k)
        f.store(d, k, x)
        with f.loop(k) as i:
            f.store(d, i, f.load(d, i) - f.load(column, i) * x)
    with f.loop(n) as j:
        f.store(d, j, f.load(d, j) * f.load(column_scale, j))
    f.give()
    return f


def _unknown(f: Function, j: Value) -> tuple[Value, Value]:
    """Return the place of an unknown of the restart and its value."""
    state = f.load(_get(f, Field.DIFFERENTIAL), j) > 0.0
    base = f.select(state, _get(f, Field.YP), _get(f, Field.Y))
    return f.at(base, j), f.load(base, j)


def _roundoff() -> Function:
    """Return 1 if every residual is as small as the roundoff of its terms."""
    f = Function("newton_roundoff", "i32", internal=True, table="ptr")
    n, nnz = _get(f, Field.N, "i64"), _get(f, Field.NNZ, "i64")
    terms, values, r = _get(f, Field.TERMS), _get(f, Field.VALUES), _get(f, Field.R)
    f.clear(terms, n)
    with f.loop(nnz) as k:
        row = f.load(_get(f, Field.ROWS), k, "i64")
        _, value = _unknown(f, f.load(_get(f, Field.COLUMNS), k, "i64"))
        f.store(terms, row, f.load(terms, row) + f.abs(f.load(values, k) * value))
    with f.loop(n) as i:
        limit = f.load(terms, i) * (ROUNDOFF_UNITS * _UNIT_ROUNDOFF)
        with f.when(~(f.abs(f.load(r, i)) <= limit)):
            f.give(0)
    f.give(1)
    return f


def _newton() -> Function:
    """Iterate; return the number of iterations or -1."""
    f = Function("acausal_newton", "i32", t="double", table="ptr")
    n = _get(f, Field.N, "i64")
    y, yp, r, d = (_get(f, k) for k in (Field.Y, Field.YP, Field.R, Field.D))
    nominal, inner = _get(f, Field.NOMINAL), _get(f, Field.TABLE)
    last, norm = f.variable("double", float("inf")), f.variable("double", 0.0)
    new, count = f.variable("i64", 1), f.variable("i32", 0)
    renewed = f.variable("i64", 0)
    with f.while_(lambda: count < ITERATIONS):
        renewed.set(new)
        with f.when(new.differs(0)):
            jacobian, values = _get(f, Field.JACOBIAN), _get(f, Field.VALUES)
            with f.when(f.call("i32", jacobian, f["t"], y, yp, values, inner).differs(0)):
                f.give(-1)
            with f.when(f.call("i32", "newton_factorise", f["table"]).differs(0)):
                f.give(-1)
        count.set(count + 1)
        residual = _get(f, Field.RESIDUAL)
        with f.when(f.call("i32", residual, f["t"], y, yp, r, inner).differs(0)):
            f.give(-1)
        f.call("void", "newton_solve", f["table"])
        norm.set(0.0)
        with f.loop(n) as j:
            _, value = _unknown(f, j)
            size = f.larger(f.abs(value), f.load(nominal, j) * SHARE)
            share = f.abs(f.load(d, j)) / size
            with f.when(~(share < float("inf"))):
                f.give(-1)
            norm.set(f.larger(share, norm))
        old_matrix_fails = renewed.equals(0) & (norm > 0.5 * last.read())
        stagnates = norm > 0.1 * last.read()
        with f.when(~old_matrix_fails | (norm <= STAGNATION)):
            with f.loop(n) as j:
                place, value = _unknown(f, j)
                f.store(place, 0, value - f.load(d, j))
            with f.when(norm <= TOLERANCE):
                f.give(count)
            with f.when(stagnates & (count >= 4) & (norm <= STAGNATION)):
                f.give(count)
            with f.when(stagnates & (count >= 2)):
                roundoff = f.call("i32", "newton_roundoff", f["table"]).differs(0)
                with f.when(roundoff):
                    f.give(count)
        new.set(f.select(norm > KEEP * last.read(), f.operand(1, "i64"), 0))
        last.set(norm)
    f.give(-1)
    return f


@cache
def address() -> int:
    """Return the address of ``i32 newton(double t, void* table)``, compiled once per machine."""
    from acausal.codegen import engine
    from acausal.storage import cache_directory

    text = module(_factorise(), _solve(), _roundoff(), _newton())
    key = blake2b(f"{engine.target_identity()}\n{text}".encode(), digest_size=16).hexdigest()
    code = cache_directory.read("solver", key)
    if code is None:
        code = engine.compile_object(text, level=2, passes=True)
        cache_directory.write("solver", key, code)
    engine.load_objects([code])
    return engine.address_of("acausal_newton")
