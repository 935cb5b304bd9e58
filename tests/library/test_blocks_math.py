"""Functions of signals against NumPy, comparisons, conversions, bundles of signals."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.blocks_runs import jumps, run, values

FUNCTIONS = {
    "Sign": np.sign, "Abs": np.abs, "Sin": np.sin, "Cos": np.cos, "Tan": np.tan, "Atan": np.arctan,
    "Sinh": np.sinh, "Cosh": np.cosh, "Tanh": np.tanh, "Exp": np.exp,
}  # fmt: skip
INSIDE = {"Asin": np.arcsin, "Acos": np.arccos}
POSITIVE = {"Sqrt": np.sqrt, "Log": np.log, "Log10": np.log10}


def test_functions_of_one_signal() -> None:
    groups = {"wide": FUNCTIONS, "narrow": INSIDE, "above": POSITIVE}
    lines = [
        "blocks.Ramp wide(height = 2.9, duration = 1, offset = -1.45);",
        "blocks.Ramp narrow(height = 1.8, duration = 1, offset = -0.9);",
        "blocks.Ramp above(height = 5, duration = 1, offset = 0.1);",
        *(f"blocks.{name} f{name};" for group in groups.values() for name in group),
        "equation",
        *(f"connect({s}.y, f{n}.u);" for s, group in groups.items() for n in group),
    ]
    result = run("\n".join(lines))
    for source, group in groups.items():
        u = values(result, f"{source}.y")
        for name, function in group.items():
            assert values(result, f"f{name}.y") == pytest.approx(function(u), rel=1e-9, abs=1e-9)


def test_functions_of_several_signals() -> None:
    result = run("""
      blocks.Sine a(f = 1, amplitude = 2), b(f = 2, offset = 3);
      blocks.Division division; blocks.Max larger; blocks.Min smaller; blocks.Atan2 angle;
      blocks.Power power(base = 3); blocks.Exponentiation raised;
      blocks.Sum sum_(nin = 2, k = {2, -1}); blocks.MatrixGain matrix(K = [1, 2; 3, 4; 5, 6]);
    equation
      connect(a.y, division.u1, larger.u1, smaller.u1, angle.u1, power.u, raised.u2, sum_.u[1],
        matrix.u[1]);
      connect(b.y, division.u2, larger.u2, smaller.u2, angle.u2, raised.u1, sum_.u[2], matrix.u[2]);
    """)
    a, b = values(result, "a.y"), values(result, "b.y")
    expected = {
        "division.y": a / b,
        "larger.y": np.maximum(a, b),
        "smaller.y": np.minimum(a, b),
        "angle.y": np.arctan2(a, b),
        "power.y": 3**a,
        "raised.y": b**a,
        "sum_.y": 2 * a - b,
        "matrix.y[1]": a + 2 * b,
        "matrix.y[3]": 5 * a + 6 * b,
    }
    for path, wanted in expected.items():
        assert values(result, path) == pytest.approx(wanted, rel=1e-9, abs=1e-9), path


def test_comparisons_and_types() -> None:
    result = run("""
      blocks.Ramp r(duration = 1); blocks.Constant half(k = 0.5);
      blocks.GreaterEqualThreshold ge(threshold = 0.25); blocks.LessThreshold lt(threshold = 0.75);
      blocks.Greater gt; blocks.LessEqual le; blocks.RealToBoolean rb(threshold = 0.6);
      blocks.IntegerStep n(height = 2, startTime = 0.4); blocks.IntegerToReal ir;
      blocks.IntegerToBoolean ib(threshold = 2); blocks.BooleanChange change;
      blocks.IntegerExpression e(y = 3*n.y + 1);
    equation
      connect(r.y, ge.u, lt.u, gt.u1, le.u1, rb.u);
      connect(half.y, gt.u2, le.u2);
      connect(n.y, ir.u, ib.u);
      connect(gt.y, change.u);
    """)
    for path, at, to in (
        ("ge.y", 0.25, 1), ("lt.y", 0.75, 0), ("gt.y", 0.5, 1), ("le.y", 0.5, 0),
        ("rb.y", 0.6, 1), ("ir.y", 0.4, 2), ("ib.y", 0.4, 1), ("e.y", 0.4, 7),
    ):  # fmt: skip
        ((time, value),) = jumps(result, path)
        assert time == pytest.approx(at, abs=1e-8), path
        assert value == to, path
    assert not values(result, "change.y")[-1]


UNITS = {
    "deg": 180 / np.pi,
    "rpm": 30 / np.pi,
    "kmh": 3.6,
    "bar": 1e-5,
    "kWh": 1 / 3.6e6,
    "litre": 1000.0,
}


def test_conversions_of_units_and_back() -> None:
    names = [*UNITS, "degC"]
    lines = ["blocks.Ramp r(height = 300, duration = 1, offset = 1);"]
    for n in names:
        lines.append(f"blocks.To_{n} to_{n}; blocks.From_{n} from_{n};")
    lines.append("equation")
    for n in names:
        lines.append(f"connect(r.y, to_{n}.u); connect(to_{n}.y, from_{n}.u);")
    result = run("\n".join(lines))
    u = values(result, "r.y")
    for n, factor in UNITS.items():
        assert values(result, f"to_{n}.y") == pytest.approx(factor * u, rel=1e-12), n
        assert values(result, f"from_{n}.y") == pytest.approx(u, rel=1e-12), n
    assert values(result, "to_degC.y") == pytest.approx(u - 273.15)
    assert values(result, "from_degC.y") == pytest.approx(u)


@pytest.mark.parametrize("size", [2, 3, 4, 5, 6])
def test_bundles_keep_the_order(size: int) -> None:
    sizes = [1 + k % 2 for k in range(size)]
    given = ", ".join(f"n{k} = {n}" for k, n in enumerate(sizes, 1))
    lines = [f"blocks.Multiplex{size} m({given});", f"blocks.DeMultiplex{size} d({given});"]
    lines.append("equation")
    number = 0
    for k, n in enumerate(sizes, 1):
        for j in range(1, n + 1):
            number += 1
            lines.append(f"m.u{k}[{j}] = {number} + time;")
    lines.append("connect(m.y, d.u);")
    result = run("\n".join(lines))
    number = 0
    for k, n in enumerate(sizes, 1):
        for j in range(1, n + 1):
            number += 1
            assert values(result, f"m.y[{number}]")[-1] == pytest.approx(number + 1)
            assert values(result, f"d.y{k}[{j}]")[-1] == pytest.approx(number + 1)


def test_any_number_of_signals() -> None:
    result = run("""
      blocks.Multiplex m(n = 3); blocks.DeMultiplex d(n = 3);
      blocks.RealPassThrough real_; blocks.IntegerPassThrough whole;
      blocks.BooleanPassThrough truth;
      blocks.IntegerReplicator copies(nout = 2); blocks.IntegerConstant n(k = 7);
      blocks.BooleanConstant yes; blocks.ContinuousClock clock(offset = 1, startTime = 0.5);
    equation
      m.u = {1, 2, 3}*time;
      connect(m.y, d.u);
      connect(clock.y, real_.u);
      connect(n.y, whole.u, copies.u);
      connect(yes.y, truth.u);
    """)
    assert [values(result, f"d.y[{k}]")[-1] for k in (1, 2, 3)] == pytest.approx([1, 2, 3])
    times = np.asarray(result.times)
    assert values(result, "real_.y") == pytest.approx(1 + np.maximum(0, times - 0.5))
    assert values(result, "whole.y")[-1] == 7
    assert [values(result, f"copies.y[{k}]")[-1] for k in (1, 2)] == [7, 7]
    assert values(result, "truth.y")[-1] == 1


def test_cosine_of_variable_frequency() -> None:
    result = run("""
      blocks.CosineVariableFrequencyAndAmplitude c(constantFrequency = 2,
        useConstantFrequency = true, useConstantAmplitude = true, constantAmplitude = 3,
        offset = 1, phi(start = 0, fixed = true));
    """)
    times = np.asarray(result.times)
    assert values(result, "c.y") == pytest.approx(1 + 3 * np.cos(4 * np.pi * times), abs=1e-6)


def test_variance_of_a_ramp_and_of_a_sine() -> None:
    result = run("""
      blocks.Ramp r(height = 4, duration = 1); blocks.Sine s(f = 10, amplitude = 3, offset = 20);
      blocks.Variance ramp; blocks.StandardDeviation sine;
    equation
      connect(r.y, ramp.u);
      connect(s.y, sine.u);
    """)
    times = np.asarray(result.times)
    late = times > 0.05
    assert values(result, "ramp.y")[late] == pytest.approx((4 * times[late]) ** 2 / 12, abs=1e-5)
    assert values(result, "sine.y")[-1] == pytest.approx(3 / np.sqrt(2), abs=1e-4)


def test_lookups_of_a_vector_are_single_lookups() -> None:
    result = run("""
      parameter Real map[4, 4] = [0, 0, 1, 2; 0, 1, 2, 4; 1, 2, 5, 7; 2, 3, 9, 8];
      blocks.CombiTable2Dv both(n = 2, table = map); blocks.CombiTable2Ds one(table = map);
    equation
      both.u1 = {2*time, 0.5};
      both.u2 = {0.5 + time, 1.5};
      one.u1 = 2*time;
      one.u2 = 0.5 + time;
    """)
    assert values(result, "both.y[1]") == pytest.approx(values(result, "one.y"))
    assert values(result, "both.y[2]")[0] == pytest.approx((2 + 4 + 5 + 7) / 4)
    assert np.ptp(values(result, "one.y")) > 3


def test_steps_with_signals_are_steps() -> None:
    result = run("""
      inner blocks.state_graph.StateGraphRoot root;
      blocks.state_graph.InitialStepWithSignal first(nIn = 0); blocks.state_graph.StepWithSignal
        second(nOut = 0);
      blocks.state_graph.Transition go(condition = time > 0.3);
    equation
      connect(first.outPort[1], go.inPort);
      connect(go.outPort, second.inPort[1]);
    """)
    ((start, active),) = jumps(result, "second.active")
    assert (start, active) == (pytest.approx(0.3, abs=1e-8), 1)
    assert not values(result, "first.active")[-1]
