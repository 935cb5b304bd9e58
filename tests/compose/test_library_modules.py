"""Packages of the library as modules."""

from __future__ import annotations

import inspect
import subprocess
import sys

import pytest

import acausal as ac
from acausal.library import electrical as el
from acausal.library.mechanical import rotational as rot


def test_signatures_and_docstrings():
    signature = inspect.signature(el.Resistor)
    assert repr(signature.parameters["R"].default) == "1[Ohm]"
    assert {"R", "alpha", "shape", "inner"} <= set(signature.parameters)
    text = inspect.getdoc(el.Resistor)
    assert "R (si.Resistance [Ohm]) = 1[Ohm]: resistance at the reference temperature" in text
    assert "p (PositivePin): positive pin" in text
    assert text.startswith("Ideal resistor")
    assert {"p", "n", "R", "v"} <= set(dir(el.Resistor()))


def test_signature_of_python_classes():
    class Mine(el.Resistor, R=5):
        extra = ac.Parameter(2.0, unit="1/s")

    signature = inspect.signature(Mine)
    assert repr(signature.parameters["R"].default) == "5"
    assert repr(signature.parameters["extra"].default) == "2.0"

    class Section(ac.Model):
        def build(self, count=3):
            pass

    assert inspect.signature(Section).parameters["count"].default == 3


def test_completion():
    assert {"Resistor", "Capacitor", "Pin"} <= set(dir(el))
    assert "Inertia" in dir(rot)
    import acausal.library

    assert "electrical" in dir(acausal.library)
    assert el.Resistor is el.Resistor
    assert el.Resistor.__module__ == "acausal.library.electrical"
    import acausal.library.mechanical.rotational as again

    assert again is rot


def test_unknown_names_are_told_with_the_nearest():
    with pytest.raises(AttributeError, match="did you mean Resistor"):
        _ = el.Resitor
    with pytest.raises(ImportError, match="did you mean electrical"):
        from acausal.library import electricl  # noqa: F401
    with pytest.raises(ImportError, match="did you mean Inertia"):
        from acausal.library.mechanical.rotational import Inertial  # noqa: F401
    assert not hasattr(el, "Nothing")


def test_nothing_is_read_before_it_is_used():
    program = (
        "import sys\nimport acausal as ac\n"
        "assert not any(m.startswith('acausal.') and m != 'acausal.version' for m in sys.modules)\n"
        "from acausal.library import electrical, thermal\n"
        "from acausal.compose.assembly import shared_library\n"
        "assert shared_library().sources == []\n"
        "electrical.Resistor\n"
        "read = {p.parent.name for p in shared_library().sources}\n"
        "assert 'electrical' in read and 'planar' not in read, read\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
