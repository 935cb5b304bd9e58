"""Figures show themselves where nobody has asked for a backend."""

from __future__ import annotations

from acausal import compile_text
from acausal.results.plot import draw


def test_a_figure_is_a_picture() -> None:
    text = "model M Real x(start = 1, fixed = true); equation der(x) = -x; end M;"
    result = compile_text(text).simulate(stop_time=1.0)
    figure = draw(result, ("x",), "")
    assert figure._repr_png_().startswith(b"\x89PNG")
    assert figure._repr_png_() == figure._repr_png_()
