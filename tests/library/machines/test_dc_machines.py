"""Direct current machines: nominal point, closed forms, losses, temperature, housing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acausal import compile_text


def run(text: str, stop_time: float = 1.0, **options: Any) -> Any:
    options = {"tolerance": 1e-8, "points": 201, **options}
    text = f"import electrical.machines.*;\nmodel Test\n{text}\nend Test;\n"
    return compile_text(text).simulate(stop_time=stop_time, **options)


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


SUPPLY = """  electrical.ConstantVoltage supply(V = {0});
  electrical.Ground ground;
"""
LOSSES = "brushParameters(V = 2), frictionParameters(PRef = 100), coreParameters(PRef = 0)"


@pytest.mark.parametrize(
    ("machine", "wiring", "speed"),
    [
        ("DC_PermanentMagnet", "connect(supply.n, m.pin_an);", 1425),
        ("DC_ElectricalExcited", "connect(supply.n, m.pin_an, m.pin_en);", 1425),
        ("DC_SeriesExcited", "connect(m.pin_an, m.pin_ep); connect(supply.n, m.pin_en);", 1410),
    ],
)
def test_nominal_point(machine: str, wiring: str, speed: float) -> None:
    shunt = ", m.pin_ep" if machine == "DC_ElectricalExcited" else ""
    w = speed * np.pi / 30
    result = run(
        SUPPLY.format(100)
        + f"""  {machine} m({LOSSES}, TaOperational = 368.15, TaNominal = 368.15,
    alpha20a = 3.92e-3, ia(start = 100, fixed = true));
  mechanical.rotational.ConstantSpeed load(w_fixed = {w});
equation
  connect(supply.p, m.pin_ap{shunt});
  {wiring}
  connect(supply.n, ground.p);
  connect(m.flange, load.flange);
""",
        stop_time=2,
    )
    assert values(result, "m.ia")[-1] == pytest.approx(100, rel=1e-5)
    Ra = 0.05 * (1 + 3.92e-3 * 75)
    Re = 0.01 * 100**2 if machine == "DC_SeriesExcited" else 0
    assert values(result, "m.powerArmature")[-1] == pytest.approx(Ra * 1e4 + 200, rel=1e-5)
    shaft = 100 * 100 - Ra * 1e4 - 200 - 100 - Re
    assert values(result, "m.tauShaft")[-1] * w == pytest.approx(shaft, rel=1e-5)


def test_run_up_of_a_permanent_magnet_machine() -> None:
    result = run(
        SUPPLY.format(24)
        + """  DC_PermanentMagnet m(VaNominal = 24, IaNominal = 10, wNominal = 200, Ra = 0.4,
    La = 1e-3, Jr = 2e-3,
    ia(fixed = true), wMechanical(fixed = true));
equation
  connect(supply.p, m.pin_ap);
  connect(supply.n, m.pin_an, ground.p);
""",
        stop_time=0.5,
    )
    k, R, L, J = 20 / 200, 0.4, 1e-3, 2e-3
    slow, fast = sorted(-np.roots([L * J, R * J, k**2]).real)
    t = result.times
    share = (fast * np.exp(-slow * t) - slow * np.exp(-fast * t)) / (fast - slow)
    assert values(result, "m.wMechanical") == pytest.approx(24 / k * (1 - share), abs=1e-4)


def test_excitation_has_its_time_constant_and_weakens_the_field() -> None:
    result = run(
        SUPPLY.format(100)
        + """  electrical.StepVoltage field(V = -50, offset = 100, startTime = 1);
  DC_ElectricalExcited m(Le = 10, sigmae = 0.1, ie(start = 1, fixed = true));
  mechanical.rotational.ConstantSpeed drive(w_fixed = 100);
equation
  connect(supply.p, m.pin_ap);
  connect(field.p, m.pin_ep);
  connect(supply.n, m.pin_an, field.n, m.pin_en, ground.p);
  connect(drive.flange, m.flange);
""",
        stop_time=2,
    )
    t = result.times
    ie = np.where(t < 1, 1, 0.5 + 0.5 * np.exp(-10 * (t - 1)))
    assert values(result, "m.ie") == pytest.approx(ie, abs=1e-6)
    assert values(result, "m.psi_e") == pytest.approx(9 * ie, abs=1e-5)
    nominal = 95 / (1425 * np.pi / 30)
    assert values(result, "m.vai") == pytest.approx(nominal * 100 * ie, abs=1e-4)


def test_losses_follow_their_laws() -> None:
    result = run(
        """  electrical.SignalCurrent source(i = 20*time - 10);
  electrical.Ground ground;
  DC_PermanentMagnet m(frictionParameters(PRef = 90, wRef = 100, power_w = 3),
    strayLoadParameters(PRef = 40, IRef = 10, wRef = 100, power_w = 2),
    brushParameters(V = 1.5, ILinear = 2), coreParameters(PRef = 50, VRef = 80), Ra = 0);
  mechanical.rotational.Speed drive(exact = true, w_ref = 200*time - 100);
