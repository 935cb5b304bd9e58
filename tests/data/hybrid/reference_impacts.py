"""Impacts of bodies that are tied to others by joints, in minimal coordinates."""

from __future__ import annotations

from typing import Any

import numpy as np
from integrate_modes import Array, Guard, Mode, impact, impact_with_constraints, integrate

GRAVITY = 9.81


def agree(a: Any, b: Any) -> None:
    """Two derivations of the same numbers must give the same."""
    np.testing.assert_allclose(a, b, rtol=1e-10, atol=1e-11)


def ball_on_lever() -> dict[str, Any]:
    """A ball drops on one end of a hinged lever that carries a mass at its other end.

    The lever is a massless bar along the direction (cos phi, sin phi), hinged at the origin, with
    the mass M at distance b on the right. The ball m falls freely and meets the bar without
    friction; the gap is its distance to the bar, y cos phi - x sin phi.
    """
    m, big, b, a, e = 0.5, 2.0, 0.6, 0.9, 0.7
    # The hinge of the lever takes no torque: J w changes by the impulse times its arm.
    inertia = big * b * b

    def fall(_: float, z: Array) -> Array:
        return np.array(
            [z[3], z[4], z[5], 0, -GRAVITY, -big * GRAVITY * b * np.cos(z[2]) / inertia]
        )

    def gap(_: float, z: Array) -> float:
        return float(z[1] * np.cos(z[2]) - z[0] * np.sin(z[2]))

    def gradient(z: Array) -> Array:
        s, c = np.sin(z[2]), np.cos(z[2])
        return np.array([-s, c, -z[1] * s - z[0] * c])

    def hit(_: float, z: Array) -> tuple[str, Array, dict[str, Any]]:
        g = gradient(z)
        after, impulse = impact(np.diag([m, m, inertia]), g, z[3:], e)

        # Angular momentum of everything about the hinge is what it was; so is the momentum of the
        # ball along the bar.
        def momentum(v: Array) -> float:
            return float(m * (z[0] * v[1] - z[1] * v[0]) + inertia * v[2])

        agree(momentum(after), momentum(z[3:]))
        agree(after[:2] @ [np.cos(z[2]), np.sin(z[2])], z[3:5] @ [np.cos(z[2]), np.sin(z[2])])
        agree(g @ after, -e * (g @ z[3:]))
        # The same with the mass M in Cartesian coordinates, tied to the hinge by a rod.
        u = np.array([np.cos(z[2]), np.sin(z[2])])
        v = np.array([z[3], z[4], -b * z[5] * u[1], b * z[5] * u[0]])
        rod = np.array([[0, 0, u[0], u[1]]])
        # phi follows from M's position: dphi = (-sin, cos) . dr / b
        wide = np.array([g[0], g[1], -u[1] * g[2] / b, u[0] * g[2] / b])
        full, tension, again = impact_with_constraints(np.diag([m, m, big, big]), rod, wide, v, e)
        agree(full, [after[0], after[1], -b * after[2] * u[1], b * after[2] * u[0]])
        agree(again, impulse)
        agree(tension, [0.0])
        return "fall", np.concatenate([z[:3], after]), {
            "impulse": impulse, "arm": float(z[0] * u[0] + z[1] * u[1])
        }  # fmt: skip

    start = [-a, 0.35, 0.3, 0.0, 0.0, 0.0]
    times = np.linspace(0, 0.8, 41)
    modes = {"fall": Mode(fall, [Guard(gap, -1, hit)])}
    values, events = integrate(modes, "fall", start, times, 0.005)
    return {
        "parameters": {"m": m, "M": big, "b": b, "e": e, "g": GRAVITY},
        "variables": ["x", "y", "phi", "vx", "vy", "w"],
        "start": start,
        "events": events,
        "times": times.tolist(),
        "values": values.tolist(),
    }


def ball_on_lever_level() -> dict[str, Any]:
    """The same in a horizontal plane (no gravity), the lever at rest at phi = 0: closed form."""
    m, big, a, b, e, height, speed = 0.5, 2.0, 0.9, 0.6, 0.7, 1.0, 4.0
    inertia = big * b * b
    # m (v+ - v-) = P; J w+ = P a (left end); v+ + a w+ = -e v-
    impulse = (1 + e) * speed / (1 / m + a * a / inertia)
    after, w = -speed + impulse / m, impulse * a / inertia
    agree(after + a * w, e * speed)
    agree(m * (-a) * after + inertia * w, m * (-a) * -speed)
    return {
        "parameters": {"m": m, "M": big, "a": a, "b": b, "e": e, "y0": height, "vy0": -speed},
        "time": height / speed,
        "impulse": impulse,
        "ball_before": -speed,
        "ball_after": after,
        "lever_after": w,
        "mass_after": b * w,
        "energy_before": m * speed**2 / 2,
        "energy_after": m * after**2 / 2 + inertia * w * w / 2,
    }


