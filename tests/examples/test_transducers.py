"""S01 and S05: components that couple two fields keep the power, and reach the right rest."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def test_motor_reaches_its_final_speed(simulate: Any) -> None:
    result = simulate("cuts_and_transducers", "Motor", stop_time=2, tolerance=1e-8)
    k, r, d, u = 0.05, 0.5, 1e-4, 12.0
    assert values(result, "rotor.w")[-1] == pytest.approx(u * k / (k**2 + r * d), rel=1e-4)
    electric = values(result, "emf.v") * values(result, "emf.i")
    mechanical = -values(result, "emf.flange.tau") * values(result, "rotor.w")
    assert mechanical == pytest.approx(electric, abs=1e-9)
    assert np.max(electric) > 10


def test_voice_coil_oscillates_as_its_impedance_says(simulate: Any) -> None:
    result = simulate("cuts_and_transducers", "VoiceCoil", stop_time=1, tolerance=1e-8, points=4001)
    omega, k = 2 * np.pi * 40, 7.0
    mechanical = 20e-3 * 1j * omega + 1.0 + 1500 / (1j * omega)
    current = 5 / (6 + 0.5e-3 * 1j * omega + k**2 / mechanical)
    velocity = k * current / mechanical
    late = result.times > 0.8
    expected = np.imag(velocity * np.exp(1j * omega * result.times))
    assert values(result, "cone.v")[late] == pytest.approx(expected[late], abs=2e-5)


def test_heating_resistor_warms_the_block(simulate: Any) -> None:
    result = simulate("cuts_and_transducers", "HeatingResistor", stop_time=300, tolerance=1e-8)
    heat = 230**2 / 50
    expected = 293.15 + heat / 10 * (1 - np.exp(-10 / 500 * result.times))
    assert values(result, "block_.T") == pytest.approx(expected, abs=1e-3)
    assert values(result, "wire.heatPort.Q_flow") == pytest.approx(-heat)


def test_hydraulic_cylinder_lifts_until_the_spring_holds(simulate: Any) -> None:
    result = simulate("cuts_and_transducers", "HydraulicCylinder", stop_time=5, tolerance=1e-8)
    force = 5e-4 * (50e5 - 101325)
    assert values(result, "load.s")[-1] == pytest.approx(force / 50e3, rel=1e-3)
    # What the oil brings is carried on by the rod, but for 0.5 % that compress the oil behind it.
    oil = values(result, "cylinder.port.m_flow") / 870 * (values(result, "line.p") - 101325)
    rod = values(result, "cylinder.f") * values(result, "load.v")
    assert rod == pytest.approx(oil, abs=5e-3 * np.max(rod))


def test_piston_pump_delivers_its_displacement(simulate: Any) -> None:
    result = simulate("cuts_and_transducers", "PistonPump", stop_time=1, tolerance=1e-8)
    w = 1500 * 2 * np.pi / 60
    assert values(result, "pump.w") == pytest.approx(w)
    pressure = 128 * 0.036 * 5 / (np.pi * 8e-3**4) * 1e-6 * w
    assert values(result, "line.p")[-1] - 101325 == pytest.approx(pressure, rel=1e-4)
    torque = values(result, "pump.flange_a.tau")
    hydraulic = -values(result, "pump.dp") * values(result, "pump.q")
    assert torque * w == pytest.approx(hydraulic, rel=1e-9, abs=1e-9)


def test_pneumatic_cylinder_pushes_until_the_spring_holds(simulate: Any) -> None:
    result = simulate("cuts_and_transducers", "PneumaticCylinder", stop_time=20, tolerance=1e-8)
    stroke = 1e-3 * (5e5 - 101325) / 5000
    assert values(result, "sledge.s")[-1] == pytest.approx(stroke, rel=1e-3)
    mass = 5e5 * (2e-5 + 1e-3 * stroke) / (287.05 * 293.15)
    assert values(result, "cylinder.m")[-1] == pytest.approx(mass, rel=1e-3)


def test_solenoid_pulls_against_its_spring(simulate: Any) -> None:
    result = simulate("cuts_and_transducers", "Solenoid", stop_time=0.5, tolerance=1e-8)
    gap = values(result, "gap.l")[-1]
    reluctance = 1e6 + gap / (1.25663706212e-6 * 1e-4)
    flux = 800 * 1.2 / reluctance
    pull = flux**2 / (2 * 1.25663706212e-6 * 1e-4)
    assert 100e3 * (2e-3 - gap) == pytest.approx(pull, rel=1e-3)
    assert 1e-4 < 2e-3 - gap < 2e-3


def test_multiport_conserves_power(simulate: Any) -> None:
    result = simulate("multiport", "Transmission", stop_time=1)
    k = np.array([[1, 2], [0, 3], [-1, 0.5]])
    across = k @ np.array([3, -2])
    through = np.array([1, 2, 4]) * across
    for i in range(3):
        assert values(result, f"box.outgoing[{i + 1}].ac") == pytest.approx(across[i])
    for j, expected in enumerate(k.T @ through):
        assert values(result, f"box.incoming[{j + 1}].th") == pytest.approx(expected)
    assert values(result, "box.powerIn") == pytest.approx(values(result, "box.powerOut"))
    assert values(result, "box.powerIn") == pytest.approx(across @ through)


def test_multiport_between_stores(simulate: Any) -> None:
    result = simulate("multiport", "Charging", stop_time=20, tolerance=1e-9)
    capacity = 1 * 1 + 3 * 2**2
    expected = 2 * (1 - np.exp(-result.times / capacity))
    assert values(result, "store[1].ac") == pytest.approx(expected, abs=1e-6)
    assert values(result, "store[2].ac") == pytest.approx(2 * expected, abs=1e-6)


def test_multiport_as_a_gear(simulate: Any) -> None:
    result = simulate("multiport", "WormDrive", stop_time=2, tolerance=1e-9)
    assert values(result, "drum.w") == pytest.approx(20 / 4 * result.times, abs=1e-6)
