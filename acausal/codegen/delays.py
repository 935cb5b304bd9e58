"""Delayed values: entries of the work vector that are read from a history.

Before every evaluation of a residual, a Jacobian or root functions, ``w[position_k]`` becomes
``e_k(t - T_k)``, where the history of ``e_k`` holds its values and slopes at the accepted steps. In
between it is the cubic Hermite polynomial (Hairer, Norsett, Wanner, Solving Ordinary Differential
Equations I, section II.17, on delay equations by continuous methods); before the first entry
the history is constant, after the last one it is a straight line.

A jump is two entries at one time. An integration arrives at it from the left and needs the
values before the jump; the restart that follows needs those after it: see ``DelayTable.right``.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import cache
from hashlib import blake2b
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from acausal.codegen import engine
from acausal.codegen.kernels import Kernel
from acausal.codegen.writer import Function, Value, module
from acausal.storage import cache_directory

Array = NDArray[np.float64]

#: Fields of the table.
FIELDS: Final = (
    "count", "positions", "delays", "times", "values", "slopes", "length", "right",
    "call_count", "calls",
)  # fmt: skip
#: Fields of the record of a call that computes delays: the kernel's residual, which adds.
_RECORD: Final = ("kernel", "count", "index", "target")
#: Entries of a new history.
_CAPACITY: Final = 64
#: Times nearer than so many units of roundoff are one time.
_SAME_TIME: Final = 8.0 * float(np.finfo(float).eps)
_FUNCTION: Final = ctypes.PYFUNCTYPE(None, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p)


class _KernelCall(Protocol):
    """What is read of ``acausal.assembly.problem.KernelCall``, a later stage."""

    @property
    def kernel(self) -> Kernel: ...
    @property
    def index(self) -> NDArray[np.int32]: ...
    @property
    def target(self) -> NDArray[np.int32]: ...


def delay_function(name: str = "acausal_delays") -> Function:
    """Return ``void name(double t, double* w, void* table)``."""
    f = Function(name, "void", t="double", w="ptr", table="ptr")

    def get(name: str, kind: str = "ptr") -> Value:
        return f.load(f["table"], FIELDS.index(name), kind)

    t, w, count = f["t"], f["w"], get("count", "i64")
    positions, delays = get("positions"), get("delays")
    times, values, slopes = get("times"), get("values"), get("slopes")
    length, right = get("length", "i64"), get("right", "i64").differs(0)
    calls = get("call_count", "i64")
    with f.when(calls > 0):
        f.clear(delays, count)
    with f.loop(calls) as i:
        record = f.at(get("calls"), i * len(_RECORD), "i64")
        kernel, index, target = (f.load(record, k, "ptr") for k in (0, 2, 3))
        f.call("void", kernel, f.load(record, 1, "i64"), w, index, target, delays)
    with f.when(length > 0), f.loop(count) as k:
        delay = f.load(delays, k)
        s = t - delay
        same = (f.abs(t) + f.abs(delay)) * _SAME_TIME
        # The first entry after s; entries at s count as before it for the values on the right.
        limit = f.select(right, s + same, s - same)
        low, high = f.variable("i64", 0), f.variable("i64", length)
        with f.while_(lambda low=low, high=high: low < high):  # type: ignore[misc]
            middle = f.half(low + high)
            before = f.load(times, middle) <= limit
            high.set(f.select(before, high.read(), middle))
            low.set(f.select(before, middle + 1, low.read()))
        last = low - 1
        result = f.variable("double", f.load(values, k))
        with f.when(last >= 0):
            at = last * count + k
            start, value, slope = f.load(times, last), f.load(values, at), f.load(slopes, at)
            with f.when(low >= length):
                result.set(value + slope * (s - start))
            with f.when(low < length):
                after = at + count
                h = f.load(times, low.read()) - start
                x = (s - start) / h
                y = 1.0 - x
                end, end_slope = f.load(values, after), f.load(slopes, after)
                bend = y * (slope * h - (end - value)) - x * (end_slope * h - (end - value))
                result.set(value + x * (end - value) + x * y * bend)
        f.store(w, f.wide(f.load(positions, k, "i32")), result)
    return f


@cache
def _load() -> int:
    text = module(delay_function("acausal_delay_values"))
    identity = engine.target_identity() + text
    key = "delays_" + blake2b(identity.encode(), digest_size=16).hexdigest()
    code = cache_directory.read("kernel", key)
    if code is None:
        code = engine.compile_object(text, level=2, passes=True)
        cache_directory.write("kernel", key, code)
    engine.load_objects([code])
    return engine.address_of("acausal_delay_values")


class DelayTable:
    """Histories of delayed expressions and where their values are wanted.

    Attributes:
        count: Number of delayed values.
        delays: The delays, seconds, shape ``(count,)``; to be set in place unless kernels
            compute them.
        maxima: The largest delays, seconds, shape ``(count,)``; older entries are forgotten.
    """

    def __init__(
        self,
        positions: NDArray[np.int32],
        maxima: Array,
        calls: Sequence[_KernelCall] = (),
    ) -> None:
        """Begin with empty histories; until the first entry ``w`` is left as it is.

        Args:
            positions: Where in ``w`` the delayed values are wanted, shape ``(count,)``.
            maxima: The largest delays, seconds; also the delays if there are no kernels.
            calls: Kernels that compute the delays from ``w``; ``target`` holds numbers of delayed
                values, each of them once in all calls together. They do not see the delayed
                values of the same time.
        """
        self.positions = np.ascontiguousarray(positions, np.int32)
        self.count = count = self.positions.size
        self.maxima = np.array(maxima, dtype=np.float64)
        self.delays = self.maxima.copy()
        self._calls = tuple(calls)
        self._records = np.array(
            [
                (c.kernel.residual, c.target.size, c.index.ctypes.data, c.target.ctypes.data)
                for c in self._calls
            ],
            np.int64,
        ).reshape(-1, len(_RECORD))
        targets = np.concatenate([np.zeros(0, np.int32), *(c.target for c in self._calls)])
        if self._calls and not np.array_equal(np.sort(targets), np.arange(count)):
            raise ValueError("every delay needs exactly one kernel")
        self._length = 0
        self._table = np.zeros(len(FIELDS), np.int64)
        self._set(
            count=count, positions=self.positions.ctypes.data, delays=self.delays.ctypes.data,
            call_count=len(self._calls), calls=self._records.ctypes.data,
        )  # fmt: skip
        self._allocate(_CAPACITY)
        self.address = int(self._table.ctypes.data)
        self._function = _FUNCTION(_load())

    def _set(self, **values: int) -> None:
        for name, value in values.items():
            self._table[FIELDS.index(name)] = value

    def _allocate(self, capacity: int) -> None:
        self._times = np.zeros(capacity)
        self._values = np.zeros((capacity, self.count))
        self._slopes = np.zeros((capacity, self.count))
        self._set(
            times=self._times.ctypes.data, values=self._values.ctypes.data,
            slopes=self._slopes.ctypes.data,
        )  # fmt: skip

    @property
    def right(self) -> bool:
        """Whether the value at a jump is that after it; False (before it) at first."""
        return bool(self._table[FIELDS.index("right")])

    @right.setter
    def right(self, value: bool) -> None:
        self._set(right=int(value))

    def __len__(self) -> int:
        """Return the number of entries."""
        return self._length

    @property
    def last_time(self) -> float:
        """Time of the last entry, seconds; -inf without one."""
        return float(self._times[self._length - 1]) if self._length else -np.inf

    def take(self, other: DelayTable) -> None:
        """Go on with the history of another table of as many delays."""
        n = len(other)
        if n > len(self._times):
            self._allocate(max(n, 2 * len(self._times)))
        self._times[:n] = other._times[:n]
        self._values[:n] = other._values[:n]
        self._slopes[:n] = other._slopes[:n]
        self.delays[:] = other.delays
        self._length = n
        self._set(length=n)

    def history(self) -> tuple[Array, Array, Array]:
        """Return copies of the entries: times, values and slopes."""
        n = self._length
        return self._times[:n].copy(), self._values[:n].copy(), self._slopes[:n].copy()

    def restore(self, times: Array, values: Array, slopes: Array) -> None:
        """Go on with the entries that :meth:`history` has returned."""
        n = len(times)
        self._allocate(max(_CAPACITY, 2 * n))
        self._times[:n], self._values[:n], self._slopes[:n] = times, values, slopes
        self._length = n
        self._set(length=n)

    def clear(self) -> None:
        """Forget all entries."""
        self._length = 0
        self._set(length=0)

    def append(self, t: float, values: Array, slopes: Array | None = None) -> None:
        """Add the values at an accepted step or, at the time of the last entry, after a jump.

        Args:
            t: Time, seconds, not before the last entry.
            values: Values of the delayed expressions, shape ``(count,)``.
            slopes: Their derivatives by time; None for those of parabolas through the
                neighbouring entries.

        Raises:
            ValueError: The time lies before the last entry.
        """
        if t < self.last_time:
            raise ValueError(f"{t} lies before the last entry, {self.last_time}")
        if self._length == len(self._times):
            self._make_room(t)
        i = self._length
        self._times[i], self._values[i] = t, values
        if slopes is None:
            self._estimate(i)
        else:
            self._slopes[i] = slopes
        self._length = i + 1
        self._set(length=self._length)

    def _estimate(self, i: int) -> None:
        """Estimate the slopes at the new entry, and better ones at the entry before it."""
        times, values, slopes = self._times, self._values, self._slopes
        h = times[i] - times[i - 1] if i else 0.0
        if h <= 0.0:  # a start or the side after a jump
            slopes[i] = 0.0
            return
        new = (values[i] - values[i - 1]) / h
        before = times[i - 1] - times[i - 2] if i > 1 else 0.0
        if before <= 0.0:  # nothing smooth before it
            slopes[i - 1] = slopes[i] = new
            return
        old = (values[i - 1] - values[i - 2]) / before
        bend = (new - old) / (h + before)
        slopes[i - 1] = old + before * bend
        slopes[i] = new + h * bend
        if i == 2 or times[i - 2] <= times[i - 3]:
            slopes[i - 2] = old - before * bend

    def _make_room(self, t: float) -> None:
        """Drop what no delay can reach any more; if that is little, take a larger memory."""
        oldest = t - float(self.maxima.max(initial=0.0)) * (1.0 + 1e-9)
        # One entry at or before the oldest time has to stay, and three for parabolas.
        first = int(np.searchsorted(self._times[: self._length], oldest, "left")) - 2
        first = max(0, min(first, self._length - 3))
        kept = slice(first, self._length)
        times, values, slopes = self._times[kept], self._values[kept], self._slopes[kept]
        capacity = len(self._times)
        if 2 * len(times) > capacity:
            self._allocate(2 * capacity)
        else:
            times, values, slopes = times.copy(), values.copy(), slopes.copy()
        n = len(times)
        self._times[:n], self._values[:n], self._slopes[:n] = times, values, slopes
        self._length = n
        self._set(length=n)

    def evaluate(self, t: float, w: Array) -> None:
        """Write the delayed values at a time to their positions in ``w``."""
        self._function(t, w.ctypes.data, self.address)
