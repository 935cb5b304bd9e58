"""Texts of models for translation and rotation at once."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from acausal import compile_text

TRANSLATION = {
    "package": "mechanical.translational", "Mass": "Mass", "Force": "Force", "f": "f", "s": "s",
    "v": "v", "m": "m", "Position": "Position", "Lever": "Lever",
}  # fmt: skip
ROTATION = {
    "package": "mechanical.rotational", "Mass": "Inertia", "Force": "Torque", "f": "tau",
    "s": "phi", "v": "w", "m": "J", "Position": "Angle", "Lever": "IdealPlanetary",
}  # fmt: skip
BOTH = [TRANSLATION, ROTATION]


def simulate(text: str, names: dict[str, str], **options: Any) -> Any:
    """Simulate a model in which ``$name$`` stands for the name of the field."""
    text = re.sub(r"\$(\w+)\$", lambda match: names[match[1]], text)
    return compile_text(text).simulate(**{"tolerance": 1e-9, **options})


def values(result: Any, path: str) -> Any:
    """Return the values of one variable."""
    return np.asarray(result[path].values)
