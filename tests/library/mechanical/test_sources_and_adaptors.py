"""Sources, adaptors and small parts, for translation and rotation alike, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.mechanical.one_dimensional import BOTH, ROTATION, TRANSLATION, simulate, values

HEAD = "import $package$.*;\nmodel M\n"
fields = pytest.mark.parametrize("field", BOTH, ids=["translation", "rotation"])


@fields
def test_constant_power_accelerates_with_the_root_of_time(field: dict[str, str]) -> None:
    result = simulate(
        HEAD
        + """  $Mass$ body($m$ = 2, $s$(fixed = true), $v$(start = 1, fixed = true));
  InverseSpeedDependent$Force$ drive($f$_nominal = 3, $v$_nominal = 2);
  $Mass$ slow($s$(fixed = true), $v$(start = 0.01, fixed = true));
  InverseSpeedDependent$Force$ push($f$_nominal = 1, $v$0 = 0.1);
equation
  connect(drive.flange, body.flange_a);
  connect(push.flange, slow.flange_a);
end M;
""",
        field,
        stop_time=0.02,
        points=101,
    )
    speed, t = field["v"], result.times
    assert values(result, f"body.{speed}") == pytest.approx(np.sqrt(1 + 6 * t), abs=1e-7)
    exponential = 0.01 * np.exp(t / 0.01)  # f = v/0.01 below 0.1
    assert values(result, f"slow.{speed}") == pytest.approx(exponential, rel=1e-6)


@fields
@pytest.mark.parametrize("kind", ["Exp", "Sine", "Linear", "CoSine"])
def test_brake_of_constant_size_brings_to_rest(field: dict[str, str], kind: str) -> None:
    result = simulate(
        HEAD + f"  $Mass$ body($m$ = 2, $s$(fixed = true), $v$(start = -4, fixed = true));\n"
        f"  Sign$Force$ brake($f$_nominal = -3, reg = blocks.Regularization.{kind}, $v$0 = 0.01);\n"
        "equation\n  connect(brake.flange, body.flange_a);\nend M;\n",
        field,
        stop_time=5,
    )
    speed, t = values(result, f"body.{field['v']}"), result.times
    moving = t < 2.6
    assert speed[moving] == pytest.approx(-4 + 1.5 * t[moving], abs=1e-4)
    assert abs(speed[-1]) < 0.011


@fields
def test_eddy_current_brake(field: dict[str, str]) -> None:
    # J v' = -2 f x/(1 + x^2) with x = v/v_n: x^2/2 + ln x falls linearly.
    result = simulate(
        HEAD
        + """  $Mass$ body($m$ = 5, $s$(fixed = true), $v$(start = 20, fixed = true));
  EddyCurrent$Force$ brake($f$_nominal = 30, $v$_nominal = 8, useExcitationInput = true,
    useHeatPort = true, TRef = 293.15, alpha20 = 3.9e-3);
  blocks.Constant half(k = 0.5);
  thermal.FixedTemperature warm(T = 343.15);
equation
  connect(half.y, brake.excitation);
  connect(brake.flange, body.flange_a);
  connect(brake.heatPort, warm.port);
end M;
""",
        field,
        stop_time=6,
    )
    nominal = 8 * (1 + 3.9e-3 * 50)
    x = values(result, f"body.{field['v']}") / nominal
    law = x**2 / 2 + np.log(x)
    fall = 2 * 30 * 0.25 / (5 * nominal)
    assert law == pytest.approx(law[0] - fall * result.times, abs=1e-6)
    lost = values(result, "brake.lossPower")
    assert values(result, "warm.port.Q_flow") == pytest.approx(lost)


@fields
def test_prescribed_motion_follows_its_three_signals(field: dict[str, str]) -> None:
    result = simulate(
        HEAD
        + """  blocks.KinematicPTP2 path(q_end = {2}, qd_max = {1}, qdd_max = {2});
  Move move(useSupport = true);
  Fixed base($s$0 = 1);
  $Mass$ load($m$ = 3);
  $Force$Sensor sensor;
equation
  connect(path.q[1], move.u[1]);
  connect(path.qd[1], move.u[2]);
  connect(path.qdd[1], move.u[3]);
  connect(base.flange, move.support);
  connect(move.flange, sensor.flange_a);
  connect(sensor.flange_b, load.flange_a);
