"""Several friction elements, gears and stops at once: energy, momentum, no creep."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from acausal import compile_text


def simulate(text: str, **options: Any) -> Any:
    return compile_text(text).simulate(**{"tolerance": 1e-9, **options})


def values(result: Any, path: str) -> Any:
    return np.asarray(result[path].values)


def nothing_creeps(result: Any, *components: str) -> None:
    for component in components:
        stuck = values(result, f"{component}.mode") == 0
        assert np.any(stuck)
        slip = values(result, f"{component}.w_relfric")[stuck]
        assert np.max(np.abs(slip)) < 1e-20


def test_coupled_clutches_lock_one_after_the_other() -> None:
    result = simulate(
        """import mechanical.rotational.*;
model CoupledClutches
  Inertia j1(J = 1, phi(fixed = true), w(start = 10, fixed = true));
  Inertia j[3](each J = 1, each phi(fixed = true), each w(start = 0, fixed = true));
  Clutch clutch[3](each peak = 1.1, each fn_max = 20);
  Torque torque;
  blocks.Sine drive(amplitude = 10, f = 5);
  blocks.Sine first(amplitude = 1, f = 0.2, phase = 1.57);
  blocks.Step second(startTime = 0.4), third(startTime = 0.9);
  Real work(start = 0, fixed = true), lost(start = 0, fixed = true);
  Real kinetic = (j1.w^2 + sum(j[k].w^2 for k in 1:3))/2;
equation
  connect(drive.y, torque.tau);
  connect(torque.flange, j1.flange_a);
  connect(j1.flange_b, clutch[1].flange_a);
  connect(clutch.flange_b, j.flange_a);
  connect(j[1:2].flange_b, clutch[2:3].flange_a);
  connect(first.y, clutch[1].f_normalized);
  connect(second.y, clutch[2].f_normalized);
  connect(third.y, clutch[3].f_normalized);
  der(work) = drive.y*j1.w;
  der(lost) = sum(clutch.lossPower);
end CoupledClutches;
""",
        stop_time=1.2,
    )
    balance = values(result, "kinetic") - values(result, "work") + values(result, "lost")
    assert balance == pytest.approx(50, abs=1e-6)
    assert np.all(np.diff(values(result, "lost")) >= -1e-12)
    nothing_creeps(result, "clutch[1]", "clutch[2]", "clutch[3]")
    assert 2.0 in values(result, "clutch[3].mode")


def test_gear_shift_with_planetary_clutch_and_brake() -> None:
    # The brake holds the ring: gear 3:1; then the clutch makes the gear turn as a block.
    result = simulate(
        """import mechanical.rotational.*;
model Shift
  Inertia engine(J = 1, phi(fixed = true), w(start = 50, fixed = true));
  IdealPlanetary planetary(ratio = 2);
  Inertia ring(J = 0.2);
  Inertia car(J = 5, phi(fixed = true), w(start = 0, fixed = true));
  Brake brake(fn_max = 200);
  Clutch clutch(fn_max = 200);
  blocks.Step first(offset = 1, height = -1, startTime = 3), second(startTime = 3);
  Real lost(start = 0, fixed = true);
equation
  connect(engine.flange_b, planetary.sun, clutch.flange_a);
  connect(planetary.carrier, car.flange_a, clutch.flange_b);
  connect(planetary.ring, ring.flange_a);
  connect(ring.flange_b, brake.flange_a);
  connect(first.y, brake.f_normalized);
  connect(second.y, clutch.f_normalized);
  der(lost) = brake.lossPower + clutch.lossPower;
end Shift;
""",
        stop_time=6,
    )
    t = result.times
    engine, ring, car = (values(result, f"{name}.w") for name in ("engine", "ring", "car"))
    assert 3 * car == pytest.approx(engine + 2 * ring, abs=1e-9)
    energy = (engine**2 + 0.2 * ring**2 + 5 * car**2) / 2
    assert energy + values(result, "lost") == pytest.approx(1312.5, abs=1e-6)
    shortly_before, after = (t > 2.9) & (t < 3), t > 5.9
    assert set(ring[shortly_before]) == {0.0}
    assert engine[shortly_before] == pytest.approx(3 * car[shortly_before])
    assert engine[after] == pytest.approx(car[after])
    assert ring[after] == pytest.approx(car[after])
    nothing_creeps(result, "brake", "clutch")


def test_row_of_sticking_and_slipping_masses_keeps_its_energy_balance() -> None:
    result = simulate(
        """import mechanical.translational.*;
