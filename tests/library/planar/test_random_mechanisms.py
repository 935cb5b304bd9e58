"""Random trees and loops of bodies, joints, rods and springs keep their energy."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.library.planar.mechanisms import Array, body_energy, run, values, vector

KINDS = ("Revolute", "Revolute", "Prismatic")


@dataclass
class Mechanism:
    """A mechanism and where its bodies are at the start."""

    text: list[str] = field(default_factory=list)
    ends: list[str] = field(default_factory=list)
    places: list[Array] = field(default_factory=lambda: [np.zeros(2)])
    angles: list[float] = field(default_factory=lambda: [0.0])
    arms: list[tuple[str, int, Array]] = field(default_factory=list)
    joints: list[tuple[str, str, str]] = field(default_factory=list)
    springs: list[tuple[str, str, dict[str, float]]] = field(default_factory=list)
    inertias: list[tuple[float, float]] = field(default_factory=list)

    def frame(self, k: int) -> str:
        """Return the frame of body k; 0 is the ground."""
        return f"body{k}.frame_a" if k else "ground.frame_a"

    def point(self, k: int, r: tuple[float, float]) -> tuple[str, Array]:
        """Return a new point of body k: its frame, and where it is."""
        name = f"arm{len(self.arms)}"
        self.arms.append((name, k, np.array(r)))
        self.text.append(f"  FixedTranslation {name}(r = {{{r[0]}, {r[1]}}});\n")
        self.ends.append(f"  connect({self.frame(k)}, {name}.frame_a);\n")
        return f"{name}.frame_b", self.places[k] + turned(self.angles[k], np.array(r))


def turned(angle: float, r: Array) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * r[0] - s * r[1], s * r[0] + c * r[1]])


COORDINATE = st.integers(-8, 8).map(lambda n: n / 10)
POINTS = st.tuples(COORDINATE, COORDINATE)


@st.composite
def mechanisms(draw: Any) -> Mechanism:
    made = Mechanism()
    n = draw(st.integers(1, 3))
    loop = draw(st.booleans()) and n > 1
    pinned = loop and n == 3 and draw(st.booleans())
    for k in range(1, n + 1):
        parent = k - 1 if loop else draw(st.integers(0, k - 1))
        kind = draw(st.sampled_from(KINDS)) if k < n and not pinned else "Revolute"
        start = draw(st.integers(-10, 10)) / 10
        speed = 0.0 if loop else draw(st.integers(-10, 10)) / 5
        mass, inertia = draw(st.integers(1, 5)), draw(st.integers(1, 5)) / 10
        here, place = made.point(parent, draw(POINTS))
        variable = "phi" if kind == "Revolute" else "s"
        rate = "w" if kind == "Revolute" else "v"
        fixed = "false" if (loop and k == n) or (pinned and k > 1) else "true"
        made.text.append(
            f"  {kind} joint{k}({variable}(start = {start}, fixed = {fixed}), "
            f"{rate}(start = {speed}, fixed = {fixed}));\n"
            f"  Body body{k}(m = {mass}, I = {inertia});\n"
        )
        made.inertias.append((mass, inertia))
        angle = made.angles[parent] + (start if kind == "Revolute" else 0)
        if kind == "Prismatic":
            place = place + turned(angle, np.array([start, 0]))
        r = (-draw(st.integers(2, 8)) / 10, draw(COORDINATE))
        made.angles.append(angle)
        made.places.append(place - turned(angle, np.array(r)))
        there, _ = made.point(k, r)
        made.joints.append((f"joint{k}", here, there))
        made.ends.append(f"  connect({here}, joint{k}.frame_a);\n")
        made.ends.append(f"  connect(joint{k}.frame_b, {there});\n")
    if pinned:
        # a hinge on the ground makes a four-bar linkage
        there, place = made.point(n, (draw(st.integers(2, 8)) / 10, draw(COORDINATE)))
        here, _ = made.point(0, (float(place[0]), float(place[1])))
        made.text.append("  Revolute pin;\n")
        made.ends.append(f"  connect({here}, pin.frame_a);\n  connect(pin.frame_b, {there});\n")
        made.joints.append(("pin", here, there))
    elif loop:
        # a rod from the ground to a point of the last body, square to the arm of its joint
        arm = made.arms[-1][2]
        across = np.array([-arm[1], arm[0]]) / np.hypot(*arm)
        there, place = made.point(n, (-arm[0], -arm[1]))
        ground = place + turned(made.angles[n], across + 0.2 * arm)
        here, _ = made.point(0, (float(ground[0]), float(ground[1])))
        made.text.append(f"  LengthConstraint rod(L = {float(np.hypot(*(ground - place)))!r});\n")
        made.ends.append(f"  connect({here}, rod.frame_a);\n  connect(rod.frame_b, {there});\n")
        made.joints.append(("rod", here, there))
    for k in range(draw(st.integers(0, 2))):
        one, two = draw(st.integers(0, n)), draw(st.integers(1, n))
        here, _ = made.point(one, draw(POINTS))
        there, _ = made.point(two, draw(POINTS))
        kind = draw(st.sampled_from(("Spring", "LineSpring")))
        c = {"c_x": 20.0, "c_y": 10.0, "c_phi": 5.0} if kind == "Spring" else {"c": 30.0}
        options = ", ".join(f"{name} = {value}" for name, value in c.items())
        made.text.append(f"  {kind} spring{k}({options});\n")
        made.ends.append(
            f"  connect({here}, spring{k}.frame_a);\n  connect(spring{k}.frame_b, {there});\n"
        )
        made.springs.append((kind, f"spring{k}", c))
    return made


def powers(result: Any, made: Mechanism) -> dict[str, tuple[Array, Array, Array]]:
    """Return the velocities in x and y and the angular velocity of all frames of arms."""
    zero = np.zeros(len(result.times))
    found = {}
    for name, k, r in made.arms:
        v = vector(result, f"body{k}.v") if k else np.array([zero, zero])
        w = values(result, f"body{k}.w") if k else zero
        phi = values(result, f"body{k}.phi") if k else zero
        lever = turned(phi, r)  # type: ignore[arg-type]
        found[f"{name}.frame_a"] = (v[0], v[1], w)
        found[f"{name}.frame_b"] = (v[0] - w * lever[1], v[1] + w * lever[0], w)
    return found


def power(result: Any, frame: str, motion: tuple[Array, Array, Array]) -> Array:
    total: Array = sum(
        values(result, f"{frame}.{name}") * part
        for name, part in zip(("fx", "fy", "t"), motion, strict=True)
    )
    return total


@settings(
    max_examples=20,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
)
@given(mechanisms())
def test_energy_stays_and_ideal_parts_pass_power_on(made: Mechanism) -> None:
    text = "  Fixed ground;\n" + "".join(made.text) + "equation\n" + "".join(made.ends)
    result = run(text, stop_time=1, tolerance=1e-9, points=101)
    energy = sum(body_energy(result, f"body{k + 1}", *i) for k, i in enumerate(made.inertias))
    for kind, name, c in made.springs:
        if kind == "LineSpring":
            energy = energy + c["c"] / 2 * values(result, f"{name}.length") ** 2
        else:
            energy = energy + c["c_x"] / 2 * values(result, f"{name}.s_relx") ** 2
            energy = energy + c["c_y"] / 2 * values(result, f"{name}.s_rely") ** 2
            energy = energy + c["c_phi"] / 2 * values(result, f"{name}.phi_rel") ** 2
    assert isinstance(energy, np.ndarray)
    assert np.ptp(energy) < 1e-5 * max(1, np.abs(energy).max()), text
    motions = powers(result, made)
    for name, _, _ in made.arms:
        into = [
            power(result, f"{name}.{end}", motions[f"{name}.{end}"])
            for end in ("frame_a", "frame_b")
        ]
        assert np.abs(into[0] + into[1]).max() < 1e-6 * max(1, np.abs(into[0]).max())
    for joint, here, there in made.joints:
        into = [
            power(result, f"{joint}.frame_a", motions[here]),
            power(result, f"{joint}.frame_b", motions[there]),
        ]
        assert np.abs(into[0] + into[1]).max() < 1e-5 * max(1, np.abs(into[0]).max()), joint
