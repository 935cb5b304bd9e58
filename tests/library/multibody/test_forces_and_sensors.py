"""Forces and torques in all frames, line forces, and what sensors show."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.multibody.bodies import G, energy, matrix, run, values, vector

FREE = "gravityType = GravityTypes.NoGravity"
F, T = np.array([1.0, 2.0, 3.0]), np.array([-0.3, 0.2, 0.1])
#: A body held in a known orientation, frames at both ends.
HELD = (
    "  FixedRotation a(r = {0.1, 0.2, 0.3}, n = {1, 2, 2}, angle = 0.8);\n"
    "  FixedRotation b(r = {1, -1, 0.5}, n = {0, 1, 2}, angle = -0.5);\n"
    "  FixedRotation c(n = {1, 0, 2}, angle = 1.2);\n"
    "  Fixed base;\n"
)
HOLD = (
    "  connect(world.frame_b, a.frame_a);\n  connect(base.frame_b, b.frame_a);\n"
    "  connect(world.frame_b, c.frame_a);\n"
)
SIGNALS = {
    "Force": "force = {1, 2, 3}",
    "Torque": "torque = {-0.3, 0.2, 0.1}",
    "ForceAndTorque": "force = {1, 2, 3}",
}


@pytest.mark.parametrize("frame", ["world", "frame_a", "frame_b", "frame_resolve"])
@pytest.mark.parametrize("kind", SIGNALS)
def test_forces_between_frames_act_and_react(kind: str, frame: str) -> None:
    resolve = "  connect(e.frame_resolve, c.frame_b);\n" if frame == "frame_resolve" else ""
    result = run(
        HELD + f"  {kind} e(resolveInFrame = ResolveInFrameAB.{frame});\nequation\n" + HOLD
        + "  connect(a.frame_b, e.frame_a);\n  connect(b.frame_b, e.frame_b);\n" + resolve
        + ("  e.force = {1, 2, 3};\n" if "Force" in kind else "")
        + ("  e.torque = {-0.3, 0.2, 0.1};\n" if "Torque" in kind else ""),
        world=FREE,
    )  # fmt: skip
    turned = {"world": None, "frame_a": "a", "frame_b": "b", "frame_resolve": "c"}[frame]
    R = np.eye(3) if turned is None else matrix(result, f"{turned}.frame_b.R.T")[:, :, 0].T
    force = R @ F if "Force" in kind else np.zeros(3)
    torque = R @ T if "Torque" in kind else np.zeros(3)
    # the fixed frames carry it; what they carry is seen from the world
    at = {name: vector(result, f"{name}.frame_b.r_0")[:, 0] for name in "ab"}
    carried = vector(result, "base.frame_b.f")[:, 0]
    assert carried == pytest.approx(force, abs=1e-12)
    assert vector(result, "base.frame_b.t")[:, 0] == pytest.approx(
        torque + np.cross(at["b"], force), abs=1e-12
    )
    assert vector(result, "world.frame_b.f")[:, 0] == pytest.approx(-force, abs=1e-12)
    assert vector(result, "world.frame_b.t")[:, 0] == pytest.approx(
        -torque - np.cross(at["b"], force), abs=1e-12
    )


@pytest.mark.parametrize("frame", ["world", "frame_b", "frame_resolve"])
@pytest.mark.parametrize("kind", ["WorldForce", "WorldTorque", "WorldForceAndTorque"])
def test_forces_from_the_world(kind: str, frame: str) -> None:
    resolve = "  connect(e.frame_resolve, c.frame_b);\n" if frame == "frame_resolve" else ""
    result = run(
        HELD + f"  {kind} e(resolveInFrame = ResolveInFrameB.{frame});\nequation\n" + HOLD
        + "  connect(b.frame_b, e.frame_b);\n" + resolve
        + ("  e.force = {1, 2, 3};\n" if "Force" in kind else "")
        + ("  e.torque = {-0.3, 0.2, 0.1};\n" if "Torque" in kind else ""),
        world=FREE,
    )  # fmt: skip
    turned = {"world": None, "frame_b": "b", "frame_resolve": "c"}[frame]
    R = np.eye(3) if turned is None else matrix(result, f"{turned}.frame_b.R.T")[:, :, 0].T
    force = R @ F if "Force" in kind else np.zeros(3)
    torque = R @ T if "Torque" in kind else np.zeros(3)
    arm = vector(result, "b.frame_b.r_0")[:, 0]
    assert vector(result, "base.frame_b.f")[:, 0] == pytest.approx(force, abs=1e-12)
    assert vector(result, "base.frame_b.t")[:, 0] == pytest.approx(
        torque + np.cross(arm, force), abs=1e-12
    )


def test_springs_and_dampers_between_free_masses() -> None:
    # two masses on a line: one oscillator of the reduced mass
    def masses(element: str) -> str:
        return (
            f"  PointMass m1(m = 2, r_0(each fixed = true), v_0(each fixed = true));\n"
            f"  PointMass m2(m = 3, r_0(start = {{0, 0.9, 1.2}}, each fixed = true),"
            f" v_0(each fixed = true));\n  {element};\nequation\n"
            "  connect(m1.frame_a, e.frame_a);\n  connect(m2.frame_a, e.frame_b);\n"
        )

    m = 6 / 5
    for element in (
        "SpringDamperParallel e(c = 40, d = 2, s_unstretched = 1)",
        "Spring e(c = 40, s_unstretched = 1);\n  Damper extra(d = 2)",
        "LineForceWithMass e;\n  mechanical.translational.SpringDamper one(c = 40, d = 2,"
        " s_rel0 = 1)",
    ):
        text = masses(element)
        if "extra" in element:
            text += "  connect(m1.frame_a, extra.frame_a);\n  connect(m2.frame_a, extra.frame_b);\n"
        if "one" in element:
            text += "  connect(e.flange_a, one.flange_a);\n  connect(e.flange_b, one.flange_b);\n"
        result = run(text, world=FREE)
        t = np.asarray(result.times)
        decay, root = 1 / m, np.sqrt(40 / m - (1 / m) ** 2)
        expected = 1 + 0.5 * np.exp(-decay * t) * (
            np.cos(root * t) + decay / root * np.sin(root * t)
        )
        assert values(result, "e.length") == pytest.approx(expected, abs=1e-6)
        centre = 2 * vector(result, "m1.r_0") + 3 * vector(result, "m2.r_0")
        assert centre == pytest.approx(np.outer([0, 2.7, 3.6], np.ones_like(t)), abs=1e-7)
    result = run(masses("SpringDamperSeries e(c = 40, d = 5, s_unstretched = 1)"), world=FREE)
    length, damper = values(result, "e.s"), values(result, "e.s_damper")
    force = 40 * (length - 1 - damper)
    assert values(result, "e.f") == pytest.approx(force, abs=1e-6)
    assert values(result, "e.lossPower") == pytest.approx(force**2 / 5, abs=1e-5)


def test_masses_on_a_line_are_carried_by_its_ends() -> None:
    result = run(
        "  Fixed a(r = {0, 0, 0}), b(r = {0.6, 0, 0.8}), c(r = {0, 1, 0}), d(r = {2, 1, 0});\n"
        "  LineForceWithMass one(m = 2, lengthFraction = 0.25);\n"
        "  LineForceWithTwoMasses two(m_a = 1, m_b = 3, L_a = 0.5, L_b = 0.2);\nequation\n"
        "  connect(a.frame_b, one.frame_a);\n  connect(b.frame_b, one.frame_b);\n"
        "  connect(c.frame_b, two.frame_a);\n  connect(d.frame_b, two.frame_b);\n"
    )
    assert vector(result, "a.frame_b.f")[2, 0] == pytest.approx(-1.5 * G)
    assert vector(result, "b.frame_b.f")[2, 0] == pytest.approx(-0.5 * G)
    assert vector(result, "c.frame_b.f")[2, 0] == pytest.approx(-(0.75 * 1 + 0.1 * 3) * G)
    assert vector(result, "d.frame_b.f")[2, 0] == pytest.approx(-(0.25 * 1 + 0.9 * 3) * G)


def test_a_spring_without_bodies_at_its_ends() -> None:
    result = run(
        "  Fixed a, b(r = {3, 0, 0});\n  Spring s1(c = 10);\n"
        "  Spring s2(c = 20, fixedRotationAtFrame_a = true);\n"
        "equation\n  connect(a.frame_b, s1.frame_a);\n  connect(s1.frame_b, s2.frame_a);\n"
        "  connect(s2.frame_b, b.frame_b);\n"
    )
    assert values(result, "s1.length") == pytest.approx(2, abs=1e-9)
    assert values(result, "s2.f") == pytest.approx(20, abs=1e-8)


ARM = (
    "  Revolute joint(n = {0, 0, 1}, useAxisFlange = true);\n"
    "  mechanical.rotational.Speed drive(exact = true);\n"
    "  FixedRotation arm(r = {2, 0, 0}, n = {1, 0, 0}, angle = 0.5);\n"
    "  FixedRotation other(n = {0, 0, 1}, angle = 0.4);\n"
    "  Body body(m = 1, I_11 = 0, I_22 = 0, I_33 = 0);\n"
)
MOVE = (
    "  drive.w_ref = 3;\n  connect(drive.flange, joint.axis);\n"
    "  connect(world.frame_b, joint.frame_a, other.frame_a);\n"
    "  connect(joint.frame_b, arm.frame_a);\n"
)


@pytest.mark.parametrize("frame", ["world", "frame_a", "frame_resolve"])
def test_absolute_sensors_on_a_turning_arm(frame: str) -> None:
    names = ["position", "velocity", "rate", "all"]
    resolve = f"resolveInFrame = ResolveInFrameA.{frame}"
    text = (
        ARM + f"  AbsolutePosition position({resolve});\n  AbsoluteVelocity velocity({resolve});\n"
        f"  AbsoluteAngularVelocity rate({resolve});\n"
        f"  AbsoluteSensor all({resolve}, get_r = true, get_v = true, get_a = true, get_w = true,"
        " get_z = true, get_angles = true, sequence = {3, 1, 2});\n"
        "  AbsoluteAngles angles(sequence = {3, 1, 2});\n"
        f"  TransformAbsoluteVector transform(frame_r_in = ResolveInFrameA.frame_a,"
        f" frame_r_out = ResolveInFrameA.{frame});\n"
        "equation\n"
        + MOVE
        + "  connect(arm.frame_b, body.frame_a, angles.frame_a, transform.frame_a);\n"
        "  transform.r_in = {1, 2, 3};\n"
        + "".join(f"  connect(arm.frame_b, {n}.frame_a);\n" for n in names)
    )
    if frame == "frame_resolve":
        text += "".join(
            f"  connect(other.frame_b, {n}.frame_resolve);\n" for n in [*names, "transform"]
        )
    result = run(text)
    t = np.asarray(result.times)
    phi, one = 3 * t, np.ones_like(t)
    r = np.array([2 * np.cos(phi), 2 * np.sin(phi), 0 * t])
    v = np.array([-6 * np.sin(phi), 6 * np.cos(phi), 0 * t])
    T = matrix(result, "arm.frame_b.R.T")
    own = T
    if frame == "world":
        T = np.repeat(np.eye(3)[:, :, None], len(t), axis=2)
    if frame == "frame_resolve":
        T = matrix(result, "other.frame_b.R.T")
    expected = {
        "position.r": r, "velocity.v": v, "rate.w": np.array([0 * t, 0 * t, 3 * one]),
        "all.r": r, "all.v": v, "all.a": -9 * r, "all.w": np.array([0 * t, 0 * t, 3 * one]),
        "all.z": 0 * r,
    }  # fmt: skip
    for name, vectors in expected.items():
        seen = np.einsum("ijt,jt->it", T, vectors)
        assert vector(result, name) == pytest.approx(seen, abs=1e-5), name
    for name in ("angles", "all"):
        assert vector(result, f"{name}.angles") == pytest.approx(
            np.array([phi, 0.5 * one, 0 * t]), abs=1e-6
        )
    turned = np.einsum("ijt,kjt,k->it", T, own.transpose(1, 0, 2).transpose(1, 0, 2), [1, 2, 3])
    assert vector(result, "transform.r_out") == pytest.approx(turned, abs=1e-9)


@pytest.mark.parametrize("frame", ["world", "frame_a", "frame_b", "frame_resolve"])
def test_relative_sensors_between_two_arms(frame: str) -> None:
    names = ["position", "velocity", "rate", "all"]
    resolve = f"resolveInFrame = ResolveInFrameAB.{frame}"
    text = (
        ARM + f"  RelativePosition position({resolve});\n  RelativeVelocity velocity({resolve});\n"
        f"  RelativeAngularVelocity rate({resolve});\n"
        f"  RelativeSensor all({resolve}, get_r_rel = true, get_v_rel = true, get_a_rel = true,"
        " get_w_rel = true, get_z_rel = true, get_angles = true);\n"
        "  RelativeAngles angles;\n  Distance distance, none;\n"
        f"  TransformRelativeVector transform(frame_r_in = ResolveInFrameAB.frame_b,"
        f" frame_r_out = ResolveInFrameAB.{frame});\n"
        "equation\n"
        + MOVE
        + "  connect(arm.frame_b, body.frame_a, angles.frame_b, transform.frame_b,"
        " distance.frame_b, none.frame_a, none.frame_b);\n"
        "  connect(other.frame_b, angles.frame_a, transform.frame_a, distance.frame_a);\n"
        "  transform.r_in = {1, 2, 3};\n"
        + "".join(
            f"  connect(other.frame_b, {n}.frame_a);\n  connect(arm.frame_b, {n}.frame_b);\n"
            for n in names
        )
    )
    if frame == "frame_resolve":
        text += "".join(
            f"  connect(world.frame_b, {n}.frame_resolve);\n" for n in [*names, "transform"]
        )
    result = run(text)
    t = np.asarray(result.times)
    phi = 3 * t
    moving = matrix(result, "arm.frame_b.R.T")
    fixed = matrix(result, "other.frame_b.R.T")
    still = np.repeat(np.eye(3)[:, :, None], len(t), axis=2)
    T = {"world": still, "frame_a": fixed, "frame_b": moving, "frame_resolve": still}[frame]
    r = np.array([2 * np.cos(phi), 2 * np.sin(phi), 0 * t])
    w = np.array([0 * t, 0 * t, 3 + 0 * t])
    if frame == "frame_b":
        # it turns with the arm and sees no motion
        v, a = 0 * r, 0 * r
    else:
        v, a = np.cross(w.T, r.T).T, -9 * r
    for name, vectors in {
        "position.r_rel": r, "velocity.v_rel": v, "rate.w_rel": w, "all.r_rel": r, "all.v_rel": v,
        "all.a_rel": a, "all.w_rel": w, "all.z_rel": 0 * w,
    }.items():  # fmt: skip
        seen = np.einsum("ijt,jt->it", T, vectors)
        assert vector(result, name) == pytest.approx(seen, abs=1e-5), name
    assert values(result, "distance.distance") == pytest.approx(2, abs=1e-9)
    assert values(result, "none.distance") == pytest.approx(0, abs=1e-12)
    turned = np.einsum("ijt,kjt,k->it", T, moving, [1, 2, 3])
    assert vector(result, "transform.r_out") == pytest.approx(turned, abs=1e-9)
    angles = vector(result, "angles.angles")
    assert vector(result, "all.angles") == pytest.approx(angles, abs=1e-9)


@pytest.mark.parametrize("frame", ["world", "frame_a", "frame_resolve"])
def test_cut_sensors_and_power_in_a_pendulum(frame: str) -> None:
    resolve = f"resolveInFrame = ResolveInFrameA.{frame}"
    text = (
        "  Universal joint(n_a = {1, 0, 0}, phi_a(start = 0.4, fixed = true), w_a(fixed = true),"
        " phi_b(start = 0.5, fixed = true), w_b(start = 2, fixed = true));\n"
        f"  CutForce force({resolve});\n  CutTorque torque({resolve});\n"
        f"  CutForceAndTorque both({resolve});\n  Power power;\n"
        "  FixedRotation other(n = {0, 0, 1}, angle = 0.4);\n"
        "  Body body(m = 2, r_CM = {0.3, 0, -0.5}, I_11 = 0.1, I_22 = 0.2, I_33 = 0.3);\n"
        "  Real work(start = 0, fixed = true);\nequation\n  der(work) = power.power;\n"
        "  connect(world.frame_b, joint.frame_a, other.frame_a);\n"
        "  connect(joint.frame_b, force.frame_a);\n  connect(force.frame_b, torque.frame_a);\n"
        "  connect(torque.frame_b, both.frame_a);\n  connect(both.frame_b, power.frame_a);\n"
        "  connect(power.frame_b, body.frame_a);\n"
    )
    if frame == "frame_resolve":
        text += "".join(
            f"  connect(other.frame_b, {n}.frame_resolve);\n" for n in ("force", "torque", "both")
        )
    result = run(text)
    total = energy(result, "body", 2, (0.3, 0, -0.5), (0.1, 0.2, 0.3))
    assert total - total[0] == pytest.approx(values(result, "work"), abs=1e-5)
    own = matrix(result, "body.frame_a.R.T")
    T = {
        "world": own.transpose(1, 0, 2), "frame_a": None,
        "frame_resolve": np.einsum("ikt,jkt->ijt", matrix(result, "other.frame_b.R.T"), own),
    }[frame]  # fmt: skip
    for sensor, quantity, cut in (
        ("force", "force", "f"), ("torque", "torque", "t"), ("both", "force", "f"),
        ("both", "torque", "t"),
    ):  # fmt: skip
        on_body = vector(result, f"body.frame_a.{cut}")
        seen = on_body if T is None else np.einsum("ijt,jt->it", T, on_body)
        assert vector(result, f"{sensor}.{quantity}") == pytest.approx(seen, abs=1e-9)
    # force on the body: mass times acceleration of its centre less gravity
    assert np.ptp(vector(result, "body.frame_a.f")) > 1
