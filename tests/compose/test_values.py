# ruff: noqa: C408 - dict() is how modifiers are written
"""What Python's values become: units, quantities, arrays, enumerations, subscripts."""

from __future__ import annotations

import numpy as np
import pint
import pytest

import acausal as ac
from acausal.library import blocks, constants, si
from acausal.library import electrical as el

units = pint.UnitRegistry()


def declaration(part, name="x"):
    """Return a component as it is written in the text."""
    model = ac.Model("m")
    model.add(name, part)
    return model.to_acm().splitlines()[-2].strip().removesuffix(";")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (5, "5"),
        (5.5, "5.5"),
        (-2, "-2"),
        (np.float64(3.0), "3.0"),
        (np.int32(3), "3"),
        ("10[kOhm]", "10[kOhm]"),
        ("1e-3 [MOhm]", "0.001[MOhm]"),
        ("7", "7"),
        ("2*5[Ohm]", "2*5[Ohm]"),
        (10 * units.kiloohm, "10.0[kOhm]"),
        (3 * units.volt / units.milliampere, "3.0[V/mA]"),
        (True, "true"),
        (float("inf"), "constants.inf"),
        (2 * constants.pi, "2*constants.pi"),
    ],
)
def test_values_of_parameters(value, text):
    assert declaration(el.Resistor(R=value)) == f"electrical.Resistor x(R = {text})"


@pytest.mark.parametrize(
    ("quantity", "si_value"),
    [
        (units.Quantity(20, "degC"), 293.15),
        (5 * units.foot, 1.524),
        (60 * units.rpm, 2 * np.pi),
        (1 * units.pound * units.foot / units.second**2, 0.45359237 * 0.3048),
        (90 * units.degree, np.pi / 2),
        (2 * units.dimensionless, 2),
    ],
)
def test_quantities_are_converted(quantity, si_value):
    model = ac.Model("m")
    model.x = ac.Variable(quantity)
    model.y = ac.Variable(start=0, fixed=True)
    model.equation(ac.der(model.y) == 0)
    assert model.simulate()["x"].values[0] == pytest.approx(si_value, rel=1e-12)


def test_quantities_are_checked():
    model = ac.Model("m")
    model.c = el.Capacitor(C=10 * units.ohm)
    with pytest.raises(ac.AcausalError) as caught:
        model.compile()
    assert caught.value.diagnostics[0].code == "U102"


def test_attributes_and_nested_modifiers():
    text = declaration(el.Capacitor(C=ac.mod(1e-6, min=0), v=dict(start=5, fixed=True)))
    assert text == "electrical.Capacitor x(C(min = 0) = 1e-06, v(start = 5, fixed = true))"
    text = declaration(ac.Variable(unit="m", start="1[cm]", state_select="prefer", shape=3))
    assert text == (
        'Real x[3](each unit = "m", each start = 1[cm], each stateSelect = StateSelect.prefer)'
    )


def test_arrays_of_components():
    values = np.array([1.0, 2.0])
    text = declaration(el.Resistor(R=values, alpha=0.5, shape=2))
    assert text == "electrical.Resistor x[2](R = {1.0, 2.0}, each alpha = 0.5)"
    text = declaration(el.Resistor(R=np.array([[1, 2, 3], [4, 5, 6]]), shape=(2, 3)))
    assert text == "electrical.Resistor x[2, 3](R = {{1, 2, 3}, {4, 5, 6}})"
    quantity = units.Quantity([1.0, 2.0], "kohm")
    text = declaration(el.Resistor(R=quantity, shape=2))
    assert text == "electrical.Resistor x[2](R = {1.0[kOhm], 2.0[kOhm]})"


def test_enumerations_types_and_texts():
    text = declaration(blocks.PI(initType=blocks.Init.SteadyState))
    assert text == "blocks.PI x(initType = blocks.Init.SteadyState)"
    assert declaration(ac.Parameter(3, type=si.Mass)) == "parameter si.Mass x = 3"
    assert declaration(ac.Parameter(blocks.Init.NoInit)) == (
        "parameter blocks.Init x = blocks.Init.NoInit"
    )
    assert declaration(ac.Parameter("a text")) == 'parameter String x = "a text"'
    assert declaration(ac.Parameter("2[kg]")) == "parameter Real x = 2[kg]"
    assert declaration(ac.Parameter(True)) == "parameter Boolean x = true"
    assert declaration(ac.Parameter(2, shape=2)) == "parameter Real x[2] = fill(2, 2)"
    assert float(constants.pi) == np.pi


@pytest.mark.parametrize(
    ("index", "text"),
    [
        (0, "1"),
        (-1, "5"),
        (slice(None), ":"),
        (slice(None, -1), "1:4"),
        (slice(1, None), "2:5"),
        (slice(None, None, 2), "1:2:5"),
        (slice(None, None, -1), "5:-1:1"),
        ([0, 3], "{1, 4}"),
        (np.array([True, False, False, True, False]), "{1, 4}"),
    ],
)
def test_subscripts_count_from_zero(index, text):
    model = ac.Model("m")
    model.x = ac.Variable(shape=5)
    assert repr(model.x[index]) == f"x[{text}]"


def test_subscripts_of_unknown_sizes():
    class Line(ac.Component):
        n = ac.Parameter(4, type=int)
        x = ac.Variable(shape=n)

    line = Line()
    assert repr(line.x[-1]).endswith("x[end]")
    assert repr(line.x[-2]).endswith("x[end - 1]")
    assert repr(line.x[:-1]).endswith("x[1:end - 1]")
    assert repr(line.x[1:]).endswith("x[2:end]")


def test_operators_act_element_by_element():
    model = ac.Model("m")
    model.x, model.y, model.s = ac.Variable(shape=3), ac.Variable(shape=3), ac.Variable()
    x, y, s = model.x, model.y, model.s
    assert repr(x * y) == "x .* y"
    assert repr(s * y) == "s*y"
    assert repr(x @ y) == "x*y"
    assert repr(x + s) == "x .+ s"
    assert repr(1 / x) == "1 ./ x"
    assert repr(x**2) == "x .^ 2"
    assert repr(np.array([1.0, 2.0, 3.0]) * x) == "{1.0, 2.0, 3.0} .* x"
    assert repr(np.float64(2) * s) == "2.0*s"
    assert repr(np.sin(s) - np.exp(-s)) == "sin(s) - exp(-s)"
    assert repr((s > 1) & ~(s < 2) | (s != 3)) == "s > 1 and not s < 2 or s <> 3"


def test_long_sums():
    model = ac.Model("m")
    model.x = ac.Variable(shape=1000)
    model.s = ac.Variable()
    model.k = ac.Parameter(np.arange(1000.0), shape=1000)
    model.equation(model.x == model.k)
    model.equation(model.s == sum(model.x[k] for k in range(1000)))
    assert model.simulate()["s"].values[0] == 499500


def test_functions_of_numbers_are_numbers():
    assert ac.sin(0.5) == np.sin(0.5)
    assert ac.max(1, 3) == 3
    assert ac.sum([1, 2]) == 3
