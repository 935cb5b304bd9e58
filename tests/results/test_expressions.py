"""Expressions of variables, arithmetic of trajectories, numbers taken from them."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import acausal as ac
from acausal.diagnostics import AcausalError
from acausal.results import Result, Trajectory
from acausal.results.expressions import is_expression, paths_within
from acausal.results.table import TableSource

T = np.linspace(0.0, 1.0, 1001)
MODEL = """
model Circuit
  parameter Real R(unit = "Ohm") = 5;
  Real v(unit = "V", start = 1, fixed = true);
  Real i(unit = "A");
  Real x[3](each unit = "m");
  Real m[2, 2];
equation
  der(v) = -v/1[s];
  i = v/R;
  for k in 1:3 loop
    x[k] = k*time*1[m];
  end for;
  m = {{1, 2}, {3, 4}}*time;
end Circuit;
"""


@pytest.fixture(scope="module")
def result() -> Result:
    return ac.compile_text(MODEL).simulate(stop_time=1.0)


def code(error: pytest.ExceptionInfo[AcausalError]) -> str:
    return error.value.diagnostics[0].code


@pytest.mark.parametrize(
    ("text", "expected", "unit"),
    [
        ("v*i", lambda v, t: v * v / 5, "W"),
        ("v*i + 2[W]", lambda v, t: v * v / 5 + 2, "W"),
        ("v + 250[mV]", lambda v, t: v + 0.25, "V"),
        ("der(v)", lambda v, t: -v, "V/s"),
        ("der(v*v)", lambda v, t: -2 * v * v, "V2/s"),
        ("R*i^2", lambda v, t: v * v / 5, "W"),
        ("sum(x)", lambda v, t: 6 * t, "m"),
        ("sum(x[2:3])", lambda v, t: 5 * t, "m"),
        ("x[end] - x[1]", lambda v, t: 2 * t, "m"),
        ("x*x", lambda v, t: 14 * t * t, "m2"),
        ("max(x[*])", lambda v, t: 3 * t, "m"),
        ("sum(x[k]*k for k in 1:3)", lambda v, t: 14 * t, "m"),
        ("m[2, 1] + m[1, 2]", lambda v, t: 5 * t, ""),
        ("sum(m[:, 2])", lambda v, t: 6 * t, ""),
        ("if time < 0.5 then v else 0", lambda v, t: np.where(t < 0.5, v, 0), "V"),
        ("sin(constants.pi*time)", lambda v, t: np.sin(np.pi * t), "1"),
        ("sqrt(v^2)", lambda v, t: v, "V"),
        ("exp(-v/1[V])", lambda v, t: np.exp(-v), "1"),
        ("v > 0.5[V]", lambda v, t: 1.0 * (v > 0.5), ""),
        ("i", lambda v, t: v / 5, "A"),
    ],
)
def test_expressions(result, text, expected, unit):
    value = result.evaluate(text)
    v, t = result["v"].values, result.times
    slack = 2e-4 if "der" in text else 2e-6
    np.testing.assert_allclose(value.values, expected(v, t), rtol=1e-6, atol=slack)
    assert value.unit == unit
    assert value.path == text


def test_arrays_are_dictionaries(result):
    doubled = result.evaluate("2*x")
    assert list(doubled) == ["(2*x)[1]", "(2*x)[2]", "(2*x)[3]"]
    np.testing.assert_allclose(doubled["(2*x)[3]"].values, 6 * result.times)
    assert len(result.evaluate("m*{1, 2}")) == 2
    mixed = result.evaluate("{v, i*1[Ohm]}")
    assert [x.unit for x in mixed.values()] == ["V", "V"]


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("v + i", "U101"),
        ("exp(v)", "U103"),
        ("w + 1", "N901"),
        ("v +", "P001"),
        ("sin(v, i)", "T120"),
        ("x + m", "T105"),
        ("x[4]", "N901"),
        ("sample(0, 1)", "E008"),
        ("pre(v)", "E008"),
        ("der(i)", "N901"),
        ('"text"', "T101"),
    ],
)
def test_mistakes_in_expressions(result, text, wanted):
    paths = result.variables.paths()
    columns = {p: result[p].values for p in paths}
    source = TableSource(columns, {p: result[p].unit for p in paths})
    written = Result("M", "", result.times, source)
    with pytest.raises(AcausalError) as error:
        (written if text == "der(i)" else result).evaluate(text)
    diagnostic = error.value.diagnostics[0]
    assert diagnostic.code[0] == wanted[0]
    assert diagnostic.code == wanted or wanted == "T105"
    assert any(text in note for note in diagnostic.notes)


def test_expressions_in_plots_files_and_selections(result, tmp_path):
    figure = result.plot("v", "v*i", "R*i")
    assert [ax.get_ylabel() for ax in figure.get_axes()] == ["[V]", "v*i [W]"]
    result.write(tmp_path / "a.csv", "v*i", "v")
    back = ac.read_result(tmp_path / "a.csv")
    assert list(back.variables.paths()) == ["v*i", "v"]
    assert back["v*i"].unit == "W"
    np.testing.assert_array_equal(back["v*i"].values, result.evaluate("v*i").values)
    few = ac.compile_text(MODEL).simulate(stop_time=1.0, variables=["v*i", "der(v)*2"])
    assert set(few.variables.paths()) == {"v", "i", "der(v)"}
    np.testing.assert_allclose(few.evaluate("v*i").values, result.evaluate("v*i").values)


def test_what_is_an_expression(result):
    for text in ("v", "x[1]", "x[*]", "c.v", "link[2:3].*", "der(v)", "*"):
        assert not is_expression(text), text
    for text in ("v*i", "v * i", "2*v", "v+1", "sin(v)", "-v", "x[1]/2", "v > 1"):
        assert is_expression(text), text
    assert paths_within("der(v)*x[2] + i", result.variables.find) == ["v", "der(v)", "x[2]", "i"]


def wave(unit: str = "V") -> Trajectory:
    return Trajectory("v", T, np.sin(4 * np.pi * T), unit)


def test_arithmetic_carries_units():
    v, i = wave(), Trajectory("i", T, np.cos(4 * np.pi * T), "A")
    assert ((v * i).unit, (v / i).unit, (1 / v).unit, (v**2).unit) == ("W", "Ohm", "1/V", "V2")
    assert (v.to("mV") * i).unit == "W"
    np.testing.assert_allclose((v.to("mV") * i).values, (v * i).values)
    np.testing.assert_allclose((v + v.to("mV")).values, 2 * v.values)
    np.testing.assert_allclose((v.to("mV") + v).values, 2000 * v.values)
    assert (v.to("mV") + v).unit == "mV"
    assert (np.float64(2) * v).unit == "V"
    assert isinstance(np.sin(v), np.ndarray)
    assert isinstance(v * np.ones(len(T)), np.ndarray)
    assert (1 - 2 * v).path == "1 - (2*v)"
    assert abs(-v).values.min() == 0
    assert (v / v).unit == "1"
    assert Trajectory("T", T, T + 273.15, "K").to("degC").values[0] == pytest.approx(0)
    for wrong in (lambda: v + i, lambda: v.to("A"), lambda: 2**v):
        with pytest.raises(AcausalError) as error:
            wrong()
        assert code(error) in ("U101", "U103")
    with pytest.raises(AcausalError) as error:
        v.to("Volz")
    assert code(error) == "U104"
    with pytest.raises(AcausalError) as error:
        v - Trajectory("w", T[:-1], T[:-1], "V")
    assert code(error) == "F212"
    other = Trajectory("w", T[::10], T[::10], "V")
    assert len(other - v.sampled(other.time)) == len(other)


def test_numbers_taken_from_a_variable():
    v = wave()
    assert v.max() == pytest.approx(1.0)
    assert v.max().time == pytest.approx(0.125)
    assert v.min().time == pytest.approx(0.375)
    assert np.max(v) == v.max()
    assert pickle.loads(pickle.dumps(v.max())).time == v.max().time
    assert v.mean() == pytest.approx(0, abs=1e-12)
    assert np.mean(v) == v.mean()
    assert v.rms() == pytest.approx(np.sqrt(0.5), rel=1e-4)
    np.testing.assert_allclose(v.crossings(0.5, 1), [1 / 24, 13 / 24], atol=1e-5)
    np.testing.assert_allclose(v.crossings(0.5), np.array([1, 5, 13, 17]) / 24, atol=1e-5)
    assert v.period(0.3) == pytest.approx(0.5, rel=1e-6)
    assert v.integral().unit == "Wb"
    assert v.integral().max() == pytest.approx(1 / (2 * np.pi), rel=1e-4)
    step = Trajectory("y", 10 * T, 1 - np.exp(-10 * T), "")
    assert step.settle_time(0.02, final=1.0) == pytest.approx(np.log(50), rel=1e-3)
    assert np.isnan(Trajectory("t", T, T).period())


def test_means_are_over_time_not_over_points():
    uneven = Trajectory("x", np.array([0.0, 1.0, 1.0, 1.1, 10.0]), np.array([0.0, 0, 1, 1, 1]))
    assert uneven.mean() == pytest.approx(0.9)
    assert uneven.rms() == pytest.approx(np.sqrt(0.9))
    (jump,) = uneven.jumps()
    assert (jump.time, jump.before, jump.after) == (1.0, 0.0, 1.0)
    assert uneven(1.0, "before") == 0.0
    assert uneven(1.0) == 1.0
    with pytest.raises(AcausalError):
        uneven(1.0, "left")


@given(st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=30), st.floats(-1e6, 1e6))
def test_crossings_are_where_the_line_is(values, level):
    x = Trajectory("x", np.arange(float(len(values))), np.array(values))
    for time in x.crossings(level):
        assert x(time) == pytest.approx(level, abs=1e-6 * (1 + np.ptp(values)))
