"""S28: Hessenberg systems of index 1, 2 and 3 against their closed solutions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest


def test_index_1(simulate: Any) -> None:
    result = simulate("hessenberg", "Index1", stop_time=1, tolerance=1e-9)
    assert result["y"].values == pytest.approx(np.sin(result.times), abs=1e-7)
    assert result["z"].values == pytest.approx(np.cos(result.times), abs=1e-7)


def test_index_2(simulate: Any) -> None:
    result = simulate("hessenberg", "Index2", stop_time=10, tolerance=1e-9)
    t = result.times
    assert result["z"].values == pytest.approx((np.sin(t) + np.cos(t)) / 2, abs=1e-6)
    assert result["y1"].values == pytest.approx((np.sin(t) + np.exp(-t)) / 2, abs=1e-7)
    assert result["y2"].values == pytest.approx((np.sin(t) - np.exp(-t)) / 2, abs=1e-7)


def test_index_3(simulate: Any) -> None:
    result = simulate("hessenberg", "Index3", stop_time=10, tolerance=1e-9)
    t = result.times
    # an angle of 20 rad with two changes of states per turn
    assert result["x"].values == pytest.approx(np.cos(2 * t), abs=3e-6)
    assert result["y"].values == pytest.approx(np.sin(2 * t), abs=3e-6)
    assert result["z"].values == pytest.approx(4, abs=1e-5)
