"""Logical blocks and sources switch at the moments that can be calculated."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.blocks_runs import after, jumps, run, values

TABLES = """
  blocks.BooleanTable a(table = {1, 2, 3, 4});
  blocks.BooleanTable b(table = {0.5, 2.5, 3.5}, startValue = true);
"""


@pytest.mark.parametrize(
    ("block", "function"),
    [
        ("And", lambda a, b: a and b),
        ("Or", lambda a, b: a or b),
        ("Xor", lambda a, b: a != b),
        ("Nor", lambda a, b: not (a or b)),
        ("Nand", lambda a, b: not (a and b)),
    ],
)
def test_gates(block: str, function: object) -> None:
    result = run(
        f"""{TABLES}
  blocks.{block} gate;
  blocks.math_boolean.{block} many(nu = 2);
equation
  connect(a.y, gate.u1, many.u[1]);
  connect(b.y, gate.u2, many.u[2]);
""",
        stop_time=5,
    )
    pairs = zip(values(result, "a.y"), values(result, "b.y"), strict=True)
    expected = [function(x, y) for x, y in pairs]  # type: ignore[operator]
    assert len(set(expected)) == 2
    assert values(result, "gate.y").tolist() == expected
    assert values(result, "many.y").tolist() == expected


def test_tables_switch_at_their_times() -> None:
    result = run(
        f"""{TABLES}
  blocks.BooleanTable c(table = {{1, 2, 4}}, extrapolation = blocks.Extrapolation.Periodic);
  blocks.BooleanTable d(table = {{1, 2}}, shiftTime = 0.25);
  blocks.IntegerTable n(table = [0, 5; 1, 7; 2.5, -3]);
""",
        stop_time=5.5,
    )
    assert jumps(result, "a.y") == [(1, 1), (2, 0), (3, 1), (4, 0)]
    assert jumps(result, "b.y") == [(0.5, 0), (2.5, 1), (3.5, 0)]
    assert jumps(result, "c.y") == [(1, 1), (2, 0), (4, 1), (5, 0)]
    assert jumps(result, "d.y") == [(1.25, 1), (2.25, 0)]
    assert jumps(result, "n.y") == [(1, 7), (2.5, -3)]


def test_pulses_and_steps() -> None:
    result = run(
        """
  blocks.BooleanPulse pulse(period = 0.3, width = 40, startTime = 0.1);
  blocks.BooleanStep up(startTime = 0.7), down(startTime = 0.2, startValue = true);
  blocks.IntegerStep step(height = -4, offset = 1, startTime = 0.6);
  blocks.BooleanConstant always;
  blocks.BooleanExpression e(y = pulse.y and up.y);
"""
    )
    found = jumps(result, "pulse.y")
    expected = [(0.1, 1), (0.22, 0), (0.4, 1), (0.52, 0), (0.7, 1), (0.82, 0), (1.0, 1)]
    assert [v for _, v in found] == [v for _, v in expected]
    assert [t for t, _ in found] == pytest.approx([t for t, _ in expected], rel=1e-14)
    assert jumps(result, "up.y") == [(0.7, 1)]
    assert jumps(result, "down.y") == [(0.2, 0)]
    assert jumps(result, "step.y") == [(0.6, -3)]
    assert set(values(result, "always.y")) == {1.0}
    assert jumps(result, "e.y")[0] == (pytest.approx(0.7), 1)


def test_a_long_train_of_pulses_loses_none() -> None:
    result = run(
        """
  blocks.BooleanPulse pulse(period = 0.01);
  blocks.SampleTrigger trigger(period = 0.01);
  blocks.IntegerConstant one;
  blocks.math_integer.TriggeredAdd pulses, samples;
equation
  connect(one.y, pulses.u, samples.u);
  connect(pulse.y, pulses.trigger);
  connect(trigger.y, samples.trigger);
""",
        stop_time=9.995,
    )
    # the pulse that begins at the start has no rising edge
    assert values(result, "pulses.y")[-1] == 999
    assert values(result, "samples.y")[-1] == 1000


SINE = "blocks.Sine sine(f = 1[Hz], amplitude = 2);"


def test_comparisons_switch_where_the_signal_passes() -> None:
    result = run(
        f"""{SINE}
  blocks.GreaterThreshold above(threshold = 1);
  blocks.LessEqualThreshold below(threshold = -1);
  blocks.Constant level(k = 1);
  blocks.Less less;
  blocks.GreaterEqual ge;