model Row
  parameter Integer n = 6;
  Mass m[n](each m = 1, each s(fixed = true), v(start = {0.1*k for k in 1:n}, each fixed = true));
  FrictionForce between[n-1](each f_pos = [0, 2; 1, 1], each peak = 1.2);
  Spring spring[n-1](each c = 20);
  SupportFriction ground(f_pos = [0, 1]);
  Force drive;
  blocks.Sine force(amplitude = 12, f = 0.5);
  Real energy = sum(m[i].m*m[i].v^2 for i in 1:n)/2
    + sum(spring[i].c*spring[i].s_rel^2 for i in 1:n-1)/2;
  Real work(start = 0, fixed = true), lost(start = 0, fixed = true);
equation
  connect(force.y, drive.f);
  connect(drive.flange, m[1].flange_a);
  connect(m[1:n-1].flange_b, between.flange_a, spring.flange_a);
  connect(between.flange_b, m[2:n].flange_a);
  connect(spring.flange_b, m[2:n].flange_b);
  connect(m[n].flange_b, ground.flange_a);
  der(work) = force.y*m[1].v;
  der(lost) = sum(between.lossPower) + ground.lossPower;
end Row;
""",
        stop_time=5,
        tolerance=1e-10,
    )
    balance = values(result, "energy") - values(result, "work") + values(result, "lost")
    assert balance == pytest.approx(balance[0], abs=1e-4)
    assert np.all(np.diff(values(result, "lost")) >= -1e-9)
    slips = [values(result, f"between[{k}].mode") for k in range(1, 6)]
    assert sum(int(np.sum(np.diff(mode) != 0)) for mode in slips) > 10


def test_impulse_of_a_stop_goes_through_a_gear() -> None:
    # The stop hits the slow side; the fast inertia takes its share of the impulse by the gear.
    result = simulate(
        """import mechanical.rotational.*;
model Stop
  Inertia fast(J = 1, w(start = 6, fixed = true), phi(start = 0, fixed = true));
  IdealGear gear(ratio = 3);
  Inertia slow(J = 4);
  RigidGap stop(e = 0.5, phi_rel0 = 0);
  Fixed wall(phi0 = 1);
equation
  connect(fast.flange_b, gear.flange_a);
  connect(gear.flange_b, slow.flange_a);
  connect(slow.flange_b, stop.flange_a);
  connect(stop.flange_b, wall.flange);
end Stop;
""",
        stop_time=1,
    )
    t, fast, slow = result.times, values(result, "fast.w"), values(result, "slow.w")
    assert fast == pytest.approx(3 * slow, abs=1e-9)
    assert slow[t < 0.4999] == pytest.approx(2)
    assert slow[t > 0.5001] == pytest.approx(-1)


def test_friction_against_a_housing_that_moves() -> None:
    # A mass in a box: friction brings both to the velocity of their common momentum.
    result = simulate(
        """import mechanical.translational.*;
model Box
  Mass box(m = 3, s(fixed = true), v(start = 0, fixed = true));
  Mass inside(m = 1, s(fixed = true), v(start = 4, fixed = true));
  SupportFriction guide(f_pos = [0, 3], useSupport = true);
equation
  connect(inside.flange_b, guide.flange_a);
  connect(guide.support, box.flange_a);
end Box;
""",
        stop_time=2,
    )
    t = result.times
    inside, box = values(result, "inside.v"), values(result, "box.v")
    assert inside == pytest.approx(4 - 3 * np.minimum(t, 1), abs=1e-8)
    assert box == pytest.approx(np.minimum(t, 1), abs=1e-8)
    assert set(values(result, "guide.v")[t > 1.001]) == {0.0}


def test_lost_power_heats_the_brake() -> None:
    result = simulate(
        """import mechanical.rotational.*;
