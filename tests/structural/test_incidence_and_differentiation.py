"""Chains, incidence from families, and differentiated families."""

from __future__ import annotations

import numpy as np
import pytest

from acausal.expressions.build import add, call, mul, sub
from acausal.expressions.evaluate import evaluate
from acausal.expressions.nodes import TIME, const, slot
from acausal.flattening.model import EquationFamily, Operand, Origin, RowKind
from acausal.structural.differentiate import DifferentiatedSystem, differentiate
from acausal.structural.dummy_derivatives import select_states
from acausal.structural.highest_jacobian import highest_entries, highest_jacobian
from acausal.structural.incidence import chains_of, incidence_of
from acausal.structural.pantelides import Offsets, pantelides

V, P = Operand.VARIABLE, Operand.PARAMETER


def test_chains_by_base_and_order():
    # 3 = der(0), 1 = der(3); 2 alone; 5 = der(4), of which only 5 is an unknown.
    chains = chains_of(np.array([3, -1, -1, 1, 5, -1]))
    assert chains.base.tolist() == [0, 0, 1, 0, 2, 2]
    assert chains.order.tolist() == [0, 2, 0, 1, 0, 1]
    assert chains.highest.tolist() == [2, 0, 1]
    assert chains.heads.tolist() == [0, 2, 4]
    assert chains.ids(np.array([0, 0, 1, 1]), np.array([1, 3, 0, -1])).tolist() == [3, -1, 2, -1]
    some = chains_of(
        np.array([3, -1, -1, 1, 5, -1]), np.array([False, False, True, False, False, True])
    )
    assert some.base.tolist() == [-1, -1, 0, -1, 1, 1]
    assert some.n_bases == 2


def test_chains_grow_by_base_and_order():
    chains = chains_of(np.array([2, -1, -1])).extend(np.array([3, 1]))
    assert chains.derivative.tolist() == [2, 5, 3, 4, -1, -1]
    assert chains.base.tolist() == [0, 1, 0, 0, 0, 1]
    assert chains.order.tolist() == [0, 0, 1, 2, 3, 1]
    assert chains.extend(np.array([1, 1])) is chains


@pytest.mark.parametrize("derivative", [[2, 2, -1], [1, 0], [0]])
def test_impossible_chains_are_refused(derivative):
    with pytest.raises(ValueError, match="derivative"):
        chains_of(np.array(derivative))


def pendulum(n: int) -> tuple[list[EquationFamily], np.ndarray, int]:
    """n pendulums: m x'' = -T x, m y'' = -T y - m g + t, x^2 + y^2 = L^2; ids by pendulum."""
    k = np.arange(n)
    x, y, T, vx, vy, ax, ay = (7 * k + s for s in range(7))
    derivative = np.full(7 * n, -1)
    derivative[x], derivative[y], derivative[vx], derivative[vy] = vx, vy, ax, ay
    s = [slot(i) for i in range(5)]
    newton_x = add(mul(s[3], s[0]), mul(s[1], s[2]))
    newton_y = sub(add(add(mul(s[3], s[0]), mul(s[1], s[2])), mul(s[3], const(9.81))), TIME)
    length = sub(add(mul(s[0], s[0]), mul(s[1], s[1])), mul(s[2], s[2]))
    m, L = np.zeros(n, np.int64), np.ones(n, np.int64)
    origin = Origin(0, n, RowKind.DECLARED, None, "x^2 + y^2 = L^2", "Pendulum", 0, k)
    return (
        [
            EquationFamily(newton_x, (V, V, V, P), np.stack([ax, T, x, m]), 3 * k),
            EquationFamily(newton_y, (V, V, V, P), np.stack([ay, T, y, m]), 3 * k + 1),
            EquationFamily(length, (V, V, P), np.stack([x, y, L]), 3 * k + 2, (origin,)),
        ],
        derivative,
        3 * n,
    )


def reduce(n: int) -> tuple[list[EquationFamily], Offsets, DifferentiatedSystem]:
    families, derivative, n_rows = pendulum(n)
    chains = chains_of(derivative)
    offsets = pantelides(incidence_of(families, n_rows, chains).signature())
    assert isinstance(offsets, Offsets)
    system = differentiate(tuple(families), n_rows, chains, offsets.c, offsets.d)
    return families, offsets, system


def test_pendulum_family_is_differentiated_once_per_order():
    _, offsets, system = reduce(4)
    assert offsets.c.tolist() == [0, 0, 2] * 4
    assert len(system.families) == 5
    assert system.orders == (0, 0, 0, 1, 2)
    assert system.n_rows == 20
    assert system.source.tolist() == [*range(12), 2, 5, 8, 11, 2, 5, 8, 11]
    assert system.order.tolist() == [0] * 12 + [1] * 4 + [2] * 4
    assert system.rows_of(np.array([5, 8, 3]), np.array([1, 2, 0])).tolist() == [13, 18, 3]
    assert system.n_original == system.chains.n_variables == 28
    once, twice = system.families[3:]
    assert once.rows.tolist() == [12, 13, 14, 15]
    assert twice.rows.tolist() == [16, 17, 18, 19]
    assert once.origins[0].text == "x^2 + y^2 = L^2"
    # x = 0.6, y = 0.8, x' = 4, y' = -3, x'' = 1, y'' = 2
    values = np.tile([0.6, 0.8, 0.0, 4.0, -3.0, 1.0, 2.0], 4)

    def residual(family: EquationFamily) -> np.ndarray:
        return np.broadcast_to(
            evaluate(family.template, lambda s: values[family.operands[s]]), family.count
        )

    assert np.allclose(residual(once), 2 * (0.6 * 4.0 - 0.8 * 3.0))
    assert np.allclose(residual(twice), 2 * (16 + 9 + 0.6 * 1.0 + 0.8 * 2.0))


