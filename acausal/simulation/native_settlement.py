"""The usual course of an event in one native call: rounds of turns until everything agrees.

The same as :meth:`EventIteration._rounds`, as far as that goes without anything unusual. Where
reinits act, the continuous equations have no nearby solution or the turns go on and on, it stops
and says so; the values are as they were at that point, and Python goes on from there.
"""

from __future__ import annotations

import ctypes
from enum import IntEnum
from functools import cache
from hashlib import blake2b
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from acausal.codegen import engine, sequence
from acausal.codegen.writer import Function, Value, module
from acausal.storage import cache_directory

if TYPE_CHECKING:
    from acausal.flattening.model import Ids
    from acausal.simulation.event_kernels import EventKernels
    from acausal.solvers.consistent_point import NativePoint

Array = NDArray[np.float64]

#: Rounds and turns before Python looks at what is going on.
ROUNDS, TURNS = 20, 10


class Outcome(IntEnum):
    """How far it went."""

    SETTLED = 0
    REINIT = 1  # reinits act, once this round is settled
    UNUSUAL = 2  # this round goes on in Python


class _Word(IntEnum):
    SEQUENCE = 0
    UPDATE = 1
    HOLD = 2
    ASSIGN = 3
    LIMITS = 4
    FIRES = 5
    REINITS = 6
    ACTING = 7
    HELD = 8
    DISCRETE = 9
    RELATIONS = 10
    WANTED = 11
    PRESENT = 12
    RELEVANT_COUNT = 13
    RELEVANT = 14
    KNOWN = 15
    BEFORE = 16
    RESTS = 17
    AT_REST = 18
    SUPPORTED = 19
    POINT = 20
    POINT_TABLE = 21
    POINT_Y = 22
    POINT_YP = 23
    N = 24
    Y = 25
    YP = 26
    SHOWN_Y = 27
    SHOWN_YP = 28
    SOLVED = 29


class _Table:
    """Words of the table, in a function under construction."""

    def __init__(self, f: Function) -> None:
        self.f = f

    def __getitem__(self, word: _Word) -> Value:
        return self.f.load(self.f["table"], int(word), "i64")

    def pointer(self, word: _Word) -> Value:
        return self.f.load(self.f["table"], int(word), "ptr")

    def run(self, word: _Word) -> None:
        """Run a sequence."""
        self.f.call("void", self.pointer(_Word.SEQUENCE), self.pointer(word))

    def differ(self, a: Value, b: Value, count: Value) -> Value:
        """Return whether two arrays differ (or are not numbers)."""
        f = self.f
        found = f.variable("i64", 0)
        with f.loop(count) as k, f.when(f.load(a, k).differs(f.load(b, k))):
            found.set(1)
        return found


def _solve() -> Function:
    """Solve the continuous equations; not zero if that fails."""
    f = Function("settle_solve", "i32", internal=True, time="double", table="ptr")
    t = _Table(f)
    n, y, yp = t[_Word.N], t.pointer(_Word.Y), t.pointer(_Word.YP)
    inner_y, inner_yp = t.pointer(_Word.POINT_Y), t.pointer(_Word.POINT_YP)
    f.copy(inner_y, y, n)
    f.copy(inner_yp, yp, n)
    with f.when(f.call("i32", t.pointer(_Word.POINT), f["time"], t.pointer(_Word.POINT_TABLE)) < 0):
        f.give(1)
    for source, targets in (
        (inner_y, (y, t.pointer(_Word.SHOWN_Y))),
        (inner_yp, (yp, t.pointer(_Word.SHOWN_YP))),
    ):
        for target in targets:
            f.copy(target, source, n)
    relevant, known = t.pointer(_Word.RELEVANT), t.pointer(_Word.KNOWN)
    with f.loop(t[_Word.RELEVANT_COUNT]) as k:
        f.store(known, k, f.load(t.pointer(_Word.HELD), f.load(relevant, k, "i64")))
    f.store(f["table"], int(_Word.SOLVED), 1, "i64")
    f.give(0)
    return f


def _turn() -> Function:
    """Bring one round into agreement; return an outcome."""
    f = Function("settle_round", "i64", internal=True, time="double", table="ptr")
    t = _Table(f)
    held, n = t.pointer(_Word.HELD), t[_Word.DISCRETE]
    turn = f.variable("i64", 0)
    with f.while_(lambda: turn < TURNS):
        turn.set(turn + 1)
        t.run(_Word.UPDATE)
        relations = t[_Word.RELATIONS]
        wanted, present = t.pointer(_Word.WANTED), t.pointer(_Word.PRESENT)
        changed = f.variable("i64", t.differ(wanted, present, relations))
        with f.when(changed.differs(0)):
            t.run(_Word.HOLD)
        with f.loop(t[_Word.RESTS]) as k:
            at_rest = f.load(held, f.load(t.pointer(_Word.AT_REST), k, "i64"))
            supported = f.load(held, f.load(t.pointer(_Word.SUPPORTED), k, "i64"))
            with f.when((at_rest > 0.0) & supported.equals(0.0)):
                f.give(int(Outcome.UNUSUAL))
        before = t.pointer(_Word.BEFORE)
        f.copy(before, held, n)
        t.run(_Word.ASSIGN)
        with f.when(t.differ(before, held, n).differs(0)):
            changed.set(1)
        renewed = f.variable("i64", 0)
        relevant, known = t.pointer(_Word.RELEVANT), t.pointer(_Word.KNOWN)
        with f.loop(t[_Word.RELEVANT_COUNT]) as k:
            value = f.load(held, f.load(relevant, k, "i64"))
            with f.when(value.differs(f.load(known, k))):
                renewed.set(1)
        with f.when(renewed.differs(0)):
            failed = f.call("i32", "settle_solve", f["time"], f["table"])
            with f.when(failed.differs(0)):
                f.give(int(Outcome.UNUSUAL))
        with f.when(renewed.equals(0) & changed.equals(0)):
            f.give(int(Outcome.SETTLED))
    f.give(int(Outcome.UNUSUAL))
    return f


