"""Flux tubes of a fixed shape: permeances in closed form, saturation, magnets, coils."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from tests.library.magnetic.circuits import MU_0, last, simulate, values

# 100 A across one tube
ACROSS = """  ConstantMagneticPotentialDifference source(V_m = 100[A]);
  Ground ground;
  {tube};
equation
  connect(source.port_p, tube.port_p);
  connect(source.port_n, tube.port_n, ground.port);
"""
LINEAR = "nonLinearPermeability = false, mu_rConst = 500"


def flux(tube: str) -> float:
    return last(simulate(ACROSS.format(tube=tube)), "tube.Phi")


@pytest.mark.parametrize(
    ("tube", "permeance"),
    [
        (f"GenericFluxTube tube({LINEAR}, l = 0.2, area = 3e-4)", 500 * MU_0 * 3e-4 / 0.2),
        (f"Cuboid tube({LINEAR}, l = 0.2, a = 0.02, b = 0.03)", 500 * MU_0 * 6e-4 / 0.2),
        (
            f"HollowCylinderAxialFlux tube({LINEAR}, l = 0.2, r_i = 0.01, r_o = 0.02)",
            500 * MU_0 * np.pi * 3e-4 / 0.2,
        ),
        (
            f"HollowCylinderRadialFlux tube({LINEAR}, l = 0.2, r_i = 0.01, r_o = 0.02)",
            # shells in series
            1 / quad(lambda r: 1 / (500 * MU_0 * 2 * np.pi * r * 0.2), 0.01, 0.02)[0],
        ),
        (
            f"HollowCylinderCircumferentialFlux tube({LINEAR}, l = 0.2, r_i = 0.1, r_o = 0.11)",
            # shells side by side, nearly: the wall is thin
            quad(lambda r: 500 * MU_0 * 0.2 / (np.pi / 2 * r), 0.1, 0.11)[0] * (1 - 0.00075),
        ),
        (
            f"Toroid tube({LINEAR}, r = 0.1, d = 0.01)",
            500 * MU_0 * np.pi * 0.25e-4 / (np.pi * 0.05),
        ),
        ("ConstantReluctance tube(R_m = 20)", 1 / 20),
        ("ConstantPermeance tube(G_m = 20)", 20),
        ("VariableReluctance tube; equation tube.R_m = 10*(1 + time)", 1 / 20),
        ("VariablePermeance tube; equation tube.G_m = 10*(1 + time)", 20),
        (
            "LeakageWithCoefficient tube(c_usefulFlux = 0.9); equation tube.R_mUsefulTot = 20",
            1 / 180,
        ),
        ("magnetic.Idle tube(Phi(start = 0))", 0),
        ("leakage.QuarterCylinder tube(l = 2)", MU_0 * 1.04),
        ("leakage.HalfCylinder tube(l = 2)", MU_0 * 0.52),
        ("leakage.QuarterSphere tube(d = 2)", MU_0 * 0.154),
        ("leakage.EighthOfSphere tube(r = 2)", MU_0 * 0.616),
        (
            "leakage.QuarterHollowCylinder tube(l = 2, ratio = 3)",
            quad(lambda r: MU_0 * 2 / (np.pi / 2 * r), 0.1, 0.4)[0],
        ),
        (
            "leakage.HalfHollowCylinder tube(l = 2, ratio = 3)",
            quad(lambda r: MU_0 * 2 / (np.pi * r), 0.1, 0.4)[0],
        ),
        ("leakage.QuarterHollowSphere tube(t = 2)", MU_0 * 0.5),
        ("leakage.EighthOfHollowSphere tube(t = 2)", MU_0),
        (
            "leakage.CoaxCylindersEndFaces tube(r_0 = 0.01, r_1 = 0.02, r_2 = 0.024)",
            # half circles around the gap: mean circumference and radii from 5 mm to 9 mm
            quad(lambda r: MU_0 * 2 * np.pi * 0.015 / (np.pi * r), 0.005, 0.009)[0],
        ),
    ],
)
def test_permeances(tube: str, permeance: float) -> None:
    assert flux(tube) == pytest.approx(100 * permeance, rel=1e-5, abs=1e-15)


def permeability(density: float, mu_i: float, most: float, a: float, b: float, n: float) -> float:
    relative = abs(density) / most
    return 1 + (mu_i - 1 + a * relative) / (1 + b * relative + relative**n)


@pytest.mark.parametrize(
    ("material", "data"),
    [
        ("Steel_9SMnPb28", (400, 1.488, 1200, 3, 12.5)),
        ("M350_50A", (1210, 1.16, 24630, 2.44, 14)),
        ("MuMetall", (27300, 0.46, 1037500, 3.67, 10)),
        ("DC03", (1, 1.05, 27790, 16, 10.4)),
    ],
)
def test_saturation(material: str, data: tuple[float, ...]) -> None:
    # the field strength goes from -20 kA/m to 20 kA/m
    result = simulate(
        """  SignalMagneticPotentialDifference source;
  Ground ground;
  Cuboid tube(l = 0.1, a = 0.01, b = 0.01, material = soft_magnetic.MATERIAL());