def test_jacobian_of_the_constraint_and_states():
    families, offsets, system = reduce(3)
    chains = chains_of(pendulum(3)[1])
    entries = highest_entries(incidence_of(families, 9, chains).signature(), offsets, system)
    values = np.tile([0.6, -0.8, 0.0, 0.0, 0.0, 0.0, 0.0], 3)
    values[7:9] = 0.8, 0.6
    jacobian, constant = highest_jacobian(
        families, chains, offsets, entries, values, np.array([1.0, 1.0])
    )
    assert jacobian.tolist() == [1.2, -1.6, 1.6, 1.2, 1.2, -1.6]
    assert not constant.any()
    assert entries.system_rows.tolist() == [12, 12, 13, 13, 14, 14]
    assert entries.variables.tolist() == [5, 6, 12, 13, 19, 20]
    selection = select_states(system.chains, offsets, entries, jacobian, np.zeros(0, np.int8))
    assert selection.states.tolist() == [0, 3, 8, 11, 14, 17]


def test_only_some_members_are_differentiated():
    """x_k = f_k(t) for all k, but only x_0 has a derivative in the system (x_0' = z)."""
    family = EquationFamily(
        sub(slot(0), mul(slot(1), call("sin", TIME))),
        (V, P),
        np.array([[0, 1, 2], [0, 0, 0]]),
        np.array([0, 1, 2]),
        (Origin(0, 2, RowKind.DECLARED, None, "a", "A", 0, np.array([5, 6])),
         Origin(2, 1, RowKind.DECLARED, None, "b", "B", 1, np.array([7]))),
    )  # fmt: skip
    rate = EquationFamily(sub(slot(0), slot(1)), (V, V), np.array([[4], [3]]), np.array([3]))
    chains = chains_of(np.array([-1, -1, 4, -1, -1]))
    offsets = pantelides(incidence_of((family, rate), 4, chains).signature())
    assert isinstance(offsets, Offsets)
    assert offsets.c.tolist() == [0, 0, 1, 0]
    system = differentiate((family, rate), 4, chains, offsets.c, offsets.d)
    new = system.families[2]
    assert new.rows.tolist() == [4]
    assert [(o.text, o.first, o.count, o.instances.tolist()) for o in new.origins] == [
        ("b", 0, 1, [7])
    ]
    value = evaluate(new.template, lambda s: [2.0, 3.0][new.kinds[s] == P], 0.0)
    assert float(value) == -1.0  # x' - p cos(0) with x' = 2, p = 3
    jacobian, constant = highest_jacobian(
        (family, rate), chains, offsets,
        highest_entries(incidence_of((family, rate), 4, chains).signature(), offsets, system),
        np.zeros(5), np.array([3.0]),
    )  # fmt: skip
    assert jacobian.tolist() == [1.0]
    assert constant.tolist() == [True]


def test_new_variables_are_made_where_derivatives_are_missing():
    """x = t, y = x', z = y': x and y are differentiated, der(y) is there, der(der(x)) is new."""
    families = (
        EquationFamily(sub(slot(0), TIME), (V,), np.array([[0]]), np.array([0])),
        EquationFamily(sub(slot(0), slot(1)), (V, V), np.array([[1, 2], [3, 4]]), np.array([1, 2])),
    )
    chains = chains_of(np.array([3, 4, -1, -1, -1]))
    offsets = pantelides(incidence_of(families, 3, chains).signature())
    assert isinstance(offsets, Offsets)
    assert offsets.c.tolist() == [2, 1, 0]
    system = differentiate(families, 3, chains, offsets.c, offsets.d)
    assert system.chains.n_variables == 6
    assert system.chains.base[5] == 0
    assert system.chains.order[5] == 2
    assert system.source.tolist() == [0, 1, 2, 0, 1, 0]
    selection = select_states(
        system.chains, offsets,
        highest_entries(incidence_of(families, 3, chains).signature(), offsets, system),
        np.ones(3), np.zeros(0, np.int8),
    )  # fmt: skip
    assert selection.states.tolist() == []
    assert selection.dummies.tolist() == [3, 4, 5]


def test_rows_whose_derivative_vanishes_are_told():
    families = (
        EquationFamily(call("floor", slot(0)), (V,), np.array([[0]]), np.array([0])),
        EquationFamily(sub(slot(0), slot(1)), (V, V), np.array([[1], [2]]), np.array([1])),
    )
    chains = chains_of(np.array([2, -1, -1]))
    offsets = pantelides(incidence_of(families, 2, chains).signature())
    assert isinstance(offsets, Offsets)
    system = differentiate(families, 2, chains, offsets.c, offsets.d)
    assert system.vanished.tolist() == [2]
