"""Running the examples of the project."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from acausal import compile_file

EXAMPLES = Path(__file__).parents[2] / "examples"

Simulate = Callable[..., Any]


@pytest.fixture
def simulate() -> Simulate:
    """Simulate one model of one example file and return the result."""

    def run(
        file: str,
        model: str | None = None,
        parameters: dict[str, Any] | None = None,
        **options: Any,
    ) -> Any:
        compiled = compile_file(EXAMPLES / f"{file}.acm", model=model, parameters=parameters or {})
        return compiled.simulate(**options)

    return run