end M;
""",
        field,
        stop_time=3,
    )
    wanted = values(result, "path.q[1]")
    assert wanted[-1] == pytest.approx(2)
    assert values(result, f"load.{field['s']}") == pytest.approx(1 + wanted, abs=1e-8)
    force = values(result, f"sensor.{field['f']}")
    assert force == pytest.approx(3 * values(result, "path.qdd[1]"), abs=1e-6)


@fields
def test_inerter_is_a_mass_between_two_bodies(field: dict[str, str]) -> None:
    # Spring and inerter side by side between a wall and a body: omega^2 = c/(m + b).
    result = simulate(
        HEAD
        + """  Fixed wall;
  Inerter inerter(b = 3);
  Spring spring(c = 16);
  $Mass$ body($m$ = 1, $s$(start = 0.1, fixed = true), $v$(fixed = true));
equation
  connect(wall.flange, inerter.flange_a, spring.flange_a);
  connect(inerter.flange_b, spring.flange_b, body.flange_a);
end M;
""",
        field,
        stop_time=5,
    )
    position = values(result, f"body.{field['s']}")
    assert position == pytest.approx(0.1 * np.cos(2 * result.times), abs=1e-6)


@fields
def test_start_values_by_signals(field: dict[str, str]) -> None:
    # A mass on a spring starts where position and acceleration are given: c*s = -m*a.
    result = simulate(
        HEAD
        + """  InitializeFlange start(use_a_start = false);
  InitializeFlange other(use_$s$_start = false);
  blocks.Constant s0(k = 0.3), v0(k = -2), v1(k = 1), a1(k = -0.5);
  $Mass$ body, hung($m$ = 2);
  Spring spring(c = 4);
  Fixed wall;
equation
  connect(s0.y, start.$s$_start);
  connect(v0.y, start.$v$_start);
  connect(v1.y, other.$v$_start);
  connect(a1.y, other.a_start);
  connect(start.flange, body.flange_a);
  connect(other.flange, hung.flange_a, spring.flange_b);
  connect(spring.flange_a, wall.flange);
end M;
""",
        field,
        stop_time=1,
    )
    s, v = field["s"], field["v"]
    assert values(result, f"body.{s}") == pytest.approx(0.3 - 2 * result.times, abs=1e-9)
    assert values(result, f"hung.{s}")[0] == pytest.approx(0.25)
    assert values(result, f"hung.{v}")[0] == pytest.approx(1)


@fields
def test_signals_in_place_of_a_flange(field: dict[str, str]) -> None:
    # A mass behind signals and a mass at a spring move as one on it.
    result = simulate(
        HEAD
        + """  $Mass$ one($m$ = 1, $s$(start = 0.1, fixed = true), $v$(fixed = true));
  Spring spring(c = 12);
  Fixed wall;
  General$Force$To$Position$Adaptor outside;
  General$Position$To$Force$Adaptor inside(use_pder = false);
  $Mass$ two($m$ = 2);
  RelativeStates relative;
equation
  connect(wall.flange, spring.flange_a, relative.flange_a);
  connect(spring.flange_b, one.flange_a, relative.flange_b, outside.flange);
  connect(outside.p, inside.p);
  connect(inside.f, outside.f);
  connect(inside.flange, two.flange_a);
end M;
""",
        field,
        stop_time=4,
    )
    wave = 0.1 * np.cos(2 * result.times)
    assert values(result, f"one.{field['s']}") == pytest.approx(wave, abs=1e-6)
    assert values(result, f"relative.{field['s']}_rel") == pytest.approx(wave, abs=1e-6)
    assert values(result, "outside.pder") == pytest.approx(
        -0.2 * np.sin(2 * result.times), abs=1e-6
    )


ADAPTORS = (
    ("General$Force$To$Position$Adaptor", "General$Position$To$Force$Adaptor", "p pder pder2 f"),
    ("$Force$To$Position$Adaptor", "$Position$To$Force$Adaptor", "$s$ $v$ a $f$"),
)


@fields
@pytest.mark.parametrize("names", ADAPTORS, ids=["general", "with units"])
def test_a_flange_cut_in_two_hands_on_its_motion_with_derivatives(
    field: dict[str, str], names: tuple[str, str, str]
) -> None:
    # A body of three masses on a spring: c/(1 + 2 + 3) = 4.
    flow, potential, signals = names
    result = simulate(
        HEAD
        + f"""  $Mass$ one($m$ = 1, $s$(start = 0.1, fixed = true), $v$(fixed = true));
  Spring spring(c = 24);
  Fixed wall;
  {flow} outside;
  {potential} inside;
  $Mass$ two($m$ = 2);
  {KIND[field["Position"], field["Force"]]}Inerter three(b = 3);
