"""Tables against interpolation by SciPy, and tables over time with their events."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import interpolate

from tests.library.blocks_runs import Array, after, run, values

X = np.array([0.0, 1.0, 1.5, 3.0, 4.0, 6.0])
Y = np.array([0.0, 2.0, 2.5, 2.5, -1.0, 0.5])
ROWS = "; ".join(f"{x}, {y}, {x}" for x, y in zip(X, Y, strict=True))


def akima(at: Array) -> Array:
    curve = interpolate.Akima1DInterpolator(X, Y)
    return np.asarray(curve(at))


def fritsch_butland(at: Array) -> Array:
    return np.asarray(interpolate.PchipInterpolator(X, Y)(at))


def modified_akima(at: Array) -> Array:
    return np.asarray(interpolate.Akima1DInterpolator(X, Y, method="makima")(at))


CURVES = [
    ("LinearSegments", lambda at: np.interp(at, X, Y)),
    ("ContinuousDerivative", akima),
    ("MonotoneContinuousDerivative1", fritsch_butland),
    ("ModifiedContinuousDerivative", modified_akima),
]


@pytest.mark.parametrize(("smoothness", "curve"), CURVES)
def test_interpolation(smoothness: str, curve: object) -> None:
    result = run(
        f"""
  blocks.CombiTable1Ds table(table = [{ROWS}], smoothness = blocks.Smoothness.{smoothness});
  blocks.CombiTable1Dv many(table = [{ROWS}], smoothness = blocks.Smoothness.{smoothness});
  blocks.CombiTimeTable over_time(table = [{ROWS}], smoothness = blocks.Smoothness.{smoothness});
equation
  table.u = time;
  many.u = {{time, 6 - time}};
""",
        stop_time=6,
    )
    t = np.asarray(result.times)
    expected = curve(t)  # type: ignore[operator]
    for path in ("table.y[1]", "many.y[1]", "over_time.y[1]"):
        assert values(result, path) == pytest.approx(expected, abs=1e-9), path
    assert values(result, "table.y[2]") == pytest.approx(t, abs=1e-9)
    assert values(result, "many.y[2]") == pytest.approx(6 - t, abs=1e-9)


def test_steffens_spline_does_not_overshoot() -> None:
    result = run(
        f"""
  blocks.CombiTable1Ds table(table = [{ROWS}],
    smoothness = blocks.Smoothness.MonotoneContinuousDerivative2);
equation
  table.u = time;
""",
        stop_time=6,
        points=601,
    )
    t, y = np.asarray(result.times), values(result, "table.y[1]")
    assert np.interp(X, t, y) == pytest.approx(Y, abs=1e-9)
    for k in range(len(X) - 1):
        inside = y[(t >= X[k]) & (t <= X[k + 1])]
        assert inside.min() >= min(Y[k : k + 2]) - 1e-9
        assert inside.max() <= max(Y[k : k + 2]) + 1e-9
    # the derivative has no jump
    slope = np.diff(y) / np.maximum(np.diff(t), 1e-12)
    assert np.abs(np.diff(slope[np.diff(t) > 1e-3])).max() < 0.3


def test_outside_of_a_table() -> None:
    result = run(
        f"""
  blocks.CombiTable1Ds last(table = [{ROWS}], smoothness = blocks.Smoothness.ContinuousDerivative);
  blocks.CombiTable1Ds line(table = [{ROWS}]);
  blocks.CombiTable1Ds hold(table = [{ROWS}], extrapolation = blocks.Extrapolation.HoldLastPoint);
  blocks.CombiTable1Ds again(table = [{ROWS}], extrapolation = blocks.Extrapolation.Periodic);
  blocks.CombiTable1Ds steps(table = [{ROWS}], smoothness = blocks.Smoothness.ConstantSegments);
  Real u = 3*time - 5;
equation
  last.u = u;
  line.u = u;
  hold.u = u;
  again.u = u;
  steps.u = u;
