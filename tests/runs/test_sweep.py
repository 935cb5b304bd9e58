"""Sweeps give what single runs give, wherever they run, and survive failures."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

from acausal import compile_text
from acausal.compiler import Compiled
from acausal.diagnostics import AcausalError
from acausal.runs.points import grid, sampled
from acausal.runs.sweep import simulate_many, sweep

DECAY = """
model Decay "first order"
  parameter Real a(unit = "1/s") = 2 "rate";
  parameter Real x0 = 1;
  parameter Integer n = 1;
  Real x(start = x0, fixed = true) "state", y[n];
equation
  der(x) = -a*x;
  for i in 1:n loop
    y[i] = sqrt(x)/i;
  end for;
  assert(a < 50, "too fast");
end Decay;
"""


@pytest.fixture(scope="module")
def decay() -> Compiled:
    return compile_text(DECAY)


def test_a_grid_in_order() -> None:
    assert grid({"a": [1, 2], "b": np.array([3.0, 4.0])}) == [
        {"a": 1, "b": 3}, {"a": 1, "b": 4}, {"a": 2, "b": 3}, {"a": 2, "b": 4}
    ]  # fmt: skip


@pytest.mark.parametrize("workers", [1, 2])
def test_every_point_is_its_closed_form(decay: Compiled, workers: int) -> None:
    rates = np.linspace(0.5, 5, 12)
    study = sweep(
        decay, {"a": rates, "start(x)": [1, 4]}, stop_time=1.0, tolerance=1e-8, workers=workers
    )
    assert len(study) == 24
    assert study.complete.all()
    starts = np.tile([1.0, 4.0], 12)
    exact = starts * np.exp(-np.repeat(rates, 2))
    assert study.final("x") == pytest.approx(exact, rel=1e-6)
    result = study[5]
    assert result is not None
    assert result["y[1]"].values == pytest.approx(np.sqrt(result["x"].values))
    assert result["x"].description == "state"


def test_failed_points_are_recorded(decay: Compiled) -> None:
    study = simulate_many(
        decay, [{"a": 1.0}, {"a": 100.0}, {"b": 1.0}, {"start(x)": 2.0}, {"a": "2[1/s]"}],
        stop_time=1.0, variables=["x"], workers=1,
    )  # fmt: skip
    assert study.complete.tolist() == [True, False, False, True, True]
    assert study.errors[2].code == "N119"
    assert set(study.errors) == {1, 2}
    assert np.isnan(study.final("x")[2])
    assert study[2] is None
    assert "2 failed" in repr(study)


def test_structural_parameters_are_compiled(decay: Compiled) -> None:
    study = sweep(decay, {"n": [1, 3], "a": [1.0, 2.0]}, stop_time=1.0, variables=["x", "y[1]"])
    assert study.final("x") == pytest.approx(np.exp([-1, -2, -1, -2]), rel=1e-5)


def test_samples_are_reproducible(decay: Compiled) -> None:
    points = sampled({"a": norm(2, 0.1), "x0": 3.0}, samples=50, seed=4)
    assert points == sampled({"a": norm(2, 0.1), "x0": 3.0}, samples=50, seed=4)
    assert points != sampled({"a": norm(2, 0.1), "x0": 3.0}, samples=50, seed=5)
    study = sweep(decay, {"a": norm(2, 0.1), "x0": 3.0}, samples=50, seed=4, stop_time=1.0,
                  tolerance=1e-8)  # fmt: skip
    exact = [3 * np.exp(-float(p["a"])) for p in points]
    assert study.final("x") == pytest.approx(exact, rel=1e-6)


def test_a_store_goes_on_where_it_stopped(decay: Compiled, tmp_path: Path) -> None:
    points = [{"a": float(k)} for k in range(1, 121)]
    seen: list[int] = []

    def stop_in_the_middle(done: int, total: int) -> None:
        if done == 70:
            raise KeyboardInterrupt

    options = {"stop_time": 1.0, "variables": ["x"], "workers": 1, "store": tmp_path / "s"}
    first = simulate_many(decay, points, progress=stop_in_the_middle, **options)
    assert first.interrupted
    assert sum(o is not None for o in first.outcomes) == 70
    second = simulate_many(decay, points, progress=lambda done, total: seen.append(done), **options)
    assert seen == list(range(71, 121))  # the others were not run again
    assert second.complete.sum() == 49  # the assertion of the model fails from 50 on
    assert set(second.errors) == set(range(49, 120))
    third = simulate_many(decay, points, **options)
    assert np.array_equal(third.final("x"), second.final("x"), equal_nan=True)
    whole = simulate_many(decay, points, stop_time=1.0, variables=["x"], workers=1)
    assert np.array_equal(whole.final("x"), second.final("x"), equal_nan=True)
    assert json.loads((tmp_path / "s" / "study.json").read_text())["model"] == "Decay"


def test_a_store_of_another_study_is_refused(decay: Compiled, tmp_path: Path) -> None:
    simulate_many(decay, [{"a": 1.0}], stop_time=1.0, store=tmp_path)
    for change in ({"stop_time": 2.0}, {"tolerance": 1e-3, "stop_time": 1.0}):
        with pytest.raises(AcausalError) as error:
            simulate_many(decay, [{"a": 1.0}], store=tmp_path, **change)
        assert error.value.diagnostics[0].code == "F140"


def test_tables_and_labelled_arrays(decay: Compiled) -> None:
    study = sweep(decay, {"a": [1.0, 2.0, 60.0]}, stop_time=1.0, points=11, variables=["x"])
    frame = study.to_pandas()
    assert frame["a"].tolist() == [1.0, 2.0, 60.0]
    assert frame["ending"].tolist() == ["complete", "complete", "failed"]
    data = study.to_xarray()
    assert data["x"].shape == (3, 11)
    assert data["x"].sel(time=1.0).values[:2] == pytest.approx(np.exp([-1, -2]), rel=1e-4)
    again = simulate_many(decay, frame[["a"]], stop_time=1.0, points=11, variables=["x"])
    assert np.array_equal(again.final("x"), study.final("x"), equal_nan=True)
    assert study.reduced("x", lambda t, x: x[0] - x[-1])[0] == pytest.approx(
        1 - np.exp(-1), rel=1e-4
    )


@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_on_a_cluster(decay: Compiled) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        study = sweep(
            decay, {"a": np.linspace(1, 2, 9)}, stop_time=1.0, tolerance=1e-8,
            scheduler=cluster.scheduler_address,
        )  # fmt: skip
    assert study.final("x") == pytest.approx(np.exp(-np.linspace(1, 2, 9)), rel=1e-6)


@pytest.mark.parametrize(
    ("call", "code"),
    [
        (lambda c: sweep(c, {"a": []}), "F141"),
        (lambda c: sweep(c, {"a": "x"}, samples=3), "F141"),
        (lambda c: sweep(c, {"a": norm(1, 1)}, samples=0), "F141"),
        (lambda c: simulate_many(c, [1, 2]), "F141"),
        (lambda c: simulate_many(c, [{"a": 1.0}], variables=["z"]), "N901"),
        (lambda c: simulate_many(c, [{"a": 1.0}], workers=0), "F141"),
        (lambda c: simulate_many(c, [{"a": 1.0}], stop_time=1.0).final("z"), "N901"),
    ],
)
def test_mistakes(decay: Compiled, call: object, code: str) -> None:
    with pytest.raises(AcausalError) as error:
        call(decay)  # type: ignore[operator]
    assert error.value.diagnostics[0].code == code
