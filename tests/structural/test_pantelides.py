"""Offsets: the examples of the literature, and random systems against the sequential algorithm."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from acausal.structural.incidence import chains_of, incidence_of_pairs
from acausal.structural.pantelides import (
    Offsets,
    Singularity,
    differentiation_index,
    pantelides,
)
from acausal.structural.singularity import count_exposed, singular_subsets
from tests.structural.sequential import Sigma, matching_size, pantelides_1988, signature


def offsets(sigma: Sigma, n: int) -> Offsets:
    result = pantelides(signature(sigma, n, n))
    assert isinstance(result, Offsets)
    for (i, j), order in sigma.items():
        assert result.d[j] - result.c[i] >= order
    for i, j in enumerate(result.matching.column_of_row.tolist()):
        assert result.d[j] - result.c[i] == sigma[i, j]
    return result


def test_pendulum_of_pantelides():
    """Pantelides 1988, example: x' = u, y' = v, u' = -T x, v' = -T y + g, x^2 + y^2 = 1."""
    x, y, u, v, T = range(5)
    sigma = {
        (0, x): 1, (0, u): 0,
        (1, y): 1, (1, v): 0,
        (2, u): 1, (2, T): 0, (2, x): 0,
        (3, v): 1, (3, T): 0, (3, y): 0,
        (4, x): 0, (4, y): 0,
    }  # fmt: skip
    result = offsets(sigma, 5)
    assert result.c.tolist() == [1, 1, 0, 0, 2]
    assert result.d.tolist() == [2, 2, 1, 1, 0]
    assert differentiation_index(result) == 3
    assert result.degrees_of_freedom == 2


def test_pendulum_of_pryce():
    """Pryce 2001, example 1: x'' + x T, y'' + y T - g, x^2 + y^2 - L^2."""
    sigma = {(0, 0): 2, (0, 2): 0, (1, 1): 2, (1, 2): 0, (2, 0): 0, (2, 1): 0}
    result = offsets(sigma, 3)
    assert result.c.tolist() == [0, 0, 2]
    assert result.d.tolist() == [2, 2, 0]
    assert differentiation_index(result) == 3


def test_two_pendula_of_pryce():
    """Pryce 2001, example 2: the second pendulum's length depends on the first one's tension."""
    x, y, T, u, v, w = range(6)
    sigma = {
        (0, x): 2, (0, T): 0, (1, y): 2, (1, T): 0, (2, x): 0, (2, y): 0,
        (3, u): 2, (3, w): 0, (4, v): 2, (4, w): 0, (5, u): 0, (5, v): 0, (5, T): 0,
    }  # fmt: skip
    result = offsets(sigma, 6)
    assert result.c.tolist() == [2, 2, 4, 0, 0, 2]
    assert result.d.tolist() == [4, 4, 2, 2, 2, 0]
    assert differentiation_index(result) == 5


def test_reactor_with_prescribed_concentration():
    """Pantelides 1988: stirred tank, C(t) given; C', T', R = R(C, T), C = given; cooling u."""
    C, T, R, u = range(4)
    sigma = {
        (0, C): 1, (0, R): 0,
        (1, T): 1, (1, R): 0, (1, u): 0,
        (2, R): 0, (2, C): 0, (2, T): 0,
        (3, C): 0,
    }  # fmt: skip
    result = offsets(sigma, 4)
    assert result.c.tolist() == [1, 0, 1, 2]
    assert differentiation_index(result) == 3


def test_explicit_ode_is_left_alone():
    result = offsets({(0, 0): 1, (0, 1): 0, (1, 1): 1, (1, 0): 0}, 2)
    assert result.c.tolist() == [0, 0]
    assert differentiation_index(result) == 0


def test_transistor_amplifier_is_structurally_of_index_one():
    """Hairer and Wanner II, VII.1: eight nodes, capacitors couple the derivatives in pairs.

    The structure alone cannot see that the capacitance matrix is singular.
    """
    pairs = [(0, 1), (2, 2), (3, 4), (5, 5), (6, 7)]
    sigma: Sigma = {}
    for a, b in pairs:
        for i, j in ((a, a), (a, b), (b, a), (b, b)):
            sigma[i, j] = 1
    result = offsets(sigma, 8)
    assert result.c.max() == 0
    assert result.d.min() == 1


def test_capacitor_loop_has_index_two():
    """Two capacitors across one another and a current source: one constraint, one state."""
    v1, v2, i1, i2 = range(4)
    sigma = {(0, v1): 1, (0, i1): 0, (1, v2): 1, (1, i2): 0, (2, v1): 0, (2, v2): 0,
             (3, i1): 0, (3, i2): 0}  # fmt: skip
    result = offsets(sigma, 4)
    assert result.c.tolist() == [0, 0, 1, 0]
    assert differentiation_index(result) == 2
    assert result.degrees_of_freedom == 1


def test_car_axis_has_index_three():
    """Test set for IVP solvers, car axis: four positions of second order, two multipliers."""
    xl, yl, xr, yr, l1, l2 = range(6)
    sigma: Sigma = {(k, k): 2 for k in range(4)}
    sigma |= {(k, m): 0 for k in range(4) for m in (l1, l2) if not (k in (xr, yr) and m == l1)}
    sigma |= {(4, xl): 0, (4, yl): 0}
    sigma |= {(5, q): 0 for q in (xl, yl, xr, yr)}
    result = offsets(sigma, 6)
    assert result.c.tolist() == [0, 0, 0, 0, 2, 2]
    assert differentiation_index(result) == 3
    assert result.degrees_of_freedom == 4


@pytest.mark.parametrize("n", [1, 2, 5, 40])
def test_inverse_integrator_chain(n):
    """x1' = x2, ..., xn' = u with x1 given has index n + 1."""
    sigma: Sigma = {(0, 0): 0}
    for k in range(n):
        sigma[k + 1, k] = 1
        sigma[k + 1, k + 1] = 0
    result = offsets(sigma, n + 1)
    assert differentiation_index(result) == n + 1
    assert result.c.tolist() == [n, *range(n - 1, -1, -1)]


systems = st.integers(1, 7).flatmap(
    lambda n: st.tuples(
        st.just(n),
        st.dictionaries(
            st.tuples(st.integers(0, n - 1), st.integers(0, n - 1)),
            st.integers(0, 3),
            max_size=3 * n,
        ),
    )
)


@settings(max_examples=300)
@given(systems, st.booleans())
def test_same_offsets_as_the_sequential_algorithm(case, diagonal):
    n, sigma = case
    if diagonal:
        sigma = {(k, (k * 3 + 1) % n if n % 3 else k): 0 for k in range(n)} | sigma
    result = pantelides(signature(sigma, n, n))
    if matching_size(set(sigma), n) < n:
        assert isinstance(result, Singularity)
        return
    assert isinstance(result, Offsets)
    c, d = pantelides_1988(sigma, n)
    assert result.c.tolist() == c
    assert result.d.tolist() == d
    offsets(sigma, n)


@given(systems, st.randoms(use_true_random=False))
def test_the_order_of_rows_and_variables_does_not_matter(case, random):
    n, sigma = case
    rows, bases = list(range(n)), list(range(n))
    random.shuffle(rows)
    random.shuffle(bases)
    turned = {(rows[i], bases[j]): order for (i, j), order in sigma.items()}
    first, second = pantelides(signature(sigma, n, n)), pantelides(signature(turned, n, n))
    assert type(first) is type(second)
    if isinstance(first, Offsets) and isinstance(second, Offsets):
        assert first.c.tolist() == second.c[rows].tolist()
        assert first.d.tolist() == second.d[bases].tolist()


@given(systems)
def test_singular_subsets_are_minimal(case):
    n, sigma = case
    result = pantelides(signature(sigma, n, n))
    assume(isinstance(result, Singularity))
    assert isinstance(result, Singularity)
    subsets = singular_subsets(result)
    assert count_exposed(result)[0] == sum(s.overdetermined for s in subsets)
    assert any(s.overdetermined for s in subsets)
    assert not all(s.overdetermined for s in subsets)
    for subset in subsets:
        turned = sigma if subset.overdetermined else {(j, i): o for (i, j), o in sigma.items()}
        many, few = subset.rows.tolist(), subset.bases.tolist()
        if not subset.overdetermined:
            many, few = few, many
        assert len(many) == len(few) + 1
        assert subset.exposed in many
        assert {j for i, j in turned if i in many} == set(few)
        for left_out in many:
            rest = [i for i in many if i != left_out]
            edges = {(rest.index(i), j) for i, j in turned if i in rest}
            assert matching_size(edges, len(rest)) == len(rest)


def test_two_sources_in_parallel():
    """Two rows give v a value; i1 and i2 stand only in their sum."""
    v, i1, i2 = range(3)
    result = pantelides(signature({(0, v): 0, (1, v): 0, (2, i1): 0, (2, i2): 0}, 3, 3))
    assert isinstance(result, Singularity)
    over, under = singular_subsets(result)
    assert over.overdetermined
    assert over.rows.tolist() == [0, 1]
    assert over.bases.tolist() == [v]
    assert not under.overdetermined
    assert under.bases.tolist() == [i1, i2]
    assert under.rows.tolist() == [2]
    assert result.parts.over_rows.tolist() == [True, True, False]


def test_systems_that_are_not_square_are_reported():
    result = pantelides(signature({(0, 0): 1, (1, 0): 0}, 2, 1))
    assert isinstance(result, Singularity)
    assert count_exposed(result) == (1, 0)
    result = pantelides(signature({}, 0, 0))
    assert isinstance(result, Offsets)
    assert differentiation_index(result) == 0


def test_long_rigid_chain():
    """Masses held together by rods: every rod is differentiated twice, two states are left."""
    n = 30_000
    k = np.arange(n)
    s, v, a, f = k, n + k, 2 * n + k, 3 * n + np.arange(n - 1)
    derivative = np.full(4 * n - 1, -1)
    derivative[s], derivative[v] = v, a
    rows = np.concatenate([k, k[:-1], k[1:], n + k[:-1], n + k[:-1]])
    ids = np.concatenate([a, f, f, s[:-1], s[1:]])
    chains = chains_of(derivative)
    result = pantelides(incidence_of_pairs(rows, ids, 2 * n - 1, chains).signature())
    assert isinstance(result, Offsets)
    assert (result.c[:n] == 0).all()
    assert (result.c[n:] == 2).all()
    assert (result.d[:n] == 2).all()
    assert (result.d[n:] == 0).all()
    assert result.degrees_of_freedom == 2