equation
  connect(sine.y, above.u, below.u, less.u1, ge.u1);
  connect(level.y, less.u2, ge.u2);
"""
    )
    up, down = 1 / 12, 5 / 12
    for path, times in (
        ("above.y", (up, down)),
        ("less.y", (up, down)),
        ("ge.y", (up, down)),
        ("below.y", (0.5 + up, 0.5 + down)),
    ):
        assert [t for t, _ in jumps(result, path)] == pytest.approx(times, abs=1e-9)
    assert [v for _, v in jumps(result, "less.y")] == [0, 1]


def test_hysteresis_and_two_point_control() -> None:
    result = run(
        f"""{SINE}
  blocks.Hysteresis hysteresis(uLow = -1, uHigh = 1);
  blocks.Constant reference(k = 0);
  blocks.OnOffController controller(bandwidth = 2);
equation
  connect(sine.y, hysteresis.u, controller.u);
  connect(reference.y, controller.reference);
"""
    )
    assert jumps(result, "hysteresis.y") == [
        (pytest.approx(1 / 12, abs=1e-9), 1),
        (pytest.approx(7 / 12, abs=1e-9), 0),
    ]
    # the controller starts switched off, the signal between its levels
    assert jumps(result, "controller.y") == [(pytest.approx(7 / 12, abs=1e-9), 1)]


def test_room_heating_cycles_between_its_levels() -> None:
    # T' = (20 u - T)/10: from 9 to 11 and back takes two logarithms
    result = run(
        """
  Real T(start = 10, fixed = true);
  blocks.OnOffController controller(bandwidth = 2, pre_y_start = true);
equation
  der(T) = ((if controller.y then 20 else 0) - T)/10;
  controller.u = T;
  controller.reference = 10;
""",
        stop_time=60,
        tolerance=1e-10,
    )
    heating, cooling = 10 * np.log(11 / 9), 10 * np.log(11 / 9)
    first = 10 * np.log(10 / 9)
    times = [t for t, _ in jumps(result, "controller.y")]
    expected = [first]
    while expected[-1] + cooling < 60:
        expected.append(expected[-1] + (cooling if len(expected) % 2 else heating))
    assert times == pytest.approx(expected, abs=1e-7)
    assert len(times) > 20


def test_edges_last_for_the_event_only() -> None:
    result = run(
        """
  blocks.BooleanTable table(table = {1, 2, 3});
  blocks.Edge rising;
  blocks.FallingEdge falling;
  blocks.Change changing;
  blocks.IntegerConstant one;
  blocks.math_integer.TriggeredAdd ups, downs, changes;
equation
  connect(table.y, rising.u, falling.u, changing.u);
  connect(one.y, ups.u, downs.u, changes.u);
  connect(rising.y, ups.trigger);
  connect(falling.y, downs.trigger);
  connect(changing.y, changes.trigger);
""",
        stop_time=4,
    )
    assert jumps(result, "ups.y") == [(1, 1), (3, 2)]
    assert jumps(result, "downs.y") == [(2, 1)]
    assert jumps(result, "changes.y") == [(1, 1), (2, 2), (3, 3)]


def test_zero_crossings_are_counted_while_enabled() -> None:
    result = run(
        f"""{SINE}
  blocks.BooleanTable enable(table = {{0.3, 1.2}});
  blocks.ZeroCrossing crossing;
  blocks.IntegerConstant one;
  blocks.math_integer.TriggeredAdd count;
equation
  connect(sine.y, crossing.u);
  connect(enable.y, crossing.enable);
  connect(crossing.y, count.trigger);
  connect(one.y, count.u);
""",
        stop_time=2,
    )
    assert [t for t, _ in jumps(result, "count.y")] == pytest.approx([0.5, 1.0], abs=1e-9)


def test_timer_and_delays() -> None:
    result = run(
        """
  blocks.BooleanTable table(table = {0.2, 0.5, 0.7, 0.75});
  blocks.Timer timer;
  blocks.LogicalDelay both(delayTime = 0.1);
  blocks.math_boolean.OnDelay on(delayTime = 0.1);
equation
  connect(table.y, timer.u, both.u, on.u);
