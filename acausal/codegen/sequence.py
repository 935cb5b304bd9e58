"""Assignments as native code: value kernels that run one after the other in a single call.

A sequence is a list of kernel calls, each of which evaluates one template for many members and
stores the results. The members of one call are evaluated before any of them is stored, so that
a call may assign to positions that it reads; later calls see the results of earlier ones.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import cache
from hashlib import blake2b
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from acausal.codegen import engine
from acausal.codegen.kernels import Kernel
from acausal.storage import cache_directory

# Table: w, out, scratch, scratch targets, number of calls, records.
# Record: the kernel's residual function (it adds), count, index, target.
_TEXT: Final = """
declare void @llvm.memset.p0.i64(ptr, i8, i64, i1)

define void @acausal_sequence(ptr %table) nounwind {
entry:
  %w = load ptr, ptr %table, align 8
  %out.f = getelementptr inbounds i64, ptr %table, i64 1
  %out = load ptr, ptr %out.f, align 8
  %scratch.f = getelementptr inbounds i64, ptr %table, i64 2
  %scratch = load ptr, ptr %scratch.f, align 8
  %own.f = getelementptr inbounds i64, ptr %table, i64 3
  %own = load ptr, ptr %own.f, align 8
  %calls.f = getelementptr inbounds i64, ptr %table, i64 4
  %calls = load i64, ptr %calls.f, align 8
  %records.f = getelementptr inbounds i64, ptr %table, i64 5
  %records = load ptr, ptr %records.f, align 8
  %any = icmp sgt i64 %calls, 0
  br i1 %any, label %call, label %done
call:
  %i = phi i64 [ 0, %entry ], [ %i.next, %stored ]
  %at = shl nuw nsw i64 %i, 2
  %record = getelementptr inbounds i64, ptr %records, i64 %at
  %kernel = load ptr, ptr %record, align 8
  %count.f = getelementptr inbounds i64, ptr %record, i64 1
  %count = load i64, ptr %count.f, align 8
  %index.f = getelementptr inbounds i64, ptr %record, i64 2
  %index = load ptr, ptr %index.f, align 8
  %target.f = getelementptr inbounds i64, ptr %record, i64 3
  %target = load ptr, ptr %target.f, align 8
  %bytes = shl nuw nsw i64 %count, 3
  call void @llvm.memset.p0.i64(ptr %scratch, i8 0, i64 %bytes, i1 false)
  call void %kernel(i64 %count, ptr %w, ptr %index, ptr %own, ptr %scratch)
  %some = icmp sgt i64 %count, 0
  br i1 %some, label %store, label %stored
store:
  %k = phi i64 [ 0, %call ], [ %k.next, %store ]
  %from = getelementptr inbounds double, ptr %scratch, i64 %k
  %value = load double, ptr %from, align 8
  %place.p = getelementptr inbounds i32, ptr %target, i64 %k
  %place.n = load i32, ptr %place.p, align 4
  %place = zext nneg i32 %place.n to i64
  %to = getelementptr inbounds double, ptr %out, i64 %place
  store double %value, ptr %to, align 8
  %k.next = add nuw nsw i64 %k, 1
  %k.more = icmp slt i64 %k.next, %count
  br i1 %k.more, label %store, label %stored
stored:
  %i.next = add nuw nsw i64 %i, 1
  %more = icmp slt i64 %i.next, %calls
  br i1 %more, label %call, label %done
done:
  ret void
}
"""

# PYFUNCTYPE keeps the interpreter's lock: giving it up costs more than a short sequence.
_FUNCTION: Final = ctypes.PYFUNCTYPE(None, ctypes.c_void_p)


@cache
def _load() -> int:
    """Load the function, compiled by the first program on this machine that needs it."""
    identity = engine.target_identity() + _TEXT
    key = "sequence_" + blake2b(identity.encode(), digest_size=16).hexdigest()
    code = cache_directory.read("kernel", key)
    if code is None:
        code = engine.compile_object(_TEXT, level=2, passes=True)
        cache_directory.write("kernel", key, code)
    engine.load_objects([code])
    return engine.address_of("acausal_sequence")


def address() -> int:
    """Return the address of the function that runs sequences, ``void f(void* argument)``."""
    return _load()


@cache
def _function() -> Any:
    return _FUNCTION(_load())


def data_of(array: NDArray[Any]) -> int:
    """Return the address of an array's data, faster than ``array.ctypes``."""
    address: int = array.__array_interface__["data"][0]
    return address


class NativeSequence:
    """Kernel calls in order, stored in an array."""

    def __init__(
        self,
        calls: Sequence[tuple[Kernel, NDArray[np.int32], NDArray[np.int32]]],
        w: NDArray[np.float64],
        out: NDArray[np.float64],
    ) -> None:
        """Bind the arrays; they are kept alive and must not be replaced, only changed.

        Args:
            calls: Kernel, operands as positions in ``w``, shape ``(m, count)``, and targets as
                positions in ``out``, shape ``(count,)``.
            w: Work vector, float64; ``w[1]`` is the time in s.
            out: Receives the results, float64; may be ``w`` itself.

        Raises:
            ValueError: An array has a wrong type or layout, or an index out of range.
        """
        _check("w", w, np.float64, w.shape)
        _check("out", out, np.float64, out.shape)
        self._calls = tuple(calls)
        self._w, self._out = w, out
        # Of the sequences of a model many are empty: they cost next to nothing.
        self._empty = not self._calls
        most = max((target.size for _, _, target in self._calls), default=0)
        self._scratch = np.zeros(most)
        self._own = np.arange(most, dtype=np.int32)
        self._records = np.zeros((len(self._calls), 4), np.int64)
        for record, (kernel, index, target) in zip(self._records, self._calls, strict=True):
            _check("target", target, np.int32, (target.size,), out.size)
            _check("index", index, np.int32, (kernel.m, target.size), w.size)
            record[:] = (kernel.residual, target.size, data_of(index), data_of(target))
        self._table = np.array(
            [
                data_of(w), data_of(out), data_of(self._scratch), data_of(self._own),
                len(self._calls), data_of(self._records),
            ],
            np.int64,
        )  # fmt: skip
        self._function = _function()
        self._argument = ctypes.c_void_p(data_of(self._table))

    @property
    def argument(self) -> int:
        """Address of what the native function :func:`address` takes, to run this sequence."""
        return data_of(self._table)

    def run(self) -> None:
        """Evaluate and store all calls in order."""
        if not self._empty:
            self._function(self._argument)


def _check(
    name: str, array: NDArray[np.generic], kind: type, shape: tuple[int, ...], bound: int = 0
) -> None:
    if array.dtype != kind or array.shape != shape or not array.flags.c_contiguous:
        raise ValueError(
            f"{name} is {array.dtype} {array.shape}, expected C-contiguous {kind.__name__} {shape}"
        )
    if bound and array.size and (array.min() < 0 or array.max() >= bound):
        raise ValueError(f"{name} holds an index outside of 0 .. {bound - 1}")
