"""Running small models of planar mechanics."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from acausal import compile_file, compile_text

Array = NDArray[np.float64]
ROOT = Path(__file__).parents[3]
G = 9.81


def body(
    name: str,
    mass: float,
    inertia: float,
    r: tuple[float, float] = (0, 0),
    v: tuple[float, float] = (0, 0),
    phi: float = 0,
    w: float = 0,
) -> str:
    """Return the declaration of a Body with all start values fixed."""
    return (
        f"  Body {name}(m = {mass}, I = {inertia}, "
        f"r(start = {{{r[0]}, {r[1]}}}, each fixed = true), "
        f"v(start = {{{v[0]}, {v[1]}}}, each fixed = true), phi(start = {phi}, fixed = true), "
        f"w(start = {w}, fixed = true));\n"
    )


def run(text: str, stop_time: float = 1.0, gravity: str = "{0, -9.81}", **options: Any) -> Any:
    """Return the result of a model with the given body."""
    options = {"tolerance": 1e-9, **options}
    head = f"  import mechanical.planar.*;\n  inner PlanarWorld world(g = {gravity});\n"
    compiled = compile_text(f"model Test\n{head}{text}\nend Test;\n")
    result = compiled.simulate(stop_time=stop_time, **options)
    assert result.ending.value == "complete", result.diagnostics
    return result


def run_example(name: str, model: str, parameters: Any = None, **options: Any) -> Any:
    """Return the result of a model of an example file."""
    path = ROOT / "examples" / f"{name}.acm"
    result = compile_file(path, model=model, parameters=parameters or {}).simulate(**options)
    assert result.ending.value == "complete", result.diagnostics
    return result


def values(result: Any, path: str) -> Array:
    """Return the values of a variable."""
    return np.asarray(result[path].values, np.float64)


def vector(result: Any, path: str, n: int = 2) -> Array:
    """Return the values of a vector, shape ``(n, times)``."""
    return np.array([values(result, f"{path}[{k + 1}]") for k in range(n)])


def reference(name: str) -> dict[str, Any]:
    """Return a reference of ``tests/data/classic``."""
    data: dict[str, Any] = json.loads((ROOT / "tests/data/classic" / f"{name}.json").read_text())
    return data


def solution(f: Any, start: list[float], times: Array) -> Array:
    """Return an independent solution of ``y' = f(t, y)`` at increasing times, a row each y."""
    wanted = np.unique(times)
    y: Array = solve_ivp(
        f, (wanted[0], wanted[-1]), start, "DOP853", wanted, rtol=1e-11, atol=1e-12
    ).y
    return y[:, np.searchsorted(wanted, times)]


def body_energy(result: Any, body: str, mass: float, inertia: float) -> Array:
    """Return the kinetic and potential energy of a Body."""
    kinetic = mass * (vector(result, f"{body}.v") ** 2).sum(axis=0) / 2
    kinetic += inertia * values(result, f"{body}.w") ** 2 / 2
    energy: Array = kinetic + mass * G * values(result, f"{body}.r[2]")
    return energy
