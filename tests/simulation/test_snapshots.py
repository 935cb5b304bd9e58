"""A run that is interrupted and goes on is the run that was not interrupted."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acausal import compile_text
from acausal.diagnostics import AcausalError
from acausal.results.snapshot import read_snapshot

OSCILLATOR = """
model Oscillator
  parameter Real k = 4;
  Real x(start = 1, fixed = true), v(start = 0, fixed = true);
equation
  der(x) = v;
  der(v) = -k*x;
end Oscillator;
"""

PENDULUM = """
model Pendulum
  Real x(start = 0.6), y(start = -0.8), u(start = 0), v(start = 0), F;
initial equation
  x = 0.6;
  u = 0;
equation
  der(x) = u;
  der(y) = v;
  der(u) = -F*x;
  der(v) = -F*y - 9.81;
  x^2 + y^2 = 1;
end Pendulum;
"""

BALL = """
model Ball
  Real h(start = 1, fixed = true), v(start = 0, fixed = true);
  Integer n(start = 0, fixed = true);
equation
  der(h) = v;
  der(v) = -9.81;
  when h <= 0 then
    reinit(v, -0.8*pre(v));
    n = pre(n) + 1;
  end when;
end Ball;
"""

SAMPLED = """
model Sampled
  discrete Real held(start = 0, fixed = true);
  Real x(start = 1, fixed = true), late;
equation
  der(x) = -held - 0.1*x;
  late = delay(x, 0.35);
  when sample(0.05, 0.1) then
    held = 3*x + pre(held)/10;
  end when;
end Sampled;
"""

DELAYED = """
model Delayed "x' = -x(t - 1), Hutchinson"
  Real x(start = 1, fixed = true);
equation
  der(x) = -delay(x, 1);
end Delayed;
"""


@pytest.mark.parametrize(
    ("text", "names", "middle", "stop"),
    [
        (OSCILLATOR, ["x", "v"], 1.3, 3.0),
        (PENDULUM, ["x", "y", "F"], 1.1, 3.0),
        (BALL, ["h", "v", "n"], 1.5, 3.0),
        (BALL, ["h", "n"], 3.99, 6.0),
        (SAMPLED, ["x", "held", "late"], 0.75, 2.0),
        (SAMPLED, ["x", "held", "late"], 0.77, 2.0),
        (DELAYED, ["x"], 1.7, 4.0),
    ],
)
def test_going_on_gives_the_same_trajectory(
    text: str, names: list[str], middle: float, stop: float, tmp_path: Path
) -> None:
    compiled = compile_text(text)
    options: dict[str, Any] = {"tolerance": 1e-9, "interval": stop / 300}
    whole = compiled.simulate(stop_time=stop, **options)
    first = compiled.simulate(stop_time=middle, **options)
    assert first.end is not None
    first.end.save(tmp_path / "middle.npz")
    again = read_snapshot(tmp_path / "middle.npz")
    second = compile_text(text).simulate(stop_time=stop, continue_from=again, **options)
    assert second.times[0] == middle
    for name in names:
        expected = np.interp(second.times[-1], whole.times, whole[name].values)
        assert second[name].values[-1] == pytest.approx(expected, abs=2e-6), name
        # also on the way, away from events
        for share in (0.31, 0.62):
            t = middle + share * (stop - middle)
            there = [np.interp(t, r.times, r[name].values) for r in (whole, second)]
            assert there[0] == pytest.approx(there[1], abs=2e-2), name


def test_other_parameters_from_there_on() -> None:
    compiled = compile_text(OSCILLATOR)
    first = compiled.simulate(stop_time=np.pi / 4, tolerance=1e-9)  # x = 0, v = -2
    second = compiled.simulate(
        stop_time=np.pi / 4 + 1, tolerance=1e-9, parameters={"k": 1.0}, continue_from=first.end
    )
    t = second.times - np.pi / 4
    assert second["x"].values == pytest.approx(-2 * np.sin(t), abs=1e-6)


def test_algebraic_values_follow_changed_parameters() -> None:
    compiled = compile_text("""
model M
  parameter Real a = 1, limit = 10;
  Real x(start = 0, fixed = true), y;
  Boolean high = x > limit;
equation
  der(x) = 1;
  y*y*y = if high then -a*x else a*x;
end M;
""")
    first = compiled.simulate(stop_time=8.0, tolerance=1e-9)
    second = compiled.simulate(
        stop_time=9.0, tolerance=1e-9, parameters={"a": 8.0, "limit": 5.0}, continue_from=first.end
    )
    assert second["y"].values[0] == pytest.approx(-4.0, rel=1e-6)
    assert second["high"].values[0] == 1.0


def test_mistakes(tmp_path: Path) -> None:
    end = compile_text(OSCILLATOR).simulate(stop_time=1.0).end
    with pytest.raises(AcausalError) as error:
        compile_text(BALL).simulate(stop_time=2.0, continue_from=end)
    assert error.value.diagnostics[0].code == "R012"
    with pytest.raises(AcausalError) as error:
        compile_text(OSCILLATOR).simulate(stop_time=2.0, continue_from=end, start={"x": 1.0})
    assert error.value.diagnostics[0].code == "R010"
    with pytest.raises(AcausalError) as error:
        compile_text(OSCILLATOR).simulate(stop_time=0.5, continue_from=end)
    assert error.value.diagnostics[0].code == "R010"
    (tmp_path / "no.npz").write_text("nothing")
    with pytest.raises(AcausalError) as error:
        read_snapshot(tmp_path / "no.npz")
    assert error.value.diagnostics[0].code == "F131"
    assert end is not None
    with pytest.raises(AcausalError) as error:
        end.save(tmp_path / "nowhere" / "end.npz")
    assert error.value.diagnostics[0].code == "F130"
