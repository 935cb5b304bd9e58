"""Magnetic forces: derivative of the co-energy, and the energy balance of a moving armature."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.magnetic.circuits import MU_0, simulate, values


@pytest.mark.parametrize(
    "tube",
    [
        "force.HollowCylinderAxialFlux tube(r_i = 0.005, r_o = 0.01)",
        "force.HollowCylinderAxialFlux tube(r_o = 0.01, dlBydx = -1, l = 0.03 - tube.s)",
        "force.HollowCylinderRadialFlux tube(r_i = 0.01, r_o = 0.011, mu_r = 1.05)",
        "force.HollowCylinderRadialFlux tube(dlBydx = -1, l = 0.03 - tube.s)",
        "force.CuboidParallelFlux tube(a = 0.01, b = 0.02)",
        "force.CuboidOrthogonalFlux tube(a = 0.01, b = 0.001)",
        "force.LeakageAroundPoles tube(w = 0.03, r = 0.003)",
    ],
)
def test_force_is_the_slope_of_the_co_energy(tube: str) -> None:
    result = simulate(
        f"""  ConstantMagneticPotentialDifference source(V_m = 300[A]);
  Ground ground;
  {tube};
  mechanical.translational.ConstantSpeed drive(v_fixed = 1, s(start = 5e-3, fixed = true));
equation
  connect(source.port_p, tube.port_p);
  connect(source.port_n, tube.port_n, ground.port);
  connect(drive.flange, tube.flange);
""",
        stop_time=0.02,
        points=2001,
    )
    co_energy = 300**2 / 2 * values(result, "tube.G_m")
    slope = np.gradient(co_energy, values(result, "tube.s"))
    inside = slice(5, -5)
    assert values(result, "tube.F_m")[inside] == pytest.approx(slope[inside], rel=1e-4)
    assert values(result, "tube.flange.f") == pytest.approx(-values(result, "tube.F_m"))
    assert np.max(np.abs(slope)) > 1e-3


def test_force_in_an_air_gap_follows_from_the_flux_density() -> None:
    # pull of an electromagnet: B^2 A/(2 mu0), the same by every model of the gap
    result = simulate(
        """  SignalMagneticFlux source;
  Ground ground;
  force.CuboidParallelFlux gap(a = 0.01, b = 0.01, useSupport = true);
  AirGap other(A = 1e-4);
  mechanical.translational.Fixed yoke(s0 = 1e-3), armature(s0 = 3e-3);
equation
  source.Phi = 1e-4*time;
  connect(source.port_p, gap.port_p);
  connect(gap.port_n, other.port_p);
  connect(source.port_n, other.port_n, ground.port);
  connect(yoke.flange, gap.support, other.flange_a);
  connect(armature.flange, gap.flange, other.flange_b);
"""
    )
    pull = -(result.times**2) * 1e-4 / (2 * MU_0)
    assert values(result, "gap.F_m") == pytest.approx(pull, abs=1e-9)
    assert values(result, "other.F") == pytest.approx(pull, abs=1e-9)
    # what pulls the armature pulls the yoke
    assert values(result, "yoke.flange.f") == pytest.approx(-values(result, "armature.flange.f"))
    assert values(result, "armature.flange.f")[-1] == pytest.approx(2 * pull[-1] * -1 * -1)


def test_energy_of_a_plunger_magnet() -> None:
    # source = resistor + field + motion; saturated iron, so the field energy is an integral
    result = simulate(
        """  electrical.ConstantVoltage source(V = 24[V]);
  electrical.Resistor resistor(R = 8[Ohm]);
  electrical.Ground earth;
  ElectroMagneticConverter coil(N = 600, Phi(fixed = true));
  HollowCylinderAxialFlux iron(l = 0.12, r_o = 5e-3, material = soft_magnetic.Steel_9SMnPb28());
  force.HollowCylinderAxialFlux gap(r_o = 5e-3, useSupport = false);
  force.LeakageAroundPoles stray(w = 0.04, r = 3e-3);
  EddyCurrent eddy(useConductance = true, G = 500);
  Ground ground;
  mechanical.translational.Mass armature(m = 0.03,
    s(start = 4e-3, fixed = true), v(start = 0, fixed = true));
  mechanical.translational.SpringDamper spring(c = 1000, d = 10, s_rel0 = 5e-3);
  mechanical.translational.Fixed frame;
  Real supplied(start = 0, fixed = true), heat(start = 0, fixed = true);
  Real field(start = 0, fixed = true);
  Real work(start = 0, fixed = true);
equation
  connect(source.p, resistor.p);
  connect(resistor.n, coil.p);
  connect(coil.n, source.n, earth.p);
  connect(coil.port_p, iron.port_p);
  connect(iron.port_n, eddy.port_p);
  connect(eddy.port_n, gap.port_p, stray.port_p);
  connect(coil.port_n, gap.port_n, stray.port_n, ground.port);
  connect(gap.flange, stray.flange, armature.flange_a);
  connect(armature.flange_b, spring.flange_b);
  connect(spring.flange_a, frame.flange);
  der(supplied) = -source.v*source.i;
  der(heat) = resistor.LossPower + eddy.LossPower + spring.lossPower;
  der(work) = (gap.F_m + stray.F_m)*armature.v;
  der(field) = iron.V_m*der(iron.Phi);
""",
        stop_time=0.06,
        points=601,
        tolerance=1e-10,
    )
    gap_energy = sum(
        values(result, f"{tube}.V_m") ** 2 * values(result, f"{tube}.G_m") / 2
        for tube in ("gap", "stray")
    )
    motion = 0.03 / 2 * values(result, "armature.v") ** 2
    spring = 1000 / 2 * (values(result, "spring.s_rel") - 5e-3) ** 2
    stored = gap_energy + values(result, "field") + motion + spring
    balance = values(result, "supplied") - values(result, "heat") - stored + stored[0]
    assert values(result, "supplied")[-1] > 0.3
    assert np.max(motion) > 1e-4
    assert balance == pytest.approx(0, abs=1e-6)
    assert np.min(values(result, "gap.l")) > 0