def _settle() -> Function:
    f = Function("acausal_settle", "i64", time="double", table="ptr")
    t = _Table(f)
    held, n = t.pointer(_Word.HELD), t[_Word.DISCRETE]
    pre = f.at(held, n)
    round_ = f.variable("i64", 0)
    with f.while_(lambda: round_ < ROUNDS):
        round_.set(round_ + 1)
        outcome = f.call("i64", "settle_round", f["time"], f["table"])
        with f.when(outcome.differs(0)):
            f.give(outcome)
        count = t[_Word.REINITS]
        with f.when(count > 0):
            t.run(_Word.FIRES)
            with f.loop(count) as k, f.when(f.load(t.pointer(_Word.ACTING), k).differs(0.0)):
                f.give(int(Outcome.REINIT))
        with f.when(t.differ(pre, held, n).equals(0)):
            f.give(int(Outcome.SETTLED))
        with f.loop(n) as k, f.when(~(f.abs(f.load(held, k)) < float("inf"))):
            f.give(int(Outcome.UNUSUAL))
        f.copy(pre, held, n)
        t.run(_Word.LIMITS)
    f.give(int(Outcome.UNUSUAL))
    return f


@cache
def _load() -> int:
    """Load the function, compiled by the first program on this machine that needs it."""
    text = module(_solve(), _turn(), _settle())
    identity = f"{engine.target_identity()}\n{text}"
    key = "settle_" + blake2b(identity.encode(), digest_size=16).hexdigest()
    code = cache_directory.read("kernel", key)
    if code is None:
        code = engine.compile_object(text, level=2, passes=True)
        cache_directory.write("kernel", key, code)
    engine.load_objects([code])
    return engine.address_of("acausal_settle")


class NativeSettlement:
    """Settles events of one layout."""

    def __init__(
        self,
        kernels: EventKernels,
        relevant: Ids,
        known: Array,
        rests: tuple[Ids, Ids],
        point: NativePoint,
        y: tuple[Array, Array],
        shown: tuple[Array, Array],
    ) -> None:
        """Bind the arrays; they are kept alive and must not be replaced, only changed.

        Args:
            kernels: The discrete equations.
            relevant: Held positions that the continuous equations read.
            known: What they were at the last solution; kept up to date.
            rests: Held positions of rests, and of their supports.
            point: The continuous equations.
            y: Unknowns and their derivatives, each of shape ``(n,)``.
            shown: The same in the work vector.
        """
        states, n = kernels.states, kernels.hybrid.n_discrete
        before = np.zeros(n)
        integers = [np.ascontiguousarray(a, np.int64) for a in (relevant, *rests)]
        self._kept = (kernels, point, known, y, shown, before, integers)
        table = np.zeros(len(_Word), np.int64)
        update, hold, assign, limits, fires = kernels.addresses()
        values: dict[_Word, int] = {
            _Word.SEQUENCE: sequence.address(),
            _Word.UPDATE: update,
            _Word.HOLD: hold,
            _Word.ASSIGN: assign,
            _Word.LIMITS: limits,
            _Word.FIRES: fires,
            _Word.REINITS: len(kernels.fires),
            _Word.ACTING: kernels.fires.ctypes.data,
            _Word.HELD: kernels.held.ctypes.data,
            _Word.DISCRETE: n,
            _Word.RELATIONS: len(states.held),
            _Word.WANTED: states.wanted.ctypes.data,
            _Word.PRESENT: states.held.ctypes.data,
            _Word.RELEVANT_COUNT: len(relevant),
            _Word.RELEVANT: integers[0].ctypes.data,
            _Word.KNOWN: known.ctypes.data,
            _Word.BEFORE: before.ctypes.data,
            _Word.RESTS: len(rests[0]),
            _Word.AT_REST: integers[1].ctypes.data,
            _Word.SUPPORTED: integers[2].ctypes.data,
            _Word.POINT: point.function,
            _Word.POINT_TABLE: point.table,
            _Word.POINT_Y: point.y,
            _Word.POINT_YP: point.yp,
            _Word.N: len(y[0]),
            _Word.Y: y[0].ctypes.data,
            _Word.YP: y[1].ctypes.data,
            _Word.SHOWN_Y: shown[0].ctypes.data,
            _Word.SHOWN_YP: shown[1].ctypes.data,
        }
        for word, value in values.items():
            table[word] = value
        self._table = table
        self._argument = ctypes.c_void_p(table.ctypes.data)
        # PYFUNCTYPE keeps the interpreter's lock: giving it up costs more than the call.
        kind = ctypes.PYFUNCTYPE(ctypes.c_int64, ctypes.c_double, ctypes.c_void_p)
        self._function = kind(_load())

    def settle(self, time: float) -> int:
        """Go as far as possible; return an :class:`Outcome`."""
        self._table[_Word.SOLVED] = 0
        outcome: int = self._function(time, self._argument)
        return outcome

    @property
    def solved(self) -> bool:
        """Whether the continuous equations were solved in the last call."""
        return bool(self._table[_Word.SOLVED])
