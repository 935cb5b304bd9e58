"""Other parameters and start values without compiling again give what compiling gives."""

from __future__ import annotations

import numpy as np
import pytest

from acausal import compile_text
from acausal.diagnostics import AcausalError

DECAY = """
model Decay
  parameter Real a = 2;
  parameter Real half = a/2;
  parameter Real x0 = 3*a;
  Real x(start = x0, fixed = true), y, z = -x;
equation
  der(x) = -half*x;
  y = 2*x + a;
end Decay;
"""

RLC = """
import electrical.*;
model RLC
  parameter Real factor = 1;
  ConstantVoltage source(V = 10);
  Resistor r[2](R = {factor*100, 50});
  Capacitor c(C = 1e-6, v(start = 0, fixed = true));
  Ground ground;
equation
  connect(source.p, r[1].p);
  connect(r[1].n, r[2].p);
  connect(r[2].n, c.p);
  connect(c.n, source.n, ground.p);
end RLC;
"""


def test_what_depends_on_a_parameter_follows() -> None:
    compiled = compile_text(DECAY)
    for a in (1.0, 4.0, 2.0):
        result = compiled.simulate(stop_time=1.0, tolerance=1e-9, parameters={"a": a})
        exact = 3 * a * np.exp(-a / 2 * result.times)
        assert result["x"].values == pytest.approx(exact, rel=1e-7)
        assert result["y"].values == pytest.approx(2 * exact + a, rel=1e-7)
        assert result["z"].values == pytest.approx(-exact, rel=1e-7)


def test_a_value_from_outside_wins_over_its_equation() -> None:
    compiled = compile_text(DECAY)
    result = compiled.simulate(stop_time=1.0, tolerance=1e-9, parameters={"half": 3.0, "a": 1.0})
    assert result["x"].values == pytest.approx(3 * np.exp(-3 * result.times), rel=1e-6, abs=1e-8)


def test_changes_add_up_and_leave_the_model_alone() -> None:
    compiled = compile_text(DECAY)
    both = compiled.with_values({"half": 3.0}).with_values({"a": 1.0})
    once = compiled.with_values({"half": 3.0, "a": 1.0})
    assert both.system.parameters.tolist() == once.system.parameters.tolist()
    plain = compiled.simulate(stop_time=1.0, tolerance=1e-9)
    assert plain["x"].values == pytest.approx(6 * np.exp(-plain.times), rel=1e-7)


def test_same_trajectory_as_compiled_with_the_values() -> None:
    given = {"factor": 2.0, "source.V": "1[kV]", "r[2].R": "1[kOhm]", "c.C": 2e-6}
    changed = compile_text(RLC).simulate(stop_time=5e-3, parameters=given)
    fresh = compile_text(RLC, parameters=given).simulate(stop_time=5e-3)
    assert np.array_equal(changed["c.v"].values, fresh["c.v"].values)
    tau = 1200 * 2e-6
    exact = 1000 * (1 - np.exp(-changed.times / tau))
    assert changed["c.v"].values == pytest.approx(exact, rel=1e-4, abs=1e-2)


def test_start_values() -> None:
    result = compile_text(RLC).simulate(stop_time=1e-3, start={"c.v": 4.0}, tolerance=1e-9)
    exact = 10 - 6 * np.exp(-result.times / 150e-6)
    assert result["c.v"].values == pytest.approx(exact, abs=1e-6)


def test_values_that_decide_about_the_structure() -> None:
    # Without its capacitance the circuit has no state; with a resistance of zero one.
    compiled = compile_text(RLC)
    result = compiled.simulate(stop_time=1e-3, parameters={"c.C": 0.0})
    assert result["c.v"].values == pytest.approx(10.0)
    again = compiled.simulate(stop_time=1e-3, tolerance=1e-9)
    exact = 10 * (1 - np.exp(-again.times / 150e-6))
    assert again["c.v"].values == pytest.approx(exact, abs=1e-6)


def test_a_structural_parameter_and_times_of_samples() -> None:
    compiled = compile_text("""
model Counter
  parameter Integer n = 2;
  parameter Real period = 0.25;
  Integer count(start = 0, fixed = true);
  Real x[n];
equation
  when sample(period, period) then
    count = pre(count) + 1;
  end when;
  for i in 1:n loop
    x[i] = i*count;
  end for;
end Counter;
""")
    result = compiled.simulate(stop_time=1.1, parameters={"n": 3, "period": 0.1})
    assert result["count"].values[-1] == 11
    assert result["x[3]"].values[-1] == 33
    assert compiled.simulate(stop_time=1.1)["count"].values[-1] == 4


def test_start_values_of_discrete_variables() -> None:
    compiled = compile_text("""
model Counter
  parameter Integer first = 5;
  parameter Real other = 1;
  discrete Real r(start = 10*other, fixed = true);
equation
  when time > 0.5 then
    r = pre(r) + 1;
  end when;
end Counter;
""")
    result = compiled.simulate(stop_time=1.0, parameters={"other": 2.0})
    assert result["r"].values[[0, -1]].tolist() == [20.0, 21.0]
    result = compiled.simulate(stop_time=1.0, start={"r": -1.0})
    assert result["r"].values[[0, -1]].tolist() == [-1.0, 0.0]


@pytest.mark.parametrize(
    ("options", "code"),
    [
        ({"parameters": {"r[3].R": 1.0}}, "N119"),
        ({"parameters": {"r[1].R": "3[m]"}}, "U108"),
        ({"start": {"c.w": 1.0}}, "N901"),
        ({"start": {"r[1].v": 1.0}}, "I012"),
        ({"parameters": {"c.C": "much"}}, "N102"),
    ],
)
def test_mistakes(options: dict[str, dict[str, float | str]], code: str) -> None:
    with pytest.raises(AcausalError) as error:
        compile_text(RLC).simulate(stop_time=1e-3, **options)  # type: ignore[arg-type]
    assert error.value.diagnostics[0].code == code


def test_parameters_of_a_result() -> None:
    result = compile_text(DECAY).simulate(stop_time=0.1, parameters={"a": 4.0})
    assert dict(result.parameters) == {"a": 4.0, "half": 2.0, "x0": 12.0}
    assert result.parameters["half"] == 2.0
