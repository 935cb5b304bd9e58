"""Flat models by hand, for tests: variables by name, equations as Python expressions."""

from __future__ import annotations

import fnmatch
from collections.abc import Sequence

import numpy as np

from acausal.diagnostics import Span
from acausal.expressions import build
from acausal.expressions.nodes import TIME, Expr, const, slot
from acausal.flattening.model import (
    Assertion,
    EquationFamily,
    FlatModel,
    Operand,
    Origin,
    RowKind,
    StateSelect,
    Variables,
)


class T:
    """A template under construction; ``ids`` of variables or parameters per slot."""

    def __init__(self, expr: Expr) -> None:
        self.expr = expr

    def __add__(self, other):
        return T(build.add(self.expr, of(other)))

    def __radd__(self, other):
        return T(build.add(of(other), self.expr))

    def __sub__(self, other):
        return T(build.sub(self.expr, of(other)))

    def __rsub__(self, other):
        return T(build.sub(of(other), self.expr))

    def __mul__(self, other):
        return T(build.mul(self.expr, of(other)))

    def __rmul__(self, other):
        return T(build.mul(of(other), self.expr))

    def __truediv__(self, other):
        return T(build.div(self.expr, of(other)))

    def __rtruediv__(self, other):
        return T(build.div(of(other), self.expr))

    def __neg__(self):
        return T(build.neg(self.expr))

    def __pow__(self, other):
        return T(build.power(self.expr, of(other)))


def of(value) -> Expr:
    return value.expr if isinstance(value, T) else const(value)


def call(name: str, *args) -> T:
    return T(build.call(name, *map(of, args)))


S = [T(slot(k)) for k in range(16)]
t = T(TIME)


class StubNames:
    """Names from a list."""

    def __init__(self, names: list[str], parameters: list[str]) -> None:
        self.names = names
        self.parameters = parameters

    def variable(self, variable: int) -> str:
        return self.names[variable]

    def parameter(self, parameter: int) -> str:
        return self.parameters[parameter]

    def find_variables(self, pattern: str):
        return [(n, i) for i, n in enumerate(self.names) if fnmatch.fnmatchcase(n, pattern)]

    def find_parameters(self, pattern: str):
        return [(n, i) for i, n in enumerate(self.parameters) if fnmatch.fnmatchcase(n, pattern)]

    def unit(self, variable: int) -> str:
        return ""

    def parameter_unit(self, parameter: int) -> str:
        return ""

    def description(self, variable: int) -> str:
        return ""

    def declaration(self, variable: int) -> Span | None:
        return Span("<test>", variable + 1, 1, variable + 1, 2)

    def instance_path(self, group: int, instance: int) -> str:
        return f"part[{instance}]"

    def all_variables(self):
        return self.names

    def suggestions(self, path: str):
        return []


class LazyNames(StubNames):
    """Names of a model too large to name."""

    def __init__(self) -> None:
        super().__init__([], [])

    def variable(self, variable: int) -> str:
        return f"x{variable}"