""",
        stop_time=6,
    )
    u = values(result, "u")
    inside = np.clip(u, 0, 6)
    linear = np.interp(inside, X, Y) + 2 * np.minimum(u, 0) + 0.75 * np.maximum(u - 6, 0)
    assert values(result, "line.y[1]") == pytest.approx(linear, abs=1e-9)
    assert values(result, "hold.y[1]") == pytest.approx(np.interp(u, X, Y), abs=1e-9)
    curve = interpolate.Akima1DInterpolator(X, Y)
    slope = curve.derivative()([0.0, 6.0])
    smooth = curve(inside) + slope[0] * np.minimum(u, 0) + slope[1] * np.maximum(u - 6, 0)
    assert values(result, "last.y[1]") == pytest.approx(smooth, abs=1e-9)
    away = np.abs((u + 1e-3) % 6) > 2e-3
    again = np.interp(u % 6, X, Y)
    assert values(result, "again.y[1]")[away] == pytest.approx(again[away], abs=1e-9)
    away = np.abs(u[:, None] - X).min(axis=1) > 1e-9
    steps = Y[np.clip(np.searchsorted(X, u, "right") - 1, 0, 5)]
    assert values(result, "steps.y[1]")[away] == pytest.approx(steps[away], abs=1e-12)


@pytest.mark.parametrize("extrapolation", ["LastTwoPoints", "HoldLastPoint"])
def test_two_dimensions(extrapolation: str) -> None:
    result = run(
        f"""
  parameter Real Z[3, 4] = [1, 2, 3, 0; 4, 4, 7, 1; 0, 1, 1, -2];
  blocks.CombiTable2Ds table(
    table = [0, 1, 2, 4, 5; 0, Z[1, 1], 2, 3, 0; 10, 4, 4, 7, 1; 30, 0, 1, 1, -2],
    extrapolation = blocks.Extrapolation.{extrapolation});
  Real u = 15 + 25*sin(2[1/s]*time);
  Real v = 3 + 3.5*cos(3.1[1/s]*time);
equation
  table.u1 = u;
  table.u2 = v;
""",
        stop_time=6,
        points=601,
    )
    x1, x2 = np.array([0.0, 10, 30]), np.array([1.0, 2, 4, 5])
    z = np.array([[1, 2, 3, 0], [4, 4, 7, 1], [0, 1, 1, -2]], float)
    u, v = values(result, "u"), values(result, "v")
    if extrapolation == "HoldLastPoint":
        u, v = np.clip(u, 0, 30), np.clip(v, 1, 5)
    surface = interpolate.RegularGridInterpolator(
        (x1, x2),
        z,
        bounds_error=False,
        fill_value=None,  # type: ignore[arg-type]
    )
    expected = surface(np.stack([u, v], axis=1))
    assert values(result, "table.y") == pytest.approx(expected, abs=1e-9)
    assert np.ptp(expected) > 5


def test_constant_cells() -> None:
    result = run(
        """
  blocks.CombiTable2Ds table(table = [0, 0, 1, 2; 0, 1, 2, 3; 1, 4, 5, 6; 2, 7, 8, 9],
    smoothness = blocks.Smoothness.ConstantSegments);
equation
  table.u1 = time;
  table.u2 = 2 - time;
""",
        stop_time=1.9,
        points=20,
    )
    t = np.asarray(result.times)
    expected = 1 + 3 * np.floor(t) + np.floor(2 - t)
    away = np.abs(t - 1) > 1e-6
    away[0] = False  # just at a point
    assert values(result, "table.y")[away] == pytest.approx(expected[away], abs=1e-12)


def test_time_table_with_jumps_is_integrated_exactly() -> None:
    # a step at 1, a ramp up to 2, a jump back at 2.5
    result = run(
        """
  blocks.CombiTimeTable table(table = [0, 1; 1, 1; 1, 3; 2, 4; 2.5, 4; 2.5, 0; 3, 0],
    extrapolation = blocks.Extrapolation.HoldLastPoint, offset = {10}, startTime = 0.5);
  blocks.TimeTable single(table = [0, 1; 1, 1; 1, 3; 2, 4; 2.5, 4; 2.5, 0; 3, 0]);
  Real x(start = 0, fixed = true);
