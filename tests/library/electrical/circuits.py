"""Runs circuits and reads their results."""

from __future__ import annotations

from typing import Any

import numpy as np

from acausal import compile_text


def run(body: str, stop_time: float = 1.0, **options: Any) -> Any:
    """Simulate a model whose declarations and equations are given."""
    options = {"tolerance": 1e-8, **options}
    text = f"model Test\n{body}\nend Test;\n"
    return compile_text(text).simulate(stop_time=stop_time, **options)


def values(result: Any, path: str) -> Any:
    """Return the values of one variable."""
    return np.asarray(result[path].values)
