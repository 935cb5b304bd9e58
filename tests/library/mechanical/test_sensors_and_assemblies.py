"""Sensors, rigid parts and random assemblies, for translation and rotation alike."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.mechanical.one_dimensional import BOTH, ROTATION, TRANSLATION, simulate, values

fields = pytest.mark.parametrize("field", BOTH, ids=["translation", "rotation"])

TRANSLATIONAL = """import mechanical.translational.*;
model M
  Mass a(m = 2, s(fixed = true), v(start = 3, fixed = true));
  Mass b(m = 1, s(start = 0.5), v(start = -1, fixed = true));
  Rod rod(L = 0.5);
  Mass c(m = 4);
  Force2 between;
  LinearSpeedDependentForce air(f_nominal = -6, v_nominal = 2);
  RelPositionSensor distance;
  RelAccSensor relative;
  MultiSensor multi;
  blocks.Sine drive(amplitude = 5, f = 1);
equation
  connect(drive.y, between.f);
  connect(between.flange_a, a.flange_a, distance.flange_a, relative.flange_a);
  connect(between.flange_b, multi.flange_a, distance.flange_b, relative.flange_b);
  connect(multi.flange_b, b.flange_a);
  connect(b.flange_b, rod.flange_a);
  connect(rod.flange_b, c.flange_a);
  connect(air.flange, a.flange_b);
initial equation
  b.s = 0.5;
end M;
"""
ROTATIONAL = """import mechanical.rotational.*;
model M
  Inertia a(J = 2, phi(fixed = true), w(start = 3, fixed = true));
  Inertia b(J = 1, phi(start = 0.5), w(start = -1, fixed = true));
  Disc rod(deltaPhi = 0.5);
  Inertia c(J = 4);
  Torque2 between;
  LinearSpeedDependentTorque air(tau_nominal = -6, w_nominal = 2);
  RelAngleSensor distance;
  RelAccSensor relative;
  MultiSensor multi;
  blocks.Sine drive(amplitude = 5, f = 1);
equation
  connect(drive.y, between.tau);
  connect(between.flange_a, a.flange_a, distance.flange_a, relative.flange_a);
  connect(between.flange_b, multi.flange_a, distance.flange_b, relative.flange_b);
  connect(multi.flange_b, b.flange_a);
  connect(b.flange_b, rod.flange_a);
  connect(rod.flange_b, c.flange_a);
  connect(air.flange, a.flange_b);
initial equation
  b.phi = 0.5;
end M;
"""


@pytest.mark.parametrize(
    ("text", "field"),
    [(TRANSLATIONAL, TRANSLATION), (ROTATIONAL, ROTATION)],
    ids=["translation", "rotation"],
)
def test_sensors_see_what_the_masses_do(text: str, field: dict[str, str]) -> None:
    result = simulate(text, field, stop_time=2)
    s, v, f = field["s"], field["v"], field["f"]
    force = 5 * np.sin(2 * np.pi * result.times)
    # The force pushes apart: a is pushed back, b and c as one mass of 5 forward.
    assert values(result, "multi.power") == pytest.approx(
        force * values(result, f"b.{v}"), abs=1e-6
    )
    assert values(result, f"multi.{f}") == pytest.approx(force, abs=1e-6)
    assert values(result, f"multi.{v}") == pytest.approx(values(result, f"b.{v}"))
    distance = values(result, f"b.{s}") - values(result, f"a.{s}")
    assert values(result, f"distance.{s}_rel") == pytest.approx(distance)
    assert values(result, f"c.{s}") == pytest.approx(values(result, f"b.{s}") + 0.5)
    own = (-force - 3 * values(result, f"a.{v}")) / 2
    assert values(result, "a.a") == pytest.approx(own, abs=1e-6)
    assert values(result, "relative.a_rel") == pytest.approx(force / 5 - own, abs=1e-6)
    start = 5 / (2 * np.pi) * (1 - np.cos(2 * np.pi * result.times)) / 5 - 1
    assert values(result, f"b.{v}") == pytest.approx(start, abs=1e-6)


def test_rack_and_pinion_from_both_packages() -> None:
    result = simulate(
        """model M
  mechanical.rotational.IdealGearR2T first(ratio = 5);
  mechanical.translational.IdealGearR2T second(ratio = 5, useSupportT = true);
  mechanical.rotational.Inertia pinion[2](each J = 0.2, each phi(fixed = true),
    each w(start = 0, fixed = true));
  mechanical.translational.Mass rack[2](each m = 3);
  mechanical.translational.Fixed base(s0 = 2);
  mechanical.rotational.ConstantTorque motor[2](each tau_constant = 1);
