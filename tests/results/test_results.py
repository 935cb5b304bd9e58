"""Results: selection, interpolation, files and plots."""

from __future__ import annotations

import csv
import math
import os
import subprocess
import sys
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from acausal.diagnostics import AcausalError
from acausal.results import Ending, Event, Result, Trajectory, read_result
from acausal.results.files import whole_file
from acausal.results.patterns import matching
from acausal.results.plot import default_paths, draw, pretty_unit
from acausal.results.table import TableSource

TIMES = np.linspace(0.0, 1.0, 11)
FORMATS = ["run.csv", "run.nc", "run.h5", "run.parquet"]


@pytest.fixture
def result() -> Result:
    columns = {
        "c.v": np.sin(TIMES),
        "l.i": np.cos(TIMES) / 3,
        "link[1].angle": TIMES * 1,
        "link[2].angle": TIMES * 2,
        "link[2].part[1,3].x": TIMES * 1e-300,
    }
    units = {"c.v": "V", "l.i": "A", "link[1].angle": "rad", "link[2].angle": "rad"}
    return Result(
        model_name="RLC",
        description='series "resonant", circuit\nsecond line',
        times=TIMES,
        variables=TableSource(columns, units, {"c.v": "voltage, across the capacitor"}),
        states=("c.v", "l.i"),
        parameters={"r.R": 100.0},
        events=(Event(0.5, "switch closes"),),
        statistics={"steps": 42},
        experiment={"stop_time": 1.0, "solver": "ida"},
    )


def code(error: pytest.ExceptionInfo[AcausalError]) -> str:
    return error.value.diagnostics[0].code


def test_a_trajectory_is_an_array_and_a_function(result):
    voltage = result["c.v"]
    assert (voltage.unit, voltage.description) == ("V", "voltage, across the capacitor")
    np.testing.assert_array_equal(np.asarray(voltage), np.sin(TIMES))
    assert np.max(voltage) == math.sin(1.0)
    assert voltage[-1] == math.sin(1.0)
    assert len(voltage[:3]) == 3
    assert voltage(0.1) == math.sin(0.1)
    assert voltage(0.05) == pytest.approx(math.sin(0.1) / 2)
    np.testing.assert_allclose(voltage([0.0, 1.0]), np.sin([0.0, 1.0]))
    assert "c.v [V]" in repr(voltage)


def test_an_event_gives_the_value_after_it():
    jump = Trajectory("x", np.array([0.0, 1.0, 1.0, 2.0]), np.array([0.0, 1.0, 5.0, 5.0]))
    assert jump(0.5) == 0.5
    assert jump(1.0) == 5.0
    assert jump(1.5) == 5.0
    end = Trajectory("x", np.array([0.0, 1.0, 1.0]), np.array([0.0, 1.0, 5.0]))
    assert end(1.0) == 5.0


@pytest.mark.parametrize("time", [-0.1, 1.1, math.nan])
def test_outside_the_interval_is_refused(result, time):
    with pytest.raises(AcausalError) as error:
        result["c.v"](time)
    assert code(error) == "F211"


def test_wildcards(result):
    assert list(result["link[*].angle"]) == ["link[1].angle", "link[2].angle"]
    assert list(result["link.angle"]) == ["link[1].angle", "link[2].angle"]
    assert list(result["link[2].*"]) == ["link[2].angle", "link[2].part[1,3].x"]
    assert result.matrix("link[*].angle").shape == (11, 2)
    assert result.find("l.i", "*", "l.i")[0] == "l.i"
    assert len(result.find("l.i", "*")) == 5
    np.testing.assert_array_equal(result.matrix("c.v", "time", "l.i")[:, 1], TIMES)
    np.testing.assert_array_equal(result["time"].values, TIMES)
    assert "c.v" in result
    assert "time" in result
    assert "nothing" not in result


@pytest.mark.parametrize("path", ["c.w", "nothing[*]"])
def test_unknown_names(result, path):
    with pytest.raises(AcausalError) as error:
        result[path]
    assert code(error) == "N901"
    if path == "c.w":
        assert "did you mean c.v?" in error.value.diagnostics[0].notes


@pytest.mark.parametrize(
    ("pattern", "path", "match"),
    [
        ("a.*", "a.b.c", True),
        ("a[*].b", "a[1,2].b", True),
        ("a[*].b", "a[1].c[2].b", False),
        ("*.v", "a.v", True),
        ("*.v", "a.b.v", False),
        ("*", "a.b[1].c", True),
        ("*", "der(a.b)", True),
        ("a*.v", "ab[3].v", True),
        ("a?.v", "ab.v", True),
        ("a?.v", "abc.v", False),
        ("a.b", "axb", False),
        ("a.b", "a[3].b", True),
        ("a[1].b", "a[12].b", False),
        ("a[2:10].b", "a[10].b", True),
        ("a[2:10].b", "a[1].b", False),
        ("a[2:10].b", "a[100].b", False),
        ("a[2].b", "a[2,3].b", True),
        ("a[*,3].b", "a[2,3].b", True),
        ("a[*,3].b", "a[3,2].b", False),
        ("der(a.*)", "der(a.b)", True),
        ("der(a.*)", "a.b", False),
        ("a.*", "ab.c", False),
        ("a..b", "a.b", False),
        ("a.", "a.", False),
        ("", "", False),
        ("[*]", "a", False),
    ],
)
def test_patterns(pattern, path, match):
    assert (matching(pattern, [path]) == [path]) is match