equation
  connect(source.n, m.pin_ap);
  connect(source.p, m.pin_an, ground.p);
  connect(drive.flange, m.flange);
"""
    )
    t = result.times
    i, r = 20 * t - 10, np.abs(2 * t - 1)
    vai = values(result, "m.vai")
    expected = 90 * r**3 + 40 * (i / 10) ** 2 * r**2 + 50 * (vai / 80) ** 2
    assert values(result, "m.powerCore") == pytest.approx(expected, abs=1e-3)
    assert values(result, "m.powerArmature") == pytest.approx(
        1.5 * np.abs(i) * np.minimum(np.abs(i) / 2, 1), abs=1e-6
    )


def test_housing_takes_the_torque() -> None:
    result = run(
        SUPPLY.format(24)
        + """  DC_PermanentMagnet m(VaNominal = 24, IaNominal = 10, wNominal = 200, Ra = 0.4,
    Jr = 2e-3, Js = 0.01, useSupport = true, ia(fixed = true), frictionParameters(PRef = 5),
    flange(phi(start = 0, fixed = true)), support(phi(start = 0, fixed = true)));
  mechanical.rotational.Inertia wheel(J = 0.01, w(start = 0, fixed = true));
  mechanical.rotational.Inertia frame(J = 0.05, w(start = 0, fixed = true));
equation
  connect(supply.p, m.pin_ap);
  connect(supply.n, m.pin_an, ground.p);
  connect(m.flange, wheel.flange_a);
  connect(m.support, frame.flange_a);
""",
        stop_time=0.5,
    )
    momentum = 0.012 * values(result, "wheel.w") + 0.06 * values(result, "frame.w")
    assert momentum == pytest.approx(0, abs=1e-6)
    assert values(result, "wheel.w")[-1] > 10
    assert values(result, "m.wMechanical") == pytest.approx(
        values(result, "wheel.w") - values(result, "frame.w"), abs=1e-8
    )


@given(
    st.sampled_from(["DC_PermanentMagnet", "DC_ElectricalExcited", "DC_SeriesExcited"]),
    st.lists(st.floats(0, 300), min_size=3, max_size=3),
    st.floats(0, 3),
    st.floats(20, 150),
)
@settings(max_examples=6, deadline=None, derandomize=True)
def test_power_goes_to_shaft_heat_and_storage(
    machine: str, losses: list[float], brush: float, voltage: float
) -> None:
    excited, series = machine != "DC_PermanentMagnet", machine == "DC_SeriesExcited"
    shunt = excited and not series
    result = run(
        SUPPLY.format(voltage)
        + f"""  {machine} m(useThermalPort = true, alpha20a = 4e-3, ia(fixed = true),
    {"ie(fixed = true), " if shunt else ""}wMechanical(fixed = true),
    frictionParameters(PRef = {losses[0]}), coreParameters(PRef = {losses[1]}),
    strayLoadParameters(PRef = {losses[2]}), brushParameters(V = {brush}));
  thermal.HeatCapacitor winding(C = 20, T(start = 300, fixed = true));
  thermal.HeatCapacitor iron(C = 50, T(start = 300, fixed = true));
  thermal.FixedTemperature room(T = 300);
  mechanical.rotational.Inertia load(J = 0.2);
  Real work(start = 0, fixed = true), excitation(start = 0, fixed = true), stored;
equation
  connect(supply.p, m.pin_ap{", m.pin_ep" if shunt else ""});
  {"connect(m.pin_an, m.pin_ep);" if series else ""}
  connect(supply.n, ground.p, {"m.pin_en" if series else "m.pin_an"});
  {"connect(m.pin_en, ground.p);" if shunt else ""}
  connect(m.flange, load.flange_a);
  connect(m.heatPortArmature, winding.port);
  connect(m.heatPortCore, iron.port);
  {"connect(m.heatPortExcitation, room.port);" if excited else ""}
  der(work) = -supply.v*supply.i;
  der(excitation) = {"m.powerExcitation" if excited else "0"};
  stored = m.La*m.ia^2/2 + {"m.Le*m.ie^2/2" if excited else "0"}
    + (m.Jr + load.J)*m.wMechanical^2/2
    + winding.C*(winding.T - 300) + iron.C*(iron.T - 300) + excitation;
""",
        stop_time=1,
        tolerance=1e-9,
    )
    work = values(result, "work")
    assert values(result, "stored") == pytest.approx(work, abs=1e-5 * work[-1])
    assert work[-1] > 10
