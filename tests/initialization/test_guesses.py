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


# No variable that stays an unknown has a start value: sum and difference are eliminated.
ELIMINATED = """
model Ring "a flip-flop seen through the difference of its sides"
  parameter Real gain = 100;
  Real first, second, difference{start};
equation
  first = if gain*second > 1 then -1 else if gain*second < -1 then 1 else -gain*second;
  second = if gain*first > 1 then -1 else if gain*first < -1 then 1 else -gain*first;
  difference = first - second;
end Ring;
"""


@pytest.mark.parametrize("sign", [-1, 1])
def test_start_values_of_eliminated_variables_choose(sign: int) -> None:
    compiled = compile_text(ELIMINATED.format(start=f"(start = {2 * sign})"))
    system = compiled.system
    ((_, difference),) = system.names.find_variables("difference")
    assert not system.active[system.representative[difference]]
    result = compiled.simulate(stop_time=1, points=3)
    assert np.asarray(result["first"].values) == pytest.approx(sign)
    assert np.asarray(result["difference"].values) == pytest.approx(2 * sign)


@pytest.mark.parametrize("sign", [-1, 1])
def test_start_values_of_eliminated_variables_choose_without_events(sign: int) -> None:
    text = f"""
model Root "x is 0, 2 or -2, and the start value of something that depends on x"
  Real x, y(start = {3 + 4 * sign}), z;
equation
  x^3 - 4*x = 0;
  z = x + 1;
  y = 2*z + 1;
end Root;
"""
    result = compile_text(text).simulate(stop_time=1, points=3)
    assert np.asarray(result["x"].values) == pytest.approx(2 * sign)
