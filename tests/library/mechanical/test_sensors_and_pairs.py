"""Sensors of relative motion and of cuts, sources between two flanges, rigid parts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from acausal import compile_text
from tests.library.mechanical.one_dimensional import BOTH, simulate, values

PAIR = """
model Test
  import $package$.*;
  $Mass$ a($m$ = 2, $s$(start = 0, fixed = true), $v$(start = 0, fixed = true));
  $Mass$ b($m$ = 3, $s$(start = 1, fixed = true), $v$(start = 0, fixed = true));
  $Force$2 push;
  Rel$Position$Sensor distance;
  RelAccSensor approach;
  MultiSensor cut;
  blocks.Sine drive(f = 0.5, amplitude = 6);
equation
  connect(drive.y, push.$f$);
  connect(a.flange_b, cut.flange_a);
  connect(cut.flange_b, push.flange_a, distance.flange_a, approach.flange_a);
  connect(push.flange_b, b.flange_a, distance.flange_b, approach.flange_b);
end Test;
"""


@pytest.mark.parametrize("names", BOTH, ids=["translation", "rotation"])
def test_two_bodies_push_each_other(names: dict[str, str]) -> None:
    result = simulate(PAIR, names, stop_time=2.0, points=201)
    times = np.asarray(result.times)
    drive = 6 * np.sin(np.pi * times)
    f, s, v = names["f"], names["s"], names["v"]
    assert values(result, f"push.{f}") == pytest.approx(drive, abs=1e-6)
    # What the flanges get is opposite and equal; the pair as a whole does not move.
    assert values(result, "approach.a_rel") == pytest.approx(drive * (1 / 2 + 1 / 3), abs=1e-6)
    moved = drive_twice_integrated(times) * (1 / 2 + 1 / 3)
    assert values(result, f"distance.{s}_rel") == pytest.approx(1 + moved, abs=1e-6)
    momentum = 2 * values(result, f"a.{v}") + 3 * values(result, f"b.{v}")
    assert momentum == pytest.approx(np.zeros_like(times), abs=1e-7)
    # The sensor stands between the first body and the source.
    assert values(result, f"cut.{v}") == pytest.approx(values(result, f"a.{v}"), abs=1e-6)
    force = values(result, f"cut.{f}")
    assert np.abs(force) == pytest.approx(np.abs(drive), abs=1e-6)
    power = values(result, "cut.power")
    assert power == pytest.approx(force * values(result, f"cut.{v}"), abs=1e-6)
    assert np.ptp(power) > 1


def drive_twice_integrated(times: Any) -> Any:
    """Return the double integral of 6 sin(pi t)."""
    return 6 / np.pi * (times - np.sin(np.pi * times) / np.pi)


@pytest.mark.parametrize("names", BOTH, ids=["translation", "rotation"])
def test_a_brake_that_is_proportional_to_the_speed(names: dict[str, str]) -> None:
    text = """
    model Test
      import $package$.*;
      $Mass$ body($m$ = 2, $s$(start = 0, fixed = true), $v$(start = 5, fixed = true));
      LinearSpeedDependent$Force$ brake($f$_nominal = -3, $v$_nominal = 2);
    equation
      connect(brake.flange, body.flange_a);
    end Test;
    """
    result = simulate(text, names, stop_time=3.0, points=101)
    # 2 dv/dt = -3 v / 2
    expected = 5 * np.exp(-0.75 * np.asarray(result.times))
    assert values(result, f"body.{names['v']}") == pytest.approx(expected, rel=1e-6)


def test_a_disc_turns_its_ends_against_each_other() -> None:
    result = compile_text("""
    model Test
      mechanical.rotational.Inertia left(J = 1, phi(start = 0.2, fixed = true),
        w(start = 1, fixed = true));
      mechanical.rotational.Disc disc(deltaPhi = 0.7);
      mechanical.rotational.Inertia right(J = 3);
      mechanical.rotational.ConstantTorque drive(tau_constant = 8);
    equation
      connect(left.flange_b, disc.flange_a);
      connect(disc.flange_b, right.flange_a);
      connect(drive.flange, right.flange_b);
    end Test;
    """).simulate(stop_time=1.0, points=11)
    times = np.asarray(result.times)
    expected = 0.2 + times + times**2  # (1 + 3) a = 8
    assert values(result, "left.phi") == pytest.approx(expected, rel=1e-6)
    assert values(result, "right.phi") == pytest.approx(expected + 0.7, rel=1e-6)


@pytest.mark.parametrize("package", ["mechanical.rotational", "mechanical.translational"])
def test_a_rack_and_pinion_passes_power_on(package: str) -> None:
    result = compile_text(f"""
    model Test
      {package}.IdealGearR2T rack(ratio = 5);
      mechanical.rotational.Inertia shaft(J = 0.1, phi(start = 0, fixed = true),
        w(start = 0, fixed = true));
      mechanical.rotational.ConstantTorque drive(tau_constant = 2);
      mechanical.translational.Mass rod(m = 4);
    equation
      connect(drive.flange, shaft.flange_a);
      connect(shaft.flange_b, rack.flangeR);
      connect(rack.flangeT, rod.flange_a);
    end Test;
    """).simulate(stop_time=1.0, points=11)
    times = np.asarray(result.times)
    # J w' + m v'/ratio = tau with w = ratio v
    acceleration = 2 / (0.1 * 5 + 4 / 5)
    assert values(result, "rod.s") == pytest.approx(acceleration * times**2 / 2, abs=1e-6)
    assert values(result, "shaft.w") == pytest.approx(5 * values(result, "rod.v"), abs=1e-9)
    speeds = values(result, "rack.flangeR.tau") * values(result, "shaft.w")
    forces = values(result, "rack.flangeT.f") * values(result, "rod.v")
    assert speeds + forces == pytest.approx(np.zeros_like(times), abs=1e-9)
    assert np.ptp(speeds) > 1
