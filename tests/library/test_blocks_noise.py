"""Noise: distributions, seeds, instants; distortion."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import stats

from tests.library.blocks_runs import run, values

SEED = "  inner blocks.noise.GlobalSeed globalSeed({0});\n"


def numbers(block: str, arguments: str, seed: str = "") -> Any:
    """Return the numbers that a block draws in 4000 instants, looked at in the middle between."""
    result = run(
        SEED.format(seed) + f"  blocks.noise.{block} noise(samplePeriod = 1e-3, {arguments});",
        stop_time=4.0005,
        interval=5e-4,
    )
    times = np.asarray(result.times)
    middle = np.arange(4000) * 1e-3 + 5e-4
    return values(result, "noise.y")[np.searchsorted(times, middle - 1e-9)]


@pytest.mark.parametrize(
    ("block", "arguments", "distribution"),
    [
        ("UniformNoise", "y_min = -1, y_max = 3", stats.uniform(-1, 4)),
        ("NormalNoise", "mu = 2, sigma = 0.5", stats.norm(2, 0.5)),
        (
            "TruncatedNormalNoise",
            "y_min = -1, y_max = 2, mu = 0, sigma = 1.5",
            stats.truncnorm(-1 / 1.5, 2 / 1.5, 0, 1.5),
        ),
        ("BandLimitedWhiteNoise", "noisePower = 0.1", stats.norm(0, 10)),
    ],
)
def test_distributions(block: str, arguments: str, distribution: Any) -> None:
    drawn = numbers(block, arguments)
    assert stats.kstest(drawn, distribution.cdf).pvalue > 1e-3
    # one number says nothing about the next
    assert abs(np.corrcoef(drawn[1:], drawn[:-1])[0, 1]) < 0.05


def test_seeds() -> None:
    one = numbers("NormalNoise", "fixedLocalSeed = 1")
    assert np.array_equal(one, numbers("NormalNoise", "fixedLocalSeed = 1"))
    for other in (
        numbers("NormalNoise", "fixedLocalSeed = 2"),
        numbers("NormalNoise", "fixedLocalSeed = 1", "fixedSeed = 5"),
        numbers("NormalNoise", "fixedLocalSeed = 1, useGlobalSeed = false"),
    ):
        assert abs(np.corrcoef(one, other)[0, 1]) < 0.05
    assert np.all(numbers("NormalNoise", "y_off = 7, enableNoise = false") == 7)
    assert np.all(numbers("NormalNoise", "y_off = 7", "enableNoise = false") == 7)
    late = numbers("NormalNoise", "y_off = 7, startTime = 1")
    assert np.all(late[:1000] == 7)
    assert np.array_equal(late[1000:], one[:3000])


@pytest.mark.parametrize("first", ["true", "false"])
def test_distortion(first: str) -> None:
    result = run(
        f"""  blocks.TotalHarmonicDistortion thd(f = 10, useFirstHarmonic = {first});
equation
  thd.u = 4*sin(20*constants.pi*time) + 3*sin(60*constants.pi*time);
""",
        stop_time=0.45,
    )
    assert values(result, "thd.y")[-1] == pytest.approx(0.75 if first == "true" else 0.6, abs=1e-5)
    valid = values(result, "thd.valid") > 0.5
    times = np.asarray(result.times)
    assert not np.any(valid[times < 0.1 - 1e-9])
    assert np.all(valid[times > 0.1 + 1e-9])
