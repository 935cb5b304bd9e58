"""Running small models of bodies in space."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from acausal import compile_file, compile_text

Array = NDArray[np.float64]
ROOT = Path(__file__).parents[3]
G = 9.81


def run(
    text: str, stop_time: float = 1.0, world: str = "n = {0, 0, -1}, g = 9.81", **options: Any
) -> Any:
    """Return the result of a model with the given body."""
    options = {"tolerance": 1e-9, **options}
    head = f"  import mechanical.multibody.*;\n  inner World world({world});\n"
    result = compile_text(f"model Test\n{head}{text}\nend Test;\n").simulate(
        stop_time=stop_time, **options
    )
    assert result.ending.value == "complete", result.diagnostics
    return result


def run_example(name: str, model: str | None = None, **options: Any) -> Any:
    """Return the result of a model of an example file."""
    result = compile_file(ROOT / "examples" / f"{name}.acm", model=model).simulate(**options)
    assert result.ending.value == "complete", result.diagnostics
    return result


def values(result: Any, path: str) -> Array:
    """Return the values of a variable."""
    return np.asarray(result[path].values, np.float64)


def vector(result: Any, path: str) -> Array:
    """Return the values of a vector, shape ``(3, times)``."""
    return np.array([values(result, f"{path}[{k}]") for k in (1, 2, 3)])


def matrix(result: Any, path: str) -> Array:
    """Return the values of a 3 by 3 matrix, shape ``(3, 3, times)``."""
    return np.array([[values(result, f"{path}[{i},{k}]") for k in (1, 2, 3)] for i in (1, 2, 3)])


def solution(f: Any, start: list[float], times: Array) -> Array:
    """Return an independent solution of ``y' = f(t, y)`` at increasing times, a row each y."""
    wanted = np.unique(times)
    y: Array = solve_ivp(
        f, (wanted[0], wanted[-1]), start, "DOP853", wanted, rtol=1e-11, atol=1e-12
    ).y
    return y[:, np.searchsorted(wanted, times)]


def turn(axis: int, angle: float) -> Array:
    """Return the rotation matrix from a frame to the one turned about axis 1, 2 or 3."""
    c, s = np.cos(angle), np.sin(angle)
    k, j = axis % 3, (axis + 1) % 3
    result = np.eye(3)
    result[k, k], result[j, j], result[k, j], result[j, k] = c, c, s, -s
    return result


def energy(
    result: Any, body: str, m: float, r_cm: Any = (0, 0, 0), inertia: Any = 1e-3, g: float = G
) -> Array:
    """Return kinetic and potential energy of a body; gravity pulls along -z.

    Args:
        result: The run.
        body: Path of a ``Body``.
        m: Mass.
        r_cm: Centre of mass, seen from the body.
        inertia: Tensor of inertia about it: a number, three moments, or a matrix.
    """
    tensor = np.asarray(inertia, float)
    tensor = np.eye(3) * tensor if tensor.ndim == 0 else tensor
    tensor = np.diag(tensor) if tensor.ndim == 1 else tensor
    T = matrix(result, f"{body}.frame_a.R.T")
    w, offset = vector(result, f"{body}.w_a"), np.asarray(r_cm, float)
    v = vector(result, f"{body}.v_0") + np.einsum("jit,jt->it", T, np.cross(w.T, offset).T)
    height = vector(result, f"{body}.frame_a.r_0")[2] + np.einsum("jt,j->t", T[:, 2, :], offset)
    turning = np.einsum("it,ij,jt->t", w, tensor, w)
    return np.asarray(m * (v * v).sum(axis=0) / 2 + turning / 2 + m * g * height)
