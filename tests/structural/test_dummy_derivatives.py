"""State selection: the pendulum of the paper, wishes, nesting, conditioning, large systems."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acausal.flattening.model import StateSelect
from acausal.structural import column_choice, dummy_derivatives
from acausal.structural.dummy_derivatives import StateSelection, select_states
from acausal.structural.graphs import compress
from acausal.structural.highest_jacobian import HighestEntries
from acausal.structural.incidence import Chains, Incidence, chains_of, incidence_of_pairs
from acausal.structural.lasting_choice import determinant_varies
from acausal.structural.pantelides import Offsets, pantelides
from acausal.structural.reselection import largest_gain, reselect


class System:
    """Bases of order 2 or less, built from (row, base, order) triples."""

    def __init__(self, triples: list[tuple[int, int, int]], n: int) -> None:
        highest = np.zeros(n, np.int64)
        for _, base, order in triples:
            highest[base] = max(highest[base], order)
        chains = chains_of(np.full(n, -1)).extend(highest)
        rows, bases, orders = np.array(triples, np.int64).T
        self.incidence: Incidence = incidence_of_pairs(rows, chains.ids(bases, orders), n, chains)
        self.signature = self.incidence.signature()
        found = pantelides(self.signature)
        assert isinstance(found, Offsets)
        self.offsets: Offsets = found
        self.chains: Chains = chains.extend(found.d)
        c, d = found.c, found.d
        s = self.signature
        wanted = (c[s.rows] > 0) & (s.orders + c[s.rows] == d[s.bases])
        rows, bases = s.rows[wanted], s.bases[wanted]
        self.entries = HighestEntries(rows, bases, rows, self.chains.ids(bases, d[bases]))

    def ids(self, *pairs: tuple[int, int]) -> list[int]:
        bases, orders = np.array(pairs).T
        return self.chains.ids(bases, orders).tolist()

    def select(self, values: list[float] | np.ndarray, wishes: dict[int, int] | None = None):
        wished = np.full(self.chains.n_variables, 3, np.int8)
        for variable, wish in (wishes or {}).items():
            wished[variable] = wish
        values = np.asarray(values, float)
        selection = select_states(self.chains, self.offsets, self.entries, values, wished)
        self.check(selection, values)
        return selection

    def check(self, selection: StateSelection, values: np.ndarray) -> None:
        """Assert counts, nesting and regularity at every level."""
        c, d, depth = self.offsets.c, self.offsets.d, selection.depth
        assert depth.sum() == c.sum() == selection.dummies.shape[0]
        assert (depth <= d).all()
        # As many unknowns as rows: states need none, their derivatives do.
        assert np.count_nonzero(selection.is_active) == c.shape[0] + c.sum() + (d - depth).sum()
        assert selection.states.shape[0] == self.offsets.degrees_of_freedom
        jacobian = np.zeros((c.shape[0], d.shape[0]))
        jacobian[self.entries.rows, self.entries.bases] = np.nan_to_num(values)
        structure = np.zeros(jacobian.shape)
        structure[self.entries.rows, self.entries.bases] = np.random.default_rng(0).random(
            values.shape
        )
        for level in range(1, int(c.max()) + 1):
            square = structure[c >= level][:, depth >= level]
            assert square.shape[0] == square.shape[1]
            assert np.linalg.matrix_rank(square) == square.shape[0]
            rows = jacobian[c >= level]
            if np.linalg.matrix_rank(rows, 1e-4) == rows.shape[0]:
                square = rows[:, depth >= level]
                assert np.linalg.matrix_rank(square, 1e-12) == square.shape[0]


X, Y, T = 0, 1, 2
PENDULUM = [(0, X, 2), (0, X, 0), (0, T, 0), (1, Y, 2), (1, Y, 0), (1, T, 0), (2, X, 0), (2, Y, 0)]


def test_pendulum_of_mattsson_and_soederlind():
    """x^2 + y^2 = L^2: hanging down, y is dependent; horizontal, x is."""
    system = System(PENDULUM, 3)
    hanging = system.select([2 * 0.1, 2 * -0.99])
    assert hanging.states.tolist() == system.ids((X, 0), (X, 1))
    assert hanging.dummies.tolist() == sorted(system.ids((Y, 1), (Y, 2)))
    horizontal = system.select([2 * 0.99, 2 * -0.1])
    assert horizontal.states.tolist() == system.ids((Y, 0), (Y, 1))
    assert horizontal.dummies.tolist() == sorted(system.ids((X, 1), (X, 2)))


def test_pendulum_is_reselected_on_its_way():
    system = System(PENDULUM, 3)
    selection = system.select([0.2, -2.0])
    assert selection.alternatives.any
    assert selection.alternatives.n_blocks == 1
    turns = 0
    for angle in np.linspace(0, 2 * np.pi, 200):
        values = np.array([np.sin(angle), -np.cos(angle)])
        new = reselect(selection, values)
        if new is not None:
            turns += 1
            selection = new
            system.check(selection, values)
        assert largest_gain(selection, values) <= 5.0 + 1e-6
    assert turns == 4
    assert reselect(selection, np.array([0.0, 1.0])) is None


def test_earlier_declared_variables_stay_states_where_all_is_equal():
    system = System(PENDULUM, 3)
    assert system.select([1.0, 1.0]).states.tolist() == system.ids((X, 0), (X, 1))
    assert system.select([0.0, 0.0]).states.tolist() == system.ids((X, 0), (X, 1))
    assert system.select([np.nan, np.nan]).states.tolist() == system.ids((X, 0), (X, 1))


@pytest.mark.parametrize("order", [0, 1])
def test_wishes_come_before_pivot_sizes(order):
    system = System(PENDULUM, 3)
    y, x = system.ids((Y, order), (X, order))
    values = [0.5, -2.0]
    for wishes in ({y: StateSelect.PREFER}, {x: StateSelect.AVOID}, {y: StateSelect.ALWAYS}):
        assert system.select(values, wishes).states.tolist() == system.ids((Y, 0), (Y, 1))


def test_a_preferred_state_is_given_up_when_it_cannot_be_one():
    system = System(PENDULUM, 3)
    (y,) = system.ids((Y, 0))
    preferred = system.select([1e-9, -2.0], {y: StateSelect.PREFER})
    assert preferred.states.tolist() == system.ids((X, 0), (X, 1))
    always = system.select([0.0, -2.0], {y: StateSelect.ALWAYS})
    assert always.states.tolist() == system.ids((X, 0), (X, 1))
    assert always.dummy_in_spite.tolist() == [y]
    kept = system.select([0.2, -2.0], {y: StateSelect.PREFER})
    assert reselect(kept, np.array([0.1, -2.0])) is None
    assert reselect(kept, np.array([1e-5, -2.0])) is not None


def test_never_where_no_constraint_helps_is_told():
    system = System([(0, 0, 1), (0, 0, 0)], 1)
    selection = select_states(
        system.chains, system.offsets, system.entries, np.zeros(0), np.array([1], np.int8)
    )
    assert selection.states.tolist() == [0]
    assert selection.state_in_spite.tolist() == [0]
    assert not selection.alternatives.any


def test_capacitor_loop_leaves_one_state():
    """C1 v1' = i1, C2 v2' = i2, v1 = v2, i1 + i2 = J: v2' becomes a dummy."""
    system = System([(0, 0, 1), (0, 2, 0), (1, 1, 1), (1, 3, 0), (2, 0, 0), (2, 1, 0),
                     (3, 2, 0), (3, 3, 0)], 4)  # fmt: skip
    selection = system.select([1.0, -1.0])
    assert selection.states.tolist() == system.ids((0, 0))
    assert selection.dummies.tolist() == system.ids((1, 1))


