"""The example on the page about bodies in space."""

from __future__ import annotations

import re

import numpy as np
import pytest

from acausal import compile_text
from tests.library.multibody.bodies import ROOT, energy, values


def test_the_flywheel_keeps_energy_and_spin() -> None:
    page = (ROOT / "docs" / "multibody.md").read_text()
    found = re.search(r"```modelica\n(.*?)```", page, re.DOTALL)
    assert found
    result = compile_text(found.group(1)).simulate(stop_time=2, tolerance=1e-9)
    m = 7700 * np.pi * 0.015**2
    across = m * (1 + 3 * 0.015**2) / 12
    rod = energy(result, "rod.body", m, (0, 0, -0.5), (across, across, m * 0.015**2 / 2), 9.80665)
    wheel = energy(result, "wheel", 2, (0, 0, 0), (0.01, 0.005, 0.005), 9.80665)
    assert rod + wheel == pytest.approx(rod[0] + wheel[0], abs=1e-5)
    assert np.ptp(values(result, "arm.phi")) > 0.9
    assert values(result, "wheel.w_a[1]") == pytest.approx(100, abs=1e-6)