"""
    )
    t = np.asarray(result.times)
    inside = (t > 0.2) & (t < 0.5)
    assert values(result, "timer.y")[inside] == pytest.approx(t[inside] - 0.2, abs=1e-12)
    assert after(result, "timer.y", 0.5) == 0
    for path in ("on.y", "both.y1"):
        assert jumps(result, path) == [(pytest.approx(0.3), 1), (0.5, 0)]
    assert jumps(result, "both.y2")[-3:] == [
        (pytest.approx(0.6), 0), (0.7, 1), (pytest.approx(0.85), 0)
    ]  # fmt: skip


def test_triggered_trapezoid_turns_round_where_it_is() -> None:
    result = run(
        """
  blocks.BooleanTable table(table = {0.1, 0.3, 0.4});
  blocks.TriggeredTrapezoid trapezoid(rising = 0.4, falling = 0.2, amplitude = 2, offset = 1);
equation
  connect(table.y, trapezoid.u);
"""
    )
    # up by 5 per second to 2, down by 10 per second to 1, up again from there
    corners = [(0, 1), (0.1, 1), (0.3, 2), (0.4, 1), (0.8, 3), (1, 3)]
    expected = np.interp(result.times, *zip(*corners, strict=True))
    assert values(result, "trapezoid.y") == pytest.approx(expected, abs=1e-9)


def test_flip_flop_remembers() -> None:
    result = run(
        """
  blocks.BooleanTable set_(table = {1, 1.5, 4, 4.5});
  blocks.BooleanTable reset(table = {2, 2.5, 3, 3.5});
  blocks.RSFlipFlop flipflop;
equation
  connect(set_.y, flipflop.S);
  connect(reset.y, flipflop.R);
""",
        stop_time=5,
    )
    assert jumps(result, "flipflop.Q") == [(1, 1), (2, 0), (4, 1)]
    assert (values(result, "flipflop.QI") == 1 - values(result, "flipflop.Q")).all()


def test_switches() -> None:
    result = run(
        """
  blocks.BooleanTable table(table = {0.25, 0.75});
  blocks.Ramp ramp(duration = 1);
  blocks.Constant seven(k = 7);
  blocks.Switch choice;
  blocks.BooleanToReal real_(realTrue = 3, realFalse = -1);
  blocks.BooleanToInteger integer_(integerTrue = 5, integerFalse = 2);
  blocks.MultiSwitch first(nu = 2, expr = {10*time, 20}, y_default = -1);
  blocks.math_integer.MultiSwitch kept(nu = 2, expr = {4, 6}, y_default = 2);
  blocks.BooleanStep late(startTime = 0.5);
equation
  connect(ramp.y, choice.u1);
  connect(table.y, choice.u2, real_.u, integer_.u, first.u[1], kept.u[1]);
  connect(seven.y, choice.u3);
  connect(late.y, first.u[2]);
  kept.u[2] = false;
"""
    )
    t = np.asarray(result.times)
    on = values(result, "table.y") == 1
    assert values(result, "choice.y") == pytest.approx(np.where(on, t, 7), abs=1e-12)
    assert jumps(result, "real_.y") == [(0.25, 3), (0.75, -1)]
    assert jumps(result, "integer_.y") == [(0.25, 5), (0.75, 2)]
    late = values(result, "late.y") == 1
    expected = np.where(on, 10 * t, np.where(late, 20, -1))
    assert values(result, "first.y") == pytest.approx(expected, abs=1e-12)
    assert jumps(result, "kept.y") == [(0.25, 4)]


def test_rounding_to_integers() -> None:
    result = run(
        """
  blocks.Ramp ramp(height = 5, offset = -2.5, duration = 1);
  blocks.RealToInteger rounded;
  blocks.Quantizer steps(q = 0.5);
equation
  connect(ramp.y, rounded.u, steps.u);
"""
    )
    found = jumps(result, "rounded.y")
    assert [t for t, _ in found][-4:] == pytest.approx([0.4, 0.6, 0.8, 1.0], abs=1e-12)
    assert [v for _, v in found][-4:] == [0, 1, 2, 3]
    u, y = values(result, "ramp.y"), values(result, "steps.y")
    assert np.abs(u - y).max() <= 0.25 + 1e-12


def test_radio_button_is_released_by_another() -> None:
    result = run(
        """
  blocks.RadioButtonSource one(buttonTimeTable = {1, 3}, nReset = 1);
  blocks.RadioButtonSource two(buttonTimeTable = {2, 4}, nReset = 1);
