"""Runs models of the magnetic library and reads their results."""

from __future__ import annotations

from typing import Any

import numpy as np

from acausal import compile_text

MU_0 = 1.25663706212e-6


def simulate(body: str, **options: Any) -> Any:
    """Simulate a model whose declarations and equations are given."""
    text = f"import magnetic.*;\nmodel Test\n{body}\nend Test;\n"
    return compile_text(text).simulate(
        **{"tolerance": 1e-9, "stop_time": 1, "points": 5, **options}
    )


def values(result: Any, path: str) -> Any:
    """Return the values of one variable."""
    return np.asarray(result[path].values)


def last(result: Any, path: str) -> float:
    """Return the last value of one variable."""
    return float(values(result, path)[-1])