equation
  connect(motor.flange, pinion.flange_a);
  connect(pinion[1].flange_b, first.flangeR);
  connect(pinion[2].flange_b, second.flangeR);
  connect(first.flangeT, rack[1].flange_a);
  connect(second.flangeT, rack[2].flange_a);
  connect(second.supportT, base.flange);
end M;
""",
        TRANSLATION,
        stop_time=1,
    )
    acceleration = 1 / (0.2 + 3 / 5**2)
    for k in (1, 2):
        w = values(result, f"pinion[{k}].w")
        assert w == pytest.approx(acceleration * result.times, abs=1e-7)
        assert values(result, f"rack[{k}].v") == pytest.approx(w / 5)
    assert values(result, "rack[2].s")[0] == pytest.approx(2)


def assembly(seed: int, field: dict[str, str]) -> str:
    """Return random masses that are tied to each other by random parts."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 7))
    text, equations, energy, loss = "", "", [], []
    s, v, m = field["s"], field["v"], field["m"]
    for i in range(n):
        text += (
            f"  $Mass$ m{i}({m} = {rng.uniform(0.2, 5)}, {s}(start = {rng.uniform(-1, 1)}, "
            f"fixed = true), {v}(start = {rng.uniform(-2, 2)}, fixed = true));\n"
        )
        energy.append(f"m{i}.{m}*m{i}.{v}^2/2")
    ties = [(int(rng.integers(0, i)), i) for i in range(1, n)]
    ties += [(int(i), int(j)) for i, j in rng.integers(0, n, (2, 2)) if i != j]
    for k, (i, j) in enumerate(ties):
        c, d, b = rng.uniform(1, 50), rng.uniform(0.05, 3), rng.uniform(0.1, 2)
        part, stored, lost = [
            (f"Spring p{k}(c = {c})", f"p{k}.c*p{k}.{s}_rel^2/2", ""),
            (f"Damper p{k}(d = {d})", "", f"p{k}.lossPower"),
            (f"SpringDamper p{k}(c = {c}, d = {d})", f"p{k}.c*p{k}.{s}_rel^2/2", f"p{k}.lossPower"),
            (f"Inerter p{k}(b = {b})", f"p{k}.b*p{k}.{v}_rel^2/2", ""),
            (
                f"ElastoGap p{k}(c = {c}, d = {d})",
                f"p{k}.c*noEvent(min(p{k}.{s}_rel, 0))^2/2",
                f"p{k}.lossPower",
            ),
            (f"Clutch p{k}(fn_max = 2, f_normalized = 1)", "", f"p{k}.lossPower"),
        ][int(rng.integers(0, 6 if k < n - 1 else 4))]
        text += f"  {part};\n"
        energy += [stored] if stored else []
        loss += [lost] if lost else []
        equations += f"  connect(m{i}.flange_b, p{k}.flange_a);\n"
        equations += f"  connect(p{k}.flange_b, m{j}.flange_a);\n"
    text += f"  Real energy = {' + '.join(energy)};\n  Real lost(start = 0, fixed = true);\n"
    momentum = " + ".join(f"m{i}.{m}*m{i}.{v}" for i in range(n))
    text += f"  Real momentum = {momentum};\nequation\n{equations}"
    text += f"  der(lost) = {' + '.join(loss) if loss else '0'};\n"
    return f"import $package$.*;\nmodel M\n{text}end M;\n"


@fields
@pytest.mark.parametrize("seed", range(6))
def test_random_assemblies_keep_energy_and_momentum(seed: int, field: dict[str, str]) -> None:
    result = simulate(assembly(seed, field), field, stop_time=4, tolerance=1e-9)
    total = values(result, "energy") + values(result, "lost")
    scale = float(np.max(total))
    assert total == pytest.approx(np.full_like(total, total[0]), abs=1e-6 * scale)
    momentum = values(result, "momentum")
    assert momentum == pytest.approx(np.full_like(momentum, momentum[0]), abs=1e-6 * scale)
    assert np.ptp(values(result, "energy")) > 1e-3 * scale or not np.ptp(values(result, "lost"))