class FlatBuilder:
    """Collects variables and equations."""

    def __init__(self, named: bool = True) -> None:
        self.named = named
        self.n = 0
        self.names: list[str] = []
        self.attributes: list[dict] = []
        self.derivatives: list[tuple[np.ndarray, np.ndarray]] = []
        self.values: list[np.ndarray] = []
        self.parameter_names: list[str] = []
        self.p = 0
        self.families: list[EquationFamily] = []
        self.initials: list[EquationFamily] = []
        self.assertions: list[Assertion] = []
        self.rows = 0
        self.initial_rows = 0

    def variables(self, name: str, count: int, **attributes) -> np.ndarray:
        ids = np.arange(self.n, self.n + count)
        self.n += count
        if self.named:
            self.names += [f"{name}[{k}]" if count > 1 else name for k in range(count)]
        self.attributes.append({"ids": ids, **attributes})
        return ids

    def variable(self, name: str, **attributes) -> int:
        return int(self.variables(name, 1, **attributes)[0])

    def der(self, x) -> np.ndarray:
        x = np.atleast_1d(x)
        ids = np.arange(self.n, self.n + x.size)
        self.n += x.size
        if self.named:
            self.names += [f"der({self.names[i]})" for i in x]
        self.derivatives.append((x, ids))
        return ids if ids.size > 1 else int(ids[0])

    def parameter(self, name: str, value) -> np.ndarray:
        value = np.atleast_1d(np.asarray(value, dtype=float))
        ids = np.arange(self.p, self.p + value.size)
        self.p += value.size
        self.values.append(value)
        if self.named:
            self.parameter_names += [name] * value.size
        return ids

    def _family(self, template, operands, rows, text, kind, parameters):
        columns = [np.atleast_1d(o) for o in operands]
        count = max([len(np.atleast_1d(rows)), *map(len, columns)])
        ids = np.array([np.broadcast_to(c, count) for c in columns], dtype=np.int64)
        ids = ids.reshape(len(columns), count)
        kinds = tuple(
            Operand.PARAMETER if k in parameters else Operand.VARIABLE for k in range(len(columns))
        )
        span = Span("<test>", len(self.families) + 1, 1, len(self.families) + 1, 2)
        origin = Origin(0, count, kind, span, text, "Test", 0, np.arange(count))
        return EquationFamily(
            of(template), kinds, ids, np.broadcast_to(rows, count).astype(np.int64), (origin,)
        )

    def equation(
        self, template, *operands, parameters: Sequence[int] = (), text="", rows=None
    ) -> np.ndarray:
        """Add ``template = 0`` for all members; returns its rows."""
        count = max([1, *(np.atleast_1d(o).size for o in operands)])
        if rows is None:
            rows = np.arange(self.rows, self.rows + count)
            self.rows += count
        kind = RowKind.DECLARED
        self.families.append(self._family(template, operands, rows, text, kind, parameters))
        return np.asarray(rows)

    def new_rows(self, count: int) -> np.ndarray:
        self.rows += count
        return np.arange(self.rows - count, self.rows)

    def contribution(self, rows, variables, sign=1) -> None:
        """Add ``sign * variables`` to junction rows."""
        template = S[0] if sign == 1 else -S[0]
        family = self._family(template, [variables], rows, "junction", RowKind.JUNCTION, ())
        self.families.append(family)

    def junction(self, *through, signs=None) -> int:
        row = self.new_rows(1)
        for k, variable in enumerate(through):
            self.contribution(row, variable, signs[k] if signs else 1)
        return int(row[0])

    def initial(self, template, *operands, parameters=(), text="") -> None:
        count = max([1, *(np.atleast_1d(o).size for o in operands)])
        rows = np.arange(self.initial_rows, self.initial_rows + count)
        self.initial_rows += count
        kind = RowKind.INITIAL
        self.initials.append(self._family(template, operands, rows, text, kind, parameters))

    def assertion(self, template, *operands, message="broken") -> None:
        family = self._family(template, operands, np.arange(1), "", RowKind.DECLARED, ())
        self.assertions.append(Assertion(family, message, False))

    def build(self, name: str = "test") -> FlatModel:
        n = self.n
        start, nominal = np.zeros(n), np.ones(n)
        given, fixed = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)
        low, high = np.full(n, -np.inf), np.full(n, np.inf)
        select = np.full(n, StateSelect.DEFAULT, dtype=np.int8)
        for a in self.attributes:
            ids = a["ids"]
            if "start" in a:
                start[ids] = a["start"]
                given[ids] = True
            fixed[ids] = a.get("fixed", False)
            nominal[ids] = a.get("nominal", 1.0)
            low[ids], high[ids] = a.get("minimum", -np.inf), a.get("maximum", np.inf)
            select[ids] = a.get("select", StateSelect.DEFAULT)
        derivative = np.full(n, -1, dtype=np.int64)
        for x, d in self.derivatives:
            derivative[x] = d
        return FlatModel(
            name=name,
            description="",
            variables=Variables(start, given, fixed, nominal, low, high, select),
            derivative=derivative,
            parameters=np.concatenate([*self.values, np.zeros(0)]),
            families=tuple(self.families),
            n_rows=self.rows,
            initial=tuple(self.initials),
            n_initial=self.initial_rows,
            assertions=tuple(self.assertions),
            names=StubNames(self.names, self.parameter_names) if self.named else LazyNames(),
        )


