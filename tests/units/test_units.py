"""Units: reading, conversion, dimensions, and agreement with pint."""

from __future__ import annotations

import math
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from acausal.units import (
    DIMENSIONLESS,
    UnitError,
    divide,
    format_dimension,
    from_si,
    generate,
    multiply,
    parse_unit,
    power,
    root,
    same_dimension,
    table,
    to_si,
)

# Modelica text, the same in pint's words.
PAIRS = [
    ("N.m/rad", "newton*meter/radian"),
    ("m/s2", "meter/second**2"),
    ("kg.m2", "kilogram*meter**2"),
    ("W/(m2.K)", "watt/(meter**2*kelvin)"),
    ("1/min", "1/minute"),
    ("K-1", "1/kelvin"),
    ("kOhm", "kiloohm"),
    ("uF", "microfarad"),
    ("mH", "millihenry"),
    ("%", "percent"),
    ("bar", "bar"),
    ("mbar", "millibar"),
    ("l/min", "liter/minute"),
    ("rpm", "revolutions_per_minute"),
    ("deg", "degree"),
    ("Hz", "hertz"),
    ("km/h", "kilometer/hour"),
    ("V.s", "volt*second"),
    ("Wb", "weber"),
    ("T", "tesla"),
    ("mm", "millimeter"),
    ("cm3", "centimeter**3"),
    ("A/V", "ampere/volt"),
    ("kW.h", "kilowatt*hour"),
    ("kWh", "kilowatt_hour"),
    ("N.s/m", "newton*second/meter"),
    ("J/(kg.K)", "joule/(kilogram*kelvin)"),
    ("Pa.s", "pascal*second"),
    ("mA", "milliampere"),
    ("MPa", "megapascal"),
    ("daN", "dekanewton"),
    ("rev/min", "revolution/minute"),
    ("m3/(Pa.s)", "meter**3/(pascal*second)"),
    ("inch", "inch"),
    ("furlong", "furlong"),
]


@pytest.fixture(scope="module")
def registry():
    import pint

    return pint.UnitRegistry()


@pytest.mark.parametrize(("ours", "theirs"), PAIRS)
def test_agrees_with_pint(registry, ours, theirs):
    quantity = registry.Quantity(1.0, registry.parse_units(theirs)).to_base_units()
    unit = parse_unit(ours)
    assert unit.factor == pytest.approx(quantity.magnitude, rel=1e-14)
    assert unit.offset == 0
    names = ["mass", "length", "time", "current", "temperature", "substance", "luminosity"]
    dimensionality = dict(quantity.dimensionality)
    assert unit.dimension == tuple(dimensionality.get(f"[{n}]", 0) for n in names)


def test_table_is_what_pint_says():
    assert Path(table.__file__).read_text(encoding="utf-8") == generate.table_source()


def test_common_units_need_no_pint():
    units = [ours for ours, _ in PAIRS if ours != "furlong"] + ["degC"]
    code = (
        "import sys; from acausal.units import parse_unit\n"
        f"for u in {units!r}: parse_unit(u)\n"
        "print([m for m in ('pint', 'numpy') if m in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("value", "unit", "si"),
    [
        (20, "degC", 293.15),
        (-40, "degF", 233.15),
        (10, "kOhm", 1e4),
        (76, "mm", 0.076),
        (25, "N/mm", 25e3),
        (1, "mm3", 1e-9),
        (1, "kg", 1.0),
        (180, "deg", math.pi),
        (3600, "km/h", 1000.0),
        (60, "rpm", 2 * math.pi),
        (5, "W/degC", 5.0),
    ],
)
def test_to_si_and_back(value, unit, si):
    unit = parse_unit(unit)
    assert to_si(value, unit) == pytest.approx(si, rel=1e-15)
    assert from_si(to_si(value, unit), unit) == pytest.approx(value, rel=1e-13)


def test_arrays_convert():
    values = to_si(np.array([0.0, 100.0]), parse_unit("degC"))
    np.testing.assert_allclose(values, [273.15, 373.15])