model Hot
  Inertia disc(J = 2, w(start = 10, fixed = true), phi(fixed = true));
  Brake brake(fn_max = 10, useHeatPort = true);
  blocks.Constant pressed(k = 1);
  thermal.HeatCapacitor steel(C = 50, T(start = 300, fixed = true));
equation
  connect(disc.flange_b, brake.flange_a);
  connect(pressed.y, brake.f_normalized);
  connect(brake.heatPort, steel.port);
end Hot;
""",
        stop_time=6,
    )
    assert values(result, "disc.w")[-1] == 0.0
    assert values(result, "steel.T")[-1] == pytest.approx(302, abs=1e-7)


def random_row(seed: int, grounded: bool) -> str:
    """Return masses in a row, each sliding on the one before; one or all of them on the ground."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 6))
    text = "import mechanical.translational.*;\nmodel Row\n  Force drive;\n"
    amplitude, frequency = rng.uniform(2, 20), rng.uniform(0.3, 3)
    text += f"  blocks.Sine force(amplitude = {amplitude:.3f}, f = {frequency:.3f});\n"
    equations = "  connect(force.y, drive.f);\n  connect(drive.flange, m1.flange_a);\n"
    loss, energy = [], []
    for i in range(1, n + 1):
        v = rng.uniform(-2, 2) if rng.random() < 0.5 else 0.0
        static = rng.uniform(0.2, 4)
        text += (
            f"  Mass m{i}(m = {rng.uniform(0.1, 5):.3f}, s(fixed = true), "
            f"v(start = {v:.2f}, fixed = true));\n"
        )
        energy.append(f"m{i}.m*m{i}.v^2/2")
        if i == n or grounded:
            text += (
                f"  SupportFriction g{i}(f_pos = [0, {static:.3f}; 0.3, {static / 3:.3f}; "
                f"10, {static / 3:.3f}], peak = {rng.uniform(1, 2):.2f});\n"
            )
            equations += f"  connect(m{i}.flange_b, g{i}.flange_a);\n"
            loss.append(f"g{i}.lossPower")
        if i > 1:
            creep = 1e-9 if grounded else 0
            text += (
                f"  Spring s{i}(c = {rng.uniform(1, 200):.2f});\n"
                f"  FrictionForce b{i}(f_pos = [0, {rng.uniform(0.1, 2):.3f}], creep = {creep});\n"
            )
            equations += f"  connect(m{i - 1}.flange_b, s{i}.flange_a, b{i}.flange_a);\n"
            equations += f"  connect(m{i}.flange_a, s{i}.flange_b, b{i}.flange_b);\n"
            loss.append(f"b{i}.lossPower")
            energy.append(f"s{i}.c*s{i}.s_rel^2/2")
    text += "  Real work(start = 0, fixed = true), lost(start = 0, fixed = true);\n"
    text += f"  Real energy = {' + '.join(energy)};\nequation\n{equations}"
    text += f"  der(work) = force.y*m1.v;\n  der(lost) = {' + '.join(loss)};\nend Row;\n"
    return text


@pytest.mark.parametrize("grounded", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_random_rows_of_masses_stick_and_slip(seed: int, grounded: bool) -> None:
    # All on the ground and on each other: those that stick hold each other in circles.
    result = simulate(random_row(seed, grounded), stop_time=4, tolerance=1e-8)
    assert result.times[-1] == 4
    balance = values(result, "energy") - values(result, "work") + values(result, "lost")
    scale = max(1.0, float(values(result, "energy").max()))
    assert balance == pytest.approx(balance[0], abs=1e-4 * scale)
    for mode in result.find("*.mode"):
        stuck = values(result, mode) == 0
        slip = values(result, mode.replace("mode", "v_relfric"))[stuck]
        assert np.max(np.abs(slip), initial=0) < (1e-7 if grounded else 1e-15)
