"""Algebraic unknowns that jump without an event leave those beside them right."""

from __future__ import annotations

import numpy as np
import pytest

from acausal import compile_text

BESIDE = """
model Beside
  Real z, a, w, b, q(start = 0, fixed = true);
equation
  z + 0.1*z*z*z = 3*time;
  a + 0.001*a*a*a = noEvent(if z >= 1.3 then z - 3.14 else z);
  w + 0.2*w*w*w = z + a;
  b*b*b + b = a*a + 5*z;
  der(q) = cos(40*time);
end Beside;
"""


@pytest.mark.parametrize("points", [61, 121, 241])
def test_every_stored_point_solves_the_equations(points: int) -> None:
    # The steps are those of q, many of which the jump of a does not concern.
    result = compile_text(BESIDE).simulate(stop_time=1.2, points=points, tolerance=1e-9)
    z, a, w, b = (result[name].values for name in "zawb")
    assert z + 0.1 * z**3 == pytest.approx(3 * result.times, abs=1e-8)
    assert a + 0.001 * a**3 == pytest.approx(np.where(z >= 1.3, z - 3.14, z), abs=1e-8)
    assert w + 0.2 * w**3 == pytest.approx(z + a, abs=1e-8)
    assert b**3 + b == pytest.approx(a**2 + 5 * z, abs=1e-8)
    assert result["q"].values == pytest.approx(np.sin(40 * result.times) / 40, abs=1e-7)