def double_pendulum(relative: bool) -> dict[str, Any]:
    """Two point masses on massless rods; the second rod meets a stop.

    Absolute angles from the hanging position. Relative stop: phi2 - phi1 <= limit; absolute stop:
    phi2 <= limit.
    """
    m1, m2, l1, l2, e = 1.0, 0.8, 1.0, 0.7, 0.6
    limit = 0.5 if relative else 0.4
    slope = np.array([1.0, -1.0] if relative else [0.0, -1.0])  # of the gap limit - angle

    def mass(z: Array) -> Array:
        c = np.cos(z[0] - z[1])
        return np.array([[(m1 + m2) * l1 * l1, m2 * l1 * l2 * c], [m2 * l1 * l2 * c, m2 * l2 * l2]])

    def swing(_: float, z: Array) -> Array:
        s = m2 * l1 * l2 * np.sin(z[0] - z[1])
        force = np.array([
            -s * z[3] ** 2 - (m1 + m2) * GRAVITY * l1 * np.sin(z[0]),
            s * z[2] ** 2 - m2 * GRAVITY * l2 * np.sin(z[1]),
        ])  # fmt: skip
        return np.concatenate([z[2:], np.linalg.solve(mass(z), force)])

    def gap(_: float, z: Array) -> float:
        return float(limit - (z[1] - z[0] if relative else z[1]))

    def hit(_: float, z: Array) -> tuple[str, Array, dict[str, Any]]:
        after, impulse = impact(mass(z), slope, z[2:], e)
        # Once more with both masses in Cartesian coordinates and two rods.
        s1, c1, s2, c2 = np.sin(z[0]), np.cos(z[0]), np.sin(z[1]), np.cos(z[1])
        to_cartesian = np.array(
            [[l1 * c1, 0], [l1 * s1, 0], [l1 * c1, l2 * c2], [l1 * s1, l2 * s2]]
        )
        rods = np.array([[s1, -c1, 0, 0], [-s2, c2, s2, -c2]])
        w1 = np.array([c1, s1, 0, 0]) / l1
        w2 = np.array([-c2, -s2, c2, s2]) / l2
        full, tension, again = impact_with_constraints(
            np.diag([m1, m1, m2, m2]), rods, slope[0] * w1 + slope[1] * w2, to_cartesian @ z[2:], e
        )
        agree(full, to_cartesian @ after)
        agree(again, impulse)
        return "swing", np.concatenate([z[:2], after]), {
            "impulse": impulse, "rod_impulses": tension.tolist(),
            "velocities_after": full.tolist(),
        }  # fmt: skip

    start = [-0.6, -1.4, 0.0, 0.0] if relative else [0.3, -1.0, 0.0, 0.0]
    times = np.linspace(0, 2, 41)
    modes = {"swing": Mode(swing, [Guard(gap, -1, hit)])}
    values, events = integrate(modes, "swing", start, times, 0.005, 60)

    def energy(z: Array) -> float:
        potential = -(m1 + m2) * l1 * np.cos(z[0]) - m2 * l2 * np.cos(z[1])
        return float(z[2:] @ mass(z) @ z[2:] / 2 + GRAVITY * potential)

    for event in events:
        before, after = (energy(np.array(event[k])) for k in ("before", "after"))
        # The energy that an impact takes: (1 - e^2) (G v-)^2 / (2 G M^-1 G^T).
        z = np.array(event["before"])
        rate = float(slope @ z[2:])
        agree(before - after, (1 - e * e) * rate**2 / (2 * slope @ np.linalg.solve(mass(z), slope)))
        event["energy_before"], event["energy_after"] = before, after
    return {
        "parameters": {
            "m1": m1, "m2": m2, "l1": l1, "l2": l2, "e": e, "limit": limit, "g": GRAVITY,
            "stop": "phi2 - phi1 <= limit" if relative else "phi2 <= limit",
        },
        "variables": ["phi1", "phi2", "w1", "w2"],
        "start": start,
        "events": events,
        "times": times.tolist(),
        "values": values.tolist(),
    }  # fmt: skip


def pendulum_and_wall() -> dict[str, Any]:
    """A pendulum, written in x and y with a rod, meets a wall at x = wall.

    x = l sin(phi), y = -l cos(phi). The wall pushes along x; the rod takes the rest: both velocity
    components change by the factor -e.
    """
    m, length, e, wall = 1.0, 1.0, 0.8, 0.3

    def swing(_: float, z: Array) -> Array:
        return np.array([z[1], -GRAVITY / length * np.sin(z[0])])

    def hit(_: float, z: Array) -> tuple[str, Array, dict[str, Any]]:
        s, c = np.sin(z[0]), np.cos(z[0])
        v = length * z[1] * np.array([c, s])
        full, tension, push = impact_with_constraints(
            m * np.eye(2), np.array([[s, -c]]), np.array([-1.0, 0.0]), v, e
        )
        agree(full, -e * v)
        return "swing", np.array([z[0], -e * z[1]]), {
            "position": [length * s, -length * c], "velocity_before": v.tolist(),
            "velocity_after": full.tolist(), "wall_impulse": push,
            "rod_impulse": float(tension[0]),
        }  # fmt: skip

    times = np.linspace(0, 5, 51)
    start = [-1.0, 0.0]
    gap = Guard(lambda _, z: wall - length * np.sin(z[0]), -1, hit)
    values, events = integrate({"swing": Mode(swing, [gap])}, "swing", start, times, 0.005, 60)
    phi, w = values.T
    cartesian = np.array([
        length * np.sin(phi), -length * np.cos(phi),
        length * w * np.cos(phi), length * w * np.sin(phi),
    ]).T  # fmt: skip
    return {
        "parameters": {"m": m, "l": length, "e": e, "wall": wall, "g": GRAVITY},
        "convention": "wall impulse acts along -x; rod impulse acts along (x, y)/l, outwards",
        "start": start,
        "variables": ["phi", "w"],
        "events": events,
        "times": times.tolist(),
        "values": values.tolist(),
        "cartesian_variables": ["x", "y", "vx", "vy"],
        "cartesian": cartesian.tolist(),
    }


