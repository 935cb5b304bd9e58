"""Random networks of chambers, resistances and pistons: mass and energy are kept."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acausal import compile_text


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def network(seed: int) -> str:
    """Return chambers in a circle with chords, some behind pistons, and one way to the outside."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 5))
    parts, joins, masses, energies = "", "", [], []
    for k in range(n):
        start = f"p(start = {rng.uniform(0.5, 8):.3f}e5, fixed = true), "
        start += f"T(start = {rng.uniform(250, 400):.1f}, fixed = true)"
        masses.append(f"c{k}.m")
        energies.append(f"c{k}.U")
        if rng.random() < 0.4:
            size = rng.uniform(1, 5)
            parts += f"""  Cylinder c{k}(A = 1e-3, stopStiffness = 0, V0 = {size:.2f}e-4, {start});
  mechanical.translational.Mass m{k}(m = {rng.uniform(0.5, 5):.2f}, s(start = 0.1, fixed = true),
    v(start = 0, fixed = true));
  mechanical.translational.Spring s{k}(c = 2e4);
  mechanical.translational.Fixed f{k};
"""
            joins += f"  connect(c{k}.flange_b, m{k}.flange_a, s{k}.flange_b);\n"
            joins += f"  connect(c{k}.flange_a, f{k}.flange, s{k}.flange_a);\n"
            energies.append(f"m{k}.m*m{k}.v^2/2 + s{k}.c*s{k}.s_rel^2/2 + gas.p_ambient*c{k}.V")
        else:
            parts += f"  VolumeClosed c{k}(V_const = {rng.uniform(1, 10):.2f}e-4, {start});\n"
        kinds = [
            "Restriction r{}(C = 2e-9)",
            "Nozzle r{}(A = 1e-6)",
            "LaminarRestriction r{}(D = 1e-3)",
        ]
        kind = str(rng.choice(kinds))
        parts += f"  {kind.format(k)};\n"
        joins += f"  connect(c{k}.port, r{k}.port_a);\n"
        joins += f"  connect(r{k}.port_b, c{(k + 1) % n}.port);\n"
    return f"""import pneumatic.*;
model Network
  inner Gas gas;
{parts}  CheckValve out(C = 1e-9);
  FlowSensor meter;
  Environment environment;
  Real inside = {" + ".join(masses)}, energy = {" + ".join(energies)};
  Real lost(start = 0, fixed = true), carried(start = 0, fixed = true);
equation
{joins}  connect(c0.port, meter.port_a);
  connect(meter.port_b, out.port_a);
  connect(out.port_b, environment.port);
  der(lost) = meter.m_flow;
  der(carried) = meter.port_a.H_flow;
end Network;
"""


@settings(max_examples=8, deadline=None, derandomize=True)
@given(st.integers(0, 10**6))
def test_mass_and_energy_are_kept(seed: int) -> None:
    result = compile_text(network(seed)).simulate(stop_time=0.5, tolerance=1e-8)
    assert result.times[-1] == 0.5
    mass = values(result, "inside") + values(result, "lost")
    assert mass == pytest.approx(mass[0], rel=1e-5)
    energy = values(result, "energy") + values(result, "carried")
    assert energy == pytest.approx(energy[0], rel=1e-5)
    assert abs(values(result, "lost")[-1]) > 0
