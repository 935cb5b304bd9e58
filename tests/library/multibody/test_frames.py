"""Orientations: rotation matrices, angles, quaternions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acausal import compile_text
from tests.library.multibody.bodies import matrix, turn, vector

SEQUENCES = [(i, j, k) for i in (1, 2, 3) for j in (1, 2, 3) for k in (1, 2, 3) if i != j != k]
angle = st.floats(-3.0, 3.0)


def evaluate(declarations: str) -> object:
    text = f"model Test\n  import mechanical.multibody.frames.*;\n{declarations}\nend Test;\n"
    return compile_text(text).simulate(stop_time=1, points=2)


def test_angles_of_rotations_in_all_sequences() -> None:
    wanted, lines = {}, []
    for n, sequence in enumerate(SEQUENCES):
        # the second angle is in -pi/2..pi/2, or in 0..pi if first and third axis are the same
        angles = (0.5, -0.8 if sequence[0] != sequence[2] else 0.8, 2.5)
        wanted[n] = angles
        axes = "{" + ", ".join(map(str, sequence)) + "}"
        given_angles = "{" + ", ".join(map(str, angles)) + "}"
        lines += [
            f"  Orientation R{n} = axesRotations({axes}, {given_angles}, {{0.1, 0.2, 0.3}});\n",
            f"  Real found{n}[3] = axesRotationsAngles(R{n}, {axes});\n",
            f"  Real main{n}[3] = rotationAngles(R{n}, {axes});\n",
            f"  Real far{n}[3] = axesRotationsAngles(R{n}, {axes}, 3.0);\n",
            f"  Orientation again{n} = axesRotations({axes}, far{n}, zeros(3));\n",
        ]
    result = evaluate("".join(lines))
    for n, angles in wanted.items():
        expected = np.eye(3)
        for axis, value in zip(SEQUENCES[n], angles, strict=True):
            expected = turn(axis, value) @ expected
        assert matrix(result, f"R{n}.T")[:, :, 0] == pytest.approx(expected, abs=1e-12)
        assert vector(result, f"found{n}")[:, 0] == pytest.approx(angles, abs=1e-12)
        assert vector(result, f"main{n}")[:, 0] == pytest.approx(angles, abs=1e-12)
        # the other solution begins opposite
        assert abs(vector(result, f"far{n}")[0, 0]) == pytest.approx(np.pi - 0.5, abs=1e-12)
        assert matrix(result, f"again{n}.T")[:, :, 0] == pytest.approx(expected, abs=1e-12)


def test_angular_velocity_is_the_derivative_of_the_matrix() -> None:
    result = evaluate(
        "  Real a[3] = {0.3 + time, 0.5 - 2*time, 1 + time^2};\n"
        "  Orientation R = axesRotations({3, 1, 2}, a, der(a));\n"
        "  Real rate[3, 3] = der(R.T);\n"
        "  Orientation Q = from_Q(to_Q(R), R.w);\n"
        "  Real b[4] = {0.1*time, 0.2, 0.3*time^2, 1};\n"
        "  Real q[4] = b/sqrt(b*b);\n"
        "  Orientation S = from_Q(q, quaternionAngularVelocity2(q, der(q)));\n"
        "  Real rate_S[3, 3] = der(S.T);\n"
    )
    for name, rate in (("R", "rate"), ("S", "rate_S")):
        T, w = matrix(result, f"{name}.T")[:, :, 1], vector(result, f"{name}.w")[:, 1]
        skew = np.cross(np.eye(3), w)
        assert matrix(result, rate)[:, :, 1] == pytest.approx(-skew @ T, abs=1e-9)
    assert matrix(result, "Q.T") == pytest.approx(matrix(result, "R.T"), abs=1e-8)


@settings(max_examples=4, deadline=None, derandomize=True, database=None)
@given(st.tuples(angle, angle, angle), st.tuples(angle, angle, angle))
def test_relations_between_two_orientations(a: tuple[float, ...], b: tuple[float, ...]) -> None:
    first = "{" + ", ".join(map(repr, a)) + "}"
    second = "{" + ", ".join(map(repr, b)) + "}"
    result = evaluate(
        f"  Orientation R1 = axesRotations({{1, 2, 3}}, {first}, {second});\n"
        f"  Orientation R2 = axesRotations({{3, 1, 3}}, {second}, {first});\n"
        "  Orientation R_rel = relativeRotation(R1, R2);\n"
        "  Orientation again = absoluteRotation(R1, R_rel);\n"
        "  Orientation none = absoluteRotation(R1, inverseRotation(R1));\n"
        "  Real residue[6] = orientationConstraint(R2);\n"
        "  Real error[3] = orientationError(R2, again);\n"
        "  Real equal[3] = Orientation.equalityConstraint(R1, R1);\n"
        "  Real u[3] = resolveRelative(resolve2(R1, {1, 2, 3}), R1, R2);\n"
        "  Real v[3] = u - resolve2(R2, {1, 2, 3});\n"
        "  Real D[3, 3] = resolveDyade2(R1, resolveDyade1(R1, [1, 2, 3; 2, 4, 5; 3, 5, 6]));\n"
        "  Orientation Q = from_Q(to_Q(R2), mechanical.multibody.frames.angularVelocity2(R2));\n"
        "  Real w[3] = angularVelocity1(R1) - resolve1(R1, R1.w);\n"
    )
    assert matrix(result, "again.T") == pytest.approx(matrix(result, "R2.T"), abs=1e-12)
    assert vector(result, "again.w") == pytest.approx(vector(result, "R2.w"), abs=1e-11)
    assert matrix(result, "none.T")[:, :, 0] == pytest.approx(np.eye(3), abs=1e-12)
    assert vector(result, "none.w") == pytest.approx(0, abs=1e-11)
    assert vector(result, "v") == pytest.approx(0, abs=1e-11)
    for name in ("error", "equal", "w"):
        assert vector(result, name) == pytest.approx(0, abs=1e-12)
    assert matrix(result, "D")[:, :, 0] == pytest.approx(
        np.array([[1, 2, 3], [2, 4, 5], [3, 5, 6]]), abs=1e-11
    )
    assert matrix(result, "Q.T") == pytest.approx(matrix(result, "R2.T"), abs=1e-12)
    first_T, second_T = matrix(result, "R1.T")[:, :, 0], matrix(result, "R2.T")[:, :, 0]
    assert matrix(result, "R_rel.T")[:, :, 0] == pytest.approx(second_T @ first_T.T, abs=1e-12)


def test_the_error_of_a_turn_tells_axis_and_angle() -> None:
    turns = [(axis, value) for axis in (1, 2, 3) for value in (0.3, -2.0, 3.1)]
    result = evaluate(
        "  Orientation R = axesRotations({1, 2, 3}, {0.4, 0.5, 0.6}, zeros(3));\n"
        + "".join(
            f"  Real error{n}[3] = orientationError("
            f"R, absoluteRotation(R, axisRotation({axis}, {value}, 0)));\n"
            for n, (axis, value) in enumerate(turns)
        )
    )
    for n, (axis, value) in enumerate(turns):
        expected = np.zeros(3)
        expected[axis - 1] = 2 * np.tan(value / 2)
        found = vector(result, f"error{n}")[:, 0]
        assert found == pytest.approx(expected, rel=1e-11, abs=1e-11)


def test_axes_from_two_directions() -> None:
    result = evaluate(
        "  Orientation R = from_nxy({1, 1, 0}, {0, 1, 1});\n"
        "  Orientation collinear = from_nxy({0, 0, 2}, {0, 0, 3});\n"
        "  Orientation zero = from_nxy({0, 0, 0}, {0, 1, 0});\n"
        "  Orientation same = from_T(R.T, {1, 2, 3});\n"
    )
    T = matrix(result, "R.T")[:, :, 0]
    x = np.array([1, 1, 0]) / np.sqrt(2)
    y = np.array([0, 1, 1]) - x * (x @ [0, 1, 1])
    assert T[0] == pytest.approx(x)
    assert T[1] == pytest.approx(y / np.linalg.norm(y))
    assert T[2] == pytest.approx(np.cross(T[0], T[1]))
    for name in ("collinear", "zero"):
        T = matrix(result, f"{name}.T")[:, :, 0]
        assert np.abs(T @ T.T - np.eye(3)).max() < 1e-12
        assert np.linalg.det(T) == pytest.approx(1)
    assert matrix(result, "collinear.T")[0, :, 0] == pytest.approx([0, 0, 1])
    assert vector(result, "same.w")[:, 0] == pytest.approx([1, 2, 3])