def chain_on_wall() -> dict[str, Any]:
    """Two masses on a line, joined by a rigid rod, or by a lever of ratio i: closed form.

    v2 = i v1. The first mass meets a wall with speed v. m1 dv1 = -P - i R, m2 dv2 = R: the wall
    feels the mass m1 + i^2 m2, and the joint passes R = m2 i (1 + e) v on, against the motion.
    """
    rows = []
    for ratio in (1.0, -2.0, 0.5):
        m1, m2, e, speed, distance = 1.5, 0.7, 0.65, 3.0, 2.0
        full, joint, push = impact_with_constraints(
            np.diag([m1, m2]), np.array([[-ratio, 1.0]]), np.array([-1.0, 0.0]),
            np.array([speed, ratio * speed]), e,
        )  # fmt: skip
        agree(push, (m1 + ratio**2 * m2) * (1 + e) * speed)
        agree(joint, [-m2 * ratio * (1 + e) * speed])
        rows.append({
            "m1": m1, "m2": m2, "ratio": ratio, "e": e, "speed": speed, "distance": distance,
            "time": distance / speed, "velocities_after": full.tolist(), "wall_impulse": push,
            "joint_impulse_on_m2": float(joint[0]),
        })  # fmt: skip
    return {"cases": rows}


def falling_dumbbell() -> dict[str, Any]:
    """Two masses joined by a rod fall, turning, on a smooth floor; the lower one bounces."""
    m1, m2, length, e = 1.0, 2.0, 0.8, 0.75
    r1, r2 = length * m2 / (m1 + m2), length * m1 / (m1 + m2)  # from the centre of mass
    total, inertia = m1 + m2, m1 * m2 / (m1 + m2) * length**2
    matrix = np.diag([total, total, inertia])

    def fall(_: float, z: Array) -> Array:
        return np.array([z[3], z[4], z[5], 0, -GRAVITY, 0])

    def hit(mass_1: bool) -> Guard:
        arm = -r1 if mass_1 else r2

        def action(_: float, z: Array) -> tuple[str, Array, dict[str, Any]]:
            after, impulse = impact(matrix, np.array([0, 1, arm * np.cos(z[2])]), z[3:], e)
            c, s = np.cos(z[2]), np.sin(z[2])

            def spread(v: Array) -> Array:
                return np.array([
                    v[0] + r1 * v[2] * s, v[1] - r1 * v[2] * c,
                    v[0] - r2 * v[2] * s, v[1] + r2 * v[2] * c,
                ])  # fmt: skip

            at = np.zeros(4)
            at[1 if mass_1 else 3] = 1.0
            full, rod, again = impact_with_constraints(
                np.diag([m1, m1, m2, m2]), np.array([[-c, -s, c, s]]), at, spread(z[3:]), e
            )
            agree(full, spread(after))
            agree(again, impulse)
            return "fall", np.concatenate([z[:3], after]), {
                "mass": 1 if mass_1 else 2, "impulse": impulse, "rod_impulse": float(rod[0]),
                "velocities_before": spread(z[3:]).tolist(), "velocities_after": full.tolist(),
            }  # fmt: skip

        return Guard(lambda _, z: z[1] + arm * np.sin(z[2]), -1, action)

    start = [0.0, 1.5, 0.4, 0.5, 0.0, -1.0]
    times = np.linspace(0, 2.0, 41)
    modes = {"fall": Mode(fall, [hit(True), hit(False)])}
    values, events = integrate(modes, "fall", start, times, 0.005, 60)
    return {
        "parameters": {"m1": m1, "m2": m2, "l": length, "e": e, "g": GRAVITY},
        "convention": "x, y of the centre of mass; phi of the line from mass 1 to mass 2; "
        "velocities are vx1, vy1, vx2, vy2; the rod impulse on mass 2 is along the line, "
        "away from mass 1",
        "variables": ["x", "y", "phi", "vx", "vy", "w"],
        "start": start,
        "events": events,
        "times": times.tolist(),
        "values": values.tolist(),
    }