def test_constant_jacobians_are_not_monitored():
    system = System(PENDULUM, 3)
    selection = select_states(
        system.chains, system.offsets, system.entries, np.ones(2), np.zeros(0, np.int8),
        constant=np.ones(2, np.bool_),
    )  # fmt: skip
    assert not selection.alternatives.any
    assert reselect(selection, np.array([1.0, 1e-9])) is None


def test_rows_of_different_levels_nest():
    """One constraint between positions, one between velocities, of three second-order bases."""
    p, q, r, lam, mu = range(5)
    triples = [(k, k, 2) for k in (p, q, r)] + [(p, lam, 0), (q, lam, 0), (q, mu, 0), (r, mu, 0)]
    triples += [(3, p, 0), (3, q, 0), (4, q, 1), (4, r, 1)]
    system = System(triples, 5)
    assert system.offsets.c.tolist() == [0, 0, 0, 2, 1]
    # Entries: (3, p), (3, q), (4, q), (4, r).
    selection = system.select([1.0, 0.1, 5.0, 0.1])
    assert sorted(selection.depth.tolist()) == [0, 0, 0, 1, 2]
    assert selection.depth[p] == 2
    assert selection.depth[q] == 1


@settings(max_examples=150, deadline=None)
@given(st.integers(1, 6), st.integers(0, 4), st.integers(0, 10_000))
def test_random_constraints(m, extra, seed):
    """Random holonomic and velocity constraints between bodies, random wishes."""
    random = np.random.default_rng(seed)
    n = m + extra
    triples = [(k, k, 2) for k in range(n)]
    values = {}
    for i in range(m):
        level = int(random.integers(0, 2))
        touched = {i, *random.integers(0, n, 2).tolist()}
        for j in touched:
            triples += [(n + i, j, level), (j, n + i, 0)]
            values[n + i, j] = float(random.normal()) if random.random() < 0.8 else 0.0
    system = System(triples, n + m)
    numbers = np.array(
        [values[i, j] for i, j in zip(system.entries.rows, system.entries.bases, strict=True)]
    )
    wishes = {v: int(random.integers(1, 6)) for v in range(n) if random.random() < 0.3}
    selection = system.select(numbers, wishes)
    others = random.normal(size=numbers.shape)
    new = reselect(selection, others)
    if new is not None:
        system.check(new, others)
    if not wishes and not (numbers == 0).any():
        assert largest_gain(selection, numbers) <= dummy_derivatives.TAU * 1.0001


