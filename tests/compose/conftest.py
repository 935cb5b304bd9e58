"""A model and its own text must be the same system."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest

import acausal as ac
from acausal.inspection.inspect import inspect


def _flat(compiled: ac.Compiled) -> str:
    """Return the flat equations, without the places they come from."""
    assert compiled.stages is not None
    return re.sub(r"[^ ]+:[0-9]+$", "", inspect(compiled.stages, "flatten"), flags=re.MULTILINE)


def _same(model: ac.Model, stop_time: float = 1.0) -> ac.Result:
    compiled = model.compile()
    again = ac.compile_text(model.to_acm(), model.name)
    assert _flat(compiled) == _flat(again)
    one = compiled.simulate(stop_time=stop_time, points=51)
    two = again.simulate(stop_time=stop_time, points=51)
    assert not one.diagnostics
    for name in one.find("*"):
        a, b = one[name].values, two[name].values
        assert np.allclose(a, b, rtol=1e-12, atol=1e-12), name
    return one


@pytest.fixture
def same() -> Callable[..., ac.Result]:
    return _same
