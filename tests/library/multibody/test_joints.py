"""Joints transmit what they do not leave free, and do no work: energy of random mechanisms."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.library.multibody.bodies import G, energy, run, values, vector

#: Joints with start values that put them into motion.
MOVING = {
    "Revolute": "n = {1, 2, 0}, phi(start = 0.4, fixed = true), w(start = 2, fixed = true)",
    "Prismatic": "n = {1, 0, 2}, s(start = 0.1, fixed = true), v(start = 1, fixed = true)",
    "Cylindrical": "n = {0, 1, 1}, s(start = 0.1, fixed = true), v(start = 0.5, fixed = true),"
    " phi(start = 0.2, fixed = true), w(start = 1, fixed = true)",
    "Universal": "n_a = {1, 0, 0.2}, n_b = {0, 1, 0}, phi_a(start = 0.5, fixed = true),"
    " phi_b(start = -0.3, fixed = true), w_a(start = 1, fixed = true),"
    " w_b(start = 2, fixed = true)",
    "Planar": "n = {0, 1, 3}, s_x(start = 0.1, fixed = true), v_x(start = 0.3, fixed = true),"
    " s_y(fixed = true), v_y(start = -1, fixed = true), phi(fixed = true),"
    " w(start = 1, fixed = true)",
    "Spherical": "enforceStates = true, angles_fixed = true, angles_start = {0.1, 0.2, 0.3},"
    " w_rel_a_fixed = true, w_rel_a_start = {1, -2, 0.5}",
    "FreeMotion": "useQuaternions = false, r_rel_a(start = {0.1, 0, 0}, each fixed = true),"
    " v_rel_a(start = {0, 1, 2}, each fixed = true), angles_fixed = true,"
    " angles_start = {0.3, 0.2, 0.1}, w_rel_b_fixed = true, w_rel_b_start = {1, 0, 2}",
}
R_CM, INERTIA = (0.3, 0.1, -0.1), (0.02, 0.03, 0.04)
BODY = "m = 2, r = {0.5, 0.1, 0}, r_CM = {0.3, 0.1, -0.1}, I_11 = 0.02, I_22 = 0.03, I_33 = 0.04"


@settings(max_examples=6, deadline=None, derandomize=True, database=None)
@given(st.lists(st.sampled_from(sorted(MOVING)), min_size=1, max_size=3), st.booleans())
def test_random_chains_keep_their_energy(kinds: list[str], reverse: bool) -> None:
    lines, connections = [], ["connect(world.frame_b, joint1.frame_a);"]
    for k, kind in enumerate(kinds, 1):
        lines.append(f"  {kind} joint{k}({MOVING[kind]});\n  BodyShape body{k}({BODY});\n")
        connections.append(f"connect(joint{k}.frame_b, body{k}.frame_a);")
    for k, j in pairwise(range(1, len(kinds) + 1)):
        connections.append(f"connect(body{k}.frame_b, joint{j}.frame_a);")
    # a spring to the world loads all joints
    lines.append("  Spring spring(c = 50, s_unstretched = 0.2);\n  Fixed anchor(r = {1, 1, 1});\n")
    ends = ("frame_b", "frame_a") if reverse else ("frame_a", "frame_b")
    connections.append(f"connect(anchor.frame_b, spring.{ends[0]});")
    connections.append(f"connect(body{len(kinds)}.frame_b, spring.{ends[1]});")
    text = "".join(lines) + "equation\n" + "\n".join(connections)
    result = run(text, 0.5, tolerance=1e-9)
    total = 25 * (values(result, "spring.length") - 0.2) ** 2
    moving = [energy(result, f"body{k}.body", 2, R_CM, INERTIA) for k in range(1, len(kinds) + 1)]
    total = total + np.sum(moving, axis=0)
    assert total == pytest.approx(total[0], abs=3e-6 * max(10, np.ptp(moving[0])))
    assert np.ptp(moving[0]) > 0.01


@pytest.mark.parametrize("kind", [k for k in MOVING if k != "FreeMotion"])
def test_joints_work_in_both_directions(kind: str) -> None:
    # The frames may be exchanged: the tree of orientations then goes from frame_b to frame_a.
    lines = f"  {kind} joint({MOVING[kind]});\n  BodyShape body({BODY});\nequation\n"
    result = run(
        lines + "  connect(world.frame_b, joint.frame_b);\n  connect(joint.frame_a, body.frame_a);",
        0.5,
    )
    total = energy(result, "body.body", 2, R_CM, INERTIA)
    assert total == pytest.approx(total[0], abs=1e-5)
    assert np.ptp(vector(result, "body.frame_b.r_0")) > 0.1


def test_fixed_rotations_in_both_directions() -> None:
    result = run(
        "  FixedRotation a(r = {1, 2, 3}, n = {1, 1, 0}, angle = 0.7);\n"
        "  FixedRotation b(rotationType = RotationTypes.TwoAxesVectors, n_x = {0, 1, 0},"
        " n_y = {0, 0, 1});\n"
        "  FixedRotation c(rotationType = RotationTypes.PlanarRotationSequence,"
        " sequence = {3, 1, 2}, angles = {0.1, 0.2, 0.3});\n"
        "  FixedRotation back(r = {1, 2, 3}, n = {1, 1, 0}, angle = 0.7);\n"
        f"  BodyShape body({BODY});\nequation\n"
        "  connect(world.frame_b, a.frame_a);\n  connect(a.frame_b, b.frame_a);\n"
        "  connect(b.frame_b, c.frame_a);\n  connect(c.frame_b, body.frame_a);\n"
        "  connect(a.frame_b, back.frame_b);\n"
    )
    assert vector(result, "back.frame_a.r_0") == pytest.approx(0, abs=1e-12)
    # the world carries the weight
    assert vector(result, "world.frame_b.f")[:, 0] == pytest.approx([0, 0, -2 * G], abs=1e-9)
    centre = vector(result, "body.body.r_gravity")[:, 0]
    moment = np.cross(centre, [0, 0, -2 * G])
    assert vector(result, "world.frame_b.t")[:, 0] == pytest.approx(moment, abs=1e-9)


CLOSED = {
    "SphericalConstraint": "Universal",
    "UniversalConstraint(n_a = {1, 0, 0}, n_b = {0, 1, 0})": "Spherical",
    "RevoluteConstraint(n = {0, 1, 0})": "Universal Universal",
    "PrismaticConstraint": "Universal Universal",
}


@pytest.mark.parametrize("constraint", CLOSED)
def test_constraints_close_loops_without_work(constraint: str) -> None:
    # base - U - link - joints of the loop - link - constraint - base
    inner = {
        "Universal": "  Universal j1(stateSelect = StateSelect.default);\n",
        "Spherical": "  Spherical j1(enforceStates = true, useQuaternions = false);\n",
        "Universal Universal": "  Universal j1(stateSelect = StateSelect.default);\n"
        "  Universal j2(n_a = {0, 0, 1}, n_b = {1, 0, 0}, stateSelect = StateSelect.default);\n",
    }[CLOSED[constraint]]
    two = CLOSED[constraint] == "Universal Universal"
    name, _, arguments = constraint.partition("(")
    result = run(
        "  Universal j0(phi_a(fixed = true), w_a(start = 1.5, fixed = true));\n"
        + inner
        + f"  {name} closing{'(' + arguments if arguments else ''};\n"
        + f"  BodyShape first({BODY.replace('0.5, 0.1, 0', '0.5, 0, 0.2')});\n"
        + f"  BodyShape second({BODY.replace('0.5, 0.1, 0', '0.1, 0.4, 0')});\n"
        + "  FixedTranslation middle(r = {0.1, 0.1, 0.2}), base(r = {0.7, 0.5, 0.4});\n"
        + "equation\n  connect(world.frame_b, j0.frame_a, base.frame_a);\n"
        + "  connect(j0.frame_b, first.frame_a);\n  connect(first.frame_b, j1.frame_a);\n"
        + (
            "  connect(j1.frame_b, middle.frame_a);\n  connect(middle.frame_b, j2.frame_a);\n"
            "  connect(j2.frame_b, second.frame_a);\n"
            if two
            else "  connect(j1.frame_b, middle.frame_a);\n"
            "  connect(middle.frame_b, second.frame_a);\n"
        )
        + "  connect(second.frame_b, closing.frame_b);\n"
        + "  connect(base.frame_b, closing.frame_a);\n",
        0.3,
    )
    each = [energy(result, f"{b}.body", 2, R_CM, INERTIA) for b in ("first", "second")]
    total = np.sum(each, axis=0)
    assert total == pytest.approx(total[0], abs=5e-5)
    assert np.ptp(each[0]) > 1e-3


ASSEMBLIES = {
    "JointUSR": "n1_a = {0, 0, 1}, n_b = {0, 1, 0.2}, rRod1_ia = {0.5, 0.1, 0.3},"
    " rRod2_ib = {-0.4, 0, 0.1}, phi_guess = 0.1",
    "JointUSP": "n1_a = {0, 0, 1}, n_b = {-1, 0.1, 0}, rRod1_ia = {0.5, 0.1, 0.3},"
    " rRod2_ib = {-0.2, 0, 0.1}, s_guess = 0.1",
    "JointSSR": "rod1Length = 0.6, rod1Mass = 0.5, n_b = {0, 1, 0.2}, rRod2_ib = {-0.4, 0, 0.1},"
    " phi_guess = 0.1",
    "JointSSP": "rod1Length = 0.6, rod1Mass = 0.5, n_b = {-1, 0.1, 0}, rRod2_ib = {-0.2, 0, 0.1},"
    " s_guess = 0.1",
    "JointRRR": "n_a = {0, 1, 0}, n_b = {0, 1, 0}, rRod1_ia = {0.5, 0, 0.3},"
    " rRod2_ib = {-0.4, 0, 0.1}, phi_guess = 0.1",
    "JointRRP": "n_a = {0, 1, 0}, n_b = {-1, 0, 0}, rRod1_ia = {0.5, 0, 0.3},"
    " rRod2_ib = {-0.2, 0, 0.1}, s_guess = 0.1",
}


@pytest.mark.parametrize("kind", ASSEMBLIES)
def test_assemblies_close_loops_without_work(kind: str) -> None:
    planar = kind.startswith("JointRR")
    rod = kind[5] in "UR"
    y = 0.0 if planar else 0.2
    text = (
        "  Revolute crank(n = {0, 1, 0}, phi(fixed = true), w(start = 2, fixed = true));\n"
        f"  BodyShape arm({BODY.replace('0.5, 0.1, 0', f'0.1, {y}, 0.2')});\n"
        f"  {kind} joint({ASSEMBLIES[kind]});\n  FixedTranslation base(r = {{1, 0, 0.3}});\n"
        f"  BodyShape last({BODY}), middle(m = 0.3);\n"
        + (f"  BodyShape coupler({BODY});\n" if rod else "")
        + "equation\n  connect(world.frame_b, crank.frame_a, base.frame_a);\n"
        "  connect(crank.frame_b, arm.frame_a);\n  connect(arm.frame_b, joint.frame_a);\n"
        "  connect(base.frame_b, joint.frame_b);\n  connect(joint.frame_ib, last.frame_a);\n"
        "  connect(joint.frame_im, middle.frame_a);\n"
        + ("  connect(joint.frame_ia, coupler.frame_a);\n" if rod else "")
    )
    result = run(text, 0.3)
    names = ["arm", "last", *(["coupler"] if rod else [])]
    each = [energy(result, f"{b}.body", 2, R_CM, INERTIA) for b in names]
    each.append(energy(result, "middle.body", 0.3, (0, 0, 0), 1e-3))
    if not rod:
        t = np.asarray(result.times)
        r = (
            vector(result, "joint.rod1.frame_a.r_0") + vector(result, "joint.rod1.frame_b.r_0")
        ) / 2
        v = vector(result, "joint.rod1.v_CM_0")
        each.append(0.5 * (v * v).sum(axis=0) / 2 + 0.5 * G * r[2] + 0 * t)
    total = np.sum(each, axis=0)
    assert total == pytest.approx(total[0], abs=1e-5)
    assert np.ptp(each[0]) > 1e-2
    ends = [vector(result, f"joint.{f}.r_0") for f in ("frame_a", "frame_im")]
    length = np.linalg.norm(ends[1] - ends[0], axis=0)
    assert length == pytest.approx(length[0], abs=1e-9)


def test_a_rod_with_mass_swings_as_a_pendulum_with_its_mass_in_the_middle() -> None:
    result = run(
        "  SphericalSpherical rod(rodLength = 1, m = 2);\n"
        "  PointMass tip(m = 1, r_0(start = {0.6, 0, -0.8}), v_0(start = {0, 0, 0}));\n"
        "initial equation\n  tip.r_0[1:2] = {0.6, 0};\n  tip.v_0[1:2] = {0, 0};\n"
        "equation\n  connect(world.frame_b, rod.frame_a);\n  connect(rod.frame_b, tip.frame_a);\n",
        1.0,
    )
    r, v = vector(result, "tip.r_0"), vector(result, "tip.v_0")
    total = (1 + 2 / 4) * (v * v).sum(axis=0) / 2 + (1 + 2 / 2) * G * r[2]
    assert total == pytest.approx(total[0], abs=1e-5)
    assert np.linalg.norm(r, axis=0) == pytest.approx(1, abs=1e-9)
    assert np.ptp(r[2]) > 0.1


def test_the_length_of_a_rod_can_be_the_distance_at_the_start() -> None:
    result = run(
        "  Revolute joint(phi(start = 0.3, fixed = true), w(fixed = true), n = {0, 1, 0});\n"
        "  BodyShape arm(r = {0.5, 0, 0}, r_CM = {0.25, 0, 0});\n"
        "  Prismatic slider(n = {0, 0, 1}, s(start = -0.4, fixed = true));\n"
        "  BodyShape load;\n  SphericalSpherical rod(computeRodLength = true);\n"
        "equation\n  connect(world.frame_b, joint.frame_a, slider.frame_a);\n"
        "  connect(joint.frame_b, arm.frame_a);\n  connect(slider.frame_b, load.frame_a);\n"
        "  connect(arm.frame_b, rod.frame_a);\n  connect(load.frame_b, rod.frame_b);\n",
    )
    expected = np.hypot(0.5 * np.cos(0.3), -0.4 + 0.5 * np.sin(0.3))
    assert values(result, "rod.length") == pytest.approx(expected, abs=1e-6)
    assert values(result, "joint.phi")[0] == pytest.approx(0.3)
    assert np.ptp(values(result, "joint.phi")) > 0.1
