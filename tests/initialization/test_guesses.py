"""Written start values choose among several solutions."""

from __future__ import annotations

import numpy as np
import pytest

from acausal import compile_text

FLIP_FLOP = """
model FlipFlop "two inverting amplifiers in a ring"
  parameter Real gain = 100;
  Real first{start}, second;
equation
  first = if gain*second > 1 then -1 else if gain*second < -1 then 1 else -gain*second;
  second = if gain*first > 1 then -1 else if gain*first < -1 then 1 else -gain*first;
end FlipFlop;
"""


@pytest.mark.parametrize("sign", [-1, 1])
def test_flip_flop_starts_as_written(sign: int) -> None:
    compiled = compile_text(FLIP_FLOP.format(start=f"(start = {sign})"))
    result = compiled.simulate(stop_time=1, points=3)
    assert np.asarray(result["first"].values) == pytest.approx(sign)
    assert np.asarray(result["second"].values) == pytest.approx(-sign)
