"""Assignments in native code."""

from __future__ import annotations

import numpy as np
import pytest

from acausal.codegen.kernels import compile_kernels
from acausal.codegen.sequence import NativeSequence
from acausal.expressions.build import add, if_, mul, relation, sub
from acausal.expressions.nodes import TIME, const, slot

A, B = slot(0), slot(1)


def ints(*values: int) -> np.ndarray:
    return np.array(values, np.int32)


def test_later_calls_see_earlier_results():
    increment, product = compile_kernels([(add(A, const(1.0)), ()), (mul(A, B), ())])
    w = np.array([0.0, 0.0, 4.0, 9.0, 9.0])
    calls = [
        (increment, ints(2)[None], ints(3)),
        (product, np.array([[2], [3]], np.int32), ints(4)),
    ]
    NativeSequence(calls, w, w).run()
    np.testing.assert_array_equal(w, [0.0, 0.0, 4.0, 5.0, 20.0])


def test_members_of_a_call_are_simultaneous():
    (difference,) = compile_kernels([(sub(A, B), ())])
    w = np.array([0.0, 0.0, 5.0, 3.0])
    swap = np.array([[3, 2], [0, 0]], np.int32)
    sequence = NativeSequence([(difference, swap, ints(2, 3))], w, w)
    sequence.run()
    np.testing.assert_array_equal(w, [0.0, 0.0, 3.0, 5.0])
    sequence.run()
    np.testing.assert_array_equal(w, [0.0, 0.0, 5.0, 3.0])


def test_relations_and_time_into_another_array():
    (late,) = compile_kernels([(if_(relation("gt", TIME, A), const(1.0), const(0.0)), ())])
    w, out = np.array([0.0, 2.5, 2.0, 3.0]), np.full(3, 8.0)
    NativeSequence([(late, ints(2, 3)[None], ints(2, 0))], w, out).run()
    np.testing.assert_array_equal(out, [0.0, 8.0, 1.0])


def test_nothing_to_do():
    w = np.zeros(2)
    NativeSequence([], w, w).run()


def test_wrong_arrays_are_refused():
    (kernel,) = compile_kernels([(add(A, const(1.0)), ())])
    w = np.zeros(4)
    with pytest.raises(ValueError, match="outside"):
        NativeSequence([(kernel, ints(4)[None], ints(0))], w, w)
    with pytest.raises(ValueError, match="outside"):
        NativeSequence([(kernel, ints(0)[None], ints(4))], w, w)
    with pytest.raises(ValueError, match="expected"):
        NativeSequence([(kernel, ints(0)[None], np.zeros(1, np.int64))], w, w)