equation
  connect(one.on, two.reset[1]);
  connect(two.on, one.reset[1]);
""",
        stop_time=5,
    )
    assert jumps(result, "one.on") == [(1, 1), (2, 0), (3, 1), (4, 0)]
    assert jumps(result, "two.on") == [(2, 1), (3, 0), (4, 1)]


def test_simulation_ends_on_a_condition() -> None:
    result = run(
        """
  Real x(start = 1, fixed = true);
  blocks.TerminateSimulation low(condition = x < 0.5, terminationText = "x is low");
equation
  der(x) = -x;
""",
        stop_time=10,
    )
    assert result.times[-1] == pytest.approx(np.log(2), abs=1e-7)


def test_routing() -> None:
    result = run(
        """
  blocks.Ramp ramp(duration = 1);
  blocks.Replicator copies(nout = 3);
  blocks.ExtractSignal some(nin = 3, nout = 2, extract = {3, 1});
  blocks.Multiplex2 both(n1 = 2, n2 = 1);
  blocks.DeMultiplex2 apart(n1 = 1, n2 = 2);
  blocks.IntegerStep index(offset = 2, height = -1, startTime = 0.5);
  blocks.Extractor extractor(nin = 3);
  blocks.BooleanReplicator truths(nout = 2);
equation
  connect(ramp.y, copies.u);
  some.u = {1, 2, 3};
  connect(some.y, both.u1);
  both.u2 = {ramp.y};
  connect(both.y, apart.u, extractor.u);
  connect(index.y, extractor.index);
  truths.u = time > 0.5;
"""
    )
    t = np.asarray(result.times)
    assert values(result, "copies.y[3]") == pytest.approx(t, abs=1e-12)
    assert [values(result, f"both.y[{k}]")[0] for k in (1, 2, 3)] == [3, 1, 0]
    assert values(result, "apart.y1[1]")[0] == 3
    assert values(result, "apart.y2[2]") == pytest.approx(t, abs=1e-12)
    assert jumps(result, "extractor.y") == [(0.5, 3)]
    assert jumps(result, "truths.y[2]") == [(0.5, 1)]


def test_plane_vectors_and_angles() -> None:
    result = run(
        """
  blocks.PolarToRectangular there;
  blocks.RectangularToPolar back;
  blocks.Pythagoras side, leg(u1IsHypotenuse = true);
  blocks.WrapAngle wrapped, positive(positiveRange = true);
  Real phi(unit = "rad") = 10[rad/s]*time;
equation
  there.u_abs = 2;
  there.u_arg = phi;
  connect(there.y_re, back.u_re, side.u1, leg.u2);
  connect(there.y_im, back.u_im, side.u2);
  connect(side.y, leg.u1);
  wrapped.u = phi;
  positive.u = phi;
"""
    )
    t = np.asarray(result.times)
    away = np.abs((10 * t + np.pi) % (2 * np.pi)) > 1e-9
    angle = (10 * t + np.pi) % (2 * np.pi) - np.pi
    assert values(result, "back.y_abs") == pytest.approx(2, abs=1e-12)
    assert values(result, "back.y_arg")[away] == pytest.approx(angle[away], abs=1e-9)
    assert values(result, "wrapped.y")[away] == pytest.approx(angle[away], abs=1e-9)
    assert values(result, "leg.y") == pytest.approx(2 * np.abs(np.sin(10 * t)), abs=1e-6)
    wraps = np.flatnonzero(np.diff(values(result, "positive.y")) < -6)
    assert t[wraps] == pytest.approx([2 * np.pi / 10], abs=1e-12)


def test_texts_of_parameters_are_in_messages() -> None:
    body = """
  Real x(start = 1, fixed = true);
  blocks.TerminateSimulation low(condition = x < 0.5, terminationText = "x is low");
equation
  der(x) = -x;
"""
    result = run(body, stop_time=2)
    assert any("x is low" in event.text for event in result.events)
    result = run(
        """
  Real x(start = 1, fixed = true);
  blocks.AssertCondition a(condition = x > 0.5, assertionText = "x has become too small");
equation
  der(x) = -x;
""",
        stop_time=2,
    )
    assert "x has become too small" in result.diagnostics[0].message
