"""Problems with root functions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from native_problems import build

from acausal.assembly.problem import DAEProblem, KernelCall, RootProblem
from acausal.codegen.kernels import compile_kernels
from acausal.expressions.build import add, call, mul, sub
from acausal.expressions.nodes import TIME, Expr, const, slot

A, B, C = slot(0), slot(1), slot(2)


def with_roots(problem: DAEProblem, *functions: tuple[Expr, list[int]]) -> DAEProblem:
    """Add root functions: template and positions in ``w``."""
    kernels = compile_kernels([(template, ()) for template, _ in functions])
    calls = tuple(
        KernelCall(
            kernel,
            np.array(operands, np.int32).reshape(-1, 1),
            np.array([number], np.int32),
            np.zeros((0, 1), np.int32),
        )
        for number, (kernel, (_, operands)) in enumerate(zip(kernels, functions, strict=True))
    )
    return replace(problem, roots=RootProblem(len(calls), calls, np.zeros(len(calls))))


def ball(g: float = 9.81) -> DAEProblem:
    """y = [height, velocity, acceleration], which is algebraic; the root is height = 0."""
    one = np.array
    problem = build(
        np.array([True, True, False]),
        [g],
        [
            (sub(A, B), [one([5, 6]), one([3, 4])], one([0, 1])),
            (add(A, B), [one([4]), one([8])], one([2])),
        ],
    )
    return with_roots(problem, (A, [2]))


def clock(count: int = 0) -> DAEProblem:
    """y' = 1 with y = t; roots of y - 0.5 k for k = 1, 2, .. ``count``."""
    problem = build(np.array([True]), [], [(sub(A, const(1.0)), [np.array([3])], np.array([0]))])
    levels = [(sub(A, const(0.5 * k)), [2]) for k in range(1, count + 1)]
    return with_roots(problem, *levels)


def rectifier() -> DAEProblem:
    """A sine source, an ideal diode and an RC load in parallel: y = [v, i], parameter: closed.

    v' = i - v (capacitor and load), and ``if closed then v = sin(t) else i = 0``, written as
    ``closed * (v_source - v - 0.01 i) + (1 - closed) * i = 0``. Root functions: the voltage of the
    diode (opens it) and its current (closes it).
    """
    one = np.array
    closed = mul(C, sub(sub(call("sin", TIME), A), mul(const(0.01), B)))
    problem = build(
        np.array([True, False]),
        [0.0],
        [
            (add(sub(A, B), C), [one([4]), one([3]), one([2])], one([0])),
            (add(closed, mul(sub(const(1.0), C), B)), [one([2]), one([3]), one([6])], one([1])),
        ],
    )
    return with_roots(problem, (sub(call("sin", TIME), A), [2]), (A, [3]))


def sine_of_time(omega: float) -> DAEProblem:
    """No unknowns; the root function is sin(omega t)."""
    problem = build(np.zeros(0, bool), [], [])
    return with_roots(problem, (call("sin", mul(const(omega), TIME)), []))


def logarithm() -> DAEProblem:
    """y = [x, z], x' = x, z = log(x) - 1, which the error test does not see; root: z."""
    one = np.array
    problem = build(
        np.array([True, False]),
        [],
        [
            (sub(A, B), [one([4]), one([2])], one([0])),
            (sub(sub(call("log", A), B), const(1.0)), [one([2]), one([3])], one([1])),
        ],
    )
    return with_roots(problem, (A, [3]))
