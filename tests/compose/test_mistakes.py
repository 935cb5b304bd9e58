# ruff: noqa: B015, B018, C408, RUF059 - mistakes are what this file is made of
"""Mistakes in Python: the code, and the line of Python that is to blame."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest

import acausal as ac
from acausal.library import electrical as el
from acausal.library.mechanical import planar as pl
from acausal.library.mechanical import rotational as rot


def circuit() -> ac.Model:
    model = ac.Model("circuit")
    model.s = el.ConstantVoltage(V=1)
    model.r = el.Resistor()
    model.g = el.Ground()
    return model


def complete() -> ac.Model:
    model = circuit()
    model.connect(model.s.p, model.r.p)
    model.connect(model.s.n, model.r.n, model.g.p)
    return model


def unknown_parameter():
    el.Resistor(r=5)  # N103 did you mean R


def unknown_parameter_set_later():
    circuit().r.Rr = 5  # N103 did you mean R


def unknown_attribute():
    el.Capacitor(v=dict(strt=0))  # N103 did you mean start


def unknown_override():
    class Mine(el.Resistor, alfa=1):  # N103 did you mean alpha
        pass


def misspelt_part():
    circuit().rr.p  # N102 did you mean r


def misspelt_cut():
    circuit().r.q  # N102 it has p, n


def misspelt_class():
    el.Resitor  # N150 did you mean Resistor


def unlike_cuts():
    model = circuit()
    model.i = rot.Inertia(J=1)
    model.connect(model.r.p, model.i.flange_a)  # C101 unlike cuts


def component_as_cut():
    model = circuit()
    model.connect(model.r, model.s.p)  # C101 name one of its cuts: p, n


def variable_as_cut():
    model = circuit()
    model.connect(model.r.p, model.s.v)  # C101 a variable


def list_of_cuts():
    model = circuit()
    model.connect([model.r.p, model.s.p], model.g.p)  # C101 connect(*cuts)


def one_cut():
    model = circuit()
    model.connect(model.r.p)  # P012 two


def wrong_shape():
    model = ac.Model("m")
    model.r = el.Resistor(R=np.ones(4), shape=5)  # T104 size
    model.compile()


def ragged_array():
    el.Resistor(R=[[1, 2], [3]], shape=2)  # T104 different lengths


def cuts_of_unlike_size():
    model = ac.Model("m")
    model.r = el.Resistor(shape=5)
    model.connect(model.r[:-1].n, model.r.p)  # C102 size
    model.compile()


def subscript_outside():
    el.Resistor(shape=5)[5]  # T114 count from 0


def subscript_of_no_array():
    circuit().r[0]  # T113 no dimensions


def loop_over_a_scalar():
    list(circuit().r.v)  # T113 no array


def forgotten_ground():
    model = ac.Model("m")
    model.s = el.ConstantVoltage(V=1)
    model.r = el.Resistor()  # S103 Ground
    model.connect(model.s.p, model.r.p)
    model.connect(model.s.n, model.r.n)
    model.compile()


def forgotten_world():
    model = ac.Model("m")
    model.a = pl.Anchor()
    model.p = pl.Pendulum()  # N118 m.world = ...PlanarWorld()
    model.compile()


def wrong_unit():
    model = complete()
    model.c = el.Capacitor(C="10[kOhm]")  # U102 Ohm and F
    model.compile()


def unknown_unit():
    el.Resistor(R="10[kOhmm]")  # U104 did you mean kOhm


def unit_without_brackets():
    el.Resistor(R="10 kOhm")  # T154 10[kOhm]


def not_a_number():
    el.Resistor(R=math.nan)  # T153 NaN


def not_a_number_in_an_array():
    el.Resistor(R=np.array([1, math.nan]), shape=2)  # T153 element [1]


def no_value():
    el.Resistor(R=object())  # T152 no value


def value_without_a_name():
    el.Resistor(100)  # N158 Resistor(name=value)


def no_type():
    ac.Variable(type="Volt")  # T155 no type


def no_size():
    el.Resistor(shape=2.5)  # T122 no size


def part_set_after_compilation():
    model = complete()
    model.compile()
    model.c = el.Capacitor()  # N156 compiled here


def parameter_set_after_compilation():
    model = complete()
    model.compile()
    model.r.R = 5  # N156 compiled here


def connection_after_compilation():
    model = complete()
    model.compile()
    model.connect(model.r.p, model.g.p)  # N156 compiled here


def equation_after_compilation():
    model = complete()
    model.compile()
    model.equation(model.r.v == 0)  # N156 compiled here


def inner_part_of_a_compiled_model():
    model = ac.Model("m")
    model.inside = complete()
    model.compile()
    model.inside.x = el.Capacitor()  # N156 compiled here


def part_of_another_model():
    one, two = circuit(), circuit()
    one.connect(one.r.p, two.s.p)  # N155 another model
    one.compile()


def part_of_no_model():
    model, r = circuit(), el.Resistor()
    model.connect(model.r.p, r.p)  # N155 assign it to the model first
    model.compile()


def name_taken():
    model = circuit()
    model.r = el.Resistor()  # N105 first here


def part_with_two_names():
    model = circuit()
    model.a = el.Resistor()
    model.b = model.a  # N153 already circuit.a


def no_identifier():
    setattr(circuit(), "my r", el.Resistor())  # N151 my_r


def reserved_word():
    circuit().model = el.Resistor()  # N151 reserved


def name_of_a_method():
    circuit().simulate = el.Resistor()  # N151 method


def model_without_a_name():
    ac.Model("RC circuit")  # N151 RC_circuit


def plain_value():
    circuit().x = 100  # N154 ac.Parameter(100)


def truth_of_a_relation():
    if circuit().r.v > 0:  # T150 ac.where
        pass


def chained_relation():
    0 < circuit().r.v < 1  # T150 (a < b) & (b < c)


def python_and():
    model = circuit()
    model.r.v > 0 and model.r.i > 0  # T150 & |


def function_of_math():
    math.exp(circuit().r.v)  # T151 ac.exp


def no_equation():
    model = circuit()
    model.equation(model.r.v)  # B110 states nothing


def comparison_of_numbers():
    circuit().equation(1 == 2)  # B110 Python's own values


def partial_class():
    el.OnePort()  # N111 extend it


def argument_of_build_missing():
    class Mine(ac.Model):
        def build(self, count):
            pass

    Mine()  # N157 count


def unknown_argument_of_build():
    class Mine(ac.Model):
        def build(self, count=3):
            pass

    Mine(cont=4)  # N103 did you mean count


def too_few_equations():
    class Mine(ac.Component):
        x = ac.Variable()

    model = ac.Model("m")
    model.a = Mine()
    model.b = Mine()
    model.equation(model.a.x == 1)
    model.compile()


def units_in_equations():
    model = complete()
    model.x = ac.Variable(unit="A")
    model.equation(model.x == model.r.v)  # U102 these units do not fit
    model.compile()


CASES = [
    value
    for value in list(globals().values())
    if getattr(value, "__module__", "") == __name__
    and hasattr(value, "__code__")
    and value.__name__ not in ("circuit", "complete", "too_few_equations")
]


def marked(case) -> tuple[int, str, str]:
    """Return line, code and words of the remark in a case."""
    with open(__file__, encoding="utf-8") as file:
        lines = file.read().split("\n")
    first = case.__code__.co_firstlineno
    for number in range(first, first + 20):
        line, mark, remark = lines[number - 1].partition("  # ")
        if mark and remark[:1].isupper() and remark[1:4].isdigit():
            code, _, words = remark.partition(" ")
            return number, code, words
    raise AssertionError(case.__name__)


@pytest.mark.parametrize("case", CASES, ids=lambda c: c.__name__)
def test_mistakes(case):
    line, code, words = marked(case)
    with pytest.raises(ac.AcausalError) as caught:
        case()
    diagnostic = caught.value.diagnostics[0]
    assert diagnostic.code == code
    assert diagnostic.span is not None
    assert (diagnostic.span.source, diagnostic.span.line) == (__file__, line)
    assert diagnostic.help
    text = str(caught.value)
    assert words in text
    # The text shows the line itself.
    with open(__file__, encoding="utf-8") as file:
        source = file.read().split("\n")[line - 1].strip()
    assert source.partition("  #")[0][:40] in text


def test_too_few_equations_name_the_class():
    with pytest.raises(ac.AcausalError) as caught:
        too_few_equations()
    assert caught.value.diagnostics[0].code == "B101"
    assert "Mine" in str(caught.value)


def test_cells_of_a_notebook_are_shown():
    import linecache

    source = (
        "import acausal as ac\nfrom acausal.library import electrical as el\nel.Resistor(x=1)\n"
    )
    name = "<cell 3>"
    linecache.cache[name] = (len(source), None, source.splitlines(keepends=True), name)
    with pytest.raises(ac.AcausalError) as caught:
        exec(compile(source, name, "exec"), {"__name__": "__main__"})
    assert "<cell 3>:3:1" in str(caught.value)
    assert "el.Resistor(x=1)\n" in str(caught.value)


def test_places_are_precise():
    with pytest.raises(ac.AcausalError) as caught:
        _ = (el.Resistor(), el.Resistor(x=1))
    span = caught.value.diagnostics[0].span
    assert span is not None
    assert span.end_column - span.column == len("el.Resistor(x=1)")
    assert sys.version_info >= (3, 11)