def bar_chain(n: int, stride: int = 1) -> tuple[Chains, Offsets, HighestEntries]:
    """Links in the plane: points 2k, 2k+1 with (x, y), link k joins point k - 1 and point k."""
    k = np.arange(n)
    x, y, force = k * stride, n * stride + k, 2 * n * stride + k
    n_bases = 2 * n * stride + n
    assert stride == 1
    second = np.r_[x, y]
    chains = chains_of(np.full(n_bases, -1)).extend(
        np.where(np.arange(n_bases) < 2 * n, 2, 0).astype(np.int64)
    )
    constraint = 2 * n + k
    rows = np.r_[
        second, x, y, x[:-1], y[:-1], constraint, constraint, constraint[1:], constraint[1:]
    ]
    bases = np.r_[second, force, force, force[1:], force[1:], x, y, x[:-1], y[:-1]]
    orders = np.r_[np.full(2 * n, 2), np.zeros(rows.shape[0] - 2 * n, np.int64)]
    ids = chains.ids(bases, orders)
    signature = incidence_of_pairs(rows, ids, n_bases, chains).signature()
    offsets = pantelides(signature)
    assert isinstance(offsets, Offsets)
    wanted = (offsets.c[signature.rows] > 0) & (
        signature.orders + offsets.c[signature.rows] == offsets.d[signature.bases]
    )
    rows, bases = signature.rows[wanted], signature.bases[wanted]
    entries = HighestEntries(rows, bases, rows, chains.ids(bases, offsets.d[bases]))
    return chains, offsets, entries


def chain_values(entries: HighestEntries, angles: np.ndarray) -> np.ndarray:
    """Return the gradient of (x_k - x_(k-1))^2 + (y_k - y_(k-1))^2 for given link angles."""
    n = angles.shape[0]
    link = entries.rows - 2 * n
    point = entries.bases % n
    along = np.where(entries.bases < n, np.sin(angles[link]), -np.cos(angles[link]))
    return np.where(point == link, 2 * along, -2 * along)


@pytest.mark.parametrize(("n", "sparse"), [(6, False), (60, False), (60, True), (3000, True)])
def test_chain_of_links(n, sparse, monkeypatch):
    if sparse:
        monkeypatch.setattr(dummy_derivatives, "SPARSE_BLOCK", 10)
        monkeypatch.setattr("acausal.structural.sparse_choice.DENSE", 400)
    chains, offsets, entries = bar_chain(n)
    assert (offsets.c[2 * n :] == 2).all()
    angles = np.random.default_rng(2).uniform(-3, 3, n)
    values = chain_values(entries, angles)
    wishes = np.zeros(0, np.int8)
    selection = select_states(chains, offsets, entries, values, wishes)
    assert selection.states.shape[0] == 2 * n == offsets.degrees_of_freedom
    chosen = np.flatnonzero(selection.depth == 2)
    assert chosen.shape[0] == n
    rows = np.zeros((n, 2 * n)) if n < 100 else None
    if rows is not None:
        rows[entries.rows - 2 * n, entries.bases] = values
        square = rows[:, chosen]
        rest = rows[:, np.setdiff1d(np.arange(2 * n), chosen)]
        assert np.abs(np.linalg.solve(square, rest)).max() < (50 if sparse else 5.01)
    again = select_states(chains, offsets, entries, values, wishes)
    assert again.depth.tolist() == selection.depth.tolist()
    other = reselect(selection, chain_values(entries, angles + 1.5))
    assert other is not None
    assert other.states.shape[0] == 2 * n


