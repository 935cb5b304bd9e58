"""Sums of states that only several rows together show."""

from __future__ import annotations

import numpy as np
import pytest

from acausal import compile_text

CAPACITORS = """
model Triangle "three capacitors between nodes that all hang in the air"
  electrical.Capacitor c[3](C = {1, 2, 3}, v(each start = 0));
  electrical.Resistor r[3](R = {1, 2, 3});
  electrical.SineVoltage s[3](each V = 1, phase = {0, 2, 4});
  electrical.Ground g;
equation
  for k in 1:3 loop
    connect(s[k].n, g.p);
    connect(s[k].p, r[k].p);
    connect(r[k].n, c[k].p);
  end for;
  connect(c[1].n, c[2].p);
  connect(c[2].n, c[3].p);
  connect(c[3].n, c[1].p);
end Triangle;
"""

COILS = """
model Bridge "three coils that end at three pairs of resistors: their currents add up to zero"
  electrical.Inductor coil[3](L = {1, 2, 3}, i(each start = 0));
  electrical.Resistor up[3](R = {1, 2, 3}), down[3](R = {3, 1, 2}), load(R = 1);
  electrical.SineVoltage s[3](each V = 1, phase = {0, 2, 4});
  electrical.Ground g;
equation
  connect(s.p, coil.p);
  for k in 1:3 loop
    connect(s[k].n, g.p);
    connect(coil[k].n, up[k].p, down[k].p);
    connect(up[k].n, load.p);
    connect(down[k].n, load.n);
  end for;
end Bridge;
"""


@pytest.mark.parametrize(
    ("text", "variable"), [(CAPACITORS, "c[{}].v"), (COILS, "coil[{}].i")], ids=["loop", "cut"]
)
def test_two_of_three_are_states(text: str, variable: str) -> None:
    result = compile_text(text).simulate(stop_time=5, tolerance=1e-8)
    assert len(result.states) == 2
    total = sum(np.asarray(result[variable.format(k)].values) for k in (1, 2, 3))
    assert total == pytest.approx(0, abs=1e-12)
    assert np.ptp(np.asarray(result[variable.format(1)].values)) > 1e-2


def test_contradicting_start_values_are_refused() -> None:
    text = COILS.replace("i(each start = 0)", "i(each start = 1, each fixed = true)")
    with pytest.raises(Exception, match="I01"):
        compile_text(text).simulate(stop_time=1)


def test_a_resistor_to_ground_sets_them_free() -> None:
    text = COILS.replace("equation", "  electrical.Resistor leak(R = 100);\nequation", 1).replace(
        "end Bridge", "  connect(leak.p, load.n);\n  connect(leak.n, g.p);\nend Bridge"
    )
    assert len(compile_text(text).simulate(stop_time=1).states) == 3