@given(st.text("ab.[]*1", max_size=30), st.lists(st.text("ab.[]1", max_size=12), max_size=5))
def test_any_pattern_is_harmless(pattern, paths):
    assert set(matching(pattern, paths)) <= set(paths)


@pytest.mark.parametrize("name", FORMATS)
def test_files_read_back_exactly(result, tmp_path, name):
    result.write(tmp_path / name)
    back = read_result(tmp_path / name)
    np.testing.assert_array_equal(back.times, result.times)
    assert list(back.variables.paths()) == list(result.variables.paths())
    for path in result.variables.paths():
        np.testing.assert_array_equal(back[path].values, result[path].values)
        assert back[path].unit == result[path].unit
        assert back[path].description == result[path].description
    assert back.model_name == "RLC"
    assert back.description.split() == result.description.split()
    assert back.parameters == {"r.R": 100.0}
    assert back.events == (Event(0.5, "switch closes"),)
    assert back.statistics == {"steps": 42}
    assert back.experiment == {"stop_time": 1.0, "solver": "ida"}
    assert back.states == ("c.v", "l.i")
    assert back.ending is Ending.COMPLETE
    assert os.listdir(tmp_path) == [name]


@pytest.mark.parametrize("name", FORMATS)
def test_selection_is_written(result, tmp_path, name):
    result.write(tmp_path / name, "link[*].angle", "time")
    assert list(read_result(tmp_path / name).variables.paths()) == [
        "link[1].angle",
        "link[2].angle",
    ]


def test_other_programs_read_the_files(result, tmp_path):
    import pandas
    import xarray

    result.write(tmp_path / "run.csv")
    frame = pandas.read_csv(tmp_path / "run.csv", comment="#")
    assert list(frame.columns)[:2] == ["time", "c.v"]
    assert frame["link[2].part[1,3].x"].iloc[-1] == 1e-300
    result.write(tmp_path / "run.nc")
    with xarray.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as data:
        assert data["c.v"].attrs["units"] == "V"
        assert data["c.v"].dims == ("time",)
        assert float(data["c.v"].sel(time=1.0)) == math.sin(1.0)
        angles = data["link[*].angle"]
        assert angles.sizes["time"] == 11
        second = angles.sel({"paths of link[*].angle": "link[2].angle"})
        np.testing.assert_array_equal(second, TIMES * 2)
    result.write(tmp_path / "run.parquet")
    assert pandas.read_parquet(tmp_path / "run.parquet")["l.i"].iloc[0] == 1 / 3


def test_tables_of_other_programs_are_read(tmp_path):
    (tmp_path / "a.csv").write_text('time,"x[1,2]"\n0,1\n2,3\n', encoding="utf-8")
    assert read_result(tmp_path / "a.csv")["x[1,2]"](1.0) == 2.0
    (tmp_path / "b.csv").write_text("time,x\n", encoding="utf-8")
    assert len(read_result(tmp_path / "b.csv")["x"]) == 0


def test_frames(result):
    frame = result.to_pandas("c.*")
    assert frame.index.name == "time"
    assert frame.attrs["units"] == {"c.v": "V"}
    assert frame["c.v"].iloc[-1] == math.sin(1.0)
    data = result.to_xarray()
    assert data["l.i"].attrs["units"] == "A"
    assert data["link[*].angle"].shape == (11, 2)


@pytest.mark.parametrize("name", ["run", "run.xlsx", "run.csv.bak"])
def test_unknown_suffix(result, tmp_path, name):
    for action in (result.write, read_result):
        with pytest.raises(AcausalError) as error:
            action(tmp_path / name)
        assert code(error) == "F201"
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("suffix", ["csv", "nc", "parquet", "png"])
def test_missing_folder_and_folder_instead_of_file(result, tmp_path, suffix):
    (tmp_path / f"folder.{suffix}").mkdir()
    for target in (tmp_path / "none" / f"run.{suffix}", tmp_path / f"folder.{suffix}"):
        with pytest.raises(AcausalError) as error:
            result.plot(file=target) if suffix == "png" else result.write(target)
        assert code(error) == "F202"
        assert error.value.diagnostics[0].help
    assert os.listdir(tmp_path) == [f"folder.{suffix}"]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
def test_full_disk(result, tmp_path):
    os.symlink("/dev/full", tmp_path / "run.csv")
    with pytest.raises(AcausalError) as error:
        result.write(tmp_path / "run.csv")
    assert code(error) == "F203"


