"""The example on the page about friction does what the page says."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from acausal import compile_text

PAGE = Path(__file__).parents[2] / "docs" / "friction.md"


def test_example_of_the_page() -> None:
    found = re.search(r"```modelica\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert found
    result = compile_text(found.group(1)).simulate(stop_time=6, tolerance=1e-8)
    for body in ("engine", "wheel"):
        assert result[f"{body}.w"].values[-1] == pytest.approx(25, abs=1e-9)
    modes = np.asarray(result["clutch.mode"].values)
    assert list(dict.fromkeys(modes.tolist())) == [2.0, -1.0, 0.0]
    assert set(np.asarray(result["clutch.w_rel"].values)[modes == 0]) == {0.0}