equation
  source.V_m = 2000*sin(time);
  connect(source.port_p, tube.port_p);
  connect(source.port_n, tube.port_n, ground.port);
""".replace("MATERIAL", material),
        stop_time=6.283185307,
        points=41,
    )
    density, strength = values(result, "tube.B"), values(result, "tube.H")
    assert strength == pytest.approx(20e3 * np.sin(result.times), abs=1e-3)
    for b, h in zip(density, strength, strict=True):
        found = brentq(lambda x, h=h: x / MU_0 / permeability(x, *data) - h, -3, 3, xtol=1e-12)
        assert b == pytest.approx(found, abs=1e-6)
    assert 0.5 < np.max(density) < 2.5  # saturated


def test_all_materials_have_a_plausible_peak_of_permeability() -> None:
    names = [
        "Steel_9SMnPb28",
        "Steel_9SMn28K",
        "DC01",
        "DC03",
        "X6Cr17",
        "AISI_1008",
        "AISI_12L14",
        "M330_50A",
        "M350_50A",
        "M530_50A",
        "M700_100A",
        "M940_100A",
        "RFe80",
        "VacoferS2",
        "Vacoflux50",
        "MuMetall",
        "Permenorm3601K3",
    ]
    lines = [
        f"  parameter soft_magnetic.BaseData m{k} = soft_magnetic.{name}();\n"
        f"  Real mu{k} = relativePermeability(time, m{k}.B_myMax, m{k}.mu_i, m{k}.c_a, m{k}.c_b,"
        f" m{k}.n);"
        for k, name in enumerate(names)
    ]
    result = simulate("\n".join(lines), stop_time=3, points=3001)
    for k, name in enumerate(names):
        mu = values(result, f"mu{k}")
        peak = result.times[np.argmax(mu)]
        assert np.max(mu) > 350, name
        assert 0.3 < peak < 2.0, name
        # far beyond saturation little more than the field in vacuum is left
        assert mu[-1] < np.max(mu) / 5, name


def test_magnet_works_where_its_line_meets_that_of_the_gap() -> None:
    result = simulate(
        """  GenericLinearPermanentMagnet magnet(l = 5e-3, A = 1e-4,
    material = hard_magnetic.NdFeB(T_op = 393.15));
  Cuboid gap(nonLinearPermeability = false, l = 2e-3, a = 0.01, b = 0.01);
  Short yoke;
  MagneticFluxSensor meter;
  MagneticPotentialDifferenceSensor instrument;
  Ground ground;
equation
  connect(magnet.port_n, meter.port_p);
  connect(meter.port_n, yoke.port_p);
  connect(yoke.port_n, gap.port_p, instrument.port_p);
  connect(gap.port_n, magnet.port_p, instrument.port_n, ground.port);
"""
    )
    remanence, coercivity = 1.2 * 0.9, 900e3 * 0.9
    line = remanence / coercivity
    density = remanence / (1 + line / MU_0 * 2 / 5)
    assert last(result, "gap.B") == pytest.approx(density, rel=1e-9)
    assert last(result, "meter.Phi") == pytest.approx(density * 1e-4, rel=1e-9)
    assert last(result, "instrument.V_m") == pytest.approx(density / MU_0 * 2e-3, rel=1e-9)
    assert last(result, "magnet.H") == pytest.approx((density - remanence) / line, rel=1e-9)


def test_all_magnets_have_a_permeability_near_that_of_air() -> None:
    names = [
        "NdFeB",
        "Sm2Co17",
        "SmCo5",
        "PlasticNdFeB",
        "PlasticSmCo",
        "HardFerrite",
        "PlasticHardFerrite",
    ]
    lines = [f"  parameter hard_magnetic.BaseData m{k} = hard_magnetic.{n}(T_op = 293.15);\n"
             f"  Real mu{k} = m{k}.B_r/(constants.mu_0*m{k}.H_cB);"
             for k, n in enumerate(names)]  # fmt: skip
    result = simulate("\n".join(lines))
    for k, name in enumerate(names):
        assert 1 < last(result, f"mu{k}") < (1.8 if name == "HardFerrite" else 1.35), name


COIL = """  electrical.ConstantVoltage source(V = 10[V]);
  electrical.Resistor resistor(R = 2[Ohm]);
  electrical.Ground earth;
  {coil}(N = 50{more});
  ConstantReluctance core(R_m = 5000);
  Ground ground;