def interrupted_write(path):
    with whole_file(path) as unfinished:
        unfinished.write_text("half", encoding="utf-8")
        raise KeyboardInterrupt


def test_a_failed_write_leaves_the_old_file(tmp_path):
    (tmp_path / "run.csv").write_text("old", encoding="utf-8")
    with pytest.raises(KeyboardInterrupt):
        interrupted_write(tmp_path / "run.csv")
    assert (tmp_path / "run.csv").read_text(encoding="utf-8") == "old"
    assert os.listdir(tmp_path) == ["run.csv"]


@pytest.mark.parametrize("name", FORMATS)
def test_noise_and_absence_are_told(tmp_path, name):
    with pytest.raises(AcausalError) as error:
        read_result(tmp_path / name)
    assert code(error) == "F204"
    (tmp_path / name).write_bytes(bytes(range(256)) * 40)
    with pytest.raises(AcausalError) as error:
        read_result(tmp_path / name)
    assert code(error) == "F204"
    (tmp_path / name).write_bytes(b"a,b\n1,2\n")
    with pytest.raises(AcausalError) as error:
        read_result(tmp_path / name)
    assert code(error) == "F204"


def test_plot_groups_by_unit(result):
    figure = draw(result, ["*"])
    axes = figure.get_axes()
    assert [len(ax.get_lines()) for ax in axes] == [1, 1, 2, 1]
    assert [ax.get_ylabel() for ax in axes] == [
        "c.v [V]",
        "l.i [A]",
        "[rad]",
        "link[2].part[1,3].x",
    ]
    assert axes[-1].get_xlabel() == "time [s]"
    assert [t.get_text() for t in axes[2].get_legend().get_texts()] == [
        "link[1].angle",
        "link[2].angle",
    ]
    assert "RLC" in figure.get_suptitle()
    np.testing.assert_array_equal(axes[0].get_lines()[0].get_ydata(), np.sin(TIMES))


def test_plot_shows_states_first(result):
    assert default_paths(result) == ["c.v", "l.i"]


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_plots_are_written_and_deterministic(result, tmp_path, suffix):
    for name in ("a", "b"):
        result.plot("c.v", file=tmp_path / f"{name}.{suffix}")
    first = (tmp_path / f"a.{suffix}").read_bytes()
    assert len(first) > 1000
    assert first == (tmp_path / f"b.{suffix}").read_bytes()


def test_empty_results_are_drawn_and_written(tmp_path):
    empty = Result("M", "", np.empty(0), TableSource({}), ending=Ending.FAILED)
    empty.plot(file=tmp_path / "run.png")
    for name in FORMATS:
        empty.write(tmp_path / name)
        assert read_result(tmp_path / name).ending is Ending.FAILED


@pytest.mark.parametrize(
    ("unit", "text"), [("kg.m2/s", "kg·m²/s"), ("1/s", "1/s"), ("kOhm", "kOhm"), ("Ohm", "Ω")]
)
def test_pretty_unit(unit, text):
    assert pretty_unit(unit) == text


class Counting:
    """A million variables that must not be named unless asked for."""

    def __init__(self) -> None:
        self.named = 0

    def paths(self) -> Sequence[str]:
        raise AssertionError("all names were built")

    def find(self, pattern: str) -> list[str]:
        return [f"x[{i}]" for i in range(3)] if "*" in pattern else [pattern]

    def values(self, path: str):
        self.named += 1
        return TIMES

    def many(self, paths: Sequence[str]):
        return np.column_stack([self.values(path) for path in paths])

    def unit(self, path: str) -> str:
        return "m"

    def description(self, path: str) -> str:
        return ""

    def suggestions(self, path: str) -> list[str]:
        return []


def test_large_results_name_only_what_is_asked(tmp_path):
    source = Counting()
    result = Result("Large", "", TIMES, source, states=("x[1]",))
    repr(result)
    result["x[7]"]
    assert source.named == 1
    result["x[*]"]
    result.write(tmp_path / "run.csv", "x[*]")
    result.plot(file=tmp_path / "run.png")
    assert "x[9]" in result


def test_a_small_csv_needs_no_large_package(tmp_path):
    program = (
        "import sys, numpy as np\n"
        "from acausal.results import Result\n"
        "from acausal.results.table import TableSource\n"
        "r = Result('m', '', np.zeros(2), TableSource({'x': np.zeros(2)}))\n"
        "r.write(sys.argv[1])\n"
        "print([m for m in ('pandas', 'xarray', 'matplotlib', 'scipy') if m in sys.modules])"
    )
    target = tmp_path / "run.csv"
    run = subprocess.run(
        [sys.executable, "-c", program, str(target)], capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == "[]"
    with target.open(encoding="utf-8") as file:
        rows = [row for row in csv.reader(file) if not row[0].startswith("#")]
    assert rows == [["time", "x"], ["0.0", "0.0"], ["0.0", "0.0"]]
