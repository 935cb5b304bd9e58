"""The example on the page about planar mechanics does what the page says."""

from __future__ import annotations

import re

import numpy as np

from acausal import compile_text
from tests.library.planar.mechanisms import ROOT, values


def test_example_of_the_page() -> None:
    found = re.search(r"```modelica\n(.*?)```", (ROOT / "docs/planar.md").read_text(), re.DOTALL)
    assert found
    result = compile_text(found.group(1)).simulate(stop_time=1, tolerance=1e-9)
    assert np.ptp(values(result, "energy")) < 1e-7
    assert np.ptp(values(result, "link[5].phi")) > 1
