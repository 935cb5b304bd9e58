"""Write ``table.py`` from pint: ``python -m acausal.units.generate > acausal/units/table.py``."""

from __future__ import annotations

from acausal.units.pint_source import from_pint

#: Symbol in model text, pint's name, and whether SI prefixes may stand before it.
SYMBOLS: tuple[tuple[str, str, bool], ...] = (
    ("1", "dimensionless", False),
    ("g", "gram", True),
    ("m", "meter", True),
    ("s", "second", True),
    ("A", "ampere", True),
    ("K", "kelvin", True),
    ("mol", "mole", True),
    ("cd", "candela", True),
    ("rad", "radian", True),
    ("sr", "steradian", True),
    ("Hz", "hertz", True),
    ("N", "newton", True),
    ("Pa", "pascal", True),
    ("J", "joule", True),
    ("W", "watt", True),
    ("C", "coulomb", True),
    ("V", "volt", True),
    ("F", "farad", True),
    ("Ohm", "ohm", True),
    ("ohm", "ohm", True),
    ("Ω", "ohm", True),
    ("S", "siemens", True),
    ("Wb", "weber", True),
    ("T", "tesla", True),
    ("H", "henry", True),
    ("lm", "lumen", True),
    ("lx", "lux", True),
    ("Bq", "becquerel", True),
    ("Gy", "gray", True),
    ("Sv", "sievert", True),
    ("kat", "katal", True),
    ("VA", "volt_ampere", True),
    ("var", "volt_ampere", True),
    ("Wh", "watt_hour", True),
    ("eV", "electron_volt", True),
    ("l", "liter", True),
    ("L", "liter", True),
    ("t", "metric_ton", False),
    ("bar", "bar", True),
    ("atm", "standard_atmosphere", False),
    ("mmHg", "millimeter_Hg", False),
    ("psi", "pound_force_per_square_inch", False),
    ("min", "minute", False),
    ("h", "hour", False),
    ("d", "day", False),
    ("wk", "week", False),
    ("yr", "year", False),
    ("deg", "degree", False),
    ("rev", "revolution", False),
    ("rpm", "revolutions_per_minute", False),
    ("degC", "degree_Celsius", False),
    ("°C", "degree_Celsius", False),
    ("degF", "degree_Fahrenheit", False),
    ("degRk", "degree_Rankine", False),
    ("%", "percent", False),
    ("ppm", "ppm", False),
    ("u", "unified_atomic_mass_unit", False),
    ("kgf", "kilogram_force", False),
    ("lbf", "pound_force", False),
    ("lb", "pound", False),
    ("inch", "inch", False),
    ("ft", "foot", False),
    ("mi", "mile", False),
    ("kn", "knot", False),
    ("cal", "calorie", True),
    ("hp", "horsepower", False),
    ("g_n", "standard_gravity", False),
)


def table_source() -> str:
    """Return the text of ``table.py``.

    Raises:
        KeyError: If pint does not know one of the names.
    """
    lines = [
        '"""Common units, generated from pint by ``generate.py``: do not edit."""',
        "",
        "from __future__ import annotations",
        "",
        "#: Symbol -> factor, offset (SI = factor * value + offset), exponents of",
        "#: kg m s A K mol cd, and whether SI prefixes may stand before the symbol.",
        "SYMBOLS: dict[str, tuple[float, float, tuple[int, ...], bool]] = {",
    ]
    for symbol, name, prefixable in SYMBOLS:
        entry = from_pint(name)
        if entry is None:
            raise KeyError(name)
        factor, offset, dimension = entry
        lines.append(f'    "{symbol}": ({factor!r}, {offset!r}, {dimension!r}, {prefixable!r}),')
    lines += ["}", ""]
    return "\n".join(lines)


if __name__ == "__main__":
    print(table_source(), end="")