equation
  connect(source.p, resistor.p);
  connect(resistor.n, coil.p);
  connect(coil.n, source.n, earth.p);
  connect(coil.port_p, core.port_p);
  connect(coil.port_n, core.port_n, ground.port);
"""


@pytest.mark.parametrize(
    ("coil", "more", "inductance"),
    [
        ("ElectroMagneticConverter coil", ", Phi(fixed = true)", 0.5),
        (
            "ElectroMagneticConverterWithLeakageInductance coil",
            ", mu_rel = 1e5, A = 1e-4, L = 0.1, i(fixed = true)",
            0.5 + 50**2 * MU_0 * 1e5 * 1e-3,
        ),
    ],
)
def test_coil_is_an_inductor(coil: str, more: str, inductance: float) -> None:
    result = simulate(COIL.format(coil=coil, more=more), points=101)
    expected = 5 * (1 - np.exp(-2 * result.times / inductance))
    assert values(result, "coil.i") == pytest.approx(expected, abs=1e-6)
    assert values(result, "coil.L_stat")[1:] == pytest.approx(inductance, rel=1e-6)


def test_eddy_currents_are_a_turn_in_short_circuit() -> None:
    # the flux of a coil that is switched on rises later the better the loop conducts
    text = COIL.format(coil="ElectroMagneticConverter coil", more=", Phi(fixed = true)")
    text = text.replace("connect(coil.port_p, core.port_p);", "").replace(
        "  Ground ground;", "  Ground ground;\n  {loop};\n"
    )
    loop = simulate(
        text.format(loop="EddyCurrent ring_(useConductance = true, G = 4000)")
        + "  connect(coil.port_p, ring_.port_p);\n  connect(ring_.port_n, core.port_p);",
        points=101,
    )
    turn = simulate(
        text.format(loop="ElectroMagneticConverter ring_(N = 1)").replace(
            "  electrical.Ground earth;",
            "  electrical.Ground earth;\n  electrical.Resistor ring(R = 1/4000);",
        )
        + "  connect(coil.port_p, ring_.port_p);\n  connect(ring_.port_n, core.port_p);\n"
        "  connect(ring_.p, ring.p);\n  connect(ring_.n, ring.n, earth.p);",
        points=101,
    )
    rise = (50**2 / 2 + 4000) / 5000
    expected = 5 * 50 / 5000 * (1 - np.exp(-loop.times / rise))
    assert -values(loop, "coil.Phi") == pytest.approx(expected, abs=1e-7)
    assert values(turn, "coil.Phi") == pytest.approx(values(loop, "coil.Phi"), abs=1e-7)
    assert values(loop, "ring_.LossPower") == pytest.approx(
        values(turn, "ring.LossPower"), abs=1e-5
    )
    assert np.max(values(loop, "ring_.LossPower")) > 0.1


def test_eddy_currents_from_the_geometry() -> None:
    result = simulate(
        """  SignalMagneticFlux source;
  EddyCurrent ring_(rho = 1e-7, l = 0.2, A = 1e-4, alpha = 5e-3, T_ref = 293.15, T = 393.15);
  Ground ground;
equation
  source.Phi = 3*time;
  connect(source.port_p, ring_.port_p);
  connect(source.port_n, ring_.port_n, ground.port);
"""
    )
    assert last(result, "ring_.V_m") == pytest.approx(-3 * 1e-4 / (1e-7 * 0.2) / 1.5, rel=1e-6)


def test_crossing_and_flux_source() -> None:
    result = simulate(
        """  ConstantMagneticFlux source(Phi = 2);
  Crossing crossing;
  ConstantReluctance one(R_m = 3), other(R_m = 3);
  Ground ground;
equation
  connect(source.port_n, crossing.port_p1);
  connect(source.port_p, crossing.port_n1);
  connect(crossing.port_p2, one.port_p);
  connect(crossing.port_n2, one.port_n, ground.port);
  connect(other.port_p, one.port_p);
  connect(other.port_n, one.port_n);
"""
    )
    assert last(result, "one.Phi") == pytest.approx(1)
    assert last(result, "source.V_m") == pytest.approx(-3)