def test_angles_are_dimensionless_and_hertz_is_per_second():
    assert parse_unit("rad").dimension == DIMENSIONLESS == parse_unit("deg").dimension
    assert same_dimension(parse_unit("Hz").dimension, parse_unit("1/s").dimension)
    assert same_dimension(parse_unit("rad/s").dimension, parse_unit("1/s").dimension)
    assert not same_dimension(parse_unit("m").dimension, parse_unit("s").dimension)


def test_prefixes_do_not_hide_symbols():
    assert parse_unit("min").factor == 60  # not milli-inch
    assert parse_unit("Pa").dimension == parse_unit("N/m2").dimension  # not peta-year
    assert parse_unit("cd").dimension[6] == 1  # not centi-day
    assert parse_unit("mm").factor == 1e-3
    assert parse_unit("mmol").factor == 1e-3


@pytest.mark.parametrize(
    "text",
    ["", " ", "N.", "N m", "/s", "m//s", "(m", "m)", "m0", "10", "V/m.s", "J/kg/K", "ohmz", "dB",
     "byte", "C2x", "m^(1/0)", "Kg", "é!", "()", "m.(", "1.", "foo/s", "mm99999"],
)  # fmt: skip
def test_wrong_units_are_refused(text):
    with pytest.raises(UnitError):
        parse_unit(text)


@pytest.mark.parametrize(
    ("text", "suggestion"),
    [
        ("Volt", "V"), ("J/kg.K", "J/(kg.K)"), ("W/m2/K", "W/(m2.K)"), ("hz", "Hz"),
        ("mhz", "MHz"), ("Kg", "kg"), ("khm", "kOhm"),
    ],
)  # fmt: skip
def test_suggestions(text, suggestion):
    if text == "Volt":
        assert parse_unit("volt").factor == 1  # a word that pint knows
    with pytest.raises(UnitError) as caught:
        parse_unit(text)
    assert suggestion in caught.value.suggestions
    assert "did you mean" in str(caught.value)


@pytest.mark.parametrize(
    ("unit", "text"),
    [
        ("V", "V"), ("N.m", "N.m"), ("J", "N.m"), ("kg.m2/s", "kg.m2/s"), ("A/s", "A/s"),
        ("rad", "1"), ("rad/s", "1/s"), ("m/s2", "m/s2"), ("kg.m2", "kg.m2"), ("W/K", "W/K"),
        ("N.s/m", "N.s/m"), ("Ohm.m", "Ohm.m"), ("J/(kg.K)", "J/(kg.K)"), ("K-1", "1/K"),
        ("m3/s", "m3/s"), ("Pa.s", "Pa.s"), ("W/(m2.K)", "W/(m2.K)"), ("V.s", "Wb"),
    ],
)  # fmt: skip
def test_format_dimension(unit, text):
    assert format_dimension(parse_unit(unit).dimension) == text


def test_roots_are_exact():
    dimension = root(parse_unit("m2/s").dimension, 2)
    assert dimension[1] == 1
    assert isinstance(dimension[1], int)
    assert dimension[2] == Fraction(-1, 2)
    assert power(dimension, 2) == parse_unit("m2/s").dimension
    assert format_dimension(dimension) == "m/s^(1/2)"


exponents = st.integers(-4, 4)
dimensions = st.tuples(*[exponents] * 7)


@given(dimensions)
def test_formatted_dimension_reads_back(dimension):
    assert parse_unit(format_dimension(dimension)).dimension == dimension


@given(dimensions, st.integers(1, 3))
def test_formatted_root_reads_back(dimension, degree):
    fractional = root(dimension, degree)
    assert parse_unit(format_dimension(fractional)).dimension == fractional


@given(dimensions, dimensions)
def test_product_and_quotient_undo_each_other(a, b):
    assert divide(multiply(a, b), b) == a


@given(st.text(alphabet="NmkgsVAK.()/^-+ 123°C%", max_size=12))
def test_any_text_is_a_unit_or_a_unit_error(text):
    try:
        unit = parse_unit(text)
    except UnitError:
        return
    assert unit.factor > 0