class OnePorts:
    """``count`` two-pin components: v = p.v - n.v, p.i + n.i = 0, i = p.i."""

    def __init__(self, b: FlatBuilder, name: str, count: int, **v_attributes) -> None:
        self.p_v = b.variables(f"{name}.p.v", count)
        self.p_i = b.variables(f"{name}.p.i", count)
        self.n_v = b.variables(f"{name}.n.v", count)
        self.n_i = b.variables(f"{name}.n.i", count)
        self.v = b.variables(f"{name}.v", count, **v_attributes)
        self.i = b.variables(f"{name}.i", count)
        b.equation(S[0] - (S[1] - S[2]), self.v, self.p_v, self.n_v, text="v = p.v - n.v")
        b.equation(S[0] + S[1], self.p_i, self.n_i, text="p.i + n.i = 0")
        b.equation(S[0] - S[1], self.i, self.p_i, text="i = p.i")


def ladder(sections: int, named: bool = False) -> FlatModel:
    """R and L in series, C, diode and conductor to ground in each section; a sine source."""
    b = FlatBuilder(named)
    r, ind, c, d, g = (OnePorts(b, name, sections) for name in "RLCDG")
    one = np.ones(sections)
    R, L, C = b.parameter("R", one), b.parameter("L", 1e-6 * one), b.parameter("C", 1e-6 * one)
    Is, G = b.parameter("Is", 1e-9 * one), b.parameter("G", 0.05 * one)
    b.equation(S[0] - S[1] * S[2], r.v, R, r.i, parameters=[1], text="v = R*i")
    b.equation(S[0] * S[1] - S[2], L, b.der(ind.i), ind.v, parameters=[0], text="L*der(i) = v")
    b.equation(S[0] - S[1] * S[2], c.i, C, b.der(c.v), parameters=[1], text="i = C*der(v)")
    diode = S[0] - S[1] * (call("exp", S[2] / 0.05) - 1)
    b.equation(diode, d.i, Is, d.v, parameters=[1], text="i = Is*(exp(v/Vt) - 1)")
    b.equation(S[0] - S[1] * S[2], g.i, G, g.v, parameters=[1], text="i = G*v")
    source = OnePorts(b, "source", 1)
    b.equation(S[0] - call("sin", 6283.185307179586 * t), source.v, text="v = sin(w*time)")
    ground_v, ground_i = b.variable("ground.p.v"), b.variable("ground.p.i")
    b.equation(S[0], ground_v, text="p.v = 0")
    # across: a chain of equalities at every junction
    b.equation(S[0] - S[1], r.n_v, ind.p_v)
    b.equation(S[0] - S[1], ind.n_v, c.p_v)
    b.equation(S[0] - S[1], c.p_v, d.p_v)
    b.equation(S[0] - S[1], d.p_v, g.p_v)
    if sections > 1:
        b.equation(S[0] - S[1], g.p_v[:-1], r.p_v[1:])
    b.equation(S[0] - S[1], source.p_v, r.p_v[:1])
    for grounded in (c.n_v, d.n_v, g.n_v, source.n_v):
        b.equation(S[0] - S[1], grounded, ground_v)
    # through
    middle, out = b.new_rows(sections), b.new_rows(sections)
    b.contribution(middle, r.n_i)
    b.contribution(middle, ind.p_i)
    for current in (ind.n_i, c.p_i, d.p_i, g.p_i):
        b.contribution(out, current)
    if sections > 1:
        b.contribution(out[:-1], r.p_i[1:])
    first, ground = b.new_rows(1), b.new_rows(1)
    b.contribution(first, source.p_i)
    b.contribution(first, r.p_i[:1])
    for current in (c.n_i, d.n_i, g.n_i, source.n_i):
        b.contribution(np.broadcast_to(ground, current.shape), current)
    b.contribution(ground, ground_i)
    return b.build("ladder")