def test_very_many_equal_blocks():
    """A hundred thousand pendulums, each at its own angle."""
    n = 100_000
    k = np.arange(n)
    chains = chains_of(np.full(3 * n, -1)).extend(np.repeat([2, 2, 0], n).astype(np.int64))
    c = np.r_[np.zeros(2 * n, np.int64), np.full(n, 2)]
    d = np.repeat([2, 2, 0], n).astype(np.int64)
    rows = np.repeat(2 * n + k, 2)
    bases = np.column_stack([k, n + k]).ravel()
    entries = HighestEntries(rows, bases, rows, chains.ids(bases, d[bases]))
    nothing = pantelides(incidence_of_pairs(k, k, n, chains_of(np.full(n, -1))).signature())
    assert isinstance(nothing, Offsets)
    offsets = Offsets(c, d, nothing.matching, 2)
    angles = np.linspace(0, 40, n)
    values = np.column_stack([np.sin(angles), -np.cos(angles)]).ravel()
    selection = select_states(chains, offsets, entries, values, np.zeros(0, np.int8))
    assert selection.states.shape[0] == 2 * n
    x_depends = selection.depth[:n] == 2
    assert (x_depends ^ (selection.depth[n : 2 * n] == 2)).all()
    clear = np.abs(np.abs(np.sin(angles)) - np.abs(np.cos(angles))) > 0.01
    assert (x_depends == (np.abs(np.sin(angles)) > np.abs(np.cos(angles))))[clear].all()
    turned = np.column_stack([np.sin(angles + 1.5), -np.cos(angles + 1.5)]).ravel()
    new = reselect(selection, turned)
    assert new is not None
    assert largest_gain(new, turned) <= 5.0 + 1e-6
    assert compress(np.array([0, 1]), 2).tolist() == [0, 1, 2]


@pytest.mark.parametrize("large", [0, 10**9])
def test_dense_choice_with_levels(large, monkeypatch):
    """Elimination and orthogonalisation both nest and reach the bound on ``B^-1 N``."""
    monkeypatch.setattr(column_choice, "LARGE", large)
    random = np.random.default_rng(5)
    matrix = random.normal(size=(1, 12, 30))
    levels = np.array([3] * 4 + [2] * 3 + [1] * 5)
    ranks = np.full((1, 3, 30), 3)
    depth = column_choice.choose_columns(matrix, levels, ranks)
    assert np.bincount(depth[0]).tolist() == [18, 5, 3, 4]
    depth, _ = column_choice.improve_columns(matrix, levels, ranks, depth, 2.0)
    gains, _ = column_choice.exchange_gains(matrix, levels, depth)
    assert np.exp(gains.max()) <= 2.0
    assert np.bincount(depth[0]).tolist() == [18, 5, 3, 4]


def test_many_ranks_are_taken_in_order():
    """With a generic matrix the columns of lowest rank become dependent, whatever their size."""
    random = np.random.default_rng(6)
    matrix = random.normal(size=(3, 4, 9))
    ranks = np.tile(np.array([5, 4, 3, 2, 1, 5, 4, 3, 2]), (3, 1, 1))
    depth = column_choice.choose_columns(matrix, np.ones(4, np.int64), ranks)
    assert (depth == (ranks[:, 0] <= 3)[:, :] * 1).sum() >= 3 * 8
    assert (depth[:, [4, 3, 8]] == 1).all()
    assert (depth[:, [0, 5, 1, 6]] == 0).all()


def test_a_triangular_choice_lasts() -> None:
    # x = f(phi), y = g(phi, x) in blocks of two rows; phi (column 2) is the state. The chosen
    # columns x, y make a triangle with ones on its diagonal, whatever dg/dx is.
    block = np.array([[0, 0, 0, 0, 0], [0, 0, 1, 1, 1], [0, 2, 0, 1, 2]])
    levels, depth = np.array([2, 2]), np.array([[2, 2, 0]])
    constant = np.array([True, False, False, True, False])
    assert not determinant_varies(block, levels, depth, constant).any()
    # With x as the state, the determinant is df/dphi.
    other = np.array([[0, 2, 2]])
    assert determinant_varies(block, levels, other, constant).all()