equation
  der(x) = single.y;
""",
        stop_time=4,
    )
    assert values(result, "x")[-1] == pytest.approx(1 + 3.5 + 2, abs=1e-9)
    assert values(result, "table.y[1]")[0] == 10
    # shifted by the start time
    assert after(result, "table.y[1]", 1.5) == pytest.approx(13)
    assert after(result, "table.y[1]", 3.0) == pytest.approx(10)


def test_periodic_time_table() -> None:
    result = run(
        """
  blocks.CombiTimeTable saw(table = [0, 0; 0.3, 3], extrapolation = blocks.Extrapolation.Periodic);
  blocks.CombiTimeTable steps(table = [0, 1; 0.1, 2; 0.25, 5; 0.4, 5],
    extrapolation = blocks.Extrapolation.Periodic, smoothness = blocks.Smoothness.ConstantSegments);
  Real x(start = 0, fixed = true), z(start = 0, fixed = true);
equation
  der(x) = saw.y[1];
  der(z) = steps.y[1];
""",
        stop_time=12,
    )
    t = np.asarray(result.times)
    away = np.abs((t + 0.01) % 0.3 - 0.01) > 1e-9
    expected = 10 * (t % 0.3)
    assert values(result, "saw.y[1]")[away] == pytest.approx(expected[away], abs=1e-6)
    assert values(result, "x")[-1] == pytest.approx(40 * 0.45, abs=5e-5)
    assert values(result, "z")[-1] == pytest.approx(30 * (0.1 + 0.3 + 0.75), abs=1e-7)


def test_fastest_motion_ends_where_it_should() -> None:
    result = run(
        """
  blocks.KinematicPTP ptp(deltaq = {2, -1}, qd_max = {1, 1}, qdd_max = {2, 2}, startTime = 0.5);
  blocks.KinematicPTP short(deltaq = {0.125}, qd_max = {1}, qdd_max = {2});
  blocks.KinematicPTP2 positions(q_begin = {1}, q_end = {3, 0}, qd_max = {1, 1}, qdd_max = {2, 2},
    startTime = 0.5);
  blocks.Integrator speed[3], position[3];
equation
  connect(ptp.y, speed[1:2].u);
  connect(short.y[1], speed[3].u);
  connect(speed.y, position.u);
""",
        stop_time=4,
    )
    t = np.asarray(result.times)
    found = [values(result, f"position[{k}].y") for k in (1, 2, 3)]
    assert found[0][-1] == pytest.approx(2, abs=1e-8)
    assert found[1][-1] == pytest.approx(-1, abs=1e-8)
    assert found[2][-1] == pytest.approx(0.125, abs=1e-8)
    assert values(result, "speed[1].y").max() == pytest.approx(1, abs=1e-8)
    assert values(result, "speed[3].y").max() == pytest.approx(0.5, abs=1e-8)
    # speeding up takes 0.5 s, the whole motion 2.5 s, the short one 0.5 s
    assert np.interp(2.9, t, found[0]) < 2 - 1e-3
    assert np.interp(3.0, t, found[0]) == pytest.approx(2, abs=1e-8)
    assert np.interp(0.5, t, found[2]) == pytest.approx(0.125, abs=1e-8)
    assert values(result, "positions.q[1]") == pytest.approx(1 + found[0], abs=1e-7)
    assert values(result, "positions.q[2]") == pytest.approx(1 - found[0] / 2, abs=1e-7)
    assert values(result, "positions.qd[1]") == pytest.approx(
        values(result, "speed[1].y"), abs=1e-7
    )
    moving = (t > 0.5) & (t < 3)
    away = (np.abs(t - 0.5) > 1e-9) & (np.abs(t - 3) > 1e-9)
    assert (values(result, "positions.moving[1]")[away] == moving[away]).all()
