"""Random networks of volumes, restrictions, pistons and pumps: mass and energy are kept.

The energy of a liquid that is compressed without exchange of heat,
    counted from ambient pressure, is
e = rho*g - (p - p0) per volume, where g is the integral of 1/rho over the pressure; m_flow*g is the
power a mass flow rate carries.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acausal import compile_text

RESTRICTIONS = [
    "LaminarRestriction r{}(L = 0.5, D = 2e-3)",
    "GenericPressureLoss r{}(D = 2e-3)",
    "SharpEdgedOrifice r{}(D_pipe = 10e-3, D_min = 2e-3)",
    "SuddenExpansion r{}(D_a = 2e-3, D_b = 10e-3)",
    "CheckValve r{}(q_nom = 2e-4)",
    "ReliefValve r{}(q_nom = 2e-4, dp_relief = 2e6)",
    "WallFriction r{}(L = 3, D = 4e-3)",
]


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def network(seed: int) -> str:
    """Return stores in a circle,
    joined by restrictions; between two of them a pump with a flywheel."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 6))
    parts, joins, masses, energies, losses = "", "", [], [], []
    for k in range(n):
        start = f"p(start = {rng.uniform(5, 200):.1f}e5, fixed = true)"
        masses.append(f"c{k}.m")
        stored = f"c{k}.m*potential(c{k}.p) - c{k}.m/c{k}.rho*(c{k}.p - oil.p_ambient)"
        energies.append(stored)
        if rng.random() < 0.4:
            parts += f"""  FluidPower2MechTrans c{k}(A = 1e-3, residualVolume = 1e-4, {start});
  mechanical.translational.Mass m{k}(m = {rng.uniform(5, 50):.1f}, s(start = 0.1, fixed = true),
    v(start = {rng.uniform(-0.1, 0.1):.2f}, fixed = true));
  mechanical.translational.Spring s{k}(c = 2e5);
  mechanical.translational.Fixed f{k};
"""
            joins += f"  connect(c{k}.flange_b, m{k}.flange_a, s{k}.flange_b);\n"
            joins += f"  connect(c{k}.flange_a, f{k}.flange, s{k}.flange_a);\n"
            energies.append(f"m{k}.m*m{k}.v^2/2 + s{k}.c*s{k}.s_rel^2/2")
        else:
            parts += f"  VolumeClosed c{k}(V = {rng.uniform(1, 20):.2f}e-4, {start});\n"
        parts += f"  {str(rng.choice(RESTRICTIONS)).format(k)};\n"
        joins += f"  connect(c{k}.port, r{k}.port_a);\n"
        joins += f"  connect(r{k}.port_b, c{(k + 1) % n}.port);\n"
        losses.append(f"r{k}.m_flow*(potential(r{k}.port_a.p) - potential(r{k}.port_b.p))")
    return f"""import hydraulic.*;
function potential
  input si.Pressure p;
  output Real y(unit = "J/kg");
algorithm
  y := 1.6e9[Pa]/870[kg/m3]*(1 - exp((101325[Pa] - p)/1.6e9[Pa]));
end potential;
model Network
  inner Oil oil;
{parts}  FluidPower2MechRotConst pump(Dconst = 1e-5);
  mechanical.rotational.Inertia wheel(J = 0.005, phi(start = 0, fixed = true), w(start = 100,
    fixed = true));
  FluidInertia pipe(L = 2, A = 1e-4, m_flow(start = 0, fixed = true));
  Real total = {" + ".join(masses)}, lossPower = {" + ".join(losses)}, lost(start = 0,
    fixed = true);
  Real energy = {" + ".join(energies)} + wheel.J*wheel.w^2/2
    + pipe.L/pipe.A*pipe.m_flow^2/(2*oil.rho);
equation
{joins}  connect(c0.port, pump.port_a);
  connect(c0.port, pipe.port_a);
  connect(pump.port_b, pipe.port_b, c1.port);
  connect(wheel.flange_b, pump.flange_a);
  der(lost) = lossPower;
end Network;
"""


@settings(max_examples=8, deadline=None, derandomize=True)
@given(st.integers(0, 10**6))
def test_mass_and_energy_are_kept(seed: int) -> None:
    result = compile_text(network(seed)).simulate(stop_time=0.3, tolerance=1e-8)
    assert result.times[-1] == 0.3
    mass = values(result, "total")
    assert mass == pytest.approx(mass[0], rel=1e-7)
    energy = values(result, "energy") + values(result, "lost")
    # The pump and the inertia in the pipe count with one density, which costs up to 1 in 1000.
    assert energy == pytest.approx(energy[0], rel=1e-3)
    assert np.all(values(result, "lossPower") >= -1e-6)
    assert values(result, "lost")[-1] > 0
