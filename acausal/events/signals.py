"""Samples and delays: their numbers and their expressions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import fail
from acausal.events.layout import Layout
from acausal.expressions.evaluate import evaluate
from acausal.flattening.model import Discrete, EquationFamily, Ids, Operand


def sample_times(
    discrete: Discrete, layout: Layout, parameters: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return first time and interval of every sample, seconds, each of shape ``(s,)``.

    Raises:
        AcausalError: ``E024`` if they are not known before the simulation, ``E025`` for an
            interval that is not above zero.
    """
    index = _index(layout.samples, discrete.n_signals)
    start, interval = np.zeros(len(layout.samples)), np.ones(len(layout.samples))
    for signal in discrete.signals:
        if signal.kind != "sample":
            continue
        first, between = signal.operands
        start[index[first.rows]] = _numbers(first, layout, parameters, "the start of a sample")
        values = _numbers(between, layout, parameters, "the interval of a sample")
        interval[index[between.rows]] = values
        if not (values > 0.0).all():
            fail("E025", f"the interval of a sample is {values[~(values > 0.0)][0]:g} s",
                 between.origins[0].span, label="it must be above zero",
                 help="give the time between two samples in seconds")  # fmt: skip
    return start, interval


def delay_families(
    discrete: Discrete, layout: Layout, parameters: NDArray[np.float64]
) -> tuple[list[EquationFamily], list[EquationFamily], NDArray[np.float64]]:
    """Return delayed expressions, delays and largest delays; ``rows`` number the delays.

    Raises:
        AcausalError: ``E024`` if a largest delay is not known before the simulation, ``E025`` if
            it is negative.
    """
    index = _index(layout.delays, discrete.n_signals)
    expressions: list[EquationFamily] = []
    times: list[EquationFamily] = []
    maxima = np.zeros(len(layout.delays))
    for signal in discrete.signals:
        if signal.kind != "delay":
            continue
        expression, time, maximum = signal.operands
        expressions.append(replace(expression, rows=index[expression.rows]))
        times.append(replace(time, rows=index[time.rows]))
        values = _numbers(maximum, layout, parameters, "the largest delay")
        maxima[index[maximum.rows]] = values
        if not (values >= 0.0).all():
            fail("E025", f"a delay is {values[~(values >= 0.0)][0]:g} s",
                 maximum.origins[0].span, label="it must not be negative",
                 help="only values of the past are known")  # fmt: skip
    return expressions, times, maxima


def timing_parameters(discrete: Discrete) -> Ids:
    """Return the parameters that times of samples and largest delays depend on, ascending."""
    families = [
        family
        for signal in discrete.signals
        for family in {"sample": signal.operands, "delay": signal.operands[2:]}.get(signal.kind, ())
    ]
    found = [np.zeros(0, np.int64), *(f.operands.reshape(-1) for f in families)]
    return np.unique(np.concatenate(found))


def _index(signals: Ids, n_signals: int) -> Ids:
    index = np.full(n_signals, -1, np.int64)
    index[signals] = np.arange(len(signals))
    return index


def _numbers(
    family: EquationFamily, layout: Layout, parameters: NDArray[np.float64], what: str
) -> NDArray[np.float64]:
    constant = all(kind == Operand.PARAMETER for kind in family.kinds)
    if not constant or (family.operands >= layout.first).any():
        fail("E024", f"{what} must be known before the simulation", family.origins[0].span,
             label="this changes during the simulation",
             help="use parameters and constants here")  # fmt: skip
    values = {k: parameters[row] for k, row in enumerate(family.operands)}
    return np.broadcast_to(evaluate(family.template, values), (family.count,))