equation
  connect(wall.flange, spring.flange_a, three.flange_a);
  connect(spring.flange_b, three.flange_b, one.flange_a, outside.flange);
"""
        + "".join(f"  connect(outside.{s}, inside.{s});\n" for s in signals.split())
        + "  connect(inside.flange, two.flange_a);\nend M;\n",
        field,
        stop_time=4,
    )
    wave = 0.1 * np.cos(2 * result.times)
    assert values(result, f"one.{field['s']}") == pytest.approx(wave, abs=1e-6)
    assert values(result, f"two.{field['s']}") == pytest.approx(wave, abs=1e-6)


KIND = {("Position", "Force"): "Translational", ("Angle", "Torque"): "Rotational"}


@fields
@pytest.mark.parametrize("acceleration", [False, True])
def test_a_flange_follows_signals_and_corrects_them(
    field: dict[str, str], acceleration: bool
) -> None:
    # What is said about the velocity is wrong by 0.5: the position is off by 0.5/w_crit, or by
    # 2*0.5/w_crit if it is corrected in both derivatives.
    flag = str(acceleration).lower()
    result = simulate(
        HEAD
        + f"""  $Position$To$Force$Adaptor right(use_a = {flag}), wrong(use_a = {flag});
  $Mass$ body($m$ = 2), other($m$ = 2);
equation
  right.$s$ = 0.1*sin(3*time);
  right.$v$ = 0.3*cos(3*time);
  wrong.$s$ = 0.1*sin(3*time);
  wrong.$v$ = 0.3*cos(3*time) + 0.5;
"""
        + ("  right.a = -0.9*sin(3*time);\n  wrong.a = -0.9*sin(3*time);\n" * acceleration)
        + """  connect(right.flange, body.flange_a);
  connect(wrong.flange, other.flange_a);
end M;
""",
        field,
        stop_time=2,
    )
    position = 0.1 * np.sin(3 * result.times)
    assert values(result, f"body.{field['s']}") == pytest.approx(position, abs=1e-6)
    force = values(result, f"right.{field['f']}")
    assert force == pytest.approx(2 * 0.9 * np.sin(3 * result.times), abs=1e-4)
    off = (values(result, f"other.{field['s']}") - position)[result.times > 0.1]
    assert off == pytest.approx((2 if acceleration else 1) * 0.5 / (100 * np.pi), rel=1e-3)


def test_lever_and_planetary_gear_share_motion_and_force() -> None:
    for field, ports in ((TRANSLATION, ("flange_a", "pivot", "flange_b")),
                         (ROTATION, ("sun", "carrier", "ring"))):  # fmt: skip
        first, middle, last = ports
        result = simulate(
            HEAD
            + f"""  $Lever$ bar(ratio = 3);
  $Mass$ a($m$ = 1, $s$(fixed = true), $v$(start = 1, fixed = true));
  $Mass$ b($m$ = 2, $s$(fixed = true), $v$(start = -1, fixed = true)), c($m$ = 3);
  Constant$Force$ push($f$_constant = 5);
equation
  connect(push.flange, a.flange_a);
  connect(a.flange_b, bar.{first});
  connect(b.flange_b, bar.{last});
  connect(c.flange_b, bar.{middle});
end M;
""",
            field,
            stop_time=2,
        )
        va, vb, vc = (values(result, f"{name}.{field['v']}") for name in "abc")
        assert 4 * vc == pytest.approx(va + 3 * vb, abs=1e-9)
        kinetic = va**2 / 2 + vb**2 + 1.5 * vc**2
        work = 5 * values(result, f"a.{field['s']}")
        assert kinetic - work == pytest.approx(np.full_like(work, kinetic[0]), abs=1e-7)


@fields
def test_gearbox_loses_what_its_table_says(field: dict[str, str]) -> None:
    result = simulate(
        HEAD
        + """  Gearbox box(ratio = 4, lossTable = [0, 0.9, 0.8, 0.2, 0.2],
    c = 1e4, d = 50, b = 1e-3);
  $Mass$ load($m$ = 8, $s$(fixed = true), $v$(start = 0, fixed = true));
  $Mass$ rotor($m$ = 0.1);
  Constant$Force$ motor($f$_constant = 10);
equation
  connect(motor.flange, rotor.flange_a);
  connect(rotor.flange_b, box.flange_a);
  connect(box.flange_b, load.flange_a);
