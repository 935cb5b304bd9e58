"""Nine-valued logic against the tables of IEEE standard 1164; delays, sources, converters."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from acausal import compile_text

LITERALS = "UX01ZWLH-"
# Rows and columns in the order above, as printed in the standard.
TABLES = {
    "logicAnd": "UU0UUU0UU UX0XXX0XX 000000000 UX01XX01X UX0XXX0XX UX0XXX0XX 000000000 UX01XX01X "
    "UX0XXX0XX",
    "logicOr": "UUU1UUU1U UXX1XXX1X UX01XX01X 111111111 UXX1XXX1X UXX1XXX1X UX01XX01X 111111111 "
    "UXX1XXX1X",
    "logicXor": "UUUUUUUUU UXXXXXXXX UX01XX01X UX10XX10X UXXXXXXXX UXXXXXXXX UX01XX01X UX10XX10X "
    "UXXXXXXXX",
}


def run(text: str, stop_time: float = 1.0, **options: Any) -> Any:
    model = f"import electrical.digital.*;\nmodel Test\n{text}\nend Test;\n"
    return compile_text(model).simulate(stop_time=stop_time, **options)


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def letters(result: Any, path: str) -> str:
    """Return a signal as text, a letter for each of its values in turn."""
    numbers = values(result, path)
    changes = np.flatnonzero(np.diff(numbers, prepend=-1))
    return "".join(LITERALS[int(k) - 1] for k in numbers[changes])


def changes(result: Any, path: str) -> Any:
    numbers = values(result, path)
    return result.times[np.flatnonzero(np.diff(numbers)) + 1]


@pytest.mark.parametrize("function", TABLES)
def test_connectives_agree_with_the_standard(function: str) -> None:
    # The inputs run through all pairs of values.
    all_values = ", ".join(f"Logic.'{c}'" for c in LITERALS)
    result = run(
        f"""
  parameter Logic values[9] = {{{all_values}}};
  Table a(x = {{{", ".join(f"Logic.'{c}'" for c in LITERALS[1:])}}}, t = 1:8, y0 = Logic.'U');
  Logic y[9];
equation
  for k in 1:9 loop
    y[k] = {function}(values[k], a.y);
  end for;
""",
        stop_time=9,
        points=19,
    )
    table = TABLES[function].split()
    middle = [int(np.argmin(np.abs(result.times - (k + 0.5)))) for k in range(9)]
    for k in range(9):
        found = "".join(LITERALS[int(v) - 1] for v in values(result, f"y[{k + 1}]")[middle])
        assert found == table[k]


def test_negation() -> None:
    result = run(
        f"""
  Table a(x = {{{", ".join(f"Logic.'{c}'" for c in LITERALS[1:])}}}, t = 1:8, y0 = Logic.'U');
  Logic y = logicNot(a.y);
""",
        stop_time=9,
        points=19,
    )
    middle = [int(np.argmin(np.abs(result.times - (k + 0.5)))) for k in range(9)]
    assert "".join(LITERALS[int(v) - 1] for v in values(result, "y")[middle]) == "UX10XX10X"


def test_gate_lets_through_what_lasts_longer_than_its_delay() -> None:
    # a pulse of 0.2 s is swallowed by the delay of 0.3 s, a pulse of 1 s is not
    result = run(
        """
  Table a(x = {Logic.'1', Logic.'0', Logic.'1', Logic.'0'}, t = {1, 1.2, 2, 3}, y0 = Logic.'0');
  Set b(x = Logic.'1');
  AndGate gate(tLH = 0.3[s], tHL = 0.5[s], y0 = Logic.'0');
equation
  connect(a.y, gate.x[1]);
  connect(b.y, gate.x[2]);
""",
        stop_time=5,
    )
    assert changes(result, "gate.y") == pytest.approx([2.3, 3.5])
    assert letters(result, "gate.y") == "010"


def test_gates_in_a_loop_hold_a_value() -> None:
    # two NOR gates, set at 1 s, reset at 3 s
    result = run(
        """
  Pulse set(startTime = 1[s], period = 100[s], width = 1, pulse = Logic.'1', quiet = Logic.'0');
  Table reset(x = {Logic.'0', Logic.'1', Logic.'0'}, t = {0.1, 3, 3.5}, y0 = Logic.'1');
  Nor q, qn;
equation
  connect(reset.y, q.x[1]);
  connect(qn.y, q.x[2]);
  connect(set.y, qn.x[1]);
  connect(q.y, qn.x[2]);
""",
        stop_time=5,
    )
    settled = result.times > 0.01
    high = (result.times > 1) & (result.times < 3)
    away = settled & (np.abs(result.times - 1) > 1e-6) & (np.abs(result.times - 3) > 1e-6)
    expected = np.where(high, LITERALS.index("1") + 1, LITERALS.index("0") + 1)
    assert np.array_equal(values(result, "q.y")[away], expected[away])


def test_clock() -> None:
    result = run("  DigitalClock clock(period = 0.25[s], width = 40, startTime = 0.1[s]);")
    starts = 0.1 + 0.25 * np.arange(4)
    expected = np.sort(np.concatenate([starts, starts + 0.1]))
    assert changes(result, "clock.y") == pytest.approx(expected[expected < 1])


@pytest.mark.parametrize("bits", [3, 8])
def test_converters_round_to_steps(bits: int) -> None:
    result = run(
        f"""
  parameter Integer N = {bits};
  electrical.AD_Converter adc(N = N, VRefHigh = 10[V]);
  electrical.DA_Converter dac(N = N, Vref = 10[V]);
  electrical.RampVoltage ramp(V = 9.87[V], duration = 1[s]);
  electrical.Resistor load(R = 1[Ohm]);
  electrical.Ground ground;
  DigitalClock clock(period = 0.01[s]);
equation
  connect(ramp.p, adc.p);
  connect(dac.p, load.p);
  connect(ramp.n, adc.n, dac.n, load.n, ground.p);
  connect(clock.y, adc.trig, dac.trig);
  connect(adc.y, dac.x);
""",
        points=1001,
    )
    # both converters act in the same event, the second on what the first has just read
    step, slope = 10 / (2**bits - 1), 9.87
    instants = 0.01 * np.floor(result.times / 0.01 + 1e-9)
    away = (result.times - instants > 1e-6) & (result.times > 0.01)
    expected = step * np.round(slope * instants / step)
    assert values(result, "load.v")[away] == pytest.approx(expected[away], abs=1e-9)
