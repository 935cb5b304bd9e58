"""Filters against the designs of SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from tests.library.blocks_runs import run, values

T = np.linspace(0, 1, 20001)
KINDS = {
    "LowPass": "lowpass",
    "HighPass": "highpass",
    "BandPass": "bandpass",
    "BandStop": "bandstop",
}


def design(kind: str, order: int, pass_: str, low: float, high: float) -> tuple[object, object]:
    """Return numerator and denominator."""
    band = pass_.startswith("Band")
    edges = 2 * np.pi * (np.array([low, high]) if band else np.array(high))
    btype = KINDS[pass_]
    if kind == "Butterworth":
        return signal.butter(order, edges, btype, analog=True)
    if kind == "Bessel":
        return signal.bessel(order, edges, btype, analog=True, norm="mag")
    if kind == "ChebyshevI":
        return signal.cheby1(order, 0.5, edges, btype, analog=True)
    z, p, k = np.zeros(0), -np.ones(order), 1.0
    if band:
        w0, width = np.sqrt(edges[0] * edges[1]), edges[1] - edges[0]
        change = signal.lp2bp_zpk if pass_ == "BandPass" else signal.lp2bs_zpk
        return signal.zpk2tf(*change(z, p, k, w0, width))
    change = signal.lp2lp_zpk if pass_ == "LowPass" else signal.lp2hp_zpk
    return signal.zpk2tf(*change(z, p, k, float(edges)))


@pytest.mark.parametrize("pass_", KINDS)
@pytest.mark.parametrize("kind", ["CriticalDamping", "Bessel", "Butterworth", "ChebyshevI"])
@pytest.mark.parametrize("order", [1, 3, 4])
def test_filter_is_that_of_the_textbook(kind: str, order: int, pass_: str) -> None:
    # SciPy's Bessel filters are normalised, its other ones are not where it makes a difference.
    normalized = "true" if kind == "Bessel" else "false"
    result = run(
        f"""
  blocks.Step step(startTime = 0.1);
  blocks.Filter filter(analogFilter = blocks.AnalogFilter.{kind}, order = {order},
    filterType = blocks.FilterType.{pass_}, f_min = 2, f_cut = 5, normalized = {normalized});
equation
  connect(step.y, filter.u);
"""
    )
    b, a = design(kind, order, pass_, 2.0, 5.0)
    t = T[T <= 0.9]
    _, expected = signal.step((b, a), T=t)
    if kind == "ChebyshevI" and order % 2 == 0:
        expected = expected * 10 ** (0.5 / 20)  # ours passes what passes with the amplitude 1
    later = result.times > 0.1
    found = values(result, "filter.y")[later]
    wanted = np.interp(result.times[later] - 0.1, t, expected)
    assert found == pytest.approx(wanted, abs=2e-5)
    assert set(values(result, "filter.y")[result.times < 0.1]) <= {0.0}


@pytest.mark.parametrize("order", [2, 3, 5, 6])
@pytest.mark.parametrize("kind", ["CriticalDamping", "Bessel", "Butterworth", "ChebyshevI"])
def test_normalized_filter_at_its_cut_off_frequency(kind: str, order: int) -> None:
    result = run(
        f"""
  blocks.Sine sine(f = 20[Hz]);
  blocks.Filter filter(analogFilter = blocks.AnalogFilter.{kind}, order = {order},
    f_cut = 20[Hz], gain = 2);
equation
  connect(sine.y, filter.u);
""",
        stop_time=3,
        points=12001,
    )
    settled = result.times > 2.5
    amplitude = values(result, "filter.y")[settled].max()
    assert amplitude == pytest.approx(2 / np.sqrt(2), abs=2e-3)


def test_filter_starts_at_rest() -> None:
    result = run(
        """
  blocks.Constant constant_(k = 3);
  blocks.Filter low(order = 5, analogFilter = blocks.AnalogFilter.Bessel);
  blocks.Filter band(order = 3, filterType = blocks.FilterType.BandStop, f_min = 0.5[Hz]);
  blocks.LowpassButterworth butterworth(n = 4, f = 2[Hz], initType = blocks.Init.SteadyState);
equation
  connect(constant_.y, low.u, band.u, butterworth.u);
"""
    )
    for path in ("low.y", "band.y", "butterworth.y"):
        assert values(result, path) == pytest.approx(3, abs=1e-7)