end M;
""",
        field,
        stop_time=4,
    )
    # Without oscillation: 8 a = 4 (0.9 (10 - 0.1*4 a) - 0.2).
    expected = 4 * (0.9 * 10 - 0.2) / (8 + 16 * 0.09) * result.times
    late = result.times > 2
    speed = values(result, f"load.{field['v']}")
    assert speed[late] == pytest.approx(expected[late], rel=2e-2)


def test_translational_gear_with_a_support_that_moves() -> None:
    result = simulate(
        HEAD
        + """  IdealGear gear(ratio = -2, useSupport = true);
  LossyGear worn(ratio = -2, lossTable = [0, 0.5, 0.5, 0, 0], useSupport = true);
  Mass a(s(fixed = true), v(start = 1, fixed = true)), b, c, d, frame(m = 4), fixedFrame(m = 1e9);
  Constant$Force$ push($f$_constant = 2), pull($f$_constant = 2);
equation
  connect(push.flange, a.flange_a);
  connect(a.flange_b, gear.flange_a);
  connect(gear.flange_b, b.flange_a);
  connect(gear.support, frame.flange_a);
  connect(pull.flange, c.flange_a);
  connect(c.flange_b, worn.flange_a);
  connect(worn.flange_b, d.flange_a);
  connect(worn.support, fixedFrame.flange_a);
initial equation
  frame.s = 0;
  frame.v = 0;
  c.s = 0;
  c.v = 0;
  fixedFrame.s = 0;
  fixedFrame.v = 0;
end M;
""",
        TRANSLATION,
        stop_time=1,
    )
    va, vb, vf = (values(result, f"{n}.v") for n in ("a", "b", "frame"))
    assert va - vf == pytest.approx(-2 * (vb - vf), abs=1e-9)
    momentum = va + vb + 4 * vf
    assert momentum == pytest.approx(momentum[0] + 2 * result.times, abs=1e-7)
    # Half of the force through the mesh is lost: c: a_c = 2 - F, d: a_d = -(2 F/2), a_c = -2 a_d.
    assert values(result, "c.v") == pytest.approx(2 / 1.5 * result.times, abs=1e-6)


def test_ratchet_lets_pass_one_way_only() -> None:
    result = simulate(
        HEAD
        + """  OneWayClutch ratchet(fn_max = 10);
  blocks.Constant open(k = 0);
  Mass hand($s$(fixed = true), $v$(fixed = true)), body($s$(fixed = true), $v$(fixed = true));
  Force drive;
  blocks.Cosine shake(amplitude = 2, f = 0.5);
equation
  connect(open.y, ratchet.f_normalized);
  connect(shake.y, drive.f);
  connect(drive.flange, hand.flange_a);
  connect(hand.flange_b, ratchet.flange_a);
  connect(ratchet.flange_b, body.flange_a);
end M;
""",
        TRANSLATION,
        stop_time=2,
    )
    hand, body = values(result, "hand.v"), values(result, "body.v")
    assert np.all(body - hand > -1e-9)
    assert np.all(np.diff(body) > -1e-9)
    assert body[-1] > 0.2


def test_vehicle_rolls_against_wind_slope_and_resistance() -> None:
    text = """import mechanical.translational.*;
model M
  Vehicle still(m = 1000, J = 4, R = 0.3, A = 2, Cd = 0.3, vWindConstant = 5, CrConstant = 0.02,
    inclinationConstant = 0.05, v(start = 20, fixed = true), s(fixed = true));
  Vehicle signals(m = 1000, J = 4, R = 0.3, A = 2, Cd = 0.3, useWindInput = true, useCrInput = true,
    useInclinationInput = true, v(start = 20, fixed = true), s(fixed = true));
  blocks.Constant wind(k = 5), cr(k = 0.02), slope(k = 0.05);
  mechanical.rotational.ConstantTorque drive[2](each tau_constant = 600);
equation
  connect(wind.y, signals.vWind);
  connect(cr.y, signals.cr);
  connect(slope.y, signals.inclination);
  connect(drive[1].flange, still.flangeR);
  connect(drive[2].flange, signals.flangeR);
end M;
"""
    result = simulate(text, TRANSLATION, stop_time=60, tolerance=1e-8)
    same = values(result, "signals.v")
    v = values(result, "still.v")
    assert v == pytest.approx(same, rel=1e-9)
    g, angle = 9.80665, np.arctan(0.05)
    force = 600 / 0.3 - 1000 * g * (np.sin(angle) + 0.02 * np.cos(angle))
    force -= 0.5 * 1.2 * 0.3 * 2 * (v - 5) * np.abs(v - 5)
    mass = 1000 + 4 / 0.3**2
    assert values(result, "still.a") == pytest.approx(force / mass, rel=1e-7)
    assert np.ptp(v) > 5
