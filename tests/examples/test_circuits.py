"""S02, S03, S32 and the ladder: circuits against closed forms and conservation laws."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp


def power(result: Any, path: str) -> Any:
    """Electric power into a component with two pins."""
    return np.asarray(result[f"{path}.v"].values) * np.asarray(result[f"{path}.i"].values)


def test_rlc_reaches_its_stationary_oscillation(simulate: Any) -> None:
    result = simulate("rlc", stop_time=0.1, tolerance=1e-8, points=2001)
    omega = 2 * np.pi * 50
    current = 10 / (100 + 1j * omega * 10e-3 + 1 / (1j * omega * 1e-6))
    late = result.times > 0.04
    expected = np.imag(current * np.exp(1j * omega * result.times))
    assert result["r.i"].values[late] == pytest.approx(expected[late], abs=1e-7)
    assert result["l.i"].values == pytest.approx(result["r.i"].values, abs=1e-12)


def test_junction_rules(simulate: Any) -> None:
    result = simulate("junction", stop_time=0.05, tolerance=1e-8)
    meeting = ["feed.n", "load.p", "filter.p", "choke.p", "dangling.p"]
    potentials = [result[f"{cut}.v"].values for cut in meeting]
    currents = [result[f"{cut}.i"].values for cut in meeting]
    for potential in potentials[1:]:
        assert potential == pytest.approx(potentials[0], abs=1e-12)
    assert np.sum(currents, axis=0) == pytest.approx(0, abs=1e-7)
    assert np.max(np.abs(currents[0])) > 0.1


def test_an_unconnected_cut_has_no_current(simulate: Any) -> None:
    result = simulate("junction", stop_time=0.05)
    assert result["dangling.n.i"].values == pytest.approx(0, abs=1e-15)
    assert result["dangling.p.i"].values == pytest.approx(0, abs=1e-9)
    assert result["dangling.n.v"].values == pytest.approx(result["dangling.p.v"].values, abs=1e-12)


def test_powers_of_a_closed_circuit_add_up_to_zero(simulate: Any) -> None:
    result = simulate("junction", stop_time=0.05, tolerance=1e-8)
    parts = ["source", "feed", "load", "filter", "choke"]
    total = sum(power(result, part) for part in parts)
    assert total == pytest.approx(0, abs=1e-6)
    assert np.max(power(result, "load")) > 0.1


def test_simple_network_of_the_lecture(simulate: Any) -> None:
    result = simulate("simple_network", stop_time=5e-3, tolerance=1e-9)
    t = result.times
    assert result["l.i"].values == pytest.approx(10 / 10 * (1 - np.exp(-t * 10 / 10e-3)), abs=1e-7)
    assert result["c.v"].values == pytest.approx(10 * (1 - np.exp(-t / (100 * 10e-6))), abs=1e-6)
    # the algebraic quantities of the lecture: i1, V1, V3
    assert result["r1.i"].values == pytest.approx(0.1 * np.exp(-t / 1e-3), abs=1e-8)
    assert result["u.p.v"].values == pytest.approx(10)
    assert result["l.p.v"].values == pytest.approx(10 * np.exp(-t * 1e3), abs=1e-6)


def test_electrical_and_mechanical_oscillator_are_the_same(simulate: Any) -> None:
    result = simulate("analogies", stop_time=10, tolerance=1e-9)
    displacement = result["mass.s"].values
    assert result["q"].values == pytest.approx(displacement, abs=1e-7)
    assert result["l.i"].values == pytest.approx(result["mass.v"].values, abs=1e-6)
    decay, omega0 = 0.8 / (2 * 0.5), np.sqrt(20 / 0.5)
    omega = np.sqrt(omega0**2 - decay**2)
    since = np.maximum(result.times - 0.1, 0)
    wave = np.cos(omega * since) + decay / omega * np.sin(omega * since)
    assert displacement == pytest.approx(2 / 20 * (1 - np.exp(-decay * since) * wave), abs=1e-6)


@pytest.mark.parametrize("sections", [1, 10])
def test_ladder_against_equations_written_by_hand(simulate: Any, sections: int) -> None:
    result = simulate(
        "ladder", "Ladder", {"N": sections}, stop_time=2e-3, tolerance=1e-7, points=101
    )
    r, ell, c, saturation, n_vt, load, bias = 1.0, 1e-6, 1e-6, 1e-9, 0.05, 1.0, 0.05

    def right_side(t: float, y: Any) -> Any:
        current, voltage = y[:sections], y[sections:]
        source = np.sin(2 * np.pi * 1e3 * t)
        left = np.concatenate(([source], voltage[:-1]))
        onward = np.concatenate((current[1:], [load * voltage[-1]]))
        diode = saturation * (np.exp(voltage / n_vt) - 1)
        into = current - onward - diode + bias * (0.7 * source - voltage)
        return np.concatenate(((left - voltage - r * current) / ell, into / c))

    expected = solve_ivp(
        right_side, (0, 2e-3), np.zeros(2 * sections), "Radau", result.times, rtol=1e-8, atol=1e-10
    ).y
    for k in range(sections):
        voltage = result[f"section[{k + 1}].c.v"].values
        assert voltage == pytest.approx(expected[sections + k], abs=2e-5)
        assert result[f"section[{k + 1}].l.i"].values == pytest.approx(expected[k], abs=2e-5)
