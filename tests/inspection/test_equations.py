"""Rows of one form are one line: names, index letters, ranges, sums."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from acausal.expressions import build
from acausal.expressions.nodes import ZERO, slot
from acausal.expressions.text import to_text
from acausal.inspection.equations import EquationForms, shortened_sum
from acausal.inspection.index_names import IndexNames
from acausal.inspection.operands import Label, Names
from acausal.instantiation.places import parameter_places, variable_places
from tests.connections.test_junctions import PIN
from tests.flattening.static import flat


def listing(text: str) -> EquationForms:
    model = flat(text)
    found = EquationForms(model.model.families, Names(model.numbering, model.model))
    assert sum(found.sizes) == model.model.n_rows == found.n_rows
    return found


def forms(text: str) -> list[str]:
    found = listing(text)
    return [found.form(k).text() for k in range(found.count)]


# --- index letters ---------------------------------------------------------------------------


def column(*values: int) -> np.ndarray:
    return np.array(values, np.int64)


def test_columns_get_letters_and_shifts():
    names = IndexNames(3)
    columns = ((4, 4, 4), (2, 3, 4), (1, 2, 3), (3, 4, 5), (5, 7, 9))
    texts = [names.text(column(*values)) for values in columns]
    assert texts == ["4", "k", "k-1", "k+1", "j"]
    assert names.text_of_ranges() == "for 3 of k in 2:4, j in {5, 7, 9}"


@pytest.mark.parametrize(
    ("values", "text", "latex"),
    [
        (range(1, 101), "for k in 1:100", r"k = 1, \dots, 100"),
        ((1, 2), "for k in 1:2", "k = 1, 2"),
        ((1, 5), "for k in {1, 5}", "k = 1, 5"),
        (range(1, 10, 2), "for k in 1:2:9", r"k = 1, 3, \dots, 9"),
        ((1, 2, 4, 8, 16), "for k in {1, 2, 4, 8, ... 16}", r"k = 1, 2, 4, 8, \dots, 16"),
    ],
)
def test_ranges(values, text, latex):
    names = IndexNames(len(values))
    names.text(column(*values))
    assert names.text_of_ranges() == text
    assert names.latex_of_ranges() == latex


def test_a_grid_is_two_ranges():
    names = IndexNames(6)
    assert names.text(np.repeat([1, 2], 3)) == "k"
    assert names.text(np.tile([1, 2, 3], 2)) == "j"
    assert names.text_of_ranges() == "for k in 1:2, j in 1:3"


@given(st.integers(-5, 5), st.integers(1, 4), st.integers(2, 30))
def test_numbers_that_follow_an_index(offset, slope, n):
    names = IndexNames(n)
    values = np.arange(1, n + 1)
    names.text(values)
    a, b, letter = names.affine(0.5 * slope * values + offset)
    assert (a, b, letter) == (pytest.approx(0.5 * slope), pytest.approx(offset, abs=1e-9), "k")
    assert n < 4 or names.affine(values**2.0) is None


# --- forms -----------------------------------------------------------------------------------


def test_single_equations_are_written_as_they_are():
    text = "model M Real x; Real y; parameter Real p = 2; equation x = p*time; y - x^2 = 3; end M;"
    assert forms(text) == ["x = p*time", "y - x^2 = 3"]


def test_instances_of_one_class_are_one_line():
    text = (
        "model A Real x; parameter Real p = 1; equation der(x) = -p*x; end A; "
        "model M A a[100]; A b; end M;"
    )
    assert forms(text) == [
        "der(a[k].x) + a[k].p*a[k].x = 0   for k in 1:100",
        "der(b.x) + b.p*b.x = 0",
    ]


def test_neighbours_in_a_loop_are_shifted():
    text = (
        "model M Real x[50]; equation x[1] = 1; "
        "for i in 2:50 loop x[i] = 2*x[i-1] + i; end for; end M;"
    )
    assert forms(text) == ["x[1] = 1", "x[k] = 2*x[k-1] + k   for k in 2:50"]


def test_numbers_without_a_rule_are_listed():
    text = "model M Real x[4]; parameter Integer t[4] = {3, 1, 4, 1}; equation x = t; end M;"
    assert forms(text) == ["x[k] = {3, 1, 4, ...}   for k in 1:4"]


def test_junctions_are_sums_over_cuts():
    found = forms(
        PIN + "model M V v; R a, b; R c[9]; G g; equation "
        "connect(v.p, a.p, b.p); connect(v.n, a.n, b.n, g.p); "
        "for k in 1:9 loop connect(c[k].p, v.p); end for; "
        "for k in 2:9 loop connect(c[k].n, c[k-1].n); end for; end M;"
    )
    assert "g.p.i + a.n.i + b.n.i + v.n.i = 0" in found
    assert "a.p.i + b.p.i + sum(c[k].p.i for k in 1:9) + v.p.i = 0" in found
    assert "sum(c[k].n.i for k in 1:9) = 0" in found


def test_inner_faces_count_the_other_way():
    found = forms(
        PIN + "model S Pin a; R r; G g; equation connect(a, r.p); connect(r.n, g.p); end S; "
        "model M S s[5]; V v; G g; equation "
        "for k in 1:5 loop connect(v.p, s[k].a); end for; connect(v.n, g.p); end M;"
    )
    assert "s[k].r.p.i = s[k].a.i   for k in 1:5" in found


def test_every_row_is_in_one_form():
    found = listing(
        PIN + "model M R r[7]; V v; G g; equation connect(r[1:6].n, r[2:7].p); "
        "connect(v.p, r[1].p); connect(r[7].n, v.n, g.p); end M;"
    )
    rows = np.concatenate([found.rows_of(k) for k in range(found.count)])
    assert sorted(rows.tolist()) == list(range(found.n_rows))


def test_long_sums_are_shortened_and_flattened():
    terms = [slot(Label(f"x{k}", "")) for k in range(40)]
    expr = ZERO
    for term in terms:
        expr = build.add(term, expr)
    text = to_text(shortened_sum(expr), lambda label: label.text)
    assert text == "x39 + x38 + x37 + ... + x0"
    short = build.sub(terms[0], build.sub(terms[1], build.add(terms[2], terms[3])))
    assert to_text(shortened_sum(short), lambda label: label.text) == "x0 - x1 + x2 + x3"


# --- places ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        "model A Real x[2,3]; equation x = zeros(2, 3); end A; model B A a[2]; A b; end B; "
        "model M B b[3,2]; A a; parameter Real p[4] = ones(4); end M;",
        PIN + "model S R r[2]; V v; end S; model M S s[3]; S t; R q; end M;",
        "model A parameter Integer n = 0; Real x[n]; "
        "Real y[2] = {1, 2}; Real z[n]; end A; model M A a[2]; end M;",
    ],
)
def test_places_give_the_paths_of_all_scalars(text):
    flattened = flat(text)
    numbering, names = flattened.numbering, flattened.model.names
    for n, find, name in (
        (numbering.n_variables, variable_places, names.variable),
        (numbering.n_parameters, parameter_places, names.parameter),
    ):
        paths = np.empty(n, object)
        for place in find(numbering, np.arange(n)):
            paths[place.members] = place.paths()
        assert paths.tolist() == [name(k) for k in range(n)]


def test_any_selection_of_ids_is_sorted_by_place():
    flattened = flat(PIN + "model M R r[5]; V v; end M;")
    numbering, names = flattened.numbering, flattened.model.names
    ids = np.array([7, 3, 20, 3, 11])
    found = np.empty(len(ids), object)
    for place in variable_places(numbering, ids):
        found[place.members] = place.paths()
    assert found.tolist() == [names.variable(int(k)) for k in ids]
