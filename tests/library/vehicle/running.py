"""Running models of vehicles in tests."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from acausal import compile_text

HEAD = """import vehicle.*;
import mechanical.translational.{Mass, Position, Fixed};
model Mover
  parameter Real heading = 0, vx = 20, vy = 0;
  Real sweep;
  mechanical.planar.Frame_b hub(x(start = 0, fixed = true), y(start = 0, fixed = true));
equation
  hub.phi = heading;
  der(hub.x) = cos(heading)*vx - sin(heading)*vy*sweep;
  der(hub.y) = sin(heading)*vx + cos(heading)*vy*sweep;
end Mover;
"""
DATA = Path(__file__).parents[2] / "data" / "classic"


def simulate(body: str, parameters: dict[str, Any] | None = None, **options: Any) -> Any:
    """Simulate ``model M`` with this body."""
    text = f"{HEAD}model M\n{body}end M;\n"
    compiled = compile_text(text, model="M", parameters=parameters or {})
    return compiled.simulate(**{"tolerance": 1e-8, **options})


def values(result: Any, path: str) -> Any:
    """Return the values of one variable."""
    return np.asarray(result[path].values)


def magic_formula(x: Any, b: float, c: float, d: float, e: float) -> Any:
    """Return the force of the Magic Formula."""
    return d * np.sin(c * np.arctan(b * x - e * (b * x - np.arctan(b * x))))
