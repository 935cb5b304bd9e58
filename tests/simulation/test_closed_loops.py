"""Closed loops through any position: no choice of states is good everywhere."""

from __future__ import annotations

import numpy as np
import pytest

from acausal import compiler

CRANK_ROCKER = """
model CrankRocker "four bars; the crank goes round, the rocker swings between its extremes"
  import mechanical.planar.*;
  parameter Real speed = 12 "of the crank at the start, rad/s";
  inner PlanarWorld world;
  Fixed left;
  Fixed right(r = {3, 0});
  Revolute a(phi(start = 1, fixed = true), w(start = speed, fixed = true));
  FixedTranslation crank(r = {1, 0});
  Revolute b(phi(start = -1));
  FixedTranslation coupler(r = {3, 0});
  Revolute c(phi(start = 1));
  FixedTranslation rocker(r = {-2.5, 0});
  Revolute d;
  Body load(m = 1[kg], I = 0.05[kg.m2]);
  Body wheel(m = 1e-9[kg], I = 2[kg.m2]);
equation
  connect(left.frame_a, a.frame_a);
  connect(a.frame_b, crank.frame_a, wheel.frame_a);
  connect(crank.frame_b, b.frame_a);
  connect(b.frame_b, coupler.frame_a);
  connect(coupler.frame_b, c.frame_a, load.frame_a);
  connect(c.frame_b, rocker.frame_a);
  connect(rocker.frame_b, d.frame_a);
  connect(d.frame_b, right.frame_a);
end CrankRocker;
"""


def test_crank_rocker_goes_round_and_closes() -> None:
    compiled = compiler.compile_text(CRANK_ROCKER)
    result = compiled.simulate(stop_time=5, tolerance=1e-8)
    assert result.ending.value == "complete", result.diagnostics
    phi = np.asarray(result["a.phi"].values)
    assert phi[-1] - phi[0] > 2 * np.pi * 5  # many full turns
    tip = np.array([np.cos(phi), np.sin(phi)])
    joint = np.array([result["load.r[1]"].values, result["load.r[2]"].values])
    assert np.hypot(*(joint - tip)) == pytest.approx(3, abs=1e-6)
    assert np.hypot(*(joint - np.array([[3.0], [0.0]]))) == pytest.approx(2.5, abs=1e-6)
    velocity = np.array([result["load.v[1]"].values, result["load.v[2]"].values])
    energy = (
        result["a.w"].values ** 2  # the wheel
        + 0.5 * (velocity**2).sum(axis=0)
        + 0.5 * 0.05 * np.asarray(result["load.w"].values) ** 2
        + 9.81 * joint[1]
    )
    assert np.ptp(energy) < 1e-3 * energy[0]
    # The rocker swings between the extremes that the lengths of the bars give.
    angle = np.arctan2(joint[1], joint[0] - 3)
    for reach, extreme in ((4.0, angle.min()), (2.0, angle.max())):
        cosine = (3.0**2 + 2.5**2 - reach**2) / (2 * 3.0 * 2.5)
        assert extreme == pytest.approx(np.pi - np.arccos(cosine), abs=2e-3)
